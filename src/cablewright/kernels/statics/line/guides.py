"""Guides of a cable in space (eyelet, swivel, pulley): the point where the cable leaves for a given tension vector.

All are without friction and bearing torque, so that the tension on both sides is the same. A swivel turns about any
axis until the axis, the sheave and the tension vector lie in one plane, because the cable on its other side runs along
the axis, or, where it comes from a winch aside of it, until both tensions have no moment about the axis. A pulley turns
in a fixed plane. Where a cable leaves or enters obliquely, the groove carries the force out of the sheave's plane: it
touches the rim where its tension vector, seen along the wheel's axis, is tangent. All depends on the direction of the
force alone, except the deflection of a compliant mount, which depends also on its size.
"""

from math import asin, atan2, cos, pi, sin, sqrt

from cablewright.kernels import jit
from cablewright.kernels.layout import (
    ARRIVAL_X,
    ASIDE,
    AXIS_X,
    DEAD_SPAN,
    END_ARRIVAL_X,
    END_AXIS_X,
    END_RADIUS,
    EYELET,
    GUIDE,
    MOUNT,
    PULLEY,
    PULLS,
    RADIUS,
    SIDE,
    SPANS,
    SWIVEL,
    UNKNOWNS,
    UPRIGHT,
)
from cablewright.kernels.rotation import rotate

# State of a guide, from `at` on: its contact point and what changes with the force f that leaves it.
CONTACT_POINT = 0  # 0..2: contact point from the guide's own point, m
BY_FORCE = 3  # 3..11: derivative of the point by f, rows x, y, z, m/N
ARC = 12  # contact length, m
ARC_BY_FORCE = 13  # 13..15: its derivative by f, m/N
SPAN = 16  # distance that the dead span covers, m
SPAN_BY_FORCE = 17  # 17..19: its derivative by f, m/N
POINT_BY_RADIUS = 20  # 20..22: derivative of the point by the sheave's radius, of a guide ASIDE
ARC_BY_RADIUS, SPAN_BY_RADIUS = 23, 24  # the same of contact length and dead span
GIVEN_WAY = 25  # 25..27: what of the contact point is how far the mount gives, m
TOWARDS = 28  # 28..30: unit vector to where the cable of a guide ASIDE comes from
GUIDE_SIZE = 31

NO_PLANE = 1e-9  # sine of the angle to the axis under which a sheave has no plane
UNWOUND = 1.5 * pi  # rad: a larger angle of contact is one below zero
TURNS = 50  # steps of the search for the angle of a swivel
TURN = 0.3  # rad: the longest of them
TURNED = 1e-15  # rad


@jit
def leave_frame(row, fx, fy, fz, away, out, at):
    """Write the guide at the frame of line *row*, where the cable leaves with the force (fx, fy, fz), to *out*.

    A sheave's plane holds its axis and the force. Its centre is on the side of *away* (x, y, z), the vector from the
    exit point to the platform point: close to the axis the cable leaves backwards. False where the force is along the
    axis, so that the sheave has no plane.
    """
    if row[GUIDE] == ASIDE:
        return _leave_aside(row, (fx, fy, fz), away, out, at)
    if row[GUIDE] == SWIVEL:
        out[at + SPAN] = row[DEAD_SPAN]
        axis = (row[AXIS_X], row[AXIS_X + 1], row[AXIS_X + 2])
        return _leave_swivel(axis, row[RADIUS], row[SIDE], (fx, fy, fz), away, out, at)
    if row[GUIDE] == PULLEY:
        out[at + SPAN] = row[DEAD_SPAN]
        axis = (row[AXIS_X], row[AXIS_X + 1], row[AXIS_X + 2])
        arrival = (row[ARRIVAL_X], row[ARRIVAL_X + 1], row[ARRIVAL_X + 2])
        return _leave_pulley(axis, arrival, row[RADIUS], (fx, fy, fz), out, at)
    _clear(out, at)
    out[at + SPAN] = row[DEAD_SPAN]
    return True


@jit
def give_way(row, fx, fy, fz, tension, out, at):
    """Add to the guide at the frame the deflection of its mount under the forces of the free and the dead span.

    The free span leaves with the force (fx, fy, fz); with a *tension* above 0 N it has that size, whatever this one's
    is, and does not change. Where the dead span is not modelled its winch is on the same mount.
    """
    out[at + GIVEN_WAY] = out[at + GIVEN_WAY + 1] = out[at + GIVEN_WAY + 2] = 0.0
    if row[MOUNT] + row[MOUNT + 1] + row[MOUNT + 2] == 0.0:
        return
    size = sqrt(fx * fx + fy * fy + fz * fz)
    held = tension > 0.0
    grow = row[PULLS] * (tension / size if held else 1.0)  # of the force, to that of all spans of the line
    f, towards = (fx, fy, fz), towards_winch(row)
    dead = size / row[SPANS]
    for i in range(3):
        for j in range(3):
            soft = grow * compliance_of_mount(row, i, j)
            out[at + GIVEN_WAY + i] += soft * (f[j] + dead * towards[j])
            along = 0.0  # compliance times the part of the force's change that is along the force, over its size
            for k in range(3):
                along += compliance_of_mount(row, i, k) * (-f[k] if held else dead * towards[k])
            slope = soft + grow * along * f[j] / (size * size)
            out[at + BY_FORCE + 3 * i + j] += slope
            out[at + SPAN_BY_FORCE + j] -= towards[i] * slope
    for i in range(3):
        out[at + CONTACT_POINT + i] += out[at + GIVEN_WAY + i]
        out[at + SPAN] -= towards[i] * out[at + GIVEN_WAY + i]


@jit
def compliance_of_mount(row, i, j):
    """Return entry *i*, *j* of the compliance of the exit point's mount, m/N."""
    return row[MOUNT + i] if i == j else row[MOUNT + 2 + i + j]


@jit
def towards_winch(row):
    """Return the unit vector from the guide at the frame along its dead span.

    It is zero where the dead span is not modelled, or comes ASIDE.
    """
    if row[UNKNOWNS] < 4.0 or row[GUIDE] == ASIDE:
        return 0.0, 0.0, 0.0
    x, y, z = row[ARRIVAL_X], row[ARRIVAL_X + 1], row[ARRIVAL_X + 2]
    if row[GUIDE] == EYELET:
        far = sqrt(x * x + y * y + z * z)
        return x / far, y / far, z / far
    axis = (row[AXIS_X], row[AXIS_X + 1], row[AXIS_X + 2])
    if row[GUIDE] == PULLEY:
        return _cross((x, y, z), axis)
    return -row[SIDE] * axis[0], -row[SIDE] * axis[1], -row[SIDE] * axis[2]


@jit
def pull_of_dead_span(row):
    """Return the unit vector by which the dead span of a straight line pulls its mount.

    As `towards_winch`, or vertical.
    """
    if row[GUIDE] != UPRIGHT:
        return towards_winch(row)
    if row[UNKNOWNS] > 3.0:  # along the axis of a swivel
        return 0.0, 0.0, -row[SIDE]
    return 0.0, 0.0, 0.0


@jit
def leave_platform(row, rotation, gx, gy, gz, away, out, at):
    """Write the guide on the platform at its *rotation*, where the cable leaves with the force (gx, gy, gz).

    See `leave_frame`. Seen from its anchor the cable leaves against that force; derivatives are by the force itself.
    """
    if row[END_RADIUS] == 0.0:
        _clear(out, at)
        return True
    axis = rotate(rotation, row[END_AXIS_X], row[END_AXIS_X + 1], row[END_AXIS_X + 2])
    arrival = rotate(rotation, row[END_ARRIVAL_X], row[END_ARRIVAL_X + 1], row[END_ARRIVAL_X + 2])
    force, back = (-gx, -gy, -gz), (-away[0], -away[1], -away[2])
    if _dot(arrival, arrival) > 0.0:
        found = _leave_pulley((-axis[0], -axis[1], -axis[2]), arrival, row[END_RADIUS], force, out, at)
    else:
        found = _leave_swivel(axis, row[END_RADIUS], 1.0, force, back, out, at)
    for k in range(BY_FORCE, ARC):
        out[at + k] = -out[at + k]
    for k in range(ARC_BY_FORCE, SPAN):
        out[at + k] = -out[at + k]
    return found


@jit
def wheel_on_platform(row, rotation, end, away, wheel):
    """Write the sheave on the platform as a disc to *wheel* (7,): its centre from the platform point, normal, radius.

    *end*: the force (x, y, z), world, with which the span arrives; *away* and *rotation* as of `leave_platform`.
    """
    a0, a1, a2 = rotate(rotation, row[END_AXIS_X], row[END_AXIS_X + 1], row[END_AXIS_X + 2])
    wheel[0] = wheel[1] = wheel[2] = 0.0
    wheel[3], wheel[4], wheel[5], wheel[6] = a0, a1, a2, row[END_RADIUS]
    if row[END_ARRIVAL_X] == row[END_ARRIVAL_X + 1] == row[END_ARRIVAL_X + 2] == 0.0:
        rise = end[0] * a0 + end[1] * a1 + end[2] * a2
        out = (rise * a0 - end[0], rise * a1 - end[1], rise * a2 - end[2])
        reach = max(sqrt(_dot(out, out)), NO_PLANE)
        reach = reach if _dot(out, away) <= 0.0 else -reach
        out = (out[0] / reach, out[1] / reach, out[2] / reach)
        across = _cross((a0, a1, a2), out)
        for k in range(3):
            wheel[k], wheel[3 + k] = row[END_RADIUS] * out[k], across[k]


@jit
def _clear(out, at):
    for k in range(GUIDE_SIZE):
        out[at + k] = 0.0


@jit
def _leave_swivel(axis, radius, side, force, toward, out, at):
    """A sheave whose centre lies one *radius* from the *axis* that it turns about, on the side of *toward*.

    The contact starts on the axis: where the cable comes along it for *side* 1, against it for -1.
    """
    a0, a1, a2 = axis
    f0, f1, f2 = force
    rise = f0 * a0 + f1 * a1 + f2 * a2
    e0, e1, e2 = f0 - rise * a0, f1 - rise * a1, f2 - rise * a2
    away = sqrt(e0 * e0 + e1 * e1 + e2 * e2)
    size = sqrt(away * away + rise * rise)
    if not away > NO_PLANE * size:
        return False
    if e0 * toward[0] + e1 * toward[1] + e2 * toward[2] < 0.0:
        away = -away
    e0, e1, e2 = e0 / away, e1 / away, e2 / away
    c, s = away / size, rise / size
    turn = side * radius
    reach, height = radius - turn * s, turn * c
    along = (c * e0 + s * a0, c * e1 + s * a1, c * e2 + s * a2)
    up = (c * a0 - s * e0, c * a1 - s * e1, c * a2 - s * e2)
    normal = (a1 * e2 - a2 * e1, a2 * e0 - a0 * e2, a0 * e1 - a1 * e0)
    e, a = (e0, e1, e2), (a0, a1, a2)
    for i in range(3):
        out[at + CONTACT_POINT + i] = reach * e[i] + height * a[i]
        for j in range(3):
            turned = reach / away * normal[i] * normal[j]
            out[at + BY_FORCE + 3 * i + j] = turned - turn / size * along[i] * up[j]
        out[at + ARC_BY_FORCE + i] = -turn / size * up[i]
        out[at + SPAN_BY_FORCE + i] = 0.0
    out[at + ARC] = radius * 0.5 * pi - turn * atan2(s, c)
    return True


@jit
def _leave_aside(row, force, toward, out, at):
    """As `_leave_swivel`, of a cable that comes from a winch aside of the axis, at ARRIVAL from the exit point."""
    axis = (row[AXIS_X], row[AXIS_X + 1], row[AXIS_X + 2])
    winch = (row[ARRIVAL_X], row[ARRIVAL_X + 1], row[ARRIVAL_X + 2])
    radius, turn = row[RADIUS], row[SIDE] * row[RADIUS]
    size = sqrt(_dot(force, force))
    f = (force[0] / size, force[1] / size, force[2] / size)
    rise, fall = _dot(f, axis), _dot(winch, axis)
    first = (f[0] - rise * axis[0], f[1] - rise * axis[1], f[2] - rise * axis[2])
    away = sqrt(_dot(first, first))
    if not away > NO_PLANE:
        return False
    if _dot(first, toward) < 0.0:
        away = -away
    first = (first[0] / away, first[1] / away, first[2] / away)
    angle, done = 0.0, False
    e, n = first, first
    for _ in range(TURNS):
        e = _turned(first, axis, angle)
        n = _cross(axis, e)
        fe, fn, we, wn = _dot(f, e), _dot(f, n), _dot(winch, e), _dot(winch, n)
        square = (we - radius) ** 2 + fall * fall - radius * radius
        if not square > 0.0:
            return False
        # of both tensions: distance of the contact point from the axis times the part across the sheave
        flat = fe * fe + rise * rise
        dphi = -rise * fn / flat
        psi = _entry(we - radius, fall, -turn)
        dpsi = -sin(psi) * wn / sqrt(square)
        span = sqrt(square + wn * wn)
        leaves, enters = radius - turn * rise / sqrt(flat), radius + turn * sin(psi)
        moment = leaves * fn + enters * wn / span
        slope = -turn * fe / sqrt(flat) * dphi * fn - leaves * fe
        slope += turn * cos(psi) * dpsi * wn / span - enters * (we / span - radius * wn * wn / span**3)
        if done or slope == 0.0:
            break
        step = moment / slope
        angle -= min(max(step, -TURN), TURN)
        done = abs(step) < TURNED
    if not done:
        return False
    return _write_aside(row, (e, n, axis), (fe, fn, rise), (we, wn, fall), slope, size, out, at)


@jit
def _write_aside(row, frame, f, winch, slope, size, out, at):
    """Write the guide of `_leave_aside` in the sheave's *frame* (outwards, across, axis); *f* and *winch* are in it.

    *slope*: derivative of the moment by the sheave's angle; *size* of the force, N.
    """
    e, n, a = frame
    fe, fn, rise = f
    we, wn, fall = winch
    radius, side = row[RADIUS], row[SIDE]
    turn, flat = side * radius, sqrt(fe * fe + rise * rise)
    c, s = fe / flat, rise / flat
    psi = _entry(we - radius, fall, -turn)
    square = (we - radius) ** 2 + fall * fall - radius * radius
    span, leaves = sqrt(square + wn * wn), radius - turn * s
    dphi, dpsi = -s * fn / flat, -sin(psi) * wn / sqrt(square)
    for j in range(3):
        by_phi = (c * a[j] - s * e[j]) / flat  # with the sheave held
        by_side = n[j] - fn * (fe * e[j] + fn * n[j] + rise * a[j])  # of the force's direction
        turned = -(leaves * by_side - turn * c * by_phi * fn) / slope
        by_phi += dphi * turned
        for i in range(3):
            slip = leaves * n[i] * turned - turn * (c * e[i] + s * a[i]) * by_phi
            out[at + BY_FORCE + 3 * i + j] = slip / size
        out[at + ARC_BY_FORCE + j] = turn * (dpsi * turned - by_phi) / size
        out[at + SPAN_BY_FORCE + j] = -radius * wn / span * turned / size
    for i in range(3):
        out[at + CONTACT_POINT + i] = leaves * e[i] + turn * c * a[i]
        out[at + TOWARDS + i] = (sqrt(square) * (cos(psi) * e[i] + sin(psi) * a[i]) + wn * n[i]) / span
    wrap = side * (psi - atan2(s, c)) + pi
    wrap = wrap if wrap < UNWOUND else wrap - 2.0 * pi
    out[at + ARC], out[at + SPAN] = radius * wrap, span + row[DEAD_SPAN]
    enters, psi_r, span_r = radius + turn * sin(psi), (sin(psi) + side) / sqrt(square), -we / span
    more = leaves / radius * fn + (enters / radius + turn * cos(psi) * psi_r) * wn / span
    turned = -(more - enters * wn / (span * span) * span_r) / slope
    for i in range(3):
        slip = leaves * n[i] * turned - turn * (c * e[i] + s * a[i]) * dphi * turned
        out[at + POINT_BY_RADIUS + i] = out[at + CONTACT_POINT + i] / radius + slip
    out[at + ARC_BY_RADIUS] = wrap + turn * (psi_r + (dpsi - dphi) * turned)
    out[at + SPAN_BY_RADIUS] = span_r - radius * wn / span * turned
    return True


@jit
def _entry(x, z, turn):
    """Direction (rad) of the tangent from a circle about zero to the point (x, z) outside, as `sheave.tangent`."""
    distance = sqrt(x * x + z * z)
    return atan2(z, x) - asin(turn / distance)


@jit
def _turned(e, axis, angle):
    """The vector *e*, across the *axis*, turned about it."""
    n, c, s = _cross(axis, e), cos(angle), sin(angle)
    return (c * e[0] + s * n[0], c * e[1] + s * n[1], c * e[2] + s * n[2])


@jit
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@jit
def _cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@jit
def _leave_pulley(axis, arrival, radius, force, out, at):
    """A wheel on a fixed *axis*, about which the cable travels in the positive sense from its *arrival* on."""
    n0, n1, n2 = axis
    k0, k1, k2 = arrival
    f0, f1, f2 = force
    across = f0 * n0 + f1 * n1 + f2 * n2
    t0, t1, t2 = f0 - across * n0, f1 - across * n1, f2 - across * n2
    inside = sqrt(t0 * t0 + t1 * t1 + t2 * t2)
    if not inside > NO_PLANE * sqrt(inside * inside + across * across):
        return False
    t0, t1, t2 = t0 / inside, t1 / inside, t2 / inside
    radial = (t1 * n2 - t2 * n1, t2 * n0 - t0 * n2, t0 * n1 - t1 * n0)
    tangent = (t0, t1, t2)
    ahead = (n1 * k2 - n2 * k1) * radial[0] + (n2 * k0 - n0 * k2) * radial[1] + (n0 * k1 - n1 * k0) * radial[2]
    angle = atan2(ahead, k0 * radial[0] + k1 * radial[1] + k2 * radial[2])
    if angle < 0.0:
        angle += 2.0 * pi
    if angle > UNWOUND:
        angle -= 2.0 * pi
    for i in range(3):
        out[at + CONTACT_POINT + i] = radius * radial[i]
        for j in range(3):
            out[at + BY_FORCE + 3 * i + j] = -radius / inside * tangent[i] * radial[j]
        out[at + ARC_BY_FORCE + i] = -radius / inside * radial[i]
        out[at + SPAN_BY_FORCE + i] = 0.0
    out[at + ARC] = radius * angle
    return True
