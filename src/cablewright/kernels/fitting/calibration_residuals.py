"""Residuals of calibration measurements and their derivatives, for straight lines over sheaves."""

from math import atan2, floor, pi, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import along_columns
from cablewright.kernels.fitting.line_over_sheave import (
    BUILD_UP,
    COLUMNS,
    COMPLIANCE,
    EXIT,
    MIN_DISTANCE,
    OFFSET,
    PER_NEWTON,
    POINT,
    PULL,
    RADIUS,
    SCALE,
    SPANS,
    SPRING,
    SWIVEL_OFFSET,
    TENSION_OFFSET,
    TENSION_SCALE,
    TILT_OFFSET,
    YAW_OFFSET,
    by_mount,
    gives,
    over_sheave,
    paid_out,
    per_tension,
    swivel_frame,
    turning,
)  # fmt: skip
from cablewright.kernels.fitting.sighting import BODY_COLUMNS, NUMBERS, edge, place_bodies
from cablewright.kernels.rotation import compose, cross, rotate
from cablewright.kernels.statics.platform import place_platform

# Kinds of rows, and the meaning of their `line`, `other` (indices of lines or axes) and `extra` (six numbers):
ENCODER = 0  # line
COORDINATE = 1  # other: the axis of the pose, 3 to 5 of a rotation, whose measured vector is extra[:3]
SWIVEL = 2  # line: angle of its free cable about the swivel's axis, rad, see `line_over_sheave.swivel_frame`
TILT = 3  # other: 0 about x, 1 about y, rad: of the platform against the plumb line
REACH = 4  # extra: a point of the world, a point of the platform: their distance, m
PLANE = 5  # extra: unit normal, a point of the platform: its distance along the normal from the origin, m
BALANCE = 6  # extra: directions of a force, 1 / N, and of a moment, 1 / N m: unbalanced part of measured tensions
BETWEEN = 7  # line, other: distance of two exit points, m; belongs to no pose
YAW = 10  # azimuth of the platform's x axis, rad
SIGHTING = 12  # line, other: indices of camera and tag among the bodies; extra: see `sighting.edge`; px
ALONG = 11  # other: 0 for the position, 3 for the rotation; extra: unit vector along which, the measured rotation
# Of lines that stretch and sag; the part that depends on their equilibrium is added elsewhere:
PAID_OUT = 8  # line
TENSION = 9  # line


class MeasurementRows(NamedTuple):
    """Measurements in the order of poses; those without a pose come last. N poses, R rows, k unknowns, m lines."""

    freedoms: int  # p: directions in which a pose is free, its n coordinates or, in a plane, fewer
    start: NDArray[np.int64]  # (N + 1,) first row of each pose, and the first one without a pose
    kind: NDArray[np.int64]  # (R,)
    line: NDArray[np.int64]  # (R,)
    other: NDArray[np.int64]  # (R,)
    extra: NDArray[np.float64]  # (R, 6)
    lines: NDArray[np.float64]  # (m, COLUMNS): known values
    target: NDArray[np.int64]  # (m, COLUMNS): index of the unknown, -1 where the value is known
    tensions: NDArray[np.float64]  # (N, m) N: readings of load cells
    load: NDArray[np.float64]  # (10,): force N and moment N m, world, at the platform's origin; weight N, its centre
    linear: NDArray[np.float64]  # (q, k): rows without a pose that are linear in the unknowns, weighted
    wanted: NDArray[np.float64]  # (q,): their expected values
    bodies: NDArray[np.float64]  # (b, BODY_COLUMNS): cameras and tags, see `sighting`
    body_target: NDArray[np.int64]  # (b, NUMBERS): index of the unknown, -1 where the value is known


class RowReading(NamedTuple):
    """Working memory of one measurement: its derivatives by the pose, and the nonzero ones by unknowns."""

    slope: NDArray[np.float64]  # (6,)
    gradient: NDArray[np.float64]  # (m * COLUMNS + 2 * NUMBERS,)
    unknown: NDArray[np.int64]  # (m * COLUMNS + 2 * NUMBERS,): the unknown of each; an unknown may occur twice
    rotation: NDArray[np.float64]  # (3, 3) of the pose
    lines: NDArray[np.float64]  # (m, COLUMNS): all values of the lines, unknowns included
    free: NDArray[np.float64]  # (12,): length, u (3,), per radius, free span, distance from the axis, its cosine and
    # sine, unit vector (3,) away from the axis
    turn: NDArray[np.float64]  # (3,)
    bodies: NDArray[np.float64]  # (b, BODY_COLUMNS): all values of the bodies, unknowns included
    by_body: NDArray[np.float64]  # (2, NUMBERS): derivatives by a camera and a tag
    spare: NDArray[np.float64]  # (2, 3, 3)


@jit(allocates=True)
def reading(rows):
    """Allocate a `RowReading` for *rows*."""
    m, numbers = rows.lines.shape[0], rows.lines.size + 2 * NUMBERS
    return RowReading(
        np.zeros(6),
        np.zeros(numbers),
        np.zeros(numbers, np.int64),
        np.eye(3),
        np.zeros((m, COLUMNS)),
        np.zeros(12),
        np.zeros(3),
        np.zeros((rows.bodies.shape[0], BODY_COLUMNS)),
        np.zeros((2, NUMBERS)),
        np.zeros((2, 3, 3)),
    )


@jit
def place_unknowns(rows, theta, work):
    """Write all values of the lines and the bodies to *work*, with the unknowns taken from *theta* (k,)."""
    for i in range(work.lines.shape[0]):
        for c in range(COLUMNS):
            at = rows.target[i, c]
            work.lines[i, c] = rows.lines[i, c] if at < 0 else theta[at]
    place_bodies(rows.bodies, rows.body_target, theta, work.bodies, work.spare[0], work.spare[1])


@jit
def read_row(rows, i, j, value, pose, work):
    """Return the residual of measurement *i* at pose *j*, and the number of its derivatives in *work*.

    The residual is NaN where it is not defined.
    """
    kind = rows.kind[i]
    work.slope[:] = 0.0
    if kind == ENCODER:
        return _encoder(rows, rows.line[i], j, value, pose, work)
    if kind == COORDINATE:
        return _coordinate(rows.other[i], rows.extra[i], value, pose, work), 0
    if kind == ALONG:
        return _along(rows.other[i], rows.extra[i], value, pose, work), 0
    if kind == SWIVEL:
        return _swivel(rows, rows.line[i], value, pose, work)
    if kind == TILT:
        return _tilt(rows, rows.other[i], value, work)
    if kind == YAW:
        return _yaw(rows, value, work)
    if kind in (REACH, PLANE):
        return _contact(kind, rows.extra[i], value, pose, work), 0
    if kind == BALANCE:
        return _balance(rows, j, rows.extra[i], pose, work)
    if kind == PAID_OUT:
        return _wound(rows, work, 0, rows.line[i], value)  # the length itself is added elsewhere
    if kind == TENSION:
        return _reading_of_cell(rows, rows.line[i], value, work)
    if kind == SIGHTING:
        return _sighting(rows, rows.line[i], rows.other[i], rows.extra[i], value, pose, work)
    return _between(rows, rows.line[i], rows.other[i], value, work)


@jit
def _put(rows, work, count, line, column, amount):
    """Append a derivative by one value of a line if it is an unknown. Returns the new count."""
    at = rows.target[line, column]
    if at < 0:
        return count
    work.gradient[count], work.unknown[count] = amount, at
    return count + 1


@jit
def platform_arm(work, line):
    """Return the vector from the platform's origin to the platform point of a line, world axes, m."""
    row = work.lines[line]
    return rotate(work.rotation, row[POINT], row[POINT + 1], row[POINT + 2])


@jit
def _by_point(rows, work, line, count, ax, ay, az, gx, gy, gz):
    """Append derivatives by pose, exit point and platform point, from the gradient by the platform point in space."""
    for axis, along in enumerate((gx, gy, gz)):
        work.slope[axis] += along
        count = _put(rows, work, count, line, EXIT + axis, -along)
    return _by_arm(rows, work, line, count, ax, ay, az, gx, gy, gz)


@jit
def _by_arm(rows, work, line, count, ax, ay, az, gx, gy, gz):
    """Append derivatives by rotation and platform point, from the gradient (gx, gy, gz) by the arm."""
    slope, turned = work.slope, work.rotation
    slope[3] += ay * gz - az * gy
    slope[4] += az * gx - ax * gz
    slope[5] += ax * gy - ay * gx
    for axis in range(3):
        along = turned[0, axis] * gx + turned[1, axis] * gy + turned[2, axis] * gz
        count = _put(rows, work, count, line, POINT + axis, along)
    return count


@jit
def _encoder(rows, i, j, counted, pose, work):
    line, free = work.lines[i], work.free
    ax, ay, az = platform_arm(work, i)
    over_sheave(line, pose[0] + ax, pose[1] + ay, pose[2] + az, free)
    spans = line[SPANS]
    count = _by_point(rows, work, i, 0, ax, ay, az, spans * free[1], spans * free[2], spans * free[3])
    count = _put(rows, work, count, i, RADIUS, spans * free[4])
    off, count = _wound(rows, work, count, i, counted)
    if _is_soft(rows, work, i):
        reading = rows.tensions[j, i]
        less, count = _given(rows, work, count, i, line[TENSION_OFFSET] + line[TENSION_SCALE] * reading, ax, ay, az)
        each = per_tension(line, free)
        count = _put(rows, work, count, i, TENSION_OFFSET, -each)
        count = _put(rows, work, count, i, TENSION_SCALE, -each * reading)
        off -= less
    return spans * free[0] + off, count


@jit
def _is_soft(rows, work, i):
    """Whether the ends of the line give, or may give."""
    return rows.target[i, COMPLIANCE] >= 0 or gives(work.lines[i])


@jit
def _given(rows, work, count, i, tension, ax, ay, az):
    """By how much less cable there is as the ends of line *i* give, m; appends minus its derivatives, at a tension."""
    line, free = work.lines[i], work.free
    per_kilo = PER_NEWTON * line[PULL] / line[SPANS] * tension
    energy, square, bx, by, bz = by_mount(line, free)
    gx, gy, gz, per_radius = turning(line, free, bx, by, bz)
    twice = -2.0 * line[SPANS] * per_kilo
    count = _by_point(rows, work, i, count, ax, ay, az, twice * gx, twice * gy, twice * gz)
    count = _put(rows, work, count, i, RADIUS, twice * per_radius)
    count = _put(rows, work, count, i, COMPLIANCE, -per_kilo * square)
    return per_kilo * energy + line[SPRING] * tension, count


@jit
def _wound(rows, work, count, i, counted):
    """Minus the true length of *counted*, offset included; appends derivatives by offset, scale and build-up."""
    line = work.lines[i]
    out, per_scale, per_build_up, per_offset = paid_out(line, counted)
    count = _put(rows, work, count, i, OFFSET, -1.0 - per_offset)
    count = _put(rows, work, count, i, SCALE, -per_scale)
    count = _put(rows, work, count, i, BUILD_UP, -per_build_up)
    return -line[OFFSET] - out, count


@jit
def _coordinate(axis, extra, value, pose, work):
    work.slope[axis] = 1.0
    if axis < 3:
        return pose[axis] - value
    for k in range(3):  # the derivative is that for small angles: the measured rotation is near
        work.turn[k] = -extra[k]
    compose(pose[3], pose[4], pose[5], work.turn)
    return work.turn[axis - 3]


@jit
def _along(axis, extra, value, pose, work):
    turn = work.turn
    for k in range(3):
        work.slope[axis + k] = extra[k]
        turn[k] = pose[k] if axis < 3 else -extra[3 + k]
    if axis == 3:
        compose(pose[3], pose[4], pose[5], turn)
    return extra[0] * turn[0] + extra[1] * turn[1] + extra[2] * turn[2] - value


@jit
def _swivel(rows, i, value, pose, work):
    line, free = work.lines[i], work.free
    ax, ay, az = platform_arm(work, i)
    over_sheave(line, pose[0] + ax, pose[1] + ay, pose[2] + az, free)
    dx, dy, dz = pose[0] + ax - line[EXIT], pose[1] + ay - line[EXIT + 1], pose[2] + az - line[EXIT + 2]
    ox, oy, oz, qx, qy, qz = swivel_frame(line)
    cosine, sine = dx * ox + dy * oy + dz * oz, dx * qx + dy * qy + dz * qz
    square = max(cosine * cosine + sine * sine, MIN_DISTANCE * MIN_DISTANCE)
    c, s = cosine / square, sine / square
    count = _by_point(rows, work, i, 0, ax, ay, az, c * qx - s * ox, c * qy - s * oy, c * qz - s * oz)
    count = _put(rows, work, count, i, SWIVEL_OFFSET, -1.0)
    return _wrapped(atan2(sine, cosine) - value - line[SWIVEL_OFFSET]), count


@jit
def _wrapped(angle):
    """The same angle from -pi to pi, rad."""
    return angle - 2.0 * pi * floor((angle + pi) / (2.0 * pi))


@jit
def _tilt(rows, about, value, work):
    """Tilt of the plumb line in the platform's frame, rad; d(R^T e_z) = -R^T (w x e_z) for a world rotation w."""
    turned, slope = work.rotation, work.slope
    up, sign = turned[2, 2], (1.0 if about == 0 else -1.0)
    axis = 1 - about
    lean = turned[2, axis]
    square = lean * lean + up * up
    for k in range(2):  # w x e_z is (w_y, -w_x, 0)
        row, turn = (1, 1.0) if k == 0 else (0, -1.0)
        change, rise = turn * turned[row, axis], turn * turned[row, 2]
        slope[3 + k] = sign * (change * up - lean * rise) / square
    offset = TILT_OFFSET + about
    return sign * atan2(lean, up) - value - work.lines[0, offset], _put(rows, work, 0, 0, offset, -1.0)


@jit
def _yaw(rows, value, work):
    """Azimuth of the platform's x axis; d(R e_x) = w x (R e_x) for a world rotation w."""
    turned, slope = work.rotation, work.slope
    x, y, z = turned[0, 0], turned[1, 0], turned[2, 0]
    square = max(x * x + y * y, MIN_DISTANCE * MIN_DISTANCE)
    slope[3], slope[4], slope[5] = -x * z / square, -y * z / square, 1.0
    return _wrapped(atan2(y, x) - value - work.lines[0, YAW_OFFSET]), _put(rows, work, 0, 0, YAW_OFFSET, -1.0)


@jit
def _contact(kind, extra, value, pose, work):
    slope = work.slope
    arm, spot = work.turn, work.free
    arm[0], arm[1], arm[2] = rotate(work.rotation, extra[3], extra[4], extra[5])
    for a in range(3):
        spot[a] = pose[a] + arm[a]
    if kind == PLANE:
        for a in range(3):
            slope[a] = extra[a]
        size = spot[0] * extra[0] + spot[1] * extra[1] + spot[2] * extra[2]
    else:
        size = sqrt((spot[0] - extra[0]) ** 2 + (spot[1] - extra[1]) ** 2 + (spot[2] - extra[2]) ** 2)
        for a in range(3):
            slope[a] = (spot[a] - extra[a]) / max(size, MIN_DISTANCE)
    slope[3], slope[4], slope[5] = cross(arm[0], arm[1], arm[2], slope[0], slope[1], slope[2])
    return size - value


@jit
def _reading_of_cell(rows, i, value, work):
    """What a load cell would read without tension, less what it reads, N; the tension is added elsewhere."""
    line = work.lines[i]
    zero = -line[TENSION_OFFSET] / line[TENSION_SCALE]
    count = _put(rows, work, 0, i, TENSION_OFFSET, -1.0 / line[TENSION_SCALE])
    count = _put(rows, work, count, i, TENSION_SCALE, -zero / line[TENSION_SCALE])
    return zero - value, count


@jit
def _balance(rows, j, along, pose, work):
    """Load less tensions times (u, r x u), along a force and a moment; u depends on the platform point.

    Along the moment b a line acts as along the force b x r, which rotates with the arm r. Noise is that of readings, so
    that all is over the root mean square of the scales: small ones would win otherwise, for they make noise small.
    """
    free, m, squares = work.free, rows.lines.shape[0], 0.0
    for i in range(m):
        squares += work.lines[i, TENSION_SCALE] ** 2
    share = sqrt(m / squares)
    left = _load(rows.load, along, work)
    count = 0
    for i in range(m):
        line, reading = work.lines[i], rows.tensions[j, i]
        pull = line[PULL]
        t = pull * (line[TENSION_OFFSET] + line[TENSION_SCALE] * reading)
        ax, ay, az = platform_arm(work, i)
        over_sheave(line, pose[0] + ax, pose[1] + ay, pose[2] + az, free)
        bx, by, bz = cross(along[3], along[4], along[5], ax, ay, az)
        bx, by, bz = along[0] + bx, along[1] + by, along[2] + bz
        along_line = bx * free[1] + by * free[2] + bz * free[3]
        left -= t * along_line
        count = _put(rows, work, count, i, TENSION_OFFSET, -pull * along_line)
        count = _put(rows, work, count, i, TENSION_SCALE, -pull * reading * along_line)
        gx, gy, gz, per_radius = turning(line, free, bx, by, bz)
        count = _by_point(rows, work, i, count, ax, ay, az, -t * gx, -t * gy, -t * gz)
        count = _put(rows, work, count, i, RADIUS, -t * per_radius)
        gx, gy, gz = cross(free[1], free[2], free[3], along[3], along[4], along[5])
        count = _by_arm(rows, work, i, count, ax, ay, az, -t * gx, -t * gy, -t * gz)
    left *= share
    for k in range(6):
        work.slope[k] *= share
    for k in range(count):
        work.gradient[k] *= share
    for i in range(m):
        count = _put(rows, work, count, i, TENSION_SCALE, -left * work.lines[i, TENSION_SCALE] / squares)
    return left, count


@jit
def _load(load, along, work):
    """The platform's own load along a force and a moment; the arm of its weight rotates."""
    slope = work.slope
    ax, ay, az = rotate(work.rotation, load[7], load[8], load[9])
    gx, gy = along[4] * load[6], -along[3] * load[6]  # weight downwards, times b
    slope[3] += -az * gy
    slope[4] += az * gx
    slope[5] += ax * gy - ay * gx
    total = gx * ax + gy * ay - along[2] * load[6]
    for k in range(6):
        total += along[k] * load[k]
    return total


@jit
def _sighting(rows, camera, tag, extra, value, pose, work):
    seen, count = edge(work.bodies, camera, tag, extra, pose, work.rotation, work.slope, work.by_body), 0
    for which, body in enumerate((camera, tag)):
        for column in range(NUMBERS):
            at = rows.body_target[body, column]
            if at >= 0:
                work.gradient[count], work.unknown[count] = work.by_body[which, column], at
                count += 1
    return seen - value, count


@jit
def _between(rows, i, other, value, work):
    one, two = work.lines[i], work.lines[other]
    x, y, z = one[0] - two[0], one[1] - two[1], one[2] - two[2]
    size = sqrt(x * x + y * y + z * z)
    share = 1.0 / max(size, MIN_DISTANCE)
    count = 0
    for line, sign in ((i, share), (other, -share)):
        for axis, along in enumerate((x, y, z)):
            count = _put(rows, work, count, line, EXIT + axis, sign * along)
    return size - value, count


@jit(allocates=True)
def derivatives(rows, free, theta, poses, values, weights, residuals, slopes, gradients):
    """Write weighted residuals (R,) and derivatives by pose (R, p) and unknowns (R, k) at *theta*, *poses* (N, n).

    *free* (n, p): an orthonormal basis of the directions in which poses are free.
    """
    work = reading(rows)
    place_unknowns(rows, theta, work)
    gradients[:, :] = 0.0
    slopes[:, :] = 0.0
    in_plane = rows.freedoms < free.shape[0]
    for j in range(poses.shape[0] + 1):
        alone = j == poses.shape[0]
        pose = poses[0 if alone else j]
        place_platform(pose, work.rotation)
        for i in range(rows.start[j], values.shape[0] if alone else rows.start[j + 1]):
            if weights[i] == 0.0:  # it does not count, even where it has no value
                residuals[i] = 0.0
                continue
            off, count = read_row(rows, i, j, values[i], pose, work)
            if in_plane:
                along_columns(free, work.slope, work.turn)
            residuals[i] = weights[i] * off
            for k in range(rows.freedoms):
                slopes[i, k] = weights[i] * work.slope[k]
            for k in range(count):
                gradients[i, work.unknown[k]] += weights[i] * work.gradient[k]
