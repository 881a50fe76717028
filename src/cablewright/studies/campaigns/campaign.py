"""`campaign`: the same print on N simulated machines as built, and the effect of each tolerance on it."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from cablewright.foundation.errors import InputError
from cablewright.foundation.progress import Progress
from cablewright.live.prints.plan import PrintOptions, twin_of
from cablewright.machine.simulated.settings import TwinSettings
from cablewright.printing.job import Job, load_job
from cablewright.robot import Robot, load
from cablewright.running.executors.executor import Executor, Serial
from cablewright.running.executors.stored_results import kept_in
from cablewright.running.executors.study import evaluate, require_all
from cablewright.running.executors.task import Task
from cablewright.running.run_folders import file_hash
from cablewright.studies.campaigns.one_print import CampaignPrint, printed
from cablewright.studies.campaigns.result import Campaign, MachinePrint, Sensitivity, machine_print, succeeds

MAX_MACHINES: Final = 100_000
DEFAULT_TRIED: Final = 10
"""Default number of machines on which each tolerance is met exactly."""


def campaign(
    robot: Robot | str | Path,
    job: Job | str | Path,
    machines: int,
    *,
    machine: TwinSettings | str | Path | None = None,
    options: PrintOptions | None = None,
    tried: int = DEFAULT_TRIED,
    allowed_error: float | None = None,
    file: Path | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Campaign:
    """Print *job* on *machines* machines, built from the tolerances with successive seeds from *options* on.

    *machine*: settings, a file or a library name (default: the robot's). *tried*: number of the machines on which each
    tolerance in turn is also set to zero, with the same seeds; 0: none. *allowed_error*: largest distance from the path
    at which a print counts as a success, m (default: that of the job). *file* keeps results, also after an
    interruption; *executor*: the executor that does the work. Raises `InputError`, and `AnswerError` where prints fail
    that are no answer: the others are kept.
    """
    if not 1 <= machines <= MAX_MACHINES:
        raise InputError(f"machines = {machines}: must be from 1 to {MAX_MACHINES}")
    if not 0 <= tried <= machines:
        raise InputError(f"tried = {tried}: must be from 0 to the number of machines, {machines}")
    what = _what(robot, job, machine, options or PrintOptions())
    bead, differing = what.job.typical_bead()
    allowed = what.job.allowed_error(bead.width) if allowed_error is None else allowed_error
    if not (allowed > 0.0 and math.isfinite(allowed)):
        raise InputError(f"allowed_error = {allowed:g}: must be a finite number over 0, m")
    seeds = [what.options.seed + number for number in range(machines)]
    items = [(seed, "") for seed in seeds] + [(seed, name) for name in what.tolerances for seed in seeds[:tried]]
    with kept_in(file) as kept:
        outcomes = evaluate(Task(printed, what, "print"), items, executor or Serial(), kept, progress)
    require_all(outcomes, [_words(*item) for item in items])
    found = {item: machine_print(item[0], each.value) for item, each in zip(items, outcomes, strict=True)}
    nominal = tuple(found[seed, ""] for seed in seeds)
    notes = () if what.machine.owner.extrusion is None else differing
    by_tolerance = [
        _sensitivity(what, name, nominal[:tried], [found[seed, name] for seed in seeds[:tried]], allowed)
        for name in what.tolerances
        if tried
    ]
    return Campaign(what, nominal, tuple(sorted(by_tolerance, key=lambda each: each.change)), allowed, notes)


def _what(
    robot: Robot | str | Path, job: Job | str | Path, machine: TwinSettings | str | Path | None, options: PrintOptions
) -> CampaignPrint:
    """Return what all prints have in common. Raises `InputError`."""
    described = robot if isinstance(robot, Robot) else load(str(robot))
    loaded = job if isinstance(job, Job) else load_job(job)
    settings = twin_of(described, loaded, machine, replace(options, intrusions=0)).settings
    same = replace(options, severity=None)
    return CampaignPrint(described, loaded, settings, same, "" if loaded.gcode is None else file_hash(loaded.gcode))


def _words(seed: int, exact: str) -> str:
    return f"machine of seed {seed}" + (f" with {exact} exact" if exact else "")


def _sensitivity(
    what: CampaignPrint,
    name: str,
    before: tuple[MachinePrint, ...],
    after: list[MachinePrint],
    allowed: float,
) -> Sensitivity:
    """Compare the same machines with and without one tolerance."""
    changes = np.array([new.max_error - old.max_error for old, new in zip(before, after, strict=True)])
    changes = changes[np.isfinite(changes)]
    count = len(changes)
    return Sensitivity(
        tolerance=name,
        value=what.tolerances[name],
        machines=len(after),
        change=float(changes.mean()) if count else math.nan,
        change_error=float(changes.std(ddof=1)) / math.sqrt(count) if count > 1 else math.nan,
        succeeded=sum(succeeds(each, allowed) for each in after),
    )
