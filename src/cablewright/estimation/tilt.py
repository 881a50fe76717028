"""Tilt of the platform by a complementary filter: the gyro for swings, gravity for slow changes.

Tilt is the rotation vector (x, y), rad, that tilts the level platform, in its own level frame: yaw comes after it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Inertial
from cablewright.kernels.rotation import yawed


@dataclass(frozen=True)
class TiltSettings:
    """Time constants and plausible readings.

    ``gravity_time``: s, time constant with which gravity corrects the gyro; longer than a swing's period, because a
    pendulum's accelerometer hardly measures its swing. ``bias_time``: s over which mean tilt and mean rate are taken
    for the sensors' biases, because a platform that hangs from one point is upright and still on average. ``max_gap``:
    s between readings beyond which the gyro is not integrated. ``max_rate``: rad/s, of a plausible rate, and
    ``max_acceleration``: m/s^2 off gravity, of an acceleration that may show it.
    """

    gravity: float = 9.81
    gravity_time: float = 4.0
    bias_time: float = 30.0
    max_gap: float = 0.1
    max_rate: float = 1.0
    max_acceleration: float = 3.0

    def __post_init__(self) -> None:
        """Reject numbers that are not positive and finite."""
        for name, value in vars(self).items():
            if not 0.0 < value < math.inf:
                raise InputError(f"{name} = {value:g}: a finite number over 0 is expected")

    def has_rate(self, reading: Inertial) -> bool:
        """Return whether the rate of a *reading* is finite and possible for a platform that hangs on lines."""
        (x, y, z), most = reading.rate.tolist(), self.max_rate
        return bool(abs(x) <= most and abs(y) <= most and abs(z) <= most)  # NaN is not

    def has_gravity(self, reading: Inertial) -> bool:
        """Return whether a *reading*'s acceleration is finite and may be gravity, not that of a bouncing platform."""
        x, y, z = reading.acceleration.tolist()
        return math.hypot(x, y, z - self.gravity) <= self.max_acceleration


class TiltState(NamedTuple):
    """Tilt (rad), and the biases of accelerometer (as a tilt, rad) and gyro (rad/s)."""

    time: float
    x: float
    y: float
    accelerometer_bias: tuple[float, float]
    gyro_bias: tuple[float, float]
    elapsed: float  # s, since the first reading


def start() -> TiltState:
    """Return the tilt state before the first reading: upright."""
    return TiltState(-math.inf, 0.0, 0.0, (0.0, 0.0), (0.0, 0.0), 0.0)


def step(settings: TiltSettings, state: TiltState, reading: Inertial, yaw_rate: float) -> TiltState:
    """Update the tilt by one IMU reading; an old one, or one without a rate, changes nothing.

    *yaw_rate*: rad/s, of the platform. Without gravity the gyro alone is integrated.
    """
    fx, fy, _ = reading.acceleration.tolist()
    wx, wy, _ = reading.rate.tolist()
    dt = reading.time - state.time
    has_gravity = settings.has_gravity(reading)
    if not (dt > 0.0 and settings.has_rate(reading) and (has_gravity or dt <= settings.max_gap)):
        return state
    # R^T z = (-y, x, 1) for a small tilt (x, y): what the accelerometer measures at rest, over g
    measured = fy / settings.gravity, -fx / settings.gravity
    if dt > settings.max_gap:
        first = state.elapsed == 0.0
        bias, gyro_bias = (measured, (wx, wy)) if first else (state.accelerometer_bias, state.gyro_bias)
        x, y = measured[0] - bias[0], measured[1] - bias[1]
        return TiltState(reading.time, x, y, bias, gyro_bias, state.elapsed + settings.max_gap)
    elapsed = min(state.elapsed + dt, settings.bias_time)
    bias = state.accelerometer_bias
    gyro_bias = _smoothed(state.gyro_bias, (wx, wy), dt / elapsed)
    x = state.x + dt * (wx - gyro_bias[0] + yaw_rate * state.y)
    y = state.y + dt * (wy - gyro_bias[1] - yaw_rate * state.x)
    if has_gravity:
        bias = _smoothed(bias, measured, dt / elapsed)
        gain = dt / settings.gravity_time
        x += gain * (measured[0] - bias[0] - x)
        y += gain * (measured[1] - bias[1] - y)
    return TiltState(reading.time, x, y, bias, gyro_bias, elapsed)


def _smoothed(old: tuple[float, float], new: tuple[float, float], gain: float) -> tuple[float, float]:
    return old[0] + gain * (new[0] - old[0]), old[1] + gain * (new[1] - old[1])


def rotation_vector(yaw: float, x: float, y: float) -> tuple[float, float, float]:
    """Return the rotation vector (rad) of a platform that is tilted by (x, y) and then rotated by *yaw*."""
    i, j, k = yawed(float(yaw), float(x), float(y))
    return i, j, k
