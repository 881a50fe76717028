"""A straight line over a swivelling sheave, for calibration: length, direction, and compliance of its exit's mount.

Length: Wang, Caro 2021, Eqs. 1 to 10, with the sign of Eq. 11 as in Eqs. 3 and 6, and either side of wrap. Its
derivative by the platform point is the unit vector u along the free cable, by the exit point -u.
"""

from math import asin, atan2, nan, pi, sqrt

from cablewright.kernels import jit
from cablewright.kernels.rotation import cross

# Columns of a line. The side is +1 over the sheave, -1 under it, 0 where there is none. The offset is the length at
# zero counts, from the exit point; the scale is the true length over the counted one; the build-up is the relative
# decrease of the drum's radius per length paid out, 1/m. True tensions and angles are readings plus their offset, those
# of load cells times their scale before. Tilt and yaw of the platform are those of the first line. Spans: how often the
# cable runs from exit point to platform. Pull: the force on the platform over the tension of a cable. Axis: unit vector
# of the swivel's axis, world; the side is with it or against it. Compliance: how far the exit's mount gives along its
# force, m/kN, so that it compares with lengths. From: unit vector to where the cable comes from, 0 if on that mount.
# Wound: the length, from the exit point, at which the drum has its radius and build-up; 0: that at zero counts.
# Mount: a compliance matrix besides, xx, yy, zz, xy, xz, yz, m/kN, world. Spring: how far one at the winch gives per
# tension of a cable, m/N. Neither is ever an unknown.
EXIT, POINT, RADIUS, SIDE, OFFSET, SCALE, BUILD_UP = 0, 3, 6, 7, 8, 9, 10
TENSION_OFFSET, TENSION_SCALE, SWIVEL_OFFSET, TILT_OFFSET, YAW_OFFSET = 11, 12, 13, 14, 16
SPANS, PULL, AXIS, COMPLIANCE, FROM, MOUNT, SPRING = 17, 18, 19, 22, 23, 26, 32
WOUND = 33
COLUMNS = 34
GIVING = (COMPLIANCE, *range(MOUNT, SPRING + 1))
PER_NEWTON = 1e-3  # of the compliance
LEAST_SQUARE = 1e-6  # of a drum's radius, as a share: it is empty
MIN_TILT = 1e-12  # 1 less the vertical part of an axis that counts as vertical
MIN_DISTANCE = 1e-9  # m: shorter distances have no direction


@jit
def over_sheave(line, x, y, z, free):
    """Write the straight cable from the sheave of *line* to the point (x, y, z) to *free*.

    Its length is NaN where the point is inside the sheave.
    """
    ax, ay, az = line[AXIS], line[AXIS + 1], line[AXIS + 2]
    dx, dy, dz = x - line[EXIT], y - line[EXIT + 1], z - line[EXIT + 2]
    rise = dx * ax + dy * ay + dz * az
    ox, oy, oz = dx - rise * ax, dy - rise * ay, dz - rise * az
    rho = sqrt(ox * ox + oy * oy + oz * oz)
    side, radius = line[SIDE], line[RADIUS]
    if rho > MIN_DISTANCE:
        free[9], free[10], free[11] = ox / rho, oy / rho, oz / rho
    elif abs(ax) < 0.9:  # any direction across the axis
        size = sqrt(1.0 - ax * ax)
        free[9], free[10], free[11] = size, -ax * ay / size, -ax * az / size
    else:
        size = sqrt(1.0 - ay * ay)
        free[9], free[10], free[11] = -ay * ax / size, size, -ay * az / size
    if side == 0.0:
        span = sqrt(rho * rho + rise * rise)
        c, s, length, per_radius = rho / span, rise / span, span, 0.0
    else:
        across, turn = rho - radius, side * radius
        square = across * across + rise * rise
        span = sqrt(square - radius * radius) if square > radius * radius and radius > 0.0 else nan
        c, s = (across * span + rise * turn) / square, (rise * span - across * turn) / square
        wrapped = 0.5 * pi - side * (atan2(rise, across) - asin(max(-1.0, min(1.0, turn / sqrt(square)))))
        length, per_radius = span + radius * wrapped, wrapped - c
    free[0], free[4], free[5], free[6], free[7], free[8] = length, per_radius, span, rho, c, s
    free[1], free[2], free[3] = c * free[9] + s * ax, c * free[10] + s * ay, c * free[11] + s * az


@jit
def swivel_frame(line):
    """Return two unit vectors across the swivel's axis: at the angle 0, and at a right angle.

    Angle 0 is along world x as far as that is across the axis; if the axis is nearly along x, along y. Angles of a
    vertical axis are azimuths, whichever way it points.
    """
    ax, ay, az = line[AXIS], line[AXIS + 1], line[AXIS + 2]
    if abs(az) > 1.0 - MIN_TILT:
        return 1.0, 0.0, 0.0, 0.0, 1.0, 0.0
    along, x, y = (ax, 1.0, 0.0) if abs(ax) < 0.9 else (ay, 0.0, 1.0)
    ox, oy, oz = x - along * ax, y - along * ay, -along * az
    size = sqrt(ox * ox + oy * oy + oz * oz)
    ox, oy, oz = ox / size, oy / size, oz / size
    qx, qy, qz = cross(ax, ay, az, ox, oy, oz)
    return ox, oy, oz, qx, qy, qz


@jit
def paid_out(line, counted):
    """Return the true length paid out for the *counted* one, m, and its derivatives by scale, build-up and offset.

    The square of the spool's radius falls linearly with the length paid out, so the radius with its angle: the true
    radius, of which the scale is the share. The build-up is per true metre, as that of a robot file.
    """
    first, build_up = line[SCALE] * counted, line[BUILD_UP]  # if the radius stayed
    half = 0.5 * first * first
    if line[WOUND] == 0.0:
        return first - build_up * half, counted * (1.0 - build_up * first), -half, 0.0
    more = line[OFFSET] - line[WOUND]
    share = sqrt(max(1.0 - 2.0 * build_up * more, LEAST_SQUARE))  # of the radius, at zero counts
    by_share = first / share
    out = share * first - build_up * half
    return out, counted * (share - build_up * first), -half - by_share * more, -by_share * build_up


@jit
def per_tension(line, free):
    """Return by how much mount and spring lengthen the cable beyond the winch per tension, m/N, negated.

    Call it after `over_sheave`. The force on the mount is p times the tension of one cable: of all spans, and of the
    cable that comes to the exit. The mount moves by its compliance times that force, and these cables become shorter by
    p times that displacement.
    """
    energy, _, _, _, _ = by_mount(line, free)
    return PER_NEWTON * line[PULL] / line[SPANS] * energy + line[SPRING]


@jit
def by_mount(line, free):
    """Return the energy p C p, m/kN, of the force p that one cable exerts on its exit point, and its derivatives.

    p is relative to the cable's tension. The last derivative is C p without the part along u: its product with a change
    of u is that of C p.
    """
    spans, own = line[SPANS], line[COMPLIANCE]
    fx, fy, fz = line[FROM], line[FROM + 1], line[FROM + 2]
    px, py, pz = spans * free[1] + fx, spans * free[2] + fy, spans * free[3] + fz
    square = px * px + py * py + pz * pz
    xx, yy, zz = line[MOUNT], line[MOUNT + 1], line[MOUNT + 2]
    xy, xz, yz = line[MOUNT + 3], line[MOUNT + 4], line[MOUNT + 5]
    mx, my, mz = xx * px + xy * py + xz * pz, xy * px + yy * py + yz * pz, xz * px + yz * py + zz * pz
    energy = own * square + (mx * px + my * py + mz * pz)
    return energy, square, own * fx + mx, own * fy + my, own * fz + mz


@jit
def gives(line):
    """Return whether the line has a compliant mount or a spring."""
    if line[COMPLIANCE] != 0.0:
        return True
    for at in range(MOUNT, SPRING + 1):
        if line[at] != 0.0:
            return True
    return False


@jit
def turning(line, free, bx, by, bz):
    """Return derivatives of the cable's direction u along a fixed direction (bx, by, bz).

    They are by the platform point and by the radius of the sheave.
    """
    rho, c, s = max(free[6], MIN_DISTANCE), free[7], free[8]
    ex, ey, ez = free[9], free[10], free[11]
    px, py, pz = line[AXIS], line[AXIS + 1], line[AXIS + 2]
    qx, qy, qz = cross(px, py, pz, ex, ey, ez)  # about the axis
    inward = c * (bx * px + by * py + bz * pz) - s * (bx * ex + by * ey + bz * ez)
    around = (bx * qx + by * qy + bz * qz) * c / rho
    turn = inward / free[5]
    gx, gy = turn * (c * px - s * ex) + around * qx, turn * (c * py - s * ey) + around * qy
    return gx, gy, turn * (c * pz - s * ez) + around * qz, -turn * (line[SIDE] - s)
