"""Check, before anything moves, that no line of a rigid platform touches material that its own print has laid."""

from __future__ import annotations

from dataclasses import fields
from typing import Final

import numpy as np

from cablewright.analyses.interference import InterferenceSettings
from cablewright.analyses.job_distances import PART, JobDistances
from cablewright.foundation.errors import AnswerError
from cablewright.models.job_poses import along
from cablewright.models.statics import Model
from cablewright.printing.job import Job
from cablewright.printing.path import Samples
from cablewright.solvers.hanging_path import nozzle_on_path
from cablewright.solvers.inverse import solve_inverse

_BLOCK: Final = 4096  # samples at a time


def check_clear(model: Model, job: Job, layers: int | None) -> None:
    """Raise `AnswerError` at the first position of a *job* where a line touches laid material.

    *layers*: how many of the job's layers are checked (None: all). Strands are as wide and high as the part's beads;
    lines hang as the full model has them. The last 0.1 m of a line at its platform point are left out: a platform point
    may be level with the nozzle.
    """
    toolpath = job.toolpath()
    samples = _first_layers(job.samples(toolpath), layers)
    poses, retraction = along(model.robot, job, samples)
    poses = nozzle_on_path(model, poses, samples.positions, retraction)
    settings = InterferenceSettings(spares_ends=True)
    found = JobDistances.of(model.robot, job.beads(toolpath), samples, settings=settings)
    for first in range(0, len(poses), _BLOCK):
        block = slice(first, first + _BLOCK)
        drawn = None if retraction is None else retraction[block]
        found.take(solve_inverse(model, poses[block], path=True, retraction=drawn), first)
        touching = np.flatnonzero(found.margins[block, PART] <= 0.0)
        if not len(touching):
            continue
        row, contact = first + int(touching[0]), found.contacts.part
        assert contact is not None  # a margin has one
        place = ", ".join(f"{each:.3f}" for each in samples.positions[row])
        raise AnswerError(
            f"line {contact.line} would touch what was laid, by {-1e3 * contact.margin:.0f} mm, from the nozzle at "
            f"{place} m on, {samples.where(row)}: `cablewright interference` shows where"
        )


def _first_layers(samples: Samples, layers: int | None) -> Samples:
    """Return the samples until the last that is laid in the first *layers*."""
    numbers = np.unique(samples.layer[samples.extruding])
    if layers is None or layers >= len(numbers):
        return samples
    last = int(np.flatnonzero(samples.extruding & (samples.layer == numbers[layers - 1]))[-1])
    return Samples(**{each.name: getattr(samples, each.name)[: last + 1] for each in fields(samples)})
