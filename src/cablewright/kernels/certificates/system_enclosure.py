"""Interval enclosures of all equilibrium equations of a robot and of their Jacobian.

The Jacobian has a block for each line and the platform's rows. The equations are those of `equilibrium.evaluate`, and
in a plane those of `held_rows`. Rotations are increments in world axes from the solution's rotation.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.certificates.interval import ROUNDING, ZERO, add, div, inflate, mul, neg, point, root, sqr, sub
from cablewright.kernels.certificates.lines_out_of_plane import enclose_spatial_line
from cablewright.kernels.certificates.plane_rows import hold_jacobian, hold_residual
from cablewright.kernels.layout import (
    EXIT_X,
    FREE,
    PHI,
    PULLS,
    STATE,
    TAU,
    UNKNOWNS,
    WEIGHT,
    WRENCH,
)
from cablewright.kernels.statics.line.enclosure import add_entry, enclose_jacobian, enclose_residual
from cablewright.kernels.statics.line.spatial_enclosure import unknowns_of
from cablewright.kernels.statics.platform_enclosure import (
    add_balance,
    add_wrench,
    along,
    component,
    cross_component,
    enclose_arm,
    enclose_place,
    enclose_weight,
    set_vector,
)


class CertificateWork(NamedTuple):
    """Working memory of one certificate, for N unknowns: those of each line, then the platform's n."""

    offsets: NDArray[np.int64]  # (m + 1,): index of each line's first unknown, and of the platform's
    coupled: NDArray[np.int64]  # (m, 2): a line's rows that the pose changes, and its unknowns that change its wrench
    centre: NDArray[np.float64]  # (N,): the solution's unknowns, without the pose
    blocks: NDArray[np.int64]  # (3m + 1, 4): first and last row, then column, of the Jacobian's nonzero blocks
    low: NDArray[np.float64]  # (N, N): the Jacobian; only its nonzero blocks are used
    high: NDArray[np.float64]
    middle: NDArray[np.float64]
    spread: NDArray[np.float64]  # half widths
    residual: NDArray[np.float64]  # (N, 2)
    inverse: NDArray[np.float64]  # (N, N): Y
    radius: NDArray[np.float64]  # (N,): of the box
    bound: NDArray[np.float64]  # (N,): the zero is within this of the solution
    step: NDArray[np.float64]  # (N,): |Y F|
    sums: NDArray[np.float64]  # (N,)
    entries: NDArray[np.float64]  # (N,): a row of I - Y J
    block: NDArray[np.float64]  # (6, 6)
    columns: NDArray[np.float64]  # (6, 12)
    schur: NDArray[np.float64]  # (n, n)
    identity: NDArray[np.float64]  # (n, n)
    rotation: NDArray[np.float64]  # (3, 3, 2)
    arm: NDArray[np.float64]  # (3, 2)
    moved: NDArray[np.float64]  # (3, 2)
    force: NDArray[np.float64]  # (3, 2)
    change: NDArray[np.float64]  # (3, 2)


@jit(allocates=True)
def certificate_pool(packed):
    """Allocate the memory of a certificate of *packed* as one array; see `unfold`."""
    n = packed.freedoms
    size = n
    for i in range(packed.lines.shape[0]):
        size += unknowns_of(packed.lines[i])[0]
    return np.zeros(5 * size * size + 8 * size + STATE * (2 * STATE + 6) + 2 * n * n + 48)


@jit
def _frame(block, first, last, left, right):
    """Write where a block of the system begins and ends."""
    block[0], block[1], block[2], block[3] = first, last, left, right


@jit(allocates=True)
def unfold(packed, pool):
    """Return the `CertificateWork` of *packed* as views of the array *pool*.

    Python passes one array faster than many.
    """
    m, n = packed.lines.shape[0], packed.freedoms
    offsets, blocks = np.zeros(m + 1, dtype=np.int64), np.zeros((3 * m + 1, 4), dtype=np.int64)
    coupled = np.zeros((m, 2), dtype=np.int64)
    for i in range(m):
        count, coupled[i, 0], coupled[i, 1] = unknowns_of(packed.lines[i])
        offsets[i + 1] = offsets[i] + count
    first, size = offsets[m], offsets[m] + n
    for i in range(m):  # a line's own block, some of its rows by the platform, and the platform's rows by some unknowns
        start, end = offsets[i], offsets[i + 1]
        _frame(blocks[3 * i], start, end, start, end)
        _frame(blocks[3 * i + 1], start, start + coupled[i, 0], first, size)
        _frame(blocks[3 * i + 2], first, size, start, start + coupled[i, 1])
    _frame(blocks[3 * m], first, size, first, size)
    square = size * size
    matrices = pool[: 5 * square].reshape((5, size, size))
    rest = pool[5 * square :]
    vectors = rest[: 6 * size].reshape((6, size))
    residual = rest[6 * size : 8 * size].reshape((size, 2))
    rest = rest[8 * size :]
    block = rest[: STATE * STATE].reshape((STATE, STATE))
    rest = rest[STATE * STATE :]
    columns = rest[: STATE * (STATE + 6)].reshape((STATE, STATE + 6))
    rest = rest[STATE * (STATE + 6) :]
    small = rest[: 2 * n * n].reshape((2, n, n))
    rest = rest[2 * n * n :]
    points = rest[18:48].reshape((5, 3, 2))
    return CertificateWork(
        offsets,
        coupled,
        vectors[5],
        blocks,
        matrices[0],
        matrices[1],
        matrices[2],
        matrices[3],
        residual,
        matrices[4],
        vectors[0],
        vectors[1],
        vectors[2],
        vectors[3],
        vectors[4],
        block,
        columns,
        small[0],
        small[1],
        rest[:18].reshape((3, 3, 2)),
        points[0],
        points[1],
        points[2],
        points[3],
    )


@jit
def residual_of_all(packed, lengths, pose, states, work):
    """Enclose the residuals of all equations at the solution itself."""
    m, n = packed.lines.shape[0], packed.freedoms
    first = work.offsets[m]
    work.radius[first:] = 0.0
    enclose_place(pose, work.rotation)
    for k in range(n):
        work.residual[first + k, 0] = work.residual[first + k, 1] = packed.platform[WRENCH + k]
    enclose_weight(packed, 0.0, work.rotation, work.force, work.arm)
    add_balance(work.residual, first, n, work.arm, work.force)
    for i in range(m):
        row, start = packed.lines[i], work.offsets[i]
        if enclose_spatial_line(packed.general, row, states[i], lengths[i], pose, 0.0, i, True, work):
            continue
        for k in range(start, work.offsets[i + 1]):
            work.centre[k] = states[i, k - start]
        ex, ey, reach, z = place_line(row, pose, 0.0, n, work.radius[first:], work)
        end = start + int(row[UNKNOWNS])
        h, v = enclose_residual(row, states[i], reach, z, point(lengths[i]), work.residual[start:end])
        v = add(v, mul(point(row[WEIGHT]), point(states[i, FREE])))
        pulls = point(row[PULLS])
        h, v = mul(pulls, h), mul(pulls, v)
        set_vector(work.force, neg(mul(h, ex)), neg(mul(h, ey)), neg(v))
        add_balance(work.residual, first, n, work.arm, work.force)
    hold_residual(packed.general, packed.platform, pose, work.residual[first:], work)


@jit
def jacobian_of_all(packed, pose, states, work):
    """Enclose the Jacobian of all equations over the box."""
    m, n = packed.lines.shape[0], packed.freedoms
    first = work.offsets[m]
    low, high = work.low, work.high
    omega = 0.0
    for k in range(3, n):
        omega += work.radius[first + k]
    omega *= ROUNDING
    low[first:, first:], high[first:, first:] = 0.0, 0.0
    enclose_weight(packed, omega, work.rotation, work.force, work.arm)
    for k in range(3, n):
        along(k, omega, work.arm, work.moved)
        for j in range(3):
            add_entry(low, high, first + 3 + j, first + k, cross_component(work.moved, work.force, j))
    for i in range(m):
        row, start = packed.lines[i], work.offsets[i]
        if enclose_spatial_line(packed.general, row, states[i], 0.0, pose, omega, i, False, work):
            continue
        ex, ey, reach, _ = place_line(row, pose, omega, n, work.radius[first:], work)
        end = start + int(row[UNKNOWNS])
        box = work.radius[start:end]
        h, v = enclose_jacobian(row, states[i], box, low[start:end, start:end], high[start:end, start:end])
        pulls = point(row[PULLS])
        h, v, weight = mul(pulls, h), mul(pulls, v), mul(pulls, point(row[WEIGHT]))
        end_v = add(v, mul(weight, inflate(point(states[i, FREE]), box[FREE])))
        set_vector(work.force, neg(mul(h, ex)), neg(mul(h, ey)), neg(end_v))
        _add_unknown(first, start + PHI, n, work, neg(v), h, ex, ey)
        _add_unknown(first, start + TAU, n, work, h, v, ex, ey)
        _add_unknown(first, start + FREE, n, work, ZERO, weight, ex, ey)
        turn = div(h, reach)
        for k in range(n):
            _add_coordinate(first, start, k, n, omega, work, turn, ex, ey)
    hold_jacobian(packed.general, packed.platform, omega, n, low[first:], high[first:], work)


@jit
def place_line(row, pose, omega, n, radius, work):
    """Enclose a line's vertical plane over the box: its direction ex, ey, and the platform point x, z in it.

    Writes the arm of the platform point to work.arm.
    """
    enclose_arm(row, n, omega, work.rotation, work.arm)
    dx, dy = _from_exit(row, pose, radius, work.arm, 0), _from_exit(row, pose, radius, work.arm, 1)
    reach = root(add(sqr(dx), sqr(dy)))
    return div(dx, reach), div(dy, reach), reach, _from_exit(row, pose, radius, work.arm, 2)


@jit
def _from_exit(row, pose, radius, arm, k):
    """Enclose a coordinate of the platform point relative to the exit point over the box."""
    return sub(add(inflate(point(pose[k]), radius[k]), component(arm, k)), point(row[EXIT_X + k]))


@jit
def _add_unknown(first, column, n, work, dh, dv, ex, ey):
    """Set the platform's rows of a line's unknown whose derivative of the end force is (dh, dv)."""
    for k in range(n):
        work.low[first + k, column], work.high[first + k, column] = 0.0, 0.0
    set_vector(work.change, neg(mul(dh, ex)), neg(mul(dh, ey)), neg(dv))
    add_wrench(work.low, work.high, first, column, n, work.arm, work.change)


@jit
def _add_coordinate(first, start, k, n, omega, work, turn, ex, ey):
    """Set a line's entries in the column of pose coordinate *k*: motion of its end, and rotation of its force.

    *turn* is the force per length by which the line's plane rotates.
    """
    along(k, omega, work.arm, work.moved)
    dx, dy = component(work.moved, 0), component(work.moved, 1)
    column = first + k
    work.low[start, column], work.high[start, column] = neg(add(mul(ex, dx), mul(ey, dy)))
    work.low[start + 1, column], work.high[start + 1, column] = neg(component(work.moved, 2))
    turned = mul(turn, sub(mul(ey, dx), mul(ex, dy)))
    set_vector(work.change, neg(mul(ey, turned)), mul(ex, turned), ZERO)
    add_wrench(work.low, work.high, first, column, n, work.arm, work.change)
    if k > 2:
        for j in range(3):
            add_entry(work.low, work.high, first + 3 + j, column, cross_component(work.moved, work.force, j))
