"""The guard of a machine: what it measures against its limits, in every state, before all else.

It needs no estimate: tensions are measured, by load cells or torques, and those that follow from lengths are judged
beside them. What it finds stops all winches together, by a ramp (category 1 of IEC 60204-1: stop under control, hold,
then brake) or at once where a ramp would worsen it. It is software on a host: the emergency-stop chain, safe torque off
and the drives' own limits are the builder's.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import chain
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array, Mask
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
    last_times: dict[str, float] = field(default_factory=dict)  # s, of the frame with each source's last reading
    causes: dict[str, list[Cause]] = field(default_factory=dict)  # by source
    over: dict[tuple[str, int], int] = field(default_factory=dict)  # readings in a row over a limit
    last_tensions: dict[str, Array] = field(default_factory=dict)  # N, by source
    last_counts: tuple[float, NDArray[np.int64]] | None = None  # s, and the counts of then


def judge(
    settings: GuardSettings, state: GuardState, frame: SensorFrame, inferred: Array | None = None
) -> Cause | None:
    """Return the cause to stop now, the most urgent one; None: nothing is wrong. *state* changes in place.

    *inferred* (m,): tensions by the lengths, N; None, or NaN: not known.
    """
    state.start_time = min(state.start_time, frame.time)
    for reading in frame.readings:
        source, causes = "", []
        if isinstance(reading, Tensions):
            source, causes = reading.source, [*_measured_tensions(settings, state, reading)]
        elif isinstance(reading, Encoders):
            source, causes = "encoders", [*_encoder_speeds(settings, state, reading)]
        elif isinstance(reading, Drives):
            source, causes = "drives", [*_drives(settings, state, reading)]
        elif isinstance(reading, Inputs):
            source, causes = "inputs", [*_inputs(reading)]
        if source:
            state.causes[source], state.last_times[source] = causes, frame.time
    found = [*_conditions(frame), *chain.from_iterable(state.causes.values()), *_silences(settings, state, frame.time)]
    if inferred is not None:
        found += _inferred_tensions(settings, inferred)
    return max(found, key=lambda cause: cause.at_once, default=None)


def _silences(settings: GuardSettings, state: GuardState, now: float) -> Iterable[Cause]:
    for source, timeout in settings.timeouts.items():
        if now - state.last_times.get(source, state.start_time) > timeout:
            yield Cause(f"no reading of the {source.replace('_', ' ')} for over {timeout:g} s", at_once=False)


def _conditions(frame: SensorFrame) -> Iterable[Cause]:
    for notice in frame.notices:
        of = f": {notice.subject}" if notice.subject else ""
        if notice.condition in _AT_ONCE:
            yield Cause(f"{_AT_ONCE[notice.condition]}{of}", at_once=True)
        elif notice.condition in _BY_RAMP:
            yield Cause(f"{_BY_RAMP[notice.condition]}{of}", at_once=False)


def _measured_tensions(settings: GuardSettings, state: GuardState, reading: Tensions) -> Iterable[Cause]:
    """A line over its limit: at once while its tension rises, as a ramp may go on winding it in."""
    before = state.last_tensions.get(reading.source)
    state.last_tensions[reading.source] = reading.tensions
    for i in _confirmed(state, reading.source, reading.tensions > settings.max_tensions):
        rising = before is None or not reading.tensions[i] < before[i]
        yield Cause(_too_much("pulls", i, reading.tensions, settings.max_tensions, "N"), at_once=rising)


def _inferred_tensions(settings: GuardSettings, inferred: Array) -> Iterable[Cause]:
    over = inferred > settings.max_tensions
    if over.any():
        worst = int(np.argmax(np.where(over, inferred / settings.max_tensions, 0.0)))
        yield Cause(_too_much("pulls", worst, inferred, settings.max_tensions, "N") + ", by the lengths", at_once=True)


def _encoder_speeds(settings: GuardSettings, state: GuardState, reading: Encoders) -> Iterable[Cause]:
    """A winch that turns too fast, by two pairs of counts in one direction: a single flipped bit comes back."""
    before, state.last_counts = state.last_counts, (reading.time, reading.counts)
    if settings.counts_per_radian is None or settings.max_drum_speed is None or before is None:
        return
    elapsed = reading.time - before[0]
    if not elapsed > 0.0:
        return
    speeds = (reading.counts - before[1]) / (settings.counts_per_radian * elapsed)
    for way, name in ((1.0, "out"), (-1.0, "in")):
        for i in _confirmed(state, name, way * speeds > settings.max_drum_speed):
            most = np.full(len(speeds), settings.max_drum_speed)
            yield Cause(_too_much("turns at", i, np.abs(speeds), most, "rad/s"), at_once=False)


def _drives(settings: GuardSettings, state: GuardState, reading: Drives) -> Iterable[Cause]:
    """A drive that faults, follows badly, turns too fast or pulls too hard."""
    for i, (drive, text) in enumerate(zip(reading.states, reading.faults, strict=True)):
        if drive is DriveState.FAULT:
            yield Cause(f"the drive of line {i + 1} reports a fault: {text or 'no text'}", at_once=True)
    m = len(reading.states)
    if settings.max_following_error is not None:
        errors, most = np.abs(reading.following_errors), np.full(m, settings.max_following_error)
        for i in _confirmed(state, "following", errors > most):
            yield Cause(_too_much("follows its command with an error of", i, errors, most, "rad"), at_once=True)
    if settings.max_drum_speed is not None:
        speeds, most = np.abs(reading.velocities), np.full(m, settings.max_drum_speed)
        for i in _confirmed(state, "speed", speeds > most):
            yield Cause(_too_much("turns at", i, speeds, most, "rad/s"), at_once=False)
    if settings.max_torques is not None:
        torques = np.abs(reading.torques)
        for i in _confirmed(state, "torque", torques > settings.max_torques):
            yield Cause(_too_much("has a torque of", i, torques, settings.max_torques, "N m"), at_once=True)


def _inputs(reading: Inputs) -> Iterable[Cause]:
    if not reading.chain_closed:
        yield Cause(str(Condition.ESTOP), at_once=False)
    elif reading.torque_off:
        yield Cause("safe torque off is active", at_once=True)
    elif not reading.enabling:
        yield Cause("the enabling switch is not pressed", at_once=False)


def _confirmed(state: GuardState, name: str, over: Mask) -> list[int]:
    """Count the readings in a row that are *over* (m,) a limit; return the lines for which it is confirmed."""
    found = []
    for i, is_over in enumerate(over.tolist()):
        key = (name, i)
        if not is_over:
            state.over.pop(key, None)
            continue
        state.over[key] = state.over.get(key, 0) + 1
        if state.over[key] >= CONFIRMED:
            found.append(i)
    return found


def _too_much(does: str, i: int, values: Array, limits: Array, unit: str) -> str:
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
