"""Homing: lines are taken up, and saved lengths compared with where taut lines can meet; or lengths are found anew.

New lengths come from a place that a person has measured. Only a machine whose lengths have passed is ready to move.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array
from cablewright.control.length_check import LengthCheck, check_lengths, lengths_at
from cablewright.control.procedure import ProcedureStep
from cablewright.control.take_up import TakeUp, TakeUpSettings
from cablewright.control.three_poses import SlowWay, places, sentence
from cablewright.errors import AnswerError, CablewrightError, Status
from cablewright.models.statics import Model
from cablewright.signals import Estimate, SensorFrame
from cablewright.solvers.continuation import Tracker

_CALM: Final = 1.0  # s after the last line
_MEASURED: Final = 0.5  # s over which tensions are averaged
_APART: Final = 0.05  # m between two places that are one


@dataclass(frozen=True, eq=False)
class HomingSettings:
    """``lengths``: those at counts by what was saved, m; None: nothing valid was. ``accept``: takes what was found.

    ``guess``: (3,) m, roughly where the platform is. ``place``: (3,) m, where a person has measured it; None: nobody.
    ``frame``: corners (3,), m, between which the platform may be moved to find which line is wrong; None: it is not.
    """

    model: Model
    take_up: TakeUpSettings
    lengths: Callable[[NDArray[np.int64]], Array | None]
    accept: Callable[[Array, NDArray[np.int64]], None]
    guess: Array
    place: Array | None = None
    frame: tuple[Array, Array] | None = None


class Homing:
    """A `Procedure`; `position` is where the platform was found."""

    def __init__(self, settings: HomingSettings) -> None:
        """Not yet begun."""
        self.settings = settings
        self.take_up = TakeUp(settings.take_up)
        self.position: Array | None = None
        self.misfit = np.nan
        self.begin(0.0)

    def begin(self, now: float) -> None:
        """As `Procedure`."""
        self.take_up.begin(now)
        self._taut_since = np.nan
        self._tensions: list[Array] = []
        self._checks: list[LengthCheck] = []
        self._ways: list[Array] = []  # places still to go to
        self._way: SlowWay | None = None
        self.position = None

    def step(self, frame: SensorFrame, estimate: Estimate, dt: float) -> ProcedureStep:
        """As `Procedure`."""
        if self._way is not None:
            return self._go(frame, dt)
        if np.isnan(self._taut_since):
            done = self.take_up.step(frame, estimate, dt)
            if not done.finished:
                return done
            self._taut_since = frame.time
        if not self.take_up.hear(frame):
            return self.take_up.hold("no tensions or counts are read")
        assert self.take_up.tensions is not None
        since = frame.time - self._taut_since
        if since > _CALM:
            self._tensions.append(self.take_up.tensions)
        if since < _CALM + _MEASURED or not self._tensions:
            return self.take_up.hold()
        failure = self._compare(np.mean(self._tensions, axis=0))
        if failure and self._goes_on():
            return self.take_up.hold()
        held = self.take_up.hold(failure)
        return held if failure else held._replace(finished=True)

    def _goes_on(self) -> bool:
        """Whether the next place is gone to, as more than one line could be wrong. The lengths are refused anyway."""
        own, checks = self.settings, self._checks
        if not checks or checks[0].fits or len(checks[0].suspects) < 2 or own.frame is None:
            return False
        if len(checks) == 1:
            self._ways = places(own.model, *own.frame, checks[0].position)
        if not self._ways:
            return False
        assert self.take_up.counts is not None
        lengths = own.lengths(self.take_up.counts)
        assert lengths is not None  # they were compared
        self._way = SlowWay(checks[-1].position, self._ways.pop(0), lengths, own.take_up.radius)
        return True

    def _go(self, frame: SensorFrame, dt: float) -> ProcedureStep:
        """One step on the way; at its end slack is taken up again."""
        assert self._way is not None
        if not self.take_up.hear(frame):
            return self.take_up.hold("no tensions or counts are read")
        assert self.take_up.counts is not None
        lengths = self.settings.lengths(self.take_up.counts)
        if lengths is None:
            return self.take_up.hold("the counts are beyond the turns of a drum")
        speeds = self._way.speeds(self.settings.model, lengths, dt)
        if not self._way.arrived:
            return ProcedureStep(speeds)
        self._way, self._taut_since = None, np.nan
        self._tensions.clear()
        self.take_up.begin(frame.time)
        return self.take_up.hold()

    def _compare(self, tensions: Array) -> str:
        """Accept the lengths, or return why not."""
        own, counts = self.settings, self.take_up.counts
        assert counts is not None
        lengths = own.lengths(counts)
        if lengths is None:
            if own.place is None:
                return "no valid lengths are saved: measure where the platform is and home with that place"
            lengths = lengths_at(own.model, own.place, tensions)
        found = check_lengths(own.model, lengths, tensions, own.guess if own.place is None else own.place)
        if found is None:
            return "the saved lengths meet nowhere near the last place: home with a measured place"
        self._checks.append(found)
        self.misfit = self._checks[0].misfit
        if not self._checks[0].fits:
            return sentence(self._checks, own.take_up.names)
        if not found.tested and own.place is None:
            return (
                "there are no more lines than freedoms, so that nothing tests the lengths: home with a measured place"
            )
        if own.place is not None and (apart := float(np.linalg.norm(found.position - own.place))) > _APART:
            return f"the saved lengths meet {apart:.3f} m from the measured place; at most {_APART:g} is allowed"
        return self._certified(lengths, counts, found.position)

    def _certified(self, lengths: Array, counts: NDArray[np.int64], place: Array) -> str:
        """Accept lengths whose equilibrium, proved to be the only one there, is at that place; or return why not."""
        own = self.settings
        try:
            tracker = Tracker(own.model, lengths)
            status = tracker.step(lengths)
        except AnswerError as error:
            return f"the lengths have no equilibrium: {error}"
        if status is not Status.OK:
            return f"the equilibrium of the lengths: {status.value}"
        apart = float(np.linalg.norm(tracker.pose - place))
        if apart > _APART:
            return f"the lengths' equilibrium is {apart:.3f} m from where they meet; at most {_APART:g} is allowed"
        try:
            own.accept(lengths, counts)
        except CablewrightError as error:
            return f"the lengths could not be kept: {error}"
        self.position = tracker.pose.copy()
        return ""
