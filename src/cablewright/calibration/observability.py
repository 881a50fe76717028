"""What the data decide and what they do not: rank, open freedoms in words, sigmas, and what to measure next.

Poses are eliminated by orthogonal projection, not by the normal equations: small singular values keep their digits.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array, Mask
from cablewright.calibration.fixed import tilt_rows
from cablewright.calibration.problem import CalibrationProblem, Derivatives
from cablewright.calibration.unknowns import Unknown
from cablewright.robot import Robot
from cablewright.robot.parameter_values import AXES

_NULL: Final = 1e-9
"""Singular values under this share of the largest are zero: rounding leaves 1e-15, the faintest sheave 1e-6."""

_ALIKE: Final = 0.9
"""A direction that has this much in common with a named motion bears its name."""

_WEAKEST: Final = 3
_SURVEYED: Final = 1e-3  # m: of a suggested distance or surveyed point
_LEVEL: Final = 1e-3  # rad: of a suggested level
_MAX_PAIRS: Final = 28
_TILTS: Final = ("tilt about x", "tilt about y")


@dataclass(frozen=True)
class Direction:
    """A combination of unknowns and how well it is known: `sigma` in m (of all exit points together) or as told.

    `unit` is that of the largest part, or rad.
    """

    words: str
    sigma: float
    unit: str
    vector: tuple[float, ...]  # (k,) of length 1


@dataclass(frozen=True)
class Suggestion:
    """One more measurement: what the sigmas of exit points would be with it, m, and how many freedoms stay open."""

    words: str
    before: float  # m, root mean square over coordinates of exit points, in the inner constraint of each
    after: float
    open_before: int
    open_after: int


@dataclass(frozen=True, eq=False)
class Information:
    """What the data say of the unknowns, with the poses eliminated, at sigma as the weights have it.

    `rows` (r, k): its Gram matrix is the information. `null` (k, d): an orthonormal basis of what stays open. `rank`
    counts poses too, as `total` does.
    """

    robot: Robot
    unknowns: tuple[Unknown, ...]
    exits: Array  # (m, 3) m, where the exit points were found
    rows: Array
    null: Array
    rank: int
    total: int
    measurements: int
    covariance: Array  # (k, k), in the inner constraint of what is open

    @property
    def redundancy(self) -> int:
        """How many measurements there are beyond those that decide."""
        return self.measurements - self.rank


def projected(found: Derivatives) -> tuple[Array, Array, NDArray[np.int64]]:
    """What is left of residuals (N, r) and derivatives (N, r, k) once each pose fits best, and the poses' ranks (N,).

    r = e where poses may be undecided: rows that a pose explains are zero.
    """
    left, values, _ = np.linalg.svd(found.by_pose, full_matrices=True)
    count, e, _ = found.by_pose.shape
    largest = values.max(axis=1, initial=0.0, keepdims=True)
    kept = np.zeros((count, e), dtype=bool)
    kept[:, : values.shape[1]] = values > _NULL * np.maximum(largest, 1e-300)
    free = np.swapaxes(left, 1, 2) * ~kept[:, :, None]
    return (
        np.einsum("nre,ne->nr", free, found.residual),
        np.einsum("nre,nek->nrk", free, found.by_unknown),
        kept.sum(axis=1),
    )


def information(
    problem: CalibrationProblem, theta: Array, poses: Array, weights: Array, priors: bool = False
) -> Information:
    """Information at a solution. Rows of weight 0 do not count, nor poses all of whose rows have it.

    *priors* says whether what was known before counts.
    """
    found = problem.balanced(theta, poses).derivatives(theta, poses, weights)
    if not priors:
        found = replace(
            found,
            others=found.others[~problem.is_prior],
            others_by_unknown=found.others_by_unknown[~problem.is_prior],
        )
    unknowns = tuple(each for each, held in zip(problem.unknowns, problem.held, strict=True) if not held)
    used = problem.of_poses(weights) > 0.0
    return information_of(found, problem.robot, unknowns, problem.exit_points(theta), used)


def information_of(
    found: Derivatives, robot: Robot, unknowns: tuple[Unknown, ...], exits: Array, used: Mask
) -> Information:
    """Information of equations whose own unknowns, at each pose, are eliminated; *used* (N, e) says which count."""
    _, reduced, ranks = projected(found)
    rows = _triangle(np.concatenate([reduced.reshape(-1, reduced.shape[-1]), found.others_by_unknown]))
    alive = used.any(axis=1)
    values, right = _spectrum(rows)
    kept = _kept(values)
    inverse = right[kept].T / values[kept]
    return Information(
        robot,
        unknowns,
        exits,
        rows,
        right[~kept].T,
        int(ranks[alive].sum() + kept.sum()),
        rows.shape[1] + int(alive.sum()) * found.by_pose.shape[2],
        int(used.sum()) + len(found.others_by_unknown),
        inverse @ inverse.T,
    )


def _triangle(rows: Array) -> Array:
    """At most k rows with the same Gram matrix."""
    return rows if len(rows) <= rows.shape[1] else np.asarray(np.linalg.qr(rows, mode="r"))


def _spectrum(rows: Array) -> tuple[Array, Array]:
    """Singular values (k,) and right vectors (k, k); values are zero where there are too few rows."""
    k = rows.shape[1]
    padded = np.concatenate([rows, np.zeros((max(0, k - len(rows)), k))])
    _, values, right = np.linalg.svd(padded, full_matrices=False)
    return values, right


def _motions(found: Information) -> dict[str, Array]:
    """Motions of everything that no encoder sees, or hardly: by name, what they do to the unknowns (k,)."""
    arms = found.exits - found.exits.mean(axis=0)
    moves = {f"translation along {axis}": np.tile(np.eye(3)[k], (len(arms), 1)) for k, axis in enumerate(AXES)}
    moves |= {
        name: np.cross(np.eye(3)[k], arms) for name, k in (("yaw", 2), *((tilt, k) for k, tilt in enumerate(_TILTS)))
    }
    names = [line.name for line in found.robot.lines]
    motions = {name: np.zeros(len(found.unknowns)) for name in moves}
    for at, each in enumerate(found.unknowns):
        if each.name == "exit_point":
            for name, move in moves.items():
                motions[name][at] = move[names.index(each.line or ""), each.axis or 0]
    return {name: motion for name, motion in motions.items() if motion.any()}


def open_freedoms(found: Information) -> tuple[str, ...]:
    """The open freedoms in words: named motions first, then combinations of unknowns."""
    null, words = found.null, []
    for name, vector in _motions(found).items():
        unit = vector / np.linalg.norm(vector)
        if np.linalg.norm(null.T @ unit) > 1.0 - 1e-6 and null.shape[1]:
            words.append(name)
            null = _without(null, unit)
    return (*words, *(_combination(found.unknowns, null[:, d]) for d in range(null.shape[1])))


def _without(basis: Array, unit: Array) -> Array:
    """The part of an orthonormal *basis* that is orthogonal to a *unit* vector in it."""
    left, values, _ = np.linalg.svd(basis - np.outer(unit, unit @ basis), full_matrices=False)
    return np.asarray(left[:, values > 0.5])


def _combination(unknowns: Sequence[Unknown], vector: Array) -> str:
    """The largest parts of a combination, in words."""
    order = np.argsort(-np.abs(vector))[:3]
    sign = np.sign(vector[order[0]])
    return ", ".join(f"{sign * vector[at]:+.2f} {unknowns[at].label}" for at in order if abs(vector[at]) > 0.05)


def weakest(found: Information) -> tuple[Direction, ...]:
    """The least known combinations that are not open, the worst first."""
    values, right = _spectrum(found.rows)
    motions = _motions(found)
    tilts = np.array([_rest(found, motions[name]) for name in _TILTS if name in motions]).reshape(-1, right.shape[1])
    sizes = np.linalg.norm(tilts, axis=1)
    directions = []
    for at in np.flatnonzero(_kept(values))[::-1][:_WEAKEST]:
        vector, sigma = right[at], 1.0 / float(values[at])
        unit = found.unknowns[int(np.argmax(np.abs(vector)))].unit
        told = Direction(_combination(found.unknowns, vector), sigma, unit, tuple(map(float, vector)))
        if len(tilts) == 2 and (sizes > 0.5 * np.linalg.norm(motions[_TILTS[0]])).all():
            turn = np.linalg.lstsq(tilts.T, vector, rcond=None)[0]
            if np.linalg.norm(turn @ tilts) > _ALIKE:
                azimuth = np.degrees(np.arctan2(turn[1], turn[0])) % 180.0
                words = f"tilt about the horizontal axis at {azimuth:.0f} deg from x"
                told = replace(told, words=words, sigma=sigma * float(np.linalg.norm(turn)), unit="rad")
        directions.append(told)
    return tuple(directions)


def _rest(found: Information, vector: Array) -> Array:
    """A motion without what of it is open."""
    return np.asarray(vector - found.null @ (found.null.T @ vector))


def _kept(values: Array) -> Mask:
    """Which singular values are not zero."""
    return np.asarray(values > _NULL * max(values.max(initial=0.0), 1e-300))


def suggestions(found: Information, scale: float) -> tuple[Suggestion, ...]:
    """What one more measurement would bring, the most helpful first; *scale* is sigma over that of the weights.

    All of it is computed from the information: rows of the measurement are added to it. Sigmas before and after are in
    one frame, the inner constraint of what is open without the measurement.
    """
    exits = [at for at, each in enumerate(found.unknowns) if each.name == "exit_point"]
    if not exits:
        return ()
    before, open_before = _spread(found.rows / scale, found.null, exits)
    made = []
    for words, rows in _measurements(found):
        after, open_after = _spread(np.concatenate([found.rows / scale, rows]), found.null, exits)
        made.append(Suggestion(words, before, after, open_before, open_after))
    return tuple(sorted(made, key=lambda each: (each.after * (1 + each.open_after), each.after)))


def _spread(rows: Array, null: Array, exits: Sequence[int]) -> tuple[float, int]:
    """Root mean square sigma over *exits*, m, without motions in *null*; and the number of open freedoms."""
    values, right = _spectrum(rows)
    kept = _kept(values)
    inverse = right[kept].T / values[kept]
    inverse = inverse - null @ (null.T @ inverse)
    variances = np.sum(inverse * inverse, axis=1)[list(exits)]
    return float(np.sqrt(variances.mean())), int((~kept).sum())


def _measurements(found: Information) -> Iterator[tuple[str, Array]]:
    """Yield measurements one could add, in words, with their weighted rows."""
    robot, unknowns = found.robot, found.unknowns
    known = {(each.line, each.axis): at for at, each in enumerate(unknowns) if each.name == "exit_point"}
    lines = [line for line in robot.lines if all((line.name, axis) in known for axis in range(3))]
    if all((line.name, 2) in known for line in robot.lines):
        yield f"exit points levelled, {_LEVEL * 1e3:g} mrad", tilt_rows(robot, unknowns) / _LEVEL

    def point(line_name: str) -> Array:
        return np.array([np.eye(len(unknowns))[known[line_name, axis]] for axis in range(3)]) / _SURVEYED

    if lines:
        name = lines[0].name
        yield f"the exit point of {name} surveyed, {_SURVEYED * 1e3:g} mm", point(name)
    if len(lines) >= 3:
        rows = np.concatenate([point(line.name) for line in lines[:3]])
        listed = ", ".join(line.name for line in lines[:3])
        yield f"three exit points surveyed ({listed}), {_SURVEYED * 1e3:g} mm", rows
    if len(lines) >= 2:
        names = [line.name for line in robot.lines]
        for a, b in list(combinations(lines, 2))[:_MAX_PAIRS]:
            apart = found.exits[names.index(a.name)] - found.exits[names.index(b.name)]
            row = np.zeros((1, len(unknowns)))
            for axis in range(3):
                row[0, known[a.name, axis]] = apart[axis]
                row[0, known[b.name, axis]] = -apart[axis]
            words = f"the distance from exit point {a.name} to {b.name}, {_SURVEYED * 1e3:g} mm"
            yield words, row / (max(float(np.linalg.norm(apart)), 1e-12) * _SURVEYED)
