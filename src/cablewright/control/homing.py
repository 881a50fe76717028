"""Homing: slack is taken up, then saved lengths are tested by where taut lines can meet, or lengths are found again.

New lengths come from a position that a person has measured; they replace saved ones, whose contradiction is reported.
Of a rigid platform that is a pose, and the measured tensions say how far its lines are stretched there. A plane holds
the platform, and with fewer winches than degrees of freedom its weight decides the rest of the pose. Either way the
tensions have to carry the platform there. Only a machine whose lengths have passed is ready to move. Quantities that no
test can check are reported too.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.control.balance_check import ForceBalance, balance
from cablewright.control.faulty_line_search import SlowWay, places, sentence
from cablewright.control.length_check import LIMIT, LengthCheck, check_lengths, lengths_at
from cablewright.control.procedure import ProcedureStep
from cablewright.control.take_up import TakeUp, TakeUpSettings
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import AnswerError, CablewrightError, Status
from cablewright.foundation.signals import Estimate, SensorFrame
from cablewright.models.plane import within
from cablewright.models.rotation import placed
from cablewright.models.statics import Equilibrium, Model
from cablewright.models.support_table import Capability, require
from cablewright.robot.plane import OFF_PLANE
from cablewright.solvers.certify import certify
from cablewright.solvers.continuation import Tracker
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.hanging_path import hung
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.taut import taut_at

_CALM: Final = 1.0  # s after the last line
_MEASURED: Final = 0.5  # s over which tensions are averaged
_APART: Final = 0.05  # m between two places that are one


@dataclass(frozen=True, eq=False)
class HomingSettings:
    """Settings of homing. ``lengths``: lengths at the present counts by saved data, m; None: there are none.

    ``accept``: function that takes the result. The arguments of ``accept`` are the lengths (m,), their counts (w,) and
    their pose (n,). ``guess``: approximate pose (n,), m and rad. ``place``: pose (n,) that a person has measured; None:
    not measured. ``frame``: corners (3,), m, between which the platform has to be, and may be moved to find which line
    is wrong. ``tensions``: function that returns the tensions (m,), N, for drum torques (w,), N m, lengths (m,), m, and
    expected tensions (m,), N. ``tension_error``: its allowed error, a share of the platform's weight. ``power_lost``:
    whether counters have begun again since the lengths were saved. ``laid``: function that returns the mass that has
    left the model's platform, kg.
    """

    model: Model
    take_up: TakeUpSettings
    lengths: Callable[[NDArray[np.int64]], Array | None]
    accept: Callable[[Array, NDArray[np.int64], Array], None]
    guess: Array
    frame: tuple[Array, Array]
    place: Array | None = None
    tensions: Callable[[Array, Array, Array], Array] = lambda torques, _lengths, _expected: torques
    tension_error: float = 0.1
    power_lost: Callable[[], bool] = lambda: False
    laid: Callable[[], float] = lambda: 0.0


class Homing:
    """A `Procedure`; `pose` (n,), m and rad, is where the platform was found."""

    def __init__(self, settings: HomingSettings) -> None:
        """Not yet begun. Raises `InputError` for a robot whose winches do not hold its position."""
        require(settings.model, Capability.HOMING)
        self.settings = settings
        self.take_up = TakeUp(settings.take_up)
        self.pose: Array | None = None
        self.misfit = np.nan
        self.begin(0.0)

    def begin(self, now: float) -> None:
        """Begin the procedure at *now*, s; see `Procedure.begin`."""
        self.take_up.begin(now)
        self._taut_since = np.nan
        self._torques: list[Array] = []
        self._checks: list[LengthCheck] = []
        self._ways: list[Array] = []  # places still to go to
        self._way: SlowWay | None = None
        self.pose, self.notes = None, list[str]()

    def step(self, frame: SensorFrame, estimate: Estimate, dt: float) -> ProcedureStep:
        """Return the winch commands for the next *dt*, s; see `Procedure.step`."""
        if self._way is not None:
            return self._go(frame, dt)
        if np.isnan(self._taut_since):
            done = self.take_up.step(frame, estimate, dt)
            if not done.finished:
                return done
            self._taut_since = frame.time
        if not self.take_up.hear(frame):
            return self.take_up.hold("no tensions or counts are read")
        if self.take_up.torques is None:
            return self.take_up.hold("no torques of the drums are read")
        since = frame.time - self._taut_since
        if since > _CALM:
            self._torques.append(self.take_up.torques)
        if since < _CALM + _MEASURED or not self._torques:
            return self.take_up.hold()
        try:
            failure = self._compare(np.mean(self._torques, axis=0))
        except AnswerError as error:
            failure = str(error)
        if failure and self._goes_on():
            return self.take_up.hold()
        held = self.take_up.hold(failure)
        return held if failure else held._replace(finished=True)

    def _goes_on(self) -> bool:
        """Whether the next place is gone to, as more than one line could be wrong. The lengths are rejected anyway."""
        own, checks = self.settings, self._checks
        if not checks or checks[0].fits or len(checks[0].suspects) < 2:
            return False
        if len(checks) == 1:
            self._ways = places(own.model, *own.frame, checks[0].pose)
        if not self._ways:
            return False
        assert self.take_up.counts is not None
        lengths = own.lengths(self.take_up.counts)
        assert lengths is not None  # they were compared
        self._way = SlowWay(checks[-1].pose, self._ways.pop(0), lengths, own.take_up.radius)
        return True

    def _go(self, frame: SensorFrame, dt: float) -> ProcedureStep:
        """One step of the motion to the next position; at its end slack is taken up again."""
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
        self._torques.clear()
        self.take_up.begin(frame.time)
        return self.take_up.hold()

    def _compare(self, torques: Array) -> str:
        """Accept the lengths by the *torques* (w,), N m, of the drums, or return why not."""
        own, counts = self.settings, self.take_up.counts
        assert counts is not None
        lengths = own.lengths(counts)
        if own.place is not None:
            return self._settled(own.place) or self._measured(lengths, torques, counts)
        if lengths is None:
            return "no valid lengths are saved: measure where the platform is and home with that place"
        tensions = self._tensions_at(own.guess, torques, lengths)
        found = check_lengths(own.model, lengths, tensions, own.guess)
        if found is None:
            return "the saved lengths meet nowhere near the last place: home with a measured place"
        self._checks.append(found)
        self.misfit = self._checks[0].misfit
        if not self._checks[0].fits:
            return sentence(self._checks, own.take_up.names)
        if not found.tested:
            return (
                "there are no more lines than degrees of freedom, so the lengths cannot be tested: home with a "
                "measured position"
            )
        if own.power_lost():
            self.notes.append("the counters were reset: only the lengths show whether a winch drum moved meanwhile")
        unseen = "not tested: lengths that are wrong together, so that they meet elsewhere,"
        return self._carried(found.pose, torques, lengths, unseen) or self._certified(lengths, counts, found.pose)

    def _settled(self, measured: Array) -> str:
        """Find the pose of a *measured* place (n,): in the platform's plane, and as its weight turns it; or why not."""
        model = self.settings.model
        inside = within(model.robot.platform.plane, measured)
        apart = self._apart(inside, measured)
        if apart > _APART:
            return f"the measured place is {apart:.3f} m off the platform's plane; at most {_APART:g} m is allowed"
        if apart > OFF_PLANE:
            self.notes.append(f"the measured place is {1e3 * apart:.3g} mm off the platform's plane: its foot is taken")
        hanging = hung(model, inside[None])
        if np.isnan(hanging).any():
            found = solve_inverse(model, hanging)[0]
            if not found.ok:
                return f"the platform cannot hang at the measured place: {found.sentence()}"
            inside = found.pose
        self._place = inside
        return ""

    def _measured(self, saved: Array | None, torques: Array, counts: NDArray[np.int64]) -> str:
        """Accept lengths by a measured place, whatever was *saved*; or return why not."""
        own, place = self.settings, self._place
        pulls = self._tensions_at(place, torques, taut_at(own.model, place).lengths)
        lengths = lengths_at(own.model, place, pulls)
        self.misfit = 0.0
        if saved is not None:
            self._contradict(place, saved, lengths, pulls)
        unseen = "not tested: the measured place,"
        return self._carried(place, torques, lengths, unseen) or self._certified(lengths, counts, place)

    def _contradict(self, place: Array, saved: Array, lengths: Array, pulls: Array) -> None:
        """Report the saved lengths where they contradict the new ones."""
        own = self.settings
        off = np.where(np.isin(np.arange(own.model.m), own.model.robot.hung), 0.0, lengths - saved)
        if float(np.abs(off).max()) <= LIMIT:
            return
        found = check_lengths(own.model, saved, pulls, place)
        where = "nowhere"
        if found is not None:
            where = f"{self._apart(found.pose, place):.3f} m from it, by {1e3 * found.misfit:.0f} mm"
        names = [line.name for line in own.model.robot.lines]
        changes = ", ".join(f"{name} {1e3 * each:+.0f} mm" for name, each in zip(names, off.tolist(), strict=True))
        self.notes.append(f"the saved lengths contradict the measured place: they meet {where}; replaced: {changes}")

    def _tensions_at(self, pose: Array, torques: Array, lengths: Array) -> Array:
        """Return the tensions (m,), N, by *torques* (w,), N m, with the platform thought to be at *pose* (n,).

        Raises `AnswerError` where they depend on those expected there, and it cannot hang there.
        """
        model = self.settings.model
        held = solve_inverse(model, hung(model, within(model.robot.platform.plane, pose)[None]))[0]
        found = self.settings.tensions(torques, lengths, held.tensions)
        if not np.isfinite(found).all():
            at = ", ".join(f"{each:.2f}" for each in pose[:3].tolist())
            raise AnswerError(f"the platform cannot hang at {at} m: {held.sentence()}")
        return found

    def _carried(self, place: Array, torques: Array, lengths: Array, unseen: str) -> str:
        """Why the platform cannot be at *place*: it is outside the frame, or the lines would not carry it there."""
        low, high = self.settings.frame
        for axis, least, at, most in zip("xyz", low.tolist(), place[:3].tolist(), high.tolist(), strict=True):
            if not least - _APART <= at <= most + _APART:
                return (
                    f"the platform would be outside the frame: {axis} = {at:.3f} m; {least:g} to {most:g} m is allowed"
                )
        own = self.settings
        found = balance(
            own.model, place, lambda at: self._tensions_at(at, torques, lengths), own.tension_error, own.laid()
        )
        if not found.holds:
            return found.sentence()
        self.notes.append(f"{unseen} by less than {self._unseen(found)}: from there on the tensions show it")
        return ""

    def _unseen(self, found: ForceBalance) -> str:
        """The distance, and of a rigid platform the turn, by which a pose may be wrong with tensions that still fit."""
        apart = f"{found.reach:.2f} m"
        if self.settings.model.n == 3:
            return apart
        return f"{apart} or " + (f"{math.degrees(found.turn):.0f} deg" if found.turn < math.pi else "any turn")

    def _certified(self, lengths: Array, counts: NDArray[np.int64], place: Array) -> str:
        """Accept lengths whose equilibrium, proved to be the only one there, is at that place; or return why not."""
        own = self.settings
        if any(line.cable.creep is not None for line in own.model.robot.lines):
            self.notes.append("not counted: creep of cables, because the load history is unknown")
        if (retraction := own.model.robot.retraction) is not None:
            self.notes.append(f"not measured: the length of the platform, {retraction.length:g} m by the robot file")
        try:
            near = None if own.model.n == 3 else solve_forward(own.model, lengths, guess=place).checked()
            tracker = Tracker(own.model, lengths, begin=near)
            status = tracker.step(lengths)
        except AnswerError as error:
            return f"the lengths have no equilibrium: {error}"
        if status is not Status.OK:
            return self._unproved(status, tracker.solved)
        apart = self._apart(tracker.pose, place)
        if apart > _APART:
            return f"the lengths' equilibrium is {apart:.3f} m from where they meet; at most {_APART:g} is allowed"
        try:
            own.accept(lengths, counts, tracker.pose)
        except CablewrightError as error:
            return f"the lengths could not be kept: {error}"
        self.pose = tracker.pose.copy()
        return ""

    def _unproved(self, status: Status, found: Equilibrium) -> str:
        """What failed in the proof that the equilibrium *found* is the only one near, and the next step."""
        steps = "change the tensions, or measure another place, and home again"
        if status is not Status.UNCERTIFIED:
            return f"the pose of the lengths cannot be followed: {status.value}; {steps}"
        reason = str(certify(found).reason()[0]).removeprefix("not certified: ")
        slack = found.tensions[0] < found.lines.tension_min[0]
        names = [line.name for line, loose in zip(self.settings.model.robot.lines, slack, strict=True) if loose]
        if names:
            steps = f"tension {', '.join(map(repr, names))}, below the min tension, and home again"
        return f"the pose of the lengths is not proved to be the only one near: {reason}; {steps}"

    def _apart(self, pose: Array, other: Array) -> float:
        """The way, m, of the platform point that moves farthest from one pose (n,) to the *other*."""
        points = [line.platform_point for line in self.settings.model.robot.lines]
        return float(np.linalg.norm(placed(pose, points) - placed(other, points), axis=1).max())
