"""Enclosures of one line over a cell of directions and tensions: its end, its force, and whether it only stiffens.

All quantities are enclosed in the frame along and across phi, in which wide cells cause little overestimation.
Derivatives are those of the free span's end by phi and log tension, or by its force; see `docs/theory/exhaustive.md`. A
line only stiffens where the derivative of its end by the force is positive definite.
"""

from cablewright.kernels import jit
from cablewright.kernels.certificates.interval import (
    ENTIRE,
    ONE,
    PI,
    ZERO,
    add,
    cos,
    div,
    down,
    exp,
    hull,
    inflate,
    intersect,
    mul,
    neg,
    point,
    root,
    scale,
    sin,
    sqr,
    sub,
)
from cablewright.kernels.layout import FREE_COMPLIANCE, LEVER, LEVER_MOMENT, RADIUS, SIDE, UNKNOWNS, WEIGHT
from cablewright.kernels.statics.line.enclosure import arc_length, contact, taken_up
from cablewright.kernels.statics.line.line_branches import dead_angle, free_length, rise
from cablewright.kernels.statics.line.span_enclosure import hanging_span

# Columns of a leaf; all but LABEL and GOOD are the lower end of an interval, whose upper end follows.
CELL_PHI, CELL_TAU = 0, 2
X, Z, REACH = 4, 6, 8  # end of the line from the exit point: horizontally, height, distance
H, V, FREE_SPAN = 10, 12, 14  # force at the start of the free span; its unstrained length
LABEL, GOOD = 16, 17  # GOOD: 1 where the line is proved to stiffen only
CENTRE, BY_PHI, BY_TAU, BEND = 18, 20, 22, 24  # REACH in the cell's middle, its derivatives; sine of the end's angle
LEAF = 26

HANGING, STANDING, UNCLEAR, OTHER_SHEET = 0, 1, 2, 4  # labels; the last is added where phi exceeds half a turn


@jit
def describe(row, length, cell, box, slopes, leaf):
    """Write enclosures of a line's end, force and stiffness over a *cell* to *leaf*.

    The inner unknowns are in *box* with the derivatives *slopes*. For *slopes* see `line_branches.tighten`; row sums
    (column 4) of 1 or more mean that they are not known.
    """
    phi, tau = (cell[0], cell[1]), (cell[2], cell[3])
    t, beta = exp(tau), (box[4], box[5])
    sf, cf = sin(phi), cos(phi)
    free = free_length(row, length, phi, t, box)
    short = free[0] <= 0.0
    free = (max(free[0], 0.0), free[1])
    q = div(mul(point(row[WEIGHT]), free), t)
    along, across, a, b, c = hanging_span(sf, cf, q)
    stretch = mul(point(row[FREE_COMPLIANCE]), t)
    carried = mul(q, scale(stretch, 0.5))
    lever, turn = point(row[LEVER]), point(row[SIDE] * row[RADIUS])
    away = sub(beta, phi) if row[UNKNOWNS] == 6.0 else neg(phi)
    ca, sa = cos(away), sin(away)
    n = add(mul(lever, ca), mul(free, add(add(along, stretch), mul(carried, sf))))
    p = add(add(mul(lever, sa), turn), mul(free, add(across, mul(carried, cf))))
    # not farther than a straight line at the largest tension
    longest = add(add(lever, point(row[RADIUS])), mul(free, add(ONE, mul(stretch, add(ONE, q)))))[1]
    ball = (-longest, longest)
    x = intersect(sub(mul(n, cf), mul(p, sf)), ball)
    reach = intersect(root(add(sqr(n), sqr(p))), ball)
    for k in range(4):
        leaf[k] = cell[k]
    leaf[X], leaf[X + 1] = x
    leaf[Z], leaf[Z + 1] = intersect(add(mul(n, sf), mul(p, cf)), ball)
    leaf[REACH], leaf[REACH + 1] = reach
    leaf[CENTRE], leaf[CENTRE + 1] = reach
    force(t, cf, sf, leaf)
    leaf[FREE_SPAN], leaf[FREE_SPAN + 1] = free
    leaf[BEND], leaf[BEND + 1] = intersect(div(p, reach), (-1.0, 1.0)) if n[0] > 0.0 else (-1.0, 1.0)
    leaf[BY_PHI], leaf[BY_PHI + 1] = ENTIRE
    leaf[BY_TAU], leaf[BY_TAU + 1] = ENTIRE
    leaf[LABEL] = _label(row, phi, t, dead_angle(row, box), beta)
    leaf[GOOD] = 0.0
    if not slopes[0, 4] < 1.0:
        return
    psi = dead_angle(row, box)
    beta_f, beta_t, free_f, free_t = _inner_slopes(row, t, phi, psi, slopes)
    moved = (mul(lever, sa), mul(lever, ca), beta_f, beta_t, free_f, free_t)
    _changes(free, sf, cf, q, a, b, c, stretch, turn, moved, (div(n, reach), div(p, reach)), leaf)
    if not short and x[0] > 0.0 and cf[0] > 0.0 and leaf[LABEL] < UNCLEAR and _is_usual(row, t, phi, box):
        weight = point(row[WEIGHT])
        leaf[GOOD] = 1.0 if _stiffens(weight, t, free, sf, cf, q, a, b, c, stretch, turn, moved) else 0.0


@jit
def _is_usual(row, t, phi, box):
    """Whether in the whole cell the dead span has no loop and the contact is within a turn: neighbours keep it too."""
    if row[UNKNOWNS] > 3.0 and not rise(row, t, box)[1] < 0.0:
        return False
    if row[RADIUS] == 0.0:
        return True
    wound = contact(row, phi, dead_angle(row, box))
    return wound[0] >= 0.0 and wound[1] <= 2.0 * PI[0]


@jit
def force(t, cf, sf, leaf):
    """Write the force at the start of the free span to *leaf*."""
    leaf[H], leaf[H + 1] = mul(t, cf)
    leaf[V], leaf[V + 1] = mul(t, sf)


@jit
def sheet(row, cell):
    """Return the number added to the labels of a cell whose directions exceed half a turn."""
    is_other = cell[0] >= PI[0] or cell[1] <= -PI[0]
    return float(OTHER_SHEET) if row[RADIUS] > 0.0 and is_other else 0.0


@jit
def labels_of(row):
    """Return the number of labels that shapes of a line have: HANGING, and over a lever STANDING too."""
    return 2 if row[UNKNOWNS] == 6.0 else 1


@jit
def _label(row, phi, t, psi, beta):
    """Label by the lever's stability: HANGING if the moment about the joint surely falls with its angle."""
    if row[UNKNOWNS] < 6.0:
        return float(HANGING)
    pull = div(point(row[LEVER_MOMENT]), mul(point(row[LEVER]), t))
    change = sub(sub(mul(pull, sin(beta)), cos(sub(phi, beta))), cos(sub(psi, beta)))
    if change[1] < 0.0:
        return float(HANGING)
    return float(STANDING) if change[0] > 0.0 else float(UNCLEAR)


@jit
def _slope(slopes, a, b):
    return inflate(point(slopes[a, b]), slopes[a, 2 + b])


@jit
def _inner_slopes(row, t, phi, psi, slopes):
    """Derivatives of lever angle and free length by phi and log tension."""
    unknowns = int(row[UNKNOWNS])
    dead_f, dead_t, psi_f, psi_t, beta_f, beta_t = ZERO, ZERO, ZERO, ZERO, ZERO, ZERO
    if unknowns > 3:
        dead_f, dead_t = _slope(slopes, 0, 0), _slope(slopes, 0, 1)
    if unknowns > 4:
        psi_f, psi_t = _slope(slopes, 1, 0), _slope(slopes, 1, 1)
    if unknowns > 5:
        beta_f, beta_t = _slope(slopes, 2, 0), _slope(slopes, 2, 1)
    taken, _ = taken_up(row, t)
    turn = mul(point(row[SIDE] * row[RADIUS]), taken)
    strain = sub(ONE, taken)  # c T / (1 + c T) of the arc
    free_f = neg(add(dead_f, mul(turn, sub(psi_f, ONE))))
    free_t = sub(mul(arc_length(row, psi, phi, taken), strain), add(dead_t, mul(turn, psi_t)))
    return beta_f, beta_t, free_f, free_t


@jit
def _changes(free, sf, cf, q, a, b, c, stretch, turn, moved, direction, leaf):
    """Write the derivatives of the end's distance from the exit point by phi and log tension to *leaf*."""
    lever_n, lever_t, beta_f, beta_t, free_f, free_t = moved
    end, side = add(ONE, mul(q, sf)), mul(q, cf)
    per = add(div(ONE, root(add(sqr(end), sqr(side)))), stretch)
    grow_n, grow_t = mul(end, per), mul(side, per)
    both = mul(free, mul(q, b))
    along_f = add(add(sub(neg(mul(lever_n, beta_f)), turn), mul(grow_n, free_f)), both)
    across_f = add(add(mul(lever_t, beta_f), mul(grow_t, free_f)), mul(free, add(c, stretch)))
    along_t = add(sub(mul(grow_n, free_t), mul(lever_n, beta_t)), mul(free, add(mul(sqr(q), a), stretch)))
    across_t = add(add(mul(lever_t, beta_t), mul(grow_t, free_t)), both)
    leaf[BY_PHI], leaf[BY_PHI + 1] = add(mul(direction[0], along_f), mul(direction[1], across_f))
    leaf[BY_TAU], leaf[BY_TAU + 1] = add(mul(direction[0], along_t), mul(direction[1], across_t))


@jit
def _stiffens(weight, t, free, sf, cf, q, a, b, c, stretch, turn, moved):
    """Whether the derivative of the end's position by its force has a positive definite symmetric part."""
    lever_n, lever_t, beta_f, beta_t, free_f, free_t = moved
    per = add(ONE, stretch)
    # motion of the end besides the span's own compliance, per dT / T and per d phi: along, across
    along_t = sub(mul(per, free_t), mul(lever_n, beta_t))
    along_f = sub(sub(mul(per, free_f), mul(lever_n, beta_f)), turn)
    across_t, across_f = mul(lever_t, beta_t), mul(lever_t, beta_f)
    # changes of force at the end are those at the sheave times I + w e k', where k T = (free_t, free_f)
    kt, kf = div(mul(weight, free_t), t), div(mul(weight, free_f), t)
    scaled = add(ONE, add(mul(kt, sf), mul(kf, cf)))
    if not scaled[0] > 0.0:
        return False
    first = div(add(mul(along_t, sf), mul(along_f, cf)), scaled)
    second = div(add(mul(across_t, sf), mul(across_f, cf)), scaled)
    along_t, along_f = sub(along_t, mul(first, kt)), sub(along_f, mul(first, kf))
    across_t, across_f = sub(across_t, mul(second, kt)), sub(across_f, mul(second, kf))
    # M, all times T / l, first row and column over q
    nn = div(add(stretch, div(along_t, free)), sqr(q))
    nt = div(scale(div(add(along_f, across_t), free), 0.5), q)
    tt = add(stretch, div(across_f, free))
    if not (add(a, nn)[0] > 0.0 and add(c, tt)[0] > 0.0):
        return False
    # det(Q + M), Q of the span alone: A C - B^2 = cos^2 / 2 times the integral of (s - s')^2 / (g g')^3
    longest = hull(ONE, root(add(sqr(add(ONE, mul(q, sf))), sqr(mul(q, cf)))))
    own = div(sqr(cf), scale(sqr(mul(longest, sqr(longest))), 12.0))
    rest = sub(add(add(mul(nn, c), mul(tt, a)), mul(nn, tt)), add(scale(mul(b, nt), 2.0), sqr(nt)))
    return down(own[0] + rest[0]) > 0.0
