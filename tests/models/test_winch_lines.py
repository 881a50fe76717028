"""Torques of drums and tensions of their lines: the nearest ones that give the torques, by least squares as oracle."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize

import shared_winch_robots
from cablewright.foundation.signals import Command, Tensions
from cablewright.live.serve.operated_machines import resting_pose
from cablewright.machine.sensors.tensions import TensionSensor
from cablewright.machine.simulated.machine_file import built_machine
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.models.winch_lines import WinchLines
from cablewright.robot import load


def test_torques_come_back_from_the_nearest_tensions() -> None:
    random = np.random.default_rng(5)
    for robot in (
        shared_winch_robots.pairs(),
        shared_winch_robots.hoist(),
        shared_winch_robots.two_on_one("against"),
        load("cogiro"),
    ):
        lines = WinchLines.of(robot)
        arms, expected = random.uniform(0.03, 0.05, robot.m), random.uniform(10.0, 90.0, robot.m)
        torques = random.uniform(1.0, 4.0, robot.winches)
        found = lines.tensions(torques, arms, expected)
        np.testing.assert_allclose(lines.torques(found, arms), torques, rtol=1e-12)
        held = list(robot.hung)
        np.testing.assert_array_equal(found[held], expected[held])
        if lines.plain:
            np.testing.assert_allclose(found, torques / arms, rtol=1e-12)
            continue
        told = {"type": "eq", "fun": lambda t, a=arms, w=lines, of=torques: w.torques(t, a) - of}
        nearest = minimize(lambda t, e=expected: ((t - e) ** 2).sum(), expected, constraints=told)
        np.testing.assert_allclose(found, nearest.x, atol=1e-4)


def test_what_is_not_known_of_some_lines_leaves_the_others_as_they_are() -> None:
    for robot in (shared_winch_robots.crane(), shared_winch_robots.pairs(), shared_winch_robots.two_on_one("against")):
        lines, arms = WinchLines.of(robot), np.linspace(0.03, 0.05, robot.m)
        torques = np.linspace(1.0, 4.0, robot.winches)
        found = lines.tensions(torques, arms, np.full(robot.m, np.nan))
        own = lines.alone
        np.testing.assert_allclose(found[own], torques[lines.winch[own]] / arms[own])
        assert np.isnan(found[~own]).all()
        first = np.where(lines.winch == 0, np.nan, 50.0)
        assert np.isnan(lines.torques(first, arms)).tolist() == [True] + [False] * (robot.winches - 1)


def test_a_drum_that_pays_one_line_out_as_it_winds_another_up_is_opposed() -> None:
    found = {winds: WinchLines.of(shared_winch_robots.two_on_one(winds)) for winds in ("along", "against")}
    assert found["along"].opposed.tolist() == [False]
    assert found["against"].opposed.tolist() == [True]
    arms = np.array([0.04, 0.04])
    assert found["along"].torques(np.array([50.0, 20.0]), arms).tolist() == [2.8]
    np.testing.assert_allclose(found["against"].torques(np.array([50.0, 20.0]), arms), [1.2])


def test_a_motor_reads_the_torque_of_all_cables_on_its_drum() -> None:
    for robot, place in (
        (shared_winch_robots.pairs(), [0.1, 0.05, 0.9]),
        (shared_winch_robots.hoist(), [0.1, 0.05, 0.8]),
    ):
        twin = built_machine(robot)[0].with_owner(motor_torques=TensionSensor(rate=100.0, deviation=0.0, most=1e4))
        machine = SimulatedMachine(robot, twin, resting_pose(robot, np.array(place)), seed=1)
        readings = []
        for _ in range(12):
            frame = machine.step(Command(machine.time, np.zeros(robot.winches)))
            readings += [each for each in frame.of(Tensions) if each.source == "motor_torques"]
        lines, told, truth = WinchLines.of(robot), readings[-1], machine.truth
        assert told.torques is not None
        shown = lines.torques(truth.tensions, truth.radii)
        np.testing.assert_allclose(told.torques, shown, rtol=0.06)  # as built: gains, zeros and friction
        assert np.isnan(told.tensions).tolist() == (~lines.alone).tolist()
