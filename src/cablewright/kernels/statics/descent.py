"""Forward solves far from the solution: the platform descends its potential, with each line solved at every trial.

For a point load on eyelet lines the potential is convex (docs/theory/statics.md), so the descent converges from
anywhere; for other robots it is a robust local minimisation. Line laws: SPRING, a massless unilateral spring of the
line's stiffness, cheap and good for a first guess; EXACT, the line itself.
"""

from math import sqrt

from cablewright.kernels import jit
from cablewright.kernels.certificates.exclusion import SETTLED
from cablewright.kernels.dense_systems import copy, largest, largest_of_column, solve
from cablewright.kernels.layout import COUNTERWEIGHT, END_SPRING, EXIT_X, FREE_COMPLIANCE, SPANS
from cablewright.kernels.statics.line.interface import condense_line, reach_of_line, settle_line, spring_line
from cablewright.kernels.statics.line.upright import FAILED
from cablewright.kernels.statics.line.vertical_plane import AXIS_DISTANCE, add_line, place
from cablewright.kernels.statics.platform import (
    POSE_STEP,
    hold,
    into_plane,
    keep_free_columns,
    load_scale,
    move_platform,
    place_platform,
    start_balance,
)

SPRING, EXACT = 0, 1
DESCENT_STEPS = 200
LINE_SEARCH_STEPS = 30
FORCE_TOLERANCE = 1e-11  # of the load
STALLED_FORCE = 1e-7  # of the load: residual accepted where rounding limits the balance
STALLED = 1e-13  # m, rad
STRIDE = 0.01  # of the longest line: largest step, if it is over `POSE_STEP`
GRAIN = 4e-16  # of a coordinate or length: its last digit
SPRING_TOLERANCE = 1e-2
BESIDE = 0.05  # of the first guess's depth: how much deeper it is where a line begins
SPRING_TENSION = 100.0  # N: at which levers are placed in the first guess


@jit
def descend(packed, lengths, pose, states, work, law, tolerance, n):
    """Move *pose* downhill until the unbalanced wrench is below *tolerance* times the load. True if it converges.

    Only the first *n* degrees of freedom move: 3 keep a rigid body's orientation. The line search compares slopes, not
    energies: it never steps far past the minimum along a step. Where lines pull far more than the load, the last digit
    of the pose is a larger force: it is accepted then.
    """
    load, stride = load_scale(packed) + 1e-9, max(POSE_STEP, STRIDE * largest(lengths, lengths.shape[0]))
    grain = STALLED + GRAIN * (largest(pose, 3) + largest(lengths, lengths.shape[0]))
    work.move[:, 0] = 0.0
    if not _evaluate(packed, lengths, pose, states, work, law):
        return False
    for _ in range(DESCENT_STEPS):
        size = largest(work.wrench, n)
        soft = 0.0
        for k in range(n):
            soft = max(soft, work.stiffness[k, k])
        if size < tolerance * load:
            return True
        slope = _direction(packed, work, n, 1e-12 * soft + 1e-6 * load)
        if not slope > 0.0:
            slope = _direction(packed, work, n, soft + load)
        if not slope > 0.0:
            return False
        stalled = max(STALLED_FORCE * load, n * soft * grain)
        if size < stalled and largest_of_column(work.move, n) < grain:
            return True
        copy(pose, work.trial)
        moved = False
        for _ in range(LINE_SEARCH_STEPS):
            move_platform(pose, work, stride)
            placed = _evaluate(packed, lengths, pose, states, work, law)
            ahead = 0.0
            for k in range(n):
                ahead += work.wrench[k] * work.move[k, 0]
            if placed and ahead > -0.9 * slope:
                moved = True
                break
            copy(work.trial, pose)
            for k in range(n):
                work.move[k, 0] *= 0.35
            slope *= 0.35
        if not moved:
            return size < stalled
    return False


@jit
def _direction(packed, work, n, damping):
    """Write the Newton direction to work.move; returns the product of wrench and direction, 0 where there is none."""
    for i in range(n):
        work.move[i, 0] = work.wrench[i]
        work.stiffness[i, i] += damping
    if not solve(work.stiffness, work.move, n, 1):
        return 0.0
    keep_free_columns(packed, work.move)
    slope = 0.0
    for k in range(n):
        slope += work.move[k, 0] * work.wrench[k]
    return slope if largest_of_column(work.move, n) < 1e6 else 0.0


@jit
def _evaluate(packed, lengths, pose, states, work, law):
    """Evaluate wrench and tangent stiffness at *pose* under the line law. False where a line has no solution."""
    place_platform(pose, work.rotation)
    start_balance(packed, work.rotation, work.wrench, work.stiffness)
    for i in range(packed.lines.shape[0]):
        row, plane = packed.lines[i], work.planes[i]
        place(packed.lines, i, pose, work.rotation, work.arms[i], plane)
        if law == SPRING:
            _add_spring(row, work.lengths[i], work.arms[i], plane, work.wrench, work.stiffness)
            continue
        found = settle_line(row, states[i], lengths[i], pose, i, SPRING_TENSION, work, work.spatial)
        if found == FAILED or (found == SETTLED and not condense_line(row, states[i], i, work, work.spatial)):
            return False
    hold(packed, work.wrench, work.stiffness)
    return True


@jit(inline=True)
def _add_spring(row, length, arm, plane, wrench, stiffness):
    """Add a unilateral spring of unstrained *length* from the exit point, or the constant pull of a counterweight."""
    x, z = plane[2], plane[3]
    distance = sqrt(x * x + z * z)
    hung = row[COUNTERWEIGHT] > 0.0
    if (distance <= length and not hung) or distance == 0.0:
        return
    rate = 0.0 if hung else 1.0 / (max(length, 0.1) * row[FREE_COMPLIANCE] + row[END_SPRING] / row[SPANS])
    tension = row[COUNTERWEIGHT] if hung else rate * (distance - length)
    c, s = x / distance, z / distance
    across = tension / distance
    kxx, kxz, kzz = rate * c * c + across * s * s, (rate - across) * c * s, rate * s * s + across * c * c
    add_line(row, arm, plane, tension * c, tension * s, kxx, kxz, kxz, kzz, wrench, stiffness)


@jit
def spring_guess(packed, lengths, pose, states, work):
    """Set *pose* near the equilibrium for *lengths*: springs from the exit points, sheaves as constant offsets.

    A rigid body is first translated at the rotation given in *pose*: there the springs' potential has a single minimum,
    and a descent from it with the rotation free rarely ends in a distant equilibrium.
    """
    place_below(packed, lengths, pose)
    for _ in range(2):
        if not _offset_springs(packed, lengths, pose, states, work):
            return False
        if not descend(packed, lengths, pose, states, work, SPRING, SPRING_TOLERANCE, 3):
            return False
    if packed.freedoms == 6:  # need not converge, which soft directions can make slow: Newton continues from here
        descend(packed, lengths, pose, states, work, SPRING, SPRING_TOLERANCE, 6)
    return True


@jit
def _offset_springs(packed, lengths, pose, states, work):
    """Set work.lengths to those of springs: *lengths* less the straight distances at *pose* to the exit points."""
    place_platform(pose, work.rotation)
    for i in range(packed.lines.shape[0]):
        place(packed.lines, i, pose, work.rotation, work.arms[i], work.planes[i])
        work.lengths[i] = spring_line(
            packed.lines[i], states[i], lengths[i], pose, i, SPRING_TENSION, work, work.spatial
        )
        if work.lengths[i] < 0.0:
            return False
    return True


@jit
def _is_at_exit(row, pose):
    """Whether the platform's origin is where the line leaves the frame: no line can be drawn from there."""
    for k in range(3):
        if abs(row[EXIT_X + k] - pose[k]) > AXIS_DISTANCE:
            return False
    return True


@jit
def place_below(packed, lengths, pose):
    """Set the position of *pose* below the centroid of the exit points as a first guess; its rotation stays.

    Where a plane carries the platform, the position is in that plane.
    """
    m = packed.lines.shape[0]
    pose[:3] = 0.0
    drop = 1e300
    for i in range(m):
        drop = min(drop, 0.25 * reach_of_line(packed.lines[i], lengths[i]))
    for k in range(3):
        low, high = 1e300, -1e300
        for i in range(m):
            pose[k] += packed.lines[i, EXIT_X + k] / m
            low, high = min(low, packed.lines[i, EXIT_X + k]), max(high, packed.lines[i, EXIT_X + k])
        drop = max(drop, 0.25 * (high - low))
    pose[2] -= drop
    for i in range(m):
        if _is_at_exit(packed.lines[i], pose):
            pose[2] -= BESIDE * drop
    into_plane(packed, pose)
