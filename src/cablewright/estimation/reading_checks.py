"""Checks of readings, and handling of a frame, shared by the filter and the estimator of Merlet 2023.

Repeated, implausible and jumping readings are rejected; others are sorted, and lidar scans wait.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Final, Self, TypeVar

import numpy as np

from cablewright.estimation import slackness
from cablewright.estimation.clock_offset import ClockLead
from cablewright.estimation.fault_monitor import FaultMonitor
from cablewright.estimation.known_creep import KnownCreep
from cablewright.estimation.known_machine import KnownMachine
from cablewright.estimation.lidar.wall_lines import LidarTurn
from cablewright.estimation.slackness import SlacknessState
from cablewright.estimation.tilt import TiltSettings
from cablewright.estimation.time_buffer import TimeBuffer
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import (
    SOURCES,
    Climate,
    Encoders,
    Inertial,
    LineAngles,
    Reading,
    Scan,
    SensorFrame,
    miscounted,
)
from cablewright.kernels.filtering.predict import LEAST_TIME
from cablewright.models.winch_lines import WinchLines
from cablewright.robot import Line
from cablewright.solvers.taut import Taut

HISTORY_LENGTH: Final = 1500
"""Rows of a `TimeBuffer`: 15 s at 10 ms."""
_MAX_LEAP: Final = 1e6  # s between two frames, from which the clock was set
_LONG_STEP: Final = 0.05  # s, of a step in which all lidar scans are processed that arrive in it

_Kind = TypeVar("_Kind", bound=Reading)
_OF_DRUM: Final = frozenset(name for name, source in SOURCES.items() if source.clock == "drum")
"""Sensors whose readings the drum's clock stamps."""
_MAX_BAD: Final = 10  # identical or implausible readings in a row before the sensor is rejected
_MAX_BOUNCE: Final = 1.0  # s in which no acceleration is about gravity, before the sensor is rejected


@dataclass(eq=False)
class ReadingChecks:
    """Memory of the checks: last reading of each sensor, and how many IMU readings in a row were bad.

    ``winches``: winches whose encoders are read; None: one for each line.
    """

    monitor: FaultMonitor
    clock: ClockLead | None = None
    winches: WinchLines | None = None
    last_imu: Inertial | None = None
    imu_repeats: int = 0  # identical to the last bit
    imu_outliers: int = 0  # implausible
    gravity_time: float = -math.inf  # s: of the last acceleration that was about gravity
    last_encoders: Encoders | None = None
    last_ranges: dict[str, Array] = field(default_factory=dict)  # of each lidar's last turn

    @classmethod
    def of(cls, machine: KnownMachine) -> Self:
        """Return the checks of a *machine* before the first reading."""
        clock = None if machine.clock is None else ClockLead(machine.clock)
        return cls(FaultMonitor(dict(machine.timeouts)), clock, WinchLines.of(machine.model.robot))

    def accepted(self, frame: SensorFrame) -> Iterator[Reading]:
        """Yield the readings of a frame that are to be used, by the machine's clock."""
        readings = frame.readings
        if self.clock is not None:
            readings = by_machine_clock(self.clock, readings, frame.time)
        return filter(self._fits, accepted(self.monitor, readings, frame.time))

    def has_time(self, frame: SensorFrame) -> bool:
        """Whether a frame has a time; one without is reported."""
        if math.isfinite(frame.time):
            return True
        self.monitor.report("clock", "none", f"a frame of {frame.time:g} s: not used")
        return False

    def _fits(self, reading: Reading) -> bool:
        """Whether a reading has a number for each line; another one is reported."""
        own = self.winches
        wrong = None if own is None else miscounted(reading, len(own.host), len(own.hosts))
        if wrong is not None:
            why = f"a reading of {wrong[1]} lines, where there are {wrong[2]}: not used"
            self.monitor.report(reading.source, "lines", why)
        return wrong is None

    def reset(self) -> None:
        """Remove the last readings, because the clock was reset."""
        self.last_imu, self.last_encoders, self.gravity_time = None, None, -math.inf
        if self.clock is not None:
            self.clock.restart()


def by_machine_clock(clock: ClockLead, readings: tuple[Reading, ...], now: float) -> tuple[Reading, ...]:
    """Convert times of a frame's *readings* from the platform's clock to the machine's, or drop readings.

    *now*: time of the frame, s.
    """
    wrong = clock.hear([each.time for each in readings if each.source in _OF_DRUM], now)
    if wrong < math.inf:
        readings = tuple(each for each in readings if not (each.source in _OF_DRUM and each.time - now > wrong))
    ahead = clock.ahead
    return tuple([each.stamped(each.stamp - ahead) if each.source in _OF_DRUM else each for each in readings])


def accepted(monitor: FaultMonitor, readings: Iterable[_Kind], now: float) -> Iterator[_Kind]:
    """Yield the *readings* that are not ahead of *now*, s, and newer than the last one of their source."""
    for reading in readings:
        if monitor.is_new(reading.source, reading.time, now):
            yield reading


def accept_imu(checks: ReadingChecks, settings: TiltSettings, reading: Inertial) -> bool | None:
    """Return whether to use an IMU *reading*.

    None: this one alone is implausible; False: the sensor is faulty.
    """
    monitor = checks.monitor
    has_rate, has_gravity = settings.has_rate(reading), settings.has_gravity(reading)
    checks.imu_outliers = 0 if has_rate and has_gravity else checks.imu_outliers + 1
    if has_gravity:
        checks.gravity_time = reading.time
    if checks.imu_outliers >= _MAX_BAD and (not has_rate or reading.time - checks.gravity_time > _MAX_BOUNCE):
        monitor.report("inertial", "implausible", "measures motion that a drum on lines cannot have: not used")
        return False
    if not has_rate:
        return None
    monitor.clear("inertial", "implausible")
    last, checks.last_imu = checks.last_imu, reading
    same = last is not None and last.rate.tolist() == reading.rate.tolist() and _same_force(last, reading)
    checks.imu_repeats = checks.imu_repeats + 1 if same else 0
    if checks.imu_repeats >= _MAX_BAD:
        monitor.report("inertial", "stuck", "repeats the same reading: not used")
        return False
    monitor.clear("inertial", "stuck")
    return True


def _same_force(last: Inertial, reading: Inertial) -> bool:
    """Whether two readings have the same acceleration."""
    return bool(last.acceleration.tolist() == reading.acceleration.tolist())


def drum_rotation(
    checks: ReadingChecks, reading: Encoders, counts_per_radian: float, max_speed: float
) -> tuple[Array | None, float]:
    """Return the rotation (m,), rad, of each winch drum since the last reading, and the time since then, s.

    The rotation is None for the first reading and where counts jump by more than *max_speed* (rad/s) explains.
    """
    last, checks.last_encoders = checks.last_encoders, reading
    if last is None:
        return None, 0.0
    turned, dt = (reading.counts - last.counts) / counts_per_radian, reading.time - last.time
    own = checks.winches
    rotation = turned if own is None or own.plain else own.of_lines(turned)
    turns = rotation.tolist()
    if max(*turns, -min(turns)) > 2.0 * max_speed * max(dt, LEAST_TIME):
        report_jump(checks)
        return None, dt
    return rotation, dt


def report_jump(checks: ReadingChecks) -> None:
    """Report that counts jumped, so that they are not used."""
    checks.monitor.report("encoders", "jump", "the counts jumped by more than the winches can turn: left out")


def queue_scan(checks: ReadingChecks, pending: list[Scan], scan: Scan, keep: int) -> bool:
    """Append *scan* to the queue, unless it has no rays or is identical to the last one of its lidar; return whether.

    At most *keep* scans of a lidar wait (after a gap of the link); the oldest is dropped.
    """
    last = checks.last_ranges.get(scan.source)
    if last is not None and np.array_equal(last, scan.ranges, equal_nan=True):
        checks.monitor.report(scan.source, "stuck", "repeats the same scan: not used")
        return False
    checks.monitor.clear(scan.source, "stuck")
    checks.last_ranges[scan.source] = scan.ranges
    if not len(scan.ranges):
        return False
    pending.append(scan)
    own = [each for each in pending if each.source == scan.source]
    if len(own) > keep:
        pending.remove(own[0])
    return True


def report_line_sensors(monitor: FaultMonitor, lines: tuple[Line, ...], state: SlacknessState) -> None:
    """Report or clear the fault of each line's accelerometer: no reading, or always the same."""
    if not monitor.has_faults and state.all_measure:
        return
    found = state.excess.tolist(), state.stuck.tolist()
    if not (monitor.concerns("line_angles") or any(map(math.isnan, found[0])) or any(found[1])):
        return
    for line, excess, same in zip(lines, *found, strict=True):
        if same or math.isnan(excess):
            why = "repeats the same reading" if same else "gives no reading"
            monitor.report("line_angles", line.name, f"the accelerometer on line {line.name} {why}: not used")
        else:
            monitor.clear("line_angles", line.name)


@dataclass(eq=False)
class Turns:
    """Queue of lidar scans that wait, and the platform's motion, so that a late scan is used at its own time."""

    motion: TimeBuffer  # at the encoders' times
    attitudes: TimeBuffer  # yaw by the gyro alone and tilt x and y, rad, at the IMU's times
    pending: list[Scan] = field(default_factory=list)
    extracted: LidarTurn | None = None  # whose lines the next time step uses

    def clear(self) -> None:
        """Drop all waiting scans, as the clock was set."""
        self.motion.clear()
        self.attitudes.clear()
        self.pending.clear()
        self.extracted = None


@dataclass(eq=False, kw_only=True)
class ClockedState:
    """State that the filter and the estimator of Merlet 2023 share. Changed in place."""

    checks: ReadingChecks
    slackness: SlacknessState
    turns: Turns
    time: float = -math.inf  # s
    creep: KnownCreep | None = None  # of cables that creep as described
    taut: Taut | None = None
    clearance_offset: float = math.nan  # m: fictive height less z of B, or of the odometry

    @property
    def monitor(self) -> FaultMonitor:
        """Monitor of the sensor faults that are active."""
        return self.checks.monitor


_Settings = TypeVar("_Settings")
_State = TypeVar("_State", bound=ClockedState)


def advance(state: _State, now: float, restart: Callable[[_State, float], None]) -> float:
    """Advance the clock to *now*, s; return by how much, 0 where the clock was set.

    Earlier readings cannot be ordered with later ones then: they are dropped, and *restart* is called before.
    """
    if not 0.0 < now - state.time <= _MAX_LEAP and math.isfinite(state.time):
        state.monitor.restart(now, f"the clock jumped from {state.time:g} to {now:g} s: earlier readings are dropped")
        state.checks.reset()
        state.turns.clear()
        state.slackness = slackness.restarted(state.slackness)
        state.time = -math.inf
        restart(state, now)
    dt = now - state.time if math.isfinite(state.time) else 0.0
    state.time = now
    return dt


def read(
    settings: _Settings,
    machine: KnownMachine,
    state: _State,
    frame: SensorFrame,
    handlers: Mapping[type, Callable[[_Settings, _State, Any], None]],
) -> list[LineAngles]:
    """Process the readings of a *frame* by their *handlers*, queue scans, and return those of line angles."""
    line_angles = []
    for reading in state.checks.accepted(frame):
        if isinstance(reading, LineAngles):
            line_angles.append(reading)
        elif isinstance(reading, Scan):
            if reading.source in (*machine.lidars, "vertical"):
                queue_scan(state.checks, state.turns.pending, reading, machine.walls.kept_turns)
        elif isinstance(reading, Climate):
            if state.creep is not None:
                state.creep.read(reading)
        elif type(reading) in handlers:
            handlers[type(reading)](settings, state, reading)
    return line_angles


def process_turns(settings: _Settings, state: _State, dt: float, process: Callable[[_Settings, _State], None]) -> None:
    """Let *process* do the next part of the work on waiting scans: as much as a step of *dt*, s, has time for."""
    process(settings, state)
    while dt > _LONG_STEP and (state.turns.pending or state.turns.extracted is not None):
        process(settings, state)


def follow_angles(machine: KnownMachine, state: ClockedState, readings: list[LineAngles], taut: Taut) -> None:
    """Use all line angle *readings* of a step: lines vibrate, so that leaving out some would not average the rest."""
    for reading in readings:
        state.slackness = slackness.step(machine.slackness, state.slackness, reading, taut)
