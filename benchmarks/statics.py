"""Forward, inverse and one span, beside general solvers on the same equations."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import root

from benchmarks.timing import Row, best, installed, medians
from cablewright.kernels import batches, jit, layout
from cablewright.kernels.layout import Packed
from cablewright.kernels.statics.equilibrium import evaluate, workspace
from cablewright.kernels.statics.line.upright import guess, settle
from cablewright.models.fidelity import Fidelity, SheaveLaw
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import load
from cablewright.solvers.continuation import Tracker, TrackerSettings
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.row_threads import run

Array = NDArray[np.float64]
BATCH = 100  # poses
PLAIN = TrackerSettings(certify=False)


@dataclass(frozen=True)
class Size:
    """How much is measured."""

    poses: int = 3000  # whole batches
    beside: int = 200  # of them that SciPy solves too
    spans: int = 200


MOUNT = 2e-6  # m/N
FULL, QUICK = Size(), Size(BATCH, 2, 5)


def rows(size: Size) -> Iterator[Row]:
    """All rows of this file."""
    model = Model(load("paty2021"), tension_limits=(20.0, 5150.0))  # its own limits exclude most of its frame
    held = some_poses(model, size.poses)
    yield from forward_rows(model, held, size.beside)
    yield from inverse_rows(model, held)
    yield mounts_row(model, size.poses)
    yield from span_rows(size.spans)


def some_poses(model: Model, count: int) -> Equilibrium:
    """Random poses over the frame that the model can hold."""
    rng = np.random.default_rng(20210603)
    low, high = np.array(model.robot.scene.frame_min), np.array(model.robot.scene.frame_max)
    found = solve_inverse(model, rng.uniform(low, high, (3 * count, 3)))
    return found[np.flatnonzero(found.ok)[:count]]


def forward_rows(model: Model, held: Equilibrium, beside: int) -> Iterator[Row]:
    """Warm, cold, single, in batches; and beside scipy's root with the same Jacobian."""
    rng, count = np.random.default_rng(1), len(held.lengths)
    lengths = held.lengths + 1e-3 * rng.standard_normal(held.lengths.shape)
    serial = solver(model, lengths, held, batches.WARM, parallel=False)
    warm = medians([lambda i=i: serial(slice(i, i + BATCH)) for i in range(0, count, BATCH)], 5)
    per_solve = float(np.median(warm)) / BATCH
    yield Row("forward, warm (lengths off by 1 mm), in a batch", per_solve * 1e6, "us", "<= 10", per_solve <= 10e-6)

    tracker = Tracker(model, held.lengths[0], PLAIN)
    steps = [held.lengths[0], held.lengths[0] + 1e-3]
    calls = [lambda: tracker.step(steps[0]), lambda: tracker.step(steps[1])]
    one = max(medians(calls, 2000))
    yield Row("forward, warm, as one Python call", one * 1e6, "us", "<= 20", one <= 20e-6)

    many = np.tile(np.arange(count), 20)
    batch = solver(model, lengths[many], held[many], batches.WARM, parallel=True)
    rate = len(many) / best(lambda: batch(slice(None)))
    yield Row("forward, warm, batch on all cores", rate, "solves/s", ">= 150000", rate >= 150e3)

    cold = solver(model, held.lengths, held, batches.COLD, parallel=False)
    times = medians([lambda i=i: cold(slice(i, i + 1)) for i in range(count)], 3)  # type: ignore[misc]
    found = solve_forward(model, held.lengths)
    right = float((np.linalg.norm(found.pose - held.pose, axis=1) < 1e-9).mean())
    yield Row("forward, cold: right pose", 100 * right, "%", "= 100", right == 1.0)
    single = float(np.median(times))
    yield Row("forward, cold, median of single solves", single * 1e6, "us", "<= 40", single <= 40e-6)
    yield scipy_row(model, held[:beside], lengths[:beside], per_solve)


def mounts_row(stiff: Model, poses: int) -> Row:
    """Warm forward solves with mounts that deflect by 2 mm under 1 kN, over those with stiff ones."""
    lines = tuple(line.model_copy(update={"exit_compliance": MOUNT}) for line in stiff.robot.lines)
    models = stiff, Model(stiff.robot.model_copy(update={"lines": lines}), tension_limits=stiff.tension_limits)
    solvers = []
    for model in models:
        held = some_poses(model, poses)
        lengths = held.lengths + 1e-3 * np.random.default_rng(1).standard_normal(held.lengths.shape)
        solvers.append(solver(model, lengths, held, batches.WARM, parallel=False))
    times = medians(
        [lambda i=i, each=each: each(slice(i, i + BATCH)) for i in range(0, poses, BATCH) for each in solvers], 5
    )
    stiffly, softly = np.median(np.reshape(times, (-1, 2)), axis=0)
    return Row(
        "forward, warm, with mounts that give", float(softly / stiffly), "x stiff", "<= 1.5", softly <= 1.5 * stiffly
    )


def solver(model: Model, lengths: Array, held: Equilibrium, start: int, *, parallel: bool) -> Callable[[slice], None]:
    """A function that solves rows of a batch of forward problems again each time, from *held* where it is warm."""
    count = len(lengths)
    poses, states = held.pose.copy(), held.states.copy()
    codes, iterations, residuals = np.zeros(count, np.int64), np.zeros(count, np.int64), np.zeros(count)
    arrays = (lengths, poses, states, codes, iterations, residuals)
    packed = model.rows()

    def solve(which: slice) -> None:
        poses[which], states[which] = held.pose[which], held.states[which]
        if parallel:
            run(batches.forward_rows, count, packed, *arrays, start)
        else:
            first, last, _ = which.indices(count)
            batches.forward_rows(packed, *arrays, start, first, last)

    return solve


@jit(allocates=True)
def full_system(packed, lengths, x, work, residual, jacobian):
    """All 3 + 6 m equations and their Jacobian in the pose and the lines' unknowns: what a general solver is given."""
    m = packed.lines.shape[0]
    states = x[3:].reshape((m, 6))
    evaluate(packed, lengths, x[:3], states, work)
    jacobian[:, :] = 0.0
    for k in range(3):
        residual[k] = work.trial[k]
    for i in range(m):
        at = 3 + 6 * i
        ex, ey = work.planes[i, 0], work.planes[i, 1]
        h, v = work.forces[i]
        for k in range(6):
            residual[at + k] = work.steps[i, k, 0]
            for j in range(6):
                jacobian[at + k, at + j] = work.blocks[i, k, j]
        jacobian[at, 0], jacobian[at, 1], jacobian[at + 1, 2] = -ex, -ey, -1.0
        for j, dh, dv in ((layout.PHI, -v, h), (layout.TAU, h, v), (layout.FREE, 0.0, packed.lines[i, layout.WEIGHT])):
            jacobian[0, at + j], jacobian[1, at + j], jacobian[2, at + j] = -ex * dh, -ey * dh, -dv
        across = h / work.planes[i, 2]
        jacobian[0, 0] -= ey * ey * across
        jacobian[0, 1] += ex * ey * across
        jacobian[1, 0] += ex * ey * across
        jacobian[1, 1] -= ex * ex * across


def scipy_row(model: Model, held: Equilibrium, lengths: Array, ours: float) -> Row:
    """The same 27 equations with the same Jacobian and start in scipy.optimize.root."""
    packed: Packed = model.packed
    work = workspace(packed)
    size = 3 + 6 * model.m
    residual, jacobian = np.zeros(size), np.zeros((size, size))

    def function(x: Array, length: Array) -> tuple[Array, Array]:
        full_system(packed, length, x, work, residual, jacobian)
        return residual.copy(), jacobian.copy()

    def solve(i: int) -> Array:
        start = np.concatenate([held.pose[i], held.states[i].ravel()])
        return np.asarray(root(function, start, args=(lengths[i],), jac=True, method="hybr", tol=1e-13).x[:3])

    some = range(len(lengths))
    exact = solve_forward(model, lengths, guess=held.pose).pose
    agree = float((np.linalg.norm([solve(i) for i in some] - exact, axis=1) < 1e-6).mean())
    theirs = float(np.median(medians([lambda i=i: solve(i) for i in some], 3)))  # type: ignore[misc]
    name = f"  scipy.optimize.root, same Jacobian ({100 * agree:.0f} % agree)"
    return Row(name, theirs * 1e6, "us", peer="ours", ratio=theirs / ours)


def inverse_rows(model: Model, held: Equilibrium) -> Iterator[Row]:
    """Least-norm tensions under limits, all physics."""
    poses, packed, count = held.pose, model.rows(), len(held.pose)
    arrays = (np.zeros_like(held.states), np.zeros_like(held.lengths), np.zeros(count, np.int64), np.zeros(count))
    one = best(lambda: batches.inverse_rows(packed, poses, *arrays, False, 0, count)) / count
    yield Row("inverse, in a batch, one thread", one * 1e6, "us")
    path = np.linspace([-3.0, -2.0, 1.0], [3.0, 2.0, 1.5], count)
    follow = best(lambda: batches.inverse_rows(packed, path, *arrays, True, 0, count)) / count
    yield Row("inverse, along a path, one thread", follow * 1e6, "us")
    everywhere = np.tile(poses, (10, 1))
    rate = len(everywhere) / best(lambda: solve_inverse(model, everywhere))
    yield Row("inverse, batch on all cores", rate, "solves/s")


@jit(allocates=True)
def spans(row, ends, lengths, states, begin, cold, repeats):
    """Settle one span after the other; cold ones are guessed first. Returns how many settled."""
    block, rhs = np.zeros((6, 6)), np.zeros((6, 3))
    settled = 0
    for _ in range(repeats):
        for i in range(len(lengths)):
            states[i] = begin[i]
            if cold:
                guess(row, ends[i, 0], ends[i, 1], lengths[i], 100.0, states[i])
            if settle(row, ends[i, 0], ends[i, 1], lengths[i], states[i], block, rhs):
                settled += 1
    return settled


def span_rows(count: int) -> Iterator[Row]:
    """Hanging spans between fixed ends."""
    model = Model(load("merlet2023"), Fidelity(sheave=SheaveLaw.EYELET))
    row = model.packed.lines[0].copy()
    row[layout.UNKNOWNS] = 3  # the free span alone
    rng = np.random.default_rng(2)
    ends = np.column_stack([rng.uniform(2, 9, count), rng.uniform(-4, -0.5, count)])
    lengths = np.linalg.norm(ends, axis=1) * (1 + 10 ** rng.uniform(-4, -1, count))  # nearly taut to quite slack
    states = np.zeros((count, 6))
    assert spans(row, ends, lengths, states, states.copy(), True, 1) == count
    near = states.copy()
    near[:, :2] *= 1.001  # as the neighbour on a path would be

    def time_of(cold: bool) -> float:
        found = states.copy()
        return best(lambda: spans(row, ends, lengths, found, near, cold, 100)) / (100 * count)

    if installed("moorpy"):
        yield from moorpy_rows(row, ends, lengths, states, time_of(False), time_of(True))
    else:
        yield Row("one span, warm, in a batch", time_of(False) * 1e6, "us")
        yield Row("one span, cold, in a batch", time_of(True) * 1e6, "us")


def moorpy_rows(row: Array, ends: Array, lengths: Array, states: Array, warm: float, cold: float) -> Iterator[Row]:
    """Our times of a span, s, against MoorPy's `catenary`: same spans, same tolerance on the ends."""
    from moorpy.Catenary import catenary

    stiffness, weight, all_spans = 1 / row[layout.FREE_COMPLIANCE], row[layout.WEIGHT], range(len(ends))
    tension = np.exp(states[:, layout.TAU])
    horizontal, upper = tension * np.cos(states[:, layout.PHI]), -tension * np.sin(states[:, layout.PHI])

    def theirs(i: int, **start: float) -> float:  # far above MoorPy's sea bed
        found = catenary(ends[i, 0], -ends[i, 1], lengths[i], stiffness, weight, CB=-100, Tol=1e-9, **start)
        return abs(float(found[2]))

    def from_near(i: int) -> float:
        return theirs(i, HF0=horizontal[i], VF0=upper[i])

    for name, own, solve, aim in (("warm", warm, from_near, 100.0), ("cold", cold, theirs, None)):
        peer = float(np.median(medians([lambda i=i, solve=solve: solve(i) for i in all_spans], 3)))  # type: ignore[misc]
        met, told = (None, "") if aim is None else (peer / own >= aim, f">= {aim:.0f} x")
        beside = f"faster than MoorPy ({peer * 1e6:.0f} us)"
        yield Row(f"one span, {name}, in a batch", own * 1e6, "us", told, met, beside, peer / own)
    difference = max(abs(theirs(i) - horizontal[i]) / horizontal[i] for i in all_spans)
    yield Row("  largest relative difference from MoorPy, 1e-9", difference * 1e9, "1e-9")
