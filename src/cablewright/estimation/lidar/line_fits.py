"""Straight lines in scans whose noise grows with range: as the kernel `draw`, with a sigma for each point.

Clusters are sought among points of about one noise each, so that a near window stays apart from its wall while a noisy
far wall stays in one piece.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from cablewright.estimation.lidar.scan import Clustering, Points, find_clusters
from cablewright.foundation.arrays import Array, Indices, Mask
from cablewright.kernels.fitting.scan_lines import (
    ALONG,
    COLUMNS,
    COUNT,
    HIGH,
    LOW,
    OFFSET,
    ROUNDS,
    SCALE,
    SQUARES,
    axis,
)

_BAND: Final = 1.5  # ratio of the noises within which points are clustered together
_WINDOW: Final = 9  # points, by whose median range a point's band is chosen: noise alone does not change it
_MIN_STEEPNESS: Final = 0.12  # sine of the angle between ray and line: noise is not reduced further below it
_GROWTHS: Final = 6  # fits of one line
_SKIPPED: Final = 4.0  # rays beyond a line's end, between which its next point is sought
_WIDEST: Final = 3.0  # m, of an opening or a pane in a wall
_MIN_FRAME: Final = 0.15  # m, of points on the line past it
_MIN_PAST: Final = 4  # points there
_MIN_WALL: Final = 1.2  # m, length of a wall that can have a pane
_MIN_GAP: Final = 0.4  # m, between two pieces of a line
_SKIPPED_IN_PIECE: Final = 6.0  # rays, likewise
_PIECE_TO_GAP: Final = 0.3  # length of a piece, at least, in the gap before it
_TELLING: Final = 0.1  # rad, sigma of a piece's direction that says something
_TURNED: Final = 0.03  # rad, of a piece from its line, besides noise
_BESIDE: Final = 0.3  # m, from the line, of points that show something else there
_SCATTERED: Final = 1.7  # of a line's residuals, in those by noise
_UNEVEN: Final = 0.02  # m, rms of walls as they are built
_SHARINGS: Final = 2
_GRAZING: Final = 0.05  # sine of the angle between ray and line
_ENDS: Final = (np.argmin, np.argmax)
_MERGE_SIGMAS: Final = 4.0  # of a cluster's ends from the line of another one


class Rules(NamedTuple):
    """Limits of a search for straight lines in a scan, `LineSearch`, as numbers."""

    angle_sigma: float  # rad
    merge_distance: float  # m
    outlier_sigmas: float
    min_points: int
    min_length: float  # m


_Fit = tuple[Array, Indices]
"""The row of a line, and its points."""


class _Groups(NamedTuple):
    """Clusters, each with the sums of its points weighted by its noise."""

    members: list[Indices]
    sigma: Array  # (k,) m
    weight: Array  # (k,) 1/m^2
    mean: Array  # (k, 2) m
    scatter: Array  # (k, 3) of xx, xy, yy, weighted
    end: Array  # (k, 2) m, from the mean
    reach: Array  # (k,) m


def fit_lines(points: Points, sigmas: Array, settings: Clustering, rules: Rules, max_lines: int) -> Array:
    """Return the lines in *points* with noise *sigmas* (n,), m: rows (k, COLUMNS) as the kernel `draw` writes them."""
    groups = _clustered(points, sigmas, settings)
    free = np.ones(len(groups.members), np.bool_)
    sizes = np.array([len(each) for each in groups.members])
    taken = np.zeros(len(points), np.bool_)
    rows: list[_Fit] = []
    while free.any() and len(rows) < max_lines:
        seed = int(np.where(free, sizes, -1).argmax())
        joined, mean, along = _gather(seed, groups, free, rules)
        free &= ~joined
        own = np.concatenate([groups.members[c] for c in np.flatnonzero(joined)])
        place = points.xy[own] @ along
        if len(own) < rules.min_points // 2 or np.ptp(place) < 0.5 * rules.min_length:
            continue
        found = _grown(points, sigmas, own, mean, along, float(groups.reach[joined].max()), rules)
        if found is None:
            continue
        rows.append(found)
        taken[found[1]] = True
        free &= np.array([np.mean(taken[each]) < 0.5 for each in groups.members])
    found_rows = (row for row, _ in _shared_out(points, sigmas, rows, rules))
    return np.array([row for row in found_rows if not _is_scattered(row)]).reshape(-1, COLUMNS)


def _is_scattered(row: Array) -> bool:
    """Whether points scatter about their line more than noise and unevenness do: they are on several things."""
    return bool(row[SCALE] > _SCATTERED and row[SQUARES] > row[COUNT] * _UNEVEN**2)


def _shared_out(points: Points, sigmas: Array, lines: list[_Fit], rules: Rules) -> list[_Fit]:
    """Fit all lines again, each point with the nearest of those that claim it: at corners two do."""
    for _ in range(_SHARINGS):
        off = np.full((len(lines), len(points)), math.inf)
        for k, (row, used) in enumerate(lines):
            off[k, used] = np.abs(row[ALONG] * points.xy[used, 1] - row[ALONG + 1] * points.xy[used, 0] - row[OFFSET])
        again, free = [], np.isinf(off).all(axis=0)
        for k, (row, used) in enumerate(lines):
            past = _past_openings(points, sigmas, free, row, rules)
            own = np.sort(np.concatenate([used[off[:, used].argmin(axis=0) == k], past]))
            own = _in_one_piece(points, sigmas, own, row)
            along = row[ALONG : ALONG + 2]
            fitted = _fit(points, sigmas, own, row[OFFSET] * np.array([-along[1], along[0]]), along, rules)
            if fitted is not None:
                again.append(fitted)
        lines = again
    return lines


def _in_one_piece(points: Points, sigmas: Array, own: Indices, row: Array) -> Indices:
    """Return a line's points without those far past its end that are on it by chance.

    From the largest piece outwards, a piece belongs to the line if it is long beside the gap before it, if that can be
    a pane in a wall, or if the piece has the line's direction. Pieces of few points, such as a pane's own, are skipped.
    """
    along = row[ALONG : ALONG + 2]
    own = own[np.argsort(points.xy[own] @ along, kind="stable")]
    place, off = points.xy[own] @ along, points.xy[own] @ np.array([-along[1], along[0]]) - row[OFFSET]
    if len(own) < 2:
        return own
    steep = np.abs(along[0] * points.ray[own, 1] - along[1] * points.ray[own, 0])
    spacing = points.distance[own] * float(np.median(points.bearing_step)) / np.maximum(steep, _GRAZING)
    gap = np.diff(place)
    cuts = np.flatnonzero(gap > np.maximum(_MIN_GAP, _SKIPPED_IN_PIECE * np.maximum(spacing[1:], spacing[:-1])))
    firsts, lasts = np.concatenate([[0], cuts + 1]), np.concatenate([cuts, [len(own) - 1]])
    largest = int((lasts - firsts).argmax())
    low, high = int(firsts[largest]), int(lasts[largest])
    noise = np.maximum(steep, _MIN_STEEPNESS) * sigmas[own]
    for piece in (*range(largest + 1, len(firsts)), *range(largest - 1, -1, -1)):
        first, last = int(firsts[piece]), int(lasts[piece])
        if last - first + 1 < _MIN_PAST:
            continue
        before = place[first] - place[high] if piece > largest else place[low] - place[last]
        length, whole = place[last] - place[first], place[high] - place[low]
        is_pane = whole >= _MIN_WALL and before <= min(_WIDEST, whole) and length >= _MIN_FRAME
        some = slice(first, last + 1)
        if is_pane or length >= _PIECE_TO_GAP * before or _is_along(place[some], off[some], noise[some]):
            low, high = min(low, first), max(high, last)
    return np.sort(own[low : high + 1])


def _is_along(place: Array, off: Array, noise: Array) -> bool:
    """Whether points, m along a line and beside it, have its direction, and suffice to decide."""
    d = place - place.mean()
    spread = float(d @ d)
    sigma = float(np.median(noise)) / math.sqrt(max(spread, 1e-12))
    return sigma < _TELLING and abs(float(d @ off)) <= (3.0 * sigma + _TURNED) * spread


def _past_openings(points: Points, sigmas: Array, free: Mask, row: Array, rules: Rules) -> Indices:
    """Return the *free* points on a line past its ends: of a pane there, and of the wall beyond it."""
    x, y = points.xy.T
    place = row[ALONG] * x + row[ALONG + 1] * y
    steep = np.abs(row[ALONG] * points.ray[:, 1] - row[ALONG + 1] * points.ray[:, 0])
    off = np.abs(row[ALONG] * y - row[ALONG + 1] * x - row[OFFSET])
    near = free & (off <= rules.outlier_sigmas * np.maximum(steep, _MIN_STEEPNESS) * sigmas)
    some = [np.empty(0, np.intp)]
    for past in (place - row[HIGH], row[LOW] - place):
        chosen = np.flatnonzero(near & (past > 0.0) & (past < _WIDEST))
        beside = free & ~near & (off < _BESIDE) & (past > 0.0) & (past <= past[chosen].max(initial=0.0))
        if len(chosen) >= max(_MIN_PAST, 2 * int(beside.sum())) and np.ptp(past[chosen]) >= _MIN_FRAME:
            some.append(chosen)
    return np.concatenate(some)


def _grown(
    points: Points, sigmas: Array, own: Indices, mean: Array, along: Array, reach: float, rules: Rules
) -> _Fit | None:
    """Fit a line to points near its clusters, and again as long as points beyond its ends belong to it."""
    found: _Fit | None = None
    used = own
    for _ in range(_GROWTHS):
        place = points.xy @ along
        beyond = np.array([max(reach, _SKIPPED * _spacing(points, used[end(place[used])], along)) for end in _ENDS])
        near = np.flatnonzero((place >= place[used].min() - beyond[0]) & (place <= place[used].max() + beyond[1]))
        grown = _fit(points, sigmas, near, mean, along, rules)
        if grown is None or (found is not None and grown[0][COUNT] <= found[0][COUNT]):
            break
        found = grown
        row, used = found
        along = row[ALONG : ALONG + 2]
        mean = row[OFFSET] * np.array([-along[1], along[0]])  # any point of the line
    return found


def _spacing(points: Points, i: int, along: Array) -> float:
    """Distance, m, of successive rays on a line along *along*, at point *i*."""
    steep = abs(float(along[0] * points.ray[i, 1] - along[1] * points.ray[i, 0]))
    return float(points.distance[i] * np.median(points.bearing_step) / max(steep, _GRAZING))


def _clustered(points: Points, sigmas: Array, settings: Clustering) -> _Groups:
    """Cluster the points of each band of noise."""
    n = len(points)
    around = np.arange(n)[:, None] + np.arange(_WINDOW) - _WINDOW // 2
    smooth = np.median(sigmas[np.clip(around, 0, max(n - 1, 0))], axis=1) if n else sigmas
    lowest = float(smooth.min()) if n else 1.0
    band = np.floor(np.log(smooth / lowest) / math.log(_BAND) + 1e-9).astype(np.int64)
    bearing = np.concatenate([[0.0], np.cumsum(points.bearing_step[:-1])]) if n else np.empty(0)
    parts: list[tuple[Indices, float, float, Array]] = []
    for level in np.unique(band):
        chosen = np.flatnonzero(band == level)
        step = np.diff(np.append(bearing[chosen], bearing[chosen[0]] + math.tau))
        first = int(step.argmax()) + 1
        chosen, step = np.roll(chosen, -first), np.roll(step, -first)
        sigma = lowest * _BAND ** (float(level) + 0.5)
        reach = max(settings.reach, 20.0 * sigma)
        some = Points(points.xy[chosen], points.ray[chosen], points.distance[chosen], step)
        own = Clustering(settings.min_incidence, settings.max_missing, reach, settings.alignment, settings.min_points)
        members, begins, sizes, found = find_clusters(some, sigma, own)
        for begin, size, row in zip(begins, sizes, found, strict=True):
            parts.append((chosen[members[begin : begin + size]], sigma, reach, row.copy()))
    sigma_of = np.array([part[1] for part in parts])
    sums = np.array([part[3] for part in parts]).reshape(-1, 7)
    weight = np.array([len(part[0]) for part in parts]) / sigma_of**2
    return _Groups(
        [part[0] for part in parts], sigma_of, weight, sums[:, 0:2], sums[:, 4:7] / sigma_of[:, None] ** 2,
        sums[:, 2:4], np.array([part[2] for part in parts]),
    )  # fmt: skip


def _gather(seed: int, groups: _Groups, free: Mask, rules: Rules) -> tuple[Mask, Array, Array]:
    """Return the free clusters on the line of one of them, the mean (2,) of all, m, and their direction (2,)."""
    joined = np.zeros(len(free), np.bool_)
    joined[seed] = True
    limit = np.maximum(rules.merge_distance, _MERGE_SIGMAS * groups.sigma)
    for _ in range(ROUNDS):
        mean, along = _pooled(groups, joined)
        normal = np.array([-along[1], along[0]])
        off = np.abs((groups.mean - mean) @ normal) + np.abs(groups.end @ normal)
        now = free & (off <= limit)
        now[seed] = True
        if np.array_equal(now, joined):
            break
        joined = now
    return joined, *_pooled(groups, joined)


def _pooled(groups: _Groups, joined: Mask) -> tuple[Array, Array]:
    """Weighted mean (2,), m, and direction (2,) of the points of clusters."""
    weight = groups.weight[joined]
    mean = weight @ groups.mean[joined] / weight.sum()
    d = groups.mean[joined] - mean
    products = np.stack([d[:, 0] ** 2, d[:, 0] * d[:, 1], d[:, 1] ** 2], axis=1)
    angle, _ = axis(*(groups.scatter[joined].sum(axis=0) + weight @ products).tolist())
    return mean, np.array([math.cos(angle), math.sin(angle)])


def _fit(points: Points, sigmas: Array, near: Indices, mean: Array, along: Array, rules: Rules) -> _Fit | None:
    """Return the row of a line through the points *near* it and which of them are on it; None for too few or too short.

    Weighted total least squares, as the kernel `_fit`.
    """
    xy, ray, far, sigma = points.xy[near], points.ray[near], points.distance[near], sigmas[near]
    limit, scale = np.maximum(rules.merge_distance, rules.outlier_sigmas * sigma), math.inf
    offset = float(along[0] * mean[1] - along[1] * mean[0])
    for _ in range(ROUNDS):
        steepness = along[0] * ray[:, 1] - along[1] * ray[:, 0]
        across = far * rules.angle_sigma * (ray @ along)
        variance = (np.maximum(np.abs(steepness), _MIN_STEEPNESS) * sigma) ** 2 + across**2
        off = along[0] * xy[:, 1] - along[1] * xy[:, 0] - offset
        on = np.abs(off) <= np.minimum(rules.outlier_sigmas * scale * np.sqrt(variance), limit)
        count = int(on.sum())
        if count < rules.min_points:
            return None
        weight = np.where(on, 1.0 / variance, 0.0)
        total = float(weight.sum())
        mean = weight @ xy / total
        d = xy - mean
        angle, larger = axis(
            float(weight @ d[:, 0] ** 2), float(weight @ (d[:, 0] * d[:, 1])), float(weight @ d[:, 1] ** 2)
        )
        turned = np.array([math.cos(angle), math.sin(angle)])
        along = turned if turned @ along >= 0.0 else -turned
        offset = float(along[0] * mean[1] - along[1] * mean[0])
        off = along[0] * xy[:, 1] - along[1] * xy[:, 0] - offset
        scale = max(1.0, math.sqrt(float(weight @ off**2) / max(count - 2, 1)))
    place, lever = xy @ along, -float(along @ mean)
    low, high = float(place[on].min()), float(place[on].max())
    if high - low < rules.min_length:
        return None
    moved = weight * (along[0] * ray[:, 1] - along[1] * ray[:, 0])
    row = [
        along[0], along[1], offset, lever, low, high, count, total, larger, scale, float(off[on] @ off[on]),
        float(moved.sum()), float(moved @ (place + lever)),
    ]  # fmt: skip
    return np.array(row), near[on]
