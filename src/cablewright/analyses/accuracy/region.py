"""The region where the nozzle may be at one place: its hull, its shadows, and whether corners bound it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cablewright.analyses.accuracy.spread import SpreadProblem, sampled, settled
from cablewright.arrays import Array
from cablewright.solvers.parameters import nozzle_response

PLANES = {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
FLAT = 1e-9  # smallest extent of a body with a volume, as a share of its largest
CLIMBERS = 16  # samples from which the error is climbed
CLIMBS = 30
FIRST_STEP = 0.125  # of the box whose sides are 2
BEATEN = 1e-9  # m: by how much an inner point has to beat the corners to be told apart from rounding


@dataclass(frozen=True, eq=False)
class Hull:
    """The convex hull of points in space, m."""

    volume: float  # m^3; 0 where all points are in one plane
    triangles: NDArray[np.int64]  # (F, 3) of the points; none where they are in one plane
    projections: dict[str, Array]  # corner points (P, 2) of its shadows on the planes xy, xz and yz, in order


@dataclass(frozen=True)
class Interior:
    """Whether any inner point of the box of ranges is worse than all of its corners."""

    samples: int  # random inner points
    climbs: int  # of them, from how many the error was climbed along its gradient
    max_error: float  # m, largest error of any inner point
    max_deviation: float  # m, largest offset from the nominal point
    corner_is_worst: bool  # neither beats the corners'


@dataclass(frozen=True, eq=False)
class Region:
    """Where the nozzle may be at one place. k uncertain numbers, S sets of values."""

    wanted: Array  # (3,) m
    nominal: Array  # (3,) m
    points: Array  # (S, 3) m
    values: Array  # (S, k)
    hull: Hull
    interior: Interior | None  # None where it was not looked at


def region(problem: SpreadProblem, values: Array, *, inner: int = 0, seed: int = 0) -> Region:
    """The region of the *values* (S, k) of a problem of one place; *inner* random points are tried against it."""
    points, _, ok = sampled(problem, values)
    kept = points[0][ok[0]]
    wanted = problem.nominal.model.nozzle(problem.wanted)[0]
    found = interior(problem, kept, inner, seed) if inner else None
    return Region(wanted, problem.nominal.nozzle[0], kept, values[ok[0]], hull_of(kept), found)


def hull_of(points: Array) -> Hull:
    """The convex hull of *points* (S, 3), m."""
    from scipy.spatial import ConvexHull

    shadows = {name: shadow(points[:, axes]) for name, axes in PLANES.items()}
    extent = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if len(points) < 4 or extent[2] <= FLAT * extent[0]:
        return Hull(0.0, np.empty((0, 3), dtype=np.int64), shadows)
    found = ConvexHull((points - points.mean(axis=0)) / extent[0])
    return Hull(float(found.volume) * float(extent[0]) ** 3, found.simplices.astype(np.int64), shadows)


def shadow(points: Array) -> Array:
    """Corners (P, 2) of the convex hull of *points* (S, 2), anticlockwise (Andrew's monotone chain)."""
    order = sorted(map(tuple, points))
    ends = [_chain(order), _chain(order[::-1])]
    return np.array(ends[0][:-1] + ends[1][:-1] if len(order) > 1 else order).reshape(-1, 2)


def _chain(order: list[tuple[float, ...]]) -> list[tuple[float, ...]]:
    """The half of the hull that lies to the right of the way through sorted points."""
    kept: list[tuple[float, ...]] = []
    for x, y in order:
        while len(kept) > 1 and _turn(kept[-2], kept[-1], (x, y)) <= 0.0:
            kept.pop()
        kept.append((x, y))
    return kept


def _turn(a: tuple[float, ...], b: tuple[float, ...], c: tuple[float, ...]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def area(outline: Array) -> float:
    """Area (m^2) within an outline (P, 2)."""
    closed = [*outline, outline[0]]
    return 0.5 * float(abs(sum(a[0] * b[1] - a[1] * b[0] for a, b in pairwise(closed))))


def interior(problem: SpreadProblem, corners: Array, samples: int, seed: int) -> Interior:
    """Try to beat the *corners* (S, 3), the nozzle at the corners of the box: random points, then climbs from the best.

    The problem is of one place. A climb goes up the gradient of the error, or of the offset from the nominal point,
    in the box whose sides are 2, held inside it.
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
    """Largest distance (m) from *goal* that climbs from *scaled* points (C, k) reach; steps that lose are halved."""
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
