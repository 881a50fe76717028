"""Facets of the available wrenches, beside linear programs, convex hulls and the kernel of `capacity`."""

from itertools import product

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial import ConvexHull

import cablewright as cw

CASES = {
    "cogiro": [0.3, 0.2, 2.0, 0.05, 0.0, 0.1],
    "house-printer": [1.0, 2.0, 5.0],
    "jung2020": [0.2, 0.1, 0.9],
    "maslow4": [0.2, np.nan, 1.0],
    "ipanema": [0.3, 0.2, 1.0],
}
LENGTH = 0.5


def corners(found: cw.WrenchPolytope) -> np.ndarray:
    """What all combinations of extreme tensions make, in the free directions, moments divided by the arm."""
    arms = np.array([1.0, 1.0, 1.0] + [1.0 / LENGTH] * 3)[: len(found.required)]
    return np.array(list(product(*found.limits))) @ (found.structure * arms[:, None]).T @ found.basis


@pytest.mark.parametrize("name", CASES)
def test_facets_and_volume_are_those_of_the_hull_of_all_corners(name: str) -> None:
    found = cw.available_wrenches(cw.load(name), CASES[name], length=LENGTH)
    hull = ConvexHull(corners(found))
    assert float(found.volume) == pytest.approx(hull.volume, rel=1e-9)
    planes = np.unique(hull.equations.round(6), axis=0)
    assert int(found.facets) == len(planes)


@pytest.mark.parametrize("name", CASES)
def test_the_margin_is_that_of_the_kernel(name: str) -> None:
    robot, rng = cw.load(name), np.random.default_rng(1)
    if robot.platform.plane is not None:  # both take planes to hold both ways
        robot = robot.with_platform(plane=robot.platform.plane.model_copy(update={"one_sided": False}))
    pose = np.array([CASES[name]] * 3)
    pose[:, 0] += rng.uniform(-0.05, 0.05, 3)
    found = cw.available_wrenches(robot, pose, length=LENGTH)
    assert found.margin == pytest.approx(cw.capacity(robot, pose, length=LENGTH).margin, rel=1e-8, abs=1e-8)
    assert found.contains(found.required[0])[0]


def test_a_counterweight_has_one_tension() -> None:
    """The margin is that of `capacity`; of one that exceeds the limit nothing can be applied."""
    robot, pose = cw.load("skycam"), [5.0, 3.0, 15.0]
    line = robot.lines[3].model_dump(exclude={"winch"}) | {"counterweight": 20.0}
    robot = robot.with_(lines=[*(each.model_dump() for each in robot.lines[:3]), line])
    found = cw.available_wrenches(robot, pose)
    assert float(found.margin) == pytest.approx(cw.capacity(robot, pose).margin, rel=1e-9)
    assert found.limits[3] == pytest.approx([20.0 * 9.81] * 2)
    assert (float(found.volume), int(found.facets)) == (pytest.approx(ConvexHull(corners(found)).volume, rel=1e-9), 6)
    beyond = cw.available_wrenches(robot, pose, tension_limits=(1.0, 100.0))
    assert (int(beyond.facets), cw.capacity(robot, pose, tension_limits=(1.0, 100.0)).margin) == (0, -np.inf)
    assert not beyond.contains(beyond.required)


def test_many_lines_and_no_poses() -> None:
    """18 lines have 8568 pairs of possible facets; no more than a few of them are compared at a time."""
    rng = np.random.default_rng(1)
    given = {"mass": 5.0, "cable": "dyneema-2mm", "tension_limits": (1.0, 500.0), "frame": [[-3.0] * 3, [3.0] * 3]}
    robot = cw.Robot.from_points(3.0 * rng.normal(size=(18, 3)), 0.3 * rng.normal(size=(18, 3)), **given)
    found = cw.available_wrenches(robot, np.zeros(6))
    assert (int(found.facets), float(found.margin)) == (17136, pytest.approx(cw.capacity(robot, np.zeros(6)).margin))
    assert cw.available_wrenches(robot, np.zeros((0, 6))).margin.shape == (0,)


@pytest.mark.parametrize("name", ["cogiro", "house-printer", "jung2020"])
def test_a_linear_program_agrees_on_points_inside(name: str) -> None:
    found = cw.available_wrenches(cw.load(name), CASES[name])
    rng = np.random.default_rng(2)
    low, high = found.limits.T
    answers = []
    for share in rng.uniform(-0.2, 1.2, (60, len(low))):
        wrench = found.structure @ (low + share * (high - low))
        program = linprog(np.zeros(found.structure.shape[1]), A_eq=found.structure, b_eq=wrench, bounds=found.limits)
        assert bool(found.contains(wrench)) == (program.status == 0)
        answers.append(program.status == 0)
    assert 0 < sum(answers) < 60


def test_corners_of_forces_beside_a_moment_are_made_by_tensions_within_limits() -> None:
    found = cw.available_wrenches(cw.load("cogiro"), CASES["cogiro"])
    points = found.vertices()
    for force in points[::7]:
        wrench = np.concatenate([force, found.required[3:]])
        slack = linprog(
            np.zeros(8),
            A_eq=found.structure,
            b_eq=wrench,
            bounds=found.limits + np.array([-1e-6, 1e-6]),
            method="highs",
        )
        assert slack.status == 0
    with pytest.raises(cw.AnswerError, match="cannot apply any force"):
        found.vertices(moment=[1e9, 0.0, 0.0])


def test_lines_that_do_not_reach_all_degrees_of_freedom_have_no_facets() -> None:
    found = cw.available_wrenches(cw.load("grab-four-lines"), [0.0, 0.0, 1.0])
    assert int(found.facets) == 0
    assert np.isnan(found.margin)
    assert not found.contains(found.required)
    with pytest.raises(cw.AnswerError, match="flat"):
        found.plot()


def test_the_picture_of_a_point_a_body_and_a_plane() -> None:
    for name in ("house-printer", "cogiro", "maslow4"):
        assert cw.available_wrenches(cw.load(name), CASES[name]).plot().axes
    batch = cw.available_wrenches(cw.load("cogiro"), [CASES["cogiro"]] * 2)
    with pytest.raises(cw.InputError, match="one pose"):
        batch.plot()
    assert len(repr(batch)) < 300


def test_methods_side_by_side_are_each_that_of_its_own() -> None:
    robot, poses = cw.load("jung2020"), [[0.2, 0.1, 0.9], [0.0, 0.0, 0.8]]
    found = cw.compare_tensions(robot, poses, ["closed-form", "exact"], tension_limits=(5.0, 150.0))
    for row, name in enumerate(found.methods):
        alone = cw.tension_distribution(robot, poses, name, tension_limits=(5.0, 150.0))
        assert found.tensions[row] == pytest.approx(alone.tensions)
        assert found.margin[row] == pytest.approx(alone.margin)
    assert found.plot().axes
    one = cw.compare_tensions(robot, poses[0], [cw.Quadratic(np.ones(8)), "least-norm"])
    assert one.methods == ("Quadratic", "least-norm")
    assert one.plot().axes
    with pytest.raises(cw.InputError, match="did you mean 'exact'"):
        cw.compare_tensions(robot, poses, ["exakt"])
    with pytest.raises(cw.InputError, match="a list"):
        cw.compare_tensions(robot, poses, "exact")
