"""Calibration measurements of lines: residuals and derivatives of lengths, swivel angles, and the balance of tensions.

*rows* and *work* are a `MeasurementRows` and a `RowReading`; its `slope`, `gradient` and `unknown` receive derivatives.
*guided* is that of the rows: None of a robot without such lines, for which Numba then compiles no other path.
"""

from math import atan2, floor, pi, sqrt

from cablewright.kernels import jit
from cablewright.kernels.fitting.guided_path import (
    BY_RADIUS,
    change_guided,
    draw_guided,
    wrench_along,
)
from cablewright.kernels.fitting.line_over_sheave import (
    BUILD_UP,
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
    by_mount,
    gives,
    over_sheave,
    paid_out,
    per_tension,
    swivel_frame,
    turning,
)
from cablewright.kernels.layout import SPANS as GUIDED  # over 0 of a line whose path is guided
from cablewright.kernels.rotation import cross, rotate
from cablewright.kernels.statics.line.spatial_lines import faces_back


@jit
def put(rows, work, count, line, column, amount):
    """Append the derivative *amount* by a number of a line, if that number is an unknown. Returns the new count."""
    at = rows.target[line, column]
    if at < 0:
        return count
    work.gradient[count], work.unknown[count] = amount, at
    return count + 1


@jit
def draw(guided, work, i, pose):
    """Write the straight cable of line *i* to `free`; its length is NaN where none runs.

    Returns the arm from the platform's origin to where the cable reaches the platform, world, m.
    """
    if guided is not None and guided[i, GUIDED] > 0.0:
        return draw_guided(work.lines[i], work.path, i, pose, work.rotation, work.free)
    row = work.lines[i]
    ax, ay, az = rotate(work.rotation, row[POINT], row[POINT + 1], row[POINT + 2])
    over_sheave(row, pose[0] + ax, pose[1] + ay, pose[2] + az, work.free)
    return ax, ay, az


@jit
def _by_point(rows, work, line, count, ax, ay, az, gx, gy, gz):
    """Append derivatives by pose, exit point and platform point, from the gradient by the platform point in space."""
    for axis, along in enumerate((gx, gy, gz)):
        work.slope[axis] += along
        count = put(rows, work, count, line, EXIT + axis, -along)
    return _by_arm(rows, work, line, count, ax, ay, az, gx, gy, gz)


@jit
def _by_arm(rows, work, line, count, ax, ay, az, gx, gy, gz):
    """Append derivatives by rotation and platform point, from the gradient (gx, gy, gz) by the arm."""
    slope = work.slope
    slope[3] += ay * gz - az * gy
    slope[4] += az * gx - ax * gz
    slope[5] += ax * gy - ay * gx
    return _by_tie(rows, work, line, count, gx, gy, gz)


@jit
def _by_tie(rows, work, line, count, gx, gy, gz):
    """Append derivatives by the platform point alone."""
    turned = work.rotation
    for axis in range(3):
        along = turned[0, axis] * gx + turned[1, axis] * gy + turned[2, axis] * gz
        count = put(rows, work, count, line, POINT + axis, along)
    return count


@jit
def _by_motions(rows, work, i, count, by, amount):
    """Append *amount* times derivatives *by* the motions of a guided line, see `guided_path`."""
    for k in range(6):
        work.slope[k] += amount * by[k]
    for axis in range(3):
        count = put(rows, work, count, i, EXIT + axis, -amount * by[axis])
    count = put(rows, work, count, i, RADIUS, amount * by[BY_RADIUS])
    return _by_tie(rows, work, i, count, amount * by[0], amount * by[1], amount * by[2])


@jit
def _by_length(guided, rows, work, i, pose, count, arm, amount):
    """Append *amount* times the derivatives of the length of a drawn line."""
    if guided is not None and guided[i, GUIDED] > 0.0:
        change_guided(work.path, i, pose, work.rotation)
        return _by_motions(rows, work, i, count, work.path.length, amount)
    free = work.free
    ax, ay, az = arm
    count = _by_point(rows, work, i, count, ax, ay, az, amount * free[1], amount * free[2], amount * free[3])
    return put(rows, work, count, i, RADIUS, amount * free[4])


@jit
def _by_turn(guided, rows, work, i, count, arm, b, amount):
    """Append *amount* times the derivatives of a drawn line's direction, projected on the fixed vector *b* (x, y, z).

    Those of a guided line are known, see `_by_length`.
    """
    bx, by, bz = b
    if guided is not None and guided[i, GUIDED] > 0.0:
        wrench_along(work.path, -bx, -by, -bz, 0.0, 0.0, 0.0)
        return _by_motions(rows, work, i, count, work.path.along, amount)
    ax, ay, az = arm
    gx, gy, gz, per_radius = turning(work.lines[i], work.free, bx, by, bz)
    count = _by_point(rows, work, i, count, ax, ay, az, amount * gx, amount * gy, amount * gz)
    return put(rows, work, count, i, RADIUS, amount * per_radius)


@jit
def encoder(guided, rows, i, j, counted, pose, work, count, amount):
    """Return *amount* times the length of line *i* less the one *counted*, m, and the number of derivatives."""
    line, free = work.lines[i], work.free
    arm = draw(guided, work, i, pose)
    count = _by_length(guided, rows, work, i, pose, count, arm, amount * line[SPANS])
    off, count = wound(rows, work, count, i, counted, amount)
    if _is_soft(rows, work, i):
        reading = rows.tensions[j, i]
        tension = line[TENSION_OFFSET] + line[TENSION_SCALE] * reading
        less, count = _given(guided, rows, work, count, i, tension, arm, amount)
        each = amount * per_tension(line, free)
        count = put(rows, work, count, i, TENSION_OFFSET, -each)
        count = put(rows, work, count, i, TENSION_SCALE, -each * reading)
        off -= less
    return amount * line[SPANS] * free[0] + off, count


@jit
def _is_soft(rows, work, i):
    """Whether the ends of the line give, or may give."""
    return rows.target[i, COMPLIANCE] >= 0 or gives(work.lines[i])


@jit
def _given(guided, rows, work, count, i, tension, arm, amount):
    """By how much less cable there is as the ends of line *i* give, m; appends minus its derivatives, at a tension."""
    line, free = work.lines[i], work.free
    per_kilo = amount * PER_NEWTON * line[PULL] / line[SPANS] * tension
    energy, square, bx, by, bz = by_mount(line, free)
    count = _by_turn(guided, rows, work, i, count, arm, (bx, by, bz), -2.0 * line[SPANS] * per_kilo)
    count = put(rows, work, count, i, COMPLIANCE, -per_kilo * square)
    return per_kilo * energy + amount * line[SPRING] * tension, count


@jit
def wound(rows, work, count, i, counted, amount):
    """Minus *amount* times the true length of *counted*, offset included; appends derivatives by numbers of drums."""
    line = work.lines[i]
    out, per_scale, per_build_up, per_offset = paid_out(line, counted)
    count = put(rows, work, count, i, OFFSET, -amount * (1.0 + per_offset))
    count = put(rows, work, count, i, SCALE, -amount * per_scale)
    count = put(rows, work, count, i, BUILD_UP, -amount * per_build_up)
    return -amount * (line[OFFSET] + out), count


@jit
def swivel(guided, rows, i, value, pose, work):
    """Angle of the free cable about the swivel's axis, from the exit point, or of a guided line by its direction."""
    line, free = work.lines[i], work.free
    arm = draw(guided, work, i, pose)
    ax, ay, az = arm
    dx, dy, dz = pose[0] + ax - line[EXIT], pose[1] + ay - line[EXIT + 1], pose[2] + az - line[EXIT + 2]
    ox, oy, oz, qx, qy, qz = swivel_frame(line)
    if guided is not None and guided[i, GUIDED] > 0.0:
        sign = -1.0 if faces_back(work.path.lines[i], work.path.record, dx, dy, dz) else 1.0
        dx, dy, dz = sign * free[1], sign * free[2], sign * free[3]
        change_guided(work.path, i, pose, work.rotation)
    else:
        sign = 1.0
    cosine, sine = dx * ox + dy * oy + dz * oz, dx * qx + dy * qy + dz * qz
    square = max(cosine * cosine + sine * sine, MIN_DISTANCE * MIN_DISTANCE)
    c, s = cosine / square, sine / square
    bx, by, bz = c * qx - s * ox, c * qy - s * oy, c * qz - s * oz
    if guided is not None and guided[i, GUIDED] > 0.0:
        count = _by_turn(guided, rows, work, i, 0, arm, (bx, by, bz), sign)
    else:
        count = _by_point(rows, work, i, 0, ax, ay, az, bx, by, bz)
    count = put(rows, work, count, i, SWIVEL_OFFSET, -1.0)
    return wrapped(atan2(sine, cosine) - value - line[SWIVEL_OFFSET]), count


@jit
def wrapped(angle):
    """Return the same angle from -pi to pi, rad."""
    return angle - 2.0 * pi * floor((angle + pi) / (2.0 * pi))


@jit
def reading_of_cell(rows, i, value, work):
    """Return the part of a load cell's residual without tension, N, and the number of derivatives.

    That is its reading without tension less the measured *value*. The tension is added elsewhere.
    """
    line = work.lines[i]
    zero = -line[TENSION_OFFSET] / line[TENSION_SCALE]
    count = put(rows, work, 0, i, TENSION_OFFSET, -1.0 / line[TENSION_SCALE])
    count = put(rows, work, count, i, TENSION_SCALE, -zero / line[TENSION_SCALE])
    return zero - value, count


@jit
def balance(guided, rows, j, along, pose, work):
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
        arm = draw(guided, work, i, pose)
        ax, ay, az = arm
        bx, by, bz = cross(along[3], along[4], along[5], ax, ay, az)
        bx, by, bz = along[0] + bx, along[1] + by, along[2] + bz
        along_line = bx * free[1] + by * free[2] + bz * free[3]
        left -= t * along_line
        count = put(rows, work, count, i, TENSION_OFFSET, -pull * along_line)
        count = put(rows, work, count, i, TENSION_SCALE, -pull * reading * along_line)
        count = _by_wrench(guided, rows, work, i, pose, count, arm, along, (bx, by, bz), -t)
    left *= share
    for k in range(6):
        work.slope[k] *= share
    for k in range(count):
        work.gradient[k] *= share
    for i in range(m):
        count = put(rows, work, count, i, TENSION_SCALE, -left * work.lines[i, TENSION_SCALE] / squares)
    return left, count


@jit
def _by_wrench(guided, rows, work, i, pose, count, arm, along, b, amount):
    """Append *amount* times the derivatives of (u, r x u) *along* a force and a moment; *b*: both, as one force."""
    free = work.free
    gx, gy, gz = cross(free[1], free[2], free[3], along[3], along[4], along[5])
    gx, gy, gz = amount * gx, amount * gy, amount * gz
    if guided is not None and guided[i, GUIDED] > 0.0:
        change_guided(work.path, i, pose, work.rotation)
        wrench_along(work.path, along[0], along[1], along[2], along[3], along[4], along[5])
        count = _by_motions(rows, work, i, count, work.path.along, -amount)
        return _by_tie(rows, work, i, count, gx, gy, gz)
    ax, ay, az = arm
    count = _by_turn(guided, rows, work, i, count, arm, b, amount)
    return _by_arm(rows, work, i, count, ax, ay, az, gx, gy, gz)


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
def tied(guided, rows, i, other, sense, j, value, pose, work, stretches):
    """Length of line *i* beyond that at home, less *sense* times that of the *other* on its drum, less *value*, m.

    Of lines that *stretch* the lengths themselves are added elsewhere.
    """
    if stretches:
        off, count = wound(rows, work, 0, i, 0.0, 1.0)
        back, count = wound(rows, work, count, other, 0.0, -sense)
    else:
        off, count = encoder(guided, rows, i, j, 0.0, pose, work, 0, 1.0)
        back, count = encoder(guided, rows, other, j, 0.0, pose, work, count, -sense)
    return off + back - value, count


@jit
def between(rows, i, other, value, work):
    """Distance of two exit points less *value*, m."""
    one, two = work.lines[i], work.lines[other]
    x, y, z = one[0] - two[0], one[1] - two[1], one[2] - two[2]
    size = sqrt(x * x + y * y + z * z)
    share = 1.0 / max(size, MIN_DISTANCE)
    count = 0
    for line, sign in ((i, share), (other, -share)):
        for axis, along in enumerate((x, y, z)):
            count = put(rows, work, count, line, EXIT + axis, sign * along)
    return size - value, count
