"""Simulated machines that tests share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from cablewright.machine.simulated.settings import MachineSettings, load_machine
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.robot import load
from cablewright.signals import Command, Reading

START = (0.3, -1.0, 1.2)
SETTINGS = load_machine("merlet2023")


def changed(settings: MachineSettings = SETTINGS, /, **tables: dict[str, Any]) -> MachineSettings:
    """The settings with some keys of some tables changed."""
    return settings.model_copy(
        update={name: getattr(settings, name).model_copy(update=keys) for name, keys in tables.items()}
    )


def perfect(settings: MachineSettings = SETTINGS) -> MachineSettings:
    """Without errors of sensors and links."""
    bare = {"deviation": 0.0, "bias": 0.0, "dropout": 0.0, "outliers": 0.0, "resolution": 1e-12}
    lidars = {name: lidar.model_copy(update=bare) for name, lidar in settings.lidars.items()}
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
    return made.model_copy(update={"lidars": lidars})


def machine(
    settings: MachineSettings = SETTINGS, seed: int = 1, plant: str = "dynamic", start: Any = START
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
