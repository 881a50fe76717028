"""Errors and coverage of the estimators of rigid platforms on machines whose cables creep and whose exit points give.

    python -m benchmarks.campaigns.body_stretch 20 250 60001             # machines, seconds, first seed
    python -m benchmarks.campaigns.body_stretch 20 250 60001 none,rough  # of some of `ROWS`

`cogiro` prints the house file at scale 12 by all sensors, in steps of 0.2 s from equilibrium to equilibrium, and
encoders alone are beside it. Besides the tolerances of the machine's file it has creep, hysteresis and exit points that
give by a severity, unknown to the estimators; in ``told-rough`` its owner knows how large they are, as
standard deviations in `[accuracy]`. In ``described`` the creep of `rough` is that of the robot file, of all lines
equally, and without other effects. Positions count once a second from the first step on. Coverage is the share of these
within the 95 % ellipsoid of the estimate's covariance, and the nees is ideally 3; positions of one machine are not
independent. Stopped: prints that ended in a fault.
"""

from __future__ import annotations

import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from multiprocessing import get_context
from pathlib import Path
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Estimate
from cablewright.live.error_statistics import CHI2_95
from cablewright.live.estimators import estimator
from cablewright.live.prints.plan import PrintOptions, plan_print, twin_of
from cablewright.live.prints.run import begin_print
from cablewright.live.prints.simulated_operator import attendant_of
from cablewright.machine.description_sigmas import MachineAccuracy
from cablewright.machine.simulated.settings import TwinSettings, whole_machine
from cablewright.machine.simulated.severity_tables import SEVERITIES
from cablewright.models.creep import usual_creep
from cablewright.printing.job import load_job
from cablewright.robot import Robot, load
from cablewright.solvers.inverse import inverse

HOUSE: Final = Path(__file__).resolve().parents[2] / "examples" / "house.toml"
JOB: Final = load_job(HOUSE).model_copy(update={"scale": 12.0})
PARTS: Final = {"creep": ("cable", "creep"), "hysteresis": ("cable", "hysteresis"), "exits": ("exits", "compliance")}
ROWS: Final = (
    "none",
    "described",
    *(f"{part}-{severity}" for part in PARTS for severity in ("typical", "rough")),
    "typical",
    "rough",
    "told-rough",
)
ESTIMATORS: Final = ("filter", "encoders")
PERIOD, EVERY = 0.2, 5  # s, steps


@dataclass
class Found:
    """What came of the positions of one estimator."""

    errors: list[float] = field(default_factory=list)  # m
    nees: list[float] = field(default_factory=list)
    sigmas: list[float] = field(default_factory=list)  # m, in space

    def add(self, estimate: Estimate, position: Array) -> None:
        """Add a position."""
        off, covariance = estimate.position - position, estimate.covariance
        assert covariance is not None
        own = covariance[:3, :3]
        self.errors.append(float(np.linalg.norm(off)))
        self.nees.append(float(off @ np.linalg.solve(own, off)))
        self.sigmas.append(float(np.sqrt(np.trace(own))))

    def row(self) -> str:
        """Figures, mm and %."""
        size, nees = 1e3 * np.array(self.errors), np.array(self.nees)
        sigma = 1e3 * np.sqrt(np.mean(np.square(self.sigmas)))
        return (
            f"{np.sqrt((size**2).mean()):.2f}, {size.max():.1f} mm | {sigma:.2f} mm | "
            f"{100.0 * np.mean(nees <= CHI2_95):.1f} % | {nees.mean():.2f}"
        )


@dataclass
class Watched:
    """What came of one print. ``stopped``: why, if it ended in a fault."""

    found: dict[str, Found] = field(default_factory=lambda: {name: Found() for name in ESTIMATORS})
    stopped: str = ""


def machine_of(row: str) -> tuple[Robot, TwinSettings]:
    """The robot as its owner describes it, and the machine, of one of `ROWS`."""
    robot, twin = load("cogiro"), whole_machine("cogiro")
    if row in ("none", "described"):
        return (robot if row == "none" else creeping(robot)), twin
    part, _, severity = row.rpartition("-")
    if part == "told":
        own = SEVERITIES[severity]
        sizes = {"hysteresis": own["cable"]["hysteresis"], "exit_compliance": own["exits"]["compliance"]}
        twin = twin.with_owner(accuracy=MachineAccuracy(creep=own["cable"]["creep"], **sizes))
    for table, key in (PARTS[part],) if part in PARTS else PARTS.values():
        own = getattr(twin.simulation, table).model_copy(update={key: SEVERITIES[severity][table][key]})
        twin = twin.with_simulation(**{table: own})
    return robot, twin


def creeping(robot: Robot) -> Robot:
    """The robot with the creep of `rough` in its file, under the mean tension in the middle of its frame."""
    scene = robot.scene
    middle = 0.5 * (np.array(scene.frame_min) + np.array(scene.frame_max))
    mean = float(inverse(robot, [*middle, 0.0, 0.0, 0.0]).tensions.mean())
    law = usual_creep(SEVERITIES["rough"]["cable"]["creep"] / mean)
    lines = (line.model_copy(update={"cable": line.cable.model_copy(update={"creep": law})}) for line in robot.lines)
    return robot.model_copy(update={"lines": tuple(lines)})


def watched(item: tuple[str, int, float]) -> Watched:
    """Print on the machine of a row and a seed, for so many seconds."""
    row, seed, seconds = item
    robot, settings = machine_of(row)
    options = PrintOptions("filter", layers=2, plant="quasi-static", period=PERIOD, seed=seed)
    twin = twin_of(robot, JOB, settings, options)
    machine, printer = begin_print(twin, plan_print(twin))
    alone = estimator("encoders", robot, machine.settings, twin.path.start_pose)
    attendant, out = attendant_of(machine, printer, options), Watched()
    for number in range(round(seconds / PERIOD)):
        step = printer.step(attendant.orders(printer, printer.time))
        estimates = dict(zip(ESTIMATORS, (step.estimate, alone.step(step.frame)), strict=True))
        for name, estimate in estimates.items() if number % EVERY == 0 else ():
            out.found[name].add(estimate, machine.truth.position)
        if attendant.is_over(printer):
            out.stopped = printer.supervisor.reason
            break
    return out


def main() -> None:
    """Print the table."""
    machines, seconds, first = int(sys.argv[1]), float(sys.argv[2]), int(sys.argv[3])
    rows = ROWS if len(sys.argv) < 5 or sys.argv[4] == "all" else tuple(sys.argv[4].split(","))
    jobs = [(row, first + k, seconds) for row in rows for k in range(machines)]
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        found = dict(zip(jobs, pool.map(watched, jobs), strict=True))
    print("| machines with | estimator | rms, most | sigma | positions in the 95 % ellipsoid | nees | stopped |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for row in rows:
        own = [each for job, each in found.items() if job[0] == row]
        stopped = sum(bool(each.stopped) for each in own)
        for name in ESTIMATORS:
            pooled = Found()
            for each in own:
                for key in vars(pooled):
                    getattr(pooled, key).extend(getattr(each.found[name], key))
            print(f"| {row} | {name} | {pooled.row()} | {stopped} |", flush=True)
        for each in own:
            if each.stopped:
                print("   ", each.stopped)


if __name__ == "__main__":
    main()
