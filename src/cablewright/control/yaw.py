"""Control of the container's yaw by a drive about its axis, which Merlet and Papegay 2023, IV, propose.

The drive turns the drum against the suspension, whose twisted lines resist. With the drive's angle a, the drum's
inertia J, its damping c, and stiffness k and rest r of the twist, the yaw y obeys J y'' + c y' + k (y - a - r) = 0. The
control knows none of J, c, k and r. It has the estimator's y: the lidars' angle, which is up to two turns old, carried
on by the gyro. Hence two laws, for the error e of the yaw and its rate w:

* with a fresh gyro: a = i - p e - d w. The drum becomes 1 + p times as stiff, and damped; i' = -(1 + p) e / T.
* without one: a = i, with p = 0. T is ten turns of a lidar, so that its delay is harmless.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final

from cablewright.foundation.reading_times import ReadingTimes
from cablewright.foundation.signals import Inertial, SensorFrame, YawAngle
from cablewright.models.rotation import wrap_angle

GIVE_UP: Final = math.radians(45.0)
"""Error of the yaw beyond which the drive stands: it turns the wrong way, or something holds the drum."""

_TURNS: Final = 10.0  # of a lidar, in the integral's time
_STIFFER: Final = 4.0  # p, of the error
_DAMPING: Final = 4.0  # d, s, of the rate
_SMOOTHING: Final = 0.1  # s, of the rate
_FRESH: Final = 0.15  # s since the last reading of the gyro, and longest step, of the law with a gyro
_APPROACH: Final = 0.2  # s, in which the drive approaches its angle


@dataclass(frozen=True)
class YawSettings:
    """Settings of the yaw control: ``held`` yaw, rad; ``max_speed``, rad/s, and ``travel``, rad, of the drive.

    ``travel`` is to either side. ``turn``: s, of a lidar.
    """

    held: float
    max_speed: float
    travel: float
    turn: float


@dataclass(eq=False)
class YawState:
    """State of the yaw drive, changed in place by `step`.

    ``angle``: angle of the drive, rad, by its encoder, or without one by its commands.
    """

    SAVED = ("angle",)

    angle: float = 0.0
    integral: float = 0.0  # rad
    rate: float = 0.0  # rad/s, smoothed
    gyro_time: float = -math.inf  # s, of the frame with the last reading
    times: ReadingTimes = field(default_factory=ReadingTimes)  # of the encoder
    last: tuple[float, bool] = (-math.inf, False)  # s, of the last step, and whether it had a fresh gyro


def yaw_rate(settings: YawSettings, state: YawState, frame: SensorFrame, yaw: float, dt: float) -> float:
    """Return the yaw drive's speed, rad/s, for the next *dt*, s, with the estimated *yaw*, rad; NaN: it stands."""
    now, error = frame.time, wrap_angle(yaw - settings.held)
    for reading in frame.of(Inertial):
        if math.isfinite(reading.rate[2]):
            state.rate += min(1.0, dt / _SMOOTHING) * (float(reading.rate[2]) - state.rate)
            state.gyro_time = now
    for angle in frame.of(YawAngle):
        if math.isfinite(angle.angle) and state.times.is_new(angle.source, angle.time, now):
            state.angle = angle.angle
    if not abs(error) <= GIVE_UP:
        state.last = -math.inf, False
        return 0.0
    fast = max(now - state.gyro_time, dt) <= _FRESH
    stiffer, damping = (_STIFFER, _DAMPING) if fast else (0.0, 0.0)
    (then, was_fast), state.last = state.last, (now, fast)
    if fast is not was_fast or now - then > 2.5 * dt:  # begin with the drive where it stands
        state.integral = state.angle + stiffer * error + damping * state.rate
    wanted = state.integral - stiffer * error - damping * state.rate
    target = min(max(wanted, -settings.travel), settings.travel)
    if target == wanted or error * wanted > 0.0:
        state.integral -= (1.0 + stiffer) / (_TURNS * settings.turn) * error * dt
    speed = (target - state.angle) / max(_APPROACH, 2.0 * dt)
    speed = min(max(speed, -settings.max_speed), settings.max_speed)
    state.angle += speed * dt
    return speed
