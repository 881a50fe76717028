"""Stop of all winches together: a ramp, a hold, then closed brakes.

A stop never goes back. Category 1 of IEC 60204-1, or its last stages alone where a ramp would make things worse. It
advances by one period with each command: a step that comes late, or a clock that jumps, skips nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import require_positive
from cablewright.foundation.signals import WinchMode


class StopKind(IntEnum):
    """Kind of a stop: how it begins, and ends; the most urgent one counts."""

    RAMP = 0  # then hold, then brake
    HOLD = 1  # immediately, then brake
    KEEP = 2  # hold immediately and keep torque on: a brake cannot be relied on
    BRAKE = 3  # immediately: a winch has no torque


@dataclass(frozen=True)
class StopSettings:
    """Settings of stops. ``ramp_time``: duration of the winches' common ramp, s.

    ``hold_time``: time for which winches hold before brakes close, s.
    """

    ramp_time: float = 0.3
    hold_time: float = 0.5

    def __post_init__(self) -> None:
        """Raise `InputError` for times that are not positive and finite."""
        require_positive(**vars(self))


@dataclass(eq=False)
class StopState:
    """A stop of winches that turned at ``speeds`` (m,), rad/s. Changed in place."""

    speeds: Array
    kind: StopKind = StopKind.RAMP
    brakes: bool = True  # whether it ends with brakes closed
    left: float = 1.0  # share of the speeds that is still commanded
    held: float = -1.0  # s since the first command of zero speed; negative: none yet
    braked: bool = False

    @classmethod
    def closed(cls, m: int) -> StopState:
        """Return the end of a stop of *m* winches: brakes are closed."""
        return cls(np.zeros(m), braked=True)

    def worsen(self, kind: StopKind) -> None:
        """Change to a more urgent *kind* of stop; a less urgent one changes nothing."""
        self.kind = max(self.kind, kind)

    def at_rest(self, settings: StopSettings) -> bool:
        """Whether the stop has finished: held for its time, or braked."""
        return self.braked or self.held >= settings.hold_time


def advance(settings: StopSettings, stop: StopState, dt: float) -> tuple[Array, WinchMode]:
    """Return speeds (m,), rad/s, and mode to command a period *dt*, s, after the last ones; *stop* changes in place."""
    none = np.zeros(len(stop.speeds))
    if stop.held >= 0.0:
        stop.held += dt
    ends = stop.brakes and stop.kind is not StopKind.KEEP and stop.held >= settings.hold_time
    if stop.braked or ends or stop.kind is StopKind.BRAKE:
        stop.braked = True
        return none, WinchMode.OFF
    if stop.kind is StopKind.RAMP and stop.held < 0.0 and stop.speeds.any():
        stop.left -= dt / settings.ramp_time
        if stop.left > 0.0:
            return stop.left * stop.speeds, WinchMode.VELOCITY
    stop.held = max(stop.held, 0.0)
    return none, WinchMode.HOLD
