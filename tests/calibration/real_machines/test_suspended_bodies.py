"""Bodies that hang on few lines: gravity determines what lengths do not, by a survey that is not level."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from benchmarks.campaigns.twins import Twin, errors, joint, suspended

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan, Prior, Sigmas
from cablewright.calibration.poses.elastic import ElasticProblem
from cablewright.calibration.poses.simulation import SensorNoise, simulate_calibration
from cablewright.foundation.errors import InputError
from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.inverse import solve_inverse


@cache
def twin() -> Twin:
    """A machine with 12 poses."""
    return suspended(3, 12)


def test_a_suspended_body_finds_where_it_hangs() -> None:
    """Gravity 0.5 deg off the survey, zeros of all sensors off, centre of mass 5 mm off, lengths with 3 mm of noise."""
    found = calibrate(twin().file, twin().measured, twin().plan, rough=0.05, need=5e-3, cable="elastic")
    assert found.status == "ok"
    assert found.verdict != "bad"
    assert np.linalg.norm(found.poses[0, :3] - twin().start) < 15e-3
    assert np.median(errors(twin(), found, twin().counts)) < 12e-3
    assert joint(twin(), found)[0]
    centre = np.array([each.name == "centre_of_mass" for each in found.unknowns])
    assert centre.sum() == 3
    written = np.array(found.robot.platform.centre_of_mass)  # type: ignore[union-attr]
    assert written == pytest.approx(found.values[centre], abs=1e-12)


def test_poses_that_are_simulated_hang_in_balance() -> None:
    robot = load("grab-four-lines")
    made = simulate_calibration(robot, 5, 0.0, seed=1)
    held = solve_inverse(
        Model(robot, Fidelity.of("rigid")), np.hstack([made.poses[:, :3], np.full((5, 2), np.nan), made.poses[:, 5:]])
    )
    assert held.pose == pytest.approx(made.poses, abs=1e-6)


def test_straight_lines_say_that_gravity_would_determine_more() -> None:
    made = simulate_calibration(twin().file, 30, 1e-4, seed=2, sensors=SensorNoise(swivel=1e-3, pose=1e-3)).measured
    found = calibrate(twin().file, made, CalibrationPlan(), rough=0.02, outliers=False)
    assert any("--cable elastic" in each for each in found.notes)


def test_derivatives_by_centre_of_mass_and_exit_points_are_those_of_differences() -> None:
    robot = twin().file
    model = Model(robot, Fidelity.of("elastic"))
    made = simulate_calibration(model, 3, 0.0, seed=4, sensors=SensorNoise(swivel=0.0, tension=0.0, tilt=0.0)).measured
    plan = CalibrationPlan(unknowns=("exit_point", "length_offset", "centre_of_mass", "sheave_radius"))
    assert made.guess is not None
    problem = ElasticProblem.of(model, made, plan)
    held = solve_inverse(model, np.where(np.arange(6) < 3, made.guess, np.array([0, 0, 0, np.nan, np.nan, 0.0])))
    states = problem.states_of(held)
    theta = problem.free
    by = problem.derivatives(theta, states).by_unknown
    scale = np.abs(by).max()
    for at in range(len(theta)):
        step = 1e-6 * np.eye(len(theta))[at]
        ahead, behind = (problem.derivatives(theta + sign * step, states).residual for sign in (1.0, -1.0))
        assert (ahead - behind) / 2e-6 == pytest.approx(by[..., at], abs=2e-5 * scale)


def test_a_prior_up_to_a_tilt_leaves_the_tilt_open() -> None:
    file, poses = twin().file, np.zeros((3, 6))
    plan = CalibrationPlan(priors=(Prior(name="exit_point", deviation=1e-3, tilted=True),))
    problem = ElasticProblem.of(Model(file, Fidelity.of("elastic")), Measured(np.zeros((3, 4)), poses), plan)
    points = np.array([line.exit_point for line in file.lines])
    rows = problem.rows.linear[:, :12]
    arms = points - points.mean(axis=0)
    for axis, size in zip(np.eye(3), (0.0, 0.0, 1.0), strict=True):
        turned = np.cross(1e-3 * axis, arms).ravel()
        assert np.linalg.norm(rows @ turned) == pytest.approx(size * np.linalg.norm(turned) / 1e-3, abs=1e-9)
    with pytest.raises(ValueError, match="is of the exit_point of all lines"):
        Prior(name="build_up", deviation=1e-3, tilted=True)


def test_what_no_straight_line_depends_on_is_rejected() -> None:
    plan = CalibrationPlan(unknowns=("exit_point", "length_offset", "centre_of_mass"), sigma=Sigmas(encoder=1e-3))
    with pytest.raises(InputError, match="only equilibria depend on it"):
        calibrate(twin().file, twin().measured, plan)
