"""Interval enclosures of the balance of a platform that a plane carries.

With N the packed normal, as its doubles are, and a the axis of its largest entry, the rows of the balance b become, for
the other axes j, N_a b_j - N_j b_a, which no force along N changes, and in row a the plane's own equation N . p = d. Of
a body the moment about N is in row 3 + a, and rows 3 + j are those of N x R N = 0: the rotation leaves N as it is. Both
are exact: N need not be of unit length.
"""

from cablewright.kernels import jit
from cablewright.kernels.certificates.interval import ZERO, add, mul, point, sub
from cablewright.kernels.layout import HELD, NORMAL, PLANE_DISTANCE
from cablewright.kernels.statics.platform_enclosure import (
    along,
    axis_across,
    component,
    cross_component,
    set_vector,
    turn,
)


@jit
def hold_residual(general, platform, pose, rows, work):
    """Replace the platform's residual *rows* (n, 2) by those in the plane at the *pose* (n,).

    *general*: see `Packed`.
    """
    if general is None or platform[HELD] == 0.0:
        return
    a, n = axis_across(platform), pose.shape[0]
    across = component(rows, a)
    for k in range(3):
        value = sub(mul(_entry(platform, a), component(rows, k)), mul(_entry(platform, k), across))
        rows[k, 0], rows[k, 1] = value
    off = point(-platform[PLANE_DISTANCE])
    for k in range(3):
        off = add(off, mul(_entry(platform, k), point(pose[k])))
    rows[a, 0], rows[a, 1] = off
    if n == 3:
        return
    about = ZERO
    for k in range(3):
        about = add(about, mul(_entry(platform, k), component(rows, 3 + k)))
    _turn_normal(platform, 0.0, work)
    for k in range(3):
        rows[3 + k, 0], rows[3 + k, 1] = about if k == a else cross_component(work.force, work.arm, k)


@jit
def hold_jacobian(general, platform, omega, n, low, high, work):
    """Replace the platform's rows *low* and *high* (n, N) of the Jacobian by those in the plane.

    They hold for rotations of up to *omega*, rad.
    """
    if general is None or platform[HELD] == 0.0:
        return
    a, first = axis_across(platform), low.shape[1] - n
    for column in range(first + n):
        across, about = (low[a, column], high[a, column]), ZERO
        for k in range(3):
            value = sub(mul(_entry(platform, a), (low[k, column], high[k, column])), mul(_entry(platform, k), across))
            low[k, column], high[k, column] = value
        low[a, column] = high[a, column] = 0.0
        if n == 6:
            for k in range(3):
                about = add(about, mul(_entry(platform, k), (low[3 + k, column], high[3 + k, column])))
                low[3 + k, column] = high[3 + k, column] = 0.0
            low[3 + a, column], high[3 + a, column] = about
    for k in range(3):
        low[a, first + k] = high[a, first + k] = platform[NORMAL + k]
    if n == 3:
        return
    _turn_normal(platform, omega, work)
    for k in range(3, 6):
        along(k, omega, work.arm, work.moved)
        for j in range(3):
            if j != a:
                low[3 + j, first + k], high[3 + j, first + k] = cross_component(work.force, work.moved, j)


@jit
def _entry(platform, k):
    return point(platform[NORMAL + k])


@jit
def _turn_normal(platform, omega, work):
    """Write the normal to work.force, and to work.arm where the rotation takes it, by up to *omega* more."""
    x, y, z = platform[NORMAL], platform[NORMAL + 1], platform[NORMAL + 2]
    set_vector(work.force, point(x), point(y), point(z))
    turn(x, y, z, omega, work.rotation, work.arm)
