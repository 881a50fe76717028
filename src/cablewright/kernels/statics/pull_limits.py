"""Limits of a line's pull in a program of the inverse problem, from those of its tensions, to first order."""

from cablewright.kernels import jit
from cablewright.kernels.layout import COUNTERWEIGHT, DEAD, FREE, TENSION_MAX, TENSION_MIN, WEIGHT
from cablewright.kernels.statics.counterweight import winch_tension, winch_tension_change
from cablewright.kernels.statics.line import extremes_and_change

FLATTEST = 0.05  # of an extreme's change per pull: min slope with which a limit is linearised


@jit
def extremes_out_of_plane(row, y, dphi, dtau, dfree, ddead):
    """As `line.extremes_and_change`, of a line out of the plane: of one with a counterweight what that decides."""
    if row[COUNTERWEIGHT] > 0.0:
        held, dheld = winch_tension(row, y), winch_tension_change(row, y, dtau, ddead)
        return held, held, dheld, dheld
    return extremes_and_change(row, y, dphi, dtau, dfree, ddead, 0.0)


@jit
def pull_limits(row, y, pull, slackest, low, high, dlow, dhigh):
    """Lowest and highest pull, N, of a line with these extremes of tension and their changes per log of the pull.

    *slackest*: least tension, of the line's own weight.
    """
    least, most = max(row[TENSION_MIN], slackest * row[WEIGHT] * (y[FREE] + y[DEAD])), row[TENSION_MAX]
    if row[COUNTERWEIGHT] > 0.0:
        least = most = row[COUNTERWEIGHT]
    lowest = pull + (least - low) * pull / max(dlow, FLATTEST * pull)
    return lowest, pull + (most - high) * pull / max(dhigh, FLATTEST * pull)
