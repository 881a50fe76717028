"""What every method of a spread keeps to: symmetry, limits of small ranges, rows that know nothing of each other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace

import numpy as np
import pytest

from analyses.test_spread import problem_of, ranges_of
from cablewright.analyses.accuracy import spread as module
from cablewright.analyses.accuracy.spread import FirstOrder, Method, MonteCarlo, Spread, SpreadProblem, Vertices
from cablewright.foundation.errors import InputError
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.robot.uncertainty import Range, modulus_ranges
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cases import nozzle_errors

HOUSE = load("house-printer")
EACH = pytest.mark.parametrize(
    "method", [Vertices(), FirstOrder(), MonteCarlo(500, seed=3)], ids=lambda method: type(method).__name__
)
MANY = ({"name": "modulus", "factor": [0.7, 1.3]}, {"name": "exit_point", "deviation": 0.002})  # 16 numbers
ENTRIES = {"few": MANY[:1], "many": MANY}


def assert_same(one: Spread, other: Spread, atol: float = 0.0) -> None:
    for field in fields(Spread):
        got, wanted = getattr(one, field.name), getattr(other, field.name)
        np.testing.assert_allclose(got, wanted, rtol=0.0, atol=atol, err_msg=field.name)


@EACH
def test_a_symmetric_machine_has_a_symmetric_spread(method: Method) -> None:
    robot = load("paty2021")
    held = solve_inverse(Model(robot), [[0.0, 0.0, 0.0], [0.0, 0.0, 5.0], [0.0, 0.0, 13.0]]).checked()
    found = method(SpreadProblem(held, held.lengths, held.pose, modulus_ranges(robot)))
    loose = 0.15 if isinstance(method, MonteCarlo) else 1e-6
    size = found.high[:, 0]
    for other in (found.high[:, 1], -found.low[:, 0], -found.low[:, 1]):
        np.testing.assert_allclose(other, size, rtol=loose)
    np.testing.assert_allclose(found.deviation[:, 0], found.deviation[:, 1], rtol=loose)
    alike = np.abs(found.effects)
    np.testing.assert_allclose(alike, np.broadcast_to(alike[..., :1], alike.shape), rtol=1e-7)


@EACH
@pytest.mark.parametrize("entries", ENTRIES.values(), ids=ENTRIES)
def test_of_tiny_ranges_first_order_is_exact(method: Method, entries: tuple[dict[str, object], ...]) -> None:
    wide = ranges_of(HOUSE, *entries)
    tiny = tuple(
        Range(one.parameter, one.nominal, one.nominal - 1e-5, one.nominal + 1e-5, one.deviation and 5e-6)
        for one in wide
    )
    problem = problem_of(Model(HOUSE, tension_limits=(100.0, 5000.0)), tiny, 3)
    found = method(problem)
    assert (found.nonlinearity < 2e-3).all()
    if not isinstance(method, MonteCarlo):
        reach = np.abs(found.effects).sum(axis=2)
        np.testing.assert_allclose(found.high, reach, rtol=1e-3)
        np.testing.assert_allclose(found.low, -reach, rtol=1e-3)
        sigma = np.array([one.sigma / one.half_width for one in tiny])
        wanted = np.sqrt(((found.effects * sigma) ** 2).sum(axis=2))
        np.testing.assert_allclose(found.deviation, wanted, rtol=5e-3)  # of quantiles, not of the distribution


@EACH
def test_ranges_off_the_nominal_value_shift_the_spread(method: Method) -> None:
    """Softer cables alone: nothing is ever above nominal, and half the range says the effect."""
    problem = problem_of(
        Model(HOUSE, tension_limits=(100.0, 5000.0)),
        ranges_of(HOUSE, {"name": "modulus", "range": [0.8, 0.9], "shared": True}),
        3,
    )
    found = method(problem)
    assert (found.high[:, 2] < 0.0).all()
    least, most = 1.0 / 0.9 - 1.0, 1.0 / 0.8 - 1.0
    ratio = found.low[:, 2] / found.high[:, 2]
    np.testing.assert_allclose(ratio, most / least, rtol=0.05)


@EACH
@pytest.mark.parametrize("entries", ENTRIES.values(), ids=ENTRIES)
def test_rows_depend_on_no_other_nor_on_the_size_of_blocks(
    method: Method, entries: tuple[dict[str, object], ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = problem_of(Model(HOUSE), ranges_of(HOUSE, *entries), 5)
    whole = method(problem)
    backwards = method(problem.rows(slice(None, None, -1)))
    for field in fields(Spread):
        np.testing.assert_array_equal(getattr(backwards, field.name)[::-1], getattr(whole, field.name))
    for size in (1, 37, 700):
        monkeypatch.setattr(module, "SOLVES", size)
        assert_same(method(problem.rows(slice(0, 2))), module.Spread(**cut(whole, 2)))


def cut(spread: Spread, rows: int) -> dict[str, np.ndarray]:
    return {field.name: getattr(spread, field.name)[:rows] for field in fields(Spread)}


def test_a_seed_is_all_there_is_to_chance() -> None:
    problem = problem_of(Model(HOUSE), ranges_of(HOUSE, *MANY), 2)
    one, again, other = (MonteCarlo(300, seed)(problem) for seed in (4, 4, 5))
    for field in fields(Spread):
        assert getattr(one, field.name).tobytes() == getattr(again, field.name).tobytes()
    assert (one.max_error != other.max_error).all()
    np.testing.assert_array_equal(one.effects, other.effects)


def test_ninety_five_of_a_hundred_samples_stay_within_the_likely_error() -> None:
    problem = problem_of(Model(HOUSE), modulus_ranges(HOUSE), 1)
    found = MonteCarlo(1000, seed=1)(problem)
    points, _, ok = module.sampled(problem, module.drawn(problem.ranges, 1000, 1))
    errors = np.linalg.norm(points[0] - problem.wanted[0], axis=1)
    assert ok.all()
    assert (errors <= found.likely_error[0]).sum() == 950
    np.testing.assert_allclose(found.deviation[0], points[0].std(axis=0), rtol=1e-9)
    assert found.max_error[0] == errors.max()


@pytest.mark.parametrize("samples", [0, 99, 10_000_001, -5])
def test_too_few_samples_or_too_many_are_rejected(samples: int) -> None:
    with pytest.raises(InputError, match="samples"):
        MonteCarlo(samples)


@EACH
def test_progress_is_reported_from_nothing_to_all(method: Method, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "SOLVES", 16)
    told: list[tuple[int, int]] = []
    problem = problem_of(Model(HOUSE), modulus_ranges(HOUSE), 3)
    method(replace(problem, progress=lambda _, done, total: told.append((done, total))))
    assert told[0] == (0, 3)
    assert told[-1] == (3, 3)
    assert sorted(told) == told


@EACH
def test_a_body_turns_and_a_point_does_not(method: Method) -> None:
    body = load("cogiro")
    found = method(problem_of(Model(body), ranges_of(body, {"name": "centre_of_mass.x", "plus_minus": 0.05}), 2))
    assert (found.max_turn > 1e-5).all()
    point = method(problem_of(Model(HOUSE), modulus_ranges(HOUSE), 2))
    np.testing.assert_array_equal(point.max_turn, 0.0)


@EACH
@pytest.mark.parametrize("kind", ["modulus", "platform_point.z", "mass"])
def test_retraction_by_row_is_that_of_a_robot_retracted(method: Method, kind: str) -> None:
    robot, pose = load("jung2020"), np.array([[0.1, -0.2, 0.4, 0.0, 0.0, 0.0]])
    width = {"plus_minus": 0.002} if kind == "platform_point.z" else {"relative_deviation": 0.05}
    drawn = np.array([1.5, 1.9])
    model = Model(robot)
    held = solve_inverse(model, pose.repeat(2, axis=0), retraction=drawn).checked()
    start = solve_forward(model, held.lengths, guess=held.pose, retraction=drawn)
    rows = method(SpreadProblem(start, held.lengths, held.pose, ranges_of(robot, {"name": kind, **width})))
    for row, length in enumerate(drawn):
        other = robot.retracted(float(length))
        alone = solve_forward(Model(other), held.lengths[row][None], guess=held.pose[row])
        ranges = ranges_of(other, {"name": kind, **width})
        wanted = method(SpreadProblem(alone, held.lengths[row][None], held.pose[row][None], ranges))
        for name in ("max_error", "low", "high", "max_turn", "deviation", "effects"):
            got = getattr(rows, name)[row]
            np.testing.assert_allclose(got, getattr(wanted, name)[0], rtol=1e-6, atol=1e-10, err_msg=name)


HEAVY = ranges_of(HOUSE, {"name": "mass", "range": [200.0, 5000.0]})  # over the cables' breaking load
TOO_HEAVY = ranges_of(HOUSE, {"name": "mass", "range": [4000.0, 5000.0]})


@pytest.mark.parametrize("method", [Vertices(), MonteCarlo(200)], ids=lambda method: type(method).__name__)
def test_what_breaks_a_cable_is_counted_and_left_out(method: Method) -> None:
    """A cable over its breaking load is no place: such values count as unsolved, whatever else they do."""
    problem = problem_of(Model(HOUSE), HEAVY, 2)
    found = method(problem)
    assert (found.unsolved > 0).all()
    assert (found.worst_values < 4000.0).all()
    for mass, worst, row in zip(found.worst_values[:, 0], found.worst, range(2), strict=True):
        robot = HOUSE.model_copy(update={"platform": HOUSE.platform.model_copy(update={"mass": float(mass)})})
        there = solve_forward(Model(robot), problem.commanded[row], guess=problem.wanted[row]).checked()
        np.testing.assert_allclose(worst, there.pose, atol=1e-8)


@pytest.mark.parametrize("method", [Vertices(), MonteCarlo(200)], ids=lambda method: type(method).__name__)
def test_where_nothing_is_solved_nothing_is_claimed(method: Method) -> None:
    found = method(problem_of(Model(HOUSE), TOO_HEAVY, 2))
    assert (found.unsolved == (2 if isinstance(method, Vertices) else 200)).all()
    for name in ("max_error", "max_deviation", "low", "high", "max_turn", "likely_error", "worst", "worst_values"):
        assert np.isnan(getattr(found, name)).all(), name


@pytest.mark.parametrize("relative", [0.1, 0.3, 0.4])
def test_a_wide_normal_modulus_has_a_finite_spread(relative: float) -> None:
    """Its tail reaches below 0, where no modulus is."""
    problem = problem_of(Model(HOUSE), ranges_of(HOUSE, {"name": "modulus", "relative_deviation": relative}), 1)
    for method in (Vertices(), MonteCarlo(300)):
        assert np.isfinite(method(problem).deviation).all()


def test_samples_are_numbers_that_a_robot_can_have() -> None:
    """No radius under zero, and none over the lever that carries the sheave."""
    ranges = ranges_of(HOUSE, {"name": "sheave_radius", "deviation": 0.02})
    drawn = module.drawn(ranges, 5000, 0)
    assert (drawn > 0.0).all()
    assert (drawn <= HOUSE.lines[0].sheave.lever).all()


@pytest.mark.parametrize("method", [Vertices(), MonteCarlo(200)], ids=lambda method: type(method).__name__)
def test_of_no_place_nothing_is_found(method: Method) -> None:
    found = method(problem_of(Model(HOUSE), HEAVY, 1).rows(slice(0, 0)))
    assert found.max_error.shape == (0,)
    assert found.worst.shape == (0, 3)


REFUSED: dict[str, tuple[Callable[[], object], type[Exception]]] = {
    "no pose": (lambda: nozzle_errors(HOUSE, None), InputError),
    "no number": (lambda: nozzle_errors(HOUSE, [0.0, 0.0, 1.0], []), InputError),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_asks_nothing_is_rejected(what: str) -> None:
    ask, refusal = REFUSED[what]
    with pytest.raises(refusal):
        ask()
