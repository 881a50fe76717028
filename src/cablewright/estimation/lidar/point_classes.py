"""Classes of scan points that are on no wall: behind glass, on people or objects, at corners, strays.

Lines behind glass are no walls of the room: they are dropped.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, Literal, NamedTuple, get_args

import numpy as np

from cablewright.estimation.lidar.scan import Points
from cablewright.estimation.lidar.wall_lines import WallLine
from cablewright.foundation.arrays import Array, Mask

Kind = Literal["behind", "rough", "thing", "corner", "stray"]

MEANINGS: Final[dict[Kind, str]] = {
    "behind": "behind a wall: seen through glass or an opening",
    "rough": "a group that scatters more than the noise: people, plants",
    "thing": "a smooth group before a wall: a pillar, furniture",
    "corner": "where two walls meet, or between the two surfaces at an edge",
    "stray": "alone",
}

_BEYOND: Final = 0.25  # m behind a wall, from which a point has passed through it: windows are less deep
_SIGMAS: Final = 5.0
_SOLID: Final = 0.4  # length in sight of a wall's solid parts, in that of its openings
_OPEN: Final = 2.0  # rays that pass a line, to those that end on it, from which it is none
_WIDEST: Final = 3.0  # m, of a pane at a wall's end
_PANE_TO_WALL: Final = 1.0  # width of such a pane, at most, in the length of the wall beside it
_MIN_WALL: Final = 1.2  # m, likewise
_CLOSING: Final = 0.3  # m, from the wall's line, of points that close it
_MIN_PAST: Final = 3  # points there
_AT_CORNER: Final = 0.5  # m, from a line's end, of another line that it meets there
_ACROSS: Final = 0.3  # sine of the angle between them
_PANE: Final = 0.08  # of a line's points: share of single nearer ones that indicates a pane before it
_MIN_PANE: Final = 3
_JOINED: Final = 0.25  # m, from a line's end, of the points of the next object
_SHARE: Final = 0.6  # of a line's points, from which it is behind walls
_ALL: Final = 0.9  # share of a line's points, on the far side of a wall
_MIN_COSINE: Final = 0.03  # between a ray and a wall's normal: not along it
_OUTLIER: Final = 3.5  # sigmas
_MIN_STEEPNESS: Final = 0.3
_CORNER: Final = 0.05  # m
_MIN_GROUP: Final = 3  # points
_ROUGH: Final = 2.5  # times the noise


class _Crossing(NamedTuple):
    """How each ray (n,) meets the line of a wall."""

    meets: Mask  # it meets the line at all
    place: Array  # m along the line, where it does
    own: Array  # m along the line, of its point
    beyond: Array  # m, of its point behind the line, along the normal
    near: Mask  # its point is on the line
    on: Mask  # and between the wall's ends
    ends: tuple[float, float]  # m along the line


def on_walls(points: Points, sigmas: Array, lines: Sequence[WallLine]) -> Mask:
    """Return which points (n,) of a scan are on one of the *lines*."""
    on = np.zeros(len(points), np.bool_)
    for line in lines:
        on |= _crossing(points, sigmas, line).on
    return on


def range_errors(points: Points, sigmas: Array, lines: Sequence[WallLine]) -> tuple[Array, Array]:
    """Return range and its error, m, of each point on a line whose ray is not nearly along it."""
    far, errors = [np.empty(0)], [np.empty(0)]
    for line in lines:
        met = _crossing(points, sigmas, line)
        steep = points.ray @ np.array([math.cos(line.angle), math.sin(line.angle)])
        good = met.on & (steep > _MIN_STEEPNESS)
        far.append(points.distance[good])
        errors.append(met.beyond[good] / steep[good])
    return np.concatenate(far), np.concatenate(errors)


def behind_walls(points: Points, sigmas: Array, lines: Sequence[WallLine]) -> Mask:
    """Return which points (n,) were seen through one of the *lines*: behind it, between its ends.

    A wall ends where its last points are: the frame beyond a pane, or the pane itself, are among them. Only lines count
    that are solid enough beside what is open, by length in sight: two pillars in one line are no window.
    """
    behind = np.zeros(len(points), np.bool_)
    met = [_crossing(points, sigmas, line) for line in lines]
    claims = np.sum([each.on for each in met], axis=0) if met else behind
    for each in met:
        loose = each.near & ((claims == 0) | each.on)
        low, high = _reach(each)
        within = each.meets & (each.place > low) & (each.place < high)
        through = within & (each.beyond > np.maximum(_BEYOND, _SIGMAS * sigmas))
        if not through.any():
            continue
        hit = np.flatnonzero(within & (through | loose))
        hit = hit[np.argsort(each.place[hit], kind="stable")]
        between = np.diff(each.place[hit])
        share = np.concatenate([[0.0], between]) + np.concatenate([between, [0.0]])
        if share[loose[hit]].sum() > _SOLID * share[through[hit]].sum():
            behind |= through
    return behind


def _reach(met: _Crossing) -> tuple[float, float]:
    """Return both ends, m, along a wall: where an opening at its end is closed by the next solid thing, that.

    That thing's first point stands near the wall's line: a corner, a frame.
    """
    low, high = met.ends
    widest = min(_WIDEST, _PANE_TO_WALL * (high - low))
    if high - low < _MIN_WALL:  # a thing: what is beside it is no pane
        return low, high
    closing = np.abs(met.beyond) <= _CLOSING
    past = met.own[closing & (met.own > high) & (met.own < high + widest)]
    if len(past) >= _MIN_PAST:
        high = float(np.partition(past, _MIN_PAST - 1)[_MIN_PAST - 1])
    past = met.own[closing & (met.own < low) & (met.own > low - widest)]
    if len(past) >= _MIN_PAST:
        low = float(np.partition(past, -_MIN_PAST)[-_MIN_PAST])
    return low, high


def drop_lines_behind(points: Points, sigmas: Array, lines: Sequence[WallLine]) -> list[WallLine]:
    """Return the *lines* that are not mostly behind others: those are outside, or mirrored by glass.

    Lines that far more rays pass than meet are dropped first: they join the sides of separate things. A line whose end
    meets an object, such as the back of an alcove, is kept. Others are dropped also behind points just past the end of
    a wall: a pane may reach to the corner.
    """
    met = [_crossing(points, sigmas, line) for line in lines]
    on = [each.on for each in met]

    def share(i: int, others: Sequence[WallLine]) -> float:
        return float(np.mean(behind_walls(points, sigmas, others)[on[i]])) if on[i].any() else 0.0

    alone = [share(i, [*lines[:i], *lines[i + 1 :]]) for i in range(len(lines))]
    kept: list[int] = []
    for i in sorted(range(len(lines)), key=lambda i: alone[i]):
        if _through_glass(points, sigmas, met[i]) or _is_open(sigmas, met[i]):
            continue
        others = [lines[k] for k in range(len(lines)) if k != i and alone[k] < _SHARE]
        torn = not any(_meets(points, met[i], end, lines[i], others) for end in lines[i].ends)
        if torn and share(i, [lines[k] for k in kept]) >= _SHARE:
            continue
        if torn and any(_is_beyond(sigmas, met[k], on[i]) for k in kept):
            continue
        kept.append(i)
    return [lines[i] for i in sorted(kept)]


def _meets(points: Points, met: _Crossing, end: Array, line: WallLine, others: Sequence[WallLine]) -> bool:
    """Whether a line's end is at a corner: near points of something else, or near another line across."""
    if int(np.sum(~met.near & (np.hypot(*(points.xy - end).T) < _JOINED))) >= _MIN_PAST:
        return True
    for other in others:
        side = other.ends[1] - other.ends[0]
        share = float(np.clip((end - other.ends[0]) @ side / max(float(side @ side), 1e-12), 0.0, 1.0))
        away = float(np.hypot(*(end - other.ends[0] - share * side)))
        if away < _AT_CORNER and abs(math.sin(other.angle - line.angle)) > _ACROSS:
            return True
    return False


def _is_beyond(sigmas: Array, wall: _Crossing, on: Mask) -> bool:
    """Whether a line's points are all behind a *wall* or a pane beside it."""
    length = wall.ends[1] - wall.ends[0]
    if length < _MIN_WALL or not on.any():
        return False
    wide = min(_WIDEST, _PANE_TO_WALL * length)
    across = wall.meets & (wall.place > wall.ends[0] - wide) & (wall.place < wall.ends[1] + wide)
    return bool(np.mean((across & (wall.beyond > np.maximum(_BEYOND, _SIGMAS * sigmas)))[on]) > _ALL)


def _is_open(sigmas: Array, met: _Crossing) -> bool:
    """Whether far more rays go through a line, between its ends, than are reflected by it."""
    within = met.meets & (met.place > met.ends[0]) & (met.place < met.ends[1])
    passed = within & (met.beyond > np.maximum(_BEYOND, _SIGMAS * sigmas))
    return int(passed.sum()) > _OPEN * int(met.on.sum())


def _through_glass(points: Points, sigmas: Array, met: _Crossing) -> bool:
    """Whether single nearer points interrupt a line again and again: those that the pane itself returned."""
    own = np.flatnonzero(met.on)
    if len(own) < 2 or (len(own) and own[-1] - own[0] > len(points) // 2):
        return False
    before, after = own[:-1], own[1:]
    alone = (after - before > 1) & (after - before <= 3)
    nearer = met.beyond[np.minimum(before + 1, len(points) - 1)] < -np.maximum(_BEYOND, _SIGMAS * sigmas[before])
    return int(np.sum(alone & nearer)) >= max(_MIN_PANE, math.ceil(_PANE * len(own)))


def kinds_off_walls(points: Points, sigmas: Array, lines: Sequence[WallLine]) -> dict[Kind, int]:
    """Return the number of points of each class that are on no wall, without empty classes."""
    kinds = np.full(len(points), "stray", dtype="<U6")
    off = ~on_walls(points, sigmas, lines)
    behind = behind_walls(points, sigmas, lines)
    for group in _groups(points, sigmas, off & ~behind):
        if len(group) >= _MIN_GROUP:
            kinds[group] = "rough" if _is_rough(points.distance[group], sigmas[group]) else "thing"
    kinds[_at_corners(points, sigmas, lines, off)] = "corner"
    kinds[behind] = "behind"
    return {kind: count for kind in get_args(Kind) if (count := int(np.sum(off & (kinds == kind))))}


def _crossing(points: Points, sigmas: Array, line: WallLine) -> _Crossing:
    normal = np.array([math.cos(line.angle), math.sin(line.angle)])
    along = np.array([-normal[1], normal[0]])
    steep = points.ray @ normal
    meets = steep > _MIN_COSINE
    with np.errstate(over="ignore"):
        there = line.distance / np.where(meets, steep, 1.0) * (points.ray @ along)
    low, high = np.sort(line.ends @ along).tolist()
    beyond, own = points.xy @ normal - line.distance, points.xy @ along
    limit = _OUTLIER * np.maximum(np.maximum(np.abs(steep), _MIN_STEEPNESS) * sigmas, math.sqrt(line.variance))
    near = np.abs(beyond) <= limit
    on = near & (own >= low - 1e-9) & (own <= high + 1e-9)
    return _Crossing(meets, there, own, beyond, near, on, (low, high))


def _groups(points: Points, sigmas: Array, chosen: Mask) -> list[Array]:
    """Runs of *chosen* points near each other, in the order of bearing."""
    index = np.flatnonzero(chosen)
    if not len(index):
        return []
    gap = np.hypot(*np.diff(points.xy[index], axis=0).T)
    usual = float(np.median(points.bearing_step))
    near = 0.1 + 5.0 * usual * points.distance[index[:-1]] + 6.0 * sigmas[index[:-1]]
    return np.split(index, np.flatnonzero(gap > near) + 1)


def _is_rough(far: Array, sigma: Array) -> bool:
    """Whether successive ranges scatter more than noise does: by second differences, small on round objects."""
    if len(far) < _MIN_GROUP + 2:
        return False
    second = np.abs(np.diff(far, 2)) / (math.sqrt(6.0) * sigma[1:-1])
    return float(np.median(second)) / 0.6745 > _ROUGH


def _at_corners(points: Points, sigmas: Array, lines: Sequence[WallLine], off: Mask) -> Mask:
    """Which points *off* walls are where two lines meet, or between the ranges of both neighbours at an edge."""
    at = np.zeros(len(points), np.bool_)
    for i, one in enumerate(lines):
        for other in lines[:i]:
            normals = np.array([[math.cos(line.angle), math.sin(line.angle)] for line in (one, other)])
            if abs(float(np.linalg.det(normals))) < 0.3:
                continue
            meeting = np.linalg.solve(normals, np.array([one.distance, other.distance]))
            at |= np.hypot(*(points.xy - meeting).T) <= np.maximum(_CORNER, _SIGMAS * sigmas)
    if len(points) > 2:
        before, after = np.roll(points.distance, 1), np.roll(points.distance, -1)
        low, high = np.minimum(before, after), np.maximum(before, after)
        margin = np.maximum(_CORNER, _SIGMAS * sigmas)
        at |= (points.distance > low + margin) & (points.distance < high - margin)
    return at & off
