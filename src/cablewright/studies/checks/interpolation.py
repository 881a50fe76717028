"""How far lengths are off between two samples, where they are interpolated linearly."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array
from cablewright.models.statics import Model
from cablewright.paging import blocks, let_go
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse

MEASURED: Final = 512
"""Segments that are measured: those where a straight line would be off most."""


def interpolation_error(robot: Robot, poses: Array, lengths: Array, retraction: Array | None) -> float | None:
    """Return the largest error, m, of *lengths* (k, m) half-way between *poses* (k, n); None where nothing is held.

    Poses go linearly between samples too. The error of a straight line of length l is step^2 / (8 l) at most: segments
    are measured in the order of that, under all physics.
    """
    worst = _worst(poses, lengths)
    if not len(worst):
        return None
    middle = 0.5 * (poses[worst] + poses[worst + 1])
    retracted = None if retraction is None else 0.5 * (retraction[worst] + retraction[worst + 1])
    held = solve_inverse(Model(robot), middle, retraction=retracted)
    between = 0.5 * (lengths[worst] + lengths[worst + 1])
    off = np.abs(held.lengths - between)[held.ok]
    return float(np.nanmax(off)) if off.size else None


def _worst(poses: Array, lengths: Array) -> NDArray[np.int64]:
    """The segments, by the sample at their begin, where a straight line may be off most: those first."""
    worst, bound = np.zeros(0, dtype=np.int64), np.zeros(0)
    for at in blocks(len(poses) - 1):
        ends = slice(at.start, at.stop + 1)
        step = np.linalg.norm(np.diff(poses[ends, :3], axis=0), axis=1)
        shortest = np.minimum(lengths[ends][1:], lengths[ends][:-1]).min(axis=1)
        let_go((poses, lengths))
        own = np.where(np.isfinite(shortest) & (step > 0.0), step**2 / shortest, -1.0)
        worst, bound = np.concatenate([worst, np.arange(at.start, at.stop)]), np.concatenate([bound, own])
        kept = np.argsort(-bound, kind="stable")[:MEASURED]
        worst, bound = worst[kept], bound[kept]
    return worst[bound > 0.0]
