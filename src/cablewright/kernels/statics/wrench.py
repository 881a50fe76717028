"""The platform: the wrench of lines and weight on it, and its derivative by the pose."""

from math import sqrt

from cablewright.kernels import jit
from cablewright.kernels.layout import (
    EXIT_X,
    GUIDE,
    LEVER,
    MASS_X,
    PLATFORM_WEIGHT,
    POINT_X,
    PULLS,
    RADIUS,
    WRENCH,
)
from cablewright.kernels.rotation import rotate
from cablewright.kernels.statics.plane import is_held, least_and_arm, load_in_plane

AXIS_DISTANCE = 1e-12  # m: nearer to the vertical through the exit point the direction of a plane is arbitrary
NO_PLANE = 1e-9  # m: nearer to the vertical through its exit point a line over a sheave has no plane
STRAIGHT_DOWN = 1e-7  # m: nearer to it the line from an eyelet is as stiff sideways as in its plane


@jit(inline=True)
def place(lines, i, pose, rotation, arm, plane):
    """Write the arm (3,) of line *i*, from the platform's origin to its point, world, and its plane (4,).

    The plane is given by its horizontal direction (ex, ey) and the platform point (x, z) in it, from the exit point.
    """
    arm[0], arm[1], arm[2] = lines[i, POINT_X], lines[i, POINT_X + 1], lines[i, POINT_X + 2]
    if pose.shape[0] == 6:
        arm[0], arm[1], arm[2] = rotate(rotation, arm[0], arm[1], arm[2])
    x = pose[0] + arm[0] - lines[i, EXIT_X]
    y = pose[1] + arm[1] - lines[i, EXIT_X + 1]
    distance = sqrt(x * x + y * y)
    if distance > AXIS_DISTANCE:
        plane[0], plane[1] = x / distance, y / distance
    else:
        plane[0], plane[1] = 1.0, 0.0
    plane[2] = distance
    plane[3] = pose[2] + arm[2] - lines[i, EXIT_X + 2]


@jit(inline=True)
def is_eyelet(row):
    """Whether a line bends at one point and ends at another, without sheaves or a lever."""
    return row[RADIUS] == 0.0 and row[LEVER] == 0.0 and row[GUIDE] == 0.0


@jit(inline=True)
def has_plane(row, plane):
    """Whether a line has a plane: not on the axis of its sheave, nor in its eyelet. From an eyelet any will do."""
    if plane[2] > NO_PLANE:
        return True
    return is_eyelet(row) and abs(plane[3]) > NO_PLANE


@jit(inline=True)
def sideways(row, x, h, kxx):
    """Stiffness of a line across its plane: h / x, as the plane turns about the vertical through the exit point.

    Where the line runs along that vertical all planes are alike, and its limit is the stiffness *kxx* in the plane.
    """
    if x < STRAIGHT_DOWN and (is_eyelet(row) or abs(h) <= 2.0 * STRAIGHT_DOWN * abs(kxx)):
        return kxx
    return h / max(x, AXIS_DISTANCE)


@jit
def load_scale(packed):
    """Force (N) with which imbalances and guesses are compared: weight, external force and moment over its longest arm.

    The largest minimum tension takes their place where it is larger, or 1 N where all of them are 0.
    """
    platform = packed.platform
    if is_held(packed.general, platform):
        return load_in_plane(packed)
    force, moment = platform[PLATFORM_WEIGHT], 0.0
    for k in range(3):
        force += abs(platform[WRENCH + k])
        moment = max(moment, abs(platform[WRENCH + 3 + k]))
    least, arm = least_and_arm(packed)
    force = max(force + moment / arm, least)
    return force if force > 0.0 else 1.0


@jit
def start_balance(packed, rotation, wrench, stiffness):
    """Set *wrench* (n,) to the platform's own load and *stiffness* (n, n) to minus its derivative by the pose."""
    n = packed.freedoms
    platform = packed.platform
    for k in range(n):
        wrench[k] = platform[WRENCH + k]
        for j in range(n):
            stiffness[k, j] = 0.0
    weight = platform[PLATFORM_WEIGHT]
    wrench[2] -= weight
    if n == 6:
        rx, ry, rz = rotate(rotation, platform[MASS_X], platform[MASS_X + 1], platform[MASS_X + 2])
        _add_moment(wrench, rx, ry, rz, 0.0, 0.0, -weight)
        _add_turning(stiffness, rx, ry, rz, 0.0, 0.0, -weight)


@jit(inline=True)
def add_line(row, arm, plane, h, v, kxx, kxz, kzx, kzz, wrench, stiffness):
    """Add one line with the tension (h, v) at the end of a span and its derivatives by (x, z), in the line's plane."""
    ex, ey, pulls = plane[0], plane[1], row[PULLS]
    h, v, kxx, kxz, kzx, kzz = pulls * h, pulls * v, pulls * kxx, pulls * kxz, pulls * kzx, pulls * kzz
    fx, fy, fz = -h * ex, -h * ey, -v
    add_force(arm, fx, fy, fz, wrench)
    across = sideways(row, plane[2], h, kxx)
    xx = ex * ex * kxx + ey * ey * across
    yy = ey * ey * kxx + ex * ex * across
    xy = ex * ey * (kxx - across)
    xz, yz, zx, zy = ex * kxz, ey * kxz, ex * kzx, ey * kzx
    stiffness[0, 0] += xx
    stiffness[0, 1] += xy
    stiffness[0, 2] += xz
    stiffness[1, 0] += xy
    stiffness[1, 1] += yy
    stiffness[1, 2] += yz
    stiffness[2, 0] += zx
    stiffness[2, 1] += zy
    stiffness[2, 2] += kzz
    if wrench.shape[0] == 6:
        rx, ry, rz = arm[0], arm[1], arm[2]
        _add_turning(stiffness, rx, ry, rz, fx, fy, fz)
        _add_lever(stiffness, rx, ry, rz, xx, xy, xz, xy, yy, yz, zx, zy, kzz)


@jit(inline=True)
def add_pull(row, arm, plane, h, v, wrench):
    """Add the force with which a line pulls at *arm* to *wrench* (n,); (h, v): tension at the end of one span, N."""
    h, v = row[PULLS] * h, row[PULLS] * v
    add_force(arm, -h * plane[0], -h * plane[1], -v, wrench)


@jit(inline=True)
def add_force(arm, fx, fy, fz, wrench):
    """Add a force at *arm* to *wrench* (n,)."""
    wrench[0] += fx
    wrench[1] += fy
    wrench[2] += fz
    if wrench.shape[0] == 6:
        _add_moment(wrench, arm[0], arm[1], arm[2], fx, fy, fz)


@jit
def _add_moment(wrench, rx, ry, rz, fx, fy, fz):
    wrench[3] += ry * fz - rz * fy
    wrench[4] += rz * fx - rx * fz
    wrench[5] += rx * fy - ry * fx


@jit
def _add_turning(stiffness, rx, ry, rz, fx, fy, fz):
    """Add -[f]x [r]x, minus the derivative of the moment r x f by a rotation of the arm under constant force."""
    dot = rx * fx + ry * fy + rz * fz
    f = (fx, fy, fz)
    r = (rx, ry, rz)
    for i in range(3):
        for j in range(3):
            stiffness[3 + i, 3 + j] -= r[i] * f[j]
        stiffness[3 + i, 3 + i] += dot


@jit
def _add_lever(stiffness, rx, ry, rz, xx, xy, xz, yx, yy, yz, zx, zy, zz):
    """Add the blocks of the translational stiffness K at an arm: -K [r]x, [r]x K and -[r]x K [r]x."""
    k = ((xx, xy, xz), (yx, yy, yz), (zx, zy, zz))
    for i in range(3):
        a, b, c = k[i]
        # row i of -K [r]x
        u, v, w = c * ry - b * rz, a * rz - c * rx, b * rx - a * ry
        stiffness[i, 3] += u
        stiffness[i, 4] += v
        stiffness[i, 5] += w
        # column i of [r]x gives the rows of the lower blocks
        if i == 0:
            first, second, p, q = 4, 5, rz, -ry
        elif i == 1:
            first, second, p, q = 3, 5, -rz, rx
        else:
            first, second, p, q = 3, 4, ry, -rx
        stiffness[first, 0] += p * a
        stiffness[first, 1] += p * b
        stiffness[first, 2] += p * c
        stiffness[second, 0] += q * a
        stiffness[second, 1] += q * b
        stiffness[second, 2] += q * c
        stiffness[first, 3] += p * u
        stiffness[first, 4] += p * v
        stiffness[first, 5] += p * w
        stiffness[second, 3] += q * u
        stiffness[second, 4] += q * v
        stiffness[second, 5] += q * w
