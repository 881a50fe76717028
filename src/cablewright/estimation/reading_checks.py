"""What is taken of a machine's readings and what is not: repeated, astray, jumped. Both estimators use it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.estimation.fault_monitor import Watch
from cablewright.estimation.tilt import TiltSettings
from cablewright.robot import Line
from cablewright.signals import Encoders, Inertial, Scan

__all__ = ["KEPT", "UNHURRIED", "Intake", "felt", "line_faults", "queue", "seen", "turned"]

Array = NDArray[np.float64]

KEPT: Final = 1500
"""Rows of the past: 15 s at 10 ms."""
UNHURRIED: Final = 0.05
"""s from one step to the next that leave time for all turns of lidars."""

_STUCK: Final = 10  # readings in a row, the same to the last bit


@dataclass(eq=False)
class Intake:
    """What was heard last, and how often in a row it was no good."""

    watch: Watch
    inertial: Inertial | None = None
    alike: int = 0  # inertial readings in a row to the last bit the same ...
    astray: int = 0  # ... and that no drum causes
    encoders: Encoders | None = None
    ranges: dict[str, Array] = field(default_factory=dict)  # of each lidar's last turn

    def forget(self) -> None:
        """Compare with nothing: the clock began anew."""
        self.inertial, self.encoders = None, None


def felt(intake: Intake, settings: TiltSettings, reading: Inertial) -> bool | None:
    """Whether an inertial *reading* counts; None for one that is astray, which is left out alone."""
    if not settings.believes(reading):
        intake.astray += 1
        if intake.astray >= _STUCK:
            intake.watch.say("inertial", "astray", "tells what no drum on lines does: not used")
            return False
        return None
    intake.astray = 0
    intake.watch.clear("inertial", "astray")
    last, intake.inertial = intake.inertial, reading
    same = last is not None and np.array_equal(last.rate, reading.rate)
    same = same and last is not None and np.array_equal(last.acceleration, reading.acceleration)
    intake.alike = intake.alike + 1 if same else 0
    if intake.alike >= _STUCK:
        intake.watch.say("inertial", "stuck", "tells the same again and again: not used")
        return False
    intake.watch.clear("inertial", "stuck")
    return True


def turned(intake: Intake, reading: Encoders, counts: float, fastest: float) -> tuple[Array | None, float]:
    """How far each winch drum turned since the last reading, (m,) rad, and s since then.

    None for the first reading, and for counts that jumped by more than the winches can turn. *counts* for a radian;
    *fastest*: rad/s.
    """
    last, intake.encoders = intake.encoders, reading
    if last is None:
        return None, 0.0
    by, since = (reading.counts - last.counts) / counts, reading.time - last.time
    if np.abs(by).max() > 2.0 * fastest * max(since, 0.02):
        intake.watch.say("encoders", "jump", "the counts jumped by more than the winches can turn: left out")
        return None, since
    return by, since


def seen(intake: Intake, scan: Scan) -> bool:
    """Whether a turn of a lidar is another than the last, and has rays."""
    last = intake.ranges.get(scan.source)
    if last is not None and np.array_equal(last, scan.ranges, equal_nan=True):
        intake.watch.say(scan.source, "stuck", "tells the same scan again and again: not used")
        return False
    intake.watch.clear(scan.source, "stuck")
    intake.ranges[scan.source] = scan.ranges
    return len(scan.ranges) > 0


def queue(pending: list[Scan], scan: Scan, keep: int) -> None:
    """Put a turn in the queue; of more than *keep* of one lidar, as after a gap of the link, the oldest is left out."""
    pending.append(scan)
    own = [each for each in pending if each.source == scan.source]
    if len(own) > keep:
        pending.remove(own[0])


def line_faults(watch: Watch, lines: tuple[Line, ...], dead: NDArray[np.bool_], stuck: NDArray[np.bool_]) -> None:
    """Say which lines' accelerometers are dead (m,), or stuck."""
    for line, none, same in zip(lines, dead, stuck, strict=True):
        if same or none:
            why = "tells the same again and again" if same else "tells nothing"
            watch.say("line_angles", line.name, f"the accelerometer on line {line.name} {why}: not used")
        else:
            watch.clear("line_angles", line.name)
