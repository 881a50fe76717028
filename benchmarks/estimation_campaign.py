"""All estimators beside many simulated machines: errors, coverage, slack lines, radii; too long for the benchmarks.

`python -m benchmarks.estimation_campaign RUNS [SECONDS] [FIRST_SEED] [ROWS]` drives machines FIRST_SEED,
FIRST_SEED + 1, .. (from 1001 on: tests and settings have seen others) along random closed paths of 28 m at 3 cm/s, one
round (935 s) or as long as SECONDS, one machine on each core at a time, and prints a row for each and one for all. A
position counts from the third turn of both lidars on, ten a second: a machine's biases and its noise are in it, and
with many machines the law of the biases is. Coverage is the share of these within the 95 % ellipsoid of the estimate's
own covariance.

ROWS are names of `ROWS`, with commas, or ``all``: machines that deviate from their descriptions by one effect of a
severity, or by all, and an owner who knows the standard deviations alone; ``unmodelled`` are all effects that no owner
knows anything of, and ``surveyed`` all others. Without them the machines are ``ideal``. The errors of
a machine's survey and mounts last for its whole run, so that its positions are not independent: for the verdict each
of n machines counts by one position, its last. Their mean nees is expected within 3 +- 1.96 sqrt(6 / n), and the share
of them within their ellipsoids within 95 +- 1.96 sqrt(95 * 5 / n) %.

Radii of the winch drums count from ten seconds later on: all of them, and those that a coil's layer changed under in
the ten seconds to a moment before. What share of them the filter expects to be within 1 % is by its own covariance.
"""

from __future__ import annotations

import math
import os
import sys
from collections import deque
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from typing import Final, cast

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

from cablewright.estimation import encoders_only
from cablewright.estimation.started_filter import StartedState
from cablewright.foundation.choices import SeverityName
from cablewright.live.drive_along_path import DriveSettings, Pilot, random_loop
from cablewright.live.error_statistics import CHI2_95, SLACK
from cablewright.live.estimator_settings import OBSERVERS
from cablewright.live.estimators import reckoning_of
from cablewright.machine.powder_load import PowderLoad
from cablewright.machine.simulated.settings import TwinSettings, load_twin
from cablewright.machine.simulated.severities import with_severity
from cablewright.machine.simulated.severity_tables import PARTS
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.robot import load

Array = NDArray[np.float64]
UNMODELLED: Final = ("creep", "hysteresis", "exits", "sheaves", "gears", "wind")
GROUPS: Final = {"unmodelled": UNMODELLED, "surveyed": tuple(part for part in PARTS if part not in UNMODELLED)}
ROWS: Final = (
    "ideal",
    *(
        f"{part}-{severity}"
        for part in ("walls", "mounts", "clock", "zeros", "people", "gaps", *UNMODELLED, *GROUPS)
        for severity in ("typical", "rough")
    ),
    "typical",
    "rough",
)
ESTIMATORS: Final = ("encoders", *OBSERVERS)
LENGTH, SPEED = 28.0, 0.03  # m, m/s
COUNTS_FROM, LEARNT = 3.1, 13.1  # s
EVERY = 10  # steps
NEAR = 0.01  # of a radius
LATELY = 100  # of the steps that count: 10 s
HEAD = (
    f"{'seed':>15} {'estimator':<9} {'valid':>7} {'rms':>7} {'95 %':>7} {'most':>7}   {'coverage':>8} {'nees':>6} "
    f"{'slack named':>11} {'radii in 1 %':>12} {'expected':>8} {'new layer':>9} {'expected':>8}"
)


@dataclass
class Found:
    """What came of one run by one estimator, or of all."""

    errors: list[Array] = field(default_factory=list)
    nees: list[float] = field(default_factory=list)
    named: list[bool] = field(default_factory=list)
    radii: list[bool] = field(default_factory=list)  # within 1 %, all ...
    layers: list[bool] = field(default_factory=list)  # ... and those of which the coil's layer changed
    expected: list[float] = field(default_factory=list)
    expected_layers: list[float] = field(default_factory=list)
    valid: list[bool] = field(default_factory=list)

    def add(self, other: Found) -> None:
        """Take in another's."""
        for name in vars(self):
            getattr(self, name).extend(getattr(other, name))

    def row(self, seed: str, estimator: str) -> str:
        """One line of the table."""
        size = 1e3 * np.linalg.norm(np.array(self.errors).reshape(-1, 3), axis=1)
        if not len(size):
            return f"{seed:>15} {estimator:<9} never valid"
        told = np.array(self.nees)
        share = f"{100.0 * np.mean(told <= CHI2_95):6.1f} % {told.mean():6.2f}" if len(told) else f"{'-':>8} {'-':>6}"
        named, radii, layers = _share(self.named, 2, 11), _share(self.radii, 1, 12), _share(self.layers, 1, 9)
        return (
            f"{seed:>15} {estimator:<9} {100.0 * np.mean(self.valid):5.1f} % {np.sqrt((size**2).mean()):4.2f} mm "
            f"{np.percentile(size, 95):4.1f} mm {size.max():4.1f} mm  {share} {named} "
            f"{radii} {_share(self.expected, 1, 8)} {layers} {_share(self.expected_layers, 1, 8)}"
        )


def _share(values: list[bool] | list[float], digits: int, width: int) -> str:
    return f"{100.0 * float(np.mean(values)):{width - 2}.{digits}f} %" if values else f"{'-':>{width}}"


def twin_of(row: str) -> TwinSettings:
    """Return the machine of one of `ROWS`."""
    part, _, severity = row.rpartition("-")
    parts = GROUPS.get(part, (part,)) if part else tuple(PARTS)
    return with_severity(load_twin("merlet2023"), cast(SeverityName, severity), parts)


def run(seed: int, row: str, seconds: float) -> dict[str, Found]:
    """Drive the machine of *seed* and a *row* with all estimators beside it."""
    robot, settings = load("merlet2023"), twin_of(row)
    way = random_loop(robot, LENGTH, seed)
    machine = SimulatedMachine(robot, settings, [*way[0], 1.2], seed=seed)
    pilot = Pilot(machine, way, DriveSettings(), seed)
    beside = [(name, one.step, one.settings(robot, settings.owner, ())) for name, one in OBSERVERS.items()]
    states = {name: OBSERVERS[name].start(known) for name, _, known in beside}
    reckoning = reckoning_of(robot, settings.owner)
    beside.insert(0, ("encoders", encoders_only.step, reckoning))
    states["encoders"] = encoders_only.start(reckoning, np.array([*way[0], 1.2]))
    found = {name: Found() for name in ESTIMATORS}
    wound: deque[Array] = deque(maxlen=2 * LATELY + 1)  # radii that are true
    carrier, carried = settings.owner.carrier, PowderLoad.of(settings.owner.carrier)
    for step in range(round(seconds / machine.period)):
        command = pilot.command()
        frame, truth = machine.step(command), machine.truth
        carried.pour(command.valve, machine.period)
        if step % EVERY == 0:
            wound.append(truth.radii)
        for name, advance, known in beside:
            if name in OBSERVERS:
                OBSERVERS[name].weigh(known, states[name], carrier.full_mass - carried.gone)
            estimate, into = advance(known, states[name], frame), found[name]
            if step % EVERY or frame.time < COUNTS_FROM:
                continue
            into.valid.append(estimate.valid)
            if not estimate.valid:
                continue
            off = estimate.position - truth.position
            into.errors.append(off)
            if estimate.covariance is not None:
                into.nees.append(float(off @ np.linalg.solve(estimate.covariance[:3, :3], off)))
            loose = truth.excess > SLACK
            if loose.any():
                into.named.append(bool(estimate.slack[loose].all() and not estimate.slack[truth.excess <= 0.0].any()))
            if frame.time > LEARNT:
                changed = np.zeros(len(truth.radii), dtype=np.bool_)
                if len(wound) == wound.maxlen:
                    changed = np.abs(wound[LATELY] - wound[0]) > 0.5 * settings.owner.winch.pitch
                _judge_radii(into, states[name], estimate.radii / truth.radii - 1.0, changed)
    return found


def _judge_radii(into: Found, state: object, off: Array, changed: NDArray[np.bool_]) -> None:
    """Count radii that are *off* (m,) by little, and those whose layer *changed* (m,) lately."""
    near = np.abs(off) <= NEAR
    into.radii += near.tolist()
    into.layers += near[changed].tolist()
    if isinstance(state, StartedState) and state.chain is None:
        share = erf(NEAR / np.sqrt(2.0 * np.diag(state.filter.P)[state.filter.layout.radii]))
        into.expected += share.tolist()
        into.expected_layers += share[changed].tolist()


def main() -> None:
    """Print the table."""
    given = dict(enumerate(sys.argv[1:]))
    runs, seconds, first = int(given.get(0, 100)), float(given.get(1, LENGTH / SPEED)), int(given.get(2, 1001))
    named = given.get(3, "ideal")
    print(HEAD, flush=True)
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        for row in ROWS if named == "all" else named.split(","):
            _print_row(pool, row, range(first, first + runs), seconds)


def _print_row(pool: ProcessPoolExecutor, row: str, seeds: range, seconds: float) -> None:
    whole = {name: Found() for name in ESTIMATORS}
    nees: list[float] = []  # of each machine's last position, by the filter
    for seed, found_by in zip(seeds, pool.map(partial(run, row=row, seconds=seconds), seeds), strict=True):
        for name, found in found_by.items():
            print(found.row(str(seed), name), flush=True)
            whole[name].add(found)
        nees += found_by["filter"].nees[-1:]
    for name, found in whole.items():
        print(found.row(row, name))
    inside, n = 100.0 * float(np.mean(np.array(nees) <= CHI2_95)), len(nees)
    print(
        f"{row}: last positions of {n} machines: mean nees {np.mean(nees):.2f} (3 +- {1.96 * math.sqrt(6.0 / n):.2f}), "
        f"{inside:.1f} % within their ellipsoids (95 +- {1.96 * math.sqrt(475.0 / n):.1f} %)",
        flush=True,
    )


if __name__ == "__main__":
    main()
