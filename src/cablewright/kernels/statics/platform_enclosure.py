"""Interval enclosures of the platform: position, arms, load, and wrenches of forces on it, as `statics.platform`.

A vector is an array (3, 2) of its components' lower and upper ends. Rotations are increments in world axes from the
pose's own rotation, of which *omega*, rad, bounds the size.
"""

from math import inf, sqrt

from cablewright.kernels import jit
from cablewright.kernels.certificates.interval import (
    ONE,
    ROUNDING,
    ZERO,
    add,
    div,
    inflate,
    mul,
    point,
    root,
    scale,
    sin,
    sqr,
    sub,
)
from cablewright.kernels.layout import HELD, MASS_X, NORMAL, PLATFORM_WEIGHT, POINT_X
from cablewright.kernels.statics.line.enclosure import add_entry


@jit
def set_vector(vector, x, y, z):
    """Write the components *x*, *y* and *z* of a *vector* (3, 2)."""
    vector[0, 0], vector[0, 1] = x
    vector[1, 0], vector[1, 1] = y
    vector[2, 0], vector[2, 1] = z


@jit
def component(vector, k):
    """Return component *k* of a *vector* (3, 2)."""
    return vector[k, 0], vector[k, 1]


@jit
def cross_component(a, b, k):
    """Return component *k* of a cross product of two interval vectors."""
    i, j = (k + 1) % 3, (k + 2) % 3
    return sub(mul(component(a, i), component(b, j)), mul(component(a, j), component(b, i)))


@jit
def enclose_place(pose, rotation):
    """Enclose the *rotation* matrix (3, 3, 2) of a body's *pose*; a point has none, and it stays as it is."""
    if pose.shape[0] == 6:
        enclose_rotation(pose, rotation)


@jit
def enclose_rotation(pose, out):
    """Enclose the rotation matrix of the pose's rotation vector (Rodrigues)."""
    x, y, z = point(pose[3]), point(pose[4]), point(pose[5])
    square = add(add(sqr(x), sqr(y)), sqr(z))
    if square[1] > 1e-8:
        angle = root(square)
        half = mul((0.5, 0.5), angle)
        a = div(sin(angle), angle)
        sine = div(sin(half), half)
        b = mul((0.5, 0.5), sqr(sine))
    else:  # alternating series
        a = sub(ONE, mul(square, (0.0, 0.16666666666666669)))
        b = sub((0.5, 0.5), mul(square, (0.0, 0.04166666666666667)))
    xx, yy, zz = mul(b, sqr(x)), mul(b, sqr(y)), mul(b, sqr(z))
    xy, xz, yz = mul(b, mul(x, y)), mul(b, mul(x, z)), mul(b, mul(y, z))
    ax, ay, az = mul(a, x), mul(a, y), mul(a, z)
    _write(out, 0, 0, sub(ONE, add(yy, zz)))
    _write(out, 1, 1, sub(ONE, add(xx, zz)))
    _write(out, 2, 2, sub(ONE, add(xx, yy)))
    _write(out, 0, 1, sub(xy, az))
    _write(out, 1, 0, add(xy, az))
    _write(out, 0, 2, add(xz, ay))
    _write(out, 2, 0, sub(xz, ay))
    _write(out, 1, 2, sub(yz, ax))
    _write(out, 2, 1, add(yz, ax))


@jit
def _write(out, i, j, value):
    out[i, j, 0], out[i, j, 1] = value


@jit
def enclose_arm(row, n, omega, rotation, arm):
    """Enclose the *arm* (3, 2) of a line, from the platform's origin to its platform point, world.

    *n*: coordinates of the pose.
    """
    if n == 3:
        for k in range(3):
            arm[k, 0] = arm[k, 1] = row[POINT_X + k]
    else:
        turn(row[POINT_X], row[POINT_X + 1], row[POINT_X + 2], omega, rotation, arm)


@jit
def turn(x, y, z, omega, rotation, out):
    """Enclose a point of the platform after the pose's rotation and further rotations by up to *omega*."""
    size = (abs(x) + abs(y) + abs(z)) * omega * ROUNDING
    for k in range(3):
        a = mul((rotation[k, 0, 0], rotation[k, 0, 1]), point(x))
        b = mul((rotation[k, 1, 0], rotation[k, 1, 1]), point(y))
        c = mul((rotation[k, 2, 0], rotation[k, 2, 1]), point(z))
        out[k, 0], out[k, 1] = add(add(add(a, b), c), (-size, size))


@jit
def turning_arm(packed, row):
    """Return an upper bound of the distance, m, of a line's platform point from a body's origin; of a point 0."""
    if packed.freedoms == 3:
        return 0.0
    return sqrt(row[POINT_X] ** 2 + row[POINT_X + 1] ** 2 + row[POINT_X + 2] ** 2) * ROUNDING


@jit
def enclose_weight(packed, omega, rotation, force, arm):
    """Enclose the platform's weight as a *force* (3, 2), N, and of a body its *arm* (3, 2)."""
    platform = packed.platform
    set_vector(force, ZERO, ZERO, point(-platform[PLATFORM_WEIGHT]))
    if packed.freedoms == 6:
        turn(platform[MASS_X], platform[MASS_X + 1], platform[MASS_X + 2], omega, rotation, arm)


@jit
def add_wrench(low, high, first, column, n, arm, force):
    """Add a force at *arm* to the platform's rows of a column."""
    for k in range(3):
        add_entry(low, high, first + k, column, component(force, k))
        if n == 6:
            add_entry(low, high, first + 3 + k, column, cross_component(arm, force, k))


@jit
def add_balance(residual, first, n, arm, force):
    """Add a force at *arm* to the platform's rows of the residual."""
    for k in range(n):
        at = first + k
        value = component(force, k) if k < 3 else cross_component(arm, force, k - 3)
        residual[at, 0], residual[at, 1] = add(component(residual, at), value)


@jit
def along(k, omega, arm, moved):
    """Enclose the motion of a point at *arm* with pose coordinate *k*: an axis, or its cross product with *arm*.

    After a rotation of at most *omega*, an increment of a rotation coordinate is its axis to within omega (the left
    Jacobian).
    """
    if k < 3:
        set_vector(moved, ZERO, ZERO, ZERO)
        moved[k, 0], moved[k, 1] = 1.0, 1.0
        return
    axis = k - 3
    i, j = (axis + 1) % 3, (axis + 2) % 3
    near, one = (-omega, omega), add(ONE, (-omega, omega))
    a, b, c = component(arm, axis), component(arm, i), component(arm, j)
    moved[axis, 0], moved[axis, 1] = sub(mul(near, c), mul(near, b))
    moved[i, 0], moved[i, 1] = sub(mul(near, a), mul(one, c))
    moved[j, 0], moved[j, 1] = sub(mul(one, b), mul(near, a))


@jit
def rotation_of(motion, n):
    """Return the rotation (3) in the *motion* (n,) of a platform with *n* degrees of freedom; a point has none."""
    return (motion[3], motion[4], motion[5]) if n == 6 else (0.0, 0.0, 0.0)


@jit
def rotation_between(other, pose, spread, a, b, turned):
    """Write an enclosure (3, 2) of the rotation vectors from a body's *pose* to the box of *spread* about *other*.

    *a* and *b* (3, 3, 2) are scratch. Of a point nothing is written. Returns the number of rotations, 3 or none.
    """
    if pose.shape[0] == 3:
        return 0
    enclose_rotation(other, a)
    enclose_rotation(pose, b)
    trace, square, spare = (0.0, 0.0), (0.0, 0.0), 0.0
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        trace = add(trace, _product(a, b, k, k))
        sine = scale(sub(_product(a, b, j, i), _product(a, b, i, j)), 0.5)
        turned[k, 0], turned[k, 1] = sine
        square = add(square, sqr(sine))
        spare += 1.6 * spread[3 + k] * ROUNDING  # a rotation vector changes by at most pi/2 times the rotation
    small = trace[0] > 1.0 and square[1] < 0.25  # asin(s) / s < 1 + s^2 there
    for k in range(3):
        off = mul((turned[k, 0], turned[k, 1]), (1.0, 1.0 + 1.01 * square[1]))
        turned[k, 0], turned[k, 1] = inflate(off, spare) if small else (-inf, inf)
    return 3


@jit
def _product(a, b, i, j):
    """Entry of A B^T."""
    total = (0.0, 0.0)
    for k in range(3):
        total = add(total, mul((a[i, k, 0], a[i, k, 1]), (b[j, k, 0], b[j, k, 1])))
    return total


@jit
def axis_across(platform):
    """Return the axis (0, 1 or 2) of the largest entry of the plane's normal."""
    a = 0
    for k in range(1, 3):
        if abs(platform[NORMAL + k]) > abs(platform[NORMAL + a]):
            a = k
    return a


@jit
def share_balance(general, platform, row, wrench):
    """Convert a *row* (n,) of Y from the rows of `held_rows` to those of the balance itself: *wrench* (6,).

    Returns the sum of the absolute values that were added up, for rounding, and of the entries at the rows of a tilt.
    """
    n, bulk = row.shape[0], 0.0
    for k in range(n):
        wrench[k] = row[k]
    for k in range(3):
        bulk += abs(row[k])
    if general is None or platform[HELD] == 0.0:
        return bulk, 0.0
    a, tilt = axis_across(platform), 0.0
    wrench[a] = 0.0
    for k in range(3):
        if k != a:
            wrench[k] = platform[NORMAL + a] * row[k]
            wrench[a] -= platform[NORMAL + k] * row[k]
    bulk *= abs(platform[NORMAL]) + abs(platform[NORMAL + 1]) + abs(platform[NORMAL + 2])
    if n == 6:
        for k in range(3):
            wrench[3 + k] = platform[NORMAL + k] * row[3 + a]
            tilt += abs(row[3 + k]) if k != a else 0.0
    return bulk, tilt


@jit
def bend_of_tilt(packed):
    """Return a bound of the second derivatives of the tilt equations by a small rotation.

    It is |N|^2 of a body in a plane, else 0.
    """
    body = packed.platform
    if packed.freedoms < 6 or body[HELD] == 0.0:
        return 0.0
    return body[NORMAL] ** 2 + body[NORMAL + 1] ** 2 + body[NORMAL + 2] ** 2


@jit
def width_that_counts(platform, found, k):
    """Return the width of pose coordinate *k* of the box *found* (2.., n), low and high.

    In a plane it is the widest of its kind.
    """
    first, last = k, k + 1
    if platform[HELD] != 0.0:
        first = 3 * (k // 3)
        last = first + 3
    width = 0.0
    for j in range(first, last):
        width = max(width, found[1, j] - found[0, j])
    return width
