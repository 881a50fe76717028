"""Snapshots and logs of the simulated machine: what it takes not to lose anything; one thread."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from statistics import median, quantiles
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.machine import speed
from benchmarks.timing import Row, best, medians
from cablewright.foundation.file_output import write_whole
from cablewright.foundation.saved_state import read_snapshots, write_snapshots
from cablewright.foundation.signals import Command, Scan, SensorFrame, Truth
from cablewright.machine.log.head import LogHead
from cablewright.machine.log.log import read_log, write_log
from cablewright.machine.simulated.settings import TwinSettings, load_twin
from cablewright.machine.simulated.simulated_machine import PlantName, SimulatedMachine
from cablewright.robot import load

Step = tuple[SensorFrame, Command, Truth]
START = (0.3, -1.0, 1.2)
SWAY = np.array([0.3, 0.3, -0.3, -0.3])  # rad/s of the drums, there and back
PERIOD = 1.0  # s, of a quasi-static campaign
WANTED = 880.0  # steps of it a second: 132 000 in 150 s


@dataclass(frozen=True)
class Size:
    """How much is measured."""

    campaign: int = 600  # steps of PERIOD
    laid: int = 400  # steps of the house printer
    written: int = 60  # snapshots
    logged: int = 6000  # steps of 10 ms


FULL, QUICK = Size(), Size(5, 5, 3, 50)


def rows(size: Size) -> Iterator[Row]:
    """All rows of this file."""
    full = load_twin("merlet2023")
    slow = full.with_simulation(quasi_static_period=PERIOD)
    rate = speed(slow, "quasi-static", size.campaign * PERIOD) / PERIOD
    name = "merlet2023: quasi-static plant of 1 s, all sensors"
    yield Row(name, rate, "steps/s", f">= {WANTED:.0f}", rate >= WANTED)
    ratio = house_speed(size.laid)
    yield Row("house-printer: dynamic plant, laying, all sensors", ratio, "x real", ">= 20", ratio >= 20.0)
    with TemporaryDirectory() as folder:
        yield from snapshots(full, size.written, Path(folder))
        yield from logs("10 ms", full, "dynamic", size.logged, Path(folder))
        yield from logs("1 s", slow, "quasi-static", size.campaign, Path(folder))


def command(machine: SimulatedMachine) -> Command:
    """There and back, laying."""
    return Command(machine.time, SWAY * np.cos(0.03 * machine.time), 1.0)


def house_speed(steps: int) -> float:
    """Times real time of a printer for houses that lays a strand to and fro."""
    machine = SimulatedMachine(load("house-printer"), load_twin("house-printer"), (0.0, 0.0, 0.5), seed=1)

    def go() -> None:
        for _ in range(steps):
            machine.step(Command(machine.time, 5.0 * SWAY * np.cos(0.5 * machine.time), 1.0))

    return steps * machine.period / best(go)


def snapshots(settings: TwinSettings, count: int, folder: Path) -> Iterator[Row]:
    """A snapshot after a layer is on the floor: taken, written, taken up; beside writing the same bytes alone."""
    robot, path = load("merlet2023"), folder / "state"
    machine = SimulatedMachine(robot, settings, START, seed=1)
    machine.rig.ground.heights[:] = np.random.default_rng(1).random(machine.rig.ground.heights.shape)
    for _ in range(150):
        machine.step(command(machine))

    def keep() -> None:
        write_snapshots(path, {"machine": machine.snapshot()})

    def write_alone() -> None:
        write_whole(folder / "alone", data)

    def take_up() -> None:
        SimulatedMachine.resumed(robot, settings, read_snapshots(path)["machine"], seed=1)

    keep()
    data = path.read_bytes()
    took, alone = medians([keep, write_alone], count)
    name = f"snapshot of merlet2023, {len(data) / 1e6:.1f} MB: taken and on the disk"
    yield Row(name, 1e3 * took, "ms", "<= 5", took <= 5e-3, "those bytes alone", took / alone)
    yield Row("snapshot of merlet2023: read and taken up", 1e3 * medians([take_up], count // 3)[0], "ms")


def logs(what: str, settings: TwinSettings, plant: PlantName, count: int, folder: Path) -> Iterator[Row]:
    """Steps written with and without flushing each half second, and read with and without scans and truth."""
    robot, path = load("merlet2023"), folder / "log.mcap"
    machine = SimulatedMachine(robot, settings, START, seed=1, plant=plant)
    steps: list[Step] = []
    for _ in range(count):
        told = command(machine)
        steps.append((machine.step(told), told, machine.truth))
    simulation = settings.simulation
    head = LogHead(robot, settings.owner, machine.period, simulation=simulation, plant=plant, seed=1)
    by_size, each = write(path, head, steps, None), write(path, head, steps, 0.5)
    mean, late = sum(each) / count, quantiles(each, n=100)[-1]
    yield Row(
        f"log: a step of {what} written", 1e6 * mean, "us", peer="in chunks by size", ratio=mean * count / sum(by_size)
    )
    yield Row(f"log: a step of {what} written, 99 of 100", 1e6 * late, "us")
    whole, bare = medians([partial(read, path, ()), partial(read, path, (Scan, Truth))], 3)
    yield Row(f"log: a step of {what} read", 1e6 * whole / count, "us")
    yield Row(
        f"log: a step of {what} read without scans and truth",
        1e6 * bare / count,
        "us",
        peer="whole",
        ratio=bare / whole,
    )


def write(path: Path, head: LogHead, steps: list[Step], flush_every: float | None) -> list[float]:
    """Time of each step, s: of three runs the one with the middle sum."""
    runs = []
    for _ in range(3):
        times = []
        with write_log(path, head, flush_every=flush_every) as log:
            for step in steps:
                begin = time.perf_counter()
                log.write(*step)
                times.append(time.perf_counter() - begin)
        runs.append(times)
    middle = median(map(sum, runs))
    return next(times for times in runs if sum(times) == middle)


def read(path: Path, without: tuple[type, ...]) -> None:
    """All steps."""
    with read_log(path) as log:
        for _ in log.entries(without=without):
            pass
