"""Active faults of an estimate, and detection of silent sensors."""

from __future__ import annotations

from cablewright.foundation.reading_times import ReadingTimes, Timeliness
from cablewright.foundation.signals import Fault

_BRIEF_FAULT_TIME = 10.0  # s for which a momentary fault stays active


class FaultMonitor:
    """Active faults, each from its first report until it is cleared, and the time of each source's last reading."""

    def __init__(self, timeouts: dict[str, float]) -> None:
        """Expect readings from all sources of *timeouts*: s by source, after which silence is a fault."""
        self._timeouts = timeouts
        self._times = ReadingTimes()
        self._start_time: float | None = None
        self._active: dict[tuple[str, str], Fault] = {}
        self._faults: tuple[Fault, ...] | None = ()
        self._now = 0.0

    @property
    def faults(self) -> tuple[Fault, ...]:
        """Faults of sensors that are active."""
        if self._faults is None:
            self._faults = tuple(self._active.values())
        return self._faults

    def is_new(self, source: str, time: float, now: float) -> bool:
        """Return whether a reading of a *source* at *time*, s, is newer than the last one and not ahead of *now*, s."""
        self._now = now
        found = self._times.judge(source, time, now)
        if found is Timeliness.AHEAD:
            self.report(source, "clock", f"a reading of {time:g} s arrived at {now:g} s: not used")
        return found is Timeliness.NEW

    def report(self, source: str, kind: str, sentence: str) -> None:
        """Activate a fault of a sensor; an active fault keeps its start time and sentence."""
        if (source, kind) not in self._active:
            self._active[source, kind] = Fault(source, self._now, sentence)
            self._faults = None

    def clear(self, source: str, kind: str) -> None:
        """Mark a fault of a sensor as ended."""
        if self._active and self._active.pop((source, kind), None) is not None:
            self._faults = None

    def set(self, source: str, kind: str, sentence: str, *, active: bool) -> None:
        """Mark a fault of a sensor as active or as ended."""
        if active:
            self.report(source, kind, sentence)
        else:
            self.clear(source, kind)

    def is_active(self, source: str, kind: str) -> bool:
        """Return whether a fault *kind* of the sensor *source* was detected and has not ended."""
        return (source, kind) in self._active

    @property
    def has_faults(self) -> bool:
        """Whether any fault is active."""
        return bool(self._active)

    def concerns(self, source: str) -> bool:
        """Return whether any fault of a *source* is active."""
        return any(fault.source == source for fault in self._active.values())

    def restart(self, now: float, sentence: str) -> None:
        """Reset all reading times, because the clock jumped back to *now*, s; *sentence* is that fault's."""
        self._times.clear()
        self._active = {key: Fault(old.source, now, old.sentence) for key, old in self._active.items()}
        self._start_time, self._now = now, now
        self.clear("clock", "back")
        self.report("clock", "back", sentence)

    def check_timeouts(self, now: float) -> None:
        """Report silent sources at *now*, s, and clear momentary faults that have been shown long enough."""
        self._now = now
        if self._start_time is None:
            self._start_time = now
        active, times, start = self._active, self._times.times, self._start_time
        for source, timeout in self._timeouts.items():
            last = times.get(source, start)
            if now - last > timeout:
                if (source, "quiet") not in active:
                    active[source, "quiet"] = Fault(source, last, f"no reading for over {timeout:g} s")
                    self._faults = None
            elif active:
                self.clear(source, "quiet")
        if not active:
            return
        for key in (("clock", "back"), ("encoders", "jump")):
            fault = self._active.get(key)
            if fault is not None and now - fault.since > _BRIEF_FAULT_TIME:
                self.clear(*key)
