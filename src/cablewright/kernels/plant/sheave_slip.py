"""Sliding over sheaves: by the way of the cable, which part of the friction acts (Maxwell slip) and which way."""

from math import exp

from cablewright.kernels import jit
from cablewright.kernels.layout import DEAD, DEAD_COMPLIANCE, FREE, TAU
from cablewright.kernels.statics.line.sheave import contact_angle


@jit
def slide(lines, states, rate, sticks, before, elements, ratio, stretch):
    """Slide lines to where they are by their *states*, monotonously since the last call.

    *rate*: coefficient of friction; *sticks* (k,), m: way from rest until an element slips. In place: *before* (m,) m,
    the free spans' lengths of last time; *elements* (m, k), -1 to 1. Written: *ratio* (m,), tension at the winch over
    that at the platform, and *stretch* (m,), m, of dead spans beyond what statics has.
    """
    k = sticks.shape[0]
    for i in range(lines.shape[0]):
        row, y = lines[i], states[i]
        paid, held = y[FREE] - before[i], 0.0
        before[i] = y[FREE]
        for j in range(k):
            elements[i, j] = min(max(elements[i, j] + paid / sticks[j], -1.0), 1.0)
            held += elements[i, j]
        ratio[i] = exp(-rate * contact_angle(row, y) * held / k)
        stretch[i] = (ratio[i] - 1.0) * exp(y[TAU]) * row[DEAD_COMPLIANCE] * y[DEAD]
