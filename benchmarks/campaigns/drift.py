"""How often a check of a calibrated robot says that something moved, where nothing did, and where something did.

`python -m benchmarks.campaigns.drift [MACHINES] [SEED]`: each machine is calibrated by 40 poses of 0.1 mm, then
checked by 8 others, at a false alarm of 1 % (the default): nothing moved; a line slipped; an exit point moved; all
lengths are longer; a single reading is wrong. Then machines of `calibration_campaign`, whose model is wrong: nothing
moved. Shares come with their 95 % interval (Clopper and Pearson).
"""

from __future__ import annotations

import sys
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from benchmarks.calibration import WANG
from benchmarks.calibration_campaign import drawn
from benchmarks.timing import interval
from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.drift.drift import Drift, check_drift
from cablewright.calibration.drift.record import CalibrationRecord, record_of
from cablewright.calibration.measurements import Measured, write_measured
from cablewright.calibration.plan import CalibrationPlan, Point
from cablewright.calibration.poses.simulation import measure, random_poses
from cablewright.robot import Robot, load

Array = NDArray[np.float64]
NOISE = 1e-4  # m
LATER = 8  # poses of a check
SLIPS = (1e-3, 2e-3, 5e-3)  # m


def part(measured: Measured, rows: slice) -> Measured:
    """Some of the rows."""
    fields = ("counted", "guess", "pose_sigma", "tensions")
    return replace(
        measured, **{name: None if (all_rows := getattr(measured, name)) is None else all_rows[rows] for name in fields}
    )


def recorded(robot: Robot, measured: Measured, plan: CalibrationPlan | None) -> tuple[Robot, CalibrationRecord] | None:
    """The calibrated robot and its record; None where the verdict is bad."""
    found = calibrate(robot, measured, plan, need=0.05)
    if found.verdict == "bad":
        return None
    with TemporaryDirectory() as folder:
        file = Path(folder, "d.csv")
        file.write_text(write_measured(measured, robot))
        return found.robot, record_of(found, file, datetime.now(UTC))


def surveyed(robot: Robot, rng: np.random.Generator) -> CalibrationPlan:
    """Three exit points surveyed to a millimetre."""
    places = [(line.name, np.array(line.exit_point) + rng.normal(0.0, 1e-3, 3)) for line in robot.lines[:3]]
    return CalibrationPlan(points=tuple(Point(line=name, at=tuple(at.tolist())) for name, at in places))


def main(count: int, seed: int) -> None:
    """Print the shares."""
    for name, robot, planned in (
        ("wang2021, encoders alone", WANG, False),
        ("wang2021, three points surveyed", WANG, True),
        ("cogiro, three points surveyed", load("cogiro"), True),
    ):
        told: dict[str, list[bool]] = {}
        sizes: list[float] = []
        for each in range(seed, seed + count):
            _one(robot, planned, np.random.default_rng(each), told, sizes)
        print(f"{name}; a slip is found from {1e3 * float(np.median(sizes)):.2g} mm (median of lines and machines)")
        for case, right in told.items():
            print(f"    {case:<58} {interval(sum(right), len(right))}", flush=True)
    _of_wrong_models(count, seed)


def _one(
    robot: Robot, planned: bool, rng: np.random.Generator, told: dict[str, list[bool]], sizes: list[float]
) -> None:
    made = measure(robot, random_poses(robot, 40 + LATER, rng), NOISE, rng).measured
    known = recorded(robot, part(made, slice(40)), surveyed(robot, rng) if planned else None)
    if known is None:
        return
    later, m = part(made, slice(40, None)), robot.m

    def check(off: Array | float) -> Drift:
        return check_drift(known[0], replace(later, counted=later.counted + off), known[1])

    def say(case: str, right: bool) -> None:
        told.setdefault(case, []).append(right)

    nothing = check(0.0)
    sizes.append(float(np.median([line.detectable for line in nothing.lines])))
    say("nothing moved: an alarm", nothing.verdict != "unchanged")
    line = int(rng.integers(m))
    for by in SLIPS:
        found = check(by * np.eye(m)[line])
        say(f"a line slipped by {1e3 * by:g} mm: an alarm", found.verdict == "moved")
        if found.verdict == "moved":
            say("    of these: only that line, or it is one of those named", _names(found, robot.lines[line].name))
            own = [one for one in found.changes if (one.line, one.what) == (robot.lines[line].name, "length")]
            say("    of these: its length, and no exit point", bool(own))
            if own:
                say(
                    "        of these: by the true amount within 3 sigma", abs(own[0].amount + by) <= 3.0 * own[0].sigma
                )
    found = check(1e-3 * later.counted)
    say("all lengths 0.1 % longer than counted: an alarm", found.verdict == "moved")
    bad = np.zeros_like(later.counted)
    bad[rng.integers(LATER), line] = 0.02
    say("one reading off by 20 mm: it is named", check(bad).verdict == "wrong-reading")


def _names(found: Drift, line: str) -> bool:
    """Whether what was found is of that line alone, or says that it may be."""
    return all(one.line == line or any(f"of {line}" in each for each in one.instead) for one in found.changes)


def _of_wrong_models(count: int, seed: int) -> None:
    alarms = []
    for each in range(seed, seed + count):
        machine = drawn(each)
        if machine.effects & {"exchanged", "gross"}:
            continue
        rows = len(machine.measured.counted) - LATER
        known = recorded(machine.file, part(machine.measured, slice(rows)), machine.plan)
        if known is not None:
            alarms.append(
                check_drift(known[0], part(machine.measured, slice(rows, None)), known[1]).verdict != "unchanged"
            )
    print("machines of the campaign, whose model is wrong, nothing moved: an alarm", interval(sum(alarms), len(alarms)))


if __name__ == "__main__":
    given = [int(each) for each in sys.argv[1:]] + [100, 500][len(sys.argv) - 1 :]
    main(*given)
