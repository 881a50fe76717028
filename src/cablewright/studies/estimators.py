"""Estimators by name, with one interface: a frame in, an estimate out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final, Protocol, get_args

import numpy as np

from cablewright.arrays import Array
from cablewright.choices import EstimatorName
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

ESTIMATORS: Final = get_args(EstimatorName)


class Estimator(Protocol):
    """Estimates a machine's state."""

    def step(self, frame: SensorFrame) -> Estimate:
        """Return the estimate after one frame. Raises nothing for what it holds."""

    @property
    def tensions(self) -> Array | None:
        """Tensions at the sheaves (m,), N, by the estimated lengths; None while these are unknown."""


def estimator(
    name: str,
    robot: Robot,
    settings: MachineSettings,
    place: Array,
    lasers: Sequence[Laser] = (),
    radii: Array | None = None,
) -> Estimator:
    """Return the estimator of that *name* for the machine that *robot* and *settings* describe.

    *place* (3,), m: the platform's position, which only ``encoders`` uses. *radii* (m,), m: of the winch drums, by an
    earlier estimator of this machine; 0: unknown. Raises `UnknownName`, and `InputError` for a machine without the
    sensors that it needs.
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
    """Return the settings of dead reckoning from a machine's description."""
    winch = settings.winch
    coils = tuple(coil_of(line, winch) for line in robot.lines)
    model = Model(with_drum_mass(robot, settings))
    return ReckoningSettings(model, winch.counts * winch.ratio / (2.0 * np.pi), coils, winch.held)


class _ChainEstimator:
    """The paper's chain, which follows an equilibrium itself."""

    def __init__(
        self, name: str, robot: Robot, settings: MachineSettings, lasers: Sequence[Laser], radii: Array | None
    ) -> None:
        self._observer = OBSERVERS[name]
        own = self._observer.settings(robot, settings, lasers)
        if radii is not None and (radii > 0.0).all():
            own = _with_radii(own, radii)
        self._settings, self._state = own, self._observer.start(own)

    def step(self, frame: SensorFrame) -> Estimate:
        return self._observer.step(self._settings, self._state, frame)

    @property
    def tensions(self) -> Array | None:
        return _tensions(self._state.tracker)


class _FilterEstimator(_ChainEstimator):
    """The Kalman filter; the equilibrium of its lengths is followed besides, for the tensions."""

    _tracker: Tracker | None = None

    def step(self, frame: SensorFrame) -> Estimate:
        estimate = super().step(frame)
        if not (estimate.valid and (estimate.lengths > 0.0).all()):
            self._tracker = None
        elif self._tracker is None:
            try:
                self._tracker = Tracker(self._settings.chain.model, estimate.lengths, TrackerSettings(certify=False))
            except AnswerError:  # no equilibrium, so no tensions
                self._tracker = None
        elif self._tracker.step(estimate.lengths) is not Status.OK:
            self._tracker = None
        return estimate

    @property
    def tensions(self) -> Array | None:
        return _tensions(self._tracker)


def _with_radii(settings: Any, radii: Array) -> Any:
    """Return the *settings* of the chain, or of the filter, with *radii* (m,), m, to start from."""
    if isinstance(settings, FilterSettings):
        return replace(settings, chain=_with_radii(settings.chain, radii))
    inside = np.clip(radii, settings.radius.min_radius, settings.radius.max_radius)
    return replace(settings, radius=replace(settings.radius, nominal=tuple(inside.tolist())))


class _EncoderEstimator:
    """Dead reckoning by the encoders."""

    def __init__(self, settings: ReckoningSettings, place: Array) -> None:
        self._settings, self._state = settings, dead_reckoning.start(settings, place)

    def step(self, frame: SensorFrame) -> Estimate:
        return dead_reckoning.step(self._settings, self._state, frame)

    @property
    def tensions(self) -> Array | None:
        return _tensions(self._state.tracker)


def _tensions(tracker: Tracker | None) -> Array | None:
    return None if tracker is None else np.asarray(LineStates(tracker.states).tension)
