"""The estimator of a rigid platform, from what a machine's owner knows."""

from __future__ import annotations

import math
from typing import ClassVar, Final

import numpy as np

from cablewright.arrays import Array
from cablewright.errors import InputError
from cablewright.estimation.body import filter as of_body
from cablewright.estimation.body.settings import BodySettings, Cells, Deviations, Swivelling, Tilt
from cablewright.estimation.body.state import resumed, start
from cablewright.machine.coils import coil_of
from cablewright.machine.sensors import InertialSensor, SwivelSensor
from cablewright.machine.settings import MachineSettings
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.saving import Saved
from cablewright.signals import Estimate, SensorFrame
from cablewright.studies.estimator_settings import with_drum_mass

_LEAST_GAIN: Final = 1e-3  # share: no load cell's scale is known better ...
_LEAST_UNEVEN: Final = 1e-4  # m
_LEAST_ZERO: Final = 0.1  # N: ... nor its zero


def body_settings(robot: Robot, settings: MachineSettings, *, sensors: bool) -> BodySettings:
    """Return the settings for a machine; *sensors*: whether load cells and inertial unit are used, if it has them.

    Raises `InputError` for a machine without encoders.
    """
    if settings.encoders is None:
        raise InputError(f"machine {settings.name!r}: has no encoders, which the estimation needs")
    winch, unit = settings.winch, settings.inertial
    cells = settings.load_cells or settings.motor_torques
    timeouts = {"encoders": max(0.5, 2.5 / settings.encoders.rate)}
    used = {_source(settings): cells, "inertial": unit} if sensors else {}
    timeouts |= {name: max(0.5, 2.5 / each.rate) for name, each in used.items() if each is not None}
    return BodySettings(
        Model(with_drum_mass(robot, settings)),
        winch.counts * winch.ratio / math.tau,
        tuple(coil_of(line, winch) for line in robot.lines),
        winch.held,
        winch.max_speed,
        _deviations(robot, settings),
        cells_of(settings) if sensors else None,
        None if unit is None or not sensors else _tilt(unit),
        None if settings.swivels is None or not sensors else _swivelling(settings.swivels),
        0.0 if settings.retraction is None else settings.retraction.deviation,
        timeouts,
    )


def _deviations(robot: Robot, settings: MachineSettings) -> Deviations:
    """What the owner knows of the machine's accuracy, and how unevenly cable lies on the drums."""
    winch = settings.winch
    radius = min(line.winch.drum_radius or math.inf for line in robot.lines)
    length = min(winch.radius_turns * math.tau * radius, 10.0)
    uneven = max(0.5 * winch.radius_deviation / radius * length, _LEAST_UNEVEN)
    known = {} if settings.accuracy is None else settings.accuracy.model_dump()
    return Deviations(uneven=uneven, uneven_length=length, **known)


def _swivelling(swivels: SwivelSensor) -> Swivelling:
    return Swivelling(max(swivels.deviation, 1e-5), max(swivels.bias, 1e-5))


def cells_of(settings: MachineSettings) -> Cells | None:
    """Return what is known of a machine's load cells or, without them, of its motors' torques; None without both."""
    cells = settings.load_cells or settings.motor_torques
    if cells is None:
        return None
    noise, zero = max(cells.deviation, _LEAST_ZERO), max(cells.bias, _LEAST_ZERO)
    return Cells(_source(settings), noise, zero, max(cells.gain_deviation, _LEAST_GAIN))


def _source(settings: MachineSettings) -> str:
    return "load_cells" if settings.load_cells is not None else "motor_torques"


def _tilt(unit: InertialSensor) -> Tilt:
    least = 1e-4  # m/s^2 and rad
    return Tilt(
        *(max(each, least) for each in (unit.acceleration_deviation, unit.acceleration_bias, unit.turn_deviation))
    )


class BodyEstimator:
    """The estimator of a print of a rigid platform that begins at a pose (6,), m and rad."""

    SAVED: ClassVar[Saved] = ("_state",)

    def __init__(self, settings: BodySettings, pose: Array, retraction: float = math.nan) -> None:
        """*retraction*: m, at the beginning; NaN: the robot's own. Raises `AnswerError` for a pose that is not held."""
        self._settings, self._state = settings, start(settings, pose, retraction)

    def step(self, frame: SensorFrame) -> Estimate:
        """As `Estimator`."""
        return of_body.step(self._settings, self._state, frame)

    @property
    def tensions(self) -> Array | None:
        """As `Estimator`."""
        return np.asarray(self._state.tensions)

    @property
    def danger(self) -> str:
        """Why the machine is to stop; empty: nothing."""
        return self._state.danger

    @property
    def searches(self) -> bool:
        """Whether the cause of that is still looked for."""
        return self._state.search is not None

    def after_load(self) -> None:
        """Go on with what was loaded."""
        resumed(self._settings, self._state)
