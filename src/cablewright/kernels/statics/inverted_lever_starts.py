"""Initial guesses for rare equilibria, in which levers are upside down: they point away from their pull."""

from math import cos, log, pi, sin

from cablewright.kernels import jit
from cablewright.kernels.layout import (
    BETA,
    DEAD,
    FREE,
    FREE_COMPLIANCE,
    LEVER,
    PHI,
    PSI,
    RADIUS,
    SIDE,
    TAU,
    UNKNOWNS,
    WEIGHT,
    WINCH_X,
    WINCH_Z,
)
from cablewright.kernels.statics.forward import guess_states
from cablewright.kernels.statics.line.sheave import straight, tangent, wrap
from cablewright.kernels.statics.platform import load_scale


@jit
def start_at(packed, lengths, pose, heads, pull, states, work):
    """Guess line states with the levers of *heads* (m,) upside down, see `forward.guess_states`.

    False if impossible.
    """
    if not guess_states(packed, lengths, pose, states, work, pull):
        return False
    share = pull * load_scale(packed) / packed.lines.shape[0]
    for i in range(packed.lines.shape[0]):
        row, plane = packed.lines[i], work.planes[i]
        inverted = heads[i] and row[UNKNOWNS] == 6.0
        if inverted and not _guess_inverted(row, plane[2], plane[3], lengths[i], share, states[i]):
            return False
    return True


@jit
def _guess_inverted(row, x, z, length, tension, y):
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
    y[PHI] += 2.0 * pi * round((phi - y[PHI]) / (2.0 * pi))  # the branch nearest to the tangents of `straight`
    y[PSI] += 2.0 * pi * round((psi - y[PSI]) / (2.0 * pi))
    y[BETA] = beta
    strained = y[FREE] + y[DEAD] + row[RADIUS] * wrap(row, y)
    stretch = (strained - length) / (length * row[FREE_COMPLIANCE])
    carried = row[WEIGHT] * (y[FREE] + y[DEAD])
    y[TAU] = log(max(stretch, 1.02 * carried, 1e-3 * tension))
    return True
