"""The guard of a machine: what it measures against its limits, in every state, before all else.

It needs no estimate: tensions are measured, by load cells or torques, and those that follow from lengths are judged
beside them. What it finds stops all winches together, by a ramp (category 1 of IEC 60204-1: stop under control, hold,
then brake) or at once where a ramp would worsen it. It is software on a host: the emergency-stop chain, safe torque off
and the drives' own limits are the builder's.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np

from cablewright.arrays import Array
from cablewright.errors import InputError, require_positive
from cablewright.signals import (
    Condition,
    Drives,
    DriveState,
    Encoders,
    Inputs,
    SensorFrame,
    Tensions,
)

CONFIRMED: Final = 2
"""Readings in a row that must be over a limit: one alone may be an outlier."""

_AT_ONCE: Final = {
    Condition.NO_EQUILIBRIUM: "the platform is in no equilibrium",
    Condition.DRIVE_FAULT: str(Condition.DRIVE_FAULT),
    Condition.BRAKE: str(Condition.BRAKE),
}
_BY_RAMP: Final = {
    Condition.BUS_SILENT: str(Condition.BUS_SILENT),
    Condition.ESTOP: str(Condition.ESTOP),
    Condition.CLOCK_BACK: "the machine's clock jumped back",
}


@dataclass(frozen=True, eq=False)
class GuardSettings:
    """Limits of m lines and winches; None: not judged.

    ``max_tensions``: (m,) N at the sheaves. ``max_torques``: (m,) N m of the winch drums. ``max_drum_speed``: rad/s of
    a winch drum. ``max_following_error``: rad of it. ``counts_per_radian``: of the encoders, per radian of a winch
    drum; None: speeds are judged by the drives alone. ``timeouts``: s without a reading, by source. ``ramp_time``: s in
    which the winches come to rest together. ``hold_time``: s for which they are then held before brakes close.
    """

    max_tensions: Array
    max_torques: Array | None = None
    max_drum_speed: float | None = None
    max_following_error: float | None = None
    counts_per_radian: float | None = None
    timeouts: Mapping[str, float] = field(default_factory=lambda: {"encoders": 0.5})
    ramp_time: float = 0.3
    hold_time: float = 0.5

    def __post_init__(self) -> None:
        """Raise `InputError` for limits that are not positive and finite."""
        names = ("max_drum_speed", "max_following_error", "counts_per_radian")
        given = {name: getattr(self, name) for name in names if getattr(self, name) is not None}
        require_positive(**given, **self.timeouts, ramp_time=self.ramp_time, hold_time=self.hold_time)
        for values in (self.max_tensions, self.max_torques):
            if values is not None and not (values > 0.0).all():
                raise InputError(f"limits of the guard: {values.tolist()}: each must be over 0")


class Cause(NamedTuple):
    """Why the guard stops the machine."""

    reason: str
    at_once: bool  # hold the winches without a ramp


@dataclass(eq=False)
class GuardState:
    """Changed in place by `judge`. What a source has told holds until it tells otherwise."""

    start_time: float = math.inf  # s, of the first frame
    read_times: dict[str, float] = field(default_factory=dict)  # s, of each source's last reading
    last_times: dict[str, float] = field(default_factory=dict)  # s, of the frame in which it came, without a gap
    causes: dict[str, list[Cause]] = field(default_factory=dict)  # by source
    over: dict[str, dict[int, int]] = field(default_factory=dict)  # readings in a row, by limit and line
    last_tensions: dict[str, list[float]] = field(default_factory=dict)  # N, by source; the last known of each line
    last_counts: tuple[float, list[int]] | None = None  # s, and the counts of then


def judge(
    settings: GuardSettings, state: GuardState, frame: SensorFrame, inferred: Array | None = None
) -> Cause | None:
    """Return the cause to stop now, the most urgent one; None: nothing is wrong. *state* changes in place.

    *inferred* (m,): tensions by the lengths, N; None, or NaN: not known.
    """
    state.start_time = min(state.start_time, frame.time)
    for reading in frame.readings:
        source = reading.source if isinstance(reading, Tensions) else _SOURCES.get(type(reading), "")
        if not source or reading.time < state.read_times.get(source, -math.inf):
            continue  # not the guard's, or overtaken by a later one
        state.read_times[source] = reading.time
        whole = True
        if isinstance(reading, Tensions):
            state.causes[source], whole = _measured_tensions(settings, state, reading)
        elif isinstance(reading, Encoders):
            state.causes[source] = _encoder_speeds(settings, state, reading)
        elif isinstance(reading, Drives):
            state.causes[source] = _drives(settings, state, reading)
        elif isinstance(reading, Inputs):
            state.causes[source] = _inputs(reading)
        if whole:
            state.last_times[source] = frame.time
    found = _conditions(frame) + _silences(settings, state, frame.time)
    for causes in state.causes.values():
        found += causes
    if inferred is not None:
        found += _inferred_tensions(settings, inferred)
    return max(found, key=lambda cause: cause.at_once) if found else None


_SOURCES: Final[dict[type, str]] = {Encoders: "encoders", Drives: "drives", Inputs: "inputs"}


def _silences(settings: GuardSettings, state: GuardState, now: float) -> list[Cause]:
    return [
        Cause(f"no reading of the {source.replace('_', ' ')} for over {timeout:g} s", at_once=False)
        for source, timeout in settings.timeouts.items()
        if now - state.last_times.get(source, state.start_time) > timeout
    ]


def _conditions(frame: SensorFrame) -> list[Cause]:
    found = []
    for notice in frame.notices:
        of = f": {notice.subject}" if notice.subject else ""
        if notice.condition in _AT_ONCE:
            found.append(Cause(f"{_AT_ONCE[notice.condition]}{of}", at_once=True))
        elif notice.condition in _BY_RAMP:
            found.append(Cause(f"{_BY_RAMP[notice.condition]}{of}", at_once=False))
    return found


def _measured_tensions(settings: GuardSettings, state: GuardState, reading: Tensions) -> tuple[list[Cause], bool]:
    """Lines over their limit, at once while a tension rises, as a ramp may go on winding its line in.

    Also returns whether no line is missing that was measured before.
    """
    now, limits = reading.tensions.tolist(), settings.max_tensions.tolist()
    before = state.last_tensions.get(reading.source, [math.nan] * len(now))
    state.last_tensions[reading.source] = [b if math.isnan(t) else t for t, b in zip(now, before, strict=True)]
    found = [
        Cause(_too_much("pulls", i, now, limits, "N"), at_once=not now[i] < before[i])
        for i in _confirmed(state, reading.source, now, limits)
    ]
    return found, not any(math.isnan(t) and not math.isnan(b) for t, b in zip(now, before, strict=True))


def _inferred_tensions(settings: GuardSettings, inferred: Array) -> list[Cause]:
    now, limits = inferred.tolist(), settings.max_tensions.tolist()
    over = [i for i, (tension, limit) in enumerate(zip(now, limits, strict=True)) if tension > limit]
    if not over:
        return []
    worst = max(over, key=lambda i: float(now[i] / limits[i]))
    return [Cause(_too_much("pulls", worst, now, limits, "N") + ", by the lengths", at_once=True)]


def _encoder_speeds(settings: GuardSettings, state: GuardState, reading: Encoders) -> list[Cause]:
    """A winch that turns too fast, by two pairs of counts in one direction: a single flipped bit comes back."""
    counts = reading.counts.tolist()
    before, state.last_counts = state.last_counts, (reading.time, counts)
    if settings.counts_per_radian is None or settings.max_drum_speed is None or before is None:
        return []
    elapsed = reading.time - before[0]
    if not elapsed > 0.0:
        return []
    per_second = 1.0 / (settings.counts_per_radian * elapsed)
    limits = [settings.max_drum_speed] * len(counts)
    found = []
    for way, name in ((per_second, "out"), (-per_second, "in")):
        speeds = [way * (now - then) for now, then in zip(counts, before[1], strict=True)]
        fast = _confirmed(state, name, speeds, limits)
        found += [Cause(_too_much("turns at", i, speeds, limits, "rad/s"), at_once=False) for i in fast]
    return found


def _drives(settings: GuardSettings, state: GuardState, reading: Drives) -> list[Cause]:
    """A drive that faults, follows badly, turns too fast or pulls too hard."""
    m, found = len(reading.states), []
    if DriveState.FAULT in reading.states:
        for i, (drive, text) in enumerate(zip(reading.states, reading.faults, strict=True)):
            if drive is DriveState.FAULT:
                found.append(Cause(f"the drive of line {i + 1} reports a fault: {text or 'no text'}", at_once=True))
    following, speed = settings.max_following_error, settings.max_drum_speed
    for name, does, values, limits, unit, at_once in (
        ("following", "follows its command with an error of", reading.following_errors, following, "rad", True),
        ("speed", "turns at", reading.velocities, speed, "rad/s", False),
        ("torque", "has a torque of", reading.torques, settings.max_torques, "N m", True),
    ):
        if limits is not None:
            most = limits.tolist() if isinstance(limits, np.ndarray) else [limits] * m
            sizes = [abs(value) for value in values.tolist()]
            over = _confirmed(state, name, sizes, most)
            found += [Cause(_too_much(does, i, sizes, most, unit), at_once=at_once) for i in over]
    return found


def _inputs(reading: Inputs) -> list[Cause]:
    if not reading.chain_closed:
        return [Cause(str(Condition.ESTOP), at_once=False)]
    if reading.torque_off:
        return [Cause("safe torque off is active", at_once=True)]
    return [] if reading.enabling else [Cause("the enabling switch is not pressed", at_once=False)]


def _confirmed(state: GuardState, name: str, values: Sequence[float], limits: Sequence[float]) -> list[int]:
    """Count the readings in a row in which *values* (m,) are over *limits*; return the lines that are confirmed.

    Lists and not arrays, here and above: of a dozen numbers they are several times as fast.
    """
    over = [i for i, (value, limit) in enumerate(zip(values, limits, strict=True)) if value > limit]
    if not over:
        state.over.pop(name, None)
        return []
    before = state.over.get(name, {})
    state.over[name] = {i: before.get(i, 0) + 1 for i in over}
    return [i for i, times in state.over[name].items() if times >= CONFIRMED]


def _too_much(does: str, i: int, values: Sequence[float], limits: Sequence[float], unit: str) -> str:
    return f"line {i + 1} {does} {values[i]:.3g} {unit}; at most {limits[i]:.3g} is allowed"


class RampState(NamedTuple):
    """A stop of all winches: since when, and from which speeds (m,), rad/s."""

    since: float  # s
    speeds: Array
    at_once: bool


def ramp(settings: GuardSettings, stop: RampState, now: float) -> tuple[Array, bool]:
    """Return the speeds (m,), rad/s, of winches that stop together, and whether brakes are to be closed by now."""
    if stop.at_once:
        return np.zeros(len(stop.speeds)), now - stop.since >= settings.hold_time
    left = 1.0 - (now - stop.since) / settings.ramp_time
    return max(left, 0.0) * stop.speeds, now - stop.since >= settings.ramp_time + settings.hold_time
