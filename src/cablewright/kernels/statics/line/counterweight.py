"""A line with a counterweight in place of a winch: the tension at that end is given instead of a length.

It is one of the lines that `spatial` solves, with another fourth equation.
"""

from math import atan2, cos, exp, log, sin

from cablewright.kernels import jit
from cablewright.kernels.layout import (
    AZIMUTH,
    COUNTERWEIGHT,
    DEAD,
    FREE,
    FREE_COMPLIANCE,
    PHI,
    TAU,
    TENSION_MAX,
    TENSION_MIN,
    WEIGHT,
    WINCH_RISE,
)
from cablewright.kernels.statics.line.guides import SPAN_BY_FORCE
from cablewright.kernels.statics.line.upright import extremes, length_of

LIGHTEST = 0.05  # of the counterweight's tension: the least at the sheave with which a guess begins


@jit
def winch_tension(row, y):
    """Return the tension (N) of one cable at its winch end, for a line outside a vertical plane."""
    return exp(y[TAU]) + row[WEIGHT] * y[DEAD] * row[WINCH_RISE]


@jit
def winch_tension_change(row, y, grown, longer):
    """Return the change of `winch_tension`, N, after the log of the tension at the sheave has *grown*.

    The dead span is *longer* by so many metres.
    """
    return exp(y[TAU]) * grown + row[WEIGHT] * row[WINCH_RISE] * longer


@jit
def hang_counterweight(row, y, record, by_tension, per_metre, block, rhs):
    """Write the line's fourth equation at *y*: the tension at its end is that of the counterweight.

    It is divided by that tension. *by_tension* and *per_metre*: derivatives of the dead span's length, see
    `spatial.dead_length`; *record*: of the placed guides.
    """
    t, c, lift = exp(y[TAU]), cos(y[PHI]), row[WEIGHT] * row[WINCH_RISE]
    toward = (c * cos(y[AZIMUTH]), c * sin(y[AZIMUTH]), sin(y[PHI]))
    for j in range(3):
        longer = by_tension * toward[j] + per_metre * record[SPAN_BY_FORCE + j]
        block[3, j] = t * (toward[j] + lift * longer) / row[COUNTERWEIGHT]
    block[3, 3] = 0.0
    rhs[3, 0] = winch_tension(row, y) / row[COUNTERWEIGHT] - 1.0


@jit
def shape_hung(row, y):
    """Set *y* to a straight line near its equilibrium with the counterweight, as a first guess."""
    held, weight = row[COUNTERWEIGHT], row[WEIGHT]
    t = max(held - weight * y[DEAD] * row[WINCH_RISE], LIGHTEST * held)
    y[TAU] = log(t)
    y[FREE] /= 1.0 + t * row[FREE_COMPLIANCE]
    y[PHI] = atan2(t * sin(y[PHI]) - 0.5 * weight * y[FREE], t * cos(y[PHI]))


@jit
def beyond_limits(row, y):
    """Return by how much a solved line's tensions violate limits, or miss the counterweight's, N.

    Negative within the limits.
    """
    low, high = extremes(row, y)
    beyond = max(row[TENSION_MIN] - low, high - row[TENSION_MAX])
    if row[COUNTERWEIGHT] > 0.0:
        beyond = max(beyond, abs(winch_tension(row, y) - row[COUNTERWEIGHT]))
    return beyond


@jit
def beyond_hung_limits(row, y):
    """Return `beyond_limits` of a line with a counterweight; 0 N for one with a winch, which sets the tension."""
    return beyond_limits(row, y) if row[COUNTERWEIGHT] > 0.0 else 0.0


@jit
def read_lengths(packed, states, lengths):
    """Write to *lengths* (m,) the unstrained lengths, m, of the lines with a counterweight, which decides them."""
    for i in range(packed.lines.shape[0]):
        if packed.lines[i, COUNTERWEIGHT] > 0.0:
            lengths[i] = length_of(packed.lines[i], states[i])
