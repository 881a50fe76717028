"""Check that disabled drives report that they are disabled, within the time that they need."""

from __future__ import annotations

import math
from collections.abc import Sequence

from cablewright.machine.drives.axis import FRESH, Axis
from cablewright.machine.drives.settings import WinchDriveSettings


class OffWatch:
    """Watch over drives that must be disabled: if one does not obey or answer, the heartbeat ends, so that it stops."""

    def __init__(self, axes: Sequence[Axis], settings: WinchDriveSettings) -> None:
        """*settings*: how long each may take."""
        self._axes, self._own = axes, settings
        self.limit = settings.stop_time(max(axis.scale.speed_of_cable for axis in axes))  # s
        self._since = math.nan  # s, when all were first commanded to be disabled

    def begin(self, now: float) -> None:
        """Begin the check: all drives are commanded to be disabled, at *now*, s, or earlier."""
        if math.isnan(self._since):
            self._since = now

    def end(self) -> None:
        """End the check that drives are without torque: they may be enabled."""
        self._since = math.nan

    def unproven(self, now: float) -> list[Axis]:
        """Return the drives that have not confirmed that they are disabled."""
        return [axis for axis in self._axes if not axis.rests(now)]

    def disobeys(self, now: float) -> str:
        """Return a sentence on a drive that is not disabled in time, or silent; empty: none."""
        if math.isnan(self._since):
            return ""
        own = self._own
        for axis in self._axes:
            if now - max(axis.state_heard, self._since) > own.answer_timeout + FRESH:
                return f"{axis.name}: it was switched off, but its drive does not answer"
            if now - self._since > self.limit and now - axis.energised < own.brake_time:
                return f"{axis.name}: it was switched off, but is still {axis.state.value}"
        return ""
