"""Edges of square tags in a camera picture: residuals, and derivatives by the pose, camera, lens and tag.

The camera looks along its z axis, with x to the right and y down the picture. Lens: two focal lengths, the principal
point, and Brown's distortion (1966) k1, k2, p1, p2, k3, in the order of OpenCV. The corners of a tag go round it from
its top left, as seen in the picture: an edge runs from one corner to the next. The residuals of an edge are its
distances from its line in the picture at both ends: the sum and the difference of the two have independent errors.
"""

from math import nan

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import copy
from cablewright.kernels.rotation import cross, left_jacobian, matrix, rotate, rotate_back

# Columns of a body, a camera or a tag: its place and a turn after its first rotation, in the world or on the platform;
# of a camera the lens, whose first four numbers are over a unit in pixels; the size of the print over that of the file.
# These may be unknown. Then the first rotation, half the side of a tag, whether the body is on the platform, the unit;
# and what follows from them: rotation, and left Jacobian.
PLACE, TURN, LENS, PRINT = 0, 3, 6, 15
NUMBERS = 16
BASE, HALF, MOUNTED, UNIT = 16, 25, 26, 27
ROTATION, JACOBIAN = 28, 37
BODY_COLUMNS = 46
MIN_DEPTH = 1e-3  # m: nearer to the camera, or behind it, there is no picture


@jit
def place_body(body, one, two):
    """Write rotation and left Jacobian of a camera or tag, *body* (BODY_COLUMNS,), into its own row.

    *one*, *two* (3, 3) are scratch.
    """
    matrix(body[TURN : TURN + 3], one)
    left_jacobian(body[TURN : TURN + 3], two)
    for a in range(3):
        for b in range(3):
            total = 0.0
            for c in range(3):
                total += one[a, c] * body[BASE + 3 * c + b]
            body[ROTATION + 3 * a + b] = total
            body[JACOBIAN + 3 * a + b] = two[a, b]


@jit
def _turned(body, x, y, z):
    """The vector (x, y, z) of the body's frame in the frame that it is in."""
    r = ROTATION
    return (
        body[r] * x + body[r + 1] * y + body[r + 2] * z,
        body[r + 3] * x + body[r + 4] * y + body[r + 5] * z,
        body[r + 6] * x + body[r + 7] * y + body[r + 8] * z,
    )


@jit
def _turned_back(body, x, y, z):
    """The vector (x, y, z) in the body's frame."""
    r = ROTATION
    return (
        body[r] * x + body[r + 3] * y + body[r + 6] * z,
        body[r + 1] * x + body[r + 4] * y + body[r + 7] * z,
        body[r + 2] * x + body[r + 5] * y + body[r + 8] * z,
    )


@jit
def _add_turn(body, by, gx, gy, gz, ax, ay, az):
    """Add the derivative by the turn, of an arm (ax, ay, az) that turns with it, from the gradient by the arm."""
    tx, ty, tz = cross(ax, ay, az, gx, gy, gz)
    for a in range(3):
        by[TURN + a] += body[JACOBIAN + a] * tx + body[JACOBIAN + 3 + a] * ty + body[JACOBIAN + 6 + a] * tz


@jit
def in_picture(lens, x, y, nx, ny, by):
    """Project a point into the picture: return n (u, v), and its gradient by x and y.

    x, y: the direction of a point, over its depth; u, v: its pixel; n = (nx, ny). The derivatives by the *lens* (9,)
    are added to *by*.
    """
    k1, k2, p1, p2, k3 = lens[4], lens[5], lens[6], lens[7], lens[8]
    r = x * x + y * y
    radial = 1.0 + r * (k1 + r * (k2 + r * k3))
    rise = 2.0 * (k1 + r * (2.0 * k2 + 3.0 * k3 * r))  # of the radial factor, over x or y
    xd = x * radial + 2.0 * p1 * x * y + p2 * (r + 2.0 * x * x)
    yd = y * radial + p1 * (r + 2.0 * y * y) + 2.0 * p2 * x * y
    fx, fy = nx * lens[0], ny * lens[1]
    both = x * y * rise + 2.0 * p1 * x + 2.0 * p2 * y
    gx = fx * (radial + x * x * rise + 2.0 * p1 * y + 6.0 * p2 * x) + fy * both
    gy = fx * both + fy * (radial + y * y * rise + 6.0 * p1 * y + 2.0 * p2 * x)
    along = fx * x + fy * y
    by[0] += nx * xd
    by[1] += ny * yd
    by[2] += nx
    by[3] += ny
    by[4] += along * r
    by[5] += along * r * r
    by[6] += fx * 2.0 * x * y + fy * (r + 2.0 * y * y)
    by[7] += fx * (r + 2.0 * x * x) + fy * 2.0 * x * y
    by[8] += along * r * r * r
    return fx * xd + fy * yd + nx * lens[2] + ny * lens[3], gx, gy


@jit
def _corner(camera, tag, corner, nx, ny, pose, rotation, slope, by_camera, by_tag):
    """Add the derivatives of n (u, v) of a corner of a tag. Returns n (u, v), NaN for a corner behind the camera."""
    half = tag[HALF] * tag[PRINT]
    right = half if corner in (1, 2) else -half
    up = half if corner < 2 else -half
    cx, cy, cz = _turned(tag, right, up, 0.0)
    wx, wy, wz = tag[PLACE] + cx, tag[PLACE + 1] + cy, tag[PLACE + 2] + cz
    if tag[MOUNTED] != 0.0:
        ax, ay, az = rotate(rotation, wx, wy, wz)
        wx, wy, wz = pose[0] + ax, pose[1] + ay, pose[2] + az
    else:
        ax, ay, az = 0.0, 0.0, 0.0
    yx, yy, yz = wx, wy, wz
    bx, by_, bz = wx - pose[0], wy - pose[1], wz - pose[2]  # from the platform
    if camera[MOUNTED] != 0.0:
        yx, yy, yz = rotate_back(rotation, bx, by_, bz)
    yx, yy, yz = yx - camera[PLACE], yy - camera[PLACE + 1], yz - camera[PLACE + 2]
    px, py, pz = _turned_back(camera, yx, yy, yz)
    if not pz > MIN_DEPTH:
        return nan
    x, y = px / pz, py / pz
    nx, ny = nx * camera[UNIT], ny * camera[UNIT]
    seen, gx, gy = in_picture(camera[LENS : LENS + 9], x, y, nx, ny, by_camera[LENS : LENS + 9])
    gx, gy, gz = gx / pz, gy / pz, -(gx * x + gy * y) / pz
    gx, gy, gz = _turned(camera, gx, gy, gz)  # by the point, in the frame of the camera's place
    by_camera[PLACE] -= gx
    by_camera[PLACE + 1] -= gy
    by_camera[PLACE + 2] -= gz
    _add_turn(camera, by_camera, -gx, -gy, -gz, yx, yy, yz)
    if camera[MOUNTED] != 0.0:
        gx, gy, gz = rotate(rotation, gx, gy, gz)
        _add_pose(slope, -gx, -gy, -gz, bx, by_, bz)
    if tag[MOUNTED] != 0.0:
        _add_pose(slope, gx, gy, gz, ax, ay, az)
        gx, gy, gz = rotate_back(rotation, gx, gy, gz)
    by_tag[PLACE] += gx
    by_tag[PLACE + 1] += gy
    by_tag[PLACE + 2] += gz
    _add_turn(tag, by_tag, gx, gy, gz, cx, cy, cz)
    by_tag[PRINT] += (gx * cx + gy * cy + gz * cz) / tag[PRINT]
    return seen


@jit
def _add_pose(slope, gx, gy, gz, ax, ay, az):
    """Add the derivative by the pose of a point at an arm (ax, ay, az) from the platform, world."""
    tx, ty, tz = cross(ax, ay, az, gx, gy, gz)
    slope[0] += gx
    slope[1] += gy
    slope[2] += gz
    slope[3] += tx
    slope[4] += ty
    slope[5] += tz


@jit
def edge(bodies, camera, tag, extra, pose, rotation, slope, by):
    """Return one residual of a tag's edge: the sum or difference of its corners' distances along the normal n.

    Writes its derivatives by the pose, the camera and the tag. *extra*: number of the first corner; +1 for the sum, -1
    for the difference; n. *by* (2, NUMBERS): by camera, tag.
    """
    by[:, :] = 0.0
    slope[:] = 0.0
    first, sign = int(extra[0]), extra[1]
    one = _corner(bodies[camera], bodies[tag], first, extra[2], extra[3], pose, rotation, slope, by[0], by[1])
    nx, ny, second = sign * extra[2], sign * extra[3], (first + 1) % 4
    return one + _corner(bodies[camera], bodies[tag], second, nx, ny, pose, rotation, slope, by[0], by[1])


@jit
def place_bodies(known, target, theta, bodies, one, two):
    """Write all numbers of the cameras and tags to *bodies*, with the unknowns taken from *theta* (k,)."""
    for i in range(bodies.shape[0]):
        copy(known[i], bodies[i])
        for c in range(NUMBERS):
            if target[i, c] >= 0:
                bodies[i, c] = theta[target[i, c]]
        place_body(bodies[i], one, two)
