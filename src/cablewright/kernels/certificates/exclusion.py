"""Proof that a box of positions contains no equilibrium of a point load except the known ones.

The leaves of a line, computed before, contain all forces with which it can end in the box. If these cannot sum to the
load, the box is excluded. If all shapes of one label of each line only stiffen over a convex set of forces, two
equilibria with such forces would contradict each other: `docs/theory/exhaustive.md`.
"""

from math import cos as float_cos
from math import pi, sqrt
from math import sin as float_sin
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.certificates.interval import add, cos, div, exp, intersect, mul, point, sin, sub
from cablewright.kernels.dense_systems import copy
from cablewright.kernels.statics.line.line_cell import (
    BEND,
    BY_PHI,
    BY_TAU,
    CELL_PHI,
    CELL_TAU,
    CENTRE,
    FREE_SPAN,
    GOOD,
    LABEL,
    REACH,
    UNCLEAR,
    H,
    V,
    X,
    Z,
)

EXCLUDED, SETTLED, OPEN = 0, 1, 2
AXIS, SHAPES, SOFT, UNSEEN = 1, 2, 4, 8  # bits of the reason why a box is open
SLACK = 1e-9  # far above the rounding of comparisons in plain floats
NEAR = 2e-3  # of a known equilibrium's forces: far above their certified error
KINDS = 3
MAX_DIRECTIONS = 96  # along which forces are summed
SIDES = 16  # of the polygons that enclose forces
NARROW = 0.1  # min cosine of a wedge of directions
COSINES = tuple(float_cos(2.0 * pi * k / SIDES) for k in range(SIDES))
SINES = tuple(float_sin(2.0 * pi * k / SIDES) for k in range(SIDES))
UP, DOWN, BACK = SIDES // 4, 3 * SIDES // 4, SIDES // 2


class Atlases(NamedTuple):
    """The leaves (possible shapes and forces) of all lines of a robot, and its known equilibria."""

    exits: NDArray[np.float64]  # (m, 3) exit points less platform points
    weights: NDArray[np.float64]  # (m,) N/m
    load: NDArray[np.float64]  # (3,) external force and weight, N
    leaves: NDArray[np.float64]  # (L, LEAF), line after line
    offsets: NDArray[np.int64]  # (m + 1,)
    free: NDArray[np.float64]  # (m, 2, 2) min and max free length by label
    tension: NDArray[np.float64]  # (m, 2) tensions at the sheave that the leaves cover
    labels: NDArray[np.int64]  # (K, m) of known equilibria
    known: NDArray[np.float64]  # (K, m, 4): H, vertical force at the end; the end from the exit point, x, y


class PlaceWork(NamedTuple):
    """Working memory of `judge`."""

    peaks: NDArray[np.float64]  # (m, KINDS, MAX_DIRECTIONS): largest component of forces along each direction
    hulls: NDArray[np.float64]  # (m, KINDS, SIDES): polygons of forces at the end, in the line's plane
    present: NDArray[np.int64]  # (m, KINDS)
    wedges: NDArray[np.float64]  # (m, 3): direction of the box from the exit point, min cosine to it
    narrow: NDArray[np.int64]  # (m,): whether the wedge is narrow
    directions: NDArray[np.float64]  # (MAX_DIRECTIONS, 3)
    choice: NDArray[np.int64]  # (m,) current labels
    part: NDArray[np.float64]  # (4,) H and V of the part of a leaf that can reach the box
    wedge: NDArray[np.float64]  # (3,)
    polygon: NDArray[np.float64]  # (SIDES,)


@jit(allocates=True)
def place_work(m):
    """Allocate a `PlaceWork` for *m* lines."""
    return PlaceWork(
        np.zeros((m, KINDS, MAX_DIRECTIONS)),
        np.zeros((m, KINDS, SIDES)),
        np.zeros((m, KINDS), dtype=np.int64),
        np.zeros((m, 3)),
        np.zeros(m, dtype=np.int64),
        np.zeros((MAX_DIRECTIONS, 3)),
        np.zeros(m, dtype=np.int64),
        np.zeros(4),
        np.zeros(3),
        np.zeros(SIDES),
    )


@jit
def judge(box, atlases, work):
    """Decide whether *box* (6,), low and high of x, y and z, can contain an unknown equilibrium.

    Returns EXCLUDED, SETTLED (known equilibria only) or OPEN, and bits with the reasons.
    """
    m = atlases.exits.shape[0]
    count = _directions(box, atlases.exits, work.directions)
    for i in range(m):
        if not _gather(box, i, count, atlases, work):
            return EXCLUDED, 0
        work.choice[i] = 0
    verdict, reason = EXCLUDED, 0
    while True:
        possible = True
        for i in range(m):
            possible = possible and work.present[i, work.choice[i]] != 0
        if possible and not _is_unbalanced(count, atlases.load, work):
            code = _judge_labels(box, atlases, work)
            verdict = max(verdict, SETTLED if code == 0 else OPEN)
            reason |= code
        i = 0
        while i < m:
            work.choice[i] += 1
            if work.choice[i] < KINDS:
                break
            work.choice[i] = 0
            i += 1
        if i == m:
            return verdict, reason


@jit(allocates=True)
def judge_rows(boxes, atlases, codes, reasons, first, last):
    """Apply `judge` to boxes (N, 6); writes codes and reasons (N,)."""
    work = place_work(atlases.exits.shape[0])
    for j in range(first, last):
        codes[j], reasons[j] = judge(boxes[j], atlases, work)


@jit
def _range(a, b):
    """Smallest and largest absolute value between a and b."""
    if a <= 0.0 <= b:
        return 0.0, max(-a, b)
    return min(abs(a), abs(b)), max(abs(a), abs(b))


@jit
def _wedge(box, exit_point, px, py, with_point, out):
    """Write direction from the exit point to the box (and a point), and the min cosine to it; False if too wide."""
    x0, x1 = box[0] - exit_point[0], box[1] - exit_point[0]
    y0, y1 = box[2] - exit_point[1], box[3] - exit_point[1]
    cx, cy = 0.5 * (x0 + x1), 0.5 * (y0 + y1)
    size = sqrt(cx * cx + cy * cy)
    if not size > SLACK:
        return False
    cx, cy = cx / size, cy / size
    if with_point:
        size = sqrt(px * px + py * py)
        cx, cy = cx + px / size, cy + py / size
        size = sqrt(cx * cx + cy * cy)
        if not size > NARROW:
            return False
        cx, cy = cx / size, cy / size
    min_cosine, nearest = 1.0, 1e300
    for k in range(5 if with_point else 4):
        x, y = (x0 if k < 2 else x1), (y0 if k % 2 == 0 else y1)
        if k == 4:
            x, y = px, py
        size = sqrt(x * x + y * y)
        if not size > SLACK:
            return False
        min_cosine, nearest = min(min_cosine, (x * cx + y * cy) / size), min(nearest, size)
    out[0], out[1], out[2] = cx, cy, min_cosine - SLACK - 2.0 * SLACK / nearest
    return min_cosine > NARROW


@jit
def _push(directions, count, x, y, z):
    """Append a direction and its opposite. Returns the new count."""
    size = sqrt(x * x + y * y + z * z)
    if count + 2 > MAX_DIRECTIONS or not size > SLACK:
        return count
    x, y, z = x / size, y / size, z / size
    directions[count] = (-x, -y, -z)
    directions[count + 1] = (x, y, z)
    return count + 2


@jit
def _directions(box, exits, directions):
    """Write the directions along which to sum forces: axes, and normals to one line or two. Returns their number."""
    x, y, z = 0.5 * (box[0] + box[1]), 0.5 * (box[2] + box[3]), 0.5 * (box[4] + box[5])
    count = 0
    for u, v, w in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 1.0, 0.0), (1.0, -1.0, 0.0)):
        count = _push(directions, count, u, v, w)
    for i in range(exits.shape[0]):
        ax, ay, az = x - exits[i, 0], y - exits[i, 1], z - exits[i, 2]
        count = _push(directions, count, -ay, ax, 0.0)
        count = _push(directions, count, ax * az, ay * az, -(ax * ax + ay * ay))
        for j in range(i):
            bx, by, bz = x - exits[j, 0], y - exits[j, 1], z - exits[j, 2]
            count = _push(directions, count, ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx)
    return count


@jit
def _gather(box, i, count, atlases, work):
    """Collect the forces with which line *i* can end in the box, by label; False if it cannot end there."""
    exit_point = atlases.exits[i]
    ax, bx = _range(box[0] - exit_point[0], box[1] - exit_point[0])
    ay, by = _range(box[2] - exit_point[1], box[3] - exit_point[1])
    z0, z1 = box[4] - exit_point[2], box[5] - exit_point[2]
    az, bz = _range(z0, z1)
    z0, z1 = z0 - SLACK, z1 + SLACK
    near, far = sqrt(ax * ax + ay * ay) - SLACK, sqrt(bx * bx + by * by) + SLACK
    nearest, farthest = sqrt(ax * ax + ay * ay + az * az) - SLACK, sqrt(bx * bx + by * by + bz * bz) + SLACK
    work.narrow[i] = 1 if _wedge(box, exit_point, 0.0, 0.0, False, work.wedges[i]) else 0
    work.present[i, :] = 0
    reached = False
    for k in range(atlases.offsets[i], atlases.offsets[i + 1]):
        leaf = atlases.leaves[k]
        if not (leaf[REACH] <= farthest and leaf[REACH + 1] >= nearest):
            continue
        if leaf[X] > far or leaf[X + 1] < near or leaf[Z] > z1 or leaf[Z + 1] < z0:
            continue
        if not _narrowed(leaf, near, far, z0, z1, nearest, farthest, work.part):
            continue
        reached = True
        label = min(int(leaf[LABEL]), UNCLEAR)
        f0 = work.part[2] + atlases.weights[i] * leaf[FREE_SPAN] - SLACK
        f1 = work.part[3] + atlases.weights[i] * leaf[FREE_SPAN + 1] + SLACK
        if work.present[i, label] == 0:
            work.present[i, label] = 1
            work.hulls[i, label, :] = -1e300
            work.peaks[i, label, :count] = -1e300
        _reach_out(work.hulls[i, label], work.part[0], work.part[1], f0, f1)
        _peak(i, label, count, work.part[0], work.part[1], f0, f1, work)
    return reached


@jit
def _narrowed(leaf, x0, x1, z0, z1, nearest, farthest, out):
    """Write H and V of the part of a leaf that can end at these distances and heights. False if none can."""
    phi, tau = (leaf[CELL_PHI], leaf[CELL_PHI + 1]), (leaf[CELL_TAU], leaf[CELL_TAU + 1])
    middle = 0.5 * (phi[0] + phi[1])
    reach = intersect((leaf[REACH], leaf[REACH + 1]), (nearest, farthest))
    if not reach[0] <= reach[1]:
        return False
    # the end's angle is phi plus the bend: sines relative to the middle of phi
    across = div(sub(mul(cos(point(middle)), (z0, z1)), mul(sin(point(middle)), (x0, x1))), reach)
    bend = (leaf[BEND], leaf[BEND + 1])
    if max(abs(across[0]), abs(across[1])) < 0.5 and max(abs(bend[0]), abs(bend[1])) < 0.5 and phi[1] - phi[0] < 0.5:
        phi = intersect(phi, add(point(middle), sub(_arcsine(across), _arcsine(bend))))
        if not phi[0] <= phi[1]:
            return False
    by_tau = (leaf[BY_TAU], leaf[BY_TAU + 1])
    if by_tau[0] > 0.0:
        turned = mul((leaf[BY_PHI], leaf[BY_PHI + 1]), sub(phi, point(middle)))
        change = div(sub(sub(reach, (leaf[CENTRE], leaf[CENTRE + 1])), turned), by_tau)
        tau = intersect(tau, add(point(0.5 * (leaf[CELL_TAU] + leaf[CELL_TAU + 1])), change))
        if not tau[0] <= tau[1]:
            return False
    t = exp(tau)
    out[0], out[1] = mul(t, cos(phi))
    out[2], out[3] = mul(t, sin(phi))
    return True


@jit
def _arcsine(a):
    """Enclose asin for arguments within 0.5 of zero, where it is between a and 1.048 a."""
    return (a[0] if a[0] > 0.0 else a[0] * 1.048, a[1] if a[1] < 0.0 else a[1] * 1.048)


@jit
def _reach_out(polygon, h0, h1, f0, f1):
    """Extend a polygon, given by its support in SIDES directions, to contain a rectangle."""
    for k in range(SIDES):
        c, s = COSINES[k], SINES[k]
        polygon[k] = max(polygon[k], (h1 if c > 0.0 else h0) * c + (f1 if s > 0.0 else f0) * s)


@jit
def _peak(i, label, count, h0, h1, f0, f1, work):
    """Update the largest components of forces along each direction."""
    cx, cy, cosine = work.wedges[i, 0], work.wedges[i, 1], work.wedges[i, 2]
    side = sqrt(max(1.0 - cosine * cosine, 0.0))
    for d in range(count):
        dx, dy, dz = work.directions[d, 0], work.directions[d, 1], work.directions[d, 2]
        if work.narrow[i] != 0:
            along, across = dx * cx + dy * cy, abs(dx * cy - dy * cx) * side + SLACK
            high, low = max(along, along * cosine) + across, min(along, along * cosine) - across
        else:
            high = sqrt(dx * dx + dy * dy) + SLACK
            low = -high
        flat = max(max(h0 * low, h0 * high), max(h1 * low, h1 * high))
        work.peaks[i, label, d] = max(work.peaks[i, label, d], flat + (f1 if dz > 0.0 else f0) * dz)


@jit
def _is_unbalanced(count, load, work):
    """Whether forces of the chosen labels cannot sum to the load: along some direction they do not reach it."""
    for d in range(count):
        required = work.directions[d, 0] * load[0] + work.directions[d, 1] * load[1] + work.directions[d, 2] * load[2]
        total, bulk = 0.0, abs(required)
        for i in range(work.choice.shape[0]):
            peak = work.peaks[i, work.choice[i], d]
            total += peak
            bulk += abs(peak)
        if total < required - SLACK * (1.0 + bulk):
            return True
    return False


@jit
def _judge_labels(box, atlases, work):
    """0 if the chosen labels are proved to have at most a known equilibrium in the box; else the reason bit."""
    m = work.choice.shape[0]
    for i in range(m):
        if work.choice[i] == UNCLEAR:
            return SHAPES
        if work.narrow[i] == 0:
            return AXIS
    seen = False
    for one in range(atlases.labels.shape[0]):
        same = True
        for i in range(m):
            same = same and atlases.labels[one, i] == work.choice[i]
        if same:
            seen = True
            if _only_stiffens(box, one, atlases, work):
                return 0
    if seen or not _only_stiffens(box, -1, atlases, work):
        return SOFT
    return UNSEEN


@jit
def _only_stiffens(box, one, atlases, work):
    """Whether all lines only stiffen over a convex set of the forces into the box and of known equilibrium *one*."""
    polygon = work.polygon
    for i in range(work.choice.shape[0]):
        label = work.choice[i]
        copy(work.hulls[i, label], polygon)
        px, py = 0.0, 0.0
        if one >= 0:
            h, f = atlases.known[one, i, 0], atlases.known[one, i, 1]
            px, py = atlases.known[one, i, 2], atlases.known[one, i, 3]
            more = NEAR * (1.0 + abs(h) + abs(f))
            _reach_out(polygon, h - more, h + more, f - more, f + more)
        if not _wedge(box, atlases.exits[i], px, py, one >= 0, work.wedge):
            return False
        _widen(polygon, work.wedge[2], atlases.weights[i], atlases.free[i, label, 0], atlases.free[i, label, 1])
        if not _is_covered(polygon, i, label, atlases):
            return False
    return True


@jit
def _widen(polygon, cosine, weight, shortest, longest):
    """Convert a polygon of forces at the end to one at the sheave that contains those of all chords of the wedge."""
    low, high = -polygon[DOWN], polygon[UP]
    for k in range(SIDES):
        s = SINES[k]
        if COSINES[k] < -SLACK:  # chords are nearer to the axis than their ends
            polygon[k] = max(polygon[k], cosine * polygon[k] + (1.0 - cosine) * s * (high if s > 0.0 else low))
        polygon[k] += SLACK * (1.0 + abs(polygon[k])) - s * weight * (shortest if s > 0.0 else longest)


@jit
def _is_covered(polygon, i, label, atlases):
    """Whether all shapes of *label* with a force at the sheave in the polygon are proved and only stiffen."""
    if not polygon[BACK] < 0.0:
        return False
    far = max(polygon[UP], polygon[DOWN])
    if polygon[0] * polygon[0] + far * far > atlases.tension[i, 1] * atlases.tension[i, 1]:
        return False
    clear = False
    for k in range(SIDES):
        clear = clear or polygon[k] < -atlases.tension[i, 0]
    if not clear:
        return False
    for k in range(atlases.offsets[i], atlases.offsets[i + 1]):
        leaf = atlases.leaves[k]
        if ((leaf[GOOD] == 0.0 and leaf[LABEL] == label) or leaf[LABEL] == UNCLEAR) and _meets(leaf, polygon):
            return False
    return True


@jit
def _meets(leaf, polygon):
    """Whether some force of a leaf may be in the polygon."""
    for k in range(SIDES):
        c, s = COSINES[k], SINES[k]
        if (leaf[H] if c > 0.0 else leaf[H + 1]) * c + (leaf[V] if s > 0.0 else leaf[V + 1]) * s > polygon[k]:
            return False
    return True
