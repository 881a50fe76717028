"""Simulated machines that tests share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from cablewright.foundation.signals import Command, Reading
from cablewright.machine.log.head import LogHead
from cablewright.machine.simulated.settings import TwinSettings, load_twin
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.robot import Robot, load

START = (0.3, -1.0, 1.2)
TWIN = load_twin("merlet2023")
SETTINGS, SIMULATION = TWIN.owner, TWIN.simulation


def changed(settings: TwinSettings = TWIN, /, **tables: dict[str, Any]) -> TwinSettings:
    """The settings with some keys of some tables changed, each where its part of the file has it."""
    owner, simulation = {}, {}
    for name, keys in tables.items():
        table = getattr(settings.owner, name, None)
        known = set() if table is None else type(table).model_fields.keys() & keys.keys()
        if known:
            owner[name] = table.model_copy(update={key: keys[key] for key in known})
        rest = {key: value for key, value in keys.items() if key not in known}
        if rest:
            table = getattr(settings.simulation, name)
            assert rest.keys() <= type(table).model_fields.keys(), name
            simulation[name] = table.model_copy(update=rest)
    return settings.with_owner(**owner).with_simulation(**simulation)


def head(
    settings: TwinSettings = TWIN,
    plant: str = "dynamic",
    seed: int = 1,
    *,
    period: float | None = None,
    robot: Robot | None = None,
) -> LogHead:
    """The head of a log of such a machine."""
    owner, simulation = settings.owner, settings.simulation
    usual = owner.period if plant == "dynamic" else simulation.quasi_static_period
    told = robot or load("merlet2023")
    return LogHead(told, owner, period or usual, simulation=simulation, plant=plant, seed=seed)


def perfect(settings: TwinSettings = TWIN) -> TwinSettings:
    """Without errors of sensors and links."""
    bare = {"deviation": 0.0, "bias": 0.0, "resolution": 1e-12}
    lidars = {name: lidar.model_copy(update=bare) for name, lidar in settings.owner.lidars.items()}
    silent = {"latency": 0.0, "jitter": 0.0, "loss": 0.0}
    made = changed(
        settings,
        wifi=silent,
        wire=silent,
        line={"vibration": 0.0},
        line_angles={"deviation": 0.0, "dropout": 0.0, "outliers": 0.0},
        distance={"deviation": 0.0, "dropout": 0.0, "outliers": 0.0},
        inertial={
            "acceleration_deviation": 0.0,
            "acceleration_bias": 0.0,
            "rate_deviation": 0.0,
            "rate_bias": 0.0,
            "dropout": 0.0,
        },
    )
    return made.with_owner(lidars=lidars).with_simulation(lidars={})


def machine(
    settings: TwinSettings = TWIN, seed: int = 1, plant: str = "dynamic", start: Any = START
) -> SimulatedMachine:
    return SimulatedMachine(load("merlet2023"), settings, start, seed=seed, plant=plant)


def run(
    moved: SimulatedMachine,
    steps: int,
    speeds: Any = (0.0, 0.0, 0.0, 0.0),
    valve: float = 0.0,
    each: Callable[[Any], None] | None = None,
) -> list[Reading]:
    """All readings of so many steps at one command."""
    readings: list[Reading] = []
    for _ in range(steps):
        frame = moved.step(Command(moved.time, np.array(speeds), valve))
        readings += frame.readings
        if each is not None:
            each(frame)
    return readings
