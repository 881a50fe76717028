"""The region at one place: its hull and shadows are geometry's, and its corners are held against the inside."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

import cases
from analyses.test_spread import ranges_of
from cablewright.analyses.accuracy import error_region as module
from cablewright.analyses.accuracy.error_region import PLANES, hull_of, interior, region
from cablewright.analyses.accuracy.spread import SpreadProblem, Vertices, corner_values, sampled
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import load
from cablewright.robot.uncertainty import Range, modulus_ranges
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cases import nozzle_errors

CLOUDS = [
    np.random.default_rng(seed).normal(size=(count, 3)) * [1.0, 2.0, 0.1] for seed, count in enumerate((4, 7, 60, 500))
]
CUBE = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
SIZES = [1e-9, 1e-4, 1.0, 1e5]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("points", CLOUDS, ids=len)
def test_hulls_and_shadows_are_scipys(points: np.ndarray, size: float) -> None:
    found = hull_of(size * points)
    assert found.volume == pytest.approx(ConvexHull(points).volume * size**3, rel=1e-9)
    assert set(np.unique(found.triangles)) == set(ConvexHull(points).vertices)
    for name, axes in PLANES.items():
        flat = points[:, axes]
        theirs = ConvexHull(flat)
        outline = found.projections[name]
        np.testing.assert_allclose(
            sorted(outline.tolist()), sorted((size * flat[theirs.vertices]).tolist()), rtol=1e-12
        )
        assert area(outline) == pytest.approx(theirs.volume * size**2, rel=1e-9)
        assert turns_left(outline)


def area(outline: np.ndarray) -> float:
    """Area of a polygon (P, 2)."""
    x, y = (outline - outline[0]).T
    return 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def turns_left(outline: np.ndarray) -> bool:
    """Whether an outline goes round anticlockwise, with no corner that is none."""
    sides = np.roll(outline, -1, axis=0) - outline
    after = np.roll(sides, -1, axis=0)
    return bool((sides[:, 0] * after[:, 1] - sides[:, 1] * after[:, 0] > 0.0).all())


@pytest.mark.parametrize("points", CLOUDS, ids=len)
def test_a_hull_moves_and_turns_with_its_points(points: np.ndarray) -> None:
    turn = Rotation.from_rotvec([0.3, -0.8, 0.5]).as_matrix()
    still, moved = hull_of(points), hull_of(1e-3 * points @ turn.T + [7.0, -3.0, 13.0])
    assert moved.volume == pytest.approx(1e-9 * still.volume, rel=1e-9)
    about_z = hull_of(points @ Rotation.from_rotvec([0.0, 0.0, 0.5 * np.pi]).as_matrix().T)
    assert area(about_z.projections["xz"]) == pytest.approx(area(still.projections["yz"]), rel=1e-9)
    assert area(about_z.projections["xy"]) == pytest.approx(area(still.projections["xy"]), rel=1e-9)


def test_the_hull_of_a_cube_is_the_cube() -> None:
    found = hull_of(np.vstack([CUBE, CUBE, [[0.5, 0.5, 0.5]], [[0.5, 0.5, 0.0]]]))
    assert found.volume == pytest.approx(1.0, rel=1e-12)
    for outline in found.projections.values():
        assert len(outline) == 4
        assert area(outline) == pytest.approx(1.0, rel=1e-12)


FLAT = {
    "one point": np.array([[1.0, 2.0, 3.0]]),
    "the same points": np.tile([1.0, 2.0, 3.0], (9, 1)),
    "two points": np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]]),
    "a line": np.linspace(0.0, 1.0, 7)[:, None] * [1.0, -2.0, 0.5] + [4.0, 4.0, 4.0],
    "a triangle": CUBE[:3],
    "a square aslant": CUBE[:4] @ Rotation.from_rotvec([0.4, 0.5, 0.6]).as_matrix().T + [3.0, 2.0, 1.0],
}


@pytest.mark.parametrize("name", FLAT)
def test_what_is_flat_has_shadows_and_no_volume(name: str) -> None:
    found = hull_of(FLAT[name])
    assert found.volume == 0.0
    assert found.triangles.shape == (0, 3)
    for outline in found.projections.values():
        assert outline.ndim == 2
        assert 1 <= len(outline) <= len(FLAT[name])
        assert area(outline) < 1.2  # of the square, were it to lie in the plane


def problem_at(name: str, pose: list[float], ranges: tuple[Range, ...] | None = None) -> SpreadProblem:
    """As `studies.place` puts it: lengths of rigid cables on the full machine."""
    robot = load(name)
    known = modulus_ranges(robot) if ranges is None else ranges
    found = nozzle_errors(robot, pose, known)
    nominal = solve_forward(Model(robot), found.commanded, guess=found.nominal)
    return SpreadProblem(nominal, found.commanded, found.wanted, known)


PLACES = [
    ("paty2021", [0.0, 0.0, 0.0]),
    ("paty2021", [1.0, -0.5, 8.0]),
    ("house-printer", [-6.0, 5.0, 1.0]),
    ("merlet2023", [0.5, -2.0, 1.0]),
    ("wang2021", [0.5, -0.4, 1.0]),
    ("jung2020", [0.0, 0.0, 0.1, 0.0, 0.0, 0.0]),
]


@pytest.mark.parametrize(("name", "pose"), PLACES)
def test_on_real_machines_corners_are_worst_and_hold_the_inside(name: str, pose: list[float]) -> None:
    problem = problem_at(name, pose)
    found = region(problem, corner_values(problem), inner=1500)
    inside = found.interior
    assert inside is not None
    assert inside.corner_is_worst
    spread = Vertices()(problem)
    corner = np.linalg.norm(found.points - found.wanted, axis=1).max()
    assert corner == pytest.approx(float(spread.max_error[0]), rel=1e-12)
    assert 0.9 * corner < inside.max_error <= corner + 1e-9  # climbs reach the corner itself
    assert 0.9 * spread.max_deviation[0] < inside.max_deviation <= spread.max_deviation[0] + 1e-9
    rng = np.random.default_rng(3)
    values = problem.middle + rng.uniform(-1, 1, (400, len(problem.ranges))) * problem.half_widths
    cloud = np.vstack([found.points, sampled(problem, values)[0][0]])
    assert hull_of(cloud).volume == pytest.approx(found.hull.volume, rel=2e-2)  # nearly a zonotope


@pytest.mark.parametrize("depth", [1e-3, 1e-6])
def test_an_inside_that_beats_the_corners_is_found_out(depth: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine with an error of *depth* in the middle of the box, and less towards its corners."""
    robot = load("house-printer")
    held = solve_inverse(Model(robot), [[0.0, 0.0, 3.0]]).checked()
    problem = SpreadProblem(held, held.lengths, held.pose, modulus_ranges(robot))

    def bent(_problem: SpreadProblem, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        scaled = (values.reshape(-1, 4) - problem.middle) / problem.half_widths
        off = depth * (1.0 - 0.5 * (scaled**2).mean(axis=1))
        points = held.nozzle[0] + off[:, None] * [0.0, 0.0, 1.0]
        return points[None], np.zeros((1, len(points))), np.ones((1, len(points)), dtype=bool)

    def settled(_problem: SpreadProblem, values: np.ndarray) -> Equilibrium:
        return replace(held[np.zeros(values.shape[1], dtype=int)], pose=bent(problem, values)[0][0])

    monkeypatch.setattr(module, "sampled", bent)
    monkeypatch.setattr(module, "settled", settled)
    monkeypatch.setattr(module, "nozzle_response", lambda held, _: np.zeros((len(held.code), 3, 4)))
    corners = bent(problem, corner_values(problem))[0][0]
    found = interior(problem, corners, 500, seed=0)
    assert not found.corner_is_worst
    assert found.max_error > 0.5 * depth
    assert found.samples == 500


def test_climbs_go_up_where_samples_do_not_reach() -> None:
    """From a few samples the climb ends in the corner itself, to rounding."""
    problem = problem_at("paty2021", [1.0, -0.5, 8.0])
    corners = sampled(problem, corner_values(problem))[0][0]
    worst = np.linalg.norm(corners - problem.wanted[0], axis=1).max()
    found = interior(problem, corners, 40, seed=1)
    assert found.max_error == pytest.approx(worst, rel=1e-9)
    assert found.climbs == 16
    assert interior(problem, corners, 3, seed=1).climbs == 3


def test_a_region_of_many_numbers_and_of_one() -> None:
    robot = load("house-printer")
    many = ranges_of(robot, {"name": "modulus", "factor": [0.7, 1.3]}, {"name": "exit_point", "plus_minus": 0.002})
    problem = problem_at("house-printer", [1.0, 2.0, 3.0], many)
    found = region(problem, corner_values(problem), inner=300)
    assert found.interior is not None
    assert found.interior.corner_is_worst
    assert found.values.shape == (len(found.points), 16)
    assert len(np.unique(found.values, axis=0)) == len(found.values)
    one = problem_at("house-printer", [1.0, 2.0, 3.0], ranges_of(robot, {"name": "mass", "plus_minus": 5.0}))
    line = region(one, corner_values(one))
    assert line.interior is None
    assert line.hull.volume == 0.0
    assert len(line.points) == 2
    np.testing.assert_allclose(line.wanted, [1.0, 2.0, 3.0])


def test_corners_without_an_answer_are_left_out() -> None:
    robot = load("house-printer")
    problem = problem_at("house-printer", [1.0, 2.0, 3.0], ranges_of(robot, {"name": "mass", "range": [200.0, 9000.0]}))
    found = region(problem, corner_values(problem), inner=50)
    np.testing.assert_array_equal(found.values, [[200.0]])
    assert len(found.points) == 1


@pytest.mark.parametrize("name", ["cogiro", "jung2020"])
def test_the_region_is_the_nozzles(name: str) -> None:
    robot = load(name)
    platform = robot.platform.model_copy(update={"nozzle": (0.2, 0.1, -0.4)})
    robot = robot.model_copy(update={"platform": platform})
    held = cases.poses(Model(robot), 1)
    problem = SpreadProblem(
        held, held.lengths, held.pose, ranges_of(robot, {"name": "centre_of_mass", "plus_minus": 0.01})
    )
    found = region(problem, corner_values(problem))
    np.testing.assert_allclose(found.wanted, held.nozzle[0], atol=1e-12)
    np.testing.assert_allclose(found.nominal, held.nozzle[0], atol=1e-12)
    assert np.linalg.norm(found.points - found.wanted, axis=1).max() < 0.1
