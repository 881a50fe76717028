"""Motion of a simulated machine along a path, controlled by its true state, and a summary.

The pilot replaces the controller: it controls each winch by its true length, which no real controller knows. So the log
shows a machine that moves as intended, to test estimators on.
"""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from cablewright.analyses.motion.inverse_dynamics import inverse_dynamics
from cablewright.analyses.motion.trajectory import Trajectory
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.foundation.progress import Progress
from cablewright.foundation.signals import Command, Order, OrderKind, SensorFrame, Truth
from cablewright.live.error_statistics import SLACK
from cablewright.machine.log.log import LogWriter
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.models.free_coordinates import with_free
from cablewright.models.statics import Model
from cablewright.printing.random_curve import CurveRequirements, draw
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse

INSET: Final = 1.0
"""Distance of a random loop from the sides of the robot's frame, m."""

_STEP: Final = 0.02  # m between points whose lengths are solved
_SMOOTHING: Final = 0.3  # m of path over which a line becomes slack
_LEAD: Final = 0.15  # share of the mean tension by which a line's must be the smallest to get the full slack


@dataclass(frozen=True)
class DriveSettings:
    """Speeds and gains of a pilot. All values are assumed except the speed (Merlet and Papegay 2023)."""

    speed: float = 0.03  # m/s along the path
    ramp: float = 2.0  # s from rest to that speed
    slack: float = 0.03  # m, excess of a point's line of smallest tension: one line is slack at a time, as in the paper
    ease: float = 20.0  # s over which the slack begins, for a smooth start
    error: float = 2e-3  # m, standard deviation of each length's error ...
    memory: float = 20.0  # ... and its correlation time, s
    gain: float = 2.0  # 1/s, gain of the control of lengths
    valve: float = 1.0  # opening of the powder valve, 0 (shut) to 1 (open)

    def __post_init__(self) -> None:
        """Raise `InputError` for numbers out of their ranges."""
        for name in ("speed", "ramp", "ease", "memory", "gain"):
            if not 0.0 < getattr(self, name) < 1e6:
                raise InputError(f"{name} = {getattr(self, name):g}: must be finite and over 0")
        for name in ("slack", "error"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise InputError(f"{name} = {getattr(self, name):g} m: must be from 0 to 1 m")
        if not 0.0 <= self.valve <= 1.0:
            raise InputError(f"valve = {self.valve:g}: must be from 0 (shut) to 1 (open)")


class Pilot:
    """Controller that moves a simulated machine along a closed path repeatedly, holds it, or follows a trajectory."""

    def __init__(
        self, machine: SimulatedMachine, path: Array | Trajectory | None, settings: DriveSettings, seed: int
    ) -> None:
        """Solve the lengths along *path* at the present height of *machine*; None: hold it in place.

        *path* (k, 2), m, world: evenly spaced points of a closed path, the first repeated at the end; or a trajectory,
        whose lengths are those of `inverse_dynamics`. *seed*: seed of the random errors of the lengths. Raises
        `AnswerError` where the drum cannot be held.
        """
        self.machine, self.settings = machine, settings
        self._random = np.random.default_rng([seed, 7])
        self._length_error = np.zeros(machine.robot.m)
        self._length, self._timed = 0.0, isinstance(path, Trajectory)
        if isinstance(path, Trajectory):
            moved = inverse_dynamics(machine.robot, path)
            if not moved.feasible:
                raise AnswerError(f"the trajectory cannot be followed: {moved.refusal}")
            self._taut, self._slack = moved.lengths, np.zeros_like(moved.lengths)
            self._times = path.times
            return
        start, turned = machine.truth.position, machine.truth.rotation[: machine.robot.n - 3]
        level = np.array([start[:2], start[:2]]) if path is None else path
        self._length = 0.0 if path is None else path_length(path)
        poses = np.column_stack([level, np.tile([start[2], *turned], (len(level), 1))])
        held = solve_inverse(Model(machine.robot), with_free(machine.robot, poses))
        if not (good := held.holds).all():
            bad = int(np.argmin(good))
            place = ", ".join(f"{x:.2f}" for x in poses[bad])
            raise AnswerError(f"the path cannot be held at {place} m: {held[bad].sentence()}")
        slack = settings.slack if machine.robot.n == 3 else 0.0  # a body is held by all its lines
        self._taut, self._slack = held.lengths, slack * self._share(held.tensions)  # (k, m)

    def distance(self, now: float) -> float:
        """Distance along the path at the time *now* (s), m."""
        settings = self.settings
        if now < settings.ramp:
            return settings.speed * now * now / (2.0 * settings.ramp)
        return settings.speed * (now - 0.5 * settings.ramp)

    def rounds(self, now: float) -> int:
        """Completed rounds of the closed path at the time *now* (s)."""
        return int(self.distance(now) / self._length) if self._length else 0

    def command(self) -> Command:
        """Return the winch speeds for the next step of the simulated machine."""
        now, period, truth, settings = self.machine.time, self.machine.period, self.machine.truth, self.settings
        here, there = self._lengths(now), self._lengths(now + period)
        keep = float(np.exp(-period / settings.memory))
        push = settings.error * float(np.sqrt(1.0 - keep * keep))
        self._length_error = keep * self._length_error + push * self._random.standard_normal(len(self._length_error))
        gain = min(settings.gain, 0.5 / period)
        rate = (there - here) / period + gain * (here + self._length_error - truth.lengths)
        hosts = list(self.machine.robot.hosts)
        return Command(now, rate[hosts] / truth.radii[hosts], settings.valve)

    def _lengths(self, now: float) -> Array:
        """Intended lengths (m,), m, at *now* (s), without errors."""
        pieces = len(self._taut) - 1
        place = (self.distance(now) / self._length % 1.0) * pieces if self._length else 0.0
        if self._timed:
            place = min(now / self._times[-1], 1.0) * pieces
        piece = min(int(place), pieces - 1)
        weights = np.array([piece + 1 - place, place - piece])
        eased = min(1.0, now / self.settings.ease)
        both = slice(piece, piece + 2)
        return np.asarray(weights @ self._taut[both] + eased * (weights @ self._slack[both]))

    def _share(self, tensions: Array) -> Array:
        """Share of the slack (k, m), 0 to 1, of each line: 1 where its tension is by far the smallest."""
        order = np.sort(tensions, axis=1)
        lead = np.clip((order[:, 1] - order[:, 0]) / (_LEAD * tensions.mean(axis=1)), 0.0, 1.0)
        share = np.where(tensions == order[:, :1], lead[:, None], 0.0)
        if not self._length:
            return share
        width = max(1, round(_SMOOTHING / _STEP))
        kernel = np.ones(width) / width
        round_twice = np.concatenate([share[-width - 1 : -1], share, share[1 : width + 1]])
        smooth = [np.convolve(column, kernel, mode="same")[width:-width] for column in round_twice.T]
        return np.stack(smooth, axis=1)


@dataclass
class PilotedDrive:
    """Summary of a piloted motion; `add` adds a step."""

    lines: tuple[str, ...]  # names
    steps: int = 0
    duration: float = 0.0  # s on the machine's clock
    distance: float = 0.0  # m, path of B
    elapsed: float = 0.0  # s of computing time
    slack_steps: Array = field(default_factory=lambda: np.zeros(0))  # (m,) in which a line's excess was over `SLACK`
    max_tension: float = 0.0  # N, largest at a sheave
    refills: int = 0  # of the drum
    max_tilt: float = 0.0  # rad, largest angle of the drum's axis from the vertical
    yaw: tuple[float, float] = (0.0, 0.0)  # rad, smallest and largest
    powder: float = 0.0  # kg left
    readings: Counter[str] = field(default_factory=Counter)  # by kind, or by source where a kind has several
    notices: Counter[str] = field(default_factory=Counter)  # steps by notice
    path: list[tuple[float, ...]] = field(default_factory=list)  # time, B, tilt, yaw, excesses, about once a second
    poses: list[Array] = field(default_factory=list)  # (6,) m and rad, of B at the end of each step of a trajectory

    @property
    def slack_share(self) -> Array:
        """Share of the steps in which each line was slack by over `SLACK`, (m,)."""
        return self.slack_steps / max(self.steps, 1)

    @property
    def real_time_ratio(self) -> float:
        """Simulated time over computing time of the run."""
        return self.duration / self.elapsed

    def add(self, frame: SensorFrame, truth: Truth, before: Truth) -> None:
        """Add one step: its frame, and the true state at its end and *before* it."""
        if not self.steps:
            self.slack_steps = np.zeros(len(self.lines))
            self.yaw = (float(truth.rotation[2]),) * 2
        self.steps += 1
        self.duration = frame.time
        self.distance += float(np.sqrt(((truth.position - before.position) ** 2).sum()))
        self.slack_steps += truth.excess > SLACK
        self.max_tension = max(self.max_tension, float(truth.tensions.max()))
        x, y, yaw = truth.rotation.tolist()
        tilt = float(np.hypot(x, y))
        self.max_tilt = max(self.max_tilt, tilt)
        self.yaw = (min(self.yaw[0], yaw), max(self.yaw[1], yaw))
        self.powder = truth.powder
        self.readings.update(each.source if len(each.SOURCES) > 1 else type(each).__name__ for each in frame.readings)
        self.notices.update(f"{notice.subject}: {notice.condition.value}" for notice in frame.notices)
        if int(frame.time) != int(before.time):
            self.path.append((frame.time, *truth.position.tolist(), tilt, yaw, *truth.excess.tolist()))


def random_loop(robot: Robot, length: float, seed: int) -> Array:
    """Return a random closed path (k, 2), m, of that *length* (m) through the middle of the robot's frame, for `Pilot`.

    It crosses itself at least twice: curve number 0 of *seed*, see `printing/random_curve.py`. Raises `InputError` if
    no curve of that length is found.
    """
    if seed < 0:
        raise InputError(f"seed = {seed}: must be at least 0")
    low, high = np.array(robot.scene.frame_min[:2]), np.array(robot.scene.frame_max[:2])
    wide, deep = (high - low - 2.0 * INSET).tolist()
    curve = draw(CurveRequirements(length, (wide, deep)), seed, 0)
    return np.asarray(curve.even(max(16, round(length / _STEP))) + 0.5 * (low + high))


def path_length(path: Array) -> float:
    """Length, m, of a path (k, 2), m, of straight segments."""
    return float(np.hypot(*np.diff(path, axis=0).T).sum())


def drive(
    machine: SimulatedMachine,
    path: Array | Trajectory | None,
    duration: float,
    *,
    settings: DriveSettings | None = None,
    seed: int = 0,
    log: LogWriter | None = None,
    progress: Progress | None = None,
) -> PilotedDrive:
    """Move *machine* for *duration* (s) along *path* (see `Pilot`) or hold it, and write each step to *log*.

    After each round the container is refilled to its initial level. Raises `InputError` for a duration of less than a
    step, `AnswerError` where the platform cannot be held.
    """
    steps = round(duration / machine.period) if 0.0 < duration < 1e9 else 0
    if steps < 1:
        raise InputError(f"duration = {duration:g} s: must be at least one step, {machine.period:g} s")
    pilot = Pilot(machine, path, settings or DriveSettings(), seed)
    found = PilotedDrive(tuple(line.name for line in machine.robot.lines))
    rounds = 0
    begin = time.perf_counter()
    for step in range(steps):
        orders: tuple[Order, ...] = ()
        if pilot.rounds(machine.time) > rounds:
            rounds += 1
            found.refills += 1
            machine.refill(machine.settings.carrier.powder)
            orders = (Order(OrderKind.REFILLED, "drive", machine.time),)
        before, command = machine.truth, pilot.command()
        frame = machine.step(command)
        if log is not None:
            log.write(frame, command, machine.truth, orders=orders)
        found.add(frame, machine.truth, before)
        if isinstance(path, Trajectory):
            found.poses.append(np.concatenate([machine.truth.position, machine.truth.rotation]))
        if progress is not None and step % 50 == 0:
            progress("simulating", step, steps)
    found.elapsed = time.perf_counter() - begin
    return found
