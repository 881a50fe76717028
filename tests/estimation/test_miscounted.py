"""Readings of another number of lines or winches than the robot has: no estimator by encoders uses them."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.foundation.signals import Encoders, SensorFrame, Tensions
from cablewright.live.estimators import estimator
from cablewright.live.rest_pose import rest_pose
from cablewright.machine.sensors.tensions import TensionSensor
from cablewright.machine.simulated.settings import whole_machine
from cablewright.robot import load

CELLS = TensionSensor(rate=10.0, deviation=3.0, bias=3.0, gain_deviation=0.005, most=1e4)


@pytest.mark.parametrize("name", ["house-printer", "cogiro"])
def test_a_reading_of_another_number_of_lines_raises_nothing_and_changes_nothing(name: str) -> None:
    robot, owner = load(name), whole_machine(name).with_owner(load_cells=CELLS).owner
    found = estimator("encoders", robot, owner, np.array(rest_pose(robot).equilibrium.pose))
    pulls, counts = np.full(robot.m, 50.0), np.zeros(robot.winches, np.int64)
    first = found.step(SensorFrame(1.0, (Encoders(1.0, counts), Tensions("load_cells", 1.0, pulls))))
    wrong = Encoders(1.1, counts[:3] + 900), Tensions("load_cells", 1.1, pulls[:3])
    then = found.step(SensorFrame(1.1, wrong))
    np.testing.assert_allclose(then.position, first.position, atol=1e-9)
    assert any("a reading of 3 winches" in fault.sentence for fault in then.faults)
    assert found.tensions is not None
    assert len(found.tensions) == robot.m
