"""Sensors that are read at a fixed rate, in steps of the machine."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, Generic, TypeVar

import numpy as np

from cablewright.errors import InputError
from cablewright.machine.sensors import TimedSettings
from cablewright.machine.simulated.rig import RigState
from cablewright.machine.simulated.settings import SensorFlaws
from cablewright.saving import Saved
from cablewright.signals import Reading

_Settings = TypeVar("_Settings", bound=TimedSettings)
_Flaws = TypeVar("_Flaws", bound=SensorFlaws)


def steps_per_interval(period: float, interval: float, what: str) -> int:
    """Return how many steps of *period* (s) make an *interval* (s). Raises `InputError`, naming *what*, if none do."""
    count = interval / period
    whole = round(count)
    if whole < 1 or abs(count - whole) > 1e-6 * whole:
        raise InputError(
            f"{what}: every {interval:g} s is no whole number of the machine's steps, {period:g} s; "
            f"allowed: {period:g}, {2 * period:g}, {3 * period:g} s and so on"
        )
    return whole


class TimedSensor(ABC, Generic[_Settings, _Flaws]):
    """A sensor that is read at the rate of its *settings*, with the *flaws* of one unit."""

    SAVED: ClassVar[Saved] = ("_step", "_random")

    def __init__(
        self, key: str, settings: _Settings, flaws: _Flaws, period: float, random: np.random.Generator
    ) -> None:
        """*key*: name of the settings' table; *period*: s, of the machine's steps; *random* draws all errors.

        Raises `InputError` for a rate that does not fit the period.
        """
        self.settings, self.flaws, self._random, self._step = settings, flaws, random, 0
        self._interval = steps_per_interval(period, 1.0 / settings.rate, f"{key}.rate = {settings.rate:g} Hz")

    def read(self, state: RigState) -> Reading | None:
        """Return a reading when one is due and not lost; to be called in each step of the machine."""
        self._step += 1
        return None if self._step % self._interval else self._measure(state)

    @abstractmethod
    def _measure(self, state: RigState) -> Reading | None:
        """Return a reading; None if it is lost."""
