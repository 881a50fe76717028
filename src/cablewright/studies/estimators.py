"""Estimators by name, all alike to who asks them: told a frame, they say what they believe."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from cablewright.errors import AnswerError, InputError, Status, UnknownName
from cablewright.estimation import dead_reckoning
from cablewright.estimation.dead_reckoning import ReckoningSettings
from cablewright.estimation.kalman.state import FilterSettings
from cablewright.estimation.lidar.room import Laser
from cablewright.machine.simulated.settings import MachineSettings
from cablewright.machine.simulated.winches import coil_of
from cablewright.models.packed_views import LineStates
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.signals import Estimate, SensorFrame
from cablewright.solvers.continuation import Tracker, TrackerSettings
from cablewright.studies.estimator_settings import OBSERVERS, with_drum_mass

__all__ = ["ESTIMATORS", "Estimator", "estimator"]

Array = NDArray[np.float64]

ESTIMATORS: Final = (*OBSERVERS, "encoders")
"""All that a print may be told by."""


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
    if name in OBSERVERS:
        kind = _FilterEstimator if name == "filter" else _ChainEstimator
        return kind(name, robot, settings, lasers, radii)
    if settings.encoders is None:
        raise InputError(f"machine {settings.name!r}: has no encoders, which the estimation needs")
    return _EncoderEstimator(reckoning_settings(robot, settings), place)


def reckoning_settings(robot: Robot, settings: MachineSettings) -> ReckoningSettings:
    """What is known of a machine's winches by description."""
    winch = settings.winch
    coils = tuple(coil_of(line, winch) for line in robot.lines)
    model = Model(with_drum_mass(robot, settings))
    return ReckoningSettings(model, winch.counts * winch.ratio / (2.0 * np.pi), coils, winch.held)


class _ChainEstimator:
    """The chain, which follows an equilibrium itself."""

    def __init__(
        self, name: str, robot: Robot, settings: MachineSettings, lasers: Sequence[Laser], radii: Array | None
    ) -> None:
        self._one = OBSERVERS[name]
        told = self._one.settings(robot, settings, lasers)
        if radii is not None and (radii > 0.0).all():
            told = _with_radii(told, radii)
        self._settings, self._state = told, self._one.start(told)

    def step(self, frame: SensorFrame) -> Estimate:
        return self._one.step(self._settings, self._state, frame)

    @property
    def tensions(self) -> Array | None:
        return _tensions(self._state.tracker)


class _FilterEstimator(_ChainEstimator):
    """The filter: what its lengths would give is followed apart from where it sees the platform."""

    _tracker: Tracker | None = None

    def step(self, frame: SensorFrame) -> Estimate:
        estimate = super().step(frame)
        if not (estimate.valid and (estimate.lengths > 0.0).all()):
            self._tracker = None
        elif self._tracker is None:
            try:
                self._tracker = Tracker(self._settings.chain.model, estimate.lengths, TrackerSettings(certify=False))
            except AnswerError:  # they give nothing, so no tensions either
                self._tracker = None
        elif self._tracker.step(estimate.lengths) is not Status.OK:
            self._tracker = None
        return estimate

    @property
    def tensions(self) -> Array | None:
        return _tensions(self._tracker)


def _with_radii(told: Any, radii: Array) -> Any:
    """The settings of an observer, or of the filter over it, that begins with *radii* (m,), m."""
    if isinstance(told, FilterSettings):
        return replace(told, chain=_with_radii(told.chain, radii))
    inside = np.clip(radii, told.radius.min_radius, told.radius.max_radius)
    return replace(told, radius=replace(told.radius, nominal=tuple(inside.tolist())))


class _EncoderEstimator:
    def __init__(self, settings: ReckoningSettings, place: Array) -> None:
        self._settings, self._state = settings, dead_reckoning.start(settings, place)

    def step(self, frame: SensorFrame) -> Estimate:
        return dead_reckoning.step(self._settings, self._state, frame)

    @property
    def tensions(self) -> Array | None:
        return _tensions(self._state.tracker)


def _tensions(tracker: Tracker | None) -> Array | None:
    return None if tracker is None else np.asarray(LineStates(tracker.states).tension)
