"""Coverage of the filters on machines of which their settings state nothing, or too little.

    python -m benchmarks.campaigns.untold 20 60 90001             # machines, seconds, first seed
    python -m benchmarks.campaigns.untold 20 60 90001 walls,room  # of some of `ROWS`

The point filter runs beside `merlet2023` on a random path, the body filter while `cogiro` prints the house. Owners
state `ideal` for all rows but ``stated`` and ``walls``, so that nothing of the deviation is in the filter's settings:

* rough: all effects that no model has, at `rough`;
* modulus: cables with 30 % less stiffness; payload: a platform with 2 kg more;
* stated: errors of the survey of walls, 2 mm, as stated; walls: twice as large as stated; room: each wall twice as far
  from the origin as stated. Point filter alone, as the body has no lidars;
* ``body-``: creep, hysteresis and mounts by the rows of `benchmarks.campaigns.body_stretch`, in ``told-rough`` stated.

A position counts once a second from the fourth second on, while the estimate is valid. Coverage is the share of these
within the 95 % ellipsoid. Noticed: machines with a fault of room or lidars, or an estimate that is not valid, from 4 s
to 60 s, and the median time.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from multiprocessing import get_context
from typing import Final

import numpy as np

from benchmarks.campaigns.body_stretch import EVERY, JOB, PERIOD, machine_of
from benchmarks.estimation_campaign import LENGTH, UNMODELLED
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Estimate
from cablewright.live.drive_along_path import DriveSettings, Pilot, random_loop
from cablewright.live.error_statistics import CHI2_95
from cablewright.live.estimator_settings import OBSERVERS
from cablewright.live.prints.plan import PrintOptions, Upon, plan_print, twin_of
from cablewright.live.prints.run import begin_print
from cablewright.live.prints.simulated_operator import attendant_of
from cablewright.machine.powder_load import PowderLoad
from cablewright.machine.settings import MachineSettings
from cablewright.machine.simulated.settings import load_twin
from cablewright.machine.simulated.severities import with_severity
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.robot import Robot, load

OF_BODIES: Final = ("none", "typical", "rough", "exits-rough", "creep-rough", "told-rough", "modulus", "payload")
ROWS: Final = ("rough", "modulus", "payload", "stated", "walls", "room", *(f"body-{row}" for row in OF_BODIES))
LESS, MORE = 0.7, 2.0  # of the stiffness, kg
FROM, NOTICED = 4.0, 60.0  # s


@dataclass
class Watched:
    """Positions of one machine: errors, m, and nees of valid ones; when something was noticed, s."""

    errors: list[float] = field(default_factory=list)
    nees: list[float] = field(default_factory=list)
    valid: list[bool] = field(default_factory=list)
    noticed: float = np.inf

    def add(self, estimate: Estimate, position: Array, counts: bool) -> None:
        """Add an estimate; *counts*: whether its position does."""
        own = any(each.source in ("room", "north", "south") for each in estimate.faults)
        if estimate.time > FROM and (own or not estimate.valid):
            self.noticed = min(self.noticed, estimate.time)
        if not counts or estimate.time < FROM:
            return
        self.valid.append(estimate.valid)
        if estimate.valid and estimate.covariance is not None:
            off = estimate.position - position
            self.errors.append(float(np.linalg.norm(off)))
            self.nees.append(float(off @ np.linalg.solve(estimate.covariance[:3, :3], off)))


def changed(robot: Robot, row: str) -> Robot:
    """Return the robot with what a *row* changes of it."""
    if row == "payload":
        mass = {"mass": robot.platform.mass + MORE}
        return robot.model_copy(update={"platform": robot.platform.model_copy(update=mass)})
    if row != "modulus":
        return robot
    lines = []
    for line in robot.lines:
        keys = ("young_modulus", "axial_stiffness")
        softer = {key: LESS * value for key in keys if (value := getattr(line.cable, key)) is not None}
        lines.append(line.model_copy(update={"cable": line.cable.model_copy(update=softer)}))
    return robot.model_copy(update={"lines": tuple(lines)})


def far_room(owner: MachineSettings) -> MachineSettings:
    """Return an owner who states each wall at half of its true distance from the origin."""
    halved = []
    for wall in owner.room.walls:
        ends = {name: tuple(0.5 * x for x in getattr(wall, name)) for name in ("start", "end")}
        halved.append(wall.model_copy(update=ends))
    return owner.model_copy(update={"room": owner.room.model_copy(update={"walls": tuple(halved)})})


def of_point(row: str, seed: int, seconds: float) -> Watched:
    """Drive the machine of *seed* with the filter beside it."""
    robot, settings = load("merlet2023"), with_severity(load_twin("merlet2023"), "ideal")
    if row == "rough":
        settings = with_severity(settings, "rough", UNMODELLED)
    if row in ("stated", "walls"):
        settings = with_severity(settings, "rough", ("walls",))
        own = settings.simulation.tolerances
        wall = {"wall": (2.0 if row == "walls" else 1.0) * own.wall}
        settings = settings.with_simulation(tolerances=own.model_copy(update=wall))
    owner = far_room(settings.owner) if row == "room" else settings.owner
    path, one = random_loop(robot, LENGTH, seed), OBSERVERS["filter"]
    machine = SimulatedMachine(changed(robot, row), settings, [*path[0], 1.2], seed=seed)
    pilot, known = Pilot(machine, path, DriveSettings(), seed), one.settings(robot, owner, ())
    state, found, carried = one.start(known), Watched(), PowderLoad.of(owner.carrier)
    for number in range(round(seconds / machine.period)):
        command = pilot.command()
        frame = machine.step(command)
        carried.pour(command.valve, machine.period)
        one.weigh(known, state, owner.carrier.full_mass - carried.gone)
        counts = number % round(1.0 / machine.period) == 0
        found.add(one.step(known, state, frame), machine.truth.position, counts)
    return found


def of_body(row: str, seed: int, seconds: float) -> Watched:
    """Print on the machine of *seed*, from equilibrium to equilibrium."""
    robot, settings = machine_of("none" if row in ("modulus", "payload") else row)
    options = PrintOptions("filter", layers=2, plant="quasi-static", period=PERIOD, seed=seed)
    twin = twin_of(robot, JOB, settings, options)
    upon = Upon(changed(robot, row), None, {})
    machine, printer = begin_print(replace(twin, upon=upon), plan_print(twin))
    attendant, found = attendant_of(machine, printer, options), Watched()
    for number in range(round(seconds / PERIOD)):
        step = printer.step(attendant.orders(printer, printer.time))
        found.add(step.estimate, machine.truth.position, number % EVERY == 0)
        if attendant.is_over(printer):
            break
    return found


def watched(row: str, seconds: float, seed: int) -> Watched:
    """Return what came of one machine of a row."""
    way: Callable[[str, int, float], Watched] = of_body if row.startswith("body-") else of_point
    return way(row.removeprefix("body-"), seed, seconds)


def main() -> None:
    """Print the table."""
    machines, seconds, first = int(sys.argv[1]), float(sys.argv[2]), int(sys.argv[3])
    rows = ROWS if len(sys.argv) < 5 else tuple(sys.argv[4].split(","))
    print("| machines with | valid | rms, most, mm | in the 95 % ellipsoid | nees | noticed, median time |")
    print("| --- | --- | --- | --- | --- | --- |")
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        for row in rows:
            found = list(pool.map(partial(watched, row, seconds), range(first, first + machines)))
            size = 1e3 * np.concatenate([each.errors for each in found])
            nees = np.concatenate([each.nees for each in found])
            noticed = np.array([each.noticed for each in found])
            own = f"{np.sqrt((size**2).mean()):.2f}, {size.max():.1f}" if len(size) else "-"
            share = f"{100.0 * np.mean(nees <= CHI2_95):.1f} %" if len(nees) else "-"
            mean = f"{nees.mean():.2f}" if len(nees) else "-"
            valid = 100.0 * np.mean(np.concatenate([each.valid for each in found]))
            seen = noticed[noticed <= NOTICED]
            when = f", {np.median(seen):.1f} s" if len(seen) else ""
            print(
                f"| {row}, {machines} | {valid:.1f} % | {own} | {share} | {mean} | {len(seen)}{when} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
