"""Cover of all possible shapes of one line by leaves: cells of direction and tension at its sheave."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.certificates.interval import cos, exp, sin
from cablewright.kernels.dense_systems import copy
from cablewright.kernels.layout import UNKNOWNS
from cablewright.kernels.statics.line.line_branches import (
    DROPPED,
    INNER,
    PROVED,
    SHRUNK,
    ShapeWork,
    examine,
    shape_work,
    tighten,
)
from cablewright.kernels.statics.line.line_cell import (
    CENTRE,
    GOOD,
    LABEL,
    LEAF,
    REACH,
    UNCLEAR,
    H,
    X,
    Z,
    describe,
    force,
    labels_of,
    sheet,
)

MAX_BOXES = 128  # boxes of the inner unknowns of one cell that are kept apart
CUTS = 4000  # max bisections of boxes in one cell
DEPTH = 4096  # max number of waiting cells
BOXES = 20_000  # max number of their boxes
ANGLE_WEIGHT = 5.0  # m per rad: weight of a box's width in psi relative to its dead length
TURN = 6.283185307179586
FULL = -1


class AtlasWork(NamedTuple):
    """Working memory of `cover`."""

    shape: ShapeWork
    pool: NDArray[np.float64]  # (BOXES, 6): boxes of the waiting cells, then of the current cell
    cells: NDArray[np.float64]  # (DEPTH, 4): waiting cells
    spans: NDArray[np.int64]  # (DEPTH, 3): first and last of their boxes in the pool, and whether shapes were skipped
    alone: NDArray[np.float64]  # (MAX_BOXES, 6): boxes that contain exactly one solution
    where: NDArray[np.float64]  # (MAX_BOXES, 6): enclosures of these
    slopes: NDArray[np.float64]  # (MAX_BOXES, INNER, 5)
    kept: NDArray[np.float64]  # (MAX_BOXES, 6): boxes of which nothing is proved
    leaf: NDArray[np.float64]  # (LEAF,)
    unknown: NDArray[np.float64]  # (INNER, 5): slopes marked as not known
    cell: NDArray[np.float64]  # (4,)
    middle: NDArray[np.float64]  # (4,)
    box: NDArray[np.float64]  # (6,)
    found: NDArray[np.int64]  # (2,)


@jit(allocates=True)
def atlas_work():
    """Allocate an `AtlasWork`."""
    unknown = np.zeros((INNER, 5))
    unknown[0, 4] = 1.0
    return AtlasWork(
        shape_work(),
        np.zeros((BOXES, 6)),
        np.zeros((DEPTH, 4)),
        np.zeros((DEPTH, 3), dtype=np.int64),
        np.zeros((MAX_BOXES, 6)),
        np.zeros((MAX_BOXES, 6)),
        np.zeros((MAX_BOXES, INNER, 5)),
        np.zeros((MAX_BOXES, 6)),
        np.zeros(LEAF),
        unknown,
        np.zeros(4),
        np.zeros(4),
        np.zeros(6),
        np.zeros(2, dtype=np.int64),
    )


@jit
def cover(row, length, cell, box, grain, view, leaves, count, work):
    """Cover a *cell* (4,) of directions and log tensions of a line with leaves, added to *leaves* after row *count*.

    *box* (6,) contains all inner unknowns: low and high of dead length, psi, beta. *grain* (6,): width in phi and log
    tension of the largest leaf, of the smallest leaf, and of the largest leaf that ends out of view. *view* (4,): low
    and high of horizontal distance and height from the exit point that are of interest. Returns the new count, FULL
    where there is no room.
    """
    copy(box, work.pool[0])
    copy(cell, work.cells[0])
    work.spans[0] = (0, 1, 0)
    depth = 1
    while depth > 0:
        depth -= 1
        copy(work.cells[depth], work.cell)
        first, last = work.spans[depth, 0], work.spans[depth, 1]
        one, rest, resolved, hole = _sift(row, length, first, last, grain, view, work)
        hole = hole or work.spans[depth, 2] != 0
        count, split = _write(row, length, one, rest, resolved, hole, grain, view, leaves, count, work)
        if count == FULL:
            return FULL
        if split:
            top = _inherit(int(row[UNKNOWNS]) - 3, one, rest, last, work)
            if top == FULL or depth + 2 > DEPTH:
                return FULL
            wide_phi, wide_tau = work.cell[1] - work.cell[0], work.cell[3] - work.cell[2]
            axis = 0 if wide_phi / grain[2] > wide_tau / grain[3] else 2
            middle = 0.5 * (work.cell[axis] + work.cell[axis + 1])
            for half in range(2):
                copy(work.cell, work.cells[depth])
                work.cells[depth, axis + 1 - half] = middle
                work.spans[depth] = (last, top, 1 if hole else 0)
                depth += 1
    return count


@jit
def _sift(row, length, first, last, grain, view, work):
    """Examine a cell's boxes. Returns the numbers of proved and unproved boxes, and whether the latter is zero.

    The last value is whether a box was skipped because it ends out of view.
    """
    size = int(row[UNKNOWNS]) - 3
    cell, pool, box = work.cell, work.pool, work.box
    top = last
    for k in range(first, last):
        copy(pool[k], pool[top])
        top += 1
    min_width = cell[1] - cell[0] + cell[3] - cell[2]
    is_small = cell[1] - cell[0] <= grain[4] and cell[3] - cell[2] <= grain[5]
    one, rest, cuts = 0, 0, 0
    resolved, hole = True, False
    while top > last:
        top -= 1
        copy(pool[top], box)
        verdict = examine(row, length, cell, box, work.shape)
        while verdict == SHRUNK:
            verdict = examine(row, length, cell, box, work.shape)
        if verdict == DROPPED:
            continue
        if verdict == PROVED:
            tighten(row, length, cell, work.shape.where, work.shape)
            if _is_new(one, size, work):
                if one == MAX_BOXES:
                    resolved = False
                    rest = _keep(box, rest, work)
                    continue
                copy(work.shape.alone, work.alone[one])
                copy(work.shape.where, work.where[one])
                for a in range(INNER):
                    copy(work.shape.slopes[a], work.slopes[one, a])
                one += 1
            continue
        if is_small:
            describe(row, length, cell, box, work.unknown, work.leaf)
            if _is_out(work.leaf, view):
                hole = True
                continue
        axis, width = _widest(box, size)
        if width > min_width and cuts < CUTS and top + 2 < pool.shape[0]:
            middle = 0.5 * (box[2 * axis] + box[2 * axis + 1])
            copy(box, pool[top])
            copy(box, pool[top + 1])
            pool[top, 2 * axis + 1] = pool[top + 1, 2 * axis] = middle
            top, cuts = top + 2, cuts + 1
            continue
        resolved = False
        rest = _keep(box, rest, work)
    return one, rest, resolved, hole


@jit
def _widest(box, size):
    """The widest side of a box by weight, and its weighted width."""
    axis, width = 0, 0.0
    for a in range(size):
        own = (box[2 * a + 1] - box[2 * a]) * (ANGLE_WEIGHT if a == 1 else 1.0)
        if own > width:
            axis, width = a, own
    return axis, width


@jit
def _keep(box, rest, work):
    """Keep an unproved box; where there is no room, merge it with the last one. Returns the number kept."""
    if rest < MAX_BOXES:
        copy(box, work.kept[rest])
        return rest + 1
    for a in range(0, 6, 2):
        work.kept[rest - 1, a] = min(work.kept[rest - 1, a], box[a])
        work.kept[rest - 1, a + 1] = max(work.kept[rest - 1, a + 1], box[a + 1])
    return rest


@jit
def _is_new(one, size, work):
    """Whether the solution just proved differs from those proved before."""
    for k in range(one):
        if _is_in(work.shape.where, work.alone[k], size) or _is_in(work.where[k], work.shape.alone, size):
            return False
    return True


@jit
def _is_in(inner, outer, size):
    """Whether a solution in *inner* is the only one in *outer*; the lever's angle counts modulo a turn."""
    for a in range(size):
        lo, hi = inner[2 * a], inner[2 * a + 1]
        if a == 2:  # not psi: a turn of psi is a turn of cable around the sheave
            away = 0.5 * (lo + hi - outer[2 * a] - outer[2 * a + 1])
            shift = TURN if away < -3.0 else (-TURN if away > 3.0 else 0.0)
            lo, hi = lo + shift - 1e-14, hi + shift + 1e-14
        if not (outer[2 * a] < lo and hi < outer[2 * a + 1]):
            return False
    return True


@jit
def _is_out(leaf, view):
    """Whether the line surely ends out of view."""
    return leaf[X] > view[1] or leaf[X + 1] < view[0] or leaf[Z] > view[3] or leaf[Z + 1] < view[2]


@jit
def _write(row, length, one, rest, resolved, hole, grain, view, leaves, count, work):
    """Write the cell's leaves. Returns the new count, and whether the cell has to be split instead."""
    cell = work.cell
    wide_phi, wide_tau = cell[1] - cell[0], cell[3] - cell[2]
    is_least = wide_phi <= grain[2] and wide_tau <= grain[3]
    other = sheet(row, cell)
    if count + one + rest + 2 > leaves.shape[0]:
        return FULL, False
    if not resolved and not (wide_phi <= grain[0] and wide_tau <= grain[3]):
        return count, True
    backwards = cos((cell[0], cell[1]))[1] <= 0.0
    poor, out = False, resolved
    work.found[0] = work.found[1] = 0
    for k in range(one):
        leaf = leaves[count + k]
        describe(row, length, cell, work.where[k], work.slopes[k], leaf)
        out = out and _is_out(leaf, view)
        if leaf[LABEL] < UNCLEAR:
            work.found[int(leaf[LABEL])] += 1
            poor = poor or (leaf[GOOD] == 0.0 and leaf[H] > 0.0)
    if resolved and (one == 0 or (out and backwards)):
        return _write_hole(cell, float(UNCLEAR) + other, leaves, count), False
    widest = 4 if out else 0
    is_wide = wide_phi > grain[widest] or wide_tau > grain[widest + 1]
    if resolved and (is_wide or (poor and not is_least and not out)):
        return count, True
    for k in range(one):
        leaf = leaves[count]
        if leaf[LABEL] < UNCLEAR and work.found[int(leaf[LABEL])] > 1:
            leaf[LABEL], leaf[GOOD] = float(UNCLEAR), 0.0
        leaf[LABEL] += other
        _centre(row, length, work.where[k], leaf, work)
        count += 1
    for k in range(rest):
        describe(row, length, cell, work.kept[k], work.unknown, leaves[count])
        leaves[count, LABEL], leaves[count, GOOD] = float(UNCLEAR) + other, 0.0
        count += 1
    for label in range(labels_of(row)):
        if work.found[label] == 0 or hole:
            count = _write_hole(cell, float(label) + other, leaves, count)
    return count, False


@jit
def _write_hole(cell, label, leaves, count):
    """Write a leaf without shapes in view, which marks its forces as unproved. Returns the new count."""
    leaf = leaves[count]
    leaf[:] = np.nan
    for k in range(4):
        leaf[k] = cell[k]
    force(exp((cell[2], cell[3])), cos((cell[0], cell[1])), sin((cell[0], cell[1])), leaf)
    leaf[LABEL], leaf[GOOD] = label, 0.0
    return count + 1


@jit
def _centre(row, length, box, leaf, work):
    """Write the end's distance from the exit point in the middle of the cell to *leaf*."""
    cell, middle = work.cell, work.middle
    middle[0] = middle[1] = 0.5 * (cell[0] + cell[1])
    middle[2] = middle[3] = 0.5 * (cell[2] + cell[3])
    copy(box, work.box)
    tighten(row, length, middle, work.box, work.shape)
    describe(row, length, middle, work.box, work.unknown, work.leaf)
    leaf[CENTRE], leaf[CENTRE + 1] = work.leaf[REACH], work.leaf[REACH + 1]


@jit
def _inherit(size, one, rest, last, work):
    """Write the initial boxes of a cell's halves to the pool. Returns their end, FULL if there is no room."""
    if last + one + rest + 4 > work.pool.shape[0]:
        return FULL
    top = last
    for k in range(one):
        copy(work.where[k], work.pool[top])
        for a in range(size):  # margin for the next proof
            more = 0.02 * (work.alone[k, 2 * a + 1] - work.alone[k, 2 * a])
            work.pool[top, 2 * a] = max(work.alone[k, 2 * a], work.where[k, 2 * a] - more)
            work.pool[top, 2 * a + 1] = min(work.alone[k, 2 * a + 1], work.where[k, 2 * a + 1] + more)
        top += 1
    for k in range(rest):
        copy(work.kept[k], work.pool[top])
        top += 1
    return top
