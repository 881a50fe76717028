"""The guard of a machine: measured values against limits, in every state, before anything else.

It needs no estimate: tensions are measured, by load cells or torques, and those that follow from lengths are judged
beside them. A violation stops all winches together (`stop`). It is software on a host: the emergency-stop chain, safe
torque off and the drives' own limits are the builder's.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from operator import gt, lt, sub
from typing import Final, NamedTuple

import numpy as np

from cablewright.control.stop import StopKind, StopSettings
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError, require_positive
from cablewright.foundation.reading_times import ReadingTimes, Timeliness
from cablewright.foundation.signals import (
    Command,
    Condition,
    Drives,
    DriveState,
    Encoders,
    Inputs,
    Reading,
    SensorFrame,
    Tensions,
    WinchMode,
    YawAngle,
    miscounted,
)

CONFIRMED: Final = 2
"""Readings in a row that must be over a limit: one alone may be an outlier."""

BRAKE_TIME: Final = 0.5
"""Time that a brake has to close or open, s."""

LOST_TIME: Final = 1.0
"""Time for which a tension may be under its minimum, s."""

UNCOUNTED: Final = 0.02
"""Cable that a winch may be ordered to pay out or wind in while its encoder does not count, m."""

_LATE: Final = 0.5  # of the encoders' timeout: for so long it is so at least, as commands and readings are late
_COUNTS: Final = 0.1  # of the ordered cable: least motion of an encoder that counts

_JUDGED: Final = (Tensions, Encoders, Drives, Inputs, YawAngle)
_FALLS: Final = 0.01  # of the limit: least decrease of a falling tension

_STANDING: Final = (Condition.STALLED, Condition.DRUM_END)  # winches that do not turn, and say so

_CONDITIONS: Final = {
    Condition.NO_EQUILIBRIUM: ("the platform is in no equilibrium", StopKind.HOLD),
    Condition.OFF_PLANE: (str(Condition.OFF_PLANE), StopKind.HOLD),
    Condition.DRIVE_FAULT: (str(Condition.DRIVE_FAULT), StopKind.BRAKE),
    Condition.BUS_SILENT: (str(Condition.BUS_SILENT), StopKind.BRAKE),
    Condition.BRAKE: (str(Condition.BRAKE), StopKind.KEEP),
    Condition.ESTOP: (str(Condition.ESTOP), StopKind.RAMP),
    Condition.HUNG: (str(Condition.HUNG), StopKind.RAMP),
    Condition.CLOCK_AHEAD: ("the machine's clock jumped ahead", StopKind.RAMP),
    Condition.CLOCK_BACK: ("the machine's clock jumped back", StopKind.RAMP),
}


@dataclass(frozen=True, eq=False)
class GuardSettings:
    """Limits of m lines and w winches; None: not judged.

    ``max_tensions``: (m,) N at the sheaves. ``min_tensions``: (m,) N, of estimated ones while it prints.
    ``max_torques``: (w,) N m of the winch drums. ``max_drum_speed``: highest speed of a winch drum, rad/s.
    ``max_following_error``: largest following error of a drum, rad. ``counts_per_radian``: encoder counts per radian of
    a winch drum; None: speeds are judged by the drives alone. ``max_uncounted``: (w,) rad that a winch drum may be
    ordered to turn without a count. ``timeouts``: s without a reading, by source. ``hosts``: (w,) indices of the lines
    that winches are named for; None: each line has a winch of its own.
    """

    max_tensions: Array
    min_tensions: Array | None = None
    max_torques: Array | None = None
    max_drum_speed: float | None = None
    max_following_error: float | None = None
    counts_per_radian: float | None = None
    max_uncounted: Array | None = None
    timeouts: Mapping[str, float] = field(default_factory=lambda: {"encoders": 0.5})
    stop: StopSettings = field(default_factory=StopSettings)
    hosts: tuple[int, ...] | None = None

    def winch(self, i: int) -> str:
        """Return words for winch *i* in messages: the name of its line."""
        return f"line {(i if self.hosts is None else self.hosts[i]) + 1}"

    @cached_property
    def uncounted(self) -> list[tuple[float, float]]:
        """Of each winch ``max_uncounted`` and the counts of an encoder that counts."""
        if self.max_uncounted is None or self.counts_per_radian is None:
            return []
        return [(most, _COUNTS * most * self.counts_per_radian) for most in self.max_uncounted.tolist()]

    def __post_init__(self) -> None:
        """Raise `InputError` for limits that are not positive and finite."""
        names = ("max_drum_speed", "max_following_error", "counts_per_radian")
        given = {name: getattr(self, name) for name in names if getattr(self, name) is not None}
        require_positive(**given, **self.timeouts)
        for values in (self.max_tensions, self.max_torques, self.max_uncounted):
            if values is not None and not (values > 0.0).all():
                raise InputError(f"limits of the guard: {values.tolist()}: each must be over 0")


class StopCause(NamedTuple):
    """Reason for a stop by the guard."""

    reason: str
    kind: StopKind = StopKind.RAMP


@dataclass(eq=False)
class _Uncounted:
    """Since when an encoder has not moved."""

    time: float  # s
    counts: int
    turned: float  # rad, by commands


@dataclass(eq=False)
class GuardState:
    """State of the guard, changed in place by `judge`. The last reading of a source stays valid until the next one."""

    start_time: float = math.inf  # s, of the first frame
    times: ReadingTimes = field(default_factory=ReadingTimes)  # of each source
    whole_times: dict[str, float] = field(default_factory=dict)  # s, of each source's last reading without a gap
    causes: dict[str, list[StopCause]] = field(default_factory=dict)  # by source
    over: dict[str, dict[int, int]] = field(default_factory=dict)  # readings in a row, by limit and line
    last_tensions: dict[str, list[float]] = field(default_factory=dict)  # N, by source; the last known of each line
    last_counts: tuple[float, list[int]] | None = None  # s, and the counts of then
    lost_since: float = math.nan  # s, since which a tension has been under its minimum
    closing_since: float = math.nan  # s, of the first command since which brakes are to be closed
    opening_since: float = math.nan  # s, since which they are to be open
    ordered: tuple[float, Command] | None = None  # s, and the command of then
    turned: list[float] = field(default_factory=list)  # (w,) rad by all commands
    uncounted: dict[int, _Uncounted] = field(default_factory=dict)  # by line


def take_note(state: GuardState, now: float, command: Command) -> None:
    """Record the commanded brakes and winch speeds at *now*, s; *state* changes in place."""
    state.ordered = now, command
    if WinchMode.OFF in command.modes:
        state.closing_since = now if math.isnan(state.closing_since) else state.closing_since
        state.opening_since = math.nan
    else:
        state.opening_since = now if math.isnan(state.opening_since) else state.opening_since
        state.closing_since = math.nan


def judge(
    settings: GuardSettings,
    state: GuardState,
    frame: SensorFrame,
    inferred: Array | None = None,
    *,
    lowest: bool = False,
    best: Array | None = None,
) -> StopCause | None:
    """Compare readings with limits; return the most urgent cause to stop now, or None. *state* changes in place.

    *inferred* (m,): tensions by the lengths, N, see `balance_check.cleared`; None, or NaN: not known. *lowest*: whether
    tensions are to be over their minimum now, by the *best* (m,), N, that is known of them; None: by the lengths.
    """
    state.start_time = min(state.start_time, frame.time)
    if state.ordered is not None:  # the command until now is in the counts of now
        then, command = state.ordered
        speeds, passed = command.winch_speeds.tolist(), max(frame.time - then, 0.0)
        turned = state.turned or [0.0] * len(speeds)
        state.turned = [before + speed * passed for before, speed in zip(turned, speeds, strict=True)]
        state.ordered = frame.time, command
    for reading in frame.readings:
        if isinstance(reading, _JUDGED):
            _read(settings, state, reading.source, reading, frame.time)
    if frame.notices and any(notice.condition in _STANDING for notice in frame.notices):
        state.uncounted.clear()
    found = _conditions(frame) + _silences(settings, state, frame.time)
    for causes in state.causes.values():
        found += causes
    if inferred is not None:
        found += _inferred_tensions(settings, inferred)
        if lowest and settings.min_tensions is not None:
            found += _lost_tensions(settings.min_tensions, inferred if best is None else best, state, frame.time)
    return max(found, key=lambda cause: cause.kind) if found else None


def _read(settings: GuardSettings, state: GuardState, source: str, reading: Reading, now: float) -> None:
    """Judge one reading, unless it was repeated or overtaken. One from the future is judged as of now."""
    timeliness, stamp = state.times.judge(source, reading.time, now), min(reading.time, now)
    ahead = timeliness is Timeliness.AHEAD
    if ahead:
        timeliness, stamp = state.times.judge(source, now, now), now
    if timeliness is Timeliness.OLD:
        return
    m, whole = len(settings.max_tensions), True
    wrong = miscounted(reading, m, m if settings.hosts is None else len(settings.hosts))
    if wrong is not None:
        what, each = source.replace("_", " "), "line" if wrong[2] == m else "winch"
        state.causes[source] = [StopCause(f"the {what} do not report {wrong[2]} numbers, one for each {each}")]
        return
    if isinstance(reading, Tensions):
        state.causes[source], whole = _measured_tensions(settings, state, reading)
    elif isinstance(reading, Encoders):
        counts = reading.counts.tolist()
        state.causes[source] = _encoder_speeds(settings, state, stamp, counts) + _stuck(settings, state, now, counts)
    elif isinstance(reading, Drives):
        state.causes[source] = _drives(settings, state, reading)
    elif isinstance(reading, Inputs):
        state.causes[source] = _inputs(reading) + _brakes(settings, state, reading, now)
    elif isinstance(reading, YawAngle):
        whole = math.isfinite(reading.angle) and not ahead  # `control.yaw` takes none that is
    if whole:
        state.whole_times[source] = stamp


def _silences(settings: GuardSettings, state: GuardState, now: float) -> list[StopCause]:
    return [
        StopCause(f"no reading of the {source.replace('_', ' ')} for over {timeout:g} s")
        for source, timeout in settings.timeouts.items()
        if now - state.whole_times.get(source, state.start_time) > timeout
    ]


def _conditions(frame: SensorFrame) -> list[StopCause]:
    found: list[StopCause] = []
    for notice in frame.notices:
        if notice.condition in _CONDITIONS:
            reason, kind = _CONDITIONS[notice.condition]
            found.append(StopCause(f"{reason}: {notice.subject}" if notice.subject else reason, kind))
    return found


def _measured_tensions(settings: GuardSettings, state: GuardState, reading: Tensions) -> tuple[list[StopCause], bool]:
    """Lines over their limit, immediately unless a tension falls, as a ramp may go on winding its line in.

    Also returns whether no line is missing that was measured before.
    """
    now, limits = reading.tensions.tolist(), settings.max_tensions.tolist()
    before = state.last_tensions.get(reading.source, [math.nan] * len(now))
    state.last_tensions[reading.source] = [b if math.isnan(t) else t for t, b in zip(now, before, strict=True)]
    found = []
    for i in _confirmed(state, reading.source, now, limits):
        known = state.last_tensions[reading.source]
        falls = now[i] < before[i] - _FALLS * limits[i]
        why = _too_much(f"line {i + 1}", "pulls", i, known, limits, "N")
        found.append(StopCause(why, StopKind.RAMP if falls else StopKind.HOLD))
    return found, not any(math.isnan(t) and not math.isnan(b) for t, b in zip(now, before, strict=True))


def _inferred_tensions(settings: GuardSettings, inferred: Array) -> list[StopCause]:
    now, limits = inferred.tolist(), settings.max_tensions.tolist()
    if not any(map(gt, now, limits)):
        return []
    over = [i for i, (tension, limit) in enumerate(zip(now, limits, strict=True)) if tension > limit]
    worst = max(over, key=lambda i: float(now[i] / limits[i]))
    return [
        StopCause(_too_much(f"line {worst + 1}", "pulls", worst, now, limits, "N") + ", by the lengths", StopKind.HOLD)
    ]


def _lost_tensions(least: Array, inferred: Array, state: GuardState, now: float) -> list[StopCause]:
    """A line that is about to fall slack, for so long that the estimator could have said why."""
    if not any(map(lt, inferred.tolist(), least.tolist())):
        state.lost_since = math.nan
        return []
    lost = np.flatnonzero(inferred < least)
    if math.isnan(state.lost_since):
        state.lost_since = now
    if now - state.lost_since < LOST_TIME:
        return []
    i = int(lost[np.argmin(inferred[lost] / least[lost])])
    return [StopCause(f"line {i + 1} pulls {inferred[i]:.3g} N; at least {least[i]:.3g} is needed", StopKind.HOLD)]


def _encoder_speeds(settings: GuardSettings, state: GuardState, now: float, counts: list[int]) -> list[StopCause]:
    """A winch that turns too fast, by two pairs of counts in one direction: a single flipped bit comes back."""
    before, state.last_counts = state.last_counts, (now, counts)
    if settings.counts_per_radian is None or settings.max_drum_speed is None or before is None:
        return []
    elapsed = now - before[0]
    if elapsed <= 0.0:  # after a reading from the future
        return []
    per_second = 1.0 / (settings.counts_per_radian * elapsed)
    limits, changes = [settings.max_drum_speed] * len(counts), list(map(sub, counts, before[1]))
    if per_second * max(map(abs, changes)) <= limits[0] and not (state.over.get("out") or state.over.get("in")):
        return []
    found = []
    for way, name in ((per_second, "out"), (-per_second, "in")):
        speeds = [way * change for change in changes]
        fast = _confirmed(state, name, speeds, limits)
        found += [StopCause(_too_much(settings.winch(i), "turns at", i, speeds, limits, "rad/s")) for i in fast]
    return found


def _stuck(settings: GuardSettings, state: GuardState, now: float, counts: list[int]) -> list[StopCause]:
    """Winches that were ordered to turn by a speed, and whose encoders do not count."""
    if not settings.uncounted or state.ordered is None:
        return []
    late = _LATE * settings.timeouts.get("encoders", 0.5)
    found, modes, turned = [], state.ordered[1].modes, state.turned
    for i, (count, (most, counted)) in enumerate(zip(counts, settings.uncounted, strict=True)):
        last = state.uncounted.get(i)
        if last is None:
            state.uncounted[i] = _Uncounted(now, count, turned[i])
            continue
        if abs(count - last.counts) > counted or (modes and modes[i] is not WinchMode.VELOCITY):
            last.time, last.counts, last.turned = now, count, turned[i]
            continue
        angle = turned[i] - last.turned
        if abs(angle) > most and now - last.time >= late:
            cable = f"{'pay out' if angle > 0.0 else 'wind in'} {1e3 * UNCOUNTED * abs(angle) / most:.0f} mm of cable"
            why = f"the encoder of {settings.winch(i)} does not count: its winch was ordered to {cable}"
            found.append(StopCause(why, StopKind.HOLD))
    return found


def _drives(settings: GuardSettings, state: GuardState, reading: Drives) -> list[StopCause]:
    """A drive that faults, follows badly, turns too fast or pulls too hard."""
    m, found = len(reading.states), []
    if DriveState.FAULT in reading.states:
        for i, (drive, text) in enumerate(zip(reading.states, reading.faults, strict=True)):
            if drive is DriveState.FAULT:
                why = f"the drive of {settings.winch(i)} reports a fault: {text or 'no text'}"
                found.append(StopCause(why, StopKind.BRAKE))
    following, speed = settings.max_following_error, settings.max_drum_speed
    hold, by_ramp, errors = StopKind.HOLD, StopKind.RAMP, reading.following_errors
    for name, does, values, limits, unit, kind in (
        ("following", "follows its command with an error of", errors, following, "rad", hold),
        ("speed", "turns at", reading.velocities, speed, "rad/s", by_ramp),
        ("torque", "has a torque of", reading.torques, settings.max_torques, "N m", hold),
    ):
        if limits is not None:
            most = limits.tolist() if isinstance(limits, np.ndarray) else [limits] * m
            sizes = [abs(value) for value in values.tolist()]
            over = _confirmed(state, name, sizes, most)
            found += [StopCause(_too_much(settings.winch(i), does, i, sizes, most, unit), kind) for i in over]
    return found


def _inputs(reading: Inputs) -> list[StopCause]:
    if reading.torque_off:
        return [StopCause("safe torque off is active", StopKind.BRAKE)]
    if not reading.chain_closed:
        return [StopCause(str(Condition.ESTOP))]
    return [] if reading.enabling else [StopCause("the enabling switch is not pressed")]


def _brakes(settings: GuardSettings, state: GuardState, reading: Inputs, now: float) -> list[StopCause]:
    """Brakes that are not as they were commanded, by their own contacts, after the time that they have for it."""
    for i, closed in enumerate(reading.brakes_closed):
        if not closed and now - state.closing_since > BRAKE_TIME:
            return [StopCause(f"the brake of {settings.winch(i)} does not close", StopKind.KEEP)]
        if closed and now - state.opening_since > BRAKE_TIME:
            return [StopCause(f"the brake of {settings.winch(i)} does not open", StopKind.HOLD)]
    return []


def _confirmed(state: GuardState, name: str, values: Sequence[float], limits: Sequence[float]) -> list[int]:
    """Count the readings in a row in which *values* (m,) are over *limits*; return the lines that are confirmed.

    Lists and not arrays, here and above: of a dozen numbers they are several times as fast.
    """
    before = state.over.get(name, {})
    state.over[name] = counted = {}
    for i, (value, limit) in enumerate(zip(values, limits, strict=True)):
        if value > limit:
            counted[i] = before.get(i, 0) + 1
        elif i in before and math.isnan(value):
            counted[i] = before[i]  # who does not answer has not recovered
    return [i for i, times in counted.items() if times >= CONFIRMED]


def _too_much(what: str, does: str, i: int, values: Sequence[float], limits: Sequence[float], unit: str) -> str:
    return f"{what} {does} {values[i]:.3g} {unit}; at most {limits[i]:.3g} is allowed"
