"""Equilibrium of all lines and the platform, by Newton's method; each line's unknowns are eliminated.

The equations are F(x, y) = 0 with the pose x and the line unknowns y; an n x n system for the pose remains.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import copy, largest, min_pivot, solve
from cablewright.kernels.layout import (
    MASS_X,
    MASS_Y,
    MASS_Z,
    NOT_CONVERGED,
    NOT_FINITE,
    OK,
    OVERSTRETCHED,
    PLATFORM_WEIGHT,
    SINGULAR,
    STATE,
    UNSTABLE,
    WRENCH,
)
from cablewright.kernels.statics.line.interface import advance_line, condense_line, evaluate_line, judge_line, may_tip
from cablewright.kernels.statics.line.spatial import SpatialWork, spatial_work
from cablewright.kernels.statics.line.upright import is_slack
from cablewright.kernels.statics.line.upright_parameter_derivatives import OWN
from cablewright.kernels.statics.line.vertical_plane import place
from cablewright.kernels.statics.platform import (
    POSE_STEP,
    hold,
    keep_free,
    keep_free_columns,
    move_platform,
    place_platform,
    start_balance,
)

NEWTON_STEPS = 60
LENGTH_TOLERANCE = 1e-12  # on every geometric equation, m: of lines over 1 m, of shorter ones a share
FORCE_TOLERANCE = 1e-12  # of the largest force at play
BALANCED = 1e-10  # of the largest force: imbalance accepted where rounding limits it
STALLED = 1e-10  # the same, where rounding limits it
NEUTRAL = 1e-10  # of the largest stiffness: a smaller one does not hold a platform
SHORTEST_ARM = 1e-9  # m: of a platform without arms, which has no moments


class Work(NamedTuple):
    """Working memory of one equilibrium solver, allocated once and used by one thread at a time."""

    blocks: NDArray[np.float64]  # (m, 6, 6)
    steps: NDArray[np.float64]  # (m, 6, 4): a line's block inverse times residual, x, z and, while moving, length
    arms: NDArray[np.float64]  # (m, 3)
    planes: NDArray[np.float64]  # (m, 4)
    rotation: NDArray[np.float64]  # (3, 3)
    wrench: NDArray[np.float64]  # (n,)
    stiffness: NDArray[np.float64]  # (n, n)
    move: NDArray[np.float64]  # (n, 1)
    trial: NDArray[np.float64]  # (n,)
    forces: NDArray[np.float64]  # (m, 2): tension (h, v) where each free span starts
    changes: NDArray[np.float64]  # (6, 5): one line's changes by its parameters
    lengths: NDArray[np.float64]  # (m,)
    spatial: SpatialWork | None


@jit(allocates=True)
def workspace(packed):
    """Allocate a `Work` for the robot *packed*."""
    return workspace_of(packed.general, packed.freedoms, packed.lines.shape[0])


@jit(allocates=True)
def workspace_of(general, n, m):
    """Allocate a `Work` for *n* degrees of freedom and *m* lines; *general*: see `Packed`."""
    return Work(
        np.zeros((m, STATE, STATE)),
        np.zeros((m, STATE, 4)),
        np.zeros((m, 3)),
        np.zeros((m, 4)),
        np.eye(3),
        np.zeros(n),
        np.zeros((n, n)),
        np.zeros((n, 1)),
        np.zeros(n),
        np.zeros((m, 2)),
        np.zeros((STATE, len(OWN))),
        np.zeros(m),
        spatial_work(general, n, m),
    )


@jit
def evaluate(packed, lengths, pose, states, work):
    """Evaluate all lines and the platform's balance at *pose* and *states*.

    Leaves the lines' blocks and residuals in *work*, except of slack massless lines. Returns the largest geometric
    residual (m), the largest unbalanced force (N) and the force scale (N).
    """
    lines = packed.lines
    place_platform(pose, work.rotation)
    start_balance(packed, work.rotation, work.wrench, work.stiffness)
    scale = packed.platform[PLATFORM_WEIGHT]
    worst, reach = 0.0, _arm_of_weight(packed)
    copy(work.wrench, work.trial)
    for k in range(3):
        scale += abs(packed.platform[WRENCH + k])
    for i in range(lines.shape[0]):
        row, y = lines[i], states[i]
        place(lines, i, pose, work.rotation, work.arms[i], work.planes[i])
        reach = max(reach, abs(work.arms[i, 0]), abs(work.arms[i, 1]), abs(work.arms[i, 2]))
        if is_slack(row, y):
            continue
        size, force = evaluate_line(row, y, lengths[i], pose, i, work, work.spatial)
        if size > worst or size != size:  # keeps a NaN
            worst = size
        scale = max(scale, force)
    keep_free(packed, work.trial)
    return worst, _unbalanced(work.trial, reach), scale


@jit
def condense(packed, states, work):
    """Eliminate the evaluated lines from the platform's equations: leave balance and tangent stiffness in *work*.

    The balance is that after each line's own Newton step. Returns False where a line's block is singular.
    """
    for i in range(packed.lines.shape[0]):
        row, y = packed.lines[i], states[i]
        if not is_slack(row, y) and not condense_line(row, y, i, work, work.spatial):
            return False
    hold(packed, work.wrench, work.stiffness)
    return True


@jit
def _arm_of_weight(packed):
    """Distance of the centre of mass from the platform's origin along the longest axis, m."""
    platform = packed.platform
    return max(abs(platform[MASS_X]), abs(platform[MASS_Y]), abs(platform[MASS_Z]))


@jit
def unbalanced(packed, arms, wrench):
    """Return the largest force (N) of a *wrench* on the platform, its moments divided by the longest of the *arms*."""
    reach = _arm_of_weight(packed)
    for i in range(arms.shape[0]):
        reach = max(reach, abs(arms[i, 0]), abs(arms[i, 1]), abs(arms[i, 2]))
    return _unbalanced(wrench, reach)


@jit
def _unbalanced(wrench, reach):
    """Largest force (N) of a wrench, its moments divided by the longest arm; NaN stays NaN."""
    most = 0.0
    for k in range(wrench.shape[0]):
        size = abs(wrench[k]) if k < 3 else abs(wrench[k]) / max(reach, SHORTEST_ARM)
        if size > most or size != size:
            most = size
    return most


@jit
def refine(packed, lengths, pose, states, work):
    """Solve the equilibrium by Newton's method from *pose* and *states*, updated in place.

    Returns code, iterations, residual (m).
    """
    stalled, worst = False, 0.0
    size, grain = grains(lengths, pose)
    for iteration in range(NEWTON_STEPS):
        worst, unbalanced, scale = evaluate(packed, lengths, pose, states, work)
        if not (worst == worst and unbalanced == unbalanced):
            return NOT_FINITE, iteration, worst
        if worst < LENGTH_TOLERANCE * size + grain and unbalanced < FORCE_TOLERANCE * scale:
            return OK, iteration, worst
        if stalled and worst < STALLED * size + grain and unbalanced < BALANCED * scale:
            return OK, iteration, worst
        possible, step, full = newton_step(packed, pose, states, work)
        if not possible:
            return SINGULAR, iteration, worst
        stalled = full and step < STALLED + grain and worst < STALLED + grain
    return NOT_CONVERGED, NEWTON_STEPS, worst


@jit
def grains(lengths, pose):
    """Return the scale of length tolerances (up to 1 m), and the floating-point resolution of a coordinate, m."""
    return min(1.0, largest(lengths, lengths.shape[0])), 4e-16 * largest(pose, 3)


@jit
def newton_step(packed, pose, states, work):
    """Take one Newton step of the evaluated equations. Returns whether it exists, and the full step's length (m)."""
    lines, n = packed.lines, packed.freedoms
    if not condense(packed, states, work):
        return False, 0.0, False
    for k in range(n):
        work.move[k, 0] = work.wrench[k]
    if not solve(work.stiffness, work.move, n, 1):
        return False, 0.0, False
    keep_free_columns(packed, work.move)
    step, full = move_platform(pose, work, POSE_STEP)
    for i in range(lines.shape[0]):
        if not is_slack(lines[i], states[i]):
            full = advance_line(lines[i], states[i], i, work.move, work, work.spatial) and full
    return True, step, full


@jit
def judge(packed, states, planes, spatial):
    """Return the status code of a solved equilibrium: OK if it is valid and the machine can have it.

    OVERSTRETCHED only if nothing else is wrong. *planes* and *spatial*: of the lines as evaluated, see `Work`.
    """
    code = OK
    for i in range(packed.lines.shape[0]):
        found = judge_line(packed.lines[i], states[i], i, planes, spatial)
        if found == OVERSTRETCHED:
            code = found
        elif found != OK:
            return found
    return code


@jit
def judge_stability(packed, states, work):
    """Return the status code of an equilibrium: OK if it is stable.

    A point load with taut dead spans always is, unless a cable leaves its sheave backwards; see
    `docs/theory/uniqueness.md`. Where a dead span hangs in a loop, cable may still run through its eyelet by itself:
    that is not judged. Without a load all lines may be slack.
    """
    if _all_slack(packed, states):
        return SINGULAR
    if not may_tip(packed, states):
        return OK
    if not condense(packed, states, work):
        return SINGULAR
    return judge_pivot(min_pivot(work.stiffness, packed.freedoms))


@jit
def _all_slack(packed, states):
    """Whether no line carries anything."""
    for i in range(packed.lines.shape[0]):
        if not is_slack(packed.lines[i], states[i]):
            return False
    return True


@jit
def judge_pivot(pivot):
    """Return the status code of an equilibrium by the smallest pivot of its stiffness: OK, SINGULAR or UNSTABLE."""
    if pivot > NEUTRAL:
        return OK
    return SINGULAR if pivot > -NEUTRAL else UNSTABLE
