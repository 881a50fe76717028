"""Region in which uncertain parameters can move the nozzle at one pose: hull, projections, check of its corners."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cablewright.analyses.accuracy.spread import SpreadProblem, sampled, settled
from cablewright.foundation.arrays import Array
from cablewright.solvers.parameter_effects import nozzle_response

if TYPE_CHECKING:
    from scipy.spatial import ConvexHull

PLANES = {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
FLAT = 1e-9  # ratio of the smallest to the largest extent below which points count as flat
CLIMBERS = 16  # samples from which a gradient ascent of the error starts
CLIMBS = 30  # steps of each ascent
FIRST_STEP = 0.125  # step of the ascent, in a box of ranges scaled to sides of 2
BEATEN = 1e-9  # m; an inner point that exceeds the corners by less is taken for rounding


@dataclass(frozen=True, eq=False)
class Hull:
    """The convex hull of points (S, 3), m."""

    volume: float  # m^3; 0 where all points are coplanar
    triangles: NDArray[np.int64]  # (F, 3) indices of points; F = 0 where they are coplanar
    projections: dict[str, Array]  # by "xy", "xz", "yz": the corners (P, 2) of the hull's outline, anticlockwise


@dataclass(frozen=True)
class Interior:
    """Whether any inner point of the box of ranges has a larger error than all its corners."""

    samples: int  # random inner points
    climbs: int  # random points from which the error was increased along its gradient
    max_error: float  # m, largest error of any inner point
    max_deviation: float  # m, largest distance of any inner point from the nominal position
    corner_is_worst: bool  # no inner point exceeds the corners in either


@dataclass(frozen=True, eq=False)
class Region:
    """The positions that the nozzle can have at one pose, for S sets of values of k uncertain parameters."""

    wanted: Array  # (3,) m, commanded position of the nozzle
    nominal: Array  # (3,) m, position if all parameters are nominal
    points: Array  # (S, 3) m
    values: Array  # (S, k)
    hull: Hull
    interior: Interior | None  # None where no inner points were tried


def region(problem: SpreadProblem, values: Array, *, inner: int = 0, seed: int = 0) -> Region:
    """Return the nozzle's region for *values* (S, k) of a problem of one pose, compared with *inner* random points."""
    points, _, ok = sampled(problem, values)
    kept = points[0][ok[0]]
    wanted = problem.nominal.model.nozzle(problem.wanted)[0]
    found = interior(problem, kept, inner, seed) if inner else None
    return Region(wanted, problem.nominal.nozzle[0], kept, values[ok[0]], hull_of(kept), found)


def hull_of(points: Array) -> Hull:
    """Return the convex hull of *points* (S, 3), m."""
    shadows = {name: _shadow(points[:, axes]) for name, axes in PLANES.items()}
    hull, scale = _scaled_hull(points)
    if hull is None:
        return Hull(0.0, np.empty((0, 3), dtype=np.int64), shadows)
    return Hull(float(hull.volume) * scale**3, hull.simplices.astype(np.int64), shadows)


def _scaled_hull(points: Array) -> tuple[ConvexHull | None, float]:
    """The hull of *points* (S, d) about their mean, divided by the scale returned with it, m; None where it is flat."""
    from scipy.spatial import ConvexHull

    centred = points - points.mean(axis=0)
    extent = np.linalg.svd(centred, compute_uv=False)
    if len(points) <= points.shape[1] or extent[-1] <= FLAT * extent[0]:
        return None, 1.0
    return ConvexHull(centred / extent[0]), float(extent[0])


def _shadow(points: Array) -> Array:
    """Corners (P, 2) of the convex hull of *points* (S, 2), anticlockwise; the ends where all are on one line."""
    hull, _ = _scaled_hull(points)
    if hull is None:
        ends = np.unique(points, axis=0)
        return ends[:: max(1, len(ends) - 1)]
    return np.asarray(points[hull.vertices])


def interior(problem: SpreadProblem, corners: Array, samples: int, seed: int) -> Interior:
    """Search the box of ranges for points worse than its *corners* (S, 3): random *samples*, then gradient ascent.

    The problem has one pose; *corners* are the nozzle positions at the corners of the box. Each ascent increases the
    error, or the distance from the nominal position, and is clipped to the box.
    """
    rng = np.random.default_rng(seed)
    scaled = rng.uniform(-1.0, 1.0, (samples, len(problem.ranges)))
    points, _, ok = sampled(problem, problem.middle + scaled * problem.half_widths)
    largest, beaten = [], False
    for goal in (problem.nominal.model.nozzle(problem.wanted)[0], problem.nominal.nozzle[0]):
        far = np.where(ok[0], np.linalg.norm(points[0] - goal, axis=1), -1.0)
        starts = np.argsort(-far)[:CLIMBERS]
        best = max(float(far.max()), _climbed(problem, scaled[starts], goal))
        largest.append(best)
        beaten |= best > np.linalg.norm(corners - goal, axis=1).max() + BEATEN
    return Interior(samples, min(CLIMBERS, samples), largest[0], largest[1], corner_is_worst=not beaten)


def _climbed(problem: SpreadProblem, scaled: Array, goal: Array) -> float:
    """Largest distance (m) from *goal* (3,) found by ascents from *scaled* points (C, k); failed steps are halved."""
    steps = np.full(len(scaled), FIRST_STEP)
    here, trial = scaled, scaled
    reached = np.full(len(scaled), -1.0)
    gradient = np.zeros_like(scaled)
    for _ in range(CLIMBS):
        found = settled(problem, (problem.middle + trial * problem.half_widths)[None])
        away = found.nozzle - goal
        far = np.where(found.ok, np.linalg.norm(away, axis=1), -1.0)
        better = far > reached
        steps = np.where(better, np.minimum(2.0 * steps, 1.0), 0.5 * steps)
        if better.any():
            reached, here = np.where(better, far, reached), np.where(better[:, None], trial, here)
            motion = nozzle_response(found[better], [each.parameter for each in problem.ranges])
            slope = np.einsum("ci,cik->ck", away[better], motion) * problem.half_widths
            gradient[better] = slope / np.maximum(np.abs(slope).max(axis=1, keepdims=True), 1e-300)
        trial = np.clip(here + steps[:, None] * gradient, -1.0, 1.0)
    return float(reached.max())
