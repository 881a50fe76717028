"""A layer of the paper's print under control, beside what the paper tells; and what a step of control takes.

`python -m benchmarks.print_job REVISION [ROUNDS]` prints how much faster than real time `cablewright print` runs,
beside the code of an earlier revision: both in turns, each in processes of its own.
`python -m benchmarks.print_job parts` prints what parts of a step take.
"""

from __future__ import annotations

import cProfile
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.timing import HERE, Row, checked_out
from cablewright.foundation.signals import Command, SensorFrame
from cablewright.live.prints.loop import Printer
from cablewright.live.prints.plan import MachineTwin, PrintOptions, plan_print, twin_of
from cablewright.live.prints.print_job import print_job
from cablewright.live.prints.record import finish
from cablewright.live.prints.recorder import FolderRecorder
from cablewright.live.prints.result import PrintRecord
from cablewright.live.prints.run import Timing, begin_print, folder_log, run_print, started
from cablewright.live.prints.simulated_operator import Attendant, attendant_of
from cablewright.live.prints.snapshot_writer import SnapshotWriter
from cablewright.machine.log.head import LogHead
from cablewright.machine.simulated.settings import whole_machine
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.printing.job import Job, Motion, load_job
from cablewright.printing.numeric_path import Helix
from cablewright.robot import load
from cablewright.running.garbage_collection import without_old_objects

JOB = Path(__file__).parent.parent / "examples" / "blind-machines.toml"
MAX_ERRORS = {"paper": 4.82, "filter": 1.5, "encoders": None}
"""cm: the most that the path error may be."""
FULL = load_job(JOB)
RING = Helix(radius=0.02, layers=1, layer_height=1e-3, first_height=1.0)
QUICK = FULL.model_copy(update={"curve": None, "helix": RING})

_FIRST = 300
"""Steps that are not counted: the machine is reset, and the filter begins."""
_TIMED = 7
"""One step of so many is timed: prime to those of a lidar's turn and of other intervals."""


def rows(job: Job) -> Iterator[Row]:
    """All rows of this file: the first layer of *job*."""
    for estimator, law in (("paper", "paper"), ("filter", "model"), ("encoders", "model")):
        found, timing = layer(job, PrintOptions(estimator, law, layers=1))  # type: ignore[arg-type]
        name, aim = f"print, a layer: {estimator} estimation, {law} law", MAX_ERRORS[estimator]
        error, speed = found.true.error, found.true.speed
        largest = 100.0 * error.size
        if aim is None:
            yield Row(f"{name}: most off", largest, "cm")
            continue
        yield Row(f"{name}: most off", largest, "cm", f"<= {aim}", largest <= aim)
        mean, off = 100.0 * error.mean, abs(speed.mean / 0.03 - 1.0)
        yield Row(f"{name}: mean", mean, "cm", "within 0.03", abs(mean) <= 0.03)
        yield Row(f"{name}: speed off by", 100.0 * off, "%", "<= 0.6", off <= 6e-3)
        variance = 1e4 * speed.variance
        yield Row(f"{name}: its variance", variance, "(cm/s)^2", "<= 0.027", variance <= 0.027)
        told = timing.statistics()
        yield Row(f"{name}: a step of control and log", 1e3 * told["mean"], "ms", "<= 1", told["mean"] <= 1e-3)
        yield Row(f"{name}: 99 of 100 steps", 1e3 * told["p99"], "ms", "<= 5", told["p99"] <= 5e-3)
    yield from body_rows(0.5 if job is FULL else 0.02)
    yield from speed_rows(3000 if job is FULL else 30)


def timed_twins() -> tuple[tuple[str, MachineTwin, float, float], ...]:
    """Prints whose loops are timed: name, twin, aims for the speed and for guard, estimate and control, us."""
    machine = whole_machine("cogiro")
    assert machine.owner.body is not None
    still = machine.with_owner(body=machine.owner.body.model_copy(update={"tour": ()}))
    ring = Helix(radius=0.5, layers=1, layer_height=0.012, first_height=0.6)
    job = Job(name="ring", helix=ring, motion=Motion(print_speed=0.05, travel_speed=0.05, acceleration=0.05))
    first, house = PrintOptions(layers=1), load_job(JOB.with_name("house.toml"))
    return (
        ("merlet2023, filter", twin_of(load("merlet2023"), FULL, None, first), 50.0, 60.0),
        ("cogiro, all sensors", twin_of(load("cogiro"), job, still, PrintOptions()), 30.0, 100.0),
        ("house-printer, encoders", twin_of(load("house-printer"), house, None, first), 65.0, 60.0),
    )


def speed_rows(steps: int) -> Iterator[Row]:
    """How much faster than real time whole loops run, by processor time: machine, estimation, control and full log."""
    for name, twin, aim, most in timed_twins():
        spent, text = loop_times(twin, steps), f"print, {name}:"
        speed = spent.steps * spent.period / spent.whole
        told = f"{text} the whole loop, by processor time"
        yield Row(told, speed, "x real", f">= {aim:g}", speed >= aim, "the machine alone", spent.machine / spent.whole)
        mean, p99 = 1e6 * float(spent.control.mean()), 1e6 * float(np.percentile(spent.control, 99.0))
        yield Row(f"{text} guard, estimate and control", mean, "us", f"<= {most:g}", mean <= most)
        yield Row(f"{text} the same, 99 of 100 steps", p99, "us", "<= 200", p99 <= 200.0)


class Spent(NamedTuple):
    """Processor time, s, of some steps of a print."""

    steps: int
    period: float  # s, of the machine
    whole: float  # of all, with the log, also in its thread
    machine: float  # of the simulated machine in all steps, by those that are timed
    control: NDArray[np.float64]  # (k,) of guard, estimation and control, of each step that is timed


@contextmanager
def begun(twin: MachineTwin) -> Iterator[tuple[SimulatedMachine, Printer, Attendant, FolderRecorder]]:
    """Begin a print with a full log in a folder that does not stay."""
    machine, printer = begin_print(twin, plan_print(twin))
    head = LogHead(started(twin.robot, twin.path), machine.settings, machine.period, simulation=machine.simulation)
    with tempfile.TemporaryDirectory() as name:
        log_path, checkpoint = Path(name) / "log.mcap", Path(name) / "checkpoint.bin"
        with folder_log(log_path, head, drops=False) as log, SnapshotWriter(checkpoint) as writer:
            recorder = FolderRecorder(log, writer, Timing(machine.period))
            machine.open()
            with without_old_objects(paced=False):  # as a print does
                yield machine, printer, attendant_of(machine, printer, twin.choices), recorder
            machine.close()


def loop_times(twin: MachineTwin, steps: int) -> Spent:
    """Return what *steps* of a print take, after some that are not counted.

    One step of seven is timed: clocks of processor time may take as long as a tenth of a step.
    """
    alone: list[float] = []

    control, first = [], 0.0
    with begun(twin) as (machine, printer, attendant, recorder):
        inner = machine.step

        def step(command: Command) -> SensorFrame:
            begin = time.thread_time()
            frame = inner(command)
            alone.append(time.thread_time() - begin)
            return frame

        for number in range(steps + _FIRST):
            if number == _FIRST:
                first = time.process_time()
            orders = attendant.orders(printer, printer.time)
            if number < _FIRST or number % _TIMED:
                made = printer.step(orders)
            else:
                machine.step, begin = step, time.thread_time()  # type: ignore[method-assign]
                made = printer.step(orders)
                control.append(time.thread_time() - begin - alone[-1])
                machine.step = inner  # type: ignore[method-assign]
            recorder.add(printer, made, last=False)
        whole = time.process_time() - first
    return Spent(steps, machine.period, whole, steps * float(np.mean(alone)), np.array(control))


def parts(twin: MachineTwin, steps: int) -> tuple[float, float, float]:
    """Return what a step takes in kernels and for its log, us, and its number of calls."""
    profile, logged = cProfile.Profile(), 0.0
    with begun(twin) as (_, printer, attendant, recorder):
        for number in range(2 * steps + _FIRST):
            if number == _FIRST + steps:
                profile.enable()
            made = printer.step(attendant.orders(printer, printer.time))
            begin = time.thread_time()
            recorder.add(printer, made, last=False)
            logged += (_FIRST <= number < _FIRST + steps) * (time.thread_time() - begin)
        profile.disable()
    found = profile.getstats()
    kernels = sum(each.inlinetime for each in found if isinstance(each.code, str) and "kernels." in each.code)
    return 1e6 * kernels / steps, 1e6 * logged / steps, sum(each.callcount for each in found) / steps


def print_parts(steps: int) -> None:
    """Print what parts of a step take, of each print whose loop is timed."""
    for name, twin, *_ in timed_twins():
        whole = 1e6 * loop_times(twin, steps).whole / steps
        kernels, logged, calls = parts(twin, steps)
        print(f"{name}: {whole:.0f} us a step; {kernels:.0f} in kernels, {logged:.0f} for the log; {calls:.0f} calls")


def body_rows(radius: float) -> Iterator[Row]:
    """A step of control of cogiro's body, with guard, estimation by all sensors and log, on a ring of a *radius*, m."""
    machine = whole_machine("cogiro")
    assert machine.owner.body is not None
    still = machine.with_owner(body=machine.owner.body.model_copy(update={"tour": ()}))
    ring = Helix(radius=radius, layers=1, layer_height=0.012, first_height=0.6)
    job = Job(name="ring", helix=ring, motion=Motion(print_speed=0.05, travel_speed=0.05, acceleration=0.05))
    with tempfile.TemporaryDirectory() as name:
        told = print_job("cogiro", job, Path(name) / "run", machine=still).run.timing.statistics()
    for key, what, most in (("mean", "a step", 0.8), ("p99", "99 of 100 steps", 3.0)):
        for clock in ("", "processor_"):
            spent = 1e3 * told[f"{clock}{key}"]
            name = f"print, cogiro, all sensors: {what} of control and log{', processor' if clock else ''}"
            yield Row(name, spent, "ms", f"<= {most}", spent <= most)


def layer(job: Job, choices: PrintOptions) -> tuple[PrintRecord, Timing]:
    """Print the first layer; its record and how long its steps took."""
    twin = twin_of(load("merlet2023"), job, None, choices)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "run"
        run = run_print(twin, folder, {}, {})
        found, _ = finish(folder, twin.path.track, twin.path.print_speed, run.machine.rig.ground.field)
    return found, run.timing


PRINTS = {"merlet2023": ("filter", 1.0, 0.03), "house-printer": ("encoders", 0.5, 0.1)}
"""Robots whose rings are printed beside an earlier revision: estimator, m over the floor, m/s."""
SHORT, LONG = 0.1, 0.7  # m, radii of two rings: what both prints have in common does not count


def beside(revision: str, rounds: int) -> None:
    """Print how much faster than real time prints of rings run, then and now; the best of some rounds."""
    with checked_out(revision) as there, tempfile.TemporaryDirectory() as folder:
        for robot in PRINTS:
            best = {there: 0.0, HERE: 0.0}
            for _ in range(rounds):
                for source in best:
                    best[source] = max(best[source], _speed(source, robot, Path(folder)))
            then, now = best.values()
            print(f"{robot}: {then:.1f} x real time then, {now:.1f} now: {now / then:.2f}", flush=True)


def _speed(source: Path, robot: str, folder: Path) -> float:
    """Times real time of a print by the code in *source*, by the clock, without what is done once."""
    spent = [_print(source, robot, radius, folder) for radius in (SHORT, SHORT, LONG)][1:]  # the first one compiles
    return 2.0 * np.pi * (LONG - SHORT) / PRINTS[robot][2] / (spent[1] - spent[0])


def _print(source: Path, robot: str, radius: float, folder: Path) -> float:
    """Seconds that the print of a ring takes."""
    (estimator, height, speed), job = PRINTS[robot], folder / "ring.toml"
    job.write_text(
        f'schema = 1\nname = "ring"\n[helix]\nradius = {radius}\nlayers = 1\nlayer_height = 1e-3\n'
        f"first_height = {height}\n[motion]\nprint_speed = {speed}\ntravel_speed = {speed}\nacceleration = 0.05\n"
    )
    with tempfile.TemporaryDirectory() as out:
        command = [sys.executable, "-m", "cablewright", "print", robot, job, "--estimator", estimator]
        begin = time.perf_counter()
        subprocess.run(
            [*command, "--out", Path(out) / "run"],
            env=os.environ | {"PYTHONPATH": str(source / "src")},
            capture_output=True,
            check=True,
        )
        return time.perf_counter() - begin


if __name__ == "__main__" and sys.argv[1] == "parts":
    print_parts(3000)
elif __name__ == "__main__":
    beside(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 3)
