"""The estimators of a print by name: each takes a sensor frame and returns an estimate."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, ClassVar, Final, Protocol, get_args, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from cablewright.estimation import encoders_only
from cablewright.estimation.body.settings import BodySettings
from cablewright.estimation.encoders_only import ReckoningSettings
from cablewright.estimation.known_creep import KnownCreep
from cablewright.estimation.length_corrections import LearntLengths, LengthPriors
from cablewright.estimation.lidar.room import Laser
from cablewright.estimation.started_filter import StartedSettings
from cablewright.foundation.arrays import Array
from cablewright.foundation.choices import EstimatorName
from cablewright.foundation.errors import AnswerError, InputError, Status, UnknownName
from cablewright.foundation.saved_state import Saved
from cablewright.foundation.signals import Estimate, SensorFrame
from cablewright.live.body_estimator import BodyEstimator, body_settings, cells_of
from cablewright.live.estimator_settings import OBSERVERS, Observer, sees_position, with_drum_mass
from cablewright.machine.coils import coils_of
from cablewright.machine.sensors import SENSORS
from cablewright.machine.sensors.camera import CAMERA
from cablewright.machine.sensors.encoders import ENCODERS
from cablewright.machine.sensors.tensions import MOTOR_TORQUES
from cablewright.machine.settings import MachineSettings
from cablewright.models.statics import Model
from cablewright.models.support_table import Capability, require
from cablewright.robot import Robot
from cablewright.solvers.continuation import Tracker, TrackerSettings

ESTIMATORS: Final = get_args(EstimatorName)


class Estimator(Protocol):
    """Interface of an estimator of a machine's state from its sensor frames."""

    def step(self, frame: SensorFrame) -> Estimate:
        """Return the estimate after one frame. Raises nothing, whatever the frame contains."""

    @property
    def tensions(self) -> Array | None:
        """Tensions at the sheaves (m,), N, by the estimated lengths; None if the lengths are unknown."""


@runtime_checkable
class Weighing(Protocol):
    """An estimator that receives the mass of the platform."""

    def weigh(self, mass: float) -> None:
        """Set the mass of the platform with its powder, kg, for the next step."""


@runtime_checkable
class Measuring(Protocol):
    """An estimator by encoders alone that also reads tensions, for a control that holds chosen tensions."""

    @property
    def measured(self) -> Array | None:
        """Measured, smoothed tensions (m,), N; NaN: not known; None: nothing measures them."""


def best_estimator(settings: MachineSettings) -> str:
    """Return the name of the best estimator for a machine's sensors: the filter, or encoders alone."""
    if settings.body is not None:
        found = settings.tension_sensor is not None or settings.sensor(CAMERA) is not None
    else:
        found = sees_position(settings)
    return "filter" if found else "encoders"


def estimator(
    name: str,
    robot: Robot,
    settings: MachineSettings,
    place: Array,
    lasers: Sequence[Laser] = (),
    radii: Array | None = None,
    place_sigma: float | None = None,
) -> Estimator:
    """Return the estimator of that *name* for the machine that *robot* and *settings* describe.

    *place* (n,), m and rad: the platform's initial pose, which ``encoders`` uses, and those of a rigid one.
    *lasers*: distances to walls that an operator measured at the start. *radii* (m,), m: initial radii of the winch
    drums; 0: unknown. *place_sigma*: m, of places that are to teach ``encoders`` lengths; None: they do not. Raises
    `UnknownName`, and `InputError` for a machine without the sensors that it needs.
    """
    if name not in ESTIMATORS:
        raise UnknownName("estimator", name, ESTIMATORS)
    require(robot, Capability.ESTIMATION)
    if robot.n == 6:
        if name == "paper":
            raise InputError(
                f"estimator = {name}: is only for a point platform; the platform of {robot.name!r} is rigid"
            )
        return BodyEstimator(body_settings(robot, settings, sensors=name == "filter"), place)
    if name in OBSERVERS:
        if robot.platform.plane is not None:
            what = f"that of {robot.name!r} does: use encoders"
            raise InputError(f"estimator = {name}: is only for a platform that does not move in a plane; {what}")
        observer = OBSERVERS[name]
        own = observer.settings(robot, settings, lasers)
        if radii is not None:
            own = _with_radii(own, radii)
        state = observer.start(own)
        if state.creep is not None:
            return CreepingEstimator(_observed(observer, own, state), state.creep)
        return _observed(observer, own, state)
    reckoning = reckoning_of(robot, settings)
    if place_sigma is not None:
        winch = settings.winch
        priors = LengthPriors(place_sigma, radius=winch.radius_deviation, turns=winch.radius_turns)
        reckoning = replace(reckoning, priors=priors)
    return DeadReckoning(encoders_only.step, reckoning, encoders_only.start(reckoning, place))


def homed(
    settings: ReckoningSettings | BodySettings, lengths: Array, counts: NDArray[np.int64], pose: Array
) -> DeadReckoning | BodyEstimator:
    """Return the estimator of a machine with known *lengths* (m,), m, at *counts* (m,), near a *pose* (n,).

    Raises `AnswerError` where there is no equilibrium.
    """
    if isinstance(settings, BodySettings):
        return BodyEstimator(settings, pose, lengths, counts)
    return DeadReckoning(encoders_only.step, settings, encoders_only.start_at(settings, lengths, counts))


def homed_settings(robot: Robot, settings: MachineSettings) -> ReckoningSettings | BodySettings:
    """Return the settings of `homed` of a machine on drives: a rigid platform's torques correct its lengths.

    Raises `InputError` as `reckoning_of`.
    """
    if robot.n == 3:
        return reckoning_of(robot, settings)
    unread = {each.table: None for each in SENSORS if each not in (ENCODERS, MOTOR_TORQUES)}
    return body_settings(robot, settings.model_copy(update=unread), sensors=True)


def reckoning_of(robot: Robot, settings: MachineSettings) -> ReckoningSettings:
    """Return the settings of dead reckoning. Raises `InputError` for a machine without encoders."""
    if settings.sensor(ENCODERS) is None:
        raise InputError(f"machine {settings.name!r}: has no encoders, which the estimation needs")
    winch = settings.winch
    coils = coils_of(robot, winch)
    counts_per_radian = winch.counts * winch.ratio / math.tau
    return ReckoningSettings(
        Model(with_drum_mass(robot, settings)), counts_per_radian, coils, winch.held, cells=cells_of(settings)
    )


class _SteppedEstimator:
    """An estimator of settings, a state and a step function."""

    def __init__(self, step: Callable[[Any, Any, SensorFrame], Estimate], settings: Any, state: Any) -> None:
        self._step, self._settings, self._state = step, settings, state

    def step(self, frame: SensorFrame) -> Estimate:
        return self._step(self._settings, self._state, frame)

    @property
    def tensions(self) -> Array | None:
        return _tensions(self._state.tracker)


def _observed(observer: Observer, settings: Any, state: Any) -> Estimator:
    """Return the Merlet 2023 estimator, or the filter with the tensions at its lengths."""
    stepped = _SteppedEstimator(observer.step, settings, state)
    if not isinstance(settings, StartedSettings):
        return stepped
    return _WithTensions(stepped, settings.chain.model, lambda mass: observer.weigh(settings, state, mass))


class CreepingEstimator:
    """An estimator by lidars. Of its state only the modelled creep of the cables is saved with a print."""

    SAVED: ClassVar[Saved] = ("_creep",)
    danger, searches = "", False

    def __init__(self, observed: Estimator, creep: KnownCreep) -> None:
        """*creep* is what the *observed* one counts."""
        self._observed, self._creep = observed, creep

    def step(self, frame: SensorFrame) -> Estimate:
        """Return the estimate after one frame; see `Estimator.step`."""
        return self._observed.step(frame)

    @property
    def tensions(self) -> Array | None:
        """Return the tensions at the sheaves (m,), N, at the estimated lengths; see `Estimator.tensions`."""
        return self._observed.tensions

    def weigh(self, mass: float) -> None:
        """Set the mass of the platform with its powder, kg, for the next step; see `Weighing.weigh`.

        Only if the inner estimator accepts it.
        """
        if isinstance(self._observed, Weighing):
            self._observed.weigh(mass)


class DeadReckoning(_SteppedEstimator):
    """The estimator by encoders alone, which accepts measured positions of the platform.

    The creep of cables, and the corrections learnt at measured positions, are saved with a print.
    """

    SAVED: ClassVar[Saved] = ("_state",)
    danger, searches = "", False

    def after_load(self) -> None:
        """Resume with the loaded data. Raises `AnswerError` where there is no equilibrium."""
        encoders_only.resumed(self._settings, self._state)

    @property
    def learnt(self) -> LearntLengths | None:
        """Corrections of lengths learnt at measured positions, if the settings ask for them."""
        found: LearntLengths | None = self._state.learnt
        return found

    @property
    def measured(self) -> Array | None:
        """Return the measured tensions of lines with a sensor, and those by the lengths of all others."""
        measured: Array | None = self._state.measured
        return None if measured is None else np.where(np.isnan(measured), self._state.tracker.tensions, measured)

    def place_measured(self, place: Array, by_tensions: bool = False) -> None:
        """Use the measured position *place* (3,), m, of the standing platform: learn from it, or begin there again.

        *by_tensions*: see `encoders_only.placed`. Raises `AnswerError` where it cannot be there.
        """
        if self.learnt is not None:
            encoders_only.taught(self._settings, self._state, place)
            return
        self._state = encoders_only.placed(self._settings, self._state, place, by_tensions=by_tensions)


class _WithTensions:
    """A filter, which has no equilibrium of its own: that of its estimated lengths is followed for the tensions."""

    def __init__(self, filtered: _SteppedEstimator, model: Model, weigh: Callable[[float], None]) -> None:
        self._filtered, self._model, self.weigh = filtered, model, weigh
        self._tracker: Tracker | None = None

    def step(self, frame: SensorFrame) -> Estimate:
        estimate = self._filtered.step(frame)
        lengths = estimate.lengths.tolist()
        if not (estimate.valid and min(lengths) > 0.0 and sum(lengths) > 0.0):  # a sum with NaN is not
            self._tracker = None
        elif self._tracker is None:
            with suppress(AnswerError):  # no equilibrium, so no tensions
                self._tracker = Tracker(self._model, estimate.lengths, TrackerSettings(certify=False))
        elif self._tracker.step(estimate.lengths) is not Status.OK:
            self._tracker = None
        return estimate

    @property
    def tensions(self) -> Array | None:
        return _tensions(self._tracker)


def _tensions(tracker: Tracker | None) -> Array | None:
    return None if tracker is None else tracker.tensions


def _with_radii(settings: Any, radii: Array) -> Any:
    """Return the *settings* of either estimator with initial *radii* (m,), m; unchanged if any is unknown."""
    if not (radii > 0.0).all():
        return settings
    if isinstance(settings, StartedSettings):
        return replace(settings, chain=_with_radii(settings.chain, radii))
    inside = np.clip(radii, settings.radius.min_radius, settings.radius.max_radius)
    return replace(settings, radius=replace(settings.radius, nominal=tuple(inside.tolist())))
