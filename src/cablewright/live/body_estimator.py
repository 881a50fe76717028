"""The estimator of a rigid platform, built from the owner's settings of a machine."""

from __future__ import annotations

import math
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from cablewright.estimation.body import filter as of_body
from cablewright.estimation.body.settings import BodySettings, Deviations
from cablewright.estimation.body.state import resumed, start
from cablewright.estimation.body.updates import UPDATES
from cablewright.estimation.body.updates.cells import Cells
from cablewright.estimation.body.updates.update import Update
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.saved_state import Saved
from cablewright.foundation.signals import Estimate, SensorFrame
from cablewright.live.estimator_settings import clock_of, with_drum_mass
from cablewright.machine.coils import coils_of
from cablewright.machine.sensors.encoders import ENCODERS
from cablewright.machine.sensors.retraction import RETRACTION
from cablewright.machine.settings import MachineSettings
from cablewright.models.statics import Model
from cablewright.robot import Robot

_LEAST_UNEVEN: Final = 1e-4  # m


def body_settings(robot: Robot, settings: MachineSettings, *, sensors: bool) -> BodySettings:
    """Return the estimator settings for a machine with a rigid platform. Raises `InputError` without encoders.

    *sensors*: whether load cells and inertial unit are used, if it has them.
    """
    if settings.sensor(ENCODERS) is None:
        raise InputError(f"machine {settings.name!r}: has no encoders, which the estimation needs")
    winch, retraction = settings.winch, settings.sensor(RETRACTION)
    known = _updates(settings)
    cells = next((source for source, each in known.items() if isinstance(each, Cells)), None)
    updates = known if sensors else {}
    missed = [ENCODERS.source, *(source for source, update in updates.items() if update.MISSED)]
    return BodySettings(
        Model(with_drum_mass(robot, settings)),
        winch.counts * winch.ratio / math.tau,
        coils_of(robot, winch),
        winch.held,
        winch.max_speed,
        _deviations(robot, settings),
        tuple(updates.values()),
        0.0 if retraction is None else retraction.deviation,
        {source: max(0.5, 2.5 / settings.sheets[source].rate) for source in missed},
        clock=clock_of(settings),
        cells=None if sensors else cells,
    )


def _updates(settings: MachineSettings) -> dict[str, Update]:
    """The update of each sensor that the estimator uses, by source: of several of a kind the first."""
    sheets, found = settings.sheets, {}
    for kind in UPDATES:
        source = next((source.name for source in kind.READING.SOURCES if source.name in sheets), None)
        if source is not None:
            found[source] = kind.told(source, sheets[source])
    return found


def _deviations(robot: Robot, settings: MachineSettings) -> Deviations:
    """The specified accuracy of the machine, and the unevenness of cable on the drums."""
    winch = settings.winch
    radius = min(line.winch.drum_radius or math.inf for line in robot.lines)
    length = min(winch.radius_turns * math.tau * radius, 10.0)
    uneven = max(0.5 * winch.radius_deviation / radius * length, _LEAST_UNEVEN)
    known = {} if settings.accuracy is None else settings.accuracy.model_dump()
    return Deviations(uneven=uneven, uneven_length=length, **known)


def cells_of(settings: MachineSettings) -> Cells | None:
    """Return the settings of a machine's load cells or, without them, of its motors' torques; None without both."""
    return next((each for each in _updates(settings).values() if isinstance(each, Cells)), None)


class BodyEstimator:
    """The estimator for prints with a rigid platform that begin at a pose (6,), m and rad."""

    SAVED: ClassVar[Saved] = ("_state",)

    def __init__(
        self,
        settings: BodySettings,
        pose: Array,
        lengths: Array | None = None,
        counts: NDArray[np.int64] | None = None,
    ) -> None:
        """*lengths* (m,), m, are out at *counts* (m,); None: those that hold it, at the first reading.

        Raises `AnswerError` for a pose that is not held.
        """
        self._settings, self._state = settings, start(settings, pose, lengths=lengths, counts=counts)

    def step(self, frame: SensorFrame) -> Estimate:
        """Return the rigid platform's estimated state after one sensor frame; see `Estimator.step`."""
        return of_body.step(self._settings, self._state, frame)

    @property
    def tensions(self) -> Array | None:
        """Return the tensions at the sheaves (m,), N, at the estimated lengths; see `Estimator.tensions`."""
        return np.asarray(self._state.tensions)

    @property
    def measured(self) -> Array | None:
        """Return the measured, smoothed tensions (m,), N; see `Measuring.measured`.

        Used where the pose is by encoders alone; silent cells have the tensions of the lengths.
        """
        measured = self._state.latest.tensions
        return None if measured is None else np.where(np.isnan(measured), self._state.tensions, measured)

    @property
    def danger(self) -> str:
        """Reason why the estimator asks for a stop of the machine; empty: none."""
        return self._state.judged.danger

    @property
    def searches(self) -> bool:
        """Return whether the estimator still searches for the cause of the danger."""
        return self._state.judged.search is not None

    def after_load(self) -> None:
        """Compute what follows from the loaded state."""
        resumed(self._settings, self._state)
