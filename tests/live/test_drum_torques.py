"""A motor of a drum with several lines shows the pull of all: the estimator of a body reads that where no cell does."""

from __future__ import annotations

import numpy as np
import pytest

import shared_winch_robots
from cablewright.estimation.body import filter as of_body
from cablewright.estimation.body import measurement
from cablewright.estimation.body.correction import _go_to
from cablewright.estimation.body.settings import BodySettings
from cablewright.estimation.body.state import BodyState, start
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Encoders, SensorFrame, Tensions, frozen
from cablewright.live.body_estimator import body_settings
from cablewright.live.serve.operated_machines import resting_pose
from cablewright.machine.sensors.tensions import TensionSensor
from cablewright.machine.simulated.machine_file import built_machine
from cablewright.models.statics import Model
from cablewright.models.winch_lines import WinchLines
from cablewright.robot import Robot
from cablewright.solvers.forward import solve_forward

MOTORS = TensionSensor(rate=100.0, deviation=0.2, gain_deviation=1e-3, most=1e3)
UNREAD = frozen(np.full(6, np.nan))


def known() -> tuple[Robot, BodySettings, BodyState]:
    """Three pairs of lines, each on one drum, with motors alone; at home."""
    robot = shared_winch_robots.pairs()
    owner = built_machine(robot)[0].with_owner(load_cells=None, inertial=None, motor_torques=MOTORS).owner
    settings = body_settings(robot, owner, sensors=True)
    return robot, settings, start(settings, resting_pose(robot, np.array([0.1, 0.05, 0.9])))


def read(settings: BodySettings, state: BodyState, torques: Array, steps: int) -> None:
    """Read them at rest, in *steps* of 10 ms."""
    begin = max(state.latest.time, 0.0)
    for k in range(1, steps + 1):
        now = begin + 0.01 * k
        shown = Tensions("motor_torques", now, UNREAD, frozen(torques))
        of_body.step(settings, state, SensorFrame(now, (Encoders(now, np.zeros(3, np.int64)), shown)))


def torques_of(robot: Robot, state: BodyState, tensions: Array) -> Array:
    arms = np.array([line.cables for line in robot.lines]) * state.wound.drums.arms.repeat(2)
    return WinchLines.of(robot).torques(tensions, arms)


def test_torques_of_drums_show_what_the_platform_weighs() -> None:
    robot, settings, state = known()
    read(settings, state, np.zeros(3), 1)  # the drums' arms are known from here
    heavy = robot.model_copy(update={"platform": robot.platform.model_copy(update={"mass": 1.01 * 12.0})})
    held = solve_forward(Model(heavy), state.lengths, guess=state.pose).checked()
    sigma = np.sqrt(np.diag(state.belief.covariance)[state.layout.load][2])
    read(settings, state, torques_of(robot, state, held.tensions), 200)
    load = state.belief.unknowns[state.layout.load]
    assert load[2] == pytest.approx(-0.01 * 12.0 * 9.81, rel=0.35)
    assert np.sqrt(np.diag(state.belief.covariance)[state.layout.load][2]) < 0.5 * sigma
    shown = state.wound.drums.per_tension @ state.tensions
    assert shown == pytest.approx(state.wound.drums.per_tension @ held.tensions, rel=2e-3)
    assert not state.judged.danger


def test_each_number_moves_the_pull_on_a_drum_as_its_gradient_says() -> None:
    robot, settings, state = known()
    read(settings, state, np.zeros(3), 1)
    read(settings, state, torques_of(robot, state, state.tensions), 5)
    slopes = measurement.slopes_of(state)
    assert slopes is not None
    found = measurement.measurement_of(settings, state, slopes, 0.0)
    assert found is not None
    assert found.rows.tolist() == [6, 7, 8]  # after those of the lines, which nothing reads
    assert not len(found.cells)
    layout, before, base = state.layout, state.belief.unknowns.copy(), measurement.predictions(settings, state)
    for column, step in (
        (layout.home.start + 3, 1e-5),
        (layout.radius.start + 2, 1e-5),
        (layout.gain.start + 2, 1e-3),
        (layout.zero.start + 4, 1e-2),
        (layout.load.start + 2, 1e-2),
    ):
        unknowns = before.copy()
        unknowns[column] += step
        assert _go_to(settings, state, unknowns)
        moved = (measurement.predictions(settings, state) - base)[found.rows] / step
        assert moved == pytest.approx(found.gradients[:, column], rel=0.02, abs=1e-6 + 1e-4 * abs(moved).max())


def test_a_reading_without_torques_of_drums_changes_nothing() -> None:
    _, settings, state = known()
    for torques in (None, frozen(np.zeros(2))):
        for k in range(30):
            now = 0.01 * k + (10.0 if torques is not None else 0.0)
            shown = Tensions("motor_torques", now, UNREAD, torques)
            estimate = of_body.step(settings, state, SensorFrame(now, (Encoders(now, np.zeros(3, np.int64)), shown)))
        assert np.isfinite(estimate.position).all()
    assert not state.belief.unknowns.any()
