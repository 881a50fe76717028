"""Rigid platforms: forward and inverse of eight sagging lines and of four, and one equilibrium beside MoorPy."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from benchmarks.statics import PLAIN, solver
from benchmarks.timing import Row, best, installed, medians
from cablewright.kernels import batches, layout
from cablewright.models.fidelity import Fidelity, SheaveLaw
from cablewright.models.rotation import angle_between, matrices
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import load
from cablewright.solvers.continuation import Tracker
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse

if TYPE_CHECKING:
    from moorpy.body import Body
    from moorpy.system import System

Array = NDArray[np.float64]
TURN = 0.05  # rad, standard deviation of each part of the rotation vector
BATCH = 50  # poses
TIGHT = 1e-10  # m: the tightest tolerance with which MoorPy converges everywhere here; with 1e-11 some poses fail
OWN = 0.05  # m: MoorPy's default, with which it stays where it starts: the step that it would take is shorter


@dataclass(frozen=True)
class Size:
    """How much is measured."""

    poses: int = 3000  # whole batches
    beside: int = 50  # poses that MoorPy solves too


FULL, QUICK = Size(), Size(BATCH, 1)


def rows(size: Size) -> Iterator[Row]:
    """All rows of this file."""
    yield from eight_rows(size)
    yield from four_rows(size)
    if installed("moorpy"):
        yield from moorpy_rows(size)


def some_poses(model: Model, count: int) -> tuple[Array, Equilibrium]:
    """Random poses over the frame that the model can hold: as requested, and held."""
    rng = np.random.default_rng(20210603)
    low, high = np.array(model.robot.scene.frame_min), np.array(model.robot.scene.frame_max)
    poses = np.hstack([rng.uniform(low, high, (3 * count, 3)), TURN * rng.standard_normal((3 * count, 3))])
    if model.m < model.n:
        poses[:, 3:5] = np.nan  # gravity decides how the platform leans
    found = solve_inverse(model, poses)
    held = np.flatnonzero(found.ok)[:count]
    return poses[held], found[held]


def off(lengths: Array) -> Array:
    """Lengths with errors of 1 mm, each line with its own."""
    return np.asarray(lengths + 1e-3 * np.random.default_rng(1).standard_normal(lengths.shape))


def per_solve(model: Model, lengths: Array, held: Equilibrium, start: int) -> float:
    """Time of one forward solve in a batch on one thread, s."""
    serial = solver(model, lengths, held, start, parallel=False)
    parts = range(0, len(lengths), BATCH)
    return float(np.mean(medians([lambda i=i: serial(slice(i, i + BATCH)) for i in parts], 5))) / BATCH  # type: ignore[misc]


def single_solves(model: Model, held: Equilibrium) -> float:
    """Median time of cold forward solves one at a time, s."""
    cold = solver(model, held.lengths, held, batches.COLD, parallel=False)
    times = medians([lambda i=i: cold(slice(i, i + 1)) for i in range(len(held.lengths))], 3)  # type: ignore[misc]
    return float(np.median(times))


def right(model: Model, held: Equilibrium) -> float:
    """Share of cold forward solves that find the pose that the lengths came from, to 1e-9 m and 1e-9 rad."""
    found = solve_forward(model, held.lengths).pose
    near = np.linalg.norm(found[:, :3] - held.pose[:, :3], axis=1) < 1e-9
    return float((near & (angle_between(found[:, 3:], held.pose[:, 3:]) < 1e-9)).mean())


def python_call(model: Model, held: Equilibrium, lengths: Array, count: int) -> float:
    """Median time of `Tracker.step` to the neighbouring lengths and back, over the first *count* poses, s."""
    steps = []
    for home, away in zip(held.lengths[:count], lengths[:count], strict=True):
        steps += there_and_back(Tracker(model, home, PLAIN).step, home, away)
    return float(np.median(medians(steps, 200)))


def there_and_back(step: Callable[[Array], object], home: Array, away: Array) -> list[Callable[[], object]]:
    """Two calls that, made in turn, always start from the other's solution."""
    return [lambda: step(away), lambda: step(home)]


def inverse(model: Model, poses: Array) -> float:
    """Time of one inverse solve in a batch on one thread, s."""
    count, packed = len(poses), model.rows()
    given = np.empty_like(poses)
    arrays = (np.zeros((count, model.m, layout.STATE)), np.zeros((count, model.m)), np.zeros(count, np.int64))
    violations = np.zeros(count)

    def solve() -> None:
        given[:] = poses
        if model.m < model.n:
            batches.hanging_rows(packed, given, *arrays, violations, 0, count)
        else:
            batches.inverse_rows(packed, given, *arrays, violations, False, 0, count)

    return best(solve) / count


def eight_rows(size: Size) -> Iterator[Row]:
    """Six degrees of freedom on eight sagging lines over swivel sheaves."""
    model = Model(load("cogiro"))
    poses, held = some_poses(model, size.poses)
    lengths = off(held.lengths)
    warm = per_solve(model, lengths, held, batches.WARM)
    yield Row("body on 8 lines: forward, warm (1 mm), in a batch", warm * 1e6, "us", "<= 40", warm <= 40e-6)
    one = python_call(model, held, lengths, size.beside)
    yield Row("  as one Python call", one * 1e6, "us")
    many = np.tile(np.arange(size.poses), 10)
    batch = solver(model, lengths[many], held[many], batches.WARM, parallel=True)
    rate = len(many) / best(lambda: batch(slice(None)))
    yield Row("  batch on all cores", rate, "solves/s")
    share = right(model, held)
    yield Row("body on 8 lines: forward, cold: right pose", 100 * share, "%", ">= 99.5", share >= 0.995)
    cold = single_solves(model, held)
    yield Row("  median of single solves", cold * 1e6, "us", "<= 300", cold <= 300e-6)
    yield Row("body on 8 lines: inverse, in a batch, one thread", inverse(model, poses) * 1e6, "us")


def four_rows(size: Size) -> Iterator[Row]:
    """Six degrees of freedom on four lines: two of them, here how the platform leans, are gravity's."""
    model = Model(load("grab-four-lines"))
    poses, held = some_poses(model, size.poses)
    yield Row("body on 4 lines: forward, cold: right pose", 100 * right(model, held), "%")
    yield Row("  median of single solves", single_solves(model, held) * 1e6, "us")
    yield Row("body on 4 lines: inverse, in a batch, one thread", inverse(model, poses) * 1e6, "us")


def moorpy_rows(size: Size) -> Iterator[Row]:
    """The same body on the same catenaries from eyelets, from the neighbouring equilibrium; MoorPy has no sheaves.

    MoorPy's bodies are solved with its analytical stiffness, each line from its last forces. Its tolerance is one on
    the last step that is taken.
    """
    model = Model(load("cogiro"), Fidelity(sheave=SheaveLaw.EYELET))
    _, held = some_poses(model, size.poses)
    lengths = off(held.lengths)
    ours = solve_forward(model, lengths[: size.beside], guess=held.pose[: size.beside]).checked()
    own = per_solve(model, lengths, held, batches.WARM)
    call = python_call(model, held, lengths, size.beside)
    peer, apart = moorpy(model, held, ours, TIGHT)
    beside = f"faster than MoorPy ({peer * 1e3:.1f} ms)"
    ratio = peer / own
    name = "body on 8 lines from eyelets, warm, in a batch"
    yield Row(name, own * 1e6, "us", ">= 1000 x", ratio >= 1000.0, beside, ratio)
    yield Row("  as one Python call", call * 1e6, "us", peer=beside, ratio=peer / call)
    yield Row(f"  MoorPy's platform points from ours ({TIGHT:g} m)", apart.max() * 1e9, "1e-9 m")
    peer, apart = moorpy(model, held, ours, OWN)
    name = f"  the same with its own tolerance ({OWN:g} m)"
    yield Row(name, apart.max() * 1e3, "mm", peer="the time of ours", ratio=peer / own)
    yield Row("  what MoorPy finds unbalanced at our poses", unbalanced(model, ours), "1e-9 weight")


def moorpy(model: Model, held: Equilibrium, ours: Equilibrium, tolerance: float) -> tuple[float, Array]:
    """Median time of MoorPy's solves there and back, s, and how far its platform points are from ours, m."""
    steps, apart = [], np.zeros(len(ours.lengths))
    for i in range(len(apart)):
        system, body = moored(model, held.pose[i], held.lengths[i])

        def step(wanted: Array, system: System = system) -> None:
            for line, length in zip(system.lineList, wanted, strict=True):
                line.setL(length)
            system.solveEquilibrium(tol=tolerance)

        step(held.lengths[i])
        step(ours.lengths[i])
        points = np.array(body.rPointRel) @ body.R.T + body.r6[:3]
        apart[i] = np.linalg.norm(points - ours.platform_points[i], axis=1).max()
        steps += there_and_back(step, ours.lengths[i], held.lengths[i])
    return float(np.median(medians(steps, 3))), apart


def moored(model: Model, pose: Array, lengths: Array) -> tuple[System, Body]:
    """The robot in MoorPy: no water to weigh less in, and a sea bed out of reach."""
    from moorpy.system import System

    gravity, platform = model.robot.scene.gravity, model.packed.platform
    system = System(depth=100.0, rho=0.0, g=gravity)
    mass, centre = platform[layout.PLATFORM_WEIGHT] / gravity, platform[layout.MASS_X : layout.MASS_Z + 1]
    body = system.addBody(0, six(pose), m=mass, rCG=centre)
    for row, length in zip(model.packed.lines, lengths, strict=True):
        wire = {"name": "wire", "m": row[layout.WEIGHT] / gravity, "w": row[layout.WEIGHT], "d_vol": 0.0}
        wire["EA"] = 1.0 / row[layout.FREE_COMPLIANCE]
        fixed = system.addPoint(1, row[layout.EXIT_X : layout.EXIT_Z + 1])
        tied = system.addPoint(1, row[layout.POINT_X : layout.POINT_Z + 1], body=1)
        system.addLine(length, wire, nSegs=1, pointA=fixed.number, pointB=tied.number)
    system.initialize()
    return system, body


def six(pose: Array) -> Array:
    """A pose as MoorPy has it: the rotation about z, then y, then x of the turned body, in the order x, y, z."""
    turn = matrices(pose[3:])
    angles = np.arctan2(turn[2, 1], turn[2, 2]), -np.arcsin(turn[2, 0]), np.arctan2(turn[1, 0], turn[0, 0])
    return np.concatenate([pose[:3], angles])


def unbalanced(model: Model, ours: Equilibrium) -> float:
    """Largest force (N) or moment (N m) that MoorPy's lines leave at our poses, in 1e-9 of the platform's weight."""
    largest = 0.0
    for pose, lengths in zip(ours.pose, ours.lengths, strict=True):
        system, _ = moored(model, pose, lengths)
        largest = max(largest, float(np.abs(system.mooringEq(six(pose), tol=1e-12)).max()))
    return 1e9 * largest / float(model.packed.platform[layout.PLATFORM_WEIGHT])
