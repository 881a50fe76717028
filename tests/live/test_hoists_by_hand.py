"""Hoists and pairs of lines on one winch are operated: jogged by hand, and shown on the page by winches."""

from __future__ import annotations

import json

import numpy as np
import pytest

import shared_winch_robots
from cablewright.foundation.signals import Order, OrderKind, PrintState
from cablewright.live.serve.operated_machines import SimulatedStation, resting_pose
from cablewright.live.serve.status import told_sitting
from cablewright.machine.simulated.machine_file import built_machine
from cablewright.robot import Robot


@pytest.mark.parametrize("robot", [shared_winch_robots.hoist(), shared_winch_robots.pairs()], ids=["hoist", "pairs"])
def test_a_jog_moves_the_platform_by_orders_to_its_winches(robot: Robot) -> None:
    place = np.array([0.0, 0.1, 0.8])
    station = SimulatedStation(robot, built_machine(robot)[0], 0, resting_pose(robot, place))
    sitting = station.sitting(None)
    told = json.loads(told_sitting(1, sitting, None, None))
    assert [told["lines"][i] for i in told["hosts"]] == list(robot.winch_names)
    assert told["winches"] == ([0, 1, 2, -1] if robot.name == "hoist" else [0, 0, 1, 1, 2, 2])
    assert station._last is not None
    machine, printer = station._last
    printer.machine = machine  # without the pace of the clock
    for _ in range(5):
        printer.step()
    printer.step((Order(OrderKind.RESET, time=printer.time),))
    for _ in range(5):
        printer.step()
    printer.step((Order(OrderKind.ENABLE, time=printer.time),))
    for _ in range(5):
        printer.step()
    assert printer.supervisor.state is PrintState.IDLE
    before, speeds = machine.truth.position, np.zeros(robot.winches)
    for _ in range(150):
        up = Order(OrderKind.JOG, time=printer.time, arguments={"velocity": (0.0, 0.0, 0.05)})
        step = printer.step((up,))
        assert step.command.winch_speeds.shape == (robot.winches,)
        speeds = np.minimum(speeds, step.command.winch_speeds)
    assert (speeds < 0.0).all()
    for _ in range(60):
        printer.step()
    moved = machine.truth.position - before
    assert 0.04 < moved[2] < 0.09
    assert np.abs(moved[:2]).max() < 5e-3
    assert printer.supervisor.state is PrintState.IDLE
