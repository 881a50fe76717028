"""Control of the drive that retracts a platform, by the schedule of the job, and its effect on the lines."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np

from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError, require_positive
from cablewright.foundation.reading_times import ReadingTimes
from cablewright.foundation.signals import BeamLength, SensorFrame
from cablewright.robot import Robot

_GAIN: Final = 1.0  # 1/s, of the length's error
_WITHIN: Final = 1.0 - 1e-9  # of the way to the end of the stroke in one step, for what numbers are rounded by
_STILL: Final = 2e-4  # m: nearer to its target than this the beam stands


class BeamMotion(NamedTuple):
    """Present length and speed of the retraction."""

    length: float  # m
    speed: float  # m/s, positive makes the platform longer
    along: Array  # (3,) unit vector, platform frame
    moved: Mask  # (m,) lines whose platform points move with it


@dataclass(frozen=True)
class BeamSettings:
    """Settings of the drive that retracts a platform. ``max_speed``: m/s; ``least``, ``most``: m."""

    max_speed: float
    least: float
    most: float
    along: tuple[float, float, float]
    moved: tuple[bool, ...]

    def __post_init__(self) -> None:
        """Raise `InputError` for numbers that are not positive and finite."""
        require_positive(max_speed=self.max_speed, least=self.least, most=self.most)

    @classmethod
    def of(cls, robot: Robot, max_speed: float) -> BeamSettings:
        """Return the settings of a *robot* with a retraction. Raises `InputError` for one without."""
        own = robot.retraction
        if own is None:
            raise InputError(f"robot {robot.name!r}: its platform has no retraction")
        moved = tuple(line.name in own.lines for line in robot.lines)
        return cls(max_speed, own.least, own.most, own.along, moved)


@dataclass(eq=False)
class BeamState:
    """State of the drive that retracts the platform. ``length``: last measured retraction length, m.

    Changed in place by `read`.
    """

    length: float
    times: ReadingTimes = field(default_factory=ReadingTimes)


def read(settings: BeamSettings, state: BeamState, frame: SensorFrame) -> None:
    """Store the measured retraction length of a frame; *state* changes in place."""
    for reading in frame.of(BeamLength):
        if math.isfinite(reading.length) and state.times.is_new(reading.source, reading.time, frame.time):
            state.length = min(max(reading.length, settings.least), settings.most)


def step(settings: BeamSettings, state: BeamState, target: float, rate: float, dt: float) -> BeamMotion:
    """Return the beam's speed for the next *dt*, s, towards the length *target*, m, which changes by *rate*, m/s.

    A *target* of NaN: it stands.
    """
    error = target - state.length
    speed = 0.0
    if math.isfinite(error) and (rate != 0.0 or abs(error) > _STILL):
        speed = rate + min(_GAIN, 0.5 / dt) * error
        speed = min(max(speed, -settings.max_speed), settings.max_speed)
    back, on = ((end - state.length) / dt * _WITHIN for end in (settings.least, settings.most))
    speed = min(max(speed, back), on)  # never beyond the stroke, where the model has no lengths
    return BeamMotion(state.length, speed, np.array(settings.along), np.array(settings.moved))
