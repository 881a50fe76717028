"""Friction of cables that slide over sheaves, by Maxwell slip elements: how much acts, and in which direction."""

from math import exp

from cablewright.kernels import jit
from cablewright.kernels.layout import DEAD, DEAD_COMPLIANCE, FREE, SPANS, TAU
from cablewright.kernels.statics.line.solved_line import turn_line


@jit
def slide(packed, states, planes, turned, guide, rate, sticks, before, elements, ratio, stretch):
    """Compute the friction of cables over sheaves after a monotonous slide from the last call to the present *states*.

    *planes* (m, 4): of the lines, as placed; *turned* (m,), rad: by which cables turn before their exit points;
    *guide* (GUIDE_SIZE,): scratch. *rate*: coefficient of friction; *sticks* (k,), m: way from rest until an element
    slips. In place: *before* (m,) m, the free spans' lengths of last time; *elements* (m, k), -1 to 1. Written: *ratio*
    (m,), tension at the winch over that at the platform, and *stretch* (m,), m, of dead spans beyond what statics has.
    """
    k = sticks.shape[0]
    for i in range(packed.lines.shape[0]):
        row, y = packed.lines[i], states[i]
        paid, held = row[SPANS] * (y[FREE] - before[i]), 0.0
        before[i] = y[FREE]
        for j in range(k):
            elements[i, j] = min(max(elements[i, j] + paid / sticks[j], -1.0), 1.0)
            held += elements[i, j]
        angle = turned[i] + turn_line(row, y, planes[i], guide, packed.general)
        ratio[i] = exp(-rate * angle * held / k)
        stretch[i] = (ratio[i] - 1.0) * exp(y[TAU]) * row[DEAD_COMPLIANCE] * y[DEAD]
