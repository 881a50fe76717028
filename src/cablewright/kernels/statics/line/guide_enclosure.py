"""Enclosures of where a cable leaves a swivel or a pulley out of the plane, and of its length there, as jets."""

from math import inf

from cablewright.kernels import jit
from cablewright.kernels.certificates.interval import PI, contains_zero, mul, point
from cablewright.kernels.certificates.jets import (
    SLOPED,
    added,
    along,
    angle,
    constant,
    cosine,
    cross,
    dot,
    fixed,
    less,
    minus,
    of,
    over,
    plus,
    scaled,
    sine,
    square_root,
    times,
    unbounded,
    unit,
    variable,
)
from cablewright.kernels.layout import ARRIVAL_X, AXIS_X, DEAD_SPAN, RADIUS, SIDE

TWO_PI = (2.0 * PI[0], 2.0 * PI[1])
TURNS = 30  # Newton steps for the angle of a swivel
TURN = 0.3  # rad: the longest of them
GRAIN = 1e-15  # rad: a step that ends them


@jit(allocates=True)
def vector(row, at):
    """Vector of doubles in columns *at* of a line."""
    return fixed(row[at], row[at + 1], row[at + 2])


@jit(allocates=True)
def leave_swivel(axis, radius, side, force, toward):
    """Contact point and length of a sheave whose centre is one *radius* from its *axis*, on the side of *toward*."""
    rise = dot(force, axis)
    out = less(force, along(axis, rise))
    away = square_root(dot(out, out))
    size, facing = square_root(plus(times(away, away), times(rise, rise))), of(dot(out, toward), 0)
    if contains_zero(facing):
        return (unbounded(), unbounded(), unbounded()), unbounded()
    if facing[1] < 0.0:
        away = scaled(away, (-1.0, -1.0))
    c, s = over(away, size), over(rise, size)
    turned = point(side * radius)
    reach = minus(constant(point(radius)), scaled(s, turned))
    leaves = added(along(out, over(reach, away)), along(axis, scaled(c, turned)))
    quarter = constant(mul(point(0.5 * radius), PI))
    if of(c, 0)[1] < 0.0 and contains_zero(of(s, 0)):
        return leaves, unbounded()
    return leaves, minus(quarter, scaled(angle(c, s), turned))


@jit(allocates=True)
def leave_pulley(axis, arrival, radius, force):
    """Contact point and length of a wheel on a fixed *axis*, about which the cable travels from its *arrival* on."""
    inside = less(force, along(axis, dot(force, axis)))
    radial = cross(unit(inside), axis)
    turned = _wound(angle(dot(arrival, radial), dot(cross(axis, arrival), radial)))
    return along(radial, constant(point(radius))), scaled(turned, point(radius))


@jit(allocates=True)
def _wound(turned):
    """Angle of contact, rad, above -pi / 2 and up to 3 pi / 2."""
    lowest = -0.5 * PI[1]
    if of(turned, 0)[0] > lowest:
        return turned
    return plus(turned, constant(TWO_PI)) if of(turned, 0)[1] < lowest else unbounded()


@jit(allocates=True)
def leave_aside(row, turned, force):
    """As `leave`, of a swivel *turned* by an unknown angle, where the moments of both spans about its axis balance."""
    axis = vector(row, AXIS_X)
    winch = vector(row, ARRIVAL_X)
    first = _zero_of_swivel(row, axis)
    e = added(along(first, cosine(turned)), along(cross(axis, first), sine(turned)))
    n = cross(axis, e)
    toward = unit(force)
    fe, fn, rise = dot(toward, e), dot(toward, n), dot(toward, axis)
    wn, fall, radius = dot(winch, n), dot(winch, axis), constant(point(row[RADIUS]))
    ahead, turn_radius = minus(dot(winch, e), radius), point(row[SIDE] * row[RADIUS])
    flat = square_root(plus(times(fe, fe), times(rise, rise)))
    c, s = over(fe, flat), over(rise, flat)
    far = plus(times(ahead, ahead), times(fall, fall))
    square = minus(far, times(radius, radius))
    reach, span = square_root(square), square_root(plus(square, times(wn, wn)))
    cp = over(minus(times(ahead, reach), scaled(fall, turn_radius)), far)
    sp = over(plus(times(fall, reach), scaled(ahead, turn_radius)), far)
    leaves, enters = minus(radius, scaled(s, turn_radius)), plus(radius, scaled(sp, turn_radius))
    moment = plus(times(leaves, fn), over(times(enters, wn), span))
    between = angle(plus(times(cp, c), times(sp, s)), minus(times(sp, c), times(cp, s)))
    wrap = _wound(plus(scaled(between, point(row[SIDE])), constant(PI)))
    contact = added(along(e, leaves), along(axis, scaled(c, turn_radius)))
    return contact, scaled(wrap, point(row[RADIUS])), plus(span, constant(point(row[DEAD_SPAN]))), moment


@jit(allocates=True)
def _zero_of_swivel(row, axis):
    """Unit vector across the *axis* from which a swivel's angle is measured."""
    k = 0
    for j in range(1, 3):
        if abs(row[AXIS_X + j]) < abs(row[AXIS_X + k]):
            k = j
    edge = fixed(1.0 if k == 0 else 0.0, 1.0 if k == 1 else 0.0, 1.0 if k == 2 else 0.0)
    return unit(less(edge, along(axis, axis[k])))


@jit(allocates=True)
def turn_of_swivel(row, force, away):
    """Angle by which a swivel ASIDE is turned under the *force*: Newton from where the force and *away* point."""
    axis = vector(row, AXIS_X)
    first = _zero_of_swivel(row, axis)
    second = cross(axis, first)
    x, y = of(dot(force, first), 0)[0], of(dot(force, second), 0)[0]
    toward = of(dot(away, first), 0)[0] * x + of(dot(away, second), 0)[0] * y
    sign = -1.0 if toward < 0.0 else 1.0
    turned = _middle(of(angle(constant((sign * x, sign * x)), constant((sign * y, sign * y))), 0))
    for _ in range(TURNS):
        moment = leave_aside(row, variable((turned, turned), 4, SLOPED), force)[3]
        step = _middle(of(moment, 0)) / _middle(of(moment, 1 + 4))  # by the angle, in slot 4
        if abs(step) < GRAIN or not abs(step) < inf:
            break
        turned -= min(max(step, -TURN), TURN)
    return turned


@jit
def _middle(a):
    return 0.5 * (a[0] + a[1])
