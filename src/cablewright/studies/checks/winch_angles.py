"""A job as winch angles: points so dense that straight interpolation between them has a stated error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.analyses.travel_moves import driven
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import AnswerError, InputError, Status
from cablewright.foundation.progress import Progress, silent
from cablewright.models.drum import WinchDrum
from cablewright.models.job_poses import along, sampled
from cablewright.models.statics import Model
from cablewright.printing.job import Job
from cablewright.printing.path import MAX_SAMPLES, Samples
from cablewright.printing.toolpath import Toolpath
from cablewright.robot import Robot
from cablewright.solvers.hanging_path import nozzle_on_path
from cablewright.solvers.inverse import BLOCK, solve_inverse

TOLERANCE: Final = 2e-5
"""Default of the largest error of a length between two points, m."""

SHORTEST: Final = 1e-5
"""Distance of two points, m, below which they are not brought closer: a length that still jumps there is no path."""

ALLOWED: Final = 1e-3
"""Error of a length, m, up to which a larger tolerance is an advice."""

_MOST_PARTS: Final = 32  # into which one step divides a piece


@dataclass(frozen=True, eq=False)
class WinchPath:
    """A job in the coordinates of its winches, at k points.

    ``turns`` (k, m): rad of each drum, positive as it pays out, 0 at the first point; ``laid`` (k,): m of strand laid
    until there; ``error``: m, the largest error of a length half-way between two points, when both turns and the place
    of the nozzle go linearly; ``toolpath``: toolpath of the job's file; ``is_part``: whether it has only some layers of
    the job.
    """

    samples: Samples
    lengths: Array  # (k, m) m, unstrained
    turns: Array  # (k, m) rad
    laid: Array  # (k,) m
    error: float
    toolpath: Toolpath
    is_part: bool


def winch_path(
    model: Model,
    job: Job,
    drums: Sequence[WinchDrum],
    *,
    layers: tuple[int, int] | None = None,
    tolerance: float = TOLERANCE,
    jump: float = 0.0,
    progress: Progress = silent,
) -> WinchPath:
    """Return the winch angles along a job, or *layers* of it (first and last, from 1), with all physics.

    Pieces of the path are divided until lengths half-way are good to *tolerance*, m, or if they are shorter than
    `SHORTEST` to *jump*, m. Raises `AnswerError` where the robot cannot hold the nozzle, or the tolerance is not met,
    and `InputError` for layers that the part does not have, or for too many points.
    """
    toolpath = job.toolpath(progress)
    if layers is not None and not 1 <= layers[0] <= layers[1] <= toolpath.layer_count:
        raise InputError(f"layers {layers[0]} to {layers[1]}: this part has 1 to {toolpath.layer_count}")
    beads = job.beads(toolpath)
    samples = driven(model.robot, job, sampled(model.robot, job, toolpath, beads=beads)[0], beads)
    samples = samples if layers is None else _of_layers(samples, layers)
    lengths = _lengths(model, job, samples, progress)
    errors = np.full(len(samples) - 1, np.nan)  # of the pieces that are measured
    while True:
        turns = np.column_stack([drum.angles(lengths[:, i]) for i, drum in enumerate(drums)])
        new = np.flatnonzero(np.isnan(errors))
        half = _halves(samples, new)
        between = np.column_stack([d.lengths(0.5 * (turns[new, i] + turns[new + 1, i])) for i, d in enumerate(drums)])
        errors[new] = np.abs(_lengths(model, job, half, progress) - between).max(axis=1)
        rough = errors > np.where(np.diff(samples.distance) < SHORTEST, max(jump, tolerance), tolerance)
        if not rough.any():
            worst = float(errors.max(initial=0.0))
            return WinchPath(samples, lengths, turns - turns[0], _laid(samples), worst, toolpath, layers is not None)
        # the error of a piece goes with the square of its length, but for corners of a length along the path
        parts = np.clip(np.ceil(np.sqrt(errors / (0.9 * tolerance))), 2, _MOST_PARTS)
        parts = np.where(rough, parts, 1).astype(np.int64)
        _require_points(model.robot, samples, lengths, errors, parts, tolerance)
        samples, errors, kept = _divided(samples, errors, parts)
        known, lengths = lengths, np.empty((len(samples), model.winches))
        lengths[kept] = known
        lengths[~kept] = _lengths(model, job, _rows(samples, ~kept), progress)


def _require_points(
    robot: Robot, samples: Samples, lengths: Array, errors: Array, parts: NDArray[np.int64], tolerance: float
) -> None:
    """Raise an error where points that are too close or too many do not meet the tolerance."""
    short = (np.diff(samples.distance) < SHORTEST) & (parts > 1)
    if short.any():
        k = int(np.argmax(np.where(short, errors, 0.0)))
        place = ", ".join(f"{each:g}" for each in samples.positions[k])
        line = robot.winch_lines[int(np.argmax(np.abs(lengths[k + 1] - lengths[k])))]
        allowed = f", or allow it with --tolerance {1.1 * errors[k]:.2g}" if errors[k] < ALLOWED else ""
        raise AnswerError(
            f"nozzle at {place} m, {samples.where(k + 1)}: line {line.name!r} jumps, the interpolation error of "
            "lengths between points is "
            f"{errors[k]:.2g} m; {tolerance:g} m asked. Where it goes slack, raise the minimum of its "
            f"tension_limits, {line.tension_limits[0]:g} N{allowed}"
        )
    if parts.sum() > MAX_SAMPLES:
        raise InputError(
            f"the interpolation error of lengths between points is {errors.max():.2g} m; {tolerance:g} m asked "
            "needs more than "
            f"{MAX_SAMPLES} points: give a larger --tolerance, or part of the job by --layers"
        )


def _of_layers(samples: Samples, layers: tuple[int, int]) -> Samples:
    """Return the samples from the first to the last that is laid in these layers."""
    first, last = layers
    inside = np.flatnonzero((samples.layer >= first) & (samples.layer <= last))
    part = _rows(samples, slice(int(inside[0]), int(inside[-1]) + 1))
    return replace(part, distance=part.distance - part.distance[0])


def _rows(samples: Samples, rows: slice | NDArray[np.int64] | Mask) -> Samples:
    return Samples(**{key: value[rows] for key, value in vars(samples).items()})


def _halves(samples: Samples, pieces: NDArray[np.int64]) -> Samples:
    """Return the points half-way of *pieces*, of which the first is from the first sample to the second."""
    middles = 0.5 * (samples.positions[pieces] + samples.positions[pieces + 1])
    return replace(_rows(samples, pieces + 1), positions=middles)


def _divided(samples: Samples, errors: Array, parts: NDArray[np.int64]) -> tuple[Samples, Array, Mask]:
    """Return samples with each piece in so many *parts*, their errors, NaN of the new ones, and which samples were."""
    ends = np.cumsum(parts)  # the row of each piece's end
    piece = np.repeat(np.arange(len(parts)), parts)
    share = (np.arange(len(piece)) - (ends - parts)[piece] + 1) / parts[piece]
    kept = np.zeros(len(piece) + 1, np.bool_)
    kept[0] = kept[ends] = True
    found = _rows(samples, np.concatenate([[0], piece + 1]))
    for name in ("positions", "distance"):
        column, start = getattr(found, name), getattr(samples, name)[piece]
        between = start + np.reshape(share, (-1,) + (1,) * (start.ndim - 1)) * (column[1:] - start)
        column[1:] = np.where(np.reshape(kept[1:], (-1,) + (1,) * (start.ndim - 1)), column[1:], between)
    found.dwell[~kept] = 0.0
    return found, np.where(parts[piece] > 1, np.nan, errors[piece]), kept


def _lengths(model: Model, job: Job, samples: Samples, progress: Progress) -> Array:
    """Return the lengths (k, w) of winches that hold the nozzle at the samples. Raises `AnswerError` where none do."""
    poses, retraction = along(model.robot, job, samples)
    poses = nozzle_on_path(model, poses, samples.positions, retraction)
    hosts = list(model.robot.hosts)
    found = np.empty((len(poses), len(hosts)))
    for first in range(0, len(poses), BLOCK):
        progress("solving", first, len(poses))
        block = slice(first, first + BLOCK)
        held = solve_inverse(
            model, poses[block], path=True, retraction=None if retraction is None else retraction[block]
        )
        if not (good := held.holds).all():
            bad = int(np.argmin(good))
            place = ", ".join(f"{each:g}" for each in samples.positions[first + bad])
            raise AnswerError(
                f"nozzle at {place} m, {samples.where(first + bad)}: {held[bad].sentence()}",
                Status.of(int(held.judged_code[bad])),
            )
        found[block] = held.lengths[:, hosts]
    progress("solving", len(poses), len(poses))
    return found


def _laid(samples: Samples) -> Array:
    return np.concatenate([[0.0], np.cumsum(np.diff(samples.distance) * samples.extruding[1:])])
