"""Compliant exit points: the cable's force displaces each mount, in equilibrium with lines and platform."""

from math import exp

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.layout import (
    DEAD,
    DEAD_COMPLIANCE,
    FREE,
    FREE_COMPLIANCE,
    NOT_CONVERGED,
    OK,
    PULLS,
    SPANS,
    TAU,
)
from cablewright.kernels.statics.forward import solve_warm
from cablewright.kernels.statics.line.guides import GUIDE_SIZE
from cablewright.kernels.statics.line.solved_line import carry_exit, directions_of_line

CLOSED = 1e-7  # m: last move of an exit in equilibrium
ROUNDS = 100
RELAXED = 20  # rounds with scaled steps


@jit
def give(packed, states, planes, ratio, compliance, displaced, steps, guide):
    """Move the exit points of *packed* by one Newton step towards the deflection under their forces.

    Returns the largest step, m. *ratio* (m,): tension of each dead span over that of its free span; *compliance* (m, 3,
    3), m/N. *displaced* (m, 3), m, and the exit points and winches in its lines are updated in place; *steps* (m, 3),
    m, are written. Each line runs between a fixed winch and a fixed platform, and its tension falls as its exit point
    yields.
    """
    most = propose(packed, states, planes, ratio, compliance, displaced, steps, guide)
    move(packed, planes, steps, 1.0, displaced)
    return most


@jit
def propose(packed, states, planes, ratio, compliance, displaced, steps, guide):
    """Write the *steps* of compliant exit points towards equilibrium and return the largest, m."""
    most = 0.0
    for i in range(packed.lines.shape[0]):
        found = directions_of_line(packed.lines[i], states[i], planes[i], guide, packed.general)
        _propose(packed.lines[i], states[i], found, ratio[i], compliance[i], displaced[i], steps[i])
        most = max(most, abs(steps[i, 0]), abs(steps[i, 1]), abs(steps[i, 2]))
    return most


@jit
def _propose(row, y, found, ratio, soft, displaced, step):
    """As `propose`, of one line: *soft* is its compliance (3, 3), *found* as `interface.directions_of_line`.

    The mount is pulled by all spans and cables of the line; (gx, gy, gz) is by how much one cable's way shortens as the
    exit moves, and, times the cables, how the pull grows with their tension. A winch that is not described moves along.
    """
    spans, cables = row[SPANS], row[PULLS] / row[SPANS]
    pull = cables * exp(y[TAU])
    ax, ay, az, bx, by, bz = found
    gx, gy, gz = spans * ax + bx, spans * ay + by, spans * az + bz
    fx, fy, fz = pull * (spans * ax + ratio * bx), pull * (spans * ay + ratio * by), pull * (spans * az + ratio * bz)
    missing_along, soft_along = 0.0, 0.0
    for k in range(3):
        g = gx if k == 0 else (gy if k == 1 else gz)
        missing_along += g * (soft[k, 0] * fx + soft[k, 1] * fy + soft[k, 2] * fz - displaced[k])
        soft_along += g * (soft[k, 0] * gx + soft[k, 1] * gy + soft[k, 2] * gz)
    stretch = row[FREE_COMPLIANCE] * spans * y[FREE] + row[DEAD_COMPLIANCE] * y[DEAD]  # m/N
    share = cables * missing_along / (stretch + cables * soft_along)
    fx, fy, fz = fx - share * gx, fy - share * gy, fz - share * gz
    for k in range(3):
        step[k] = soft[k, 0] * fx + soft[k, 1] * fy + soft[k, 2] * fz - displaced[k]


@jit
def move(packed, planes, steps, scale, displaced):
    """Move exit points by *scale* times *steps* (m, 3), m; winches stay where they are."""
    for i in range(packed.lines.shape[0]):
        for k in range(3):
            displaced[i, k] += scale * steps[i, k]
        carry_exit(packed.lines[i], planes[i], steps[i], scale, packed.general)


@jit(allocates=True)
def close(packed, lengths, pose, states, ratio, compliance, displaced, work):
    """Displace exit points until their mounts are in equilibrium with lines and platform.

    All but *lengths* and *ratio* change in place. *pose* and *states* are an equilibrium for the present exit points,
    evaluated in *work*. Steps are scaled by the response to the last one, since the platform is not fixed (Aitken
    relaxation: Kuettler and Wall 2008, Computational Mechanics 43), and no more where that does not help. Returns a
    code.
    """
    steps, last, scale = np.zeros_like(displaced), np.zeros_like(displaced), 1.0
    guide = np.zeros(GUIDE_SIZE)
    for k in range(ROUNDS):
        if propose(packed, states, work.planes, ratio, compliance, displaced, steps, guide) < CLOSED:
            return OK
        if k > 0:
            scale = min(max(_answered(steps, last, scale), 0.5), 3.0) if k < RELAXED else 1.0
        move(packed, work.planes, steps, scale, displaced)
        last[:, :] = steps
        code, _, _ = solve_warm(packed, lengths, pose, states, work)
        if code != OK:
            return code
    return NOT_CONVERGED


@jit
def _answered(steps, last, scale):
    """The scale with which *last* would have left the least of the *steps* that are left."""
    along, size = 0.0, 0.0
    for i in range(steps.shape[0]):
        for k in range(3):
            change = steps[i, k] - last[i, k]
            along += last[i, k] * change
            size += change * change
    return -scale * along / size if size > 0.0 else 1.0
