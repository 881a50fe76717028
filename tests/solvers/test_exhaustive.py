"""The exhaustive search: its proofs are right, and it never misses an unknown equilibrium."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from mpmath import mp, mpf, quad

import cablewright as cw
from cablewright.foundation.errors import InputError
from cablewright.foundation.progress import silent
from cablewright.kernels import layout
from cablewright.kernels.certificates.interval import cos, point, sin
from cablewright.kernels.statics.line import line_branches, line_cell
from cablewright.kernels.statics.line.span_enclosure import hanging_span
from cablewright.solvers import exhaustive
from cablewright.solvers.line_cover import atlases, known_of
from cases import often

NO_LOOPS = "all equilibria with the platform in the box and without a loop in a dead span"


def held(name: str, pose: list[float], longer: float = 0.0) -> tuple[cw.Model, np.ndarray]:
    """A robot, and its lengths at a pose, the first line longer by *longer*."""
    model = cw.Model(cw.load(name))
    lengths = cw.inverse(model.robot, pose).checked().lengths.copy()
    lengths[0] += longer
    return model, lengths


@pytest.fixture(scope="module")
def taut():
    """A machine with levers, its sixteen equilibria, and the atlas of its first line around them."""
    model, lengths = held("paty2021", [-2.1392, 2.2533, 4.0237])
    found = cw.equilibria(model, lengths)
    poses = found.solutions.pose
    box = np.stack([poses.min(axis=0) - 0.1, poses.max(axis=0) + 0.1], axis=1).ravel()
    return model, lengths, found, atlases(found.solutions, lengths[:1], box, box, 0)


@pytest.mark.slow  # the command `equilibria` does too
def test_a_machine_on_swivels_has_one_equilibrium_in_its_whole_room() -> None:
    model, lengths = held("merlet2023", [0.5, -1.0, 1.2], 0.005)
    found = cw.equilibria(model, lengths)
    every, search = exhaustive.exhaust(found, exhaustive.begin(model, None))
    assert "dead spans are taut" in (found.complete_for or "")  # by theorem 3, which is about any place
    assert (every.complete_for, len(every.stable), search.finished, len(every.undecided)) == (NO_LOOPS, 1, True, 0)


@pytest.mark.slow
def test_levers_have_sixteen_and_no_more(taut) -> None:
    model, _, found, _ = taut
    every, search = exhaustive.exhaust(found, exhaustive.begin(model, None))
    assert (every.complete_for, len(every.stable), every.stable.sum()) == (NO_LOOPS, 16, 1)
    assert search.finished


@pytest.mark.slow
def test_an_unknown_equilibrium_stays_open(taut) -> None:
    model, _, found, _ = taut
    hidden = 3
    rest = np.delete(np.arange(len(found.stable)), hidden)
    pose = found.solutions.pose[hidden]
    around = np.stack([pose - 0.4, pose + 0.3], axis=1).ravel()
    begun = replace(exhaustive.begin(model, None), open=around[None])
    search = exhaustive._level(found.solutions[rest], begun, np.inf, lambda _: None, silent)
    open_there = ((search.undecided[:, ::2] <= pose) & (search.undecided[:, 1::2] >= pose)).all(axis=1)
    assert open_there.any()
    more = exhaustive._hunt(found.solutions[rest], search.undecided)
    assert np.abs(more.pose - pose).max(axis=1).min() < 1e-9


def test_every_shape_that_a_solve_finds_is_in_a_leaf(taut) -> None:
    _, _, found, known = taut
    labels, _ = known_of(found.solutions)
    for label, state, pose in zip(labels, found.solutions.states, found.solutions.pose, strict=True):
        for i, own in enumerate(np.split(known.leaves, known.offsets[1:-1])):
            phi, tau = state[i, layout.PHI], state[i, layout.TAU]
            at = own[(own[:, 0] <= phi) & (own[:, 1] >= phi) & (own[:, 2] <= tau) & (own[:, 3] >= tau)]
            at = at[at[:, line_cell.LABEL] == label[i]]
            away = pose - known.exits[i]
            x = np.hypot(away[0], away[1])
            wanted = {
                line_cell.X: x,
                line_cell.Z: away[2],
                line_cell.REACH: np.hypot(x, away[2]),
                line_cell.H: np.exp(tau) * np.cos(phi),
                line_cell.V: np.exp(tau) * np.sin(phi),
                line_cell.FREE_SPAN: state[i, layout.FREE],
            }
            holds = np.ones(len(at), dtype=bool)
            for column, value in wanted.items():
                holds &= (at[:, column] <= value + 1e-9) & (at[:, column + 1] >= value - 1e-9)
            assert holds.any()


def test_the_span_in_its_own_frame_encloses_the_integrals() -> None:
    mp.dps = 30
    rng = np.random.default_rng(3)
    for _ in range(often(10, 40)):
        phi, q = rng.uniform(-1.5, 1.4), 10.0 ** rng.uniform(-3.0, 0.5)
        found = hanging_span(sin(point(phi)), cos(point(phi)), point(q))
        wanted = _integrals(mpf(phi), mpf(q))
        for (low, high), value in zip(found, wanted, strict=True):
            assert low <= value <= high
        largest = max(mpf(1), mp.sqrt(1 + 2 * mpf(q) * mp.sin(mpf(phi)) + mpf(q) ** 2))
        lower = mp.cos(mpf(phi)) ** 2 / (12 * largest**6)
        assert wanted[2] * wanted[4] - wanted[3] ** 2 >= lower * (1 - mpf(10) ** -12)


def _integrals(phi, q):
    """What `hanging_span` encloses, by quadrature."""
    s, c = mp.sin(phi), mp.cos(phi)

    def size(u):
        return mp.sqrt(1 + 2 * q * u * s + (q * u) ** 2)

    parts = (
        lambda u: (1 + q * u * s) / size(u),
        lambda u: q * u * c / size(u),
        lambda u: (u * c) ** 2 / size(u) ** 3,
        lambda u: -u * c * (1 + q * u * s) / size(u) ** 3,
        lambda u: (1 + q * u * s) ** 2 / size(u) ** 3,
    )
    return [quad(part, [0, 0.25, 0.5, 0.75, 1]) for part in parts]


@pytest.mark.slow  # compiles what it alone calls; leaves that are wrong show in the test of every shape
def test_what_only_stiffens_does(taut) -> None:
    """The derivative of a line's end by its force, by differences of whole solves, at leaves said to stiffen."""
    model, lengths, _, known = taut
    rng = np.random.default_rng(4)
    row = model.packed.lines[0]
    own = known.leaves[: known.offsets[1]]
    good = own[(own[:, line_cell.GOOD] == 1.0) & (np.exp(own[:, 2]) < 1e4)]
    work = line_branches.shape_work()
    for one in good[rng.choice(len(good), often(15, 60), replace=False)]:
        middle = np.array([0.5 * (one[0] + one[1]), 0.5 * (one[2] + one[3])])
        ends, forces = [], []
        for step in ((0.0, 0.0), (1e-5, 0.0), (0.0, 1e-5)):
            end, force = _line_at(row, float(lengths[0]), middle + step, int(one[line_cell.LABEL]), work)
            ends.append(end)
            forces.append(force)
        by = np.column_stack([ends[1] - ends[0], ends[2] - ends[0]])
        of = np.column_stack([forces[1] - forces[0], forces[2] - forces[0]])
        derivative = by @ np.linalg.inv(of)
        assert np.linalg.eigvalsh(0.5 * (derivative + derivative.T))[0] > 0.0


def _line_at(row, length, middle, label, work):
    """End and end force of a line of given direction, log tension and lever, by the inner unknowns' own equations."""
    t = np.exp(middle[1])
    cell = np.array([middle[0], middle[0], middle[1], middle[1]])
    lever = 0.5 * (middle[0] - 0.5 * np.pi) + (np.pi if label == line_cell.STANDING else 0.0)
    box = np.array([14.0, 16.0, -1.8, -1.4, lever - 1.2, lever + 1.2])
    stack, proved = [box], None
    while stack and proved is None:
        box = stack.pop()
        verdict = line_branches.examine(row, length, cell, box, work)
        while verdict == line_branches.SHRUNK:
            verdict = line_branches.examine(row, length, cell, box, work)
        if verdict == line_branches.PROVED:
            proved = work.where.copy()
            line_branches.tighten(row, length, cell, proved, work)
        elif verdict == line_branches.UNSURE:
            axis = int(np.argmax([box[1] - box[0], 5.0 * (box[3] - box[2]), box[5] - box[4]]))
            halves = [box.copy(), box.copy()]
            halves[0][2 * axis + 1] = halves[1][2 * axis] = 0.5 * (box[2 * axis] + box[2 * axis + 1])
            stack += halves
    assert proved is not None
    own = np.zeros(line_cell.LEAF)
    line_cell.describe(row, length, cell, proved, work.slopes, own)
    x, z, free = (0.5 * own[at : at + 2].sum() for at in (line_cell.X, line_cell.Z, line_cell.FREE_SPAN))
    return np.array([x, z]), np.array([t * np.cos(middle[0]), t * np.sin(middle[0]) + row[layout.WEIGHT] * free])


@pytest.mark.slow  # compiles what it alone calls; leaves that are wrong show in the test of every shape
def test_slopes_of_the_inner_unknowns_are_enclosed() -> None:
    """Derivatives of dead length, psi and lever over a cell hold the differences of solves at points in it."""
    row = cw.Model(cw.load("paty2021")).packed.lines[0]
    rng, work = np.random.default_rng(6), line_branches.shape_work()
    for _ in range(often(8, 25)):
        phi, tau = rng.uniform(-1.4, 0.2), np.log(10.0 ** rng.uniform(0.8, 3.0))
        cell = np.array([phi, phi + 0.05, tau, tau + 0.02])
        parts = [_inner_at(row, np.array([phi + a, phi + a, tau + b, tau + b]), work) for a, b in POINTS]
        box = np.stack(parts)
        whole = np.stack([box[:, ::2].min(axis=0) - 1e-9, box[:, 1::2].max(axis=0) + 1e-9], axis=1).ravel()
        wide = whole + 0.05 * np.tile([-1.0, 1.0], 3) * (whole[1::2] - whole[::2]).repeat(2)
        line_branches.tighten(row, 25.0, cell, wide, work)
        middles = 0.5 * (box[:, ::2] + box[:, 1::2])
        for b, (one, other) in enumerate(((0, 1), (0, 2))):
            step = 0.05 if b == 0 else 0.02
            secant = (middles[other] - middles[one]) / step
            assert (np.abs(secant - work.slopes[:, b]) <= work.slopes[:, 2 + b] + 1e-7).all()


POINTS = ((0.0, 0.0), (0.05, 0.0), (0.0, 0.02), (0.05, 0.02))


def _inner_at(row, cell, work):
    """The inner unknowns at one direction and tension, a tiny box."""
    lever = 0.5 * (cell[0] - 0.5 * np.pi)
    stack = [np.array([14.0, 16.0, -1.8, -1.4, lever - 1.2, lever + 1.2])]
    while stack:
        box = stack.pop()
        verdict = line_branches.examine(row, 25.0, cell, box, work)
        while verdict == line_branches.SHRUNK:
            verdict = line_branches.examine(row, 25.0, cell, box, work)
        if verdict == line_branches.PROVED:
            proved = work.where.copy()
            line_branches.tighten(row, 25.0, cell, proved, work)
            return proved
        if verdict == line_branches.UNSURE:
            axis = int(np.argmax([box[1] - box[0], 5.0 * (box[3] - box[2]), box[5] - box[4]]))
            halves = [box.copy(), box.copy()]
            halves[0][2 * axis + 1] = halves[1][2 * axis] = 0.5 * (box[2 * axis] + box[2 * axis + 1])
            stack += halves
    raise AssertionError("no shape")


def test_a_search_that_was_begun_with_more_is_not_finished_with_less(taut) -> None:
    """What was judged beside sixteen equilibria does not pass for a proof of the fifteen that are found now."""
    model, _, found, _ = taut
    begun = exhaustive.begin(model, None)
    finished = replace(begun, open=begun.open[:0], poses=found.solutions.pose)
    fewer = replace(found, solutions=found.solutions[np.arange(1, 16)])
    every, _ = exhaustive.exhaust(fewer, finished)
    assert (len(every.stable), every.complete_for) == (16, NO_LOOPS)


@pytest.mark.slow  # the command `equilibria` does too, on a smaller search
def test_it_can_be_interrupted_and_goes_on() -> None:
    """To one equilibrium, with a line that hangs too."""
    model, lengths = held("merlet2023", [0.5, -1.0, 1.2], 0.3)
    found = cw.equilibria(model, lengths)
    saved = [exhaustive.begin(model, None)]

    def interrupt(what: str, _done: int, _all: int) -> None:
        if what == "places" and len(saved) < 2:
            raise KeyboardInterrupt

    while not saved[-1].finished:
        with suppress(KeyboardInterrupt):
            first, _ = exhaustive.exhaust(found, saved[-1], save=saved.append, progress=interrupt)
    assert [search.judged for search in saved[:2]] == [0, 1]
    assert (first.complete_for, first.status, len(first.stable)) == (NO_LOOPS, "ok", 1)
    assert len(saved[-1].undecided) == 0


def test_the_time_limit_holds_while_the_lines_are_prepared() -> None:
    model, lengths = held("merlet2023", [0.5, -1.0, 1.2])
    found = cw.equilibria(model, lengths, starts=1)
    stages: list[str] = []
    ended, search = exhaustive.exhaust(
        found, exhaustive.begin(model, None), time_limit=0.05, progress=lambda what, *_: stages.append(what)
    )
    assert ended.status == "unfinished"
    assert "before the lines' shapes were known, so that it needs a longer time limit" in ended.why
    assert (search.judged, "places" in stages) == (0, False)


def test_unsupported_robots_are_rejected() -> None:
    body = cw.Model(cw.load("cogiro"))
    lengths = cw.inverse(body.robot, [1.0, 1.0, 1.5]).checked().lengths
    with pytest.raises(InputError, match="exhaustive: robot 'cogiro' has a rigid platform; not supported"):
        exhaustive.exhaust(cw.equilibria(body, lengths, starts=1), exhaustive.begin(body, None))
    model, lengths = held("merlet2023", [0.5, -1.0, 1.2])
    found = cw.equilibria(model, lengths)
    with pytest.raises(InputError, match="time limit"):
        exhaustive.exhaust(found, exhaustive.begin(model, None), time_limit=0.0)
