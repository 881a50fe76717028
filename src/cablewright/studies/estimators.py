"""Estimators by name, all alike to who asks them: told a frame, they say what they believe."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from cablewright.errors import InputError, UnknownName
from cablewright.estimation import dead_reckoning, observer
from cablewright.estimation.dead_reckoning import ReckoningSettings
from cablewright.estimation.observer import ObserverSettings
from cablewright.estimation.room import Laser
from cablewright.kernels.layout import TAU
from cablewright.machine.settings import MachineSettings
from cablewright.models.coil import Coil, wind
from cablewright.models.statics import Model
from cablewright.robot import Line, Robot
from cablewright.signals import Estimate, SensorFrame
from cablewright.solvers.track import Tracker
from cablewright.studies.observing import believed, observer_settings

__all__ = ["ESTIMATORS", "Estimator", "estimator"]

Array = NDArray[np.float64]

ESTIMATORS: Final = ("paper", "encoders")


class Estimator(Protocol):
    """What finds out a machine's state."""

    def step(self, frame: SensorFrame) -> Estimate:
        """Take one frame. Raises nothing for what it holds."""

    @property
    def tensions(self) -> Array | None:
        """Tensions at the sheaves (m,), N, that the lengths believed in would give; None before anything is known."""


def estimator(
    name: str,
    robot: Robot,
    settings: MachineSettings,
    place: Array,
    lasers: Sequence[Laser] = (),
    radii: Array | None = None,
) -> Estimator:
    """Return the estimator of that *name* for the machine that *robot* and *settings* describe.

    *place* (3,), m: where the platform hangs, which only ``encoders`` has to be told. *radii* (m,), m: of the winch
    drums, as an earlier estimator of this machine found them, 0 where not. Raises `UnknownName`, and `InputError` for a
    machine without the sensors that it needs.
    """
    if name not in ESTIMATORS:
        raise UnknownName("estimator", name, ESTIMATORS)
    if name == "paper":
        told = observer_settings(robot, settings, lasers)
        if radii is not None and (radii > 0.0).all():
            inside = np.clip(radii, told.radius.least, told.radius.most)
            told = replace(told, radius=replace(told.radius, nominal=tuple(inside.tolist())))
        return _Observed(told)
    if settings.encoders is None:
        raise InputError(f"machine {settings.name!r}: has no encoders, which the estimation needs")
    return _Reckoned(reckoning_settings(robot, settings), place)


def reckoning_settings(robot: Robot, settings: MachineSettings) -> ReckoningSettings:
    """What is known of a machine's winches by description."""
    winch = settings.winch
    coils = tuple(_as_it_should_lie(line, settings) for line in robot.lines)
    model = Model(believed(robot, settings))
    return ReckoningSettings(model, winch.counts * winch.ratio / (2.0 * np.pi), coils, winch.held)


def _as_it_should_lie(line: Line, settings: MachineSettings) -> Coil:
    radius, diameter, winch = line.winch.drum_radius, line.cable.diameter, settings.winch
    if radius is None or diameter is None:
        missing = "winch.drum_radius" if radius is None else "cable.diameter"
        raise InputError(f"line {line.name!r} gives no {missing}, which the estimation needs")
    return wind(winch.capacity, radius, winch.width, diameter, winch.pitch)


class _Observed:
    def __init__(self, settings: ObserverSettings) -> None:
        self._settings, self._state = settings, observer.start(settings)

    def step(self, frame: SensorFrame) -> Estimate:
        return observer.step(self._settings, self._state, frame)

    @property
    def tensions(self) -> Array | None:
        return _tensions(self._state.tracker)


class _Reckoned:
    def __init__(self, settings: ReckoningSettings, place: Array) -> None:
        self._settings, self._state = settings, dead_reckoning.start(settings, place)

    def step(self, frame: SensorFrame) -> Estimate:
        return dead_reckoning.step(self._settings, self._state, frame)

    @property
    def tensions(self) -> Array | None:
        return _tensions(self._state.tracker)


def _tensions(tracker: Tracker | None) -> Array | None:
    return None if tracker is None else np.asarray(np.exp(tracker.states[:, TAU]))
