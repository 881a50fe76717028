"""Lines of several spans, and of several cables, that stretch."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan, Sigmas
from cablewright.calibration.poses.elastic import ElasticProblem
from cablewright.calibration.poses.simulation import SensorNoise, aligned, random_poses, simulate_calibration
from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import Robot, load
from cablewright.solvers.inverse import solve_inverse


def several(robot: Robot) -> Robot:
    """The robot with lines of two or three spans, the latter with two cables side by side."""
    lines = (
        line.model_copy(update={"advantage": 2 + i % 2, "cables": 1 + i % 2}) for i, line in enumerate(robot.lines)
    )
    return Robot.model_validate(robot.model_copy(update={"lines": tuple(lines)}).model_dump())


@pytest.mark.parametrize("name", ["hangprinter-v4", "jung2020"])
def test_derivatives_are_those_of_differences(name: str) -> None:
    robot = load(name) if name == "hangprinter-v4" else several(load(name))
    model = Model(robot, Fidelity.of("elastic"))
    held = solve_inverse(model, random_poses(model, 3, np.random.default_rng(3)))
    data = Measured(np.zeros((3, robot.m)), held.pose, tensions=held.tensions)
    problem = ElasticProblem.of(model, data, CalibrationPlan(unknowns=("exit_point", "length_offset", "modulus")))
    states, theta = problem.states_of(held), problem.free
    by = problem.derivatives(theta, states).by_unknown
    for at in range(len(theta)):
        step = 1e-6 * np.eye(len(theta))[at]
        ahead, behind = (problem.derivatives(theta + sign * step, states).residual for sign in (1.0, -1.0))
        assert (ahead - behind) / 2e-6 == pytest.approx(by[..., at], abs=1e-6 * np.abs(by).max())


def test_a_hangprinter_that_stretches_finds_its_modulus() -> None:
    robot = load("hangprinter-v4")
    made = simulate_calibration(robot, 30, 1e-4, seed=1, cable="elastic", sensors=SensorNoise(tension=0.5)).measured
    plan = CalibrationPlan(
        unknowns=("exit_point", "length_offset", "modulus"),
        shared=("modulus",),
        sigma=Sigmas(encoder=1e-4, tension=0.5),
    )
    found = calibrate(robot, made, plan, cable="elastic", rough=0.02, outliers=False)
    assert found.status == "ok"
    modulus = [each.name for each in found.unknowns].index("modulus")
    assert found.values[modulus] == pytest.approx(1.0, abs=3.0 * found.sigma[modulus])
    exits = np.array([line.exit_point for line in robot.lines])
    assert found.exit_sigma is not None
    assert np.abs(aligned(found.problem.points(found.fit.theta), exits)[0] - exits).max() < 3.0 * found.exit_sigma
