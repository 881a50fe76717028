"""A layer of the paper's print under control, beside what the paper tells; and what a step of control takes."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

from benchmarks.timing import Row
from cablewright.live.prints.plan import PrintOptions, twin_of
from cablewright.live.prints.print_job import print_job
from cablewright.live.prints.record import finish
from cablewright.live.prints.result import PrintRecord
from cablewright.live.prints.run import Timing, run_print
from cablewright.machine.simulated.settings import whole_machine
from cablewright.printing.job import Job, Motion, load_job
from cablewright.printing.numeric_path import Helix
from cablewright.robot import load

JOB = Path(__file__).parent.parent / "examples" / "blind-machines.toml"
MAX_ERRORS = {"paper": 4.82, "filter": 1.5, "encoders": None}
"""cm: the most that the path error may be."""
FULL = load_job(JOB)
RING = Helix(radius=0.02, layers=1, layer_height=1e-3, first_height=1.0)
QUICK = FULL.model_copy(update={"curve": None, "helix": RING})


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
