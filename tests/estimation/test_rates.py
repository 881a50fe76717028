"""Sensors at rates that do not fit each other, and walls that leave a direction open."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Command, Scan, SensorFrame
from cablewright.live.estimator_settings import OBSERVERS
from cablewright.machine.simulated.settings import TwinSettings
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.robot import load
from observer_runs import drive, errors, observe
from twins import SETTINGS, TWIN, changed, machine

ROBOT = load("merlet2023")


def at_odd_rates() -> TwinSettings:
    """Each a whole number of steps, else the machine rejects it; none divides another."""
    turns = {"north": 0.93, "south": 0.57, "vertical": 1.31}
    lidars = {name: lidar.model_copy(update={"turn": turns[name]}) for name, lidar in SETTINGS.lidars.items()}
    rates = {"inertial": 0.03, "line_angles": 0.31, "distance": 1.43, "encoders": 0.07}
    odd = changed(**{name: {"rate": 1.0 / every} for name, every in rates.items()})
    return odd.model_copy(update={"lidars": lidars})


@pytest.mark.parametrize(("estimator", "most"), [("paper", 0.03), ("filter", 0.015)])
def test_rates_that_fit_nothing_are_lived_with(estimator: str, most: float) -> None:
    settings = at_odd_rates()
    recording = drive(16.0, settings, seed=2)
    found = observe(recording, settings, estimator=estimator)
    assert errors(found, recording, 6.0).max() < most
    assert all(estimate.valid for estimate, (frame, _) in zip(found, recording, strict=True) if frame.time > 6.0)
    assert not found[-1].faults


@pytest.mark.parametrize("estimator", ["paper", "filter"])
def test_where_the_drum_stands_a_first_place_is_found_from_turns_that_come_late(estimator: str) -> None:
    """As in steps of a second, through which clocks that drift apart move the ends of turns."""
    twin = TWIN.with_simulation(quasi_static_period=1.0)  # so that turns end with each step
    built = SimulatedMachine(ROBOT, twin, np.array([0.3, -0.4, 1.2]), seed=5, plant="quasi-static")
    observer = OBSERVERS[estimator]
    settings = observer.settings(ROBOT, twin.owner, ())
    state = observer.start(settings)
    for _ in range(20):
        frame = built.step(Command(built.time, np.zeros(ROBOT.m)))
        late = (dataclasses.replace(r, begin=r.begin - 0.8) if isinstance(r, Scan) else r for r in frame.readings)
        found = observer.step(settings, state, SensorFrame(frame.time, tuple(late)))
    assert found.valid
    assert np.linalg.norm(found.position - built.truth.position) < 0.02


def test_the_estimator_keeps_coordinates_along_parallel_walls() -> None:
    """Without the north wall only east and west bound the place: along them encoders lead."""

    def open_to_the_north(reading: Any) -> Any:
        if not (isinstance(reading, Scan) and reading.source == "north" and reading.begin > 5.0):
            return reading
        away = np.abs(np.remainder(reading.angles, 2.0 * np.pi) - 0.5 * np.pi) < 0.7
        return dataclasses.replace(reading, ranges=np.where(away, np.nan, reading.ranges))

    recording = drive(14.0, seed=2)
    recording = [
        (SensorFrame(f.time, tuple(map(open_to_the_north, f.readings)), f.notices), truth) for f, truth in recording
    ]
    found = observe(recording)
    late = found[-1]
    assert any("parallel" in fault.sentence or "direction" in fault.sentence for fault in late.faults)
    assert late.valid
    off = np.array([e.position - t.position for e, (f, t) in zip(found, recording, strict=True) if f.time > 6.0])
    assert np.abs(off[:, 0]).max() < 0.02
    assert np.abs(off[:, 1]).max() < 0.06


def test_a_rate_that_no_step_meets_is_rejected() -> None:
    with pytest.raises(
        InputError, match=r"^inertial\.rate = 37 Hz: .* no whole number of the machine's steps, 0\.01 s"
    ):
        machine(changed(inertial={"rate": 37.0}))
