"""Poses that may be measured next, and the choice among them, one by one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from cablewright.arrays import Array
from cablewright.calibration.guidance.known import Known
from cablewright.calibration.measured import Measured
from cablewright.calibration.plan import CalibrationPlan
from cablewright.calibration.poses.observability import projected
from cablewright.calibration.poses.problem import CalibrationProblem
from cablewright.calibration.poses.simulation import random_poses
from cablewright.calibration.sensors.positions import exit_rows
from cablewright.models.statics import Model
from cablewright.solvers.inverse import solve_inverse

_CANDIDATES: Final = 300
_MAX_MORE: Final = 60  # poses within which what is needed must be reached
_RIDGE: Final = (1e-8, 1e-12)  # of the mean information, so that it is regular: before there are enough poses, and then
_NULL: Final = 1e-9

MAX_NEXT: Final = 50
"""The most poses at a time."""


@dataclass(frozen=True)
class NextPose:
    """A pose to measure, the counts at which it should be, and the tensions there in the robots that it may be."""

    pose: tuple[float, ...]  # m and rad
    counts: tuple[float, ...]  # m
    min_tension: float  # N
    max_tension: float  # N
    safe: bool  # feasible in all of these robots


@dataclass(frozen=True, eq=False)
class PoseCandidates:
    """Poses that may be measured, and the tensions there in each of the robots that it may be, NaN if not feasible."""

    places: Array  # (C, n)
    tensions: Array  # (R, C, m) N
    rows: Array  # (C, e, k) of the encoders, their poses eliminated

    @classmethod
    def drawn(cls, model: Model, known: Known, rng: np.random.Generator) -> PoseCandidates:
        """Random poses that the robot holds; those that all robots hold, if they are enough."""
        places = random_poses(model, _CANDIDATES, rng)
        tensions = []
        for exits in known.robots(rng):
            at = np.ascontiguousarray(np.broadcast_to(exits, (len(places), *exits.shape)))
            held = solve_inverse(model, places, exit_points=at)
            tensions.append(np.where(held.ok[:, None], held.tensions, np.nan))
        every = np.array(tensions)
        held_by = np.isfinite(every).all(axis=2).sum(axis=0)
        least = np.sort(held_by)[-min(2 * MAX_NEXT, len(places))]
        kept = held_by >= least
        places, every = places[kept], every[:, kept]
        problem = known.problem
        blank = Measured(np.zeros((len(places), problem.robot.m)), places)
        kept = problem.plan
        plan = CalibrationPlan(unknowns=kept.unknowns, shared=kept.shared, groups=kept.groups, datum=kept.datum)
        wanted = CalibrationProblem.of(problem.robot, blank, plan, hold=bool(problem.held.any()))
        _, rows, _ = projected(wanted.derivatives(known.theta, places))
        return cls(places, every, rows * (wanted.encoder_sigma / known.sigma))

    def ordered(self, chosen: list[int], last: Array | None) -> list[int]:
        """Return them in an order with short travel: the next is the nearest."""
        left = list(chosen)
        at = self.places.mean(axis=0) if last is None else last
        found = []
        while left:
            here = at
            nearest = min(left, key=lambda each: float(np.linalg.norm(self.places[each, :3] - here[:3])))
            left.remove(nearest)
            found.append(nearest)
            at = self.places[nearest]
        return found

    def told(self, ordered: list[int], known: Known) -> tuple[NextPose, ...]:
        """Return poses as people are told of them; where nothing is measured the first is home, of counts 0."""
        problem, places, given = known.problem, self.places[ordered], np.zeros(1)
        if problem.is_soft:  # with the tensions of the robots that hold the pose
            given = np.nanmean(self.tensions[:, ordered], axis=0) * problem.given_per_tension(known.theta, places)
        counts = problem.counts_at(known.theta, places, given)
        counts -= counts[0] * (known.poses == 0)
        made = []
        for at, own_counts in zip(ordered, counts.tolist(), strict=True):
            own = self.tensions[:, at]
            safe, pose = bool(np.isfinite(own).all()), tuple(self.places[at].tolist())
            made.append(NextPose(pose, tuple(own_counts), float(np.nanmin(own)), float(np.nanmax(own)), safe))
        return tuple(made)


class Search:
    """Choice of poses one by one, in the space of what data and candidates determine together."""

    def __init__(self, known: Known, candidates: PoseCandidates) -> None:
        every = np.concatenate([known.rows, candidates.rows.reshape(-1, candidates.rows.shape[2])])
        _, values, right = np.linalg.svd(np.linalg.qr(every, mode="r"))
        kept = values > _NULL * values[0]
        basis = right[kept].T
        self.rows = candidates.rows @ basis
        exits, self.line_of = exit_rows(known.problem.robot, known.problem.free_unknowns)
        self.exits, self.lines = exits @ basis, known.problem.robot.m
        self.assumed = np.zeros(len(exits))
        if known.found is not None:
            self.assumed = np.einsum("ak,kl,al->a", exits, known.found.doubt.assumed, exits)
        own = known.rows @ basis
        ridge = _RIDGE[known.found is not None] * float(np.mean(np.sum(own**2, axis=0)))
        self.root = _root(own, np.sqrt(ridge) * np.eye(basis.shape[1]))

    def sigmas(self, inverse: Array | None = None) -> Array:
        """Return the largest sigma (m,) of a coordinate of each exit point, m."""
        found = np.zeros(self.lines)
        np.maximum.at(found, self.line_of, self._variances(_inverse(self.root) if inverse is None else inverse))
        return np.asarray(np.sqrt(found))

    def chosen(self, size: int, need: float) -> tuple[list[int], Array, int | None]:
        """Return *size* poses, the sigmas (m,) after them, and how many more until *need*; None if never."""
        root, made = self.root, list[int]()
        inverse = _inverse(root)
        then = self.sigmas()
        for _ in range(min(size + _MAX_MORE, len(self.rows))):
            if len(made) >= size and float(self.sigmas(inverse).max()) <= need:
                return made[:size], then, len(made) - size
            after = self._after(inverse)
            after[made] = np.inf
            best = int(np.argmin(after))
            made.append(best)
            root = _root(root, self.rows[best])
            inverse = _inverse(root)
            if len(made) == size:
                then = self.sigmas(inverse)
        return made[:size], then, None

    def _variances(self, inverse: Array) -> Array:
        """Return the variance (a,) of each coordinate of an exit point, with that by numbers that count as known."""
        return np.asarray(np.einsum("ad,de,ae->a", self.exits, inverse, self.exits) + self.assumed)

    def _after(self, inverse: Array) -> Array:
        """Return the largest variance (C,) of a coordinate of an exit point with each candidate added."""
        across = self.rows @ inverse
        inner = np.linalg.inv(np.eye(self.rows.shape[1]) + np.einsum("crd,csd->crs", across, self.rows))
        seen = across @ self.exits.T
        fallen = np.einsum("cra,crs,csa->ca", seen, inner, seen)
        return np.asarray((self._variances(inverse) - fallen).max(axis=1))


def _root(*rows: Array) -> Array:
    """Return a triangle (d, d) with the Gram matrix of all *rows* (.., d): the information that they have together.

    Beside what nothing determines yet, rounding would take the rest from the information itself, and from its inverse.
    """
    return np.asarray(np.linalg.qr(np.concatenate(rows), mode="r"))


def _inverse(root: Array) -> Array:
    """Return the covariance (d, d) by the *root* (d, d) of an information."""
    half = np.linalg.inv(root)
    return np.asarray(half @ half.T)
