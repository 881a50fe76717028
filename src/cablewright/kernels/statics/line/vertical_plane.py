"""The vertical plane in which an upright line hangs: its position, and the forces of a line in it on the platform."""

from math import hypot, sqrt

from cablewright.kernels import jit
from cablewright.kernels.layout import EXIT_X, GUIDE, LEVER, PULLS, RADIUS, UNKNOWNS
from cablewright.kernels.statics.platform import add_force, add_lever, add_turning, place_arm

AXIS_DISTANCE = 1e-12  # m: nearer to the vertical through the exit point the direction of a plane is arbitrary
NO_PLANE = 1e-9  # m: nearer to the vertical through its exit point a line over a sheave has no plane
STRAIGHT_DOWN = 1e-7  # m: nearer to it the line from an eyelet is as stiff sideways as in its plane


@jit(inline=True)
def place(lines, i, pose, rotation, arm, plane):
    """Write the arm (3,) of line *i*, from the platform's origin to its platform point, world, and its plane (4,).

    The plane is given by its horizontal direction (ex, ey) and the platform point (x, z) in it, from the exit point.
    """
    place_arm(lines, i, pose, rotation, arm)
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
    """Return whether a line has a vertical plane: it is not on the axis of its sheave, nor in its eyelet.

    From an eyelet straight down any plane is valid.
    """
    if plane[2] > NO_PLANE:
        return True
    return is_eyelet(row) and abs(plane[3]) > NO_PLANE


@jit(inline=True)
def sideways(row, x, h, kxx):
    """Return the stiffness of a line across its plane, h / x, N/m.

    The plane turns about the vertical through the exit point. Where the line runs along that vertical all planes are
    equivalent, and its limit is the stiffness *kxx* in the plane.
    """
    if x < STRAIGHT_DOWN and (is_eyelet(row) or abs(h) <= 2.0 * STRAIGHT_DOWN * abs(kxx)):
        return kxx
    return h / max(x, AXIS_DISTANCE)


@jit(inline=True)
def add_line(row, arm, plane, h, v, kxx, kxz, kzx, kzz, wrench, stiffness):
    """Add the wrench and stiffness of one line to the platform's, in the line's plane.

    (h, v): tension at the end of a span, with its derivatives by (x, z).
    """
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
        add_turning(stiffness, 3, rx, ry, rz, fx, fy, fz)
        add_lever(stiffness, rx, ry, rz, xx, xy, xz, xy, yy, yz, zx, zy, kzz)


@jit(inline=True)
def add_pull(row, arm, plane, h, v, wrench):
    """Add the force with which a line pulls at *arm* to *wrench* (n,); (h, v): tension at the end of one span, N."""
    h, v = row[PULLS] * h, row[PULLS] * v
    add_force(arm, -h * plane[0], -h * plane[1], -v, wrench)


@jit(inline=True)
def is_in_reach_of_lever(row, plane):
    """Whether the platform point of a line over a lever is too near its exit point for a tangent at every angle."""
    return row[UNKNOWNS] == 6.0 and hypot(plane[2], plane[3]) < row[LEVER] + row[RADIUS]
