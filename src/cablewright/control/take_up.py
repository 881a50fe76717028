"""Taking up slack: winch by winch to a low tension, in torque mode, within limits of length and speed.

A line that pulls already is held: in torque mode at a low tension it would let its load down. So is a drum that winds
one line up as it pays another out: no torque makes both taut.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.control.procedure import ProcedureStep
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import require_positive
from cablewright.foundation.reading_times import ReadingTimes
from cablewright.foundation.signals import Encoders, Estimate, SensorFrame, Tensions, WinchMode

PULLS: Final = 0.5
"""Share of the tension from which a line is taut already; pushing by as much, its sign is wrong."""

_REACHED: Final = 0.8  # share of it at which a line is taut
_CALM: Final = 0.5  # s for which it has to stand there
_CREEP: Final = 2e-3  # m of cable in this time of a line that stands
_SURE: Final = 0.02  # m of cable after which it is judged whether a line tightens
_SLACKENS: Final = 0.5  # smallest share of its tension that a line has while it is reeled in
_TIME: Final = 60.0  # s for one line
_SILENCE: Final = 0.5  # s without tensions or counts
_TENSIONS, _COUNTS = "tensions", "counts"


@dataclass(frozen=True, eq=False)
class TakeUpSettings:
    """Settings for taking up slack. ``tension``: N, of a taut line. ``max_length``: m of cable to reel in at most.

    ``names``: names of the w winches, from their lines. ``counts_per_radian``: encoder counts per radian of a winch
    drum. ``radius``: m, the drums' largest. ``arms`` (w,): m, torque of a drum over the tension of one cable on it.
    ``opposed`` (w,): drums with lines that pull against each other. Both None: a line alone is on each drum.
    """

    names: tuple[str, ...]
    tension: float
    counts_per_radian: float
    radius: float
    max_length: float = 0.3
    arms: Array | None = None
    opposed: Mask | None = None

    def __post_init__(self) -> None:
        """Raise `InputError` for numbers that are not positive and finite."""
        numbers = ("tension", "counts_per_radian", "radius", "max_length")
        require_positive(**{name: getattr(self, name) for name in numbers})


class TakeUp:
    """The `Procedure` that takes up slack.

    `tensions` (w,), N, `torques` (w,), N m, and `counts` (w,) are the last ones read.
    """

    def __init__(self, settings: TakeUpSettings) -> None:
        """Not yet begun."""
        self.settings = settings
        self._opposed = np.zeros(len(settings.names), bool) if settings.opposed is None else settings.opposed
        self.begin(0.0)

    def begin(self, now: float) -> None:
        """Begin the procedure at *now*, s; see `Procedure.begin`."""
        self.tensions: Array | None = None
        self.torques: Array | None = None
        self.counts: NDArray[np.int64] | None = None
        self.reeled = np.zeros(len(self.settings.names))  # m, of each line
        self._line, self._next = -1, 0
        self._begin = self._since = now
        self._times = ReadingTimes()
        self._begun: tuple[int, float] = (0, 0.0)  # counts and tension of the line as it began
        self._places: deque[tuple[float, float]] = deque()

    def step(self, frame: SensorFrame, _estimate: Estimate, _dt: float) -> ProcedureStep:
        """Return the winch commands for the next *dt*, s; see `Procedure.step`."""
        now = frame.time
        if not self.hear(frame):
            return self.hold("no tensions or counts are read" if now - self._oldest > _SILENCE else "")
        assert self.tensions is not None
        assert self.counts is not None
        worst = int(np.argmin(told := np.where(self._opposed, np.inf, self.tensions)))
        if told[worst] < -PULLS * self.settings.tension:
            return self.hold(f"line {self._name(worst)} pulls with {told[worst]:.0f} N: {WRONG_SIGN}")
        if self._line >= 0:
            failure = self._judge(now, float(self.tensions[self._line]), int(self.counts[self._line]))
            if failure:
                return self.hold(failure)
        while self._line < 0 and self._next < len(self.settings.names):
            if self.tensions[self._next] < PULLS * self.settings.tension and not self._opposed[self._next]:
                self._line, self._since = self._next, now
                self._begun = int(self.counts[self._line]), float(self.tensions[self._line])
                self._places.clear()
            self._next += 1
        if self._line < 0:
            return ProcedureStep(self._still(), self._held(), finished=True)
        modes = list(self._held())
        modes[self._line] = WinchMode.TENSION
        asked = np.full(len(modes), np.nan)
        asked[self._line] = self.settings.tension
        return ProcedureStep(self._still(), tuple(modes), asked)

    def hear(self, frame: SensorFrame) -> bool:
        """Process the readings of a frame; return whether there are new tensions and counts of all winches."""
        m = len(self.settings.names)
        for reading in frame.of(Tensions):
            pulls = pulls_of(reading, self.settings.arms)
            whole = len(pulls) == m and np.isfinite(pulls).all()
            if whole and self._times.is_new(_TENSIONS, reading.time, frame.time):
                self.tensions, self.torques = np.array(pulls), reading.torques
        for encoders in frame.of(Encoders):
            if len(encoders.counts) == m and self._times.is_new(_COUNTS, encoders.time, frame.time):
                self.counts = np.array(encoders.counts)
        known = self.tensions is not None and self.counts is not None
        return known and frame.time - self._oldest <= _SILENCE

    @property
    def _oldest(self) -> float:
        """Time of the older one of the last tensions and counts, s; before the first, when the procedure began."""
        return min(self._times.last(source, self._begin) for source in (_TENSIONS, _COUNTS))

    def hold(self, failure: str = "") -> ProcedureStep:
        """Hold all winches; with a *failure* the procedure ends."""
        return ProcedureStep(self._still(), self._held(), failure=failure)

    def _judge(self, now: float, tension: float, counts: int) -> str:
        """Go on with the next line where this one is taut; return what is wrong with it, or an empty text."""
        settings, name, (begin, first) = self.settings, self._name(self._line), self._begun
        paid = (counts - begin) / settings.counts_per_radian * settings.radius
        self.reeled[self._line] = -paid
        if paid > _SURE:
            why = f"it is overloaded, or {WRONG_SIGN}"
            return f"line {name} pays out {1e3 * paid:.0f} mm where it should be taken up: {why}"
        if -paid > settings.max_length:
            why = f"it is longer than that, caught, or {WRONG_SIGN}"
            return f"line {name} was reeled in by {-paid:.2f} m and is not taut: {why}"
        tightened = tension >= _REACHED * settings.tension
        if -paid > _SURE and first > 0.1 * settings.tension and tension < _SLACKENS * first:
            return f"line {name} slackens where it should tighten, from {first:.0f} to {tension:.0f} N: {WRONG_SIGN}"
        if now - self._since > _TIME:
            return f"line {name} is not taut after {_TIME:g} s: {tension:.0f} N of {settings.tension:g} N"
        self._places.append((now, paid))
        while self._places[0][0] < now - _CALM:
            self._places.popleft()
        calm = now - self._since > _CALM and abs(paid - self._places[0][1]) < _CREEP
        if tightened and calm:
            self._line = -1
        return ""

    def _name(self, line: int) -> str:
        return self.settings.names[line]

    def _still(self) -> Array:
        return np.zeros(len(self.settings.names))

    def _held(self) -> tuple[WinchMode, ...]:
        return (WinchMode.HOLD,) * len(self.settings.names)


def pulls_of(reading: Tensions, arms: Array | None) -> Array:
    """Return the tension (w,), N, of a cable on each drum by a reading; *arms* as in `TakeUpSettings`."""
    if arms is None or reading.torques is None or len(reading.torques) != len(arms):
        return reading.tensions
    return np.asarray(reading.torques / arms)


WRONG_SIGN: Final = "its direction in the machine file is wrong, or its gear's sign in the drive"
