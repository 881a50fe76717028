"""The one linearisation: what the platform does when a length, a modulus or an exit point changes."""

from math import cos, exp, sin

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.equilibrium import OK, SINGULAR, condense, evaluate, is_slack
from cablewright.kernels.layout import (
    ARC_COMPLIANCE,
    DEAD,
    DEAD_COMPLIANCE,
    FREE,
    FREE_COMPLIANCE,
    PHI,
    PSI,
    RADIUS,
    STATE,
    TAU,
    UNKNOWNS,
    WEIGHT,
)
from cablewright.kernels.line import force_change, system
from cablewright.kernels.newton import solve
from cablewright.kernels.sheave import wrap
from cablewright.kernels.wrench import AXIS_DISTANCE, add_force

# Columns of a line's parameters: length, relative modulus, exit point x, y, z.
PARAMETERS = 5


@jit(allocates=True)
def linearise(packed, lengths, pose, states, work, stiffness, motion):
    """Write the tangent stiffness (n, n) and the motion (n, m, 5) of the platform per line parameter.

    Parameters: unstrained length (m/m), relative modulus (m per unit), exit point x, y, z (m/m). Where the dead
    span is modelled its winch exit follows the exit point sideways, so that the line keeps its plane, and stays
    where it is in height. Motion of a rigid body: translation and rotation in space. Returns a code.
    """
    m, n = packed.lines.shape[0], packed.freedoms
    evaluate(packed, lengths, pose, states, work)
    if not condense(packed, states, work):
        return SINGULAR
    stiffness[:, :] = work.stiffness[:n, :n]
    changes = np.zeros((STATE, 3))
    right = motion.reshape((n, m * PARAMETERS))
    for i in range(m):
        row, y, plane, arm = packed.lines[i], states[i], work.planes[i], work.arms[i]
        right[:, i * PARAMETERS : (i + 1) * PARAMETERS] = 0.0
        if is_slack(row, y):
            continue
        h, v = system(row, y, plane[2], plane[3], lengths[i], work.blocks[i], changes[:, 0])
        _parameter_residuals(row, y, changes)
        if not solve(work.blocks[i], changes, int(row[UNKNOWNS]), 3):
            return SINGULAR
        for k in range(3):
            dh, dv = force_change(h, v, row[WEIGHT], changes, k)
            _write(right, arm, dh * plane[0], dh * plane[1], dv, i * PARAMETERS + (k if k < 2 else 4), work.trial)
        kxx, kzx = force_change(h, v, row[WEIGHT], work.steps[i], 1)
        across = h / max(plane[2], AXIS_DISTANCE)
        ex, ey = plane[0], plane[1]
        _write(
            right,
            arm,
            ex * ex * kxx + ey * ey * across,
            ex * ey * (kxx - across),
            ex * kzx,
            i * PARAMETERS + 2,
            work.trial,
        )
        _write(
            right,
            arm,
            ex * ey * (kxx - across),
            ey * ey * kxx + ex * ex * across,
            ey * kzx,
            i * PARAMETERS + 3,
            work.trial,
        )
    return OK if solve(work.stiffness, right, n, m * PARAMETERS) else SINGULAR


@jit
def _write(right, arm, fx, fy, fz, column, wrench):
    """Set a column to the wrench of a force at *arm*."""
    wrench[:] = 0.0
    add_force(arm, fx, fy, fz, wrench)
    for k in range(right.shape[0]):
        right[k, column] = wrench[k]


@jit
def _parameter_residuals(row, y, out):
    """Derivatives of the line's equations by length, relative modulus and exit height, in columns of *out*."""
    out[:, :] = 0.0
    t = exp(y[TAU])
    out[2, 0] = -1.0
    stretch = t * row[FREE_COMPLIANCE] * y[FREE]
    sag = 0.5 * row[WEIGHT] * row[FREE_COMPLIANCE] * y[FREE] * y[FREE]
    out[0, 1] = -stretch * cos(y[PHI])
    out[1, 1] = -stretch * sin(y[PHI]) - sag
    strain = t * row[ARC_COMPLIANCE]
    out[2, 1] = row[RADIUS] * wrap(row, y) * strain / (1.0 + strain) ** 2
    out[1, 2] = 1.0
    if row[UNKNOWNS] > 3.0:
        stretch = t * row[DEAD_COMPLIANCE] * y[DEAD]
        sag = 0.5 * row[WEIGHT] * row[DEAD_COMPLIANCE] * y[DEAD] * y[DEAD]
        out[3, 1] = -stretch * sin(y[PSI]) - sag
        out[4, 1] = -stretch * cos(y[PSI])
        out[3, 2] = 1.0
