"""Lines that stretch and sag: found from measured poses, through the one linearisation."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.calibration.elastic import calibrate_elastic
from cablewright.calibration.plan import Plan, Sigmas
from cablewright.calibration.problem import Measured
from cablewright.calibration.simulation import random_poses
from cablewright.errors import InputError
from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import Robot, load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse


def machine(
    robot: Robot, cable: str, count: int, noise: float, factor: float, seed: int
) -> tuple[Measured, np.ndarray]:
    """Measurements of a robot whose cables are *factor* times as stiff; and its home lengths."""
    rng = np.random.default_rng(seed)
    model = Model(robot, Fidelity.of(cable))
    asked = random_poses(robot, count, rng)
    lengths = solve_inverse(model, asked).checked().lengths
    held = solve_forward(model, lengths, guess=asked, modulus_factors=np.full(robot.m, factor)).checked()
    counted = lengths - lengths[0] + rng.normal(0.0, noise, lengths.shape)
    sigma = np.full(asked.shape, max(noise, 1e-4))
    return Measured(counted, held.pose + rng.normal(0.0, noise, held.pose.shape), sigma), lengths[0]


@pytest.mark.parametrize(
    ("name", "cable"), [("merlet2023", "catenary"), ("wang2021", "elastic"), ("cogiro", "catenary")]
)
def test_modulus_and_geometry_are_found(name: str, cable: str) -> None:
    robot = load(name)
    measured, home = machine(robot, cable, 30, 0.0, 0.8, 3)
    off = np.random.default_rng(1).uniform(-5e-3, 5e-3, (robot.m, 3))
    lines = tuple(
        line.model_copy(update={"exit_point": tuple(np.add(line.exit_point, by).tolist())})
        if line.winch_exit is None
        else line
        for line, by in zip(robot.lines, off, strict=True)
    )
    names = ("exit_point", "length_offset", "modulus")
    plan = Plan(unknowns=names, shared=("modulus",), sigma=Sigmas(encoder=1e-4))
    found = calibrate_elastic(robot.model_copy(update={"lines": lines}), measured, plan, cable)
    assert found.status == "ok"
    assert found.gauge == ()
    exits = found.values[: 3 * robot.m].reshape(-1, 3)
    assert np.abs(exits - [line.exit_point for line in robot.lines]).max() < 1e-6
    assert np.abs(found.values[3 * robot.m : -1] - home).max() < 1e-6
    assert found.values[-1] == pytest.approx(0.8, abs=1e-5)


def test_sigmas_are_of_the_size_of_the_errors() -> None:
    robot = load("merlet2023")
    shares = []
    for seed in range(6):
        measured, home = machine(robot, "elastic", 25, 1e-3, 1.0, seed)
        plan = Plan(sigma=Sigmas(encoder=1e-3))
        found = calibrate_elastic(robot, measured, plan, "elastic")
        truth = np.append(np.array([line.exit_point for line in robot.lines]).ravel(), home)
        shares.append(np.abs(found.values - truth) / found.sigma)
    assert np.mean(np.array(shares) < 1.0) == pytest.approx(0.68, abs=0.17)


def test_without_measured_poses_nothing_is_left_over() -> None:
    robot = load("wang2021")
    measured, _ = machine(robot, "elastic", 20, 0.0, 1.0, 1)
    with pytest.raises(InputError, match="need measured poses"):
        calibrate_elastic(robot, Measured(measured.counted, measured.guess), cable="elastic")
