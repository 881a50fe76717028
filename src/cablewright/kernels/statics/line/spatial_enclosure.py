"""Interval equations of a line that does not hang in a vertical plane, with all their derivatives, as jets.

The unknowns are, in this order, a first coordinate across the direction of the free span in its middle, the relative
tension there, its unstrained length, the second coordinate across, and of a swivel with its winch ASIDE of its axis the
angle by which it is turned from the axis of smallest entry. Direction and tension are relative to the solution, so that
there is no seam and no pole, and a span may hang straight down. As the chord has the direction of the middle but for
terms of the second order in the weight, its derivatives by the tension stay narrow on wide boxes. The third equation is
that of the length.
"""

from math import cos as cos_of
from math import exp as exp_of
from math import sin as sin_of
from math import sqrt

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.certificates.interval import (
    ENTIRE,
    ONE,
    ROUNDING,
    ZERO,
    add,
    div,
    hull,
    inflate,
    log1p_ratio,
    mul,
    neg,
    point,
    root,
    scale,
    sqr,
    sub,
    up,
)
from cablewright.kernels.certificates.jets import (
    OWN,
    PAIRS,
    SLOPED,
    added,
    along,
    chained,
    constant,
    cross,
    dot,
    fixed,
    less,
    minus,
    of,
    over,
    pair,
    plus,
    put,
    scaled,
    square_root,
    times,
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
from cablewright.kernels.statics.line.guide_enclosure import (
    leave_aside,
    leave_pulley,
    leave_swivel,
    turn_of_swivel,
    vector,
)
from cablewright.kernels.statics.line.guides import compliance_of_mount
from cablewright.kernels.statics.platform_enclosure import along as turning
from cablewright.kernels.statics.platform_enclosure import component, turn

SERIES, TERMS = 0.25, 28  # up to where, and how many terms: the rest is below 2^-55
PARTS = 8  # of half a span over which second derivatives are integrated


@jit
def unknowns_of(row):
    """Return how many unknowns a line has in a certificate, and how many rows depend on the pose and on the force."""
    if row[GUIDE] == UPRIGHT:
        return int(row[UNKNOWNS]), 2, 3
    return (5, 4, 4) if row[GUIDE] == ASIDE else (4, 4, 4)


@jit(allocates=True)
def centre_of(row, y, pose, rotation, arm, moved, out):
    """Write the doubles nearest to a solved line's unknowns to *out* (k,); the others as of `enclose_spatial`."""
    out[:] = 0.0
    out[2] = y[FREE]
    if row[GUIDE] == ASIDE:
        c = cos_of(y[PHI])
        _, away = _platform_point(row, pose, np.zeros(pose.shape[0]), 0.0, rotation, arm, moved, SLOPED)
        out[4] = turn_of_swivel(row, fixed(c * cos_of(y[AZIMUTH]), c * sin_of(y[AZIMUTH]), sin_of(y[PHI])), away)


@jit
def tangent_of(row, y):
    """Direction and size of a solved line's tension in the middle of its free span, as plain numbers.

    The direction is given by the cosine and sine of its height, and of its azimuth.
    """
    t = exp_of(y[TAU])
    level, upright = t * cos_of(y[PHI]), t * sin_of(y[PHI]) + 0.5 * row[WEIGHT] * y[FREE]
    size = sqrt(level * level + upright * upright)
    return level / size, upright / size, cos_of(y[AZIMUTH]), sin_of(y[AZIMUTH]), size


@jit(allocates=True)
def frame_of(row, y):
    """The direction of `tangent_of`, and a horizontal and a third one across it: vectors of doubles."""
    c, s, ca, sa, _ = tangent_of(row, y)
    return fixed(c * ca, c * sa, s), fixed(-sa, ca, 0.0), fixed(-s * ca, -s * sa, c)


@jit(allocates=True)
def enclose_spatial(row, y, centre, box, given, arm, moved, equations, wrench):
    """Write the jets of a line's equations and of its wrench: *equations* (k, rows, 2) and *wrench* (n, rows, 2).

    *y*: the solved line's state; *centre*, *box* (k,): middles and radii of the unknowns. *given*: *pose*, *radius*
    (n,), the same of the pose, whose rotations are increments of up to *omega*, rad, from *rotation* (3, 3, 2);
    *length*, a double, m; and the *origin* (3,) of moments from the platform's, doubles, m. *arm*, *moved* (3, 2):
    scratch.
    """
    pose, radius, omega, rotation, length, origin = given
    n, rows, weight, one = pose.shape[0], equations.shape[1], point(row[WEIGHT]), constant(ONE)
    way, middle, free = span_at(row, y, centre, box, rows)
    heavy = over(scaled(free, scale(weight, 0.5)), middle)
    force, end = (way[0], way[1], minus(way[2], heavy)), (way[0], way[1], plus(way[2], heavy))
    tension = times(middle, square_root(dot(force, force)))
    give, (level, upright) = scaled(middle, point(row[FREE_COMPLIANCE])), _span(heavy, way[2])
    level, upright = times(free, plus(give, level)), times(free, plus(give, upright))
    chord = (times(way[0], level), times(way[1], level), times(way[2], upright))
    place, away = _platform_point(row, pose, radius, omega, rotation, arm, moved, rows)
    at_end, arc_at_end = _leave_platform(row, n, omega, rotation, arm, moved, end, away)
    away, place = added(away, at_end), added(place, at_end)
    leaves, arc, covered, moment = leave(row, centre, box, force, away, rows)
    leaves, covered = _given_way(row, along(force, middle), tension, leaves, covered)
    gap = less(added(leaves, chord), away)
    put(gap[0], equations[0])
    put(gap[1], equations[1])
    put(gap[2], equations[3])
    dead = _dead_length(row, covered, tension)
    if row[COUNTERWEIGHT] > 0.0:
        hung = scaled(dead, mul(weight, point(row[WINCH_RISE])))
        put(minus(plus(tension, hung), constant(point(row[COUNTERWEIGHT]))), equations[2])
    else:
        taken = plus(one, scaled(tension, point(row[ARC_COMPLIANCE])))
        whole = plus(plus(scaled(free, point(row[SPANS])), dead), over(plus(arc, arc_at_end), taken))
        rest = sub(point(row[DEAD_LENGTH]) if row[UNKNOWNS] == 3.0 else ZERO, point(length))
        put(minus(plus(whole, constant(rest)), scaled(tension, point(row[END_SPRING]))), equations[2])
    if row[GUIDE] == ASIDE:
        put(moment, equations[4])
    pull = along(end, scaled(middle, point(-row[PULLS])))
    about = cross(less(place, fixed(origin[0], origin[1], origin[2])), pull)
    for k in range(n):
        put(pull[k] if k < 3 else about[k - 3], wrench[k])


@jit(allocates=True)
def span_at(row, y, centre, box, rows):
    """Direction and size, N, of the tension in the middle of the free span, and its unstrained length, m.

    The direction is the unit vector of e + u e' + v e'' in the frame of the state *y*, the size its own (1 + theta).
    """
    ahead, aside, third = frame_of(row, y)
    u, v = _unknown(centre, box, 0, rows), _unknown(centre, box, 3, rows)
    way = unit(added(added(ahead, along(aside, u)), along(third, v)))
    size = scaled(plus(constant(ONE), _unknown(centre, box, 1, rows)), point(tangent_of(row, y)[4]))
    return way, size, _unknown(centre, box, 2, rows)


@jit(allocates=True)
def _span(heavy, v):
    """Mean of 1 / q over a span and, over *v*, of its vertical part; q is the tension over that in the middle.

    At a share s of the length from the middle q^2 = 1 + 4 s h v + 4 s^2 h^2: *heavy* h is the weight of half the span
    over the tension in the middle, and *v* the sine of its height. With x = 2 h / (q(-1/2) + q(1/2)) the means are
    (x / h) artanh(x) / x, the potential of a rod, and x / h. Neither has terms of odd order in h.
    """
    square, one = times(heavy, heavy), constant(ONE)
    whole = plus(one, square)
    both = square_root(minus(times(whole, whole), scaled(times(square, times(v, v)), (4.0, 4.0))))
    mean = over(constant((1.4142135623730949, 1.4142135623730951)), square_root(plus(whole, both)))
    if heavy.shape[0] > SLOPED:
        return _integrated(heavy, v), mean
    inner = times(square, times(mean, mean))
    low, high = _rod(of(inner, 0)[0]), _rod(of(inner, 0)[1])
    return times(mean, chained(inner, hull(low[0], high[0]), hull(low[1], high[1]), ZERO)), mean


@jit
def _rod(y):
    """Enclose artanh(x) / x and its derivative by y = x^2, which both grow with y >= 0, at the double *y*."""
    if not 0.0 <= y < 1.0:
        return ENTIRE, ENTIRE
    if y > SERIES:
        x = root(point(y))
        apart = sub(ONE, x)
        value = div(log1p_ratio(div(scale(x, 2.0), apart)), apart)
        return value, div(sub(div(ONE, sub(ONE, point(y))), value), point(2.0 * y))
    value, slope, power = ZERO, ZERO, ONE
    for k in range(TERMS):  # 1 / (2 k + 1) in powers of y
        value = add(value, div(power, point(2.0 * k + 1.0)))
        slope = add(slope, mul(power, div(point(k + 1.0), point(2.0 * k + 3.0))))
        power = mul(power, point(y))
    rest = power[1]  # more than the sum of all terms that are left
    return (value[0], up(value[1] + rest)), (slope[0], up(slope[1] + rest))


@jit(allocates=True)
def _integrated(heavy, v):
    """The mean of 1 / q with its derivatives, as `_span`, from enclosures on PARTS of half the span.

    Each is of both halves together, as terms of odd order cancel.
    """
    h, w, sums = of(heavy, 0), of(v, 0), np.zeros((6, 2))
    for j in range(PARTS):
        s = (float(j) / PARTS, (j + 1.0) / PARTS)  # exact; twice the share
        a = mul(h, s)
        after, before = add(w, a), sub(w, a)  # half the derivative of q^2 by h is s times these
        square, rest = sqr(a), scale(mul(a, w), 2.0)
        above, below = add(add(ONE, square), rest), sub(add(ONE, square), rest)  # q^2 on both sides
        cube, other = div(ONE, mul(above, root(above))), div(ONE, mul(below, root(below)))
        fifth, another = div(scale(cube, 3.0), above), div(scale(other, 3.0), below)
        cubes, fifths = add(cube, other), add(fifth, another)
        powers = add(add(sqr(above), mul(above, below)), sqr(below))
        apart = mul(scale(rest, -2.0), div(mul(mul(cube, other), powers), add(div(ONE, cube), div(ONE, other))))
        _sum(sums, 0, add(mul(cube, above), mul(other, below)))
        _sum(sums, 1, neg(mul(a, apart)))  # by v
        _sum(sums, 2, neg(mul(s, add(mul(w, apart), mul(a, cubes)))))  # by h
        _sum(sums, 3, mul(square, fifths))
        _sum(sums, 4, mul(s, sub(mul(a, add(mul(w, fifths), mul(a, sub(fifth, another)))), apart)))
        bent = add(mul(sqr(after), fifth), mul(sqr(before), another))
        _sum(sums, 5, mul(sqr(s), sub(bent, cubes)))
    out = np.empty_like(heavy)
    out[0, 0], out[0, 1] = of(sums, 0)
    for k in range(1, out.shape[0]):
        value = add(mul(of(sums, 1), of(v, k)), mul(of(sums, 2), of(heavy, k)))
        if k >= SLOPED:
            p, q = pair(k)
            vp, vq, hp, hq = of(v, p), of(v, q), of(heavy, p), of(heavy, q)
            value = add(value, add(mul(of(sums, 3), mul(vp, vq)), mul(of(sums, 5), mul(hp, hq))))
            value = add(value, mul(of(sums, 4), add(mul(vp, hq), mul(vq, hp))))
        out[k, 0], out[k, 1] = value
    return out


@jit
def _sum(sums, k, value):
    sums[k, 0], sums[k, 1] = add(of(sums, k), scale(value, 0.5 / PARTS))


@jit(allocates=True)
def _unknown(centre, box, k, rows):
    return variable(inflate(point(centre[k]), box[k]), k, rows)


@jit(allocates=True)
def _platform_point(row, pose, radius, omega, rotation, arm, moved, rows):
    """Platform point from the platform's origin, and from the exit point."""
    place, given = _placed(row, POINT_X, pose.shape[0], omega, rotation, arm, moved, rows), (pose, radius, rows)
    return place, added(place, (_offset(row, 0, given), _offset(row, 1, given), _offset(row, 2, given)))


@jit(allocates=True)
def _offset(row, k, given):
    """Pose coordinate *k* from the exit point."""
    pose, radius, rows = given
    out = variable(inflate(point(pose[k]), radius[k]), OWN + k, rows)
    out[0, 0], out[0, 1] = sub(of(out, 0), point(row[EXIT_X + k]))
    return out


@jit(allocates=True)
def _turning(value, rows):
    """Jet with *rows* that are still to be filled."""
    out = np.zeros((rows, 2))
    out[0, 0], out[0, 1] = value
    return out


@jit(allocates=True)
def _placed(row, at, n, omega, rotation, arm, moved, rows):
    """Vector of the platform in columns *at* of a line, turned with a body."""
    if n == 3:
        return vector(row, at)
    turn(row[at], row[at + 1], row[at + 2], omega, rotation, arm)
    size = sqrt(row[at] ** 2 + row[at + 1] ** 2 + row[at + 2] ** 2)
    bend = size * (1.0 + 2.0 * omega) * ROUNDING  # of exp([d]x) b, for omega <= 1
    out = _turning(component(arm, 0), rows), _turning(component(arm, 1), rows), _turning(component(arm, 2), rows)
    for k in range(3, 6):
        turning(k, omega, arm, moved)
        for j in range(3):
            out[j][1 + OWN + k, 0], out[j][1 + OWN + k, 1] = component(moved, j)
    for k in range(SLOPED, rows):
        if PAIRS[k - SLOPED, 0] >= OWN:
            for j in range(3):
                out[j][k, 0], out[j][k, 1] = -bend, bend
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
def leave(row, centre, box, force, away, rows):
    """Contact point from the exit point, contact length and distance of the dead span of the guide at the frame.

    As `guides.leave_frame`; the contact point is relative to the exit point. The last jet is the moment about a swivel
    whose winch is ASIDE of its axis, else zero.
    """
    nothing = constant(ZERO)
    covered = constant(point(row[DEAD_SPAN]))
    axis = vector(row, AXIS_X)
    if row[GUIDE] == ASIDE:
        return leave_aside(row, _unknown(centre, box, 4, rows), force)
    if row[GUIDE] == SWIVEL:
        leaves, arc = leave_swivel(axis, row[RADIUS], row[SIDE], force, away)
        return leaves, arc, covered, nothing
    if row[GUIDE] == PULLEY:
        arrival = vector(row, ARRIVAL_X)
        leaves, arc = leave_pulley(axis, arrival, row[RADIUS], force)
        return leaves, arc, covered, nothing
    return (nothing, nothing, nothing), nothing, covered, nothing


@jit(allocates=True)
def _leave_platform(row, n, omega, rotation, arm, moved, end, away):
    """Contact point from the platform point, and contact length, as `guides.leave_platform`."""
    nothing, rows = constant(ZERO), away[0].shape[0]
    if row[END_RADIUS] == 0.0:
        return (nothing, nothing, nothing), nothing
    axis = _placed(row, END_AXIS_X, n, omega, rotation, arm, moved, rows)
    minus_one = constant((-1.0, -1.0))
    force = along(end, minus_one)
    if row[END_ARRIVAL_X] == row[END_ARRIVAL_X + 1] == row[END_ARRIVAL_X + 2] == 0.0:
        return leave_swivel(axis, row[END_RADIUS], 1.0, force, along(away, minus_one))
    arrival = _placed(row, END_ARRIVAL_X, n, omega, rotation, arm, moved, rows)
    return leave_pulley(along(axis, minus_one), arrival, row[END_RADIUS], force)
