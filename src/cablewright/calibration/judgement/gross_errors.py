"""Gross errors: found after a plain fit by fits that they cannot move, then tested against all other poses.

Noise alone seldom rejects any: these are F tests, with the level shared out. A pose is tested by the residuals that its
degrees of freedom do not explain. A set of poses is the worst of all sets of its size, so its level is divided by their
number (Bonferroni): the false alarms of a whole file are at most `FALSE_ALARM`, to first order.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import special

from cablewright.calibration.judgement.robust_fit import robust_fit, spread_of, unexplained
from cablewright.calibration.judgement.sigmas import evened
from cablewright.calibration.measurement_rows.measurement_kinds import KINDS
from cablewright.calibration.poses.fit import PoseFit, fitted_poses, refit
from cablewright.calibration.poses.observability import information, projected
from cablewright.calibration.poses.problem import CalibrationProblem
from cablewright.calibration.sightings.detection import EDGES
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.progress import Progress, silent

FALSE_ALARM: Final = 0.003
"""Probability that a calibration without gross errors rejects anything."""

_SETTLING: Final = 12  # max rounds of testing
_NAMED: Final = 3.0  # max excess, over its limit, of a pose without the reading that is named
_TESTABLE: Final = 10  # min redundant measurements of a search: with fewer, noise looks like errors
_TESTED: Final = 5  # min redundant measurements that are left after it
_TOO_MANY: Final = 0.4  # share of rejected poses beyond which the model is wrong, not the data


@dataclass(frozen=True, eq=False)
class Unexplained:
    """Residuals of each pose that no change of the pose explains, at a fit without the poses `out`.

    Each row has sigma 1 or less: the weights are those of `sigmas.evened`.
    """

    off: Array  # (N, e)
    rows: Array  # (N, e, k)
    surplus: NDArray[np.int64]  # (N,)
    covariance: Array  # (k, k), of the unknowns by the poses that are not out
    out: Mask  # (N,)
    total: float  # sum of squares of the fit
    freedom: float  # the redundancy of its poses: their rows less what poses and unknowns take

    @classmethod
    def of(cls, problem: CalibrationProblem, found: PoseFit, out: Mask) -> Unexplained:
        """Return the unexplained residuals at a fit *found* without the poses *out*."""
        poses = found.poses
        if out.any():  # at the place that fits all its rows best, for the equations are linear only near it
            poses = np.where(out[:, None], fitted_poses(problem, found.theta, poses), poses)
        off, rows, ranks = projected(problem.derivatives(found.theta, poses))
        kept = problem.derivatives(found.theta, found.poses, found.weights)
        own, own_rows, own_ranks = projected(kept)
        by_unknown = np.concatenate([own_rows.reshape(-1, own_rows.shape[-1]), kept.others_by_unknown])
        covariance = np.linalg.pinv(by_unknown.T @ by_unknown, rcond=1e-13, hermitian=True)
        used = problem.of_poses(found.weights) > 0.0
        taken = float(np.sum((own_rows @ covariance) * own_rows))
        freedom = max(float(used.sum() - own_ranks.sum()) - taken, 1.0)
        return cls(off, rows, problem.row_counts - ranks, covariance, out, float(np.sum(own * own)), freedom)

    def rejected(self) -> Mask:
        """Return a mask (N,) of poses that an F test against all others rejects as gross errors."""
        return np.asarray(self._single > math.log(len(self.off) / FALSE_ALARM))

    @cached_property
    def _single(self) -> Array:
        """How improbable each pose (N,) is: minus the logarithm of the probability of as much by noise."""
        return np.array([self._one(j) for j in range(len(self.off))])

    def _one(self, j: int) -> float:
        surplus, rest, rows = int(self.surplus[j]), self.off[j], self.rows[j]
        if surplus < 1:
            return 0.0
        if not np.isfinite(rest).all():
            return math.inf
        if self.out[j]:
            return self._improbable(self._predicted(np.array([j])), surplus, self.total, self.freedom)
        shared = np.eye(len(rest)) - rows @ self.covariance @ rows.T
        square = float(rest @ np.linalg.pinv(shared, rcond=1e-9, hermitian=True) @ rest)
        return self._improbable(square, surplus, max(self.total - square, 0.0), max(self.freedom - surplus, 1.0))

    def _predicted(self, poses: NDArray[np.int64]) -> float:
        """Return the sum of squares of poses that are out, over what the others predict of them together."""
        rest = self.off[poses].ravel()
        rows = self.rows[poses].reshape(len(rest), -1)
        return float(rest @ np.linalg.solve(np.eye(len(rest)) + rows @ self.covariance @ rows.T, rest))

    def _improbable(self, square: float, surplus: int, others: float, freedom: float) -> float:
        variance = max(others / freedom, 1.0)  # rows with a too large given sigma would make it small
        with np.errstate(divide="ignore"):  # what is too improbable for a number is infinitely so
            return -float(np.log(special.fdtrc(surplus, freedom, square / (surplus * variance))))

    def mistaken(self) -> NDArray[np.int64]:
        """Return the poses that were rejected although noise may explain them, as the worst of all sets of as many."""
        places = np.flatnonzero(self.out & (self.surplus > 0))
        places = places[np.argsort(self._single[places], kind="stable")]
        whole = np.isfinite(self.off[places]).all(axis=1)
        mistaken = 0
        for size in range(1, int(whole.sum()) + 1):
            left = len(self.off) - len(places) + size  # the worse ones are out anyway
            level = math.log(FALSE_ALARM / (size * (size + 1))) - _log_binomial(left, size)
            least = places[whole][:size]
            square, surplus = self._predicted(least), int(self.surplus[least].sum())
            if self._improbable(square, surplus, self.total, self.freedom) < -level:
                mistaken = size
        return places[whole][:mistaken]


def _log_binomial(of: int, size: int) -> float:
    """Return the logarithm of the number of sets of a size."""
    return float(special.gammaln(of + 1) - special.gammaln(size + 1) - special.gammaln(of - size + 1))


@dataclass(frozen=True)
class Rejected:
    """A pose (counted from 0) left out, or one `sensor` of it if the others single it out; `size`: its error.

    `sensor`: "encoder" of a `line` (m) or, with elastic lines, "tension" (N), "position", "plane" or "range" (m),
    "sighting" of a tag, which then is the `line` (px); None for a whole pose. `measured` and `expected`: its readings,
    and what the others predict; encoders' of a whole pose.
    """

    pose: int
    line: str | None
    size: float
    sensor: str | None = "encoder"
    measured: tuple[float, ...] = ()
    expected: tuple[float, ...] = ()

    @property
    def unit(self) -> str:
        """Unit of the size: m, N or px."""
        return {"tension": "N", "sighting": "px"}.get(self.sensor or "", "m")


def without_outliers(
    problem: CalibrationProblem, plain: PoseFit, start: PoseFit, seed: int, progress: Progress = silent
) -> tuple[PoseFit, tuple[Rejected, ...]]:
    """Fit again without gross errors. *plain*: a fit of all rows; *start*: a start for fits of parts of them.

    The surplus of a pose, its rows less its degrees of freedom, limits what can be found: with 1, that the pose has an
    error; with more, in which line. With too few redundant measurements there is no search. Kinds of measurements are
    weighted by the sigmas that their residuals show, not by the given ones: rows with a too large given sigma would
    always fit.
    """
    if _redundancy(problem, plain) < _TESTABLE:
        return plain, ()
    even, level = evened(problem, plain)
    robust = robust_fit(even, level, start, seed, progress)
    out = _suspects(even, robust)
    even, robust = evened(even, refit(even, robust, _weights_without(even, out)))  # what they add to sigmas is gone
    rows, found = _settled(even, robust, out)
    if rows is None or (rows.any() and _redundancy(even, found) < _TESTED):
        return plain, ()
    if rows.any():
        again = refit(problem, found, _weights_without(problem, rows))
        return again, tuple(_rejected(problem, again, rows))
    again = refit(problem, found, problem.weights)  # all rows count in both fits: return the better one
    return (again if again.cost < plain.cost else plain), ()


def _settled(problem: CalibrationProblem, robust: PoseFit, out: Mask) -> tuple[Mask | None, PoseFit]:
    """Return the rows (N, e) to leave out, and the fit without them; None for more than gross errors explain.

    *out*: the poses (N,) suspected at first.
    """
    rows, found = _left_out(problem, robust, out)
    for _ in range(_SETTLING):
        rejected = Unexplained.of(problem, found, out).rejected()
        if rejected.mean() > _TOO_MANY:
            return None, found
        if np.array_equal(rejected, out):
            break
        out = rejected
        rows, found = _left_out(problem, found, out)
    for _ in range(_SETTLING):
        mistaken = Unexplained.of(problem, found, out).mistaken()
        if not len(mistaken):
            break
        out = out.copy()
        out[mistaken] = False
        rows, found = _left_out(problem, found, out)
    return rows, found


def _suspects(problem: CalibrationProblem, robust: PoseFit) -> Mask:
    """Return which poses (N,) have large residuals at a fit that they did not move."""
    squares, redundancy = unexplained(problem, robust)
    spread = max(spread_of(squares, redundancy), problem.floor)
    return np.asarray(squares > spread**2 * special.chdtri(redundancy, FALSE_ALARM / len(squares)))


def _left_out(problem: CalibrationProblem, found: PoseFit, out: Mask) -> tuple[Mask, PoseFit]:
    """Return the rows (N, e) to leave out of the poses *out* (N,), and the fit without them."""
    squares, redundancy = unexplained(problem, found)
    kept = np.logical_not(out)
    spread = max(spread_of(squares[kept], redundancy[kept]), problem.floor) if kept.any() else np.inf
    rows = _rows_of(problem, found, out, spread)
    return rows, refit(problem, found, _weights_without(problem, rows))


def _redundancy(problem: CalibrationProblem, found: PoseFit) -> int:
    return information(problem, found.theta, found.poses, found.weights, priors=True).redundancy


def _weights_without(problem: CalibrationProblem, rows: Mask) -> Array:
    """Return the weights (R,) with those of *rows* (N, e), or of whole poses (N,), set to 0."""
    weights = problem.weights.copy()
    problem.of_poses(weights)[rows] = 0.0
    return weights


def _rows_of(problem: CalibrationProblem, found: PoseFit, bad: Mask, spread: float) -> Mask:
    """Return the rows (N, e) to leave out: those of the one reading that explains a bad pose, else all of the pose."""
    rows = np.zeros(problem.of_poses(problem.weights).shape, dtype=bool)
    derivatives = problem.derivatives(found.theta, found.poses)
    _, _, ranks = projected(derivatives)
    if not np.isfinite(derivatives.by_pose[bad]).all():
        rows[bad] = True
        return rows
    left, _, _ = np.linalg.svd(derivatives.by_pose[bad], full_matrices=True)
    readings, rows_each = _readings(problem), problem.row_counts
    level = FALSE_ALARM / len(bad)
    for own, j in zip(left, np.flatnonzero(bad), strict=True):
        surplus = int(rows_each[j] - ranks[j])
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
            excess.append(remains / (spread**2 * special.chdtri(left_over, level)))
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
    """Return what of a pose may be wrong alone: an encoder, with elastic lines a load cell, a position, a tag."""
    found, at = [], 0
    while at < problem.per_pose:
        reading = KINDS[int(problem.rows.kind[at])].reading
        of_line, size = reading in ("encoder", "tension"), {"position": problem.robot.freedoms, "sighting": EDGES}
        if reading:
            line = problem.robot.lines[int(problem.rows.line[at])].name if of_line else None
            if reading == "sighting" and problem.measured.sightings is not None:
                line = f"tag {problem.measured.sightings.tags[int(problem.rows.other[at]) - 1].number}"
            found.append(_Reading(slice(at, at + size.get(reading, 1)), reading, line))
        at += size.get(reading, 1)
    return found


def _rejected(problem: CalibrationProblem, found: PoseFit, rows: Mask) -> Iterator[Rejected]:
    """Yield what the *rows* (N, e) left out are of, their errors, and what the others predict."""
    theta, out = found.theta, rows.any(axis=1)
    fitted = fitted_poses(problem, theta, found.poses)  # those left out at their own best place
    derivatives, own = problem.derivatives(theta, found.poses), problem.derivatives(theta, fitted)
    off, _, _ = projected(own)
    expected, best = (problem.counts_at(theta, each, problem.given(theta, each)) for each in (found.poses, fitted))
    weights, values = problem.of_poses(problem.weights), problem.of_poses(problem.values)
    readings = _readings(problem)
    for j in np.flatnonzero(out):
        if rows[j].all():
            read, wanted = (each[j, list(problem.robot.hosts)] for each in (problem.measured.counted, best))
            size = float(np.linalg.norm(off[j])) * problem.encoder_sigma
            yield Rejected(int(j), None, size, None, tuple(read.tolist()), tuple(wanted.tolist()))
            continue
        reading = next(each for each in readings if rows[j, each.rows].any())
        at, place = reading.rows, reading.rows.start
        error = derivatives.residual[j, at] / np.maximum(weights[j, at], 1e-300)
        if reading.sensor == "encoder":
            shown = problem.measured.counted[j, place : place + 1], expected[j, place : place + 1]
        elif reading.sensor == "position":
            assert problem.measured.guess is not None
            error = _displacement(problem, int(j), at, error)
            shown = problem.measured.guess[j, :3], problem.measured.guess[j, :3] + error
        else:
            shown = values[j, at], values[j, at] + error
        size = float(np.linalg.norm(error))
        yield Rejected(int(j), reading.line, size, reading.sensor, *(tuple(map(float, each)) for each in shown))


def _displacement(problem: CalibrationProblem, pose: int, rows: slice, error: Array) -> Array:
    """Return the vector (3,) of the error of a measured position, m, from the errors of its *rows*."""
    if problem.robot.platform.plane is None:
        return error[:3]
    along = problem.rows.extra[pose * problem.per_pose : (pose + 1) * problem.per_pose][rows, :3]
    return np.asarray(error[:2] @ along[:2])
