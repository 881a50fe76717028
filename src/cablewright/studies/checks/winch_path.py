"""A job as the turns of winches: points so close that lines between them are straight to a stated error."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from cablewright.arrays import Array
from cablewright.errors import AnswerError, InputError
from cablewright.models.drum import Drum
from cablewright.models.statics import Model
from cablewright.printing.job import Job
from cablewright.printing.path import Samples
from cablewright.progress import Progress, silent
from cablewright.solvers.inverse import BLOCK, solve_inverse
from cablewright.studies.job_poses import along, sampled

TOLERANCE: Final = 2e-5
"""Default of the largest error of a length between two points, m."""

_TRIES: Final = 4
_LEAST: Final = 0.1  # share of a step that the next has at least: some errors do not fall, as of lines near slack


@dataclass(frozen=True, eq=False)
class WinchPath:
    """A job in the coordinates of its winches, at k points.

    ``turns`` (k, m): rad of each drum, positive as it pays out, 0 at the first point; ``laid`` (k,): m of strand laid
    until there; ``error``: m, the largest by which a length is off half-way between two points, when both turns and the
    place of the nozzle go linearly.
    """

    samples: Samples
    lengths: Array  # (k, m) m, unstrained
    turns: Array  # (k, m) rad
    laid: Array  # (k,) m
    error: float


def winch_path(
    model: Model,
    job: Job,
    drums: Sequence[Drum],
    *,
    layers: tuple[int, int] | None = None,
    tolerance: float = TOLERANCE,
    progress: Progress = silent,
) -> WinchPath:
    """Return the turns of the winches along a job, or *layers* of it (first and last, from 1), under all physics.

    The step shrinks until lengths between points are good to *tolerance*, m. Raises `AnswerError` where the robot
    cannot hold the nozzle, or the tolerance is not met, and `InputError` for layers that the part does not have.
    """
    toolpath = job.toolpath(progress)
    if layers is not None and not 1 <= layers[0] <= layers[1] <= toolpath.layer_count:
        raise InputError(f"layers {layers[0]} to {layers[1]}: this part has 1 to {toolpath.layer_count}")
    samples, step = sampled(model.robot, job, toolpath)
    for _ in range(_TRIES):
        part = samples if layers is None else _of_layers(samples, layers)
        lengths = _lengths(model, job, part, progress)
        turns = np.column_stack([drum.angles(lengths[:, i]) for i, drum in enumerate(drums)])
        error = _error(model, job, part, turns, drums, progress)
        if error <= tolerance:
            return WinchPath(part, lengths, turns - turns[0], _laid(part), error)
        step *= max(0.9 * math.sqrt(tolerance / error), _LEAST)  # the error goes with the square of the step
        finer = job.sampling.model_copy(update={"step": step})
        samples = job.model_copy(update={"sampling": finer}).samples(toolpath)
    raise AnswerError(
        f"lengths between points are off by {error:.3g} m at a step of {step:.3g} m; {tolerance:g} m asked"
    )


def _of_layers(samples: Samples, layers: tuple[int, int]) -> Samples:
    """Return the samples from the first to the last that is laid in these layers."""
    first, last = layers
    inside = np.flatnonzero((samples.layer >= first) & (samples.layer <= last))
    part = slice(int(inside[0]), int(inside[-1]) + 1)
    columns = {key: value[part] for key, value in vars(samples).items()}
    return replace(samples, **columns | {"distance": columns["distance"] - columns["distance"][0]})


def _lengths(model: Model, job: Job, samples: Samples, progress: Progress) -> Array:
    """Return the lengths (k, m) that hold the nozzle at the samples. Raises `AnswerError` where none do."""
    poses, retraction = along(model.robot, job, samples)
    found = np.empty((len(poses), model.m))
    for first in range(0, len(poses), BLOCK):
        progress("solving", first, len(poses))
        block = slice(first, first + BLOCK)
        held = solve_inverse(
            model, poses[block], path=True, retraction=None if retraction is None else retraction[block]
        )
        if not held.ok.all():
            bad = int(np.flatnonzero(~held.ok)[0])
            place = ", ".join(f"{each:g}" for each in samples.positions[first + bad])
            raise AnswerError(
                f"nozzle at {place} m, {samples.where(first + bad)}: {held[bad].sentence()}", held[bad].status
            )
        found[block] = held.lengths
    progress("solving", len(poses), len(poses))
    return found


def _error(model: Model, job: Job, samples: Samples, turns: Array, drums: Sequence[Drum], progress: Progress) -> float:
    """Return the largest error, m, of a length half-way between two points."""
    if len(samples) < 2:
        return 0.0
    half = {key: value[1:] for key, value in vars(samples).items()}
    half["positions"] = 0.5 * (samples.positions[:-1] + samples.positions[1:])
    lengths = _lengths(model, job, replace(samples, **half), progress)
    middle = 0.5 * (turns[:-1] + turns[1:])
    between = np.column_stack([drum.lengths(middle[:, i]) for i, drum in enumerate(drums)])
    return float(np.abs(lengths - between).max())


def _laid(samples: Samples) -> Array:
    pieces = np.diff(samples.distance) * samples.extruding[1:]
    return np.concatenate([[0.0], np.cumsum(pieces)])
