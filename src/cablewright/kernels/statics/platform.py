"""The platform: its position, its load, the forces on it, and its balance within a plane that carries it.

A point moves in the plane; a body also rotates about its normal. Force along the normal, and moments about axes in the
plane, are the plane's, which is taken to hold both ways. With P the projector onto the free directions, the balance
P w = 0 has the stiffness P K P. Without a plane the functions of a plane leave everything as it is.
"""

from math import inf, pi, sqrt

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import copy, largest
from cablewright.kernels.layout import (
    HELD,
    MASS_X,
    NORMAL,
    PLANE_DISTANCE,
    PLATFORM_WEIGHT,
    POINT_X,
    POINT_Y,
    POINT_Z,
    TENSION_MIN,
    WRENCH,
)
from cablewright.kernels.rotation import compose, left_jacobian, matrix, rotate

POSE_STEP, TURN_STEP = 1.0, 0.3  # m, rad: the longest single move of the platform
STARTS = 10  # start rotations of a rigid body
MAX_DEVIATION = 0.05  # m, rad: of a solved pose from the one that its neighbours on a path make expect
IN_PLANE = pi / 5.0  # rad: between the start rotations of a body in a plane


@jit(inline=True)
def place_platform(pose, rotation):
    """Write the *rotation* matrix (3, 3) of the *pose* of a rigid body; a point has none, and it stays as it is."""
    if pose.shape[0] == 6:
        matrix(pose[3:], rotation)


@jit
def pose_of(position, rotation, pose):
    """Write the *pose* (n,) from a *position* (3,) and, of a rigid body, a *rotation* vector (3,)."""
    copy(position, pose[:3])
    if pose.shape[0] == 6:
        copy(rotation, pose[3:])


@jit
def place_arm(lines, i, pose, rotation, arm):
    """Write the *arm* (3,) of line *i*: from the platform's origin to its platform point, world axes, m."""
    arm[0], arm[1], arm[2] = lines[i, POINT_X], lines[i, POINT_Y], lines[i, POINT_Z]
    if pose.shape[0] == 6:
        arm[0], arm[1], arm[2] = rotate(rotation, arm[0], arm[1], arm[2])


@jit(inline=True)
def rates_of_rotation(pose, out):
    """Write the derivative (3, 3) of a body's world rotation by its rotation vector; of a point nothing."""
    if pose.shape[0] == 6:
        left_jacobian(pose[3:], out)


@jit
def shift_pose(pose, shift):
    """Move the *pose* (n,) by *shift* (n,): a translation, and of a body a rotation in world axes."""
    for k in range(3):
        pose[k] += shift[k]
    if pose.shape[0] == 6:
        compose(shift[3], shift[4], shift[5], pose[3:])


@jit
def angle_of(pose):
    """Rotation angle of a pose (n,), rad; 0 for a point load."""
    return sqrt(pose[3] ** 2 + pose[4] ** 2 + pose[5] ** 2) if pose.shape[0] == 6 else 0.0


@jit
def between(start, end, shift):
    """Write to *shift* (n,) the translation and the rotation in world axes that move pose *start* to *end*."""
    for k in range(3):
        shift[k] = end[k] - start[k]
    if start.shape[0] == 6:
        for k in range(3, 6):
            shift[k] = -start[k]
        compose(end[3], end[4], end[5], shift[3:])


@jit
def move_freely(free, pose, step, moved):
    """Write to *moved* the *pose* (n,) after a *step* (p,) in its *free* directions, the columns of (n, p)."""
    n, p = free.shape
    copy(pose, moved)
    if p == n:
        shift_pose(moved, step)
        return
    for c in range(3):
        moved[c] += free[c, 0] * step[0] + free[c, 1] * step[1]
    if n == 6:
        compose(free[3, 2] * step[2], free[4, 2] * step[2], free[5, 2] * step[2], moved[3:])


@jit
def may_be_another(shift):
    """Return whether a *shift* (n,) is so large that another equilibrium was found. Never for a point."""
    return shift.shape[0] == 6 and largest(shift, 6) > MAX_DEVIATION


@jit
def move_platform(pose, work, most):
    """Add work.move, at most *most* (m), to *pose*. Returns the step's length (m) and whether it is full."""
    n = pose.shape[0]
    length = sqrt(work.move[0, 0] ** 2 + work.move[1, 0] ** 2 + work.move[2, 0] ** 2)
    held = 1.0 if length <= most else most / length
    if n == 6:
        turn = sqrt(work.move[3, 0] ** 2 + work.move[4, 0] ** 2 + work.move[5, 0] ** 2)
        if turn * held > TURN_STEP:
            held = TURN_STEP / turn
    for k in range(n):
        work.move[k, 0] *= held
    for k in range(3):
        pose[k] += work.move[k, 0]
    if n == 6:
        compose(work.move[3, 0], work.move[4, 0], work.move[5, 0], pose[3:])
        length += turn
    return length * held, held == 1.0


@jit
def starts_of(packed):
    """Return the number of rotations to try as starts, see `turn_to_start`: 1 of a point."""
    return STARTS if packed.freedoms == 6 else 1


@jit
def turn_to_start(packed, pose, start):
    """Set the rotation of *pose* for start number *start*: none, tilts to four sides, then rotations about z.

    In a plane only the normal is an axis. A point has no rotation.
    """
    if packed.freedoms < 6:
        return
    pose[3:] = 0.0
    if is_held(packed.general, packed.platform):
        turn = (start + 1) // 2 * (IN_PLANE if start % 2 else -IN_PLANE)
        for k in range(3):
            pose[3 + k] = turn * packed.platform[NORMAL + k]
    elif 1 <= start <= 4:
        pose[3 + (start - 1) // 2] = 0.6 if start % 2 else -0.6
    elif start >= 5:
        pose[5] = pi * (0.25, -0.25, 0.5, -0.5, 1.0)[start - 5]


@jit
def load_scale(packed):
    """Return the force (N) to which imbalances are compared: weight plus external force plus moment over arm.

    The arm is the platform's longest. The largest minimum tension takes their place where it is larger, or 1 N where
    all of them are 0.
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
def own_load(packed, rotation, wrench):
    """Write weight plus external wrench to *wrench* (n,); return the weight's lever arm, world: zero of a point."""
    platform = packed.platform
    for k in range(packed.freedoms):
        wrench[k] = platform[WRENCH + k]
    weight = platform[PLATFORM_WEIGHT]
    wrench[2] -= weight
    if packed.freedoms < 6:
        return 0.0, 0.0, 0.0
    rx, ry, rz = rotate(rotation, platform[MASS_X], platform[MASS_X + 1], platform[MASS_X + 2])
    _add_moment(wrench, rx, ry, rz, 0.0, 0.0, -weight)
    return rx, ry, rz


@jit
def start_balance(packed, rotation, wrench, stiffness):
    """Set *wrench* (n,) to the platform's own load and *stiffness* (n, n) to minus its derivative by the pose."""
    n = packed.freedoms
    for k in range(n):
        for j in range(n):
            stiffness[k, j] = 0.0
    rx, ry, rz = own_load(packed, rotation, wrench)
    if n == 6:
        add_turning(stiffness, 3, rx, ry, rz, 0.0, 0.0, -packed.platform[PLATFORM_WEIGHT])


@jit
def weight_without_moment(packed):
    """Return the weight (N) that causes no moment in `own_load`: that of a point platform, else 0."""
    return packed.platform[PLATFORM_WEIGHT] if packed.freedoms == 3 else 0.0


@jit(inline=True)
def add_force(arm, fx, fy, fz, wrench):
    """Add a force at *arm* to *wrench* (n,)."""
    wrench[0] += fx
    wrench[1] += fy
    wrench[2] += fz
    if wrench.shape[0] == 6:
        _add_moment(wrench, arm[0], arm[1], arm[2], fx, fy, fz)


@jit(inline=True)
def gradient_by_pose(arm, gx, gy, gz, out):
    """Write to *out* (n,) the pose derivative of a quantity with the gradient (gx, gy, gz) at the end of *arm*."""
    out[0], out[1], out[2] = gx, gy, gz
    if out.shape[0] == 6:
        out[3] = arm[1] * gz - arm[2] * gy
        out[4] = arm[2] * gx - arm[0] * gz
        out[5] = arm[0] * gy - arm[1] * gx


@jit
def _add_moment(wrench, rx, ry, rz, fx, fy, fz):
    wrench[3] += ry * fz - rz * fy
    wrench[4] += rz * fx - rx * fz
    wrench[5] += rx * fy - ry * fx


@jit
def add_turning(stiffness, first, rx, ry, rz, fx, fy, fz):
    """Add minus the derivative of the moment r x f by a rotation of arm r under constant force f: -[f]x [r]x.

    To the columns of the rotations in *stiffness*, in the rows that begin with *first*.
    """
    dot = rx * fx + ry * fy + rz * fz
    f = (fx, fy, fz)
    r = (rx, ry, rz)
    for i in range(3):
        for j in range(3):
            stiffness[first + i, 3 + j] -= r[i] * f[j]
        stiffness[first + i, 3 + i] += dot


@jit
def add_lever(stiffness, rx, ry, rz, xx, xy, xz, yx, yy, yz, zx, zy, zz):
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


@jit(inline=True)
def is_held(general, platform):
    """Return whether a plane carries the platform; *general*: see `Packed`."""
    if general is None:
        return False
    return platform[HELD] > 0.0


@jit
def _normal(packed):
    """The unit vector across the plane."""
    platform = packed.platform
    return platform[NORMAL], platform[NORMAL + 1], platform[NORMAL + 2]


@jit
def keep_free(packed, wrench):
    """Remove from *wrench* (n,) the part that the plane carries."""
    if not is_held(packed.general, packed.platform):
        return
    x, y, z = _normal(packed)
    along = x * wrench[0] + y * wrench[1] + z * wrench[2]
    wrench[0] -= along * x
    wrench[1] -= along * y
    wrench[2] -= along * z
    if wrench.shape[0] == 6:
        about = x * wrench[3] + y * wrench[4] + z * wrench[5]
        wrench[3], wrench[4], wrench[5] = about * x, about * y, about * z


@jit
def keep_free_columns(packed, columns):
    """Remove from each column of a matrix (n, k) the part that the plane carries, and rounding of moves across it."""
    if not is_held(packed.general, packed.platform):
        return
    x, y, z = _normal(packed)
    for j in range(columns.shape[1]):
        along = x * columns[0, j] + y * columns[1, j] + z * columns[2, j]
        columns[0, j] -= along * x
        columns[1, j] -= along * y
        columns[2, j] -= along * z
        if columns.shape[0] == 6:
            about = x * columns[3, j] + y * columns[4, j] + z * columns[5, j]
            columns[3, j], columns[4, j], columns[5, j] = about * x, about * y, about * z


@jit
def keep_free_part(packed, stiffness):
    """Project the *stiffness* K (n, n) on the free directions, in place: P K P, P the projector on these."""
    if not is_held(packed.general, packed.platform):
        return
    keep_free_columns(packed, stiffness)
    for i in range(stiffness.shape[0]):
        keep_free(packed, stiffness[i])


@jit
def hold(packed, wrench, stiffness):
    """Leave the balance in the free directions; give the others a similar stiffness, so that nothing moves there."""
    if not is_held(packed.general, packed.platform):
        return
    keep_free(packed, wrench)
    keep_free_part(packed, stiffness)
    normal = _normal(packed)
    forces, moments = 0.0, 0.0  # of none the system is singular, as without a plane
    for k in range(stiffness.shape[0]):
        if k < 3:
            forces = max(forces, abs(stiffness[k, k]))
        else:
            moments = max(moments, abs(stiffness[k, k]))
    for i in range(3):
        for j in range(3):
            across = normal[i] * normal[j]
            stiffness[i, j] += forces * across
            if stiffness.shape[0] == 6:
                stiffness[3 + i, 3 + j] += moments * ((1.0 if i == j else 0.0) - across)


@jit
def into_plane(packed, pose):
    """Move the position of *pose* into the plane that carries the platform."""
    if not is_held(packed.general, packed.platform):
        return
    x, y, z = _normal(packed)
    off = x * pose[0] + y * pose[1] + z * pose[2] - packed.platform[PLANE_DISTANCE]
    pose[0] -= off * x
    pose[1] -= off * y
    pose[2] -= off * z


@jit
def least_and_arm(packed):
    """Largest minimum tension (N) of the lines; longest arm (m) of the platform along an axis, infinite of a point."""
    least, arm = 0.0, 0.0
    for i in range(packed.lines.shape[0]):
        row = packed.lines[i]
        least = max(least, row[TENSION_MIN])
        arm = max(arm, abs(row[POINT_X]), abs(row[POINT_Y]), abs(row[POINT_Z]))
    return least, arm if arm > 0.0 else inf


@jit
def load_in_plane(packed):
    """Return the `load_scale` in the plane: its load and the largest minimum tension, or 1 N."""
    platform = packed.platform
    x, y, z = _normal(packed)
    along = x * platform[WRENCH] + y * platform[WRENCH + 1] + z * platform[WRENCH + 2]
    size = platform[PLATFORM_WEIGHT] * sqrt(x * x + y * y)
    for k in range(3):
        size += abs(platform[WRENCH + k] - along * platform[NORMAL + k])
    least, arm = least_and_arm(packed)
    about = x * platform[WRENCH + 3] + y * platform[WRENCH + 4] + z * platform[WRENCH + 5]
    size += least + abs(about) / arm
    return size if size > 0.0 else 1.0


@jit
def axes(packed):
    """Return two unit vectors in the plane that carries the platform; along the world's axes where the plane is."""
    x, y, z = _normal(packed)
    if abs(x) <= abs(y) and abs(x) <= abs(z):
        u, v, w = 1.0 - x * x, -x * y, -x * z
    elif abs(y) <= abs(z):
        u, v, w = -y * x, 1.0 - y * y, -y * z
    else:
        u, v, w = -z * x, -z * y, 1.0 - z * z
    size = sqrt(u * u + v * v + w * w)
    u, v, w = u / size, v / size, w / size
    return u, v, w, y * w - z * v, z * u - x * w, x * v - y * u


@jit
def free_rows(packed, table, scale, rows):
    """Replace the first *rows* of *table*, wrenches (n,), by components in the free directions; return their number.

    Forces along both axes of the plane, and of a body the moment about the normal; so is *scale* (n,).
    """
    n = packed.freedoms
    if not is_held(packed.general, packed.platform):
        return n
    x, y, z = _normal(packed)
    a, b, c, d, e, f = axes(packed)
    for i in range(rows):
        u, v, w = table[i, 0], table[i, 1], table[i, 2]
        table[i, 0], table[i, 1] = a * u + b * v + c * w, d * u + e * v + f * w
        if n == 6:
            table[i, 2] = x * table[i, 3] + y * table[i, 4] + z * table[i, 5]
    if n < 6:
        return 2
    scale[2] = scale[3]
    return 3


@jit
def free_side(packed, half, k):
    """Return half side *k* of a box of wrenches, (n,), in the free directions; exact in a plane along axes."""
    if not is_held(packed.general, packed.platform):
        return half[k]
    a, b, c, d, e, f = axes(packed)
    if k == 0:
        return abs(a) * half[0] + abs(b) * half[1] + abs(c) * half[2]
    if k == 1:
        return abs(d) * half[0] + abs(e) * half[1] + abs(f) * half[2]
    x, y, z = _normal(packed)
    return abs(x) * half[3] + abs(y) * half[4] + abs(z) * half[5]


@jit
def add_reactions(packed, matrix, column):
    """Append columns of the plane's reaction force and moments to the square *matrix* (n, n), from *column* on."""
    if not is_held(packed.general, packed.platform):
        return
    n = packed.freedoms
    x, y, z = _normal(packed)
    for j in range(column, n):
        for i in range(n):
            matrix[i, j] = 0.0
    matrix[0, column], matrix[1, column], matrix[2, column] = x, y, z
    if n == 6:
        a, b, c, d, e, f = axes(packed)
        matrix[3, column + 1], matrix[4, column + 1], matrix[5, column + 1] = a, b, c
        matrix[3, column + 2], matrix[4, column + 2], matrix[5, column + 2] = d, e, f
