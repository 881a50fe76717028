"""Straight lines over what they pass: several spans, cables side by side, guides, swivels of any axis."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.guidance.pose_selection import calibration_poses
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan, Point, Sigmas
from cablewright.calibration.poses.problem import StraightProblem
from cablewright.calibration.poses.simulation import SensorNoise, aligned, random_poses, simulate_calibration
from cablewright.foundation.errors import InputError
from cablewright.models.drum import WinchDrum
from cablewright.models.fidelity import Fidelity
from cablewright.models.rotation import placed
from cablewright.models.statics import Model
from cablewright.robot import Line, Robot, Swivel, load
from cablewright.solvers.inverse import solve_inverse
from cases import some
from out_of_plane import body, guided, point

HANGPRINTER = load("hangprinter-v4")


def several(robot: Robot) -> Robot:
    """The robot with lines of two or three spans, the latter with two cables side by side."""
    return changed(robot, lambda i, _: {"advantage": 2 + i % 2, "cables": 1 + i % 2})


def changed(robot: Robot, how: Callable[[int, Line], dict[str, object]]) -> Robot:
    lines = tuple(line.model_copy(update=how(i, line)) for i, line in enumerate(robot.lines))
    return Robot.model_validate(robot.model_copy(update={"lines": lines}).model_dump())


def over_wheels(robot: Robot) -> Robot:
    """The robot with wheels before its eyelets."""
    rng = np.random.default_rng(2)
    return changed(robot, lambda _, line: dict(guided(line, "wheels", 0, rng)))


ROBOTS = [HANGPRINTER, several(load("jung2020")), point("tilted"), body("tilted"), body("horizontal"), body("guides")]
ROBOTS.append(over_wheels(load("merlet2023")))
NAMES = ["hangprinter-v4", "several spans", "tilted", "tilted body", "horizontal axes", "guides", "wheels"]
GUIDED = ("pulleys", "aside", "platform sheaves", "platform pulleys")
ROBOTS += [make(kind) for kind in GUIDED for make in (point, body)] + [body("wheels")]
NAMES += [f"{kind}, {what}" for kind in GUIDED for what in ("point", "body")] + ["wheels of all kinds"]


@pytest.mark.parametrize("robot", ROBOTS, ids=NAMES)
def test_lengths_and_forces_are_those_of_rigid_statics(robot: Robot) -> None:
    """Lengths up to a constant: what the cable passes before its exit point."""
    held = solve_inverse(
        Model(robot, Fidelity.of("rigid")), random_poses(robot, 12, np.random.default_rng(3))
    ).checked()
    measured = Measured(np.zeros(held.lengths.shape), held.pose, tensions=held.tensions)
    problem = StraightProblem.of(robot, measured, CalibrationPlan(sigma=Sigmas(tension=1.0)))
    lengths = problem.lengths(problem.start, held.pose)
    assert np.ptp(held.lengths - lengths, axis=0) == pytest.approx(np.zeros(robot.m), abs=1e-12)
    left = problem.derivatives(problem.start, held.pose).residual[:, robot.m :]
    assert left == pytest.approx(np.zeros_like(left), abs=1e-8 * held.tensions.max())
    spoiled = StraightProblem.of(
        robot, Measured(measured.counted, held.pose, tensions=1.01 * held.tensions), problem.plan
    )
    mended = spoiled.balanced(spoiled.start, held.pose).derivatives(spoiled.start, held.pose).residual[:, robot.m :]
    assert mended == pytest.approx(np.zeros_like(mended), abs=1e-8 * held.tensions.max())


@pytest.mark.parametrize("robot", ROBOTS, ids=NAMES)
def test_derivatives_are_those_of_differences(robot: Robot) -> None:
    rng = np.random.default_rng(5)
    poses = random_poses(robot, 4, rng)
    names = ("exit_point", "length_offset", "length_scale", "build_up", "tension_offset", "tension_scale")
    names += () if any(line.is_aside for line in robot.lines) else ("exit_compliance",)
    names += ("sheave_radius",) if any(line.sheave.kind != "eyelet" for line in robot.lines) else ()
    names += ("platform_point",) if robot.n == 6 else ()
    measured = Measured(rng.uniform(-1.0, 1.0, (4, robot.m)), poses, tensions=rng.uniform(50.0, 200.0, (4, robot.m)))
    problem = StraightProblem.of(robot, measured, CalibrationPlan(unknowns=names))
    theta, step = problem.free + 0.01 * rng.standard_normal(len(problem.free)), 1e-6
    found = problem.derivatives(theta, poses)

    def slope(by_theta: np.ndarray, by_pose: np.ndarray) -> np.ndarray:
        ahead = problem.derivatives(theta + by_theta, poses + by_pose).residual
        return (ahead - problem.derivatives(theta - by_theta, poses - by_pose).residual) / (2 * step)

    for k in range(len(theta)):
        scale = 1e-9 / step * max(1.0, float(np.abs(found.by_unknown).max()))
        assert slope(step * np.eye(len(theta))[k], np.zeros(robot.n)) == pytest.approx(
            found.by_unknown[:, :, k], abs=scale
        )
    for c in range(3):  # rotations: see test_sensors
        scale = 1e-9 / step * max(1.0, float(np.abs(found.by_pose).max()))
        assert slope(np.zeros(len(theta)), step * np.eye(robot.n)[c]) == pytest.approx(
            found.by_pose[:, :, c], abs=scale
        )


def off(robot: Robot, plan: CalibrationPlan, **noise: float) -> tuple[str, float, float]:
    """Verdict, largest error of a coordinate of an exit point and sigma, m."""
    made = simulate_calibration(robot, 40, 1e-4, seed=1, sensors=SensorNoise(**noise))
    found = calibrate(robot, made.measured, plan, rough=0.05)
    file = np.array([line.exit_point for line in robot.lines])
    points, _ = aligned(found.problem.points(found.fit.theta), file)
    assert found.exit_sigma is not None
    return found.verdict, float(np.abs(points - file).max()), found.exit_sigma


def test_a_hangprinter_is_calibrated() -> None:
    """Two spans to each anchor: counts are of cable, exit points of the anchors."""
    verdict, error, sigma = off(HANGPRINTER, CalibrationPlan())
    assert verdict == "good"
    assert error < 4.0 * sigma < 5e-3


def test_an_unknown_of_the_spool_is_per_cable_paid_out() -> None:
    """A scale and a build-up of counts that are of cable, of which two spans take half."""
    made = simulate_calibration(HANGPRINTER, 60, 1e-5, seed=2)
    rate, scale = 0.01, 1.002
    counted = WinchDrum(scale, build_up=rate).angles(made.measured.counted)
    measured = Measured(counted, made.poses, np.full(made.poses.shape, 1e-3))
    plan = CalibrationPlan(
        unknowns=("exit_point", "length_offset", "length_scale", "build_up"), sigma=Sigmas(encoder=1e-5)
    )
    found = calibrate(HANGPRINTER, measured, plan, rough=0.05)
    for name, true in (("build_up", rate), ("length_scale", scale)):
        which = [each.name == name for each in found.unknowns]
        assert np.abs((found.values[which] - true) / found.sigma[which]).max() < 4.0
        assert found.sigma[which].max() < 1e-3


def test_swivels_of_any_axis_are_calibrated_where_points_are_surveyed() -> None:
    robot = point("tilted")
    points = tuple(Point(line=line.name, at=line.exit_point) for line in robot.lines[:3])
    _, error, sigma = off(robot, CalibrationPlan(points=points))
    assert error < 4.0 * sigma < 0.05


def test_all_motions_of_eyelets_are_named() -> None:
    """Tilts too, though they are not at right angles to the others where lines have several spans."""
    found = calibrate(HANGPRINTER, simulate_calibration(HANGPRINTER, 40, 1e-4, seed=1).measured)
    assert found.gauge == (*(f"translation along {axis}" for axis in "xyz"), "yaw", "tilt about x", "tilt about y")


def test_poses_are_chosen_for_several_spans() -> None:
    found = calibration_poses(HANGPRINTER, 16, candidates=100)
    lengths = solve_inverse(Model(HANGPRINTER, Fidelity.of("rigid")), found.poses).lengths
    assert found.counted == pytest.approx(lengths - lengths[0], abs=1e-12)


@pytest.mark.parametrize("robot", [point("tilted"), body("tilted"), body("horizontal")], ids=str)
def test_a_swivel_of_any_axis_has_its_angle_about_that_axis(robot: Robot) -> None:
    """From where world x points across it, by the right hand; computed by vectors of its own."""
    made = simulate_calibration(robot, 8, 0.0, seed=3, guess=0.0, sensors=SensorNoise(swivel=0.0))
    assert made.measured.swivel is not None
    points = placed(made.poses, [line.platform_point for line in robot.lines])
    for i, line in enumerate(robot.lines):
        axis = np.array(line.swivel_axis)
        away = points[:, i] - np.array(line.exit_point)
        first = np.eye(3)[0 if abs(axis[0]) < 0.9 else 1]
        first -= (first @ axis) * axis
        turn = np.arctan2(np.cross(first, away) @ axis, away @ first)
        assert made.measured.swivel[:, i] == pytest.approx(turn, abs=1e-12)


@pytest.mark.parametrize("robot", some([body("tilted"), body("horizontal")]), ids=str)
def test_angle_sensors_of_tilted_swivels_find_their_zeros(robot: Robot) -> None:
    points = tuple(Point(line=line.name, at=line.exit_point, deviation=1e-3) for line in robot.lines)
    plan = CalibrationPlan(
        unknowns=("exit_point", "length_offset", "swivel_offset"), points=points, sigma=Sigmas(encoder=1e-4)
    )
    zeros = np.random.default_rng(4).normal(0.0, math.radians(1.0), robot.m)
    made = simulate_calibration(robot, 24, 1e-4, seed=4, sensors=SensorNoise(swivel=1e-3)).measured
    found = calibrate(robot, replace(made, swivel=made.swivel - zeros), plan, rough=0.02, outliers=False)
    own = np.array([each.name == "swivel_offset" for each in found.unknowns])
    pulls = (found.values[own] - zeros) / found.sigma[own]
    assert np.abs(pulls).max() < 4.0
    assert found.sigma[own].max() < 2e-3
    theta, states = found.fit.theta, found.fit.poses
    by = found.problem.derivatives(theta, states)
    m = robot.m
    for at in range(len(theta)):
        step = 1e-6 * np.eye(len(theta))[at]
        two = [found.problem.derivatives(theta + way * step, states).residual[:, m : 2 * m] for way in (1.0, -1.0)]
        assert by.by_unknown[:, m : 2 * m, at] == pytest.approx((two[0] - two[1]) / 2e-6, abs=1e-3)


def test_swivels_that_hang_are_read_as_those_that_stand() -> None:
    """A cable that comes from below over an axis that points up is one from below against an axis that points down."""

    def hung(_: int, line: Line) -> dict[str, object]:
        assert isinstance(line.sheave, Swivel)
        wrap = "under" if line.sheave.wrap == "over" else "over"
        return {"sheave": line.sheave.model_copy(update={"axis": (0.0, 0.0, -1.0), "wrap": wrap})}

    wang = load("wang2021")
    measured = simulate_calibration(wang, 40, 1e-4, seed=1, sensors=SensorNoise(swivel=1e-3)).measured
    standing, hanging = (calibrate(robot, measured, rough=0.05) for robot in (wang, changed(wang, hung)))
    assert (standing.status, hanging.status) == ("ok", "ok")
    assert hanging.fit.theta == pytest.approx(standing.fit.theta, abs=1e-8)


def test_counts_of_several_spans_may_be_as_long_as_they_are() -> None:
    """Six diagonals of the frame with three spans are no mm."""
    robot = several(load("jung2020"))
    diagonal = float(np.linalg.norm(np.subtract(robot.scene.frame_max, robot.scene.frame_min)))
    counted = np.zeros((3, robot.m))
    counted[1, 1] = 8.0 * diagonal  # line 1 has three spans
    with pytest.raises(InputError, match="poses; at least"):
        calibrate(robot, Measured(counted, np.zeros((3, robot.n))))
    counted[1, 0] = 8.0 * diagonal  # line 0 has two
    with pytest.raises(InputError, match="are these mm"):
        calibrate(robot, Measured(counted, np.zeros((3, robot.n))))
