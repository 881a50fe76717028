"""Jog of one winch while a button is held, with a limit of its line's tension."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from cablewright.control.manual import LEASE, MAX_SPEED, require_run_out
from cablewright.control.procedure import ProcedureStep
from cablewright.control.take_up import WRONG_SIGN, pulls_of
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.reading_times import ReadingTimes
from cablewright.foundation.signals import Estimate, SensorFrame, Tensions

_RAMP: Final = 0.2  # m/s^2 of cable
_END: Final = 0.5  # s after the last lease until the procedure ends
_SILENCE: Final = 0.5  # s without a tension of the line


@dataclass(frozen=True)
class WinchJogSettings:
    """Settings of a jog of one winch. ``line``: index of the line on it; ``lines``: number of lines of the robot.

    ``speed``: speed of the cable, m/s, positive pays out. ``max_tension``: highest tension of the line while it reels
    in, N. ``radius``: largest radius of the drum, m, so that cable is never faster. ``min_tension``: N, under which the
    sign of a line that is held must be wrong; (w,) where that differs by drum. ``deceleration``: deceleration of the
    cable when the button is released, m/s^2. ``max_run_out``: largest length of cable from the last order to rest, m.
    ``delay``: time from an order to the motion, s. ``arms``: radii by which lines act, see `TakeUpSettings`.
    ``opposed``: the drum reels another line in as it pays this one out.
    """

    line: int
    lines: int
    speed: float
    max_tension: float
    radius: float
    min_tension: float | Array = -math.inf
    deceleration: float = _RAMP
    max_run_out: float = math.inf
    delay: float = 0.0
    arms: Array | None = None
    opposed: bool = False

    def __post_init__(self) -> None:
        """Raise `InputError` for a speed that is not allowed by hand, or from which it would not stop in time."""
        if not 0.0 < abs(self.speed) <= MAX_SPEED:
            raise InputError(f"jog: {self.speed:g} m/s of cable; over 0 and at most {MAX_SPEED:g} is allowed by hand")
        require_run_out(abs(self.speed), self.deceleration, self.delay, self.max_run_out)


class WinchJog:
    """The `Procedure` of a winch jog; the holder of the button calls `lease` again and again."""

    def __init__(self, settings: WinchJogSettings) -> None:
        """Not yet begun."""
        self.settings = settings
        self.begin(0.0)

    def begin(self, now: float) -> None:
        """Begin the procedure at *now*, s; see `Procedure.begin`."""
        self._times = ReadingTimes()
        self._asked = False  # earlier requests do not count
        self._lease_end, self._read, self._speed, self._tension = now, now, 0.0, math.nan
        self._now = now

    def lease(self) -> None:
        """Extend the jog by the time `LEASE` from the next step on."""
        self._asked = True

    def let_go(self) -> None:
        """Stop the jog with the next step, as after the release of its button."""
        self._asked, self._lease_end = False, min(self._lease_end, self._now)

    def step(self, frame: SensorFrame, _estimate: Estimate, dt: float) -> ProcedureStep:
        """Return the winch commands for the next *dt*, s; see `Procedure.step`.

        It ends when requests stop, and fails where the line's tension is not known.
        """
        own, now = self.settings, frame.time
        self._now = now
        if self._asked:
            self._lease_end, self._asked = now + LEASE, False
        speeds = np.zeros(own.lines)
        for reading in frame.of(Tensions):
            pulls = pulls_of(reading, own.arms)
            if len(pulls) == own.lines and self._times.is_new(reading.source, reading.time, now):
                if math.isnan(self._tension) and (wrong := pulls < own.min_tension).any():
                    return ProcedureStep(speeds, failure=f"a line pulls with {pulls[wrong].min():.0f} N: {WRONG_SIGN}")
                if math.isfinite(tension := float(pulls[own.line])):
                    outwards = own.opposed and own.speed > 0.0  # it reels the other line in
                    self._tension, self._read = -tension if outwards else tension, reading.time
        if now - self._read > _SILENCE:
            return ProcedureStep(speeds, failure=f"no tension of the line was read for {_SILENCE:g} s")
        if math.isnan(self._tension):
            return ProcedureStep(speeds)
        wish = own.speed if now < self._lease_end else 0.0
        if (own.speed < 0.0 or own.opposed) and self._tension >= own.max_tension:
            self._speed = wish = 0.0  # immediately: a ramp would go on reeling in
        change = (own.deceleration if not wish else _RAMP) * dt
        self._speed += min(max(wish - self._speed, -change), change)
        speeds[own.line] = self._speed / own.radius
        return ProcedureStep(speeds, finished=not self._speed and now >= self._lease_end + _END)
