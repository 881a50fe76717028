"""Interval equations of a line that does not hang in a vertical plane, with all their derivatives, as jets.

They are those of `spatial`. The unknowns are the force (N, world) with which the free span leaves the frame, its
unstrained length and, of a swivel with its winch ASIDE of its axis, the angle by which it is turned from the axis of
smallest entry. Cartesian forces have no seam and no pole, so that a span may hang straight down.
"""

from math import inf

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.certificates.interval import (
    ONE,
    PI,
    ZERO,
    add,
    contains_zero,
    cos,
    div,
    exp,
    inflate,
    mul,
    neg,
    point,
    root,
    scale,
    sin,
    sqr,
    sub,
)
from cablewright.kernels.certificates.jets import (
    OWN,
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
from cablewright.kernels.layout import (
    ARC_COMPLIANCE,
    ARRIVAL_X,
    ASIDE,
    AXIS_X,
    AZIMUTH,
    COUNTERWEIGHT,
    DEAD_COMPLIANCE,
    DEAD_LENGTH,
    DEAD_SPAN,
    END_ARRIVAL_X,
    END_AXIS_X,
    END_RADIUS,
    END_SPRING,
    EXIT_X,
    EYELET,
    FREE,
    FREE_COMPLIANCE,
    GUIDE,
    MEAN_RISE,
    MOUNT,
    PHI,
    POINT_X,
    PULLEY,
    PULLS,
    RADIUS,
    SIDE,
    SPANS,
    SWIVEL,
    TAU,
    UNKNOWNS,
    UPRIGHT,
    WEIGHT,
    WINCH_RISE,
)
from cablewright.kernels.statics.line.enclosure import span_tensions
from cablewright.kernels.statics.line.guides import compliance_of_mount
from cablewright.kernels.statics.platform_enclosure import along as turning
from cablewright.kernels.statics.platform_enclosure import component, turn

TWO_PI = (2.0 * PI[0], 2.0 * PI[1])
TURNS = 30  # Newton steps for the angle of a swivel
TURN = 0.3  # rad: the longest of them
GRAIN = 1e-15  # rad: a step that ends them


@jit
def unknowns_of(row):
    """Return how many unknowns a line has in a certificate, and how many rows depend on the pose and on the force."""
    if row[GUIDE] == UPRIGHT:
        return int(row[UNKNOWNS]), 2, 3
    return (5, 4, 4) if row[GUIDE] == ASIDE else (4, 4, 4)


@jit(allocates=True)
def centre_of(row, y, pose, rotation, arm, moved, out):
    """Write a solved line's unknowns, rounded to doubles, to *out* (k,); other arguments as of `enclose_spatial`."""
    t, h = exp(point(y[TAU])), cos(point(y[PHI]))
    out[0] = _middle(mul(mul(t, h), cos(point(y[AZIMUTH]))))
    out[1] = _middle(mul(mul(t, h), sin(point(y[AZIMUTH]))))
    out[2] = _middle(mul(t, sin(point(y[PHI]))))
    out[3] = y[FREE]
    if row[GUIDE] == ASIDE:
        _, away = _platform_point(row, pose, np.zeros(pose.shape[0]), 0.0, rotation, arm, moved)
        out[4] = _turn_of_swivel(row, fixed(out[0], out[1], out[2]), away)


@jit
def _middle(a):
    return 0.5 * (a[0] + a[1])


@jit(allocates=True)
def enclose_spatial(row, y, box, pose, radius, omega, rotation, length, arm, moved, equations, wrench):
    """Write the jets of a line's equations, *equations* (k, 1 + SLOTS, 2), and of its *wrench* (n, .., 2).

    *y*, *box* (k,): midpoints and radii of the unknowns; *pose*, *radius* (n,): the same of the pose, whose rotations
    are increments of up to *omega*, rad, from *rotation* (3, 3, 2). *length*: double, m. *arm*, *moved* (3, 2):
    scratch.
    """
    n, weight = pose.shape[0], point(row[WEIGHT])
    f0, f1, f2 = _unknown(y, box, 0), _unknown(y, box, 1), _unknown(y, box, 2)
    free, force = _unknown(y, box, 3), (f0, f1, f2)
    end = (f0, f1, plus(f2, scaled(free, weight)))
    stretched = plus(scaled(free, point(row[FREE_COMPLIANCE])), _integral(row, y, box))
    tension = square_root(dot(force, force))
    both = plus(tension, square_root(dot(end, end)))
    rise = times(
        times(free, plus(f2, end[2])), plus(constant(point(0.5 * row[FREE_COMPLIANCE])), over(constant(ONE), both))
    )
    chord = (times(f0, stretched), times(f1, stretched), rise)
    place, away = _platform_point(row, pose, radius, omega, rotation, arm, moved)
    at_end, arc_at_end = _leave_platform(row, n, omega, rotation, arm, moved, end, away)
    away, place = added(away, at_end), added(place, at_end)
    leaves, arc, covered, moment = leave(row, y, box, force, away)
    leaves, covered = _given_way(row, force, tension, leaves, covered)
    gap = less(added(leaves, chord), away)
    for k in range(3):
        equations[k] = gap[k]
    dead = _dead_length(row, covered, tension)
    if row[COUNTERWEIGHT] > 0.0:
        hung = scaled(dead, mul(weight, point(row[WINCH_RISE])))
        equations[3] = minus(plus(tension, hung), constant(point(row[COUNTERWEIGHT])))
    else:
        taken = plus(constant(ONE), scaled(tension, point(row[ARC_COMPLIANCE])))
        whole = plus(plus(scaled(free, point(row[SPANS])), dead), over(plus(arc, arc_at_end), taken))
        rest = sub(point(row[DEAD_LENGTH]) if row[UNKNOWNS] == 3.0 else ZERO, point(length))
        equations[3] = minus(plus(whole, constant(rest)), scaled(tension, point(row[END_SPRING])))
    if row[GUIDE] == ASIDE:
        equations[4] = moment
    pull = along(end, constant(point(-row[PULLS])))
    about = cross(place, pull)
    for k in range(n):
        wrench[k] = pull[k] if k < 3 else about[k - 3]


@jit(allocates=True)
def _unknown(y, box, k):
    return variable(inflate(point(y[k]), box[k]), k)


@jit(allocates=True)
def _platform_point(row, pose, radius, omega, rotation, arm, moved):
    """Platform point from the platform's origin, and from the exit point."""
    place = _placed(row, POINT_X, pose.shape[0], omega, rotation, arm, moved)
    offset = _offset(row, pose, radius, 0), _offset(row, pose, radius, 1), _offset(row, pose, radius, 2)
    return place, added(place, offset)


@jit(allocates=True)
def _offset(row, pose, radius, k):
    """Pose coordinate *k* from the exit point."""
    out = variable(inflate(point(pose[k]), radius[k]), OWN + k)
    out[0, 0], out[0, 1] = sub(of(out, 0), point(row[EXIT_X + k]))
    return out


@jit(allocates=True)
def _vector(row, at):
    """Vector of doubles in columns *at* of a line."""
    return fixed(row[at], row[at + 1], row[at + 2])


@jit(allocates=True)
def _placed(row, at, n, omega, rotation, arm, moved):
    """Vector of the platform in columns *at* of a line, turned with a body."""
    if n == 3:
        return _vector(row, at)
    turn(row[at], row[at + 1], row[at + 2], omega, rotation, arm)
    out = (constant(component(arm, 0)), constant(component(arm, 1)), constant(component(arm, 2)))
    for k in range(3, 6):
        turning(k, omega, arm, moved)
        for j in range(3):
            out[j][1 + OWN + k, 0], out[j][1 + OWN + k, 1] = component(moved, j)
    return out


@jit(allocates=True)
def _integral(row, y, box):
    """Integral of ds / T along the free span, with its derivatives by the force at its start and by its length."""
    h0, h1, v = inflate(point(y[0]), box[0]), inflate(point(y[1]), box[1]), inflate(point(y[2]), box[2])
    length, square = inflate(point(y[3]), box[3]), add(sqr(h0), sqr(h1))
    v1, t0, t1, reach = span_tensions(square, v, length, row[WEIGHT])
    out, both, product = constant(reach), add(v, v1), mul(t0, t1)
    if row[WEIGHT] == 0.0:
        cube = div(length, mul(product, t0))
    elif v[0] > 0.0 or v1[1] < 0.0:
        cube = div(mul(length, both), mul(product, add(mul(v1, t0), mul(v, t1))))
    else:
        cube = div(sub(div(v1, t1), div(v, t0)), mul(point(row[WEIGHT]), square))
    out[1, 0], out[1, 1] = neg(mul(h0, cube))
    out[2, 0], out[2, 1] = neg(mul(h1, cube))
    out[3, 0], out[3, 1] = neg(div(mul(length, both), mul(add(t0, t1), product)))
    out[4, 0], out[4, 1] = div(ONE, t1)
    return out


@jit(allocates=True)
def _dead_length(row, covered, tension):
    """Unstrained length of the dead span, as `spatial.dead_length`."""
    compliance = point(row[DEAD_COMPLIANCE])
    bend = mul(mul(compliance, point(2.0 * row[WEIGHT])), point(row[MEAN_RISE]))
    linear = plus(constant(ONE), scaled(tension, compliance))
    return over(
        scaled(covered, (2.0, 2.0)), plus(linear, square_root(plus(times(linear, linear), scaled(covered, bend))))
    )


@jit(allocates=True)
def _given_way(row, force, tension, leaves, covered):
    """Contact point and distance of the dead span with the deflection of the mount, as `guides.give_way`."""
    if row[MOUNT] + row[MOUNT + 1] + row[MOUNT + 2] == 0.0:
        return leaves, covered
    x, y, z = _towards_winch(row)
    dead = scaled(tension, div(ONE, point(row[SPANS])))
    load = (plus(force[0], scaled(dead, x)), plus(force[1], scaled(dead, y)), plus(force[2], scaled(dead, z)))
    given = (_given(row, load, 0), _given(row, load, 1), _given(row, load, 2))
    less_covered = plus(plus(scaled(given[0], x), scaled(given[1], y)), scaled(given[2], z))
    return added(leaves, given), minus(covered, less_covered)


@jit(allocates=True)
def _given(row, load, i):
    """Coordinate *i* of the mount's deflection under the *load* of one cable."""
    out = constant(ZERO)
    for j in range(3):
        out = plus(out, scaled(load[j], mul(point(row[PULLS]), point(compliance_of_mount(row, i, j)))))
    return out


@jit
def _towards_winch(row):
    """Enclose the unit vector of `guides.towards_winch`."""
    x, y, z = point(row[ARRIVAL_X]), point(row[ARRIVAL_X + 1]), point(row[ARRIVAL_X + 2])
    if row[UNKNOWNS] < 4.0 or row[GUIDE] == ASIDE:
        return ZERO, ZERO, ZERO
    if row[GUIDE] == EYELET:
        far = root(add(add(sqr(x), sqr(y)), sqr(z)))
        return div(x, far), div(y, far), div(z, far)
    a, b, c = point(row[AXIS_X]), point(row[AXIS_X + 1]), point(row[AXIS_X + 2])
    if row[GUIDE] == PULLEY:
        return sub(mul(y, c), mul(z, b)), sub(mul(z, a), mul(x, c)), sub(mul(x, b), mul(y, a))
    return scale(a, -row[SIDE]), scale(b, -row[SIDE]), scale(c, -row[SIDE])


@jit(allocates=True)
def leave(row, y, box, force, away):
    """Enclose where a cable leaves its guide at the frame: contact point, contact length, distance of the dead span.

    As `guides.leave_frame`; the contact point is relative to the exit point. The last jet is the moment about a swivel
    whose winch is ASIDE of its axis, else zero.
    """
    nothing = constant(ZERO)
    covered = constant(point(row[DEAD_SPAN]))
    axis = _vector(row, AXIS_X)
    if row[GUIDE] == ASIDE:
        return _leave_aside(row, _unknown(y, box, 4), force)
    if row[GUIDE] == SWIVEL:
        leaves, arc = _leave_swivel(axis, row[RADIUS], row[SIDE], force, away)
        return leaves, arc, covered, nothing
    if row[GUIDE] == PULLEY:
        arrival = _vector(row, ARRIVAL_X)
        leaves, arc = _leave_pulley(axis, arrival, row[RADIUS], force)
        return leaves, arc, covered, nothing
    return (nothing, nothing, nothing), nothing, covered, nothing


@jit(allocates=True)
def _leave_platform(row, n, omega, rotation, arm, moved, end, away):
    """Contact point from the platform point, and contact length, as `guides.leave_platform`."""
    nothing = constant(ZERO)
    if row[END_RADIUS] == 0.0:
        return (nothing, nothing, nothing), nothing
    axis = _placed(row, END_AXIS_X, n, omega, rotation, arm, moved)
    minus_one = constant((-1.0, -1.0))
    force = along(end, minus_one)
    if row[END_ARRIVAL_X] == row[END_ARRIVAL_X + 1] == row[END_ARRIVAL_X + 2] == 0.0:
        return _leave_swivel(axis, row[END_RADIUS], 1.0, force, along(away, minus_one))
    arrival = _placed(row, END_ARRIVAL_X, n, omega, rotation, arm, moved)
    return _leave_pulley(along(axis, minus_one), arrival, row[END_RADIUS], force)


@jit(allocates=True)
def _leave_swivel(axis, radius, side, force, toward):
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
def _leave_pulley(axis, arrival, radius, force):
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
def _leave_aside(row, turned, force):
    """As `leave`, of a swivel *turned* by an unknown angle, where the moments of both spans about its axis balance."""
    axis = _vector(row, AXIS_X)
    winch = _vector(row, ARRIVAL_X)
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
def _turn_of_swivel(row, force, away):
    """Angle by which a swivel ASIDE is turned under the *force*: Newton from where the force and *away* point."""
    axis = _vector(row, AXIS_X)
    first = _zero_of_swivel(row, axis)
    second = cross(axis, first)
    x, y = of(dot(force, first), 0)[0], of(dot(force, second), 0)[0]
    toward = of(dot(away, first), 0)[0] * x + of(dot(away, second), 0)[0] * y
    sign = -1.0 if toward < 0.0 else 1.0
    turned = _middle(of(angle(constant((sign * x, sign * x)), constant((sign * y, sign * y))), 0))
    for _ in range(TURNS):
        moment = _leave_aside(row, variable((turned, turned), 4), force)[3]
        step = _middle(of(moment, 0)) / _middle(of(moment, 1 + 4))  # by the angle, in slot 4
        if abs(step) < GRAIN or not abs(step) < inf:
            break
        turned -= min(max(step, -TURN), TURN)
    return turned
