"""The tensions that let uncertain numbers do least: none found by chance is better, and all are allowed."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

import cases
from analyses.test_spread import ranges_of
from cablewright.analyses.accuracy.least_sensitive_tensions import BestTensions, best_tensions
from cablewright.analyses.accuracy.spread import FirstOrder, Method, MonteCarlo, SpreadProblem, Vertices
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.models.statics import Model
from cablewright.robot import Robot, load
from cablewright.robot.uncertainty import Range, modulus_ranges
from cablewright.robot.winch import Winch
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.tension import self_stresses
from cases import often

PLACES = {
    "paty2021": [0.2, -0.1, 8.0],
    "house-printer": [3.0, -2.0, 2.0],
    "merlet2023": [0.5, -2.0, 1.0],
    "wang2021": [0.5, 0.4, 1.0],
    "six-lines": [0.4, -0.8, 1.2],
    "cogiro": [0.5, 0.3, 1.5, 0.0, 0.0, 0.0],
    "jung2020": [0.1, 0.0, 0.3, 0.0, 0.0, 0.0],
}
TRIED = often(100, 200)


def best_at(model: Model, pose: np.ndarray, ranges: tuple[Range, ...], method: Method) -> BestTensions:
    return best_tensions(solve_inverse(model, pose[None]), ranges, method)


def robot_of(name: str) -> Robot:
    return next(robot for robot in cases.robots() if robot.name == name)


def deviations(model: Model, pose: np.ndarray, ranges: tuple[Range, ...], wanted: np.ndarray) -> np.ndarray:
    """Largest deviations under the distributions nearest to *wanted* (N, m), those that are allowed."""
    held = solve_inverse(model, np.repeat(pose[None], len(wanted), axis=0), preferred=wanted)
    held = held[held.ok]
    return Vertices()(SpreadProblem(held, held.lengths, held.pose, ranges)).max_deviation


Found = tuple[Model, np.ndarray, tuple[Range, ...], BestTensions]


BEST = [  # 256 corners of a body, which jung2020 has too
    pytest.param(each, marks=[pytest.mark.slow] * (each == ("cogiro", "moduli")), id="-".join(each))
    for each in product(PLACES, ("moduli", "load"))
]


@pytest.fixture(scope="module", params=BEST)
def found(request: pytest.FixtureRequest) -> Found:
    """A model, a pose, what is uncertain, and the best tensions there."""
    name, what = request.param
    model, pose = Model(robot_of(name)), np.array(PLACES[name])
    ranges = modulus_ranges(model.robot) if what == "moduli" else load_of(model.robot)
    return model, pose, ranges, best_at(model, pose, ranges, Vertices())


def load_of(robot: Robot) -> tuple[Range, ...]:
    entries = {"name": "mass", "relative_deviation": 0.05}, {"name": "force", "plus_minus": 2.0}
    return ranges_of(robot, *entries)


def test_no_tensions_of_chance_are_better(found: Found) -> None:
    model, pose, ranges, best = found
    rng = np.random.default_rng(7)
    low, high = np.transpose([line.tension_limits for line in model.robot.lines])
    wide = rng.uniform(low, high, (TRIED // 2, model.m))
    near = best.tensions + rng.normal(0.0, 0.05, (TRIED // 2, model.m)) * best.tensions.max()
    tried = deviations(model, pose, ranges, np.concatenate([wide, near]))
    assert len(tried) > 0.25 * TRIED
    assert best.max_deviation <= 1.01 * tried.min()


def test_they_are_at_least_as_good_as_the_least_norm(found: Found) -> None:
    model, pose, ranges, best = found
    plain = deviations(model, pose, ranges, np.zeros((1, model.m)))
    assert best.least_norm_max_deviation == pytest.approx(plain[0], rel=1e-9)
    assert best.max_deviation <= best.least_norm_max_deviation
    assert best.gain == pytest.approx(1.0 - best.max_deviation / best.least_norm_max_deviation)
    assert best.tried > 100


def test_they_hold_the_pose_within_the_limits(found: Found) -> None:
    model, pose, ranges, best = found
    there = solve_forward(model, best.lengths, guess=pose).checked()
    np.testing.assert_allclose(there.pose, pose, atol=1e-8)
    np.testing.assert_allclose(there.tensions, best.tensions, rtol=1e-5, atol=1e-5)
    assert there.margin() > -1e-4
    spread = Vertices()(SpreadProblem(there[None], best.lengths[None], pose[None], ranges))
    assert spread.max_deviation[0] == pytest.approx(best.max_deviation, rel=1e-6)


def test_tension_stiffens_a_light_machine_against_forces() -> None:
    model = Model(load("wang2021"))
    best = best_at(model, np.array(PLACES["wang2021"]), load_of(model.robot), FirstOrder())
    assert best.gain > 0.5
    assert best.tensions.max() > 500.0


@pytest.mark.parametrize("method", [FirstOrder(), MonteCarlo(200)], ids=lambda method: type(method).__name__)
def test_any_method_will_do(method: Method) -> None:
    model, pose = Model(load("house-printer")), np.array(PLACES["house-printer"])
    best = best_at(model, pose, modulus_ranges(model.robot), method)
    wanted = best_at(model, pose, modulus_ranges(model.robot), Vertices())
    assert best.max_deviation <= best.least_norm_max_deviation
    assert 0.6 * wanted.max_deviation < best.max_deviation < 1.05 * wanted.max_deviation  # samples miss corners


def test_a_counterweight_keeps_its_tension() -> None:
    """Seven lines with a winch leave one direction of choice; no point of that line is better."""
    robot, pose = load("cogiro"), np.array(PLACES["cogiro"])
    mass = float(solve_inverse(Model(robot), pose[None]).checked().winch_tensions[0, 0]) / 9.81
    line = robot.lines[0].model_copy(update={"counterweight": 1.05 * mass, "winch": Winch()})
    model = Model(robot.model_copy(update={"lines": (line, *robot.lines[1:])}))
    ranges = modulus_ranges(model.robot)
    best = best_at(model, pose, ranges, FirstOrder())
    held = solve_inverse(model, pose[None]).checked()
    (along,) = self_stresses(held[0])
    assert along[0] == 0.0
    assert best.tensions[0] == pytest.approx(held.tensions[0, 0], rel=1e-4)
    tried = held.tensions + np.linspace(-2000.0, 2000.0, 41)[:, None] * along
    there = solve_inverse(model, np.repeat(pose[None], 41, axis=0), preferred=tried)
    there = there[there.ok]
    least = FirstOrder()(SpreadProblem(there, there.lengths, there.pose, ranges)).max_deviation.min()
    assert best.max_deviation <= 1.001 * least


def test_limits_in_place_of_the_lines_bound_the_choice() -> None:
    model = Model(load("house-printer"), tension_limits=(300.0, 900.0))
    best = best_at(model, np.array([0.5, -0.5, 2.0]), modulus_ranges(model.robot), Vertices())
    assert best.tensions.min() >= 300.0 - 1e-6
    assert best.tensions.max() <= 900.0 + 1e-6


def test_they_are_found_again() -> None:
    model, pose = Model(load("house-printer")), np.array(PLACES["house-printer"])
    one, two = (best_at(model, pose, modulus_ranges(model.robot), Vertices()) for _ in range(2))
    np.testing.assert_array_equal(one.tensions, two.tensions)


def with_lines(robot: Robot, count: int) -> Robot:
    """*robot* with as many lines, some of them twice at slightly different places."""
    lines = [
        line.model_copy(
            update={"name": f"{line.name} {k}", "exit_point": (*line.exit_point[:2], line.exit_point[2] + 0.1 * k)}
        )
        for k in range(3)
        for line in robot.lines
    ][:count]
    return robot.model_copy(update={"lines": tuple(lines)})


@pytest.mark.parametrize("count", [3, 7, 9])
def test_without_a_choice_or_with_too_much_it_is_rejected(count: int) -> None:
    robot = with_lines(load("wang2021"), count)
    with pytest.raises(InputError, match=f"{count - 3} redundant lines"):
        best_at(Model(robot), np.array([0.0, 0.0, 1.0]), modulus_ranges(robot), Vertices())
    grab = load("grab-four-lines")
    with pytest.raises(InputError, match="fewer winches than degrees of freedom"):
        best_at(Model(grab), np.array([0.0, 0.0, 1.0, np.nan, np.nan, 0.0]), modulus_ranges(grab), Vertices())


def test_a_pose_that_cannot_be_held_has_none() -> None:
    with pytest.raises(AnswerError, match="no tensions within the limits"):
        best_at(Model(load("paty2021")), np.array([0.0, 0.0, 14.9]), modulus_ranges(load("paty2021")), Vertices())
