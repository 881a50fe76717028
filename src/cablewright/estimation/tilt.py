"""How the drum leans, from its accelerometer and gyro: the gyro for swings, gravity for the rest.

Tilt is the rotation vector (x, y), rad, that leans the level drum, in the drum's own level frame: yaw comes after it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from cablewright.errors import InputError
from cablewright.signals import Inertial

__all__ = ["TiltSettings", "TiltState", "rotation_vector", "start", "step"]


@dataclass(frozen=True)
class TiltSettings:
    """How much each sensor is believed.

    ``blend``: s, how long the gyro is believed before gravity corrects it; over a swing's period, for a pendulum's
    accelerometer hardly feels its swing. ``rest``: s over which the drum leans and turns by nothing on average, since
    it hangs from one point: what the sensors tell on average is their bias. ``gap``: s without a reading after which
    nothing is carried on. ``most_rate``: rad/s, and ``most_push``: m/s^2 off gravity, of a reading that a drum on lines
    can cause; others are astray.
    """

    gravity: float = 9.81
    blend: float = 4.0
    rest: float = 30.0
    gap: float = 0.1
    most_rate: float = 1.0
    most_push: float = 3.0

    def __post_init__(self) -> None:
        """Refuse what is no time."""
        for name in ("gravity", "blend", "rest", "gap", "most_rate", "most_push"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise InputError(f"{name} = {getattr(self, name):g}: a finite number over 0 is wanted")

    def believes(self, reading: Inertial) -> bool:
        """Whether *reading* is finite and nothing that no drum on lines does."""
        x, y, z = reading.acceleration.tolist()
        push = math.hypot(x, y, z - self.gravity)
        rates = reading.rate.tolist()
        return push <= self.most_push and all(abs(rate) <= self.most_rate for rate in rates)  # NaN is neither


class TiltState(NamedTuple):
    """Tilt (rad), and what the sensors are off: the accelerometer (rad) and the gyro (rad/s)."""

    time: float
    x: float
    y: float
    lean_bias: tuple[float, float]
    rate_bias: tuple[float, float]
    spent: float  # s, since the first reading


def start() -> TiltState:
    """Return the state before the first reading: upright."""
    return TiltState(-math.inf, 0.0, 0.0, (0.0, 0.0), (0.0, 0.0), 0.0)


def step(settings: TiltSettings, state: TiltState, reading: Inertial, yaw_rate: float) -> TiltState:
    """Take one reading. *yaw_rate*: rad/s, of the drum. A reading that is astray or not new changes nothing."""
    fx, fy, _ = reading.acceleration.tolist()
    wx, wy, _ = reading.rate.tolist()
    dt = reading.time - state.time
    if not (dt > 0.0 and settings.believes(reading)):
        return state
    # R^T z = (-y, x, 1) for a small tilt (x, y): what the accelerometer feels at rest, over g
    lean_x, lean_y = fy / settings.gravity, -fx / settings.gravity
    if dt > settings.gap:
        first = state.spent == 0.0
        bias, rates = ((lean_x, lean_y), (wx, wy)) if first else (state.lean_bias, state.rate_bias)
        return TiltState(reading.time, lean_x - bias[0], lean_y - bias[1], bias, rates, state.spent + settings.gap)
    spent = min(state.spent + dt, settings.rest)
    slow = dt / spent
    lean = _toward(state.lean_bias, (lean_x, lean_y), slow)
    rate = _toward(state.rate_bias, (wx, wy), slow)
    x = state.x + dt * (wx - rate[0] + yaw_rate * state.y)
    y = state.y + dt * (wy - rate[1] - yaw_rate * state.x)
    share = dt / settings.blend
    x += share * (lean_x - lean[0] - x)
    y += share * (lean_y - lean[1] - y)
    return TiltState(reading.time, x, y, lean, rate, spent)


def _toward(old: tuple[float, float], new: tuple[float, float], share: float) -> tuple[float, float]:
    return old[0] + share * (new[0] - old[0]), old[1] + share * (new[1] - old[1])


def rotation_vector(yaw: float, x: float, y: float) -> tuple[float, float, float]:
    """Rotation vector (rad) of a drum that is leaned by (x, y) and then turned by *yaw*, by quaternions."""
    lean = math.hypot(x, y)
    c, s = math.cos(0.5 * lean), (0.5 if lean < 1e-9 else math.sin(0.5 * lean) / lean)
    a, b, d = math.cos(0.5 * yaw), math.sin(0.5 * yaw), s
    w, i, j, k = a * c, d * (a * x - b * y), d * (a * y + b * x), b * c
    if w < 0.0:
        w, i, j, k = -w, -i, -j, -k
    size = math.sqrt(i * i + j * j + k * k)
    scale = 2.0 if size < 1e-12 else 2.0 * math.atan2(size, w) / size
    return scale * i, scale * j, scale * k
