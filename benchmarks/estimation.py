"""The paper's estimation on simulated machines: time of a step, and how near it comes to the truth.

Machines are drawn by seed, nothing is tuned to one. Of each step's time the best of a few runs on the same frames.
Three lidar scans are half a million multiplications and 50 kB, a tenth of a millisecond's work: what they take beyond
is some hundred array operations on 720 rays or less, each about a microsecond before it begins.
`python -m benchmarks.estimation` prints a table of docs/estimation.md: the estimator without its steps beyond the
paper.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.estimation_campaign import Found as Campaign
from benchmarks.estimation_campaign import run as beside
from benchmarks.timing import Row, best
from cablewright.estimation.merlet2023 import observer
from cablewright.estimation.merlet2023.observer import ObserverSettings
from cablewright.foundation.signals import Scan, SensorFrame, Truth
from cablewright.live.drive_along_path import DriveSettings, Pilot, random_loop
from cablewright.live.error_statistics import CHI2_95
from cablewright.live.estimator_settings import OBSERVERS, observer_settings
from cablewright.machine.files import load_machine
from cablewright.machine.simulated.settings import TwinSettings, load_twin
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.continuation import Tracker, TrackerSettings
from cablewright.solvers.inverse import solve_inverse

Array = NDArray[np.float64]
THREE_SCANS = 3.2  # s
SLACK = 5e-3  # m
LEARNT = 13.0  # s: ten after the third scan
LEFT_OUT = ("nothing", "filter of radii", "odometry in a turn", "lowest points' lift", "all three")
TOLD, TOLD_SEED = 120.0, 7  # s; of the drive in the docs


@dataclass(frozen=True)
class Size:
    """How much is measured. Times in s."""

    still: range = range(20)  # seeds of machines that are held ...
    held: float = 6.0  # ... so long
    drives: range = range(1, 6)  # seeds of machines that are driven ...
    driven: float = 60.0  # ... so long
    timed: float = 20.0  # of the drive in the docs ...
    repeats: int = 7  # ... so often


FULL, QUICK = Size(), Size(range(1), 3.3, range(5, 6), 13.5, 1.5, 1)


@dataclass
class Found:
    """What came of some runs."""

    level: list[float] = field(default_factory=list)
    space: list[float] = field(default_factory=list)
    named: list[bool] = field(default_factory=list)
    radii: list[Array] = field(default_factory=list)


def rows(size: Size) -> Iterator[Row]:
    """All rows of this file."""
    settings = load_twin("merlet2023")
    still, moving = Found(), Found()
    lidars = settings.owner.lidars.items()
    unbiased = settings.with_owner(lidars={name: lidar.model_copy(update={"bias": 0.0}) for name, lidar in lidars})
    for seed in size.still:
        run(unbiased, seed, size.held, still, held=True)
    for seed in size.drives:
        run(settings, seed, size.driven, moving, held=False)
    (times, turned), alone = step_times("paper", size), solve_time()
    turns = 1e3 * float((times[turned] - np.median(times[~turned])).sum()) / size.timed
    mean, p99 = 1e6 * float(times.mean()), 1e3 * float(np.percentile(times, 99))
    yield Row("estimation: a step of 10 ms, mean", mean, "us", "<= 300 us", mean <= 300.0)
    yield Row("estimation: the forward solve of a step, alone", 1e6 * alone, "us")
    yield Row("estimation: a step, 99 of 100", p99, "ms", "<= 2 ms", p99 <= 2.0)
    yield Row("estimation: three lidar turns, in a second", turns, "ms", "<= 3 ms", turns <= 3.0)
    near = 100.0 * float(np.mean(np.array(still.level) <= 2e-3))
    yield Row("estimation: static, from above within 2 mm, no bias", near, "%", ">= 95 %", near >= 95.0)
    near = 100.0 * float(np.mean(np.array(still.space) <= 2e-3))
    yield Row("estimation: static, in space within 2 mm, no bias", near, "%")
    largest = 1e3 * max(moving.space)
    yield Row("estimation: moving, most", largest, "mm", "<= 20 mm", largest <= 20.0)
    yield Row("estimation: moving, rms", 1e3 * float(np.sqrt(np.mean(np.square(moving.space)))), "mm")
    rightly = 100.0 * float(np.mean(moving.named))
    yield Row("estimation: slack lines over 5 mm named rightly", rightly, "%", ">= 98 %", rightly >= 98.0)
    within = 100.0 * float(np.mean(np.abs(moving.radii) <= 0.01))
    yield Row("estimation: radii within 1 %, from 10 s on", within, "%", "100 %", within >= 99.5)
    yield from filter_rows(size)


def filter_rows(size: Size) -> Iterator[Row]:
    """Rows of the filter, on the same drives."""
    found = Campaign()
    for seed in size.drives:
        found.add(beside(seed, "ideal", size.driven)["filter"])
    times, _ = step_times("filter", size)
    mean, p99 = 1e6 * float(times.mean()), 1e3 * float(np.percentile(times, 99))
    yield Row("estimation: filter, a step of 10 ms, mean", mean, "us", "<= 200 us", mean <= 200.0)
    yield Row("estimation: filter, a step, 99 of 100", p99, "ms", "<= 2 ms", p99 <= 2.0)
    off = 1e3 * np.linalg.norm(np.array(found.errors), axis=1)
    rms, largest = float(np.sqrt((off**2).mean())), float(off.max())
    yield Row("estimation: filter, moving, rms", rms, "mm", "<= 5 mm", rms <= 5.0)
    yield Row("estimation: filter, moving, most", largest, "mm", "<= 15 mm", largest <= 15.0)
    share = 100.0 * float(np.mean(np.array(found.nees) <= CHI2_95))
    yield Row("estimation: filter, within the 95 % ellipsoid", share, "%", "93 to 97 %", 93.0 <= share <= 97.0)
    named = 100.0 * float(np.mean(found.named))
    yield Row("estimation: filter, slack lines named rightly", named, "%", ">= 98 %", named >= 98.0)
    radii = 100.0 * float(np.mean(found.radii))
    yield Row("estimation: filter, radii within 1 %", radii, "%", "100 %", radii >= 99.5)


def run(settings: TwinSettings, seed: int, seconds: float, found: Found, *, held: bool) -> None:
    """One machine by *seed*, driven round a path or *held* where it begins, with the estimation beside."""
    robot = load("merlet2023")
    way = random_loop(robot, 28.0, seed)
    machine = SimulatedMachine(robot, settings, [*way[0], 1.2], seed=seed)
    pilot = Pilot(machine, None if held else way, DriveSettings(), seed)
    known = observer_settings(robot, settings.owner)
    state = observer.start(known)
    for _ in range(round(seconds / machine.period)):
        frame = machine.step(pilot.command())
        estimate = observer.step(known, state, frame)
        if frame.time < THREE_SCANS:
            continue
        truth = machine.truth
        off = estimate.position - truth.position
        found.level.append(float(np.hypot(*off[:2])))
        found.space.append(float(np.sqrt(off @ off)))
        slack, excess = estimate.slack, truth.excess
        if (excess > SLACK).any():
            found.named.append(bool(slack[excess > SLACK].all() and not slack[excess <= 0.0].any()))
        if frame.time > LEARNT:
            found.radii.append(estimate.radii / truth.radii - 1.0)


def step_times(estimator: str, size: Size) -> tuple[Array, NDArray[np.bool_]]:
    """Time of each step of a drive, s, the shortest of some runs; and which have to do with a lidar's turn."""
    one = OBSERVERS[estimator]
    drive, known = told(size.timed), one.settings(load("merlet2023"), load_machine("merlet2023"), ())
    runs, turned = [], np.zeros(len(drive), np.bool_)
    for _ in range(size.repeats):
        state, times = one.start(known), []
        for k, (frame, _) in enumerate(drive):
            waits = estimator == "paper" and (bool(state.turns.pending) or state.turns.extracted is not None)
            turned[k] = waits or any(isinstance(reading, Scan) for reading in frame.readings)
            begin = time.perf_counter()
            one.step(known, state, frame)
            times.append(time.perf_counter() - begin)
        runs.append(times)
    return np.asarray(np.min(runs, axis=0)), turned


def solve_time() -> float:
    """Time of one forward solve between lengths that a step apart, s."""
    model = Model(load("merlet2023"))
    lengths = solve_inverse(model, (0.3, -1.0, 1.2)).checked().lengths
    tracker, there = Tracker(model, lengths, TrackerSettings(certify=False)), lengths + 2e-4

    def to_and_fro() -> None:
        tracker.step(there)
        tracker.step(lengths)

    return best(to_and_fro, 200) / 2.0


def less(known: ObserverSettings, what: str) -> ObserverSettings:
    """The settings with steps beyond the paper left out."""
    if what in ("filter of radii", "all three"):
        known = replace(known, radius=replace(known.radius, rule="paper"))
    if what in ("odometry in a turn", "all three"):
        known = replace(known, deskew=False)
    if what in ("lowest points' lift", "all three") and known.height is not None:
        known = replace(known, height=replace(known.height, sigma=0.0))
    return known


def told(seconds: float) -> list[tuple[SensorFrame, Truth]]:
    """Frames and truths of the drive in the docs, so long."""
    robot, settings = load("merlet2023"), load_twin("merlet2023")
    way = random_loop(robot, 28.0, TOLD_SEED)
    machine = SimulatedMachine(robot, settings, [*way[0], 1.2], seed=TOLD_SEED)
    pilot = Pilot(machine, way, DriveSettings(), TOLD_SEED)
    return [(machine.step(pilot.command()), machine.truth) for _ in range(round(seconds / machine.period))]


def main() -> None:
    """Print the table."""
    drive = told(TOLD)
    print(f"{'left out':<22} {'from above, rms':>16} {'most':>9} {'height, rms':>12} {'radii, rms':>11}")
    for what in LEFT_OUT:
        known = less(observer_settings(load("merlet2023"), load_machine("merlet2023")), what)
        state, off, radii = observer.start(known), [], []
        for frame, truth in drive:
            estimate = observer.step(known, state, frame)
            if frame.time > THREE_SCANS:
                off.append(estimate.position - truth.position)
            if frame.time > LEARNT:
                radii.append(estimate.radii / truth.radii - 1.0)
        level, height = np.hypot(*np.array(off).T[:2]), np.array(off)[:, 2]
        rms = [1e3 * float(np.sqrt((each**2).mean())) for each in (level, height)]
        radius = 100.0 * float(np.sqrt((np.array(radii) ** 2).mean()))
        print(f"{what:<22} {rms[0]:13.1f} mm {1e3 * level.max():6.1f} mm {rms[1]:9.1f} mm {radius:9.2f} %")


if __name__ == "__main__":
    sys.exit(main())
