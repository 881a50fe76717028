"""Checks of sensor readings, shared by the estimators: repeated, implausible and jumping ones are rejected."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Final, TypeVar

import numpy as np

from cablewright.arrays import Array
from cablewright.estimation.drum_clock import ClockLead
from cablewright.estimation.fault_monitor import FaultMonitor
from cablewright.estimation.slackness import SlacknessState
from cablewright.estimation.tilt import TiltSettings
from cablewright.robot import Line
from cablewright.signals import SOURCES, Encoders, Inertial, Reading, Scan, SensorFrame, per_line

HISTORY_LENGTH: Final = 1500
"""Rows of a `TimeBuffer`: 15 s at 10 ms."""
MAX_LEAP: Final = 1e6
"""Time between two frames, s, from which the clock was set."""
LONG_STEP: Final = 0.05
"""Time step, s, beyond which all lidar turns are processed in the step that they arrive in."""

_Kind = TypeVar("_Kind", bound=Reading)
_MAX_BAD: Final = 10  # identical or implausible readings in a row before the sensor is rejected
_MAX_BOUNCE: Final = 1.0  # s in which no acceleration is about gravity, before the sensor is rejected


@dataclass(eq=False)
class ReadingChecks:
    """The last reading of each sensor, and how many of the IMU's in a row were bad."""

    monitor: FaultMonitor
    clock: ClockLead | None = None
    lines: int = 0
    last_imu: Inertial | None = None
    imu_repeats: int = 0  # identical to the last bit
    imu_outliers: int = 0  # implausible
    gravity_time: float = -math.inf  # s: of the last acceleration that was about gravity
    last_encoders: Encoders | None = None
    last_ranges: dict[str, Array] = field(default_factory=dict)  # of each lidar's last turn

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
        for name in per_line(type(reading)):
            count = len(getattr(reading, name))
            if count != self.lines:
                why = f"a reading of {count} lines, where there are {self.lines}: not used"
                self.monitor.report(reading.source, "lines", why)
                return False
        return True

    def reset(self) -> None:
        """Remove the last readings, because the clock was reset."""
        self.last_imu, self.last_encoders, self.gravity_time = None, None, -math.inf
        if self.clock is not None:
            self.clock.restart()


def by_machine_clock(clock: ClockLead, readings: tuple[Reading, ...], now: float) -> tuple[Reading, ...]:
    """Return the *readings* of a frame of time *now*, s, those of the drum by the machine's clock, or not at all."""
    wrong = clock.hear([each.time for each in readings if _is_of_drum(each)], now)
    if wrong < math.inf:
        readings = tuple(each for each in readings if not (_is_of_drum(each) and each.time - now > wrong))
    return tuple(each.stamped(each.stamp - clock.ahead) if _is_of_drum(each) else each for each in readings)


def _is_of_drum(reading: Reading) -> bool:
    """Whether the drum's clock stamped a reading."""
    return SOURCES[reading.source].clock == "drum"


def accepted(monitor: FaultMonitor, readings: Iterable[_Kind], now: float) -> Iterator[_Kind]:
    """Yield the *readings* that are not ahead of *now*, s, and newer than the last one of their source."""
    for reading in readings:
        if monitor.is_new(reading.source, reading.time, now):
            yield reading


def accept_imu(checks: ReadingChecks, settings: TiltSettings, reading: Inertial) -> bool | None:
    """Whether to use an IMU *reading*. None: this one alone is implausible; False: the sensor is faulty."""
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
    same = last is not None and _numbers(last) == _numbers(reading)
    checks.imu_repeats = checks.imu_repeats + 1 if same else 0
    if checks.imu_repeats >= _MAX_BAD:
        monitor.report("inertial", "stuck", "repeats the same reading: not used")
        return False
    monitor.clear("inertial", "stuck")
    return True


def _numbers(reading: Inertial) -> list[float]:
    """All numbers of a reading."""
    return [*reading.rate.tolist(), *reading.acceleration.tolist()]


def drum_rotation(
    checks: ReadingChecks, reading: Encoders, counts_per_radian: float, max_speed: float
) -> tuple[Array | None, float]:
    """Rotation (m,), rad, of each winch drum since the last reading, and the time since then, s.

    The rotation is None for the first reading and where counts jump by more than *max_speed* (rad/s) explains.
    """
    last, checks.last_encoders = checks.last_encoders, reading
    if last is None:
        return None, 0.0
    rotation, dt = (reading.counts - last.counts) / counts_per_radian, reading.time - last.time
    if max(map(abs, rotation.tolist())) > 2.0 * max_speed * max(dt, 0.02):
        checks.monitor.report("encoders", "jump", "the counts jumped by more than the winches can turn: left out")
        return None, dt
    return rotation, dt


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
    for line, excess, same in zip(lines, state.excess.tolist(), state.stuck.tolist(), strict=True):
        if same or math.isnan(excess):
            why = "repeats the same reading" if same else "gives no reading"
            monitor.report("line_angles", line.name, f"the accelerometer on line {line.name} {why}: not used")
        else:
            monitor.clear("line_angles", line.name)
