"""How the house printer lays one layer of the house on the nonlinear dynamic plant, with and without shaping.

python -m tools.motion.printed_layer none      (or auto; each takes a quarter of an hour)
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Final

import numpy as np

import cablewright as cw
from cablewright.foundation.signals import PrintState
from cablewright.live.prints.plan import plan_print, twin_of
from cablewright.live.prints.run import begin_print
from cablewright.live.prints.simulated_operator import Attendant
from cablewright.models.path_offset import nearest_of_each
from cablewright.printing.job import load_job
from cablewright.robot import load

HOUSE: Final = Path(__file__).resolve().parent.parent.parent / "examples" / "house.toml"
SEARCH: Final = 0.3  # m along the path
SLACK: Final = 1.0  # N


def main() -> None:
    """Print the row of one kind of shaping."""
    shaping = sys.argv[1]
    job = load_job(HOUSE)
    job = job.model_copy(update={"motion": job.motion.model_copy(update={"shaping": shaping})})
    twin = twin_of(load("house-printer"), job, None, cw.PrintOptions(layers=1, severity="ideal", seed=1))
    machine, printer = begin_print(twin, plan := plan_print(twin))
    attendant, rows, tensions = Attendant(lambda: None), [], []
    machine.open()
    while not printer.finished:
        step = printer.step(attendant.orders(printer, printer.time))
        if step.progress.state is PrintState.PRINTING and printer.target is not None:
            rows.append((printer.time, printer.target.distance, *machine.truth.position, printer.target.position[2]))
            tensions.append(machine.truth.tensions)
        elif printer.supervisor.state in (PrintState.FAULT, PrintState.STOPPED) and rows:
            sys.exit(f"{printer.supervisor.state}: {printer.supervisor.reason}")
    machine.close()
    found, pulls = np.array(rows), np.array(tensions)
    _, aside = nearest_of_each(plan.path.track, found[:, 2:5], found[:, 1], SEARCH)
    away = 1e3 * np.hypot(aside, found[:, 4] - found[:, 5])
    slack = (pulls < SLACK).any(axis=1).mean()
    sys.stdout.write(
        f"| {shaping} | {found[-1, 0] - found[0, 0]:.0f} | {np.nanpercentile(away, 50):.2f} | "
        f"{np.nanpercentile(away, 95):.2f} | {np.nanmax(away):.2f} | {pulls.min():.0f} | {slack:.2%} |\n"
    )


if __name__ == "__main__":
    main()
