"""Gross errors: found after a plain fit by re-weighting, then tested one by one against all other poses."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from cablewright.arrays import Array, Mask
from cablewright.calibration.checks import gauge_size
from cablewright.calibration.kinds import idle
from cablewright.calibration.observability import information, projected
from cablewright.calibration.pose_fit import QUICK, PoseFit, fit, fitted_poses
from cablewright.calibration.problem import CalibrationProblem
from cablewright.kernels.fitting import calibration_residuals
from cablewright.progress import Progress, silent

_FALSE_ALARM: Final = 0.003
"""Probability that a calibration without gross errors rejects anything."""

_ROUNDS: Final = 12  # of re-weighting
_SETTLING: Final = 12  # max rounds of testing
_EXACT: Final = 1e-8  # m: smaller residuals are no gross errors, however small the others are
_PARTS: Final = (40, 12)  # random parts of the poses, with few redundant poses and with many
_CONCENTRATIONS: Final = 4
_MANY: Final = 3  # times the poses of a part: with more, re-weighting seldom fails
_KEPT: Final = 75  # percent of the poses, the best ones, by whose residuals parts are compared
_EACH: Final = 4  # min poses of a group in a part: with three known places nothing is open
_LEFT_OVER: Final = 5  # redundant measurements in a part
_NAMED: Final = 3.0  # max excess, over its limit, of a pose without the reading that is named
_CONTACTS: Final = {calibration_residuals.PLANE: "plane", calibration_residuals.REACH: "range"}
_TESTABLE: Final = 10  # min redundant measurements of a search: with fewer, noise looks like errors
_TESTED: Final = 5  # min redundant measurements that are left after it
_TOO_MANY: Final = 0.4  # share of rejected poses beyond which the model is wrong, not the data


@dataclass(frozen=True)
class Rejected:
    """A pose (counted from 0) left out, or one `sensor` of it if the others single it out; `size`: its error.

    `sensor`: "encoder" of a `line` (m) or, with elastic lines, "tension" (N), "position", "plane" or "range" (m); None
    for a whole pose. `measured` and `expected`: its readings, and what the others predict; encoders' of a whole pose.
    """

    pose: int
    line: str | None
    size: float
    sensor: str | None = "encoder"
    measured: tuple[float, ...] = ()
    expected: tuple[float, ...] = ()

    @property
    def unit(self) -> str:
        """Of the size: m or N."""
        return "N" if self.sensor == "tension" else "m"


def without_outliers(
    problem: CalibrationProblem, plain: PoseFit, start: PoseFit, seed: int, progress: Progress = silent
) -> tuple[PoseFit, tuple[Rejected, ...]]:
    """Fit again without gross errors. *plain*: a fit of all rows; *start*: a start for fits of parts of them.

    The surplus of a pose, its rows less its freedoms, limits what can be found: with 1, that the pose has an error;
    with more, in which line. With too few redundant measurements there is no search.
    """
    whole = problem
    vague = idle(problem, plain)
    if vague.any():  # they would count as surplus that always fits
        weights = problem.weights.copy()
        problem.of_poses(weights)[vague] = 0.0
        problem = replace(problem, weights=weights)
        full, plain = plain, replace(plain, weights=weights)
    else:
        full = plain
    if _redundancy(problem, plain) < _TESTABLE:
        return full, ()
    robust = _best_of_parts(problem, _reweighted(problem, plain), start, seed, progress)
    squares, surplus = _unexplained(problem, robust, robust.weights)
    spread = max(_spread(squares, surplus), _floor(problem))
    bad = squares > spread**2 * stats.chi2.isf(_FALSE_ALARM / len(squares), np.maximum(surplus, 1))
    found, rows = robust, np.zeros((problem.poses, problem.per_pose), dtype=bool)
    for _ in range(_SETTLING):
        if bad.mean() > _TOO_MANY:
            return full, ()
        squares, surplus = _unexplained(problem, found, found.weights)
        rows = _rows_of(problem, found, bad, max(_spread(squares[~bad], surplus[~bad]), _floor(problem)))
        weights = _weights_without(problem, rows)
        again = fit(problem, found.theta, found.poses, weights)
        found = replace(plain, theta=again.theta, poses=again.poses, weights=weights, cost=again.cost, code=again.code)
        rejected = _tested(problem, found, plain.weights, bad)
        if np.array_equal(rejected, bad):
            break
        bad = rejected
    if rows.any() and _redundancy(problem, found) < _TESTED:
        return full, ()
    if not rows.any():  # all rows count in both fits: return the better one
        better = found.cost < plain.cost
        return (fit_of(whole, found, whole.weights) if better else full), ()
    found = fit_of(whole, found, _weights_without(whole, rows))
    return found, tuple(_rejected(whole, found, rows))


def _redundancy(problem: CalibrationProblem, found: PoseFit) -> int:
    return information(problem, found.theta, found.poses, found.weights, priors=True).redundancy


def fit_of(problem: CalibrationProblem, found: PoseFit, weights: Array) -> PoseFit:
    """Return the fit from another one with other *weights* (R,)."""
    if np.array_equal(found.weights, weights):
        return found
    again = fit(problem, found.theta, found.poses, weights)
    return replace(found, theta=again.theta, poses=again.poses, weights=weights, cost=again.cost, code=again.code)


def _unexplained(problem: CalibrationProblem, found: PoseFit, weights: Array) -> tuple[Array, NDArray[np.int64]]:
    """Return the sum of squares (N,) of each pose that no change of the pose explains, and its surplus of rows (N,)."""
    off, _, ranks = projected(problem.derivatives(found.theta, found.poses, weights))
    return np.sum(off * off, axis=1), _counts(problem) - ranks


def _weights_without(problem: CalibrationProblem, rows: Mask) -> Array:
    """Return the weights (R,) with those of *rows* (N, e), or of whole poses (N,), set to 0."""
    weights = problem.weights.copy()
    problem.of_poses(weights)[rows] = 0.0
    return weights


def _counts(problem: CalibrationProblem) -> NDArray[np.int64]:
    """Return the number of rows of each pose (N,)."""
    return np.asarray((problem.of_poses(problem.weights) > 0.0).sum(axis=1))


def _spread(squares: Array, surplus: NDArray[np.int64]) -> float:
    """Return the sigma of a row over that of its weight, from the median over poses: a few outliers cannot move it."""
    return float(np.sqrt(np.median(squares / stats.chi2.median(np.maximum(surplus, 1)))))


def _floor(problem: CalibrationProblem) -> float:
    """Return the min of `_spread`, for data without noise."""
    return _EXACT / problem.encoder_sigma


def _reweighted(problem: CalibrationProblem, plain: PoseFit) -> PoseFit:
    """Return the fit with poses re-weighted by 1 / |unexplained residuals|: a few bad ones hardly count."""
    found = plain
    for _ in range(_ROUNDS):
        squares, surplus = _unexplained(problem, found, plain.weights)
        usual = stats.chi2.median(np.maximum(surplus, 1))  # a pose with more surplus has larger squares
        size = np.sqrt(squares * np.median(usual) / usual)
        smallest = max(0.3 * _spread(squares, surplus), _floor(problem))
        weights = plain.weights.copy()
        problem.of_poses(weights)[:] *= np.sqrt(smallest / np.maximum(size, smallest))[:, None]
        found = fit(problem, found.theta, found.poses, weights)
    return replace(found, weights=plain.weights)


def _best_of_parts(
    problem: CalibrationProblem, reweighted: PoseFit, start: PoseFit, seed: int, progress: Progress
) -> PoseFit:
    """Return the fit whose best poses have the smallest residuals, of *reweighted* and fits of random parts of poses.

    Least trimmed squares (Rousseeuw, Van Driessen 2006): with few redundant poses, gross errors move a plain fit so far
    that no re-weighting brings it back, while a part of the poses without them has the right answer.
    """
    count, surplus = problem.poses, int(_counts(problem).min()) - problem.unknowns_per_pose
    decided = len(reweighted.theta) - gauge_size(problem)
    smallest = -(-(decided + _LEFT_OVER) // surplus)
    kept = max(-(-_KEPT * count // 100), smallest)
    if kept >= count:
        return reweighted
    rng, groups = np.random.default_rng(seed), _alike(problem)
    best, size = reweighted, _trimmed(problem, reweighted, kept, groups)[0]
    parts = _PARTS[kept > _MANY * smallest]
    for part in range(parts):
        progress("gross errors, parts of the poses", part, parts)
        found = (start, reweighted)[part % 2]
        chosen = _drawn(rng, groups, min(smallest, kept))
        trimmed = np.inf
        for _ in range(_CONCENTRATIONS):
            weights = _weights_without(problem, ~np.isin(np.arange(count), chosen))
            found = fit(problem, found.theta, found.poses, weights, settings=QUICK)
            if not np.isfinite(found.cost):
                break
            found = replace(found, poses=fitted_poses(problem, found.theta, found.poses))
            trimmed, order = _trimmed(problem, found, kept, groups)
            chosen = order[:kept]
        if trimmed < size:
            best, size = replace(reweighted, theta=found.theta, poses=found.poses), trimmed
    return best


def _alike(problem: CalibrationProblem) -> list[NDArray[np.int64]]:
    """Return groups of poses with as many rows: those that have a measured position, say, and those that have none."""
    counts = _counts(problem)
    return [np.flatnonzero(counts == each) for each in np.unique(counts)]


def _drawn(rng: np.random.Generator, groups: list[NDArray[np.int64]], size: int) -> NDArray[np.int64]:
    """Return about *size* random poses, as many of each group as is its share, but some of each."""
    total = sum(map(len, groups))
    shares = [min(len(group), max(_EACH, -(-size * len(group) // total))) for group in groups]
    if len(groups) == 1:
        shares = [size]
    return np.concatenate(
        [rng.choice(group, share, replace=False) for group, share in zip(groups, shares, strict=True)]
    )


def _trimmed(
    problem: CalibrationProblem, found: PoseFit, kept: int, groups: list[NDArray[np.int64]]
) -> tuple[float, NDArray[np.int64]]:
    """Return the unexplained sum of squares of the *kept* best poses, and all poses in order of theirs in *groups*."""
    if not problem.is_finite(found.theta, found.poses):  # a pose of weight 0 is inside a sheave
        return np.inf, np.arange(problem.poses)
    squares, _ = _unexplained(problem, found, problem.weights)
    place = np.zeros(len(squares))
    for group in groups:
        place[group[np.argsort(squares[group])]] = (np.arange(len(group)) + 0.5) / len(group)
    order = np.argsort(place, kind="stable")
    return float(squares[order[:kept]].sum()), order


def _tested(problem: CalibrationProblem, found: PoseFit, weights: Array, bad: Mask) -> Mask:
    """Return which poses (N,) an F test rejects, each against all others, at a level shared by all poses."""
    off, reduced, ranks = projected(problem.derivatives(found.theta, found.poses, weights))
    kept = problem.derivatives(found.theta, found.poses, found.weights)
    own, own_reduced, own_ranks = projected(kept)
    by_unknown = np.concatenate([own_reduced.reshape(-1, own_reduced.shape[-1]), kept.others_by_unknown])
    covariance = np.linalg.pinv(by_unknown.T @ by_unknown, rcond=1e-13, hermitian=True)
    k = np.linalg.matrix_rank(covariance, tol=1e-13 * np.abs(covariance).max(), hermitian=True)
    used = problem.of_poses(found.weights) > 0.0
    freedom = max(int(used.sum() - own_ranks.sum() - k), 1)
    total = max(float(np.sum(own * own)), freedom * _floor(problem) ** 2)
    rejected, counts = np.zeros(len(off), dtype=bool), _counts(problem)
    for j, (rest, rows) in enumerate(zip(off, reduced, strict=True)):
        surplus = int(counts[j] - ranks[j])
        if surplus < 1:
            continue
        shared = rows @ covariance @ rows.T
        if bad[j]:
            square, others, left = rest @ np.linalg.solve(np.eye(len(rest)) + shared, rest), total, freedom
        else:
            square = rest @ np.linalg.pinv(np.eye(len(rest)) - shared, rcond=1e-9, hermitian=True) @ rest
            others, left = max(total - square, 0.0), max(freedom - surplus, 1)
        variance = max(others / left, _floor(problem) ** 2)
        rejected[j] = square / (surplus * variance) > stats.f.isf(_FALSE_ALARM / len(off), surplus, left)
    return rejected


def _rows_of(problem: CalibrationProblem, found: PoseFit, bad: Mask, spread: float) -> Mask:
    """Return the rows (N, e) to leave out: those of the one reading that explains a bad pose, else all of the pose."""
    rows = np.zeros(problem.of_poses(problem.weights).shape, dtype=bool)
    derivatives = problem.derivatives(found.theta, found.poses)
    _, _, ranks = projected(derivatives)
    if not np.isfinite(derivatives.by_pose[bad]).all():
        rows[bad] = True
        return rows
    left, _, _ = np.linalg.svd(derivatives.by_pose[bad], full_matrices=True)
    readings, counts = _readings(problem), _counts(problem)
    level = _FALSE_ALARM / len(bad)
    for own, j in zip(left, np.flatnonzero(bad), strict=True):
        surplus = int(counts[j] - ranks[j])
        free = own[:, ranks[j] :]
        rest = free.T @ derivatives.residual[j]
        excess = []
        for reading in readings:
            part = free[reading.rows]
            left_over = surplus - np.linalg.matrix_rank(part, tol=1e-6)
            if left_over < 1:  # nothing would test it
                excess.append(np.inf)
                continue
            remains = rest @ rest - rest @ (np.linalg.pinv(part, rcond=1e-9) @ (part @ rest))
            excess.append(remains / (spread**2 * stats.chi2.isf(level, left_over)))
        order = np.argsort(excess)
        if surplus >= 2 and excess[order[0]] < _NAMED and excess[order[1]] > 1.0:
            rows[j, readings[order[0]].rows] = True
        else:
            rows[j] = True
    return rows


@dataclass(frozen=True)
class _Reading:
    """Rows of a pose that fail together."""

    rows: slice
    sensor: str
    line: str | None


def _readings(problem: CalibrationProblem) -> list[_Reading]:
    """Return what of a pose may be wrong alone: an encoder, with elastic lines a load cell, a position, a contact."""
    lines, kinds = problem.robot.lines, problem.rows.kind[: problem.per_pose].tolist()
    found, at = [], 0
    while at < len(kinds):
        kind, size = kinds[at], 1
        line = lines[int(problem.rows.line[at])].name
        if kind in (calibration_residuals.ENCODER, calibration_residuals.PAID_OUT):
            found.append(_Reading(slice(at, at + 1), "encoder", line))
        elif kind == calibration_residuals.TENSION:
            found.append(_Reading(slice(at, at + 1), "tension", line))
        elif kind == calibration_residuals.COORDINATE:
            size = problem.robot.n
            found.append(_Reading(slice(at, at + size), "position", None))
        elif kind in _CONTACTS:
            found.append(_Reading(slice(at, at + 1), _CONTACTS[kind], None))
        at += size
    return found


def _rejected(problem: CalibrationProblem, found: PoseFit, rows: Mask) -> Iterator[Rejected]:
    """Yield what the *rows* (N, e) left out are of, their errors, and what the others predict."""
    theta, out = found.theta, rows.any(axis=1)
    fitted = fitted_poses(problem, theta, found.poses)  # those left out at their own best place
    derivatives, own = problem.derivatives(theta, found.poses), problem.derivatives(theta, fitted)
    off, _, _ = projected(own)
    counts, best = problem.counts_at(theta, found.poses), problem.counts_at(theta, fitted)
    weights, values = problem.of_poses(problem.weights), problem.of_poses(problem.values)
    readings = _readings(problem)
    for j in np.flatnonzero(out):
        if rows[j].all():
            read, wanted = problem.measured.counted[j], best[j]
            size = float(np.linalg.norm(off[j])) * problem.encoder_sigma
            yield Rejected(int(j), None, size, None, tuple(read.tolist()), tuple(wanted.tolist()))
            continue
        reading = next(each for each in readings if rows[j, each.rows].any())
        at, place = reading.rows, reading.rows.start
        error = derivatives.residual[j, at] / np.maximum(weights[j, at], 1e-300)
        if reading.sensor == "encoder":
            read, wanted = problem.measured.counted[j, place : place + 1], counts[j, place : place + 1]
        else:
            read, wanted = values[j, at], values[j, at] + error
        shown = (read[:3], wanted[:3]) if reading.sensor == "position" else (read, wanted)
        size = float(np.linalg.norm(error[:3]))
        yield Rejected(int(j), reading.line, size, reading.sensor, *(tuple(map(float, each)) for each in shown))
