"""How platforms swing after gusts and after a refill, with and without the damping of a print.

    python -m tools.damped_swing drum       # the drum of merlet2023, damped by its tilt
    python -m tools.damped_swing stretch    # house-printer and cogiro, damped by load cells; or: stretch cogiro rough

They print a ring on the dynamic plant. Pushes of 20 N for about a second act on the platform; or its powder runs out,
and 26 kg are filled in suddenly while it waits.
"""

from __future__ import annotations

import math
import sys
import tempfile
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Final, get_args

import numpy as np

import cablewright as cw
from cablewright.foundation.arrays import Array
from cablewright.foundation.choices import SeverityName
from cablewright.foundation.signals import PrintState
from cablewright.live.prints.loop import Printer
from cablewright.live.prints.plan import plan_print, twin_of
from cablewright.live.prints.run import begin_print
from cablewright.live.prints.simulated_operator import Attendant
from cablewright.machine.log.log import read_log
from cablewright.machine.sensors.tensions import TensionSensor
from cablewright.machine.simulated.settings import TwinSettings
from cablewright.machine.simulated.severities import with_severity
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.printing.job import Job, Motion
from cablewright.printing.numeric_path import Helix
from cablewright.robot import load

WINDOW = 4.0  # s
WINDOWS = 7  # after a refill
FULL = 26.0  # kg
LITTLE = 0.05  # kg, in the beginning of a print with a refill
RING = Job(
    name="ring",
    helix=Helix(radius=0.3, layers=1, layer_height=0.001, first_height=1.0),
    motion=Motion(print_speed=0.03),
)


def swings(*, damping: bool, seed: int = 3) -> list[float]:
    """The largest tilt of the drum in each window of the print, mrad."""
    machine = cw.load_twin("merlet2023")
    pushes = machine.simulation.pushes.model_copy(update={"force": 20.0, "pause": 15.0, "length": 1.0})
    options = cw.PrintOptions(seed=seed, damping=damping)
    times, tilts = [], []
    with tempfile.TemporaryDirectory() as folder:
        run = Path(folder) / "run"
        cw.print_job("merlet2023", RING, run, machine=machine.with_simulation(pushes=pushes), options=options)
        with read_log(run / "log.mcap") as log:
            for entry in log.entries():
                printing = entry.progress is not None and entry.progress.state == "printing"
                if entry.truth is not None and printing:
                    times.append(entry.frame.time)
                    tilts.append(1e3 * math.hypot(*entry.truth.rotation[:2]))
    window = ((np.array(times) - times[0]) / WINDOW).astype(int)
    return [float(np.array(tilts)[window == k].max()) for k in range(window.max())]


def refilled(*, damping: bool, seed: int = 3) -> list[float]:
    """The largest tilt of the drum in each window after a refill, mrad, from when the print goes on."""
    machine = cw.load_twin("merlet2023")
    drum = machine.owner.point_drum.model_copy(update={"powder": FULL})
    owner = machine.owner.model_copy(update={"drum": drum})
    options = cw.PrintOptions(seed=seed, damping=damping)
    twin = twin_of(load("merlet2023"), RING, machine.model_copy(update={"owner": owner}), options)
    simulated, printer = begin_print(twin, plan_print(twin))
    simulated.refill(LITTLE)
    attendant = Attendant(lambda: simulated.refill(FULL), refill_time=5.0)
    times: list[float] = []
    tilts: list[float] = []
    simulated.open()
    while len(times) * simulated.period < WINDOWS * WINDOW:
        printer.step(attendant.orders(printer, printer.time))
        if simulated.truth.powder > LITTLE and printer.supervisor.state in (PrintState.READY, PrintState.PRINTING):
            times.append(printer.time)
            tilts.append(1e3 * math.hypot(*simulated.truth.rotation[:2]))
    simulated.close()
    return [float(each.max()) for each in np.array_split(tilts, WINDOWS)]


def table(title: str, found: list[list[float]]) -> None:
    """Print what was *found* with damping and without."""
    sys.stdout.write(f"{title}\nwindow of 4 s   tilt with damping, mrad   without\n")
    for k, row in enumerate(zip(*found, strict=True)):
        sys.stdout.write(f"{k:14d}   {row[0]:23.1f}   {row[1]:7.1f}\n")


@dataclass
class Push:
    """A force (2,), N, that lasts for a second from *begin*, s."""

    force: tuple[float, float]
    begin: float = math.inf

    def at(self, time: float) -> Array:
        """As `Pushes`."""
        return np.array(self.force) * (self.begin <= time < self.begin + 1.0)


GUST: Final = (16.0, 12.0)  # N
CELLS: Final = TensionSensor(rate=100.0, deviation=5.0, bias=5.0, gain_deviation=0.005, most=6000.0)  # cogiro's
FIRST: Final = 2.0  # s of the print, before the push
LAST: Final = 8.0  # s, looked at after push or refill
HEIGHTS: Final = {"house-printer": 1.0, "cogiro": 3.0}  # m
WAVE: Final = 0.6  # s: windows in which a swing has its largest ...
STEP: Final = 0.2  # s: ... one begins each


def machine_of(robot: str, severity: SeverityName, delay: float) -> TwinSettings:
    """The library's machine with load cells, whose readings come late by *delay*, s, and a container for powder."""
    machine = cw.load_twin(robot)
    carrier = machine.owner.carrier.model_copy(
        update={"powder": FULL, "capacity": FULL, "radius": 0.3, "powder_density": 1500.0}
    )
    carried = {"drum" if machine.owner.body is None else "body": carrier}
    if machine.owner.body is not None:
        carried["body"] = carrier.model_copy(update={"tour": ()})
    machine = with_severity(machine.with_owner(load_cells=CELLS, **carried), severity)
    wire = machine.simulation.wire.model_copy(update={"latency": machine.simulation.wire.latency + delay})
    return machine.with_simulation(wire=wire)


def begun(
    robot: str, severity: SeverityName, delay: float, damping: bool, seed: int
) -> tuple[SimulatedMachine, Printer]:
    """The print of a ring, at its beginning."""
    helix = Helix(radius=0.3, layers=1, layer_height=0.001, first_height=HEIGHTS[robot])
    ring = RING.model_copy(update={"helix": helix})
    machine = machine_of(robot, severity, delay)
    pushed = machine.simulation.pushes.model_copy(update={"force": 1.0, "pause": 1e6, "length": 1.0})
    options = cw.PrintOptions(seed=seed, damping=damping)
    twin = twin_of(load(robot), ring, machine.with_simulation(pushes=pushed), options)
    return begin_print(twin, plan_print(twin))


def course(
    robot: str, severity: SeverityName, delay: float, *, damping: bool, force: tuple[float, float] | None, seed: int = 1
) -> Array:
    """How far (k, 3), m, the platform is from the target, in each period after a push, or else a refill.

    None (0, 3) where the machine stops, since its estimator finds tensions that contradict each other.
    """
    simulated, printer = begun(robot, severity, delay, damping, seed)
    if force is None:
        simulated.refill(LITTLE)
        if simulated.robot.n == 6:
            printer.load.poured = FULL - LITTLE  # its estimator weighs what the cells carry
    push = Push(force or (0.0, 0.0))
    simulated.rig.unmodelled.pushes = push  # type: ignore[assignment]
    found: list[Array] = []
    attendant = Attendant(lambda: simulated.refill(FULL), refill_time=5.0)
    simulated.open()
    while len(found) * simulated.period < LAST:
        printer.step(attendant.orders(printer, printer.time))
        moves = printer.supervisor.state in (PrintState.READY, PrintState.PRINTING)
        if math.isinf(push.begin) and printer.supervisor.state is PrintState.PRINTING:
            push.begin = printer.time + FIRST
        after = simulated.truth.powder > LITTLE if force is None else printer.time >= push.begin + 1.0
        if printer.time > 1.0 and printer.supervisor.state in (PrintState.FAULT, PrintState.STOPPED):
            simulated.close()
            return np.zeros((0, 3))
        if moves and after and printer.target is not None:
            found.append(simulated.truth.position - printer.target.position)
    simulated.close()
    return np.array(found)


def waves(deviations: Array, period: float) -> Array:
    """The largest deviation, m, from a straight course in each window; one begins each `STEP`."""
    size, step = round(WAVE / period), round(STEP / period)
    line = np.stack([np.ones(size), np.arange(size)], axis=1)
    off = np.eye(size) - line @ np.linalg.pinv(line)
    begins = range(0, len(deviations) - size, step)
    return np.array([np.linalg.norm(off @ deviations[k : k + size], axis=1).max() for k in begins])


def settled(found: Array, first: float) -> str:
    """The time, s, from which on no window has a tenth of the *first* one."""
    large = np.flatnonzero(found >= 0.1 * first)
    time = STEP * (large[-1] + 1) if len(large) else 0.0
    return f"> {time - STEP:.1f}" if len(large) and large[-1] == len(found) - 1 else f"{time:.1f}"


def stretch_table(robot: str, severities: Collection[SeverityName]) -> None:
    """Print how soon a *robot* settles, and how much it moves without a push, by severity and delay."""
    for severity in severities:
        for delay in (0.0, 0.04) if severity == "ideal" else (0.04,):
            cells = []
            for event in ("gust", "refill"):
                found = []
                for damping in (False, True):
                    moved = course(robot, severity, delay, damping=damping, force=GUST if event == "gust" else None)
                    if event == "gust":
                        quiet = course(robot, severity, delay, damping=damping, force=(0.0, 0.0))
                        cells.append(f"{1e3 * np.median(waves(quiet, 0.01)):.3f}")
                        moved = moved - quiet
                    found.append(waves(moved, 0.01) if len(moved) else moved)
                if not all(map(len, found)):
                    cells += ["stops"] * 3
                    continue
                first = found[0][:4].max()
                cells += [f"{1e3 * first:.2f}", *(settled(each, first) for each in found)]
            name = f"| {robot} | {severity} | {1e3 * delay:.0f} "
            sys.stdout.write(name + "".join(f"| {each} " for each in cells) + "|\n")
            sys.stdout.flush()


def main() -> None:
    """Print the requested tables."""
    if "stretch" in sys.argv[1:]:
        sys.stdout.write(
            "| robot | severity | delay, ms | still, without, mm | with | gust, mm | without, s | with, s "
            "| refill, mm | without, s | with, s |\n" + "| --- " * 11 + "|\n"
        )
        severities: tuple[SeverityName, ...] = get_args(SeverityName)
        some = [each for each in severities if each in sys.argv] or severities
        for robot in HEIGHTS.keys() & set(sys.argv) or HEIGHTS:
            stretch_table(robot, some)
    if "drum" in sys.argv[1:]:
        table("gusts", [swings(damping=each) for each in (True, False)])
        table("refill", [refilled(damping=each) for each in (True, False)])


if __name__ == "__main__":
    main()
