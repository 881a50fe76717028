"""Gross errors: found after a plain fit by fits that they cannot move, then tested against all other poses."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy import special

from cablewright.arrays import Array, Mask
from cablewright.calibration.judgement.outlier_tests import FALSE_ALARM, Unexplained, counts, floor_of
from cablewright.calibration.judgement.robust_fit import robust_fit, spread_of, unexplained
from cablewright.calibration.judgement.sigmas import evened
from cablewright.calibration.poses.fit import PoseFit, fitted_poses, refit
from cablewright.calibration.poses.observability import information, projected
from cablewright.calibration.poses.problem import CalibrationProblem
from cablewright.kernels.fitting import calibration_residuals
from cablewright.progress import Progress, silent

_SETTLING: Final = 12  # max rounds of testing
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
    with more, in which line. With too few redundant measurements there is no search. Kinds of measurements count in it
    as their residuals say, not as their sigmas do: rows whose sigma is told too large would always fit.
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
    """Return which poses (N,) are far off at a fit that they did not move."""
    squares, redundancy = unexplained(problem, robust)
    spread = max(spread_of(squares, redundancy), floor_of(problem))
    return np.asarray(squares > spread**2 * special.chdtri(redundancy, FALSE_ALARM / len(squares)))


def _left_out(problem: CalibrationProblem, found: PoseFit, out: Mask) -> tuple[Mask, PoseFit]:
    """Return the rows (N, e) to leave out of the poses *out* (N,), and the fit without them."""
    squares, redundancy = unexplained(problem, found)
    kept = np.logical_not(out)
    spread = max(spread_of(squares[kept], redundancy[kept]), floor_of(problem)) if kept.any() else np.inf
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
    readings, rows_each = _readings(problem), counts(problem)
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
        elif kind in (calibration_residuals.COORDINATE, calibration_residuals.ALONG):
            size = problem.robot.freedoms
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
    expected, best = (problem.counts_at(theta, each, problem.given(theta, each)) for each in (found.poses, fitted))
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
    """Return the vector (3,) by which a measured position is off, m, from the errors of its *rows*."""
    if problem.robot.platform.plane is None:
        return error[:3]
    along = problem.rows.extra[pose * problem.per_pose : (pose + 1) * problem.per_pose][rows, :3]
    return np.asarray(error[:2] @ along[:2])
