"""Guides of a cable in space: where it leaves them for a given tension vector, and how that point moves with it.

All are without friction and bearing torque, so that the tension on both sides is the same. A swivel turns about any
axis until the axis, the sheave and the tension vector lie in one plane, because the cable on its other side runs
along the axis; a pulley turns in a fixed plane, and its groove takes what pulls out of it: the cable leaves where the
tension vector, seen along the wheel's axis, touches the wheel. Either point depends on the direction alone.
"""

from math import atan2, pi, sqrt

from cablewright.kernels import jit
from cablewright.kernels.layout import (
    ARRIVAL_X,
    AXIS_X,
    END_RADIUS,
    GUIDE,
    PULLEY,
    RADIUS,
    SIDE,
    SWIVEL,
)

# What is known of a guide, from `at` on: its contact point and what changes with the force f that leaves it.
CONTACT_POINT = 0  # 0..2: contact point from the guide's own point, m
BY_FORCE = 3  # 3..11: derivative of the point by f, rows x, y, z, m/N
ARC = 12  # contact length, m
ARC_BY_FORCE = 13  # 13..15: its derivative by f, m/N
GUIDE_SIZE = 16

NO_PLANE = 1e-9  # sine of the angle to the axis under which a sheave has no plane
UNWOUND = 1.5 * pi  # rad: a larger angle of contact is one below zero


@jit
def leave_frame(row, fx, fy, fz, out, at):
    """Write the guide of line *row* at the frame, left with the force (fx, fy, fz), to *out* from *at* on.

    False where the force is along the axis, so that the sheave has no plane.
    """
    if row[GUIDE] == SWIVEL:
        axis = (row[AXIS_X], row[AXIS_X + 1], row[AXIS_X + 2])
        return _leave_swivel(axis, row[RADIUS], row[SIDE], (fx, fy, fz), out, at)
    if row[GUIDE] == PULLEY:
        return _leave_pulley(row, (fx, fy, fz), out, at)
    _clear(out, at)
    return True


@jit
def leave_platform(row, ax, ay, az, gx, gy, gz, out, at):
    """As `leave_frame`, of the sheave on the platform: axis (world) and the force (gx, gy, gz) at the span's end.

    Seen from its anchor the cable leaves against that force; derivatives are by the force itself.
    """
    if row[END_RADIUS] == 0.0:
        _clear(out, at)
        return True
    found = _leave_swivel((ax, ay, az), row[END_RADIUS], 1.0, (-gx, -gy, -gz), out, at)
    for k in range(BY_FORCE, ARC):
        out[at + k] = -out[at + k]
    for k in range(ARC_BY_FORCE, GUIDE_SIZE):
        out[at + k] = -out[at + k]
    return found


@jit
def _clear(out, at):
    for k in range(GUIDE_SIZE):
        out[at + k] = 0.0


@jit
def _leave_swivel(axis, radius, side, force, out, at):
    """A sheave whose centre lies one *radius* from the *axis* that it turns about, on the force's side.

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
    out[at + ARC] = radius * 0.5 * pi - turn * atan2(s, c)
    return True


@jit
def _leave_pulley(row, force, out, at):
    """A wheel on a fixed axis, about which the cable travels in the positive sense."""
    n0, n1, n2 = row[AXIS_X], row[AXIS_X + 1], row[AXIS_X + 2]
    k0, k1, k2 = row[ARRIVAL_X], row[ARRIVAL_X + 1], row[ARRIVAL_X + 2]
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
    radius = row[RADIUS]
    for i in range(3):
        out[at + CONTACT_POINT + i] = radius * radial[i]
        for j in range(3):
            out[at + BY_FORCE + 3 * i + j] = -radius / inside * tangent[i] * radial[j]
        out[at + ARC_BY_FORCE + i] = -radius / inside * radial[i]
    out[at + ARC] = radius * angle
    return True
