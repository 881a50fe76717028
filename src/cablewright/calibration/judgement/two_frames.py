"""Measured positions in two frames: which rows are in a frame that is moved and turned from that of the others.

The lengths alone give the places of all poses up to one motion. If one motion takes some of these places to the
positions measured there, and another motion takes the rest, an instrument was set up again, or two files were joined.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

import numpy as np

from cablewright.calibration.judgement.consistency import predicted
from cablewright.calibration.plan import CalibrationPlan
from cablewright.calibration.poses.problem import CalibrationProblem, StraightProblem
from cablewright.calibration.poses.start_values import best_fit
from cablewright.calibration.poses.sufficient_data import min_poses, surplus_per_pose
from cablewright.foundation.arrays import Array, Indices, Mask
from cablewright.models.rotation import rotation_onto

_TRIES: Final = 200  # random threes of places
_BEYOND: Final = 5.0  # sigmas of a position ...
_SHAPE: Final = 5e-3  # m: ... and what lengths alone do not know of the places, up to which one fits a motion
_FEW: Final = 4  # places of a frame
_ALL: Final = 0.9  # share of the places that are in one of two frames
_LEVEL: Final = 1e-6  # probability by chance of positions so far from where the other data have them
_FITS: Final = 2e-3  # m: lengths that fit worse alone say nothing of places


def two_frames(problem: CalibrationProblem, rough: float, seed: int = 0) -> str:
    """Return a sentence that names the rows whose positions are in a second frame; empty if all are in one.

    *rough*: max error of the file's exit points, m; starts and threes of places are drawn with *seed*.
    """
    measured, sigma = problem.measured, problem.measured.pose_sigma
    if problem.elastic or sigma is None or measured.guess is None:
        return ""
    known = np.flatnonzero(np.isfinite(sigma[:, :3]).all(axis=1))
    if len(known) < 2 * _FEW:
        return ""
    plan = CalibrationPlan(**{name: getattr(problem.plan, name) for name in ("unknowns", "shared", "groups", "known")})
    alone = StraightProblem.of(problem.robot, measured.lengths_alone(), plan, hold=False)
    if surplus_per_pose(alone) < 1 or problem.poses < min_poses(alone):
        return ""
    found = best_fit(alone, seed, rough)
    off = alone.derivatives(found.theta, found.poses).residual * alone.encoder_sigma
    if found.code != 0 or not np.sqrt(np.mean(off**2)) < _FITS:
        return ""
    places, seen = alone.poses_of(found.poses)[known, :3], measured.guess[known, :3]
    limit = _BEYOND * np.linalg.norm(sigma[known, :3], axis=1) + _SHAPE
    rng = np.random.default_rng(seed)
    first = _largest(places, seen, limit, np.ones(len(known), dtype=bool), rng)
    other = _largest(places, seen, limit, ~first, rng)
    if other.sum() < _FEW or first.sum() + other.sum() < _ALL * len(known):
        return ""
    rows = known[other]
    if not _is_denied(problem, rows, rough, seed):
        return ""
    step, turn = _between(places, seen, first, other)
    names = ", ".join(measured.place(int(at)) for at in rows[:3]) + (
        f" and {len(rows) - 3} more" if rows[3:].size else ""
    )
    return (
        f"measured positions are in two frames: that of {names} is {step:.3g} m away from the frame of the other "
        f"{first.sum()}, and turned by {math.degrees(turn):.2g} deg; measure all from one set-up of the instrument, "
        "convert them by common points, or leave sigma_x .. of these rows blank"
    )


def _is_denied(problem: CalibrationProblem, rows: Indices, rough: float, seed: int) -> bool:
    """Return whether all other data deny the positions of some *rows*, beyond the uncertainty of these places."""
    measured = problem.measured
    assert measured.pose_sigma is not None
    sigma, part = measured.pose_sigma.copy(), np.isin(np.arange(problem.poses), rows)
    sigma[rows] = np.nan
    without = StraightProblem.of(problem.robot, replace(measured, pose_sigma=sigma), problem.plan)
    found = best_fit(without, seed, rough)
    if found.code != 0:
        return False
    whole = StraightProblem.of(problem.robot, measured, problem.plan)
    shown = predicted(whole, replace(found, weights=whole.weights), (part,))
    return bool(shown) and shown[0].probability < _LEVEL


def _largest(places: Array, seen: Array, limit: Array, among: Mask, rng: np.random.Generator) -> Mask:
    """Return the largest set (N,) *among* the positions that one motion takes from *places* to within *limit* (N,)."""
    best, where = np.zeros(len(places), dtype=bool), np.flatnonzero(among)
    for _ in range(_TRIES if len(where) >= _FEW else 0):
        own = np.zeros(len(places), dtype=bool)
        own[rng.choice(where, 3, replace=False)] = True
        for _ in range(2):  # by the three, then by all that fit
            turn, shift = _motion(places[own], seen[own])
            own = among & (np.linalg.norm(places @ turn.T + shift - seen, axis=1) < limit)
            if own.sum() < _FEW:
                break
        best = own if own.sum() > best.sum() else best
    return best


def _motion(places: Array, seen: Array) -> tuple[Array, Array]:
    """Return the rotation (3, 3) and translation (3,), m, that best move *places* (N, 3) onto those *seen* (N, 3)."""
    turn = rotation_onto(places, seen)
    return turn, seen.mean(axis=0) - turn @ places.mean(axis=0)


def _between(places: Array, seen: Array, first: Mask, other: Mask) -> tuple[float, float]:
    """Return the distance, m, and the angle, rad, between the frames of the *first* and the *other* positions."""
    one, two = (_motion(places[own], seen[own]) for own in (first, other))
    middle = places[other].mean(axis=0)
    step = (two[0] @ middle + two[1]) - (one[0] @ middle + one[1])
    return float(np.linalg.norm(step)), math.acos(min(1.0, max(-1.0, 0.5 * (float(np.trace(two[0] @ one[0].T)) - 1.0))))
