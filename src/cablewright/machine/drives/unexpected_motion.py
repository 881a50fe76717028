"""Detection of winches that turn otherwise than commanded, which their own drives may not detect."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array
from cablewright.machine.drives.axis import Axis, Setpoint
from cablewright.machine.drives.objects import Mode
from cablewright.machine.drives.settings import WinchDriveSettings

_HALF: Final = 1 << 31  # of a drive's counter
_FORGETTING: Final = 0.1  # m of commanded way within which a deviation is forgotten
_TOO_FAR: Final = 5e-3  # m that a winch may go beyond its speed limit under torque


class StrayWatch:
    """Watch over each winch's deviation from its commanded motion, by encoder counts.

    The deviation is forgotten along the commanded motion, so that small errors of speeds do not add up, and never while
    a winch is held: a creep is detected however slow it is. Under torque it is the way beyond the speed limit.
    """

    def __init__(self, settings: WinchDriveSettings) -> None:
        """*settings*: limits."""
        self._own = settings
        self._before: tuple[float, NDArray[np.int64]] | None = None  # s, counts
        self._off: Array = np.zeros(0)  # rad

    def forget(self) -> None:
        """Forget earlier deviations of winches from their commands."""
        self._before = None

    def judge(self, axes: Sequence[Axis], setpoints: Sequence[Setpoint], time: float) -> str:
        """Return a sentence on a winch that deviates, from the answers at *time*, s; empty: none."""
        if any(axis.pending for axis in axes):
            return ""
        counts = np.array([axis.counts for axis in axes], dtype=np.int64)
        before, self._before = self._before, (time, counts)
        if before is None:
            self._off = np.zeros(len(axes))
            return ""
        dt = time - before[0]
        turned = (counts - before[1] + _HALF) % (2 * _HALF) - _HALF  # counters wrap
        angles = turned / np.array([abs(axis.scale.counts) for axis in axes])
        radii = np.array([axis.scale.radii[1] for axis in axes])
        asked = np.array([axis.commanded for axis in axes])
        velocity = self._off * np.exp(-np.abs(asked) * radii * dt / _FORGETTING) + angles - asked * dt
        allowed = self._own.tension_speed / radii * dt
        torque = np.maximum(self._off, 0.0) + np.abs(angles) - allowed
        under_torque = np.array([each.mode is Mode.TORQUE for each in setpoints])
        self._off = np.where(under_torque, np.maximum(torque, 0.0), velocity)
        lengths = np.abs(self._off) * radii
        most = np.where(under_torque, min(_TOO_FAR, self._own.following_error), self._own.following_error)
        worst = int(np.argmax(lengths / most))
        if lengths[worst] <= most[worst]:
            return ""
        name = axes[worst].name
        if under_torque[worst]:
            size = f"{1e3 * lengths[worst]:.0f} mm"
            return (
                f"{name}: its winch moved {size} beyond its speed limit under torque, {self._own.tension_speed:g} m/s"
            )
        return astray(name, lengths[worst])


def astray(name: str, length: float) -> str:
    """Return a sentence: the winch of the line called *name* is a *length*, m, away from its command."""
    return f"{name}: its winch is {1e3 * length:.0f} mm from where it was commanded"


def slipping(stray: str) -> str:
    """Return the sentence of `astray` with the addition that the brake is closed."""
    return f"{stray}, which its brake should hold: secure the load"
