"""Residual swing of the house printer after corners, planned stops, pauses and jogs that are shaped.

    python -m tools.motion.shaped_stops

The nonlinear dynamic plant of a print follows a path whose shaper takes frequencies that are wrong.
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

import cablewright as cw
from cablewright.control.path_follower import TimedPath
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Order, OrderKind, PrintState
from cablewright.live.prints.loop import Printer
from cablewright.live.prints.plan import MachineTwin, plan_print, twin_of
from cablewright.live.prints.run import begin_print
from cablewright.printing.job import Job
from cablewright.robot import load

ROBOT: Final = load("house-printer")
SPEEDS: Final = (0.2, 0.25, 0.3)  # m/s: one of them alone may leave little by chance
WRONG: Final = (0.75, 0.9, 1.0, 1.1, 1.25)  # true frequency over the one that is assumed
TEXT: Final = """G21
G90
M83
G0 X0 Y0 Z800 F{feed}
G1 X1800 E9 F{feed}
G1 Y1500 E9
G4 P4000
G1 X-1500 E9
"""
PAUSE: Final = 5.2  # m along the path, which begins on the floor
WINDOW: Final = 1.5  # s
RATES: Final = np.linspace(1.5, 5.0, 36)  # Hz, at which a swing is looked for
JOG: Final = (0.2, 0.0, 0.0)  # m/s


@dataclass
class Course:
    """Times, s, deviations from the target, m, and the target's velocities, m/s, of a print with a pause and a jog."""

    printer: Printer
    times: list[float]
    errors: list[Array]
    velocities: list[Array]
    paused: float = np.nan
    jogged: float = np.nan

    def swing(self, begin: float) -> float:
        """The amplitude, m, of the largest wave in a window from *begin*, s, on, beside what the control corrects."""
        times = np.array(self.times)
        rows = (times >= begin) & (times < begin + WINDOW)
        time, errors, sizes = times[rows] - begin, np.array(self.errors)[rows], []
        for rate in 2.0 * np.pi * RATES:
            waves = [np.ones_like(time), time, time**2, np.cos(rate * time), np.sin(rate * time)]
            fitted = np.linalg.lstsq(np.stack(waves, axis=1), errors, rcond=None)[0]
            sizes.append(np.sqrt((fitted[3:] ** 2).sum()))
        return float(max(sizes))

    def found(self) -> tuple[float, ...]:
        """Residual swing in windows after the corner, in the planned stop, in the pause and in the jog, m."""
        speeds, times = np.linalg.norm(self.velocities, axis=1), np.array(self.times)
        ways = np.array(self.velocities)
        corner = times[np.flatnonzero((ways[:, 1] > 0.01) & (speeds > 0.05))[0]]
        stop = times[np.flatnonzero((speeds < 1e-9) & (times > corner + 1.0))[0]]
        still = times[np.flatnonzero((speeds < 1e-9) & (times > self.paused))[0]]
        return self.swing(corner + 1.5), self.swing(stop + 0.1), self.swing(still + 0.1), self.swing(self.jogged + 1.8)


def twin(speed: float, shaping: str, folder: Path) -> MachineTwin:
    """The machine, without faults of its own, and its job."""
    file = folder / "part.gcode"
    file.write_text(TEXT.format(feed=6e4 * speed))
    bead = {"width": 0.06, "height": 0.02}
    motion = {"shaping": shaping, "print_speed": speed, "travel_speed": speed}
    job = Job.model_validate({"name": "stops", "gcode": str(file), "bead": bead, "motion": motion})
    return twin_of(ROBOT, job, None, cw.PrintOptions(severity="ideal", seed=1))


def wrong(path: TimedPath, factor: float) -> TimedPath:
    """The path as shaped for a period that is *factor* times as long."""
    assert path.shaping is not None
    shaper, samples = path.shaping
    other = replace(shaper, period=lambda places: factor * shaper.period(places))
    return replace(path, shaping=(other, samples)).slower(path.acceleration, np.full(len(path.speed), np.inf))


def printed(speed: float, shaping: str, factor: float, folder: Path) -> Course:
    """Print with a pause in the last leg, and jog after it."""
    made = twin(speed, shaping, folder)
    if shaping == "auto":
        made = replace(made, path=wrong(made.path, factor))
    plan = plan_print(made)
    if (period := plan.path.period) is not None:

        def late(place: Array) -> float:
            return factor * period(place)

        plan = replace(plan, path=replace(plan.path, period=late), manual=replace(plan.manual, period=late))
    machine, printer = begin_print(made, plan)
    course = Course(printer, [], [], [])
    machine.open()
    printer.step(tuple(Order(kind, "tool", printer.time) for kind in (OrderKind.RESET, OrderKind.ENABLE)))
    printer.step((Order(OrderKind.START, "tool", printer.time),))
    for _ in range(20_000):
        now, orders = printer.time, []
        state, target = printer.supervisor.state, printer.target
        if np.isnan(course.paused) and state is PrintState.PRINTING and target and target.distance > PAUSE:
            orders, course.paused = [OrderKind.PAUSE], now
        elif now > course.paused + 8.0 and state is PrintState.PAUSED:
            orders = [OrderKind.STOP]
        elif now > course.paused + 10.0 and state is PrintState.STOPPED:
            orders = [OrderKind.RESET]
        elif now > course.paused + 12.0 and state in (PrintState.IDLE, PrintState.MANUAL):
            course.jogged = now if np.isnan(course.jogged) else course.jogged
            orders = [OrderKind.JOG]
        if now > course.jogged + 4.0:
            break
        printer.step(
            tuple(
                Order(each, "tool", now, arguments={"velocity": JOG} if each is OrderKind.JOG else {})
                for each in orders
            )
        )
        if printer.target is not None:
            course.times.append(printer.time)
            course.errors.append(machine.truth.position - printer.target.position)
            course.velocities.append(printer.target.velocity)
    machine.close()
    return course


def main() -> None:
    """Print the table."""
    write = sys.stdout.write
    with tempfile.TemporaryDirectory() as folder:
        wild = [np.array(printed(speed, "none", 1.0, Path(folder)).found()) for speed in SPEEDS]
        before = np.max(wild, axis=0)
        names = ("corner of 90 degrees", "planned stop", "pause", "start of a jog")
        write("| true frequency / assumed | " + " | ".join(f"{each}, mm (left)" for each in names) + " |\n")
        write("| --- | --- | --- | --- | --- |\n")
        write("| not shaped | " + " | ".join(f"{1e3 * each:.2f}" for each in before) + " |\n")
        for factor in WRONG:
            calm = np.max([printed(speed, "auto", factor, Path(folder)).found() for speed in SPEEDS], axis=0)
            cells = (f"{1e3 * one:.2f} ({one / other:.0%})" for one, other in zip(calm, before, strict=True))
            write(f"| {factor:g} | " + " | ".join(cells) + " |\n")


if __name__ == "__main__":
    main()
