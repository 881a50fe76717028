"""Limits of a line's pull in the inverse problem, to first order, from its tension limits."""

from cablewright.kernels import jit
from cablewright.kernels.layout import COUNTERWEIGHT, DEAD, FREE, TENSION_MAX, TENSION_MIN, WEIGHT

FLATTEST = 0.05  # of an extreme's change per pull: min slope with which a limit is linearised


@jit
def pull_limits(row, y, pull, slackest, low, high, dlow, dhigh):
    """Return the lowest and highest pull, N, at which a line's extreme tensions are within its limits.

    The extremes and their changes per log of the pull are given. *slackest*: least tension, of the line's own weight.
    """
    least, most = max(row[TENSION_MIN], slackest * row[WEIGHT] * (y[FREE] + y[DEAD])), row[TENSION_MAX]
    if row[COUNTERWEIGHT] > 0.0:
        least = most = row[COUNTERWEIGHT]
    lowest = pull + (least - low) * pull / max(dlow, FLATTEST * pull)
    return lowest, pull + (most - high) * pull / max(dhigh, FLATTEST * pull)
