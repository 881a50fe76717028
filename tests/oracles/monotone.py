"""Oracle: from the force on the free end of a line to where that end is, the map of docs/theory/uniqueness.md.

Numbers are mpmath's, formulas the textbook's. A force is (horizontal, upward) in the line's plane, N, x away from the
exit point; `at` turns it to space. Nothing here is shared with the package.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mpmath import mp, mpf

Vector = Sequence[mpf]
ZERO = mpf(0)


def span(h: mpf, v: mpf, length: mpf, weight: mpf, compliance: mpf) -> tuple[mpf, mpf]:
    """Where a span ends whose start force is (h, v): Irvine's elastic catenary, h > 0 or weight = 0."""
    v1 = v + weight * length
    t0, t1 = mp.hypot(h, v), mp.hypot(h, v1)
    if weight == 0:
        return h * length * (compliance + 1 / t0), v * length * (compliance + 1 / t0)
    x = h * compliance * length + h / weight * (mp.asinh(v1 / h) - mp.asinh(v / h))
    return x, compliance * length * (v + v1) / 2 + (t1 - t0) / weight


def flexibility(h: mpf, v: mpf, length: mpf, weight: mpf, compliance: mpf) -> mp.matrix:
    """Change of the end with the force, in the plane and (third row and column) across it."""
    v1 = v + weight * length
    t0, t1 = mp.hypot(h, v), mp.hypot(h, v1)
    g = (mp.asinh(v1 / h) - mp.asinh(v / h)) / weight
    s = (v1 / t1 - v / t0) / weight
    b = h * (1 / t1 - 1 / t0) / weight
    cl = compliance * length
    return mp.matrix([[cl + g - s, b, 0], [b, cl + s, 0], [0, 0, cl + g]])


@dataclass(frozen=True)
class MonotoneLine:
    """One line. *length* is what is shared between free span, arc and dead span; *drop* of 0 is no modelled dead span.

    *side* is +1 over, -1 under. *radius* 0 is an eyelet. The dead span hangs straight down by *drop*; below its least
    tension it keeps the length that it has there, as the proof extends it. *elastic_arc* lets the arc stretch.
    """

    length: mpf
    weight: mpf
    compliance: mpf
    radius: mpf = ZERO
    side: int = 1
    drop: mpf = ZERO
    elastic_arc: bool = False

    @property
    def longest_dead(self) -> mpf:
        return 2 * self.drop / (1 + mp.sqrt(1 + 2 * self.compliance * self.weight * self.drop))

    @property
    def kappa(self) -> mpf:
        return self.compliance * self.weight * self.longest_dead

    @property
    def skew(self) -> mpf:
        """s: how far the Jacobian may be from symmetric, and what the sheave takes from the modulus."""
        if self.drop > 0:
            return self.radius * self.compliance * (1 + self.kappa / 2) / (1 - self.kappa)
        return self.radius * self.compliance / 2

    @property
    def modulus(self) -> mpf:
        arc = mp.pi * self.radius
        return self.compliance * (self.length - arc - self.longest_dead) - self.skew

    def dead(self, tension: mpf) -> mpf:
        """Unstrained length of the dead span."""
        if self.drop == 0:
            return mpf(0)
        cw = self.compliance * self.weight
        tension = max(tension, self.weight * self.longest_dead)
        stretch = 1 + self.compliance * tension
        return 2 * self.drop / (stretch + mp.sqrt(stretch**2 - 2 * cw * self.drop))

    def free(self, h: mpf, v: mpf) -> mpf:
        """Length of the free span whose start force is (h, v)."""
        t = mp.hypot(h, v)
        arc = self.radius * (mp.pi / 2 - self.side * mp.atan2(v, h))
        return self.length - (arc / (1 + self.compliance * t) if self.elastic_arc else arc) - self.dead(t)

    def start(self, h: mpf, up: mpf) -> mpf:
        """Upward start force of the free span that ends with the force (h, up): a root, bracketed."""
        low, high = up - self.weight * self.length, up
        if self.radius == 0 and self.drop == 0:
            return low
        off_low, off_high = self._off(h, up, low), self._off(h, up, high)
        for _ in range(400):
            guess = low - off_low * (high - low) / (off_high - off_low)
            middle = (low + high) / 2
            for v in (guess, middle):
                if not low < v < high:
                    continue
                off = self._off(h, up, v)
                if off < 0:
                    low, off_low = v, off
                else:
                    high, off_high = v, off
            if high - low <= mp.eps * 100 * (abs(low) + abs(high)) or off_low == 0 or off_high == 0:
                break
        return low if abs(off_low) < abs(off_high) else high

    def _off(self, h: mpf, up: mpf, v: mpf) -> mpf:
        return v + self.weight * self.free(h, v) - up

    def end(self, h: mpf, up: mpf) -> tuple[mpf, mpf]:
        """Where the free end is, in the plane, from the exit point."""
        v = self.start(h, up)
        t = mp.hypot(h, v)
        x, z = span(h, v, self.free(h, v), self.weight, self.compliance)
        turn = self.side * self.radius
        return self.radius - turn * v / t + x, turn * h / t + z

    def at(self, force: Vector) -> mp.matrix:
        """Where the free end is, in space, from the exit point, for a force in space that is not vertical."""
        h = mp.hypot(force[0], force[1])
        x, z = self.end(h, force[2])
        return mp.matrix([x * force[0] / h, x * force[1] / h, z])

    def jacobian(self, h: mpf, up: mpf) -> mp.matrix:
        """Derivative of `end` and, third, across the plane: the formula of the proof."""
        v = self.start(h, up)
        t, free = mp.hypot(h, v), self.free(h, v)
        c, w, r = self.compliance, self.weight, self.radius
        n, across = mp.matrix([h / t, v / t, 0]), mp.matrix([-v / t, h / t, 0])
        sine, eps = v / t, self.side * w * r / t
        dead, a = self.dead(t), mpf(0)
        if self.drop > 0 and t > w * self.longest_dead:
            a = c * dead / (1 + c * (t - w * dead))
        q = 1 + eps * h / t + a * w * sine
        along = a * (1 + c * t + eps * h / t) / q
        turning = (self.side * r * c * (1 + a * w * sine) - (1 + c * t) * a * eps * sine) / q
        whole = flexibility(h, v, free, w, c) + along * n * n.T + turning * n * across.T
        whole[2, 2] = self.end(h, up)[0] / h
        return whole

    def lowest(self, force: Vector) -> mpf:
        """No more than the lowest tension along the line."""
        return mp.hypot(mp.hypot(force[0], force[1]), max(-force[2], force[2] - self.weight * self.length, mpf(0)))

    def steepest(self, force: Vector, reach: mpf) -> mpf:
        """Lambda: bounds the symmetric part of each Jacobian within *reach* of *force*; inf if there is no bound."""
        h, up = mp.hypot(force[0], force[1]), force[2]
        carried = self.weight * self.length
        lowest = self.lowest(force) - reach
        if lowest <= 0 or (self.radius > 0 and h <= reach):
            return mp.inf
        bound = self.compliance * self.length + self.length / lowest + self.skew
        if self.radius > 0:
            bound += 2 * self.radius / (h - reach)
        if self.drop > 0:
            most = mp.hypot(h, max(abs(up), abs(up - carried))) + reach
            bound += (
                self.compliance * (self.longest_dead * (1 + self.compliance * most) + self.radius) / (1 - self.kappa)
            )
        return bound
