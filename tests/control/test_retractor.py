"""The drive of a retraction: it follows its schedule within speed and stroke."""

from __future__ import annotations

import math

import pytest

from cablewright.control import retraction
from cablewright.control.retraction import BeamSettings, BeamState
from cablewright.robot import load

ROBOT = load("jung2020")
SETTINGS = BeamSettings.of(ROBOT, 0.02)


@pytest.mark.parametrize("length", [1.2, 1.2003, 1.6, 1.99999, 2.0])
@pytest.mark.parametrize("target", [1.2, 1.7, 2.0])
@pytest.mark.parametrize("rate", [-0.02, 0.0, 0.013])
@pytest.mark.parametrize("dt", [0.01, 0.2, 1.0])
def test_a_step_stays_within_speed_and_stroke(length: float, target: float, rate: float, dt: float) -> None:
    """The next length is one that the robot has, whatever is asked."""
    moved = retraction.step(SETTINGS, BeamState(length), target, rate, dt)
    assert abs(moved.speed) <= SETTINGS.max_speed
    ROBOT.retraction_to(moved.length + dt * moved.speed)


@pytest.mark.parametrize("begin", [1.2, 2.0])
def test_it_reaches_its_target_and_stands(begin: float) -> None:
    state = BeamState(begin)
    for _ in range(600):
        state.length += 0.2 * retraction.step(SETTINGS, state, 1.63, 0.0, 0.2).speed
    assert state.length == pytest.approx(1.63, abs=3e-4)
    assert retraction.step(SETTINGS, state, 1.63, 0.0, 0.2).speed == 0.0
    assert retraction.step(SETTINGS, state, math.nan, 0.0, 0.2).speed == 0.0
