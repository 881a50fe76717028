"""Three ways to the same spread: against springs, against each other, against every corner there is."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy.optimize import brentq, root
from scipy.spatial import ConvexHull

import cases
from cablewright.analyses.accuracy.corners import extreme_signs, signs_of_box, vertex_count
from cablewright.analyses.accuracy.spread import FirstOrder, MonteCarlo, SpreadProblem, Vertices, settled
from cablewright.models.fidelity import CableLaw, Fidelity, SheaveLaw
from cablewright.models.statics import Model
from cablewright.robot import Robot, load
from cablewright.robot.uncertainty import Range, Uncertainty, modulus_ranges
from cablewright.solvers.inverse import solve_inverse

SPRINGS = Fidelity(CableLaw.ELASTIC, SheaveLaw.EYELET)


def ranges_of(robot: Robot, *entries: dict[str, object], coverage: float = 2.0) -> tuple[Range, ...]:
    return Uncertainty(parameters=list(entries), coverage=coverage).of(robot)


def problem_of(model: Model, ranges: tuple[Range, ...], count: int, seed: int = cases.SEED) -> SpreadProblem:
    """The machine at random poses, commanded the true lengths: errors are offsets."""
    held = cases.poses(model, count, seed)
    return SpreadProblem(held, held.lengths, held.pose, tuple(ranges))


def springs(robot: Robot, lengths: np.ndarray, factors: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Where a mass hangs on straight massless springs, by SciPy."""
    exits = np.array([line.exit_point for line in robot.lines])
    stiffness = np.array([line.cable.stiffness for line in robot.lines]) * factors
    weight = robot.platform.mass * robot.scene.gravity

    def force(place: np.ndarray) -> np.ndarray:
        away = exits - place
        spans = np.linalg.norm(away, axis=1)
        tensions = np.maximum(stiffness * (spans - lengths) / lengths, 0.0)
        return (tensions / spans) @ away / weight - [0.0, 0.0, 1.0]

    found = root(force, start, tol=1e-14)
    assert np.abs(found.fun).max() < 1e-9
    return found.x


@pytest.fixture(scope="module")
def hung() -> Robot:
    """A point on four springs, none of whose dead spans is modelled."""
    return cases.replaced(load("wang2021"), "hung", winch_exit=None, dead_length=0.0)


def test_corners_are_those_of_springs(hung: Robot) -> None:
    ranges = modulus_ranges(hung, 0.7, 1.3)
    problem = problem_of(Model(hung, SPRINGS, (40.0, 1000.0)), ranges, 3)
    found = Vertices()(problem)
    corners = np.array(list(product((1.3, 0.7), repeat=4)))
    for row in range(3):
        wanted = problem.wanted[row]
        points = np.array([springs(hung, problem.commanded[row], one, wanted) for one in corners])
        off = np.linalg.norm(points - wanted, axis=1)
        assert found.max_error[row] == pytest.approx(off.max(), rel=1e-6)
        np.testing.assert_allclose(found.worst[row], points[off.argmax()], atol=1e-9)
        np.testing.assert_allclose(found.worst_values[row], corners[off.argmax()])
        np.testing.assert_allclose(found.low[row], (points - wanted).min(axis=0), atol=1e-9)
        np.testing.assert_allclose(found.high[row], (points - wanted).max(axis=0), atol=1e-9)
    np.testing.assert_array_equal(found.max_deviation, found.max_error)  # the nominal pose is the wanted one
    np.testing.assert_array_equal(found.max_turn, 0.0)
    assert np.isnan(found.likely_error).all()
    assert not found.unsolved.any()


@pytest.mark.parametrize("factor", [0.5, 0.7, 1.3, 2.0])
def test_in_the_middle_one_equation_says_all(hung: Robot, factor: float) -> None:
    """Where all lines are equal the drop solves one equation of one unknown, and goes nearly with the compliance."""
    lines = tuple(
        line.model_copy(update={"exit_point": (x, y, 3.0)})
        for line, (x, y) in zip(hung.lines, product((-2.0, 2.0), repeat=2), strict=True)
    )
    robot = hung.model_copy(update={"lines": lines})
    held = solve_inverse(Model(robot, SPRINGS), [[0.0, 0.0, 1.0]]).checked()
    ends = sorted((1.0, factor))
    ranges = ranges_of(robot, {"name": "modulus", "range": ends, "shared": True})
    found = Vertices()(SpreadProblem(held, held.lengths, held.pose, ranges))
    length, stiffness = float(held.lengths[0, 0]), factor * robot.lines[0].cable.stiffness
    share = robot.platform.mass * robot.scene.gravity / 4.0

    def unbalanced(z: float) -> float:
        span = np.sqrt(8.0 + (3.0 - z) ** 2)
        return stiffness * (span - length) / length * (3.0 - z) / span - share

    drop = brentq(unbalanced, 0.9, 1.1, xtol=1e-15) - 1.0
    assert found.max_error[0] == pytest.approx(abs(drop), rel=1e-6)
    np.testing.assert_allclose(found.worst[0], [0.0, 0.0, 1.0 + drop], atol=1e-10)
    full = 1.0 / found.effects[0, 2, 0] * (0.5 * abs(1.0 / factor - 1.0))  # of the whole compliance
    assert drop == pytest.approx((1.0 - 1.0 / factor) / full, rel=2e-3)


CORNERS = [(name, {"name": "modulus", "factor": [0.7, 1.3]}) for name in ("house-printer", "paty2021", "merlet2023")]
CORNERS += [("jung2020", {"name": "modulus", "factor": [0.7, 1.3]}), ("cogiro", {"name": "mass", "factor": [0.8, 1.2]})]
CORNERS += [
    ("wang2021", {"name": "exit_point", "plus_minus": 0.002}),
    ("cogiro", {"name": "force", "plus_minus": 30.0}),
]


@pytest.mark.parametrize(("name", "entry"), CORNERS)
def test_no_sample_is_worse_than_the_worst_corner(name: str, entry: dict[str, object]) -> None:
    problem = problem_of(Model(load(name)), ranges_of(load(name), entry), 10)
    corners, samples = Vertices()(problem), MonteCarlo(1500)(problem)
    for size in ("max_error", "max_deviation"):
        assert (getattr(samples, size) <= getattr(corners, size) * (1.0 + 1e-9) + 1e-9).all()
    curved = 1e-9 + (corners.nonlinearity * corners.max_deviation)[:, None]  # where first order hardly moves it
    assert (samples.low >= corners.low - curved).all()
    assert (samples.high <= corners.high + curved).all()
    assert (samples.likely_error < samples.max_error).all()


SMALL: dict[str, dict[str, object]] = {
    "modulus": {"relative_deviation": 0.01},
    "mass": {"relative_deviation": 0.01},
    "linear_density": {"relative_deviation": 0.01},
    "sheave_radius": {"relative_deviation": 0.01},
    "exit_point": {"plus_minus": 0.001},
    "platform_point": {"plus_minus": 0.001},
    "length_offset": {"deviation": 0.0003},
    "length_scale": {"plus_minus": 5e-5},
    "temperature": {"plus_minus": 10.0},
    "centre_of_mass": {"plus_minus": 0.003},
    "force": {"plus_minus": 5.0},
    "moment": {"plus_minus": 2.0},
}
OF_A_BODY = ("platform_point", "centre_of_mass", "moment")


@pytest.mark.parametrize("name", ["house-printer", "cogiro"])
def test_first_order_has_the_deviations_of_samples(name: str) -> None:
    """Each kind of number alone, and all together; sampling itself leaves a percent."""
    robot = load(name)
    kinds = [kind for kind in SMALL if robot.n == 6 or kind not in OF_A_BODY]
    entries = [{"name": kind, **SMALL[kind]} for kind in kinds]
    model = Model(robot, tension_limits=(100.0, 5000.0))
    for chosen in (*([one] for one in entries), entries):
        problem = problem_of(model, ranges_of(robot, *chosen), 2)
        first, samples = FirstOrder()(problem), MonteCarlo(3000)(problem)
        largest = samples.deviation.max(axis=1, keepdims=True)
        np.testing.assert_array_less(
            np.abs(first.deviation - samples.deviation), 0.05 * samples.deviation + 1e-3 * largest
        )
        assert samples.nonlinearity.max() < 0.05
        assert not samples.unsolved.any()


def test_where_a_line_may_go_slack_first_order_reports_its_own_error() -> None:
    model = Model(load("house-printer"))
    held = cases.poses(model, 60, 3)
    slackest = held.tensions.min(axis=1).argsort()[:2]
    ranges = ranges_of(model.robot, {"name": "mass", "factor": [0.7, 1.3]}, {"name": "force.y", "plus_minus": 300.0})
    problem = SpreadProblem(held[slackest], held.lengths[slackest], held.pose[slackest], ranges)
    corners, first = Vertices()(problem), FirstOrder()(problem)
    assert (first.nonlinearity > 0.25).all()
    np.testing.assert_allclose(first.nonlinearity, corners.nonlinearity, rtol=1e-9)  # with four corners all are tried
    away = np.abs(first.max_deviation - corners.max_deviation)
    assert (away <= first.nonlinearity * corners.max_deviation * (1.0 + 1e-9)).all()
    narrow = tuple(replace(one, low=one.nominal - 1e-3, high=one.nominal + 1e-3) for one in ranges)
    assert (FirstOrder()(replace(problem, ranges=narrow)).nonlinearity < 1e-3).all()


SHAPES = ["random", "alike", "opposite", "some nothing", "flat", "straight", "of all sizes"]


def effects_of(shape: str, k: int) -> np.ndarray:
    rng = np.random.default_rng(k)
    effects = rng.normal(size=(3, k))
    if shape in ("alike", "opposite"):
        effects[:, k // 2 :] = effects[:, : k - k // 2] * (1.0 if shape == "alike" else -1.0)
    if shape == "some nothing":
        effects[:, ::3] = 0.0
    if shape in ("flat", "straight"):
        effects[2:] = 0.0
    if shape == "straight":
        effects[1] = 2.0 * effects[0]
    return effects * 10.0 ** rng.uniform(-6, 0, k) if shape == "of all sizes" else effects


@pytest.mark.parametrize("k", [13, 14])
@pytest.mark.parametrize("shape", SHAPES)
def test_the_corners_chosen_hold_the_extremes_of_all(shape: str, k: int) -> None:
    effects = effects_of(shape, k)
    every = signs_of_box(k) @ effects.T
    signs = extreme_signs(effects)
    assert len(signs) == vertex_count(k)
    assert (np.abs(signs) == 1.0).all()
    chosen = signs @ effects.T
    rng = np.random.default_rng(1)
    size = np.abs(effects).sum()
    for goal in size * np.concatenate([rng.normal(size=(40, 3)), 0.1 * rng.normal(size=(40, 3)), np.zeros((1, 3))]):
        assert np.linalg.norm(chosen - goal, axis=1).max() >= np.linalg.norm(every - goal, axis=1).max() - 1e-12 * size
    for way in np.concatenate([np.eye(3), rng.normal(size=(100, 3))]):
        assert (chosen @ way).max() >= (every @ way).max() - 1e-12 * size
    if shape not in ("flat", "straight"):
        assert ConvexHull(chosen, qhull_options="QJ").volume == pytest.approx(
            ConvexHull(every, qhull_options="QJ").volume, rel=1e-6
        )


def test_beyond_twelve_numbers_the_worst_corner_is_still_found() -> None:
    """Of 16 numbers, solved at every fifth of 65 536 corners: those that first order chooses hold the worst."""
    robot = load("house-printer")
    ranges = ranges_of(robot, {"name": "modulus", "factor": [0.7, 1.3]}, {"name": "exit_point", "plus_minus": 0.005})
    problem = problem_of(Model(robot, tension_limits=(100.0, 5000.0)), ranges, 1)
    found = Vertices()(problem)
    every = problem.middle + signs_of_box(16)[::5] * problem.half_widths
    points = settled(problem, every[None]).nozzle
    assert found.max_error[0] >= np.linalg.norm(points - problem.wanted[0], axis=1).max()
    assert (found.high >= (points - problem.wanted[0]).max(axis=0) - 1e-6).all()
