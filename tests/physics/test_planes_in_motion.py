"""A platform that moves in a plane: the force on it, modes, time reversal, and a plane that only pushes."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import cablewright as cw
import planar_robots
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Command, Condition, frozen
from cablewright.kernels.plant import dynamics
from cablewright.kernels.plant.dynamics import INERTIA, MASS, RATE, TURN, VELOCITY
from cablewright.live.estimators import estimator
from cablewright.machine.simulated.machine_file import machine_file
from cablewright.machine.simulated.settings import load_twin
from cablewright.robot import Robot

Array = NDArray[np.float64]
KINDS = [("vertical", False), ("tilted", True)]
G = 9.81


class Sliding:
    """The platform of a board on lines of fixed lengths, without drag."""

    def __init__(self, robot: Robot, pose: Array) -> None:
        self.held = cw.inverse(robot, pose).checked()
        self.model, self.lengths, self.states = self.held.model, self.held.lengths, self.held.states.copy()
        self.body, self.motion = np.zeros(dynamics.BODY), np.zeros(dynamics.MOTION)
        self.body[MASS], self.body[INERTIA : INERTIA + 9] = planar_robots.MASS, np.diag([0.1, 0.12, 0.14]).ravel()
        self.motion[[0, 1, 2, 6, 7, 8][: robot.n]] = self.held.pose
        self.work, self.swing = dynamics.moving_workspace(self.model.packed)

    def step(self, dt: float) -> None:
        both = (self.lengths, self.lengths)
        arrays = (self.model.packed, self.body, self.motion, *both, dt, self.states, self.work, self.swing)
        assert dynamics.midpoint_step(*arrays) == 0


@pytest.mark.parametrize(("plane", "body"), KINDS)
def test_force_on_the_plane_at_rest_is_that_of_the_balance(plane: str, body: bool) -> None:
    robot = planar_robots.board(plane, body)
    sliding = Sliding(robot, planar_robots.places(robot, 1)[0])
    sliding.step(1e-3)
    assert sliding.swing.on_plane[0] == pytest.approx(float(sliding.held.plane_force), rel=1e-7)
    np.testing.assert_allclose(sliding.motion[VELOCITY : VELOCITY + 3], 0.0, atol=1e-9)


@pytest.mark.parametrize(("plane", "body"), KINDS)
def test_force_on_the_plane_gives_the_acceleration_across_it(plane: str, body: bool) -> None:
    """Without the plane the same lines accelerate the platform off it by that force over its mass."""
    robot, loose = (planar_robots.board(plane, body, held=held) for held in (True, False))
    pose, n = planar_robots.places(robot, 1)[0], planar_robots.frame(robot)[2]
    sliding, free = Sliding(robot, pose), Sliding(robot, pose)
    free.model = cw.Model(loose)
    free.work, free.swing = dynamics.moving_workspace(free.model.packed)
    for each in (sliding, free):
        each.step(1e-5)
    across = free.motion[VELOCITY : VELOCITY + 3] @ n / 1e-5
    assert sliding.swing.on_plane[0] == pytest.approx(planar_robots.MASS * across, rel=2e-3)


@pytest.mark.parametrize(("plane", "body"), KINDS)
def test_it_stays_in_the_plane_and_goes_back_as_it_came(plane: str, body: bool) -> None:
    robot = planar_robots.board(plane, body)
    a, b, n = planar_robots.frame(robot)
    sliding = Sliding(robot, planar_robots.places(robot, 1)[0])
    start = sliding.motion.copy()
    sliding.motion[VELOCITY : VELOCITY + 3] = 0.1 * a - 0.05 * b
    if body:
        sliding.motion[RATE : RATE + 3] = 0.4 * n
    for _ in range(200):
        sliding.step(1e-3)
        turn = sliding.motion[TURN : TURN + 3]
        assert sliding.motion[:3] @ n == pytest.approx(planar_robots.DISTANCE, abs=1e-11)
        np.testing.assert_allclose(turn - (turn @ n) * n, 0.0, atol=1e-11)
    assert np.linalg.norm(sliding.motion[:3] - start[:3]) > 1e-3
    sliding.motion[[3, 4, 5, 9, 10, 11]] *= -1.0
    for _ in range(200):
        sliding.step(1e-3)
    np.testing.assert_allclose(sliding.motion[[0, 1, 2, 6, 7, 8]], start[[0, 1, 2, 6, 7, 8]], atol=1e-8)


@pytest.mark.parametrize(("plane", "body"), KINDS)
def test_it_swings_at_the_frequency_of_its_first_mode(plane: str, body: bool) -> None:
    robot = planar_robots.board(plane, body)
    sliding = Sliding(robot, planar_robots.places(robot, 1)[0])
    found = cw.modes(sliding.held)
    frequency, shape = float(found.frequencies[0]), found.shapes[:, 0]
    push = 1e-4 * shape / np.linalg.norm(shape)
    sliding.motion[[3, 4, 5, 9, 10, 11][: robot.n]] = push
    period, steps = 1.0 / frequency, 400
    for _ in range(steps):
        sliding.step(period / steps)
    np.testing.assert_allclose(sliding.motion[[3, 4, 5, 9, 10, 11][: robot.n]], push, atol=2e-3 * 1e-4)


def _machine_of(robot: Robot, tmp_path, plant: str = "dynamic") -> cw.SimulatedMachine:
    file = tmp_path / "machine.toml"
    file.write_text(machine_file(robot))
    return cw.SimulatedMachine(robot, load_twin(file), planar_robots.places(robot, 1)[0], seed=1, plant=plant)


def _wound(robot: Robot, **plane: object) -> Robot:
    """The board with the data of a winch, and a plane with other values."""
    table = robot.model_dump(by_alias=True)
    table["platform"]["plane"] |= plane
    for line in table["lines"]:
        line["cable"]["diameter"], line["winch"] = 2e-3, {"drum_radius": 0.03}
    return Robot.model_validate(table)


@pytest.mark.parametrize("plant", ["dynamic", "quasi-static"])
def test_a_plane_that_only_pushes_reports_what_lifts_off(plant: str, tmp_path) -> None:
    """The lines run to points 0.05 m off the board, and pull the platform off it unless a force presses it on."""
    for press, lifts in ((-200.0, False), (200.0, True)):
        across = tuple(press * planar_robots.axes(planar_robots.PLANES["vertical"])[2])
        robot = _wound(planar_robots.board(force=across), one_sided=True)
        machine = _machine_of(robot, tmp_path, plant)
        frame = machine.step(Command(0.0, frozen(np.zeros(robot.m))))
        assert (Condition.OFF_PLANE in {notice.condition for notice in frame.notices}) == lifts
        both = _machine_of(_wound(robot, one_sided=False), tmp_path, plant)
        assert not both.step(Command(0.0, frozen(np.zeros(robot.m)))).notices


def test_estimator_by_encoders_follows_lengths_in_the_plane(tmp_path) -> None:
    robot = _wound(planar_robots.board("tilted"))
    machine = _machine_of(robot, tmp_path)
    found = estimator("encoders", robot, machine.settings, planar_robots.places(robot, 1)[0])
    for k in range(30):
        frame = machine.step(Command(0.01 * k, frozen(np.array([0.2, 0.1, -0.2, -0.1]))))
        estimate = found.step(frame)
    assert estimate.valid
    assert robot.platform.plane.height(estimate.position) == pytest.approx(0.0, abs=1e-9)
    assert np.linalg.norm(estimate.position - machine.truth.position) < 5e-3
    with pytest.raises(InputError, match="estimator = filter: is only for a platform that does not move in a plane"):
        estimator("filter", robot, machine.settings, planar_robots.places(robot, 1)[0])
