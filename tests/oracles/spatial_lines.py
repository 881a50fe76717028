"""Oracle: lines out of the plane and their platform in balance, with 50 digits, from the doubles of a packed robot.

Geometry by vectors: a sheave's centre, the tangents of the cable there, and the angle between them. Spans are Irvine's.
Unknowns are those of a certificate: of the tension in the middle of a free span two coordinates across that of the
solved line, and its relative size; the length; and the angle of a swivel whose winch is beside its axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from mpmath import mp, mpf

from cablewright.kernels import layout as L  # noqa: N812
from oracles.irvine import span
from oracles.platform import exponential

Vector = list[mpf]


class SpatialLine:
    """One row of `Packed.lines`."""

    def __init__(self, row: Any) -> None:
        self.row = [mpf(float(value)) for value in row]
        self.kind = int(row[L.GUIDE])
        assert self.kind != L.UPRIGHT

    def at(self, column: int) -> mpf:
        return self.row[column]

    def three(self, column: int) -> Vector:
        return self.row[column : column + 3]

    def start(self, state: Any, y: Sequence[mpf]) -> Vector:
        """Force at the start of the free span, from the unknowns *y* about the solved line's *state*."""
        phi, tau, free, azimuth = (mpf(float(state[k])) for k in (L.PHI, L.TAU, L.FREE, L.AZIMUTH))
        size, across = mp.exp(tau), [-mp.sin(azimuth), mp.cos(azimuth), mpf(0)]
        way = [mp.cos(phi) * mp.cos(azimuth), mp.cos(phi) * mp.sin(azimuth), mp.sin(phi)]
        middle = plus(times(size, way), [mpf(0), mpf(0), self.at(L.WEIGHT) * free / 2])
        ahead = unit(middle)
        way = unit(plus(ahead, plus(times(y[0], across), times(y[3], cross(ahead, across)))))
        middle = times(norm(middle) * (1 + y[1]), way)
        return minus(middle, [mpf(0), mpf(0), self.at(L.WEIGHT) * y[2] / 2])

    def residual(
        self, state: Any, y: Sequence[mpf], place: Vector, turned: mp.matrix, length: float
    ) -> tuple[list[mpf], Vector]:
        """Equations of the line at the unknowns *y*, and its wrench (6) on the platform at *place* and *turned*."""
        force, free, weight = self.start(state, y), y[2], self.at(L.WEIGHT)
        end = [force[0], force[1], force[2] + weight * free]
        tension = norm(force)
        arm = list(turned * mp.matrix(self.three(L.POINT_X)))
        away = minus(plus(place, arm), self.three(L.EXIT_X))
        point, arc_there = self._platform(turned, end, away)
        arm, away = plus(arm, point), plus(away, point)
        leaves, arc, covered, moment = self._frame(y, force, away)
        leaves, covered = self._mounted(force, tension, leaves, covered)
        horizontal = mp.hypot(force[0], force[1])
        stiffness = 1 / self.at(L.FREE_COMPLIANCE) if self.at(L.FREE_COMPLIANCE) else mp.inf
        x, z = span(horizontal, force[2], free, weight, stiffness)
        chord = [x * force[0] / horizontal, x * force[1] / horizontal, z]
        found = minus(plus(leaves, chord), away)
        dead = self._dead(covered, tension)
        if self.at(L.COUNTERWEIGHT) > 0:
            found.insert(2, tension + weight * dead * self.at(L.WINCH_RISE) - self.at(L.COUNTERWEIGHT))
        else:
            whole = self.at(L.SPANS) * free + dead + (arc + arc_there) / (1 + tension * self.at(L.ARC_COMPLIANCE))
            whole += self.at(L.DEAD_LENGTH) if self.at(L.UNKNOWNS) == 3 else 0
            found.insert(2, whole - tension * self.at(L.END_SPRING) - mpf(float(length)))
        pull = times(-self.at(L.PULLS), end)
        return [*found, *moment], [*pull, *cross(arm, pull)]

    def _dead(self, covered: mpf, tension: mpf) -> mpf:
        """Length that stretches to *covered* under its mean tension: s (1 + c (T + s w r / 2)) = covered."""
        c = self.at(L.DEAD_COMPLIANCE)
        a, b = c * self.at(L.WEIGHT) * self.at(L.MEAN_RISE) / 2, 1 + c * tension
        return 2 * covered / (b + mp.sqrt(b * b + 4 * a * covered))

    def _mounted(self, force: Vector, tension: mpf, leaves: Vector, covered: mpf) -> tuple[Vector, mpf]:
        m = [self.at(L.MOUNT + k) for k in range(6)]
        soft = mp.matrix([[m[0], m[3], m[4]], [m[3], m[1], m[5]], [m[4], m[5], m[2]]])
        towards = self._towards()
        load = [self.at(L.PULLS) * (f + tension / self.at(L.SPANS) * t) for f, t in zip(force, towards, strict=True)]
        given = list(soft * mp.matrix(load))
        return plus(leaves, given), covered - dot(towards, given)

    def _towards(self) -> Vector:
        """Unit vector from the guide towards the winch; zero where the dead span is not modelled."""
        if self.at(L.UNKNOWNS) < 4 or self.kind == L.ASIDE:
            return [mpf(0)] * 3
        if self.kind == L.EYELET:
            return unit(self.three(L.ARRIVAL_X))
        if self.kind == L.PULLEY:
            return cross(self.three(L.ARRIVAL_X), self.three(L.AXIS_X))
        return times(-self.at(L.SIDE), self.three(L.AXIS_X))

    def _frame(self, y: Sequence[mpf], force: Vector, away: Vector) -> tuple[Vector, mpf, mpf, list[mpf]]:
        """Contact point from the exit point, contact length, dead span, and the moment about a swivel."""
        axis, radius, covered = self.three(L.AXIS_X), self.at(L.RADIUS), self.at(L.DEAD_SPAN)
        if self.kind == L.EYELET:
            return [mpf(0)] * 3, mpf(0), covered, []
        if self.kind == L.PULLEY:
            return *on_wheel(axis, self.three(L.ARRIVAL_X), radius, force), covered, []
        if self.kind == L.SWIVEL:
            return *on_swivel(axis, radius, self.at(L.SIDE), force, away), covered, []
        return self._aside(y[4], force)

    def _aside(self, angle: mpf, force: Vector) -> tuple[Vector, mpf, mpf, list[mpf]]:
        """A swivel at the *angle*: both tangents of its wheel, whose forces have no moment about its axis."""
        axis, radius, side, winch = self.three(L.AXIS_X), self.at(L.RADIUS), self.at(L.SIDE), self.three(L.ARRIVAL_X)
        k = min(range(3), key=lambda j: abs(axis[j]))
        edge = [mpf(j == k) for j in range(3)]
        first = unit(minus(edge, times(axis[k], axis)))
        out = plus(times(mp.cos(angle), first), times(mp.sin(angle), cross(axis, first)))
        across, f, centre = cross(axis, out), unit(force), times(radius, out)
        phi = mp.atan2(dot(f, axis), dot(f, out))
        leaves = plus(centre, times(side * radius, plus(times(-mp.sin(phi), out), times(mp.cos(phi), axis))))
        x, z = dot(winch, out) - radius, dot(winch, axis)
        psi = mp.atan2(z, x) + side * mp.asin(radius / mp.hypot(x, z))
        enters = plus(centre, times(side * radius, plus(times(mp.sin(psi), out), times(-mp.cos(psi), axis))))
        rest = minus(winch, enters)
        moment = dot(cross(leaves, f), axis) + dot(cross(enters, unit(rest)), axis)
        wrap = (side * (psi - phi) + mp.pi + mp.pi / 2) % (2 * mp.pi) - mp.pi / 2
        assert abs(dot(leaves, across)) < mpf(10) ** -15
        return leaves, radius * wrap, norm(rest) + self.at(L.DEAD_SPAN), [moment]

    def _platform(self, turned: mp.matrix, end: Vector, away: Vector) -> tuple[Vector, mpf]:
        radius = self.at(L.END_RADIUS)
        if radius == 0:
            return [mpf(0)] * 3, mpf(0)
        axis, leaves = (list(turned * mp.matrix(self.three(at))) for at in (L.END_AXIS_X, L.END_ARRIVAL_X))
        back = times(-1, end)
        if any(leaves):
            return on_wheel(times(-1, axis), leaves, radius, back)
        return on_swivel(axis, radius, mpf(1), back, times(-1, away))


def on_swivel(axis: Vector, radius: mpf, side: mpf, force: Vector, toward: Vector) -> tuple[Vector, mpf]:
    """Contact point and length on a wheel that touches its *axis* and turns to the side of *toward*."""
    out = minus(force, times(dot(force, axis), axis))
    out = times(1 if dot(out, toward) >= 0 else -1, unit(out))
    phi = mp.atan2(dot(force, axis), dot(force, out))
    tangent = plus(times(-mp.sin(phi), out), times(mp.cos(phi), axis))
    return plus(times(radius, out), times(side * radius, tangent)), radius * (mp.pi / 2 - side * phi)


def on_wheel(axis: Vector, arrival: Vector, radius: mpf, force: Vector) -> tuple[Vector, mpf]:
    """Contact point and length on a wheel about a fixed *axis*, from its *arrival* on in the positive sense."""
    inside = minus(force, times(dot(force, axis), axis))
    radial = cross(unit(inside), axis)
    angle = mp.atan2(dot(cross(axis, arrival), radial), dot(arrival, radial))
    return times(radius, radial), radius * ((angle + mp.pi / 2) % (2 * mp.pi) - mp.pi / 2)


def balance(
    packed: Any, lengths: Any, pose: Vector, turn: Vector, start: mp.matrix, states: Any, unknowns: list[Vector]
) -> list[mpf]:
    """Equations of all lines, then the balance of the platform (n,), turned by *turn* from its rotation *start*."""
    n, found = packed.freedoms, []
    turned = exponential(turn) * start if n == 6 else mp.eye(3)
    platform = [mpf(float(value)) for value in packed.platform]
    wrench = platform[L.WRENCH : L.WRENCH + 6]
    weight = [mpf(0), mpf(0), -platform[L.PLATFORM_WEIGHT]]
    arm = list(turned * mp.matrix(platform[L.MASS_X : L.MASS_X + 3]))
    wrench = plus(wrench, [*weight, *cross(arm, weight)])
    for row, state, y, length in zip(packed.lines, states, unknowns, lengths, strict=True):
        own, pull = SpatialLine(row).residual(state, y, pose, turned, length)
        found += own
        wrench = plus(wrench, pull)
    return found + wrench[:n]


def plus(a: Sequence[mpf], b: Sequence[mpf]) -> Vector:
    return [x + y for x, y in zip(a, b, strict=True)]


def minus(a: Sequence[mpf], b: Sequence[mpf]) -> Vector:
    return [x - y for x, y in zip(a, b, strict=True)]


def times(factor: mpf | int, a: Sequence[mpf]) -> Vector:
    return [factor * x for x in a]


def dot(a: Sequence[mpf], b: Sequence[mpf]) -> mpf:
    return mp.fdot(a, b)


def cross(a: Sequence[mpf], b: Sequence[mpf]) -> Vector:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def norm(a: Sequence[mpf]) -> mpf:
    return mp.sqrt(mp.fdot(a, a))


def unit(a: Sequence[mpf]) -> Vector:
    return times(1 / norm(a), a)
