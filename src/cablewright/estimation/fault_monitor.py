"""Which sensors are heard, and what is wrong with them: the faults that an estimate names."""

from __future__ import annotations

import math

from cablewright.signals import (
    Barrier,
    Climate,
    DistanceReading,
    Encoders,
    Fault,
    Inertial,
    LineAngles,
    Reading,
    Scan,
)

__all__ = ["Watch"]

_NAMES: dict[type, str] = {
    Barrier: "barrier",
    Climate: "climate",
    DistanceReading: "distance",
    Encoders: "encoders",
    Inertial: "inertial",
    LineAngles: "line_angles",
}
_AHEAD = 1e-6  # s by which a reading may be ahead of its frame
_SHOWN = 10.0  # s for which a fault that was over at once is told


class Watch:
    """Keeps a fault from when it began until it is over. ``quiet``: s by source without a reading."""

    def __init__(self, quiet: dict[str, float]) -> None:
        """Expect all sources of *quiet*."""
        self._quiet = quiet
        self._last: dict[str, float] = {}
        self._begin: float | None = None
        self._faults: dict[tuple[str, str], Fault] = {}
        self._told: tuple[Fault, ...] | None = ()
        self._now = 0.0

    @property
    def faults(self) -> tuple[Fault, ...]:
        """What is wrong now."""
        if self._told is None:
            self._told = tuple(self._faults.values())
        return self._told

    def heard(self, reading: Reading, now: float) -> str | None:
        """Whose *reading* this is; None if it is from the future or not newer than the last of its source."""
        source = reading.source if isinstance(reading, Scan) else _NAMES[type(reading)]
        self._now = now
        if not reading.time <= now + _AHEAD:
            self.say(source, "clock", f"a reading of {reading.time:g} s came at {now:g} s: left out")
            return None
        if not reading.time > self._last.get(source, -math.inf):
            return None
        self._last[source] = reading.time
        return source

    def say(self, source: str, kind: str, sentence: str) -> None:
        """Note a fault; one that goes on stays as it began."""
        if (source, kind) not in self._faults:
            self._faults[source, kind] = Fault(source, self._now, sentence)
            self._told = None

    def clear(self, source: str, kind: str) -> None:
        """Say that a fault is over."""
        if self._faults.pop((source, kind), None) is not None:
            self._told = None

    def has(self, source: str, kind: str) -> bool:
        """Whether a fault goes on."""
        return (source, kind) in self._faults

    def restart(self, now: float, sentence: str) -> None:
        """Forget when what was heard, since the clock begins anew at *now*."""
        self._last.clear()
        self._faults = {key: Fault(old.source, now, old.sentence) for key, old in self._faults.items()}
        self._begin, self._now = now, now
        self.clear("clock", "back")
        self.say("clock", "back", sentence)

    def check(self, now: float) -> None:
        """Say which sources are quiet at *now*, and forget what was over at once."""
        self._now = now
        if self._begin is None:
            self._begin = now
        for source, most in self._quiet.items():
            last = self._last.get(source, self._begin)
            if now - last > most:
                if (source, "quiet") not in self._faults:
                    self._faults[source, "quiet"] = Fault(source, last, f"nothing heard for over {most:g} s")
                    self._told = None
            else:
                self.clear(source, "quiet")
        for key in (("clock", "back"), ("encoders", "jump")):
            fault = self._faults.get(key)
            if fault is not None and now - fault.since > _SHOWN:
                self.clear(*key)
