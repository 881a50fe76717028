"""The shapes that one line can have over a cell: an interval of directions and one of tensions at its sheave.

Given direction phi and tension of the free span at the sheave, dead span and lever have a few solutions in the inner
unknowns: dead length, psi and beta. Boxes of these (low and high, six numbers) are excluded, narrowed by Krawczyk's
operator, or proved to contain exactly one solution for each point of the cell.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.certificates.interval import (
    GAMMA,
    ONE,
    ROUNDING,
    ZERO,
    add,
    contains_zero,
    cos,
    div,
    down,
    exp,
    mul,
    point,
    scale,
    sin,
    sub,
    up,
)
from cablewright.kernels.dense_systems import copy, solve
from cablewright.kernels.layout import (
    BETA,
    DEAD,
    DEAD_COMPLIANCE,
    DEAD_LENGTH,
    FREE,
    LEVER,
    LEVER_MOMENT,
    PHI,
    PSI,
    RADIUS,
    SIDE,
    STATE,
    TAU,
    UNKNOWNS,
    WEIGHT,
    WINCH_X,
    WINCH_Z,
)
from cablewright.kernels.statics.line.enclosure import (
    arc_length,
    contact,
    dead_direction,
    enclose_jacobian,
    enclose_residual,
    taken_up,
    upright,
)
from cablewright.kernels.statics.line.span_enclosure import hanging_span

TURN = 6.2832  # just above 2 pi
NARROWER = 0.7  # ratio of widths above which a shrunk box is not examined again
INNER = 3  # max number of inner unknowns
TIGHTEN = 4

DROPPED, SHRUNK, PROVED, UNSURE = 0, 1, 2, 3


class ShapeWork(NamedTuple):
    """Working memory of the boxes of one cell."""

    y: NDArray[np.float64]  # (STATE,) middles
    radius: NDArray[np.float64]  # (STATE,)
    low: NDArray[np.float64]  # (STATE, STATE) Jacobian
    high: NDArray[np.float64]
    residual: NDArray[np.float64]  # (STATE, 2)
    inverse: NDArray[np.float64]  # (INNER, INNER)
    block: NDArray[np.float64]  # (INNER, INNER)
    image: NDArray[np.float64]  # (INNER, 2): middles and half widths
    slopes: NDArray[np.float64]  # (INNER, 5): derivatives by phi, by log tension: middles, half widths; row sums
    alone: NDArray[np.float64]  # (6,) a box that contains exactly one solution
    where: NDArray[np.float64]  # (6,) enclosure of that solution


@jit(allocates=True)
def shape_work():
    """Allocate a `ShapeWork`, for `examine` and `tighten`.

    The Jacobian is a slice, as in `certify`, to have one compiled signature.
    """
    jacobian = np.zeros((2, STATE, STATE + 1))
    return ShapeWork(
        np.zeros(STATE),
        np.zeros(STATE),
        jacobian[0, :, :STATE],
        jacobian[1, :, :STATE],
        np.zeros((STATE, 2)),
        np.zeros((INNER, INNER)),
        np.zeros((INNER, INNER)),
        np.zeros((INNER, 2)),
        np.zeros((INNER, 5)),
        np.zeros(6),
        np.zeros(6),
    )


@jit
def examine(row, length, cell, box, work):
    """Try to exclude, narrow or prove one box of the inner unknowns over a *cell*.

    *cell*: phi low, high, log tension low, high. Returns DROPPED: no solution in it; PROVED: for each point of the cell
    exactly one solution in work.alone, which is in work.where; SHRUNK: *box* was reduced; UNSURE: none of these.
    """
    size = int(row[UNKNOWNS]) - 3
    if not _prepare(row, length, cell, box, work):
        return DROPPED
    if size == 0:
        copy(box, work.alone)
        copy(box, work.where)
        return PROVED
    if _misses(row, (cell[0], cell[1]), exp((cell[2], cell[3])), box):
        return DROPPED
    if not _krawczyk(row, work):
        return UNSURE
    for a in range(size):
        if work.image[a, 0] - work.image[a, 1] > box[2 * a + 1] or work.image[a, 0] + work.image[a, 1] < box[2 * a]:
            return DROPPED
    if _is_inside(box, size, work):
        copy(box, work.alone)
        return PROVED
    if _shrink(box, size, work):
        return SHRUNK
    for attempt in range(2):  # the solution may be on the box's edge: try a box around the image
        copy(box, work.alone)
        for a in range(size):
            more = (1.3 + attempt) * work.image[a, 1]
            work.alone[2 * a], work.alone[2 * a + 1] = work.image[a, 0] - more, work.image[a, 0] + more
        work.alone[0] = max(work.alone[0], 0.0)
        if not _prepare(row, length, cell, work.alone, work) or not _krawczyk(row, work):
            return UNSURE
        if _is_inside(work.alone, size, work):
            return PROVED
    return UNSURE


@jit
def tighten(row, length, cell, box, work):
    """Narrow a *box* that contains a solution for each point of the cell; write its derivatives to work.slopes."""
    size = int(row[UNKNOWNS]) - 3
    if size == 0:
        return
    for _ in range(TIGHTEN):
        if not _prepare(row, length, cell, box, work) or not _krawczyk(row, work):
            return
        if not _shrink(box, size, work):
            return


@jit
def free_length(row, length, phi, t, box):
    """Enclose the unstrained length of the free span, m: the line's *length* less dead span and contact."""
    taken, _ = taken_up(row, t)
    rest = (box[0], box[1]) if row[UNKNOWNS] > 3.0 else point(row[DEAD_LENGTH])
    return sub(sub(point(length), rest), arc_length(row, dead_angle(row, box), phi, taken))


@jit
def rise(row, t, box):
    """Enclose the vertical tension of the dead span at the winch, N.

    Where positive the dead span has a loop, which is not a valid shape.
    """
    _, sine = dead_direction(row, dead_angle(row, box))
    return add(mul(t, sine), mul(point(row[WEIGHT]), (box[0], box[1])))


@jit
def dead_angle(row, box):
    """Enclose the direction of the dead span, rad, in a box of the inner unknowns."""
    return (box[2], box[3]) if row[UNKNOWNS] > 4.0 else upright(row[SIDE])


@jit
def lever_moment(row, phi, t, psi, beta):
    """Enclose the moment about the lever's joint, divided by lever length and tension."""
    pull = div(point(row[LEVER_MOMENT]), mul(point(row[LEVER]), t))
    return sub(add(sin(sub(phi, beta)), sin(sub(psi, beta))), mul(pull, cos(beta)))


@jit
def _centre(lo, hi, work, k):
    work.y[k] = 0.5 * (lo + hi)
    work.radius[k] = up(max(hi - work.y[k], work.y[k] - lo))


@jit
def _prepare(row, length, cell, box, work):
    """Write middles and half widths of a cell and a box; False if the free span or the contact is impossible."""
    phi, psi = (cell[0], cell[1]), dead_angle(row, box)
    if row[RADIUS] > 0.0:
        wound = contact(row, phi, psi)
        if wound[1] < 0.0 or wound[0] > TURN:
            return False
    free = free_length(row, length, phi, exp((cell[2], cell[3])), box)
    if free[1] <= 0.0:
        return False
    _centre(cell[0], cell[1], work, PHI)
    _centre(cell[2], cell[3], work, TAU)
    _centre(max(free[0], 0.0), free[1], work, FREE)
    _centre(box[0], box[1], work, DEAD)
    _centre(psi[0], psi[1], work, PSI)
    _centre(box[4], box[5], work, BETA)
    return True


@jit
def _misses(row, phi, t, box):
    """Whether the equations of dead span and lever have no solution in the box, or all of it has a dead span's loop."""
    turn, lever = point(row[SIDE] * row[RADIUS]), point(row[LEVER])
    psi, dead, beta = dead_angle(row, box), (box[0], box[1]), (box[4], box[5])
    cp, sp = dead_direction(row, psi)
    if rise(row, t, box)[0] > 0.0:
        return True
    q = div(mul(point(row[WEIGHT]), dead), t)
    along, across, _, _, _ = hanging_span(sp, cp, q)
    stretch = mul(point(row[DEAD_COMPLIANCE]), t)
    carried = mul(q, scale(stretch, 0.5))
    along = mul(dead, add(add(along, stretch), mul(carried, sp)))
    across = mul(dead, add(across, mul(carried, cp)))
    cb, sb = (cos(beta), sin(beta)) if row[UNKNOWNS] == 6.0 else (ONE, ZERO)
    z = add(sub(mul(lever, sb), mul(turn, cp)), add(mul(along, sp), mul(across, cp)))
    if not contains_zero(sub(z, point(row[WINCH_Z]))):
        return True
    if row[UNKNOWNS] > 4.0:
        x = add(add(mul(lever, cb), mul(turn, sp)), sub(mul(along, cp), mul(across, sp)))
        if not contains_zero(sub(x, point(row[WINCH_X]))):
            return True
    return row[UNKNOWNS] > 5.0 and not contains_zero(lever_moment(row, phi, t, psi, beta))


@jit
def _krawczyk(row, work):
    """Write Krawczyk's image of the inner unknowns' box, and their derivatives over it. False if it does not exist."""
    size = int(row[UNKNOWNS]) - 3
    enclose_residual(row, work.y, ZERO, ZERO, ZERO, work.residual)
    enclose_jacobian(row, work.y, work.radius, work.low, work.high)
    for a in range(size):
        for b in range(size):
            work.block[a, b] = 0.5 * (work.low[3 + a, 3 + b] + work.high[3 + a, 3 + b])
            work.inverse[a, b] = 1.0 if a == b else 0.0
            if not abs(work.block[a, b]) < 1e100:
                return False
    if not solve(work.block, work.inverse, size, size):
        return False
    worst = 0.0
    for a in range(size):
        shift, total = 0.0, 0.0
        for c in range(size):
            lo, hi = work.residual[3 + c, 0], work.residual[3 + c, 1]
            middle = 0.5 * (lo + hi)
            shift += work.inverse[a, c] * middle
            total += abs(work.inverse[a, c]) * (hi - lo + GAMMA * abs(middle))
        sums = 0.0
        for b in range(size):
            left, spread = _times_jacobian(a, 3 + b, size, work)
            share = abs((1.0 if a == b else 0.0) - left) + spread + GAMMA
            total += share * work.radius[3 + b]
            sums += share
        for b in range(2):
            left, spread = _times_jacobian(a, b, size, work)
            total += (abs(left) + spread) * work.radius[b]
            work.slopes[a, b], work.slopes[a, 2 + b] = -left, spread
        work.slopes[a, 4] = sums
        worst = max(worst, sums)
        work.image[a, 0] = work.y[3 + a] - shift
        work.image[a, 1] = (total + GAMMA * (abs(work.y[3 + a]) + abs(shift))) * ROUNDING
        if not work.image[a, 1] < 1e100:
            return False
    _widen_slopes(size, worst, work)
    return True


@jit
def _times_jacobian(a, column, size, work):
    """Row *a* of the inverse times a column of the Jacobian: middle and half width."""
    value, spread = 0.0, 0.0
    for c in range(size):
        lo, hi = work.low[3 + c, column], work.high[3 + c, column]
        middle = 0.5 * (lo + hi)
        value += work.inverse[a, c] * middle
        spread += abs(work.inverse[a, c]) * (max(hi - middle, middle - lo) + GAMMA * abs(middle))
    return value, spread


@jit
def _widen_slopes(size, worst, work):
    """Widen the derivatives D for the error of Y: J D = -J_p, so D = -Y J_p + (I - Y J) D."""
    slopes = work.slopes
    for b in range(2):
        spread, largest = 0.0, 0.0
        for a in range(size):
            spread, largest = max(spread, slopes[a, 2 + b]), max(largest, abs(slopes[a, b]))
        bound = (spread + worst * largest) / (1.0 - worst) * ROUNDING if worst < 1.0 else np.inf
        for a in range(size):
            slopes[a, 2 + b] = (slopes[a, 2 + b] + slopes[a, 4] * (largest + bound)) * ROUNDING


@jit
def _is_inside(box, size, work):
    """Whether the image is inside the box; writes the enclosure of the solution to work.where."""
    copy(box, work.where)
    for a in range(size):
        lo, hi = down(work.image[a, 0] - work.image[a, 1]), up(work.image[a, 0] + work.image[a, 1])
        if not (box[2 * a] < lo and hi < box[2 * a + 1]):
            return False
        work.where[2 * a], work.where[2 * a + 1] = lo, hi
    return True


@jit
def _shrink(box, size, work):
    """Intersect the box with the image. Returns whether that makes it much smaller."""
    shrunk = False
    for a in range(size):
        wide = box[2 * a + 1] - box[2 * a]
        box[2 * a] = max(box[2 * a], down(work.image[a, 0] - work.image[a, 1]))
        box[2 * a + 1] = min(box[2 * a + 1], up(work.image[a, 0] + work.image[a, 1]))
        shrunk = shrunk or box[2 * a + 1] - box[2 * a] < NARROWER * wide
    return shrunk
