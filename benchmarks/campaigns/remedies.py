"""Errors of a print by encoders alone, with and without remedies: a table that a builder can decide by.

    python -m benchmarks.campaigns.remedies house 10 3 50001        # layers, machines, first seed
    python -m benchmarks.campaigns.remedies exhibition 6 3 50001
    python -m benchmarks.campaigns.remedies house 10 3 50001 1 12 13    # these rows alone, counted from 1

Machines are drawn by seed, in steps of 1 s from equilibrium to equilibrium, at each severity. Printed are the mean over
the machines of the mean error in space while printing, the largest of all, and the mean error in height, mm.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import product
from multiprocessing import get_context
from pathlib import Path
from typing import Final

import numpy as np

from benchmarks.campaigns.camera_loop import FLAWS, camera_of
from cablewright.foundation.arrays import Array
from cablewright.live.prints.loop import run
from cablewright.live.prints.plan import MOST_IRREGULAR, PrintOptions, plan_print, twin_of
from cablewright.live.prints.run import begin_print
from cablewright.live.prints.simulated_operator import attendant_of
from cablewright.machine.sensors.tensions import TensionSensor
from cablewright.machine.simulated.settings import TwinSettings, load_twin
from cablewright.machine.simulated.severities import with_severity
from cablewright.machine.simulated.severity_tables import SEVERITIES
from cablewright.models.creep import usual_creep
from cablewright.printing.job import load_job
from cablewright.robot import Robot, load
from cablewright.solvers.inverse import inverse
from cablewright.studies.campaigns.true_errors import TrueErrors

EXAMPLES: Final = Path(__file__).resolve().parents[2] / "examples"
PRINTS: Final = {
    "house": ("house-printer", EXAMPLES / "house.toml"),
    "exhibition": ("merlet2023", EXAMPLES / "blind-machines.toml"),
}
EVERY: Final = {"house": 3600.0, "exhibition": 900.0}  # s between calibrations; of a print of an hour, a quarter of it
CAMERA: Final = {"house": (4.0, 3.0), "exhibition": (3.0, 1.5)}  # m before the frame, and high: it sees the whole part
STOPS: Final = 4
UNKNOWN: Final = 0.1  # of the compliance of mounts that were measured
UNEVEN: Final = 0.3  # difference of the creep of a line from that of the measured piece
PLACE_SIGMA: Final = 1e-3  # m
CELL_NOISE: Final = 2.0  # N, of a reading and of a zero; scales have errors by severity
MOST_SHOWN: Final = 1e4  # N


@dataclass(frozen=True)
class Remedy:
    """Measures of an owner: ``creep`` of a piece of cable and ``mounts`` measured, the place, tensions, lidars, camera.

    ``hourly``: the place measured at `STOPS` places each so often (`EVERY`), which together ``learn`` lengths.
    """

    name: str
    creep: bool = False
    mounts: bool = False
    place_layers: int = 0
    cells: bool = False
    lidars: tuple[str, ...] | None = None  # None: encoders alone
    hourly: bool = False
    learn: bool = False
    camera: bool = False


REMEDIES: Final = (
    Remedy("nothing"),
    Remedy("mounts measured to 10 %, in the robot file", mounts=True),
    Remedy("creep measured to 30 %, in the robot file", creep=True),
    Remedy("creep and mounts", creep=True, mounts=True),
    Remedy("place measured to 1 mm after each 3 layers", place_layers=3),
    Remedy("place measured to 1 mm after each layer", place_layers=1),
    Remedy("the same with load cells", place_layers=1, cells=True),
    Remedy("creep and mounts, and the place after each layer", creep=True, mounts=True, place_layers=1),
    Remedy("all of these, with load cells", creep=True, mounts=True, place_layers=1, cells=True),
    Remedy("one lidar (the paper's chain, north and the vertical one)", lidars=("north", "vertical")),
    Remedy("all three lidars (the paper's chain)", lidars=("north", "south", "vertical")),
    Remedy("place measured to 1 mm at 4 places each hour, each corrects by itself", hourly=True),
    Remedy("recalibrated each hour at 4 places", hourly=True, learn=True),
    Remedy(
        "creep and mounts, and recalibrated each hour at 4 places", creep=True, mounts=True, hourly=True, learn=True
    ),
    Remedy("a camera in the room, a picture each second (filter)", camera=True),
)


def creeping(robot: Robot, twin: TwinSettings, begin: Array) -> tuple[Robot, TwinSettings]:
    """The robot with the creep of the least line in its file, and the machine with what is more, as before in all."""
    cable = twin.simulation.cable
    least = (1.0 - UNEVEN) * cable.creep / float(inverse(robot, begin).tensions.mean())
    law = usual_creep(least)
    lines = (line.model_copy(update={"cable": line.cable.model_copy(update={"creep": law})}) for line in robot.lines)
    more = cable.model_copy(update={"creep": UNEVEN * cable.creep, "creep_spread": 1.0 - 1e-9})
    return robot.model_copy(update={"lines": tuple(lines)}), twin.with_simulation(cable=more)


def machine_of(name: str, severity: str, remedy: Remedy) -> tuple[Robot, TwinSettings]:
    """The robot as its owner describes it, and the machine."""
    robot, twin = load(name), with_severity(load_twin(name), severity)
    exits = twin.simulation.exits
    if remedy.mounts and isinstance(exits.compliance, float):
        told = (1.0 - UNKNOWN) * exits.compliance
        lines = tuple(line.model_copy(update={"exit_compliance": told}) for line in robot.lines)
        robot = robot.model_copy(update={"lines": lines})
        twin = twin.with_simulation(exits=exits.model_copy(update={"compliance": UNKNOWN * exits.compliance}))
    if remedy.cells:
        gain = twin.simulation.tolerances.tension_gain
        cells = TensionSensor(rate=1.0, deviation=CELL_NOISE, bias=CELL_NOISE, gain_deviation=gain, most=MOST_SHOWN)
        twin = twin.with_owner(load_cells=cells)
    if remedy.camera:
        which = next(key for key, (robot_name, _) in PRINTS.items() if robot_name == name)
        seen, (away, high) = camera_of(which, robot), CAMERA[which]
        low = {
            "rate": 1.0,
            "at": (seen.at[0], robot.scene.frame_min[1] - away, high),
            "looks": (0.0, 1.0, -0.1),
        }
        twin = twin.with_owner(camera=seen.model_copy(update=low), lidars={}).with_simulation(camera=FLAWS)
    if remedy.lidars is not None:
        kept = {key: lidar for key, lidar in twin.owner.lidars.items() if key in remedy.lidars}
        twin = twin.with_owner(lidars=kept)
    return robot, twin


def printed(item: tuple[str, str, Remedy, int, int]) -> tuple[float, float, float]:
    """Mean and largest error in space and mean height error, m, of one print; NaN where the machine stops."""
    which, severity, remedy, layers, seed = item
    name, job = PRINTS[which]
    robot, settings = machine_of(name, severity, remedy)
    options = PrintOptions(
        estimator="filter" if remedy.camera else "encoders" if remedy.lidars is None else "paper",
        height=None if remedy.lidars is not None else "job",
        layers=layers,
        plant="quasi-static",
        seed=seed,
        place_layers=remedy.place_layers,
        place_sigma=PLACE_SIGMA,
        place_tensions=remedy.cells,
        place_every=EVERY[which] if remedy.hourly else 0.0,
        place_stops=STOPS if remedy.hourly else 1,
        place_learn=remedy.learn,
    )
    twin = twin_of(robot, load_job(job), settings, options)
    if remedy.creep and settings.simulation.cable.creep:
        robot, settings = creeping(robot, settings, twin.path.start_pose)
        twin = twin_of(robot, load_job(job), settings, options)
    machine, printer = begin_print(twin, plan_print(twin))
    errors = TrueErrors(twin, machine)
    run(printer, attendant_of(machine, printer, options), errors)
    if not printer.finished:
        return np.nan, np.nan, np.nan
    found = errors.path.result()
    return found.space.mean, found.space.max, found.height.mean


def items(
    which: str, layers: int, machines: int, seed: int, rows: Sequence[int]
) -> Iterator[tuple[str, str, Remedy, int, int]]:
    """Each remedy, or those of some *rows* from 1 on, at each severity on each machine that has or allows it."""
    owner = load_twin(PRINTS[which][0]).owner
    regular = owner.winch.radius_deviation <= MOST_IRREGULAR
    chosen = REMEDIES if not rows else [REMEDIES[row - 1] for row in rows]
    remedies = [each for each in chosen if (each.lidars is None or owner.lidars) and (regular or not each.learn)]
    for remedy, severity in product(remedies, SEVERITIES):
        for number in range(machines):
            yield which, severity, remedy, layers, seed + number


def main() -> None:
    """Print the table."""
    which, (layers, machines, seed, *rows) = sys.argv[1], map(int, sys.argv[2:])
    jobs = list(items(which, layers, machines, seed, rows))
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        found = list(pool.map(printed, jobs))
    print(f"| {which}, {layers} layers, {machines} machines | {' | '.join(SEVERITIES)} |")
    print("| --- |" + " --- |" * len(SEVERITIES))
    errors = dict(zip(jobs, found, strict=True))
    for remedy in dict.fromkeys(job[2] for job in jobs):
        cells = []
        for severity in SEVERITIES:
            own = [each for job, each in errors.items() if job[1:3] == (severity, remedy)]
            mean, most, height = 1e3 * np.array(own).T
            cells.append(f"{mean.mean():.1f}, {most.max():.1f}; {height.mean():+.1f}")
        print(f"| {remedy.name} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
