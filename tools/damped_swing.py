"""How the drum of merlet2023 swings after gusts and after a refill, with and without the damping of a print.

    python -m tools.damped_swing

It prints a ring on the dynamic plant. Pushes of 20 N for about a second act on the platform; or its powder runs out,
and 26 kg are filled in at once while it waits.
"""

from __future__ import annotations

import math
import sys
import tempfile
from pathlib import Path

import numpy as np

import cablewright as cw
from cablewright.foundation.signals import PrintState
from cablewright.live.prints.attendant import Attendant
from cablewright.live.prints.plan import plan_print, twin_of
from cablewright.live.prints.run import begin_print
from cablewright.machine.log.log import read_log
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


def main() -> None:
    """Print the tables."""
    table("gusts", [swings(damping=each) for each in (True, False)])
    table("refill", [refilled(damping=each) for each in (True, False)])


if __name__ == "__main__":
    main()
