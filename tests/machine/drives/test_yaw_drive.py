"""A drive that turns a simulated drum about its axis: in series with the twist of the lines, within its limits."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Command, Condition
from cablewright.foundation.validation import validated
from cablewright.kernels.plant import dynamics
from cablewright.machine.carried_load import YawDrive
from cablewright.machine.files import machine_table
from cablewright.machine.settings import MachineSettings
from cablewright.machine.simulated.settings import TwinSettings
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.robot import load
from twins import SETTINGS, START, TWIN, changed, machine, run

STILL = {"yaw_wander": 0.0, "swing_damping": 150.0, "drag": 400.0}
DRIVE = YawDrive(max_speed=0.5, max_torque=2.0)


def with_drive(settings: TwinSettings = TWIN, **keys: float) -> TwinSettings:
    """A machine with a drive; *keys*: of it."""
    return changed(settings, drum={"yaw_drive": DRIVE.model_copy(update=keys)})


def turned(twin: SimulatedMachine, seconds: float, speed: float) -> list[Condition]:
    """Turn the drive at *speed*, rad/s; return the conditions that the machine reports."""
    told: list[Condition] = []
    for _ in range(round(seconds / twin.period)):
        frame = twin.step(Command(twin.time, np.zeros(4), outputs={"yaw": speed}))
        told += [notice.condition for notice in frame.notices if notice.subject == "yaw"]
    return told


def test_the_drum_follows_its_drive_as_a_pendulum_of_torsion() -> None:
    """After a step of the drive the yaw swings with the period and the damping of J y'' + c y' + k (y - a) = 0."""
    still = changed(drum=STILL | {"yaw_damping": 0.1}, climate={"swing": 0.0})
    twin = machine(with_drive(still, max_speed=100.0, max_torque=100.0))
    inertia = twin.rig.body[dynamics.INERTIA + 8]
    assert turned(twin, 0.01, 20.0) == []
    yaws = []
    for _ in range(round(20.0 / twin.period)):
        turned(twin, twin.period, 0.0)
        yaws.append(float(twin.truth.rotation[2]))
    decay, t = 0.1 / (2.0 * inertia), twin.period * (1.0 + np.arange(len(yaws)))
    rate = math.sqrt(1.0 / inertia - decay * decay)
    law = 0.2 * (1.0 - np.exp(-decay * t) * (np.cos(rate * t) + decay / rate * np.sin(rate * t)))
    np.testing.assert_allclose(yaws, law, atol=3e-3)
    assert np.linalg.norm(twin.truth.position - START) < 1e-3  # yaw does nothing to the lines of a point


@pytest.mark.parametrize("plant", ["dynamic", "quasi-static"])
def test_it_yields_at_its_torque_and_ends_at_its_travel(plant: str) -> None:
    still = changed(drum=STILL, climate={"swing": 0.0})
    twin = machine(with_drive(still, max_torque=0.05, travel=0.3), plant=plant)
    told = turned(twin, 30.0, 0.5)
    assert twin.rig.yaw.angle == pytest.approx(0.3)
    assert Condition.LIMITED in told
    assert Condition.STALLED in told
    assert twin.truth.rotation[2] == pytest.approx(0.3, abs=0.06)


def test_a_lag_delays_it_and_a_faster_order_is_cut() -> None:
    twin = machine(with_drive(lag=1.0))
    assert set(turned(twin, 1.0, 0.9)) == {Condition.LIMITED}
    assert twin.rig.yaw.speed == pytest.approx(0.5 * (1.0 - math.exp(-1.0)))
    turned(twin, 8.0, 0.0)
    stands = twin.rig.yaw.angle
    turned(twin, 1.0, 0.0)
    assert twin.rig.yaw.angle == pytest.approx(stands, abs=1e-3)


def test_a_drive_that_stands_changes_nothing_and_no_machine_without_one_takes_its_output() -> None:
    plain, driven = machine(), machine(with_drive())
    for each in (plain, driven):
        run(each, 200, (0.3, -0.2, 0.1, 0.0), 0.5)
    np.testing.assert_array_equal(driven.truth.rotation, plain.truth.rotation)
    np.testing.assert_array_equal(driven.truth.position, plain.truth.position)
    with pytest.raises(InputError, match="'yaw': the machine has no such output"):
        turned(plain, 0.01, 0.1)


def test_a_resumed_machine_continues_to_the_bit() -> None:
    settings = with_drive(lag=0.2)
    whole = machine(settings)
    turned(whole, 1.0, 0.2)
    kept = whole.snapshot()
    turned(whole, 1.0, 0.1)
    again = SimulatedMachine.resumed(load("merlet2023"), settings, kept, seed=1)
    turned(again, 1.0, 0.1)
    np.testing.assert_array_equal(again.truth.rotation, whole.truth.rotation)
    assert again.rig.yaw.angle == whole.rig.yaw.angle


def test_settings_are_checked() -> None:
    for keys in (
        {"max_torque": 0.0},
        {"max_speed": 0.0},
        {"travel": 0.0},
        {"travel": 7.0},
        {"held": 0.6},
        {"lag": -1.0},
    ):
        with pytest.raises(ValueError, match=next(iter(keys))):
            YawDrive.model_validate({"max_speed": 0.5, "max_torque": 2.0} | keys)
    assert SETTINGS.point_drum.yaw_drive is None
    table, origin = machine_table(Path(__file__).parents[3] / "examples/virtual-drives.toml")
    del table["simulation"]
    table["drum"]["yaw_drive"] = {"max_speed": 0.5, "max_torque": "2 N m"}
    with pytest.raises(InputError, match=r'drum\.yaw_drive: must be left out where kind is "canopen"'):
        validated(MachineSettings, table, origin)
