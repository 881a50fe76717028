"""A simulated machine driven along a path by a pilot who knows the truth, and what came of it.

The pilot stands in for control: it drives each winch by its true length, as no controller can. So a log is of a machine
that does what it should, and how well that is found out is left to who reads the log.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.errors import AnswerError, InputError
from cablewright.machine.log import LogWriter
from cablewright.machine.simulated import SimulatedMachine
from cablewright.models.statics import Model
from cablewright.printing.loop import Loop
from cablewright.signals import Command, SensorFrame, Truth
from cablewright.solvers.inverse import solve_inverse

__all__ = ["Drive", "DriveSettings", "Pilot", "drive"]

Array = NDArray[np.float64]

SLACK: Final = 5e-3
"""Excess from which a line counts as slack in a summary, m."""

_STEP: Final = 0.02  # m between places whose lengths are solved for
_SMOOTH: Final = 0.3  # m along which a line is let slack
_EVEN: Final = 0.15  # of the mean tension: lines nearer to each other than this share being the slackest


@dataclass(frozen=True)
class DriveSettings:
    """How a pilot drives. All assumed; the paper only tells its speed."""

    speed: float = 0.03
    """m/s along the path."""
    ramp: float = 2.0
    """s from rest to that speed."""
    slack: float = 0.03
    """What the line with the least to do is let out by, m: as the paper's cables are slack one at a time."""
    ease: float = 20.0
    """s over which that begins, so that the start is calm."""
    error: float = 2e-3
    """Standard deviation of what each length is off what it should be, m ..."""
    memory: float = 20.0
    """... and how long that stays, s."""
    gain: float = 2.0
    """Share of a length's error that is driven out, 1/s."""
    valve: float = 1.0
    """Opening of the powder's valve."""

    def __post_init__(self) -> None:
        """Refuse what is no drive."""
        for name in ("speed", "ramp", "ease", "memory", "gain"):
            if not 0.0 < getattr(self, name) < 1e6:
                raise InputError(f"{name} = {getattr(self, name):g}: a finite number over 0 is wanted")
        for name in ("slack", "error"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise InputError(f"{name} = {getattr(self, name):g} m: 0 to 1 m is wanted")
        if not 0.0 <= self.valve <= 1.0:
            raise InputError(f"valve = {self.valve:g}: 0 (shut) to 1 (open) is wanted")


class Pilot:
    """Drives the winches of one machine round a loop, or holds it where it hangs."""

    def __init__(self, machine: SimulatedMachine, loop: Loop | None, settings: DriveSettings, seed: int) -> None:
        """Work out the lengths round *loop* at the height where *machine* hangs; None: it stays.

        Raises `AnswerError` where the drum cannot be held somewhere on the way.
        """
        self.machine, self.settings = machine, settings
        self._random = np.random.default_rng([seed, 7])
        self._off = np.zeros(machine.robot.m)
        start = machine.truth.position
        pieces = 1 if loop is None else max(2, round(loop.length / _STEP))
        self._length = 0.0 if loop is None else loop.length
        self._at = np.linspace(0.0, self._length, pieces + 1)
        level = np.broadcast_to(start[:2], (pieces + 1, 2)) if loop is None else loop.at(self._at)
        poses = np.column_stack([level, np.full(pieces + 1, start[2])])
        held = solve_inverse(Model(machine.robot), poses)
        if not held.ok.all():
            bad = int(np.flatnonzero(~held.ok)[0])
            place = ", ".join(f"{x:.2f}" for x in poses[bad])
            raise AnswerError(f"the path cannot be held at {place} m: {held[bad].sentence()}")
        self._taut, self._slack = held.lengths, settings.slack * self._share(held.tensions)  # (k, m)

    def distance(self, now: float) -> float:
        """How far along the path one should be at *now* (s), m."""
        settings = self.settings
        if now < settings.ramp:
            return settings.speed * now * now / (2.0 * settings.ramp)
        return settings.speed * (now - 0.5 * settings.ramp)

    def command(self) -> Command:
        """What to do in the next step."""
        now, period, truth, settings = self.machine.time, self.machine.period, self.machine.truth, self.settings
        here, there = self._wanted(now), self._wanted(now + period)
        keep = float(np.exp(-period / settings.memory))
        push = settings.error * float(np.sqrt(1.0 - keep * keep))
        self._off = keep * self._off + push * self._random.standard_normal(len(self._off))
        gain = min(settings.gain, 0.5 / period)
        rate = (there - here) / period + gain * (here + self._off - truth.lengths)
        return Command(now, rate / truth.radii, settings.valve)

    def _wanted(self, now: float) -> Array:
        along = np.mod(self.distance(now), self._length) if self._length else 0.0
        place = float(along) / self._length * (len(self._at) - 1) if self._length else 0.0
        piece = min(int(place), len(self._at) - 2)
        weights = np.array([piece + 1 - place, place - piece])
        eased = min(1.0, now / self.settings.ease)
        both = slice(piece, piece + 2)
        return np.asarray(weights @ self._taut[both] + eased * (weights @ self._slack[both]))

    def _share(self, tensions: Array) -> Array:
        """Which line is let slack where, (k, m) from 0 to 1: that with the least tension, where it has least by far."""
        order = np.sort(tensions, axis=1)
        lead = np.clip((order[:, 1] - order[:, 0]) / (_EVEN * tensions.mean(axis=1)), 0.0, 1.0)
        share = np.where(tensions == order[:, :1], lead[:, None], 0.0)
        if not self._length:
            return share
        width = max(1, round(_SMOOTH / _STEP))
        kernel = np.ones(width) / width
        round_twice = np.concatenate([share[-width - 1 : -1], share, share[1 : width + 1]])
        smooth = [np.convolve(column, kernel, mode="same")[width:-width] for column in round_twice.T]
        return np.stack(smooth, axis=1)


@dataclass
class Drive:
    """What came of a drive; grows with `add`."""

    lines: tuple[str, ...]
    steps: int = 0
    duration: float = 0.0
    """s on the machine's clock."""
    distance: float = 0.0
    """m that B went, between steps."""
    seconds: float = 0.0
    """s that it took."""
    slack_steps: Array = field(default_factory=lambda: np.zeros(0))
    """Steps in which each line's excess was over `SLACK`, (m,)."""
    most_tension: float = 0.0
    """N at a sheave."""
    most_tilt: float = 0.0
    """rad of the drum's axis from the vertical."""
    yaw: tuple[float, float] = (0.0, 0.0)
    """rad: the least and the most."""
    powder: float = 0.0
    """kg left."""
    readings: Counter[str] = field(default_factory=Counter)
    notices: Counter[str] = field(default_factory=Counter)
    path: list[tuple[float, ...]] = field(default_factory=list)
    """Time, B, tilt, yaw, excesses, about once a second."""

    @property
    def slack_share(self) -> Array:
        """Share of the time in which each line was slack by more than `SLACK`, (m,)."""
        return self.slack_steps / max(self.steps, 1)

    def add(self, frame: SensorFrame, truth: Truth, before: Truth) -> None:
        """Count one step in."""
        if not self.steps:
            self.slack_steps = np.zeros(len(self.lines))
            self.yaw = (float(truth.rotation[2]),) * 2
        self.steps += 1
        self.duration = frame.time
        self.distance += float(np.sqrt(((truth.position - before.position) ** 2).sum()))
        self.slack_steps += truth.excess > SLACK
        self.most_tension = max(self.most_tension, float(truth.tensions.max()))
        x, y, yaw = truth.rotation.tolist()
        tilt = float(np.hypot(x, y))
        self.most_tilt = max(self.most_tilt, tilt)
        self.yaw = (min(self.yaw[0], yaw), max(self.yaw[1], yaw))
        self.powder = truth.powder
        self.readings.update(getattr(reading, "source", type(reading).__name__) for reading in frame.readings)
        self.notices.update(f"{notice.whose}: {notice.condition.value}" for notice in frame.notices)
        if int(frame.time) != int(before.time):
            self.path.append((frame.time, *truth.position.tolist(), tilt, yaw, *truth.excess.tolist()))


def drive(
    machine: SimulatedMachine,
    loop: Loop | None,
    duration: float,
    *,
    settings: DriveSettings | None = None,
    seed: int = 0,
    log: LogWriter | None = None,
    progress: Callable[[str, int, int], None] | None = None,
) -> Drive:
    """Drive *machine* for *duration* (s) round *loop*, or hold it, and write each step to *log*.

    Raises `InputError` for a duration of no step, `AnswerError` where the path cannot be held.
    """
    steps = round(duration / machine.period) if 0.0 < duration < 1e9 else 0
    if steps < 1:
        raise InputError(f"duration = {duration:g} s: at least one step of {machine.period:g} s is wanted")
    pilot = Pilot(machine, loop, settings or DriveSettings(), seed)
    found = Drive(tuple(line.name for line in machine.robot.lines))
    begin = time.perf_counter()
    for step in range(steps):
        before, command = machine.truth, pilot.command()
        frame = machine.step(command)
        if log is not None:
            log.write(frame, command, machine.truth)
        found.add(frame, machine.truth, before)
        if progress is not None and step % 50 == 0:
            progress("simulating", step, steps)
    found.seconds = time.perf_counter() - begin
    return found
