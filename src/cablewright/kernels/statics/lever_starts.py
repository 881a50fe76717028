"""Starts for equilibria other than the usual one: levers that stand on their head."""

from math import cos, log, pi, sin

from cablewright.kernels import jit
from cablewright.kernels.layout import (
    BETA,
    DEAD,
    FREE,
    FREE_COMPLIANCE,
    LEVER,
    PHI,
    PLATFORM_WEIGHT,
    PSI,
    RADIUS,
    SIDE,
    TAU,
    UNKNOWNS,
    WEIGHT,
    WINCH_X,
    WINCH_Z,
)
from cablewright.kernels.rotation import matrix
from cablewright.kernels.statics.line import guess
from cablewright.kernels.statics.sheave import straight, tangent, wrap
from cablewright.kernels.statics.wrench import place


@jit
def start_at(packed, lengths, pose, heads, pull, states, work):
    """Line states near those of *lengths* at *pose*, the levers marked in *heads* (m,) turned about. False if none.

    Levers are placed as if each line bore *pull* times its share of the platform's weight.
    """
    share = pull * packed.platform[PLATFORM_WEIGHT] / packed.lines.shape[0]
    if packed.freedoms == 6:
        matrix(pose[3:], work.rotation)
    for i in range(packed.lines.shape[0]):
        row, plane, y = packed.lines[i], work.planes[i], states[i]
        place(packed.lines, i, pose, work.rotation, work.arms[i], plane)
        if heads[i] and row[UNKNOWNS] == 6.0:
            if not _on_head(row, plane[2], plane[3], lengths[i], share, y):
                return False
        elif not guess(row, plane[2], plane[3], lengths[i], share, y):
            return False
    return True


@jit
def _on_head(row, x, z, length, tension, y):
    """Set *y* to the straight line over a sheave whose lever points away from its pull. False inside the sheave."""
    if not straight(row, x, z, tension, y):
        return False
    beta = y[BETA] + pi
    hx, hz = row[LEVER] * cos(beta), row[LEVER] * sin(beta)
    turn = row[SIDE] * row[RADIUS]
    phi, psi = y[PHI], y[PSI]
    y[PHI], y[FREE] = tangent(x - hx, z - hz, turn)
    y[PSI], y[DEAD] = tangent(row[WINCH_X] - hx, row[WINCH_Z] - hz, -turn)
    if y[FREE] <= 0.0 or y[DEAD] <= 0.0:
        return False
    y[PHI] += 2.0 * pi * round((phi - y[PHI]) / (2.0 * pi))  # the tangents turn little as the lever does
    y[PSI] += 2.0 * pi * round((psi - y[PSI]) / (2.0 * pi))
    y[BETA] = beta
    strained = y[FREE] + y[DEAD] + row[RADIUS] * wrap(row, y)
    stretch = (strained - length) / (length * row[FREE_COMPLIANCE])
    carried = row[WEIGHT] * (y[FREE] + y[DEAD])
    y[TAU] = log(max(stretch, 1.02 * carried, 1e-3 * tension))
    return True
