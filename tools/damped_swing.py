"""How the drum of merlet2023 swings after gusts, with and without the damping of a print.

    python -m tools.damped_swing

Pushes of 20 N for about a second act on the platform while it prints a ring on the dynamic plant.
"""

from __future__ import annotations

import math
import sys
import tempfile
from pathlib import Path

import numpy as np

import cablewright as cw
from cablewright.machine.log.log import read_log
from cablewright.printing.job import Job, Motion
from cablewright.printing.numeric_path import Helix

WINDOW = 4.0  # s
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


def main() -> None:
    """Print the table."""
    found = [swings(damping=each) for each in (True, False)]
    sys.stdout.write("window of 4 s   tilt with damping, mrad   without\n")
    for k, row in enumerate(zip(*found, strict=True)):
        sys.stdout.write(f"{k:14d}   {row[0]:23.1f}   {row[1]:7.1f}\n")


if __name__ == "__main__":
    main()
