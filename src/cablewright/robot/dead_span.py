"""Path of a cable from its winch over its guides: straight pieces, and arcs on wheels in fixed planes.

A wheel has a groove: where the cable comes or leaves aslant it touches the rim where its direction, seen along the
wheel's axis, is tangent, and between the two it lies on the rim. Lengths are in m, points in the world's axes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Final

from cablewright.foundation.errors import InputError
from cablewright.foundation.units import Vec3
from cablewright.robot.direction import cross, unit_vector
from cablewright.robot.sheave import GuideSheave

Guide = Vec3 | GuideSheave
"""A point that the cable passes, or a wheel that it lies on."""

MOST_WOUND: Final = 1.5 * math.pi
"""Largest angle of contact, rad: a larger one is one below zero, as in `kernels.statics.line.guides`."""

_ROUNDING: Final = 1e-9  # m, and rad
_OUTSIDE: Final = 1.0 + 1e-12  # distance of a point from a wheel's axis, per radius, from which it has a tangent
_LOOKS: Final = 180  # angles of a wheel at which a tangent to another one is looked for
_HALVINGS: Final = 60
_DRAWN: Final = math.radians(10.0)


@dataclass(frozen=True)
class Straight:
    """A straight piece of cable from ``start`` to ``end``, (3,) m each."""

    start: Vec3
    end: Vec3

    @property
    def length(self) -> float:
        """Length of the piece, m."""
        return math.dist(self.start, self.end)

    @property
    def moment(self) -> float:
        """Integral of height over length of the piece, m^2."""
        return 0.5 * (self.start[2] + self.end[2]) * self.length

    @property
    def heights(self) -> tuple[float, float]:
        """Height of the piece's lowest and of its highest point, m."""
        return min(self.start[2], self.end[2]), max(self.start[2], self.end[2])

    def drawn(self) -> list[Vec3]:
        """Points of this piece of cable after its first, which a picture joins, (k, 3) m."""
        return [self.end]


@dataclass(frozen=True)
class Arc:
    """Cable on a wheel, by ``angle`` (rad) from the unit vector ``arm`` towards ``ahead``, which is across it."""

    centre: Vec3
    radius: float
    arm: Vec3
    ahead: Vec3
    angle: float

    @property
    def length(self) -> float:
        """Length of the arc, m."""
        return self.radius * self.angle

    @property
    def moment(self) -> float:
        """Integral of height over length of the arc, m^2."""
        over = math.sin(self.angle) * self.arm[2] + (1.0 - math.cos(self.angle)) * self.ahead[2]
        return self.length * self.centre[2] + self.radius**2 * over

    @property
    def heights(self) -> tuple[float, float]:
        """Height of the arc's lowest and of its highest point, m."""
        top = math.atan2(self.ahead[2], self.arm[2])
        turning = (each % (2.0 * math.pi) for each in (top, top + math.pi))
        heights = [self.at(each)[2] for each in (0.0, self.angle, *(turn for turn in turning if turn < self.angle))]
        return min(heights), max(heights)

    def at(self, angle: float) -> Vec3:
        """Return the point (3,), m, of the arc by *angle* (rad) after its start."""
        return _on_rim(self.centre, self.radius, _turned(self.arm, self.ahead, angle))

    def drawn(self) -> list[Vec3]:
        """Points of this piece of cable after its first, which a picture joins, (k, 3) m."""
        count = math.ceil(self.angle / _DRAWN)
        return [self.at(self.angle * (k + 1) / count) for k in range(count)]


@dataclass(frozen=True)
class DeadSpan:
    """Pieces of cable, in order from the winch to where the cable comes to its sheave."""

    pieces: tuple[Straight | Arc, ...]

    @property
    def first(self) -> Straight:
        """The straight piece that leaves the winch."""
        return _straight(self.pieces[0])

    @property
    def last(self) -> Straight:
        """The straight piece that arrives at the sheave."""
        return _straight(self.pieces[-1])

    @cached_property
    def length(self) -> float:
        """Length of the whole path, m."""
        return math.fsum(piece.length for piece in self.pieces)

    @property
    def turned(self) -> float:
        """Angle by which the cable turns between winch and sheave, on wheels and at points, rad."""
        bends = [
            math.atan2(math.hypot(*cross(one, two)), _dot(one, two))
            for one, two in pairwise(
                _minus(each.end, each.start) if isinstance(each, Straight) else None for each in self.pieces
            )
            if one is not None and two is not None
        ]
        return math.fsum(bends) + math.fsum(each.angle for each in self.pieces if isinstance(each, Arc))

    @property
    def mean_height(self) -> float:
        """Mean height along its length, m."""
        return math.fsum(piece.moment for piece in self.pieces) / self.length

    @property
    def heights(self) -> tuple[float, float]:
        """Height of the lowest and of the highest point of the path from winch to sheave, m."""
        low, high = zip(*(piece.heights for piece in self.pieces), strict=True)
        return min(low), max(high)

    def drawn(self) -> list[Vec3]:
        """Points of the cable from the winch to the sheave, which a picture joins, (k, 3) m."""
        return [self.first.start, *(point for piece in self.pieces for point in piece.drawn())]


def _straight(piece: Straight | Arc) -> Straight:
    assert isinstance(piece, Straight)  # no wheel is first or last
    return piece


@lru_cache(maxsize=512)
def dead_span(winch_exit: Vec3, guides: tuple[Guide, ...], end: Guide) -> DeadSpan:
    """Return the path of a cable from its *winch_exit* over *guides* to its *end*: the exit point, or a pulley there.

    Raises `InputError`, which names the guide, where no cable can run.
    """
    stops = [each if isinstance(each, tuple) else _Wheel.of(each) for each in (winch_exit, *guides, end)]
    names = ["winch_exit", *(f"guide {k + 1}" for k in range(len(guides)))]
    names.append("exit_point" if isinstance(end, tuple) else "the pulley")
    straights = [_joined(*pair, *named) for pair, named in zip(pairwise(stops), pairwise(names), strict=True)]
    _require_free(stops, names, straights)
    pieces: list[Straight | Arc] = [straights[0]]
    for stop, name, come, leave in zip(stops[1:-1], names[1:-1], straights, straights[1:], strict=False):
        pieces += [leave] if isinstance(stop, tuple) else [_arc(stop, name, come, leave), leave]
    return DeadSpan(tuple(pieces))


@dataclass(frozen=True)
class _Wheel:
    """Centre and radius (m), and the unit vector of the axis, about which the cable travels by the right-hand rule."""

    centre: Vec3
    radius: float
    axis: Vec3

    @classmethod
    def of(cls, wheel: GuideSheave) -> _Wheel:
        return cls(wheel.centre, wheel.radius, unit_vector(wheel.axis))

    def touched(self, point: Vec3, way: float) -> Vec3 | None:
        """Return the unit vector to the point where a cable from *point* (way 1), or to it (way -1), is tangent.

        None for one inside.
        """
        away = _minus(point, self.centre)
        across = _dot(away, self.axis)
        x, y, z = (each - across * normal for each, normal in zip(away, self.axis, strict=True))
        distance = math.hypot(x, y, z)
        if not distance > self.radius * _OUTSIDE:
            return None
        outward, share = (x / distance, y / distance, z / distance), self.radius / distance
        beside = way * math.sqrt((1.0 - share) * (1.0 + share))
        return _combined(share, outward, beside, cross(self.axis, outward))

    def rim(self, arm: Vec3) -> Vec3:
        return _on_rim(self.centre, self.radius, arm)


def _joined(one: Vec3 | _Wheel, two: Vec3 | _Wheel, name: str, other: str) -> Straight:
    """Return the straight piece from one stop to the next."""
    if isinstance(one, tuple):
        return Straight(one, two if isinstance(two, tuple) else _tangent(two, one, 1.0, other, name))
    if isinstance(two, tuple):
        return Straight(_tangent(one, two, -1.0, name, other), two)
    found = _between(one, two)
    if len(found) != 1:
        why = "no straight cable" if not found else "more than one straight cable"
        hint = "put an eyelet between them" if found else "do they overlap, or is an axis the other way round?"
        raise InputError(f"{why} leaves the rim of {name} and comes to that of {other}: {hint}")
    return found[0]


def _tangent(wheel: _Wheel, point: Vec3, way: float, name: str, other: str) -> Vec3:
    arm = wheel.touched(point, way)
    if arm is None:
        raise InputError(f"{other} is within the rim of {name}, seen along its axis: no cable touches that wheel")
    return wheel.rim(arm)


def _between(one: _Wheel, two: _Wheel) -> list[Straight]:
    """Return all straight pieces from wheel to wheel whose direction, seen along each axis, is tangent to its rim.

    From each point of the first rim there is one tangent to the second; it has to be square to the first one's arm.
    """
    first = _across(one.axis)
    ahead = cross(one.axis, first)

    def piece(angle: float) -> Straight | None:
        start = one.rim(_turned(first, ahead, angle))
        arm = two.touched(start, 1.0)
        return None if arm is None else Straight(start, two.rim(arm))

    def slant(angle: float) -> float:
        """Return the component of the piece along the first wheel's arm, m; NaN where there is none."""
        at = piece(angle)
        return math.nan if at is None else _dot(_minus(at.end, at.start), _turned(first, ahead, angle))

    found = []
    for (low, before), (high, after) in pairwise(_looked_at(slant)):
        if not math.isnan(before + after) and (before > 0.0) != (after > 0.0):
            angle = _root(slant, low, high, before > 0.0)
            at, onward = piece(angle), cross(one.axis, _turned(first, ahead, angle))
            if at is not None and _dot(_minus(at.end, at.start), onward) > 0.0:
                found.append(at)
    return found


def _looked_at(slant: Callable[[float], float]) -> list[tuple[float, float]]:
    """Return angles (rad) of a whole turn in order, and the *slant* there; also where that begins or ends."""
    even = [(angle, slant(angle)) for angle in (2.0 * math.pi * k / _LOOKS for k in range(_LOOKS + 1))]
    found = even[:1]
    for one, other in pairwise(even):
        if math.isnan(one[1]) != math.isnan(other[1]):
            (none, _), some = (one, other) if math.isnan(one[1]) else (other, one)
            for _ in range(_HALVINGS):
                middle = 0.5 * (none + some[0])
                at = middle, slant(middle)
                none, some = (middle, some) if math.isnan(at[1]) else (none, at)
            found.append(some)
        found.append(other)
    return found


def _root(slant: Callable[[float], float], low: float, high: float, falls: bool) -> float:
    """Return where *slant* changes its sign between *low* and *high*, to rounding."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        if (slant(middle) > 0.0) == falls:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def _arc(wheel: _Wheel, name: str, come: Straight, leave: Straight) -> Arc:
    """Return the cable on a wheel between two pieces. Raises `InputError` where it would be less than none."""
    arm, left = (_over(_minus(point, wheel.centre), wheel.radius) for point in (come.end, leave.start))
    ahead = cross(wheel.axis, arm)
    angle = math.atan2(_dot(left, ahead), _dot(left, arm)) % (2.0 * math.pi)
    if angle > MOST_WOUND:
        unwound = 2.0 * math.pi - angle
        if unwound > _ROUNDING:
            why = f"would have to unwind by {math.degrees(unwound):.3g} deg from it"
            raise InputError(f"{name}: the cable passes this wheel by, and {why}: is its axis the other way round?")
        angle = 0.0
    return Arc(wheel.centre, wheel.radius, arm, ahead, angle)


def _require_free(stops: Sequence[Vec3 | _Wheel], names: Sequence[str], straights: Sequence[Straight]) -> None:
    """Raise `InputError` for a straight piece that goes through a wheel other than those that it touches."""
    for k, piece in enumerate(straights):
        for i, (stop, name) in enumerate(zip(stops, names, strict=True)):
            if isinstance(stop, _Wheel) and i not in (k, k + 1) and _cuts(stop, piece):
                raise InputError(f"the cable from {names[k]} to {names[k + 1]} goes through the wheel of {name}")


def _cuts(wheel: _Wheel, piece: Straight) -> bool:
    """Whether a piece goes through the disc of a wheel, or lies in it."""
    start, end = _minus(piece.start, wheel.centre), _minus(piece.end, wheel.centre)
    begin, close = _dot(start, wheel.axis), _dot(end, wheel.axis)
    way = _minus(end, start)
    if max(abs(begin), abs(close)) <= _ROUNDING:
        share = min(max(-_dot(start, way) / (_dot(way, way) or 1.0), 0.0), 1.0)
    elif (begin > 0.0) == (close > 0.0):
        return False
    else:
        share = begin / (begin - close)
    return math.hypot(*_combined(1.0, start, share, way)) < wheel.radius - _ROUNDING


def _minus(one: Vec3, other: Vec3) -> Vec3:
    return one[0] - other[0], one[1] - other[1], one[2] - other[2]


def _over(vector: Vec3, size: float) -> Vec3:
    return vector[0] / size, vector[1] / size, vector[2] / size


def _dot(one: Vec3, other: Vec3) -> float:
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


def _combined(a: float, one: Vec3, b: float, other: Vec3) -> Vec3:
    return a * one[0] + b * other[0], a * one[1] + b * other[1], a * one[2] + b * other[2]


def _turned(arm: Vec3, ahead: Vec3, angle: float) -> Vec3:
    return _combined(math.cos(angle), arm, math.sin(angle), ahead)


def _on_rim(centre: Vec3, radius: float, arm: Vec3) -> Vec3:
    return _combined(1.0, centre, radius, arm)


def _across(axis: Vec3) -> Vec3:
    """Return a unit vector across a unit vector."""
    least = min(range(3), key=lambda k: abs(axis[k]))
    return unit_vector(cross(axis, (float(least == 0), float(least == 1), float(least == 2))))
