"""Calibration fits that resist gross errors: poses re-weighted by their residuals, and fits of parts of the poses.

Least trimmed squares (Rousseeuw, Van Driessen 2006): with few redundant poses, gross errors move a plain fit so far
that no re-weighting brings it back, while a part of the poses without them has the right answer. As there, many parts
take cheap steps, here of linear equations where a fit is slow or re-weighting seldom fails, and the best few are then
fitted.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import special

from cablewright.calibration.poses.fit import QUICK, PoseFit, fit, fitted_poses
from cablewright.calibration.poses.observability import information, projected
from cablewright.calibration.poses.problem import CalibrationProblem
from cablewright.calibration.poses.sufficient_data import gauge_size
from cablewright.foundation.arrays import Array
from cablewright.foundation.progress import Progress

_ROUNDS: Final = 12  # max, of re-weighting
_SETTLED: Final = 0.02  # change of the weights that ends them
_PARTS: Final = (40, 12)  # random parts of the poses, with few redundant poses and with many
_BEST: Final = 3  # parts that are fitted where linear equations may choose
_CONCENTRATIONS: Final = 4
_MANY: Final = 3  # times the poses of a part: with more, re-weighting seldom fails
_KEPT: Final = 75  # percent of the poses, the best ones, by whose residuals parts are compared
_EACH: Final = 4  # min poses of a group in a part: with three known places nothing is open
_LEFT_OVER: Final = 5  # redundant measurements in a part

_Poses = NDArray[np.int64]


def robust_fit(problem: CalibrationProblem, plain: PoseFit, start: PoseFit, seed: int, progress: Progress) -> PoseFit:
    """Return a fit that gross errors hardly move.

    *plain*: a fit of all rows; *start*: one for fits of parts.
    """
    return _best_of_parts(problem, _reweighted(problem, plain), start, seed, progress)


def unexplained(problem: CalibrationProblem, found: PoseFit) -> tuple[Array, Array]:
    """Return the sum of squares (N,) of each pose that no change of the pose explains, and its redundancy (N,).

    The redundancy is the pose's surplus of rows, less the share that the unknowns use.
    """
    off, rows, ranks = projected(problem.derivatives(found.theta, found.poses, found.weights))
    covariance = information(problem, found.theta, found.poses, found.weights, priors=True).covariance
    taken = np.sum((rows @ covariance) * rows, axis=(1, 2))
    return np.sum(off * off, axis=1), np.maximum(problem.row_counts - ranks - taken, 0.1)


def spread_of(squares: Array, redundancy: Array) -> float:
    """Return the ratio of residuals to the sigmas of their weights: a median over poses, which resists outliers."""
    return float(np.sqrt(np.median(squares / special.chdtri(redundancy, 0.5))))


def _reweighted(problem: CalibrationProblem, plain: PoseFit) -> PoseFit:
    """Return the fit with poses re-weighted by 1 / |unexplained residuals|: a few bad ones hardly count."""
    found, share = plain, np.ones(problem.poses)
    for _ in range(_ROUNDS):
        squares, redundancy = unexplained(problem, replace(found, weights=plain.weights))
        usual = special.chdtri(redundancy, 0.5)  # a pose with more surplus has larger squares
        size = np.sqrt(squares * np.median(usual) / usual)
        smallest = max(0.3 * spread_of(squares, redundancy), problem.floor)
        if not np.isfinite(smallest):  # half of the poses have no value
            break
        wanted = np.sqrt(smallest / np.maximum(size, smallest))
        if np.abs(wanted - share).max() < _SETTLED:
            break
        share, weights = wanted, plain.weights.copy()
        problem.of_poses(weights)[:] *= share[:, None]
        found = fit(problem, found.theta, found.poses, weights, settings=QUICK)
    return replace(found, weights=plain.weights)


def _best_of_parts(
    problem: CalibrationProblem, reweighted: PoseFit, start: PoseFit, seed: int, progress: Progress
) -> PoseFit:
    """Return the fit whose best poses have the smallest residuals, of *reweighted* and fits of random parts."""
    count, surplus = problem.poses, int(problem.row_counts.min()) - problem.unknowns_per_pose
    smallest = -(-(len(reweighted.theta) - gauge_size(problem) + _LEFT_OVER) // surplus)
    kept = max(-(-_KEPT * count // 100), smallest)
    if kept >= count:
        return reweighted
    rng, groups = np.random.default_rng(seed), _alike(problem)
    best, size = reweighted, _trimmed(problem, reweighted, kept, groups)[0]
    many = kept > _MANY * smallest
    parts = [_drawn(rng, groups, min(smallest, kept)) for _ in range(_PARTS[many])]
    if many or problem.elastic:
        parts = _screened(problem, reweighted, parts, kept, groups)
    for part, chosen in enumerate(parts):
        progress("gross errors, parts of the poses", part, len(parts))
        found, trimmed = _concentrated(problem, (start, reweighted)[part % 2], chosen, kept, groups)
        if trimmed < size:
            best, size = replace(reweighted, theta=found.theta, poses=found.poses), trimmed
    return best


def _concentrated(
    problem: CalibrationProblem, found: PoseFit, chosen: _Poses, kept: int, groups: list[_Poses]
) -> tuple[PoseFit, float]:
    """Return the fit of the *kept* poses that fit best, from those *chosen* on, and their sum of squares."""
    trimmed = np.inf
    for _ in range(_CONCENTRATIONS):
        weights = problem.weights.copy()
        problem.of_poses(weights)[~np.isin(np.arange(problem.poses), chosen)] = 0.0
        found = fit(problem, found.theta, found.poses, weights, settings=QUICK)
        if not np.isfinite(found.cost):
            break
        found = replace(found, poses=fitted_poses(problem, found.theta, found.poses))
        before, (trimmed, order) = trimmed, _trimmed(problem, found, kept, groups)
        if set(order[:kept].tolist()) == set(chosen.tolist()) or not trimmed < before:
            break
        chosen = order[:kept]
    return found, trimmed


def _screened(
    problem: CalibrationProblem, found: PoseFit, parts: list[_Poses], kept: int, groups: list[_Poses]
) -> list[_Poses]:
    """Return the sets of poses at which the best parts end, by linear equations at the fit *found*."""
    rows = problem.derivatives(found.theta, found.poses, problem.weights)
    off, reduced, _ = projected(rows)
    ended = []
    for part in parts:
        chosen, trimmed = part, np.inf
        for _ in range(_CONCENTRATIONS):
            left = np.concatenate([reduced[chosen].reshape(-1, reduced.shape[-1]), rows.others_by_unknown])
            change = np.linalg.lstsq(left, -np.append(off[chosen].ravel(), rows.others), rcond=1e-9)[0]
            squares = np.sum((off + reduced @ change) ** 2, axis=1)
            order = _in_order(squares, groups)
            chosen, trimmed = np.sort(order[:kept]), float(squares[order[:kept]].sum())
        ended.append((trimmed, tuple(chosen.tolist())))
    return [np.array(chosen) for _, chosen in sorted(set(ended))[:_BEST]]


def _alike(problem: CalibrationProblem) -> list[_Poses]:
    """Return groups of poses with as many rows: those that have a measured position, say, and those that have none."""
    rows = problem.row_counts
    return [np.flatnonzero(rows == each) for each in np.unique(rows)]


def _drawn(rng: np.random.Generator, groups: list[_Poses], size: int) -> _Poses:
    """Return about *size* random poses, as many of each group as is its share, but some of each."""
    total = sum(map(len, groups))
    shares = [min(len(group), max(_EACH, -(-size * len(group) // total))) for group in groups]
    if len(groups) == 1:
        shares = [size]
    return np.concatenate(
        [rng.choice(group, share, replace=False) for group, share in zip(groups, shares, strict=True)]
    )


def _trimmed(problem: CalibrationProblem, found: PoseFit, kept: int, groups: list[_Poses]) -> tuple[float, _Poses]:
    """Return the unexplained sum of squares of the *kept* best poses, and all poses in order of theirs in *groups*."""
    if not problem.is_finite(found.theta, found.poses):  # a pose of weight 0 is inside a sheave
        return np.inf, np.arange(problem.poses)
    off, _, _ = projected(problem.derivatives(found.theta, found.poses, problem.weights))
    squares = np.sum(off * off, axis=1)
    order = _in_order(squares, groups)
    return float(squares[order[:kept]].sum()), order


def _in_order(squares: Array, groups: list[_Poses]) -> _Poses:
    """Return all poses by their place in the order of *squares* (N,) within their group."""
    place = np.zeros(len(squares))
    for group in groups:
        place[group[np.argsort(squares[group])]] = (np.arange(len(group)) + 0.5) / len(group)
    return np.argsort(place, kind="stable")
