"""Signed distances of the lines of solved poses from each other, the platform, the frame and a part."""

from math import cos, exp, sin, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.collision.distance import (
    clipped,
    depth_in_box,
    segment_box,
    segment_disc,
    segment_polygon,
    segment_segment,
    vector,
)
from cablewright.kernels.collision.polyline_of_line import MAX_POINTS, polyline
from cablewright.kernels.dense_systems import copy_rows
from cablewright.kernels.layout import END_RADIUS, EXIT_X, FREE, PHI, STATE, TAU, WEIGHT
from cablewright.kernels.rotation import rotate_back
from cablewright.kernels.statics.line.guides import GUIDE_SIZE, wheel_on_platform
from cablewright.kernels.statics.line.solved_line import shape_line
from cablewright.kernels.statics.line.vertical_plane import place
from cablewright.kernels.statics.platform import place_platform

LINE, BODY, FRAME, PART = 0, 1, 2, 3  # kinds of obstacles, in the order of the results
KINDS = 4
SHARED_EXIT, SHARED_POINT = 1, 2
BEADS, TRIANGLES = 0, 1
PIECE = 12  # numbers of a piece of a solid
STACK = 64


class PartTree(NamedTuple):
    """A part as beads or triangles in a complete binary tree of boxes: node k has the children 2 k + 1 and 2 k + 2.

    A bead is a box: centre, unit vectors along two of its sides, its three half sides. A triangle is its corners. A
    piece exists from its entry of `births` on, in the same quantity as the queries' `now`. For triangles that is the
    height of the lowest corner, and a triangle exists up to the height `now`.
    """

    kind: int
    pieces: NDArray[np.float64]  # (P, PIECE)
    births: NDArray[np.float64]  # (P,)
    boxes: NDArray[np.float64]  # (2 L - 1, 6): centre and half sides; L leaves
    since: NDArray[np.float64]  # (2 L - 1,): the earliest birth within
    ranges: NDArray[np.int64]  # (L + 1,): the first piece of each leaf


class Surroundings(NamedTuple):
    """Obstacles of the lines except each other and the part: boxes of the platform, beams and sheaves."""

    radii: NDArray[np.float64]  # (m,) m, of the cables
    shared: NDArray[np.int64]  # (m, m): SHARED_EXIT, SHARED_POINT or their sum
    beams: NDArray[np.float64]  # (B, 2, 3) m, world
    beam_radii: NDArray[np.float64]  # (B,)
    bodies: NDArray[np.float64]  # (Q, 6) m, platform frame: centre and half sides of boxes
    ends: float  # m of cable at either end that are not compared with the obstacle they end on
    tolerance: float  # m, largest distance of a chord from its line


class Clearing(NamedTuple):
    """Working memory of one thread of `clearance_rows`."""

    points: NDArray[np.float64]  # (m, MAX_POINTS, 3): lines as polylines
    counts: NDArray[np.int64]  # (m,)
    cuts: NDArray[np.int64]  # (m, 2)
    bounds: NDArray[np.float64]  # (m,)
    rotation: NDArray[np.float64]  # (3, 3)
    arm: NDArray[np.float64]  # (3,)
    plane: NDArray[np.float64]  # (4,)
    origin: NDArray[np.float64]  # (3,)
    guide: NDArray[np.float64]  # (GUIDE_SIZE,)
    wheels: NDArray[np.float64]  # (m, 7): sheaves on the platform as discs, world: see `segment_disc`; radius 0: none
    hints: NDArray[np.int64]  # (m,): the piece of the part last nearest to each line, -1 for none
    stack: NDArray[np.int64]  # (STACK,): nodes of the tree to visit
    squares: NDArray[np.float64]  # (STACK,): their squared distances
    polygon: NDArray[np.float64]  # (5, 3)


@jit(allocates=True)
def clearing_scratch(m):
    """Allocate a `Clearing` for *m* lines."""
    return Clearing(
        np.zeros((m, MAX_POINTS, 3)),
        np.zeros(m, np.int64),
        np.zeros((m, 2), np.int64),
        np.zeros(m),
        np.eye(3),
        np.zeros(3),
        np.zeros(4),
        np.zeros(3),
        np.zeros(GUIDE_SIZE),
        np.zeros((m, 7)),
        np.full(m, -1),
        np.zeros(STACK, np.int64),
        np.zeros(STACK),
        np.zeros((5, 3)),
    )


@jit(allocates=True)
def clearance_rows(packed, poses, states, around, solid, now, skip_part, margins, pairs, places, bounds, first, last):
    """Smallest distance of the lines from each kind of obstacle at each pose.

    *solid* is the part, taken at *now* (N,); *skip_part*: the part is not compared with the `ends` of the lines at the
    platform. Writes margins (N, KINDS), m: less the radii, inf where there is no obstacle of a kind, NaN where a row is
    not solved; pairs (N, KINDS, 2), the line and the index of the nearest obstacle; places (N, KINDS, 3), the nearest
    point on the line's axis, world; bounds (N,), a bound of the distance between any line and its polyline, m. After
    the platform's boxes come the sheaves on it, by line, and after the beams again these, nearest to a line's sheave.
    """
    m = packed.lines.shape[1]
    work = clearing_scratch(m)
    for j in range(first, last):
        lines = packed.lines[j if packed.lines.shape[0] > 1 else 0]
        margins[j], bounds[j], pairs[j], places[j] = np.inf, 0.0, -1, np.nan
        if not _drawn(lines, poses[j], states[j], around, work):
            margins[j], bounds[j] = np.nan, np.nan
            continue
        for i in range(m):
            bounds[j] = max(bounds[j], work.bounds[i])
        _among_lines(around, work, margins[j], pairs[j], places[j])
        for i in range(m):
            if around.bodies.shape[0] > 0:
                _from_bodies(i, poses[j], around, work, margins[j], pairs[j], places[j])
            if around.beams.shape[0] > 0:
                _from_beams(i, around, work, margins[j], pairs[j], places[j])
            if work.wheels[i, 6] > 0.0:
                _from_wheel(i, around, work, margins[j], pairs[j], places[j])
            if solid.pieces.shape[0] > 0:
                _from_part(i, around.radii[i], solid, now[j], skip_part, work, margins[j], pairs[j], places[j])


@jit(allocates=True)
def drawn_lines(packed, poses, states, around, points, counts):
    """Write the polylines of the lines of the first row: points (m, MAX_POINTS, 3), world, and their counts (m,)."""
    work = clearing_scratch(packed.lines.shape[1])
    counts[:] = 0
    if _drawn(packed.lines[0], poses[0], states[0], around, work):
        for i in range(counts.shape[0]):
            copy_rows(work.points[i], points[i])
            counts[i] = work.counts[i]


@jit
def _drawn(lines, pose, states, around, work):
    """Draw all lines as polylines; False where a number is not finite."""
    place_platform(pose, work.rotation)
    for i in range(lines.shape[0]):
        for k in range(STATE):
            if not np.isfinite(states[i, k]):
                return False
        place(lines, i, pose, work.rotation, work.arm, work.plane)
        x, y, z = work.arm[0] + pose[0], work.arm[1] + pose[1], work.arm[2] + pose[2]
        begin = shape_line(lines[i], states[i], work.guide, work.origin, work.plane)
        drawing = work.origin, work.plane, around.ends, around.tolerance, work.points[i], work.cuts[i]
        work.counts[i], work.bounds[i] = polyline(lines[i], states[i], begin, *drawing)
        work.wheels[i, 6] = 0.0
        if lines[i, END_RADIUS] > 0.0:
            tension = exp(states[i, TAU])
            h, v = tension * cos(states[i, PHI]), tension * sin(states[i, PHI])
            end = (work.plane[0] * h, work.plane[1] * h, v + lines[i, WEIGHT] * states[i, FREE])
            away = (x - lines[i, EXIT_X], y - lines[i, EXIT_X + 1], z - lines[i, EXIT_X + 2])
            wheel_on_platform(lines[i], work.rotation, end, away, work.wheels[i])
            work.wheels[i, 0] += x
            work.wheels[i, 1] += y
            work.wheels[i, 2] += z
    return True


@jit
def _keep(margin, kind, i, other, points, k, s, margins, pairs, places):
    """Store the nearest obstacle so far: *other*, at fraction *s* of segment *k* of line *i*."""
    margins[kind] = margin
    pairs[kind, 0], pairs[kind, 1] = i, other
    for axis in range(3):
        places[kind, axis] = points[k, axis] + s * (points[k + 1, axis] - points[k, axis])


@jit
def _apart(a, k, b, j, reach):
    """Whether the circumscribed balls of two segments are farther apart than *reach*."""
    x = y = mid = 0.0
    for axis in range(3):
        u, v = a[k + 1, axis] - a[k, axis], b[j + 1, axis] - b[j, axis]
        between = a[k, axis] + 0.5 * u - b[j, axis] - 0.5 * v
        x += u * u
        y += v * v
        mid += between * between
    far = reach + 0.5 * (sqrt(x) + sqrt(y))
    return far > 0.0 and mid > far * far


@jit
def _among_lines(around, work, margins, pairs, places):
    """Compare each line with each other, except near a shared end."""
    m = work.counts.shape[0]
    for i in range(m):
        for other in range(i + 1, m):
            shared = around.shared[i, other]
            a, b = work.points[i], work.points[other]
            radii = around.radii[i] + around.radii[other]
            exits = shared & SHARED_EXIT
            points = shared & SHARED_POINT
            low, low2 = (work.cuts[i, 0], work.cuts[other, 0]) if exits else (0, 0)
            high = work.cuts[i, 1] if points else work.counts[i] - 1
            high2 = work.cuts[other, 1] if points else work.counts[other] - 1
            for k in range(low, high):
                for j in range(low2, high2):
                    if _apart(a, k, b, j, margins[LINE] + radii):
                        continue
                    square, s, _ = segment_segment(a, k, b, j)
                    margin = sqrt(square) - radii
                    if margin < margins[LINE]:
                        _keep(margin, LINE, i, other, a, k, s, margins, pairs, places)


@jit
def _from_bodies(i, pose, around, work, margins, pairs, places):
    """Compare line *i* with the platform's boxes, except near its end at the platform."""
    R, points = work.rotation, work.points[i]
    for k in range(work.cuts[i, 1]):
        px, py, pz = points[k, 0] - pose[0], points[k, 1] - pose[1], points[k, 2] - pose[2]
        ux, uy, uz = vector(points, k, points, k + 1)
        px, py, pz = rotate_back(R, px, py, pz)
        ux, uy, uz = rotate_back(R, ux, uy, uz)
        for box in range(around.bodies.shape[0]):
            own = around.bodies[box]
            x, y, z = px - own[0], py - own[1], pz - own[2]
            distance, s = _signed(x, y, z, ux, uy, uz, own[3], own[4], own[5])
            margin = distance - around.radii[i]
            if margin < margins[BODY]:
                _keep(margin, BODY, i, box, points, k, s, margins, pairs, places)


@jit
def _signed(x, y, z, ux, uy, uz, hx, hy, hz):
    """Signed distance of a segment from a box about zero, and its fraction."""
    square, s = segment_box(x, y, z, ux, uy, uz, hx, hy, hz)
    if square > 0.0:
        return sqrt(square), s
    return depth_in_box(x, y, z, ux, uy, uz, hx, hy, hz, s)


@jit
def _from_beams(i, around, work, margins, pairs, places):
    """Compare line *i* with the frame's beams, except near its end at the exit."""
    points = work.points[i]
    for beam in range(around.beams.shape[0]):
        radii = around.radii[i] + around.beam_radii[beam]
        for k in range(work.cuts[i, 0], work.counts[i] - 1):
            square, s, _ = segment_segment(points, k, around.beams[beam], 0)
            margin = sqrt(square) - radii
            if margin < margins[FRAME]:
                _keep(margin, FRAME, i, beam, points, k, s, margins, pairs, places)


@jit
def _from_wheel(i, around, work, margins, pairs, places):
    """Compare the sheave of line *i* on the platform, as thick as its cable, with the other lines and the beams.

    A line that shares its platform point is compared without its end there.
    """
    wheel, beams = work.wheels[i], around.beams.shape[0]
    for other in range(work.counts.shape[0]):
        if other == i:
            continue
        last = work.cuts[other, 1] if around.shared[i, other] & SHARED_POINT else work.counts[other] - 1
        for k in range(last):
            square, s = segment_disc(work.points[other], k, wheel)
            margin = sqrt(square) - around.radii[i] - around.radii[other]
            if margin < margins[BODY]:
                at = around.bodies.shape[0] + i
                _keep(margin, BODY, other, at, work.points[other], k, s, margins, pairs, places)
    for beam in range(beams):
        square, s = segment_disc(around.beams[beam], 0, wheel)
        margin = sqrt(square) - around.radii[i] - around.beam_radii[beam]
        if margin < margins[FRAME]:
            _keep(margin, FRAME, i, beams + beam, around.beams[beam], 0, s, margins, pairs, places)


@jit
def _from_part(i, radius, solid, now, skip, work, margins, pairs, places):
    """Compare line *i* with the part at *now*, from the platform upwards since the nearest piece is mostly there.

    The nearest piece of the row before is tried first: neighbouring rows are mostly neighbours in space.
    """
    last = work.cuts[i, 1] if skip else work.counts[i] - 1
    points, piece = work.points[i], work.hints[i]
    here = np.inf
    if piece >= 0 and solid.births[piece] <= now:
        for k in range(last):
            distance, s = _from_piece(solid, piece, now, points, k, work.polygon)
            here = min(here, distance)
            if distance - radius < margins[PART]:
                _keep(distance - radius, PART, i, piece, points, k, s, margins, pairs, places)
    best = min(margins[PART] + radius, here)
    for down in range(last):
        k = last - 1 - down
        distance, s, found = nearest(solid, now, points, k, best, work)
        if found >= 0:
            best, piece = distance, found
            _keep(best - radius, PART, i, piece, points, k, s, margins, pairs, places)
    work.hints[i] = piece


@jit
def nearest(solid, now, points, k, best, work):
    """Return the signed distance of segment *k* of *points* from the nearest piece of a part at *now*.

    Only pieces nearer than *best* are searched. Returns distance, fraction and index of the piece, -1 if there is none.
    For triangles the distance is 0 where the segment passes through one.
    """
    stack, squares = work.stack, work.squares
    leaves = solid.ranges.shape[0] - 1
    at, found, top = 0.0, -1, 0
    if solid.since[0] <= now:
        stack[0], squares[0] = 0, _square(solid.boxes, 0, points, k)
        top = 1
    while top > 0:
        top -= 1
        node = stack[top]
        if squares[top] > 0.0 and squares[top] >= max(best, 0.0) ** 2:
            continue
        if node < leaves - 1:
            near, far = 2 * node + 1, 2 * node + 2
            square, other = _square(solid.boxes, near, points, k), _square(solid.boxes, far, points, k)
            if other < square:
                near, far, square, other = far, near, other, square
            if solid.since[far] <= now:
                stack[top], squares[top] = far, other
                top += 1
            if solid.since[near] <= now:
                stack[top], squares[top] = near, square
                top += 1
            continue
        leaf = node - (leaves - 1)
        for piece in range(solid.ranges[leaf], solid.ranges[leaf + 1]):
            if solid.births[piece] <= now:
                distance, s = _from_piece(solid, piece, now, points, k, work.polygon)
                if distance < best:
                    best, at, found = distance, s, piece
    return best, at, found


@jit
def _square(boxes, node, points, k):
    """Squared distance of segment *k* from a node's box."""
    px, py, pz = vector(boxes, node, points, k)
    ux, uy, uz = vector(points, k, points, k + 1)
    square, _ = segment_box(px, py, pz, ux, uy, uz, boxes[node, 3], boxes[node, 4], boxes[node, 5])
    return square


@jit
def _from_piece(solid, piece, now, points, k, polygon):
    """Signed distance of segment *k* from one piece at *now*, and its fraction."""
    if solid.kind == TRIANGLES:
        count = clipped(solid.pieces[piece], now, polygon)
        square, s = segment_polygon(points, k, polygon, count)
        return sqrt(square), s
    row = solid.pieces[piece]
    x, y, z = vector(solid.pieces, piece, points, k)
    ux, uy, uz = vector(points, k, points, k + 1)
    ax, ay, az, bx, by, bz = row[3], row[4], row[5], row[6], row[7], row[8]
    cx, cy, cz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    return _signed(
        ax * x + ay * y + az * z,
        bx * x + by * y + bz * z,
        cx * x + cy * y + cz * z,
        ax * ux + ay * uy + az * uz,
        bx * ux + by * uy + bz * uz,
        cx * ux + cy * uy + cz * uz,
        row[9],
        row[10],
        row[11],
    )
