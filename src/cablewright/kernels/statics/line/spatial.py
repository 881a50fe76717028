"""One line that does not hang in a vertical plane: guide of any axis at the frame, free span, guide on the platform.

Unknowns are the tension vector f where the free span leaves the frame, kept as its direction (PHI above the horizontal,
AZIMUTH) and the logarithm of its size, and the span's unstrained length. Three equations say that the span from the
contact point at the frame ends at the one on the platform, the fourth gives the length, or the pull. Both points follow
from the forces there (`guides`), so that nothing else is unknown. The dead span is straight, with its weight. Steps of
the unknowns are s = df / |f| (3,) and that of the span's length: four numbers.
"""

from math import atan2, cos, exp, log, sin, sqrt
from typing import NamedTuple

import numpy as np
from numba import types
from numba.extending import overload
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import largest_of_column, solve
from cablewright.kernels.layout import (
    ARC_COMPLIANCE,
    AZIMUTH,
    CONTACT,
    COUNTERWEIGHT,
    DEAD,
    DEAD_COMPLIANCE,
    END_RADIUS,
    END_SPRING,
    EXIT_X,
    FREE,
    FREE_COMPLIANCE,
    INSIDE_SHEAVE,
    MEAN_RISE,
    NOT_CONVERGED,
    PARAMETERS,
    PHI,
    RADIUS,
    SPANS,
    TAU,
    UNDER_EXIT,
    WEIGHT,
)
from cablewright.kernels.statics.line.catenary import span
from cablewright.kernels.statics.line.counterweight import hang_counterweight, shape_hung
from cablewright.kernels.statics.line.guides import (
    ARC,
    ARC_BY_FORCE,
    BY_FORCE,
    CONTACT_POINT,
    GUIDE_SIZE,
    SPAN,
    SPAN_BY_FORCE,
    give_way,
    leave_frame,
    leave_platform,
)
from cablewright.kernels.statics.line.sheave import constant_length
from cablewright.kernels.statics.line.upright import LENGTH_TOLERANCE, STALLED, STEPS, shape_span

SIZE = 4  # unknowns of a line
# Columns of the right-hand sides and of the solutions of `solve`.
RESIDUAL, POSE, GIVEN = 0, 1, 7  # by residual; by the pose's coordinates, 1..6; by length or logarithm of the pull
COLUMNS = 8  # of right-hand sides

# What `place_span` writes to a record.
FRAME, PLATFORM = 0, GUIDE_SIZE  # the guides, see `guides`
FORCE = 2 * GUIDE_SIZE  # tension vector at the span's start, along the direction of travel, N
END_FORCE = FORCE + 3  # the same at its end
ARM = END_FORCE + 3  # from the platform's origin to where the span ends, world, m
CHORD = ARM + 3  # of the span, m
GAP = CHORD + 3  # from the span's end to where it should end, m
RECORD = GAP + 3

STRAIGHT_STEPS = 30
STRAIGHT_STEP = 0.5  # largest turn of a straight line's direction in one step
CLOSED = 1e-15  # m per m: a few roundings
ON_AXIS = -1.0  # in place of a length: a sheave has no plane
UNWOUND = 1e-12  # of a sheave's radius: contact below zero that is rounding


class SpatialWork(NamedTuple):
    """Working memory of lines that do not hang in vertical planes.

    A robot that is not general has None in its place: see `Packed`.
    """

    records: NDArray[np.float64]  # (m, RECORD)
    blocks: NDArray[np.float64]  # (m, 4, 4)
    steps: NDArray[np.float64]  # (m, 4, 8): right-hand sides
    change: NDArray[np.float64]  # (n,): of one line's wrench
    parameters: NDArray[np.float64]  # (4, PARAMETERS): one line's steps of the unknowns by its parameters


def spatial_work(general, n, m):
    """Allocate a `SpatialWork` for *m* lines and *n* degrees of freedom.

    None unless the robot is *general*, see `Packed`.
    """
    return None if general is None else _room(n, m)


@overload(spatial_work)
def _spatial_work(general, n, m):  # noqa: ARG001  (an overload has the arguments of its function)
    """As two functions, since one that returned None or not would have the type of both."""
    return _without_room if isinstance(general, types.NoneType) else _with_room


def _without_room(general, n, m):  # noqa: ARG001
    return None


def _with_room(general, n, m):  # noqa: ARG001
    return _room(n, m)


@jit(allocates=True)
def _room(n, m):
    blocks, steps = np.zeros((m, SIZE, SIZE)), np.zeros((m, SIZE, COLUMNS))
    return SpatialWork(np.zeros((m, RECORD)), blocks, steps, np.zeros(n), np.zeros((SIZE, PARAMETERS)))


@jit
def dead_length(row, covered, tension):
    """Return the unstrained length (m) of a straight dead span that covers *covered* metres.

    *tension*: at the sheave, N. Also returns the derivatives by the tension, m/N, and by the length that it covers.
    """
    compliance = row[DEAD_COMPLIANCE]
    bend = 0.5 * compliance * row[WEIGHT] * row[MEAN_RISE]
    linear = 1.0 + compliance * tension
    length = 2.0 * covered / (linear + sqrt(linear * linear + 4.0 * bend * covered))
    per_metre = 1.0 / (linear + 2.0 * bend * length)
    return length, -compliance * length * per_metre, per_metre


@jit
def point_of(row, pose, arm, k):
    """Return coordinate *k* of the vector from the platform point to the frame's guide, m."""
    return row[EXIT_X + k] - pose[k] - arm[k]


@jit
def place_guides(row, pose, arm, rotation, tension, record):
    """Write both guides of a line for the forces in *record*. False where a sheave has no plane.

    The mount of the frame's guide deflects under the force there or, above 0 N, under the *tension* in its direction.
    """
    away = (-point_of(row, pose, arm, 0), -point_of(row, pose, arm, 1), -point_of(row, pose, arm, 2))
    gx, gy, gz = record[END_FORCE], record[END_FORCE + 1], record[END_FORCE + 2]
    found = leave_platform(row, rotation, gx, gy, gz, away, record, PLATFORM)
    at = PLATFORM + CONTACT_POINT
    away = (away[0] + record[at], away[1] + record[at + 1], away[2] + record[at + 2])
    fx, fy, fz = record[FORCE], record[FORCE + 1], record[FORCE + 2]
    if not (leave_frame(row, fx, fy, fz, away, record, FRAME) and found):
        return False
    give_way(row, fx, fy, fz, tension, record, FRAME)
    return True


@jit
def place_span(row, y, pose, arm, rotation, record, block):
    """Write forces, guides, chord and closing error of the line at *y* to *record*; contact and dead length to *y*.

    *block* (4, 4) receives the closing error's derivative by the unknowns in its first three rows. False where a sheave
    has no plane.
    """
    t, c, s = exp(y[TAU]), cos(y[PHI]), sin(y[PHI])
    ex, ey = cos(y[AZIMUTH]), sin(y[AZIMUTH])
    h, v = t * c, t * s
    x, z, hh, hv, vv, xl, zl, v1 = span(h, v, y[FREE], row[WEIGHT], row[FREE_COMPLIANCE])
    across = x / h if abs(h) > 1e-200 else hh
    record[FORCE], record[FORCE + 1], record[FORCE + 2] = h * ex, h * ey, v
    record[END_FORCE], record[END_FORCE + 1], record[END_FORCE + 2] = h * ex, h * ey, v1
    record[CHORD], record[CHORD + 1], record[CHORD + 2] = x * ex, x * ey, z
    if not place_guides(row, pose, arm, rotation, 0.0, record):
        return False
    y[CONTACT] = record[FRAME + ARC] + record[PLATFORM + ARC]
    y[DEAD], _, _ = dead_length(row, record[FRAME + SPAN], t)
    block[0, 0], block[1, 1] = ex * ex * hh + ey * ey * across, ey * ey * hh + ex * ex * across
    block[0, 1] = block[1, 0] = ex * ey * (hh - across)
    block[0, 2] = block[2, 0] = ex * hv
    block[1, 2] = block[2, 1] = ey * hv
    block[2, 2] = vv
    block[0, 3], block[1, 3], block[2, 3] = ex * xl, ey * xl, zl
    for i in range(3):
        record[ARM + i] = arm[i] + record[PLATFORM + CONTACT_POINT + i]
        reached = record[FRAME + CONTACT_POINT + i] + record[CHORD + i] - record[PLATFORM + CONTACT_POINT + i]
        record[GAP + i] = point_of(row, pose, arm, i) + reached
        for j in range(3):
            moved = record[FRAME + BY_FORCE + 3 * i + j] - record[PLATFORM + BY_FORCE + 3 * i + j]
            block[i, j] = t * (block[i, j] + moved)
        block[i, 3] -= record[PLATFORM + BY_FORCE + 3 * i + 2] * row[WEIGHT]
    return True


@jit
def spatial_system(row, y, pose, arm, rotation, length, record, block, rhs):
    """Write the four equations for *length* (m), as `line.system`: block (4, 4) and right-hand sides (4, 8).

    Solved, column k of *rhs* is the step to take off the unknowns for the residual (0), and their derivatives by the
    pose (1..6) and the length (7). False where a sheave has no plane.
    """
    if not place_span(row, y, pose, arm, rotation, record, block):
        return False
    t, n = exp(y[TAU]), pose.shape[0]
    taken = 1.0 / (1.0 + t * row[ARC_COMPLIANCE])
    _, by_tension, per_metre = dead_length(row, record[FRAME + SPAN], t)
    for i in range(3):
        rhs[i, RESIDUAL] = record[GAP + i]
        rhs[i, GIVEN] = 0.0
    rhs[3, GIVEN] = 1.0
    if row[COUNTERWEIGHT] > 0.0:
        hang_counterweight(row, y, record, by_tension, per_metre, block, rhs)
        by_pose(n, record, 0.0, rhs)
        return True
    by_tension -= y[CONTACT] * taken * taken * row[ARC_COMPLIANCE] + row[END_SPRING]
    for j in range(3):
        arcs = record[FRAME + ARC_BY_FORCE + j] + record[PLATFORM + ARC_BY_FORCE + j]
        spans = per_metre * record[FRAME + SPAN_BY_FORCE + j]
        block[3, j] = t * (arcs * taken + spans) + record[FORCE + j] * by_tension
    block[3, 3] = row[SPANS] + record[PLATFORM + ARC_BY_FORCE + 2] * row[WEIGHT] * taken
    spans = row[SPANS] * y[FREE] + y[DEAD] + y[CONTACT] * taken
    rhs[3, RESIDUAL] = spans + constant_length(row) - t * row[END_SPRING] - length
    by_pose(n, record, taken, rhs)
    return True


@jit
def by_pose(n, record, taken, rhs):
    """Write the right-hand sides for the pose's *n* degrees of freedom: derivatives of the line's equations.

    *taken*: unstrained per contact length, 0 at a pull.
    """
    for k in range(3):
        for i in range(4):
            rhs[i, POSE + k] = 1.0 if i == k else 0.0
    if n < 6:
        return
    for k in range(3):
        ex, ey, ez = turn_of(k, record[END_FORCE], record[END_FORCE + 1], record[END_FORCE + 2])
        moved = turn_of(k, record[ARM], record[ARM + 1], record[ARM + 2])
        for i in range(3):
            at = PLATFORM + BY_FORCE + 3 * i
            rhs[i, POSE + 3 + k] = moved[i] - record[at] * ex - record[at + 1] * ey - record[at + 2] * ez
        at = PLATFORM + ARC_BY_FORCE
        rhs[3, POSE + 3 + k] = taken * (record[at] * ex + record[at + 1] * ey + record[at + 2] * ez)


@jit
def turn_of(k, x, y, z):
    """Return the change of the vector (x, y, z) per rotation about world axis *k*."""
    if k == 0:
        return 0.0, -z, y
    if k == 1:
        return z, 0.0, -x
    return -y, x, 0.0


@jit
def spatial_at_pull(row, y, pose, arm, rotation, pull, record, block, rhs):
    """Write the equations of `spatial_system` with the pull (N) given instead of the length; column 7: its logarithm.

    The pull is the mid-length force along the span's chord, see `line.pull_of`.
    """
    if not place_span(row, y, pose, arm, rotation, record, block):
        return False
    t, weight = exp(y[TAU]), row[WEIGHT]
    found, chord = pull_along(row, y, record)
    for j in range(4):
        slope = 0.0
        for i in range(3):
            toward = record[CHORD + i] / chord
            middle = record[FORCE + i] + (0.5 * weight * y[FREE] if i == 2 else 0.0)
            across = (middle - found * toward) / chord  # the chord turns as its ends move
            if j < 3:
                moved = record[FRAME + BY_FORCE + 3 * i + j] - record[PLATFORM + BY_FORCE + 3 * i + j]
                slope += across * (block[i, j] - t * moved)
                slope += t * toward if i == j else 0.0
            else:
                slope += across * (block[i, 3] + record[PLATFORM + BY_FORCE + 3 * i + 2] * weight)
                slope += 0.5 * weight * toward if i == 2 else 0.0
        block[3, j] = slope / pull
    for i in range(3):
        rhs[i, RESIDUAL] = record[GAP + i]
        rhs[i, GIVEN] = 0.0
    rhs[3, RESIDUAL] = found / pull - 1.0
    rhs[3, GIVEN] = 1.0
    by_pose(pose.shape[0], record, 0.0, rhs)
    return True


@jit
def pull_along(row, y, record):
    """Return the pull of a placed span (N) and the length of its chord, m."""
    along, square = 0.0, 0.0
    for i in range(3):
        middle = record[FORCE + i] + (0.5 * row[WEIGHT] * y[FREE] if i == 2 else 0.0)
        along += middle * record[CHORD + i]
        square += record[CHORD + i] ** 2
    chord = sqrt(square)
    return along / chord, chord


@jit
def advance_spatial(y, rhs, column, scale):
    """Add minus *scale* times a column of *rhs* to the unknowns, shortened where one would change too much.

    True if it is not shortened.
    """
    c, s = cos(y[PHI]), sin(y[PHI])
    fx, fy, fz = c * cos(y[AZIMUTH]), c * sin(y[AZIMUTH]), s
    sx, sy, sz, longer = rhs[0, column], rhs[1, column], rhs[2, column], rhs[3, column]
    grow = fx * sx + fy * sy + fz * sz
    sx, sy, sz = sx - grow * fx, sy - grow * fy, sz - grow * fz
    turn = sqrt(sx * sx + sy * sy + sz * sz)
    held = scale
    if turn * abs(held) > 0.5:
        held = 0.5 / turn if held > 0.0 else -0.5 / turn
    if abs(grow * held) > 1.5:
        held *= 1.5 / abs(grow * held)
    allowed = 0.7 * y[FREE] if longer * held > 0.0 else 0.7 * y[FREE] + 0.5
    if abs(longer * held) > allowed:
        held *= allowed / abs(longer * held)
    fx, fy, fz = fx - held * sx, fy - held * sy, fz - held * sz
    y[PHI], y[AZIMUTH] = atan2(fz, sqrt(fx * fx + fy * fy)), atan2(fy, fx)
    y[TAU] -= held * grow
    y[FREE] -= held * longer
    return held == scale


@jit
def settle_spatial(row, y, pose, arm, rotation, length, record, block, rhs):
    """Solve the line at a fixed pose for its *length* (m) from the guess in *y*. True if it converges."""
    scale = LENGTH_TOLERANCE * (1.0 + _size(row, pose, arm) + length)
    for _ in range(STEPS):
        if not spatial_system(row, y, pose, arm, rotation, length, record, block, rhs):
            return False
        if largest_of_column(rhs, SIZE) < scale:
            return True
        if not solve(block, rhs, SIZE, 1):
            return False
        stalled = largest_of_column(rhs, SIZE) < STALLED
        advance_spatial(y, rhs, RESIDUAL, 1.0)
        if stalled:
            return True
    return False


@jit
def settle_spatial_at_pull(row, y, pose, arm, rotation, pull, record, block, rhs):
    """Solve the line at a fixed pose for its *pull* (N) from *y*; *rhs* is then solved. True if it converges."""
    scale = LENGTH_TOLERANCE * (1.0 + _size(row, pose, arm))
    for _ in range(STEPS):
        if not spatial_at_pull(row, y, pose, arm, rotation, pull, record, block, rhs):
            return False
        done = largest_of_column(rhs, SIZE) < scale
        if not solve(block, rhs, SIZE, COLUMNS):
            return False
        if done:
            return True
        done = largest_of_column(rhs, SIZE) < STALLED
        advance_spatial(y, rhs, RESIDUAL, 1.0)
        if done:
            return spatial_at_pull(row, y, pose, arm, rotation, pull, record, block, rhs) and solve(
                block, rhs, SIZE, COLUMNS
            )
    return False


@jit
def _size(row, pose, arm):
    """Distance of the platform point from the frame's guide along the three axes together, m."""
    return abs(point_of(row, pose, arm, 0)) + abs(point_of(row, pose, arm, 1)) + abs(point_of(row, pose, arm, 2))


@jit
def straight_spatial(row, y, pose, arm, rotation, tension, record, block, rhs):
    """Set *y* to the straight massless line at *tension* (N), with strained lengths, as `sheave.straight`.

    False where no straight line joins the guides: the platform point is inside a sheave, or on its axis.
    """
    size = _size(row, pose, arm)
    ex, ey, ez = -point_of(row, pose, arm, 0), -point_of(row, pose, arm, 1), -point_of(row, pose, arm, 2)
    x = sqrt(ex * ex + ey * ey + ez * ez)
    y[FREE] = 0.0
    if not x > 0.0:
        return False
    ex, ey, ez = ex / x, ey / x, ez / x
    closed = False
    for _ in range(STRAIGHT_STEPS):
        record[FORCE], record[FORCE + 1], record[FORCE + 2] = ex, ey, ez
        record[END_FORCE], record[END_FORCE + 1], record[END_FORCE + 2] = ex, ey, ez
        y[PHI], y[AZIMUTH] = atan2(ez, sqrt(ex * ex + ey * ey)), atan2(ey, ex)
        if not place_guides(row, pose, arm, rotation, tension, record):
            y[FREE] = ON_AXIS
            return False
        toward, gap = (ex, ey, ez), 0.0
        for i in range(3):
            reached = record[FRAME + CONTACT_POINT + i] - record[PLATFORM + CONTACT_POINT + i] + x * toward[i]
            rhs[i, 0] = point_of(row, pose, arm, i) + reached
            gap = max(gap, abs(rhs[i, 0]))
            for j in range(3):
                moved = record[FRAME + BY_FORCE + 3 * i + j] - record[PLATFORM + BY_FORCE + 3 * i + j]
                block[i, j] = moved + (1.0 - x) * toward[i] * toward[j] + (x if i == j else 0.0)
        if closed or gap <= CLOSED * size:
            closed = True
            break
        if not solve(block, rhs, 3, 1):
            return False
        longer = rhs[0, 0] * ex + rhs[1, 0] * ey + rhs[2, 0] * ez
        turns = (rhs[0, 0] - longer * ex, rhs[1, 0] - longer * ey, rhs[2, 0] - longer * ez)
        turn = sqrt(turns[0] ** 2 + turns[1] ** 2 + turns[2] ** 2)
        held = min(1.0, STRAIGHT_STEP / max(turn, 1e-300))
        ex, ey, ez = ex - held * turns[0], ey - held * turns[1], ez - held * turns[2]
        unit = sqrt(ex * ex + ey * ey + ez * ez)
        ex, ey, ez = ex / unit, ey / unit, ez / unit
        x -= held * longer
        closed = turn < STALLED and abs(longer) < STALLED * size
    y[TAU] = log(tension)
    y[FREE], y[DEAD] = x, record[FRAME + SPAN]
    y[CONTACT] = record[FRAME + ARC] + record[PLATFORM + ARC]
    for i in range(3):
        record[ARM + i] = arm[i] + record[PLATFORM + CONTACT_POINT + i]
    return closed and x > 0.0


@jit
def why_not_straight(row, y, pose, arm):
    """Return the code that explains why `straight_spatial` found no straight line."""
    if y[FREE] == ON_AXIS:
        return UNDER_EXIT
    return INSIDE_SHEAVE if _size(row, pose, arm) < 4.0 * (row[RADIUS] + row[END_RADIUS]) else NOT_CONVERGED


@jit
def straight_length(row, y):
    """Length (m) of the straight line that `straight_spatial` wrote to *y*."""
    return row[SPANS] * y[FREE] + y[DEAD] + y[CONTACT] + constant_length(row)


@jit
def guess_spatial(row, y, pose, arm, rotation, length, tension, record, block, rhs):
    """Set *y* close to the line of unstrained *length*, taut or slack, as `line.guess`. False inside a sheave."""
    if not straight_spatial(row, y, pose, arm, rotation, tension, record, block, rhs):
        return False
    chord = y[FREE]
    if row[COUNTERWEIGHT] > 0.0:
        shape_hung(row, y)
    else:
        free = max((length - straight_length(row, y)) / row[SPANS] + chord, 0.05 * chord)
        shape_span(row, chord, free, tension, y)
    y[DEAD], _, _ = dead_length(row, record[FRAME + SPAN], exp(y[TAU]))
    return True


@jit
def is_unwound(row, i, spatial):
    """Return whether the cable of line *i* would leave a sheave before it meets it: an angle of contact is negative."""
    at_frame = spatial.records[i, FRAME + ARC] < -UNWOUND * row[RADIUS]
    return at_frame or spatial.records[i, PLATFORM + ARC] < -UNWOUND * row[END_RADIUS]
