"""Counterweights that move: the mass of each, by the implicit midpoint rule, at the end of its line.

In a step of *dt* a counterweight of mass M that the cable pulls with T has the acceleration 4 (L - L0 - u dt/2) / dt^2
at the midpoint, with L the length that its line has there, L0 and u those at the begin: as the line gets longer the
weight rises. M times that is T - M g, so that T is affine in L: the line is one of given length, with a spring of the
rate 4 M / dt^2 at its end, and is solved as such with lines and platform. Energy and momentum are kept as by the rule.
"""

from math import exp

from cablewright.kernels import jit
from cablewright.kernels.layout import DEAD, END_SPRING, TAU, WEIGHT, WINCH_RISE
from cablewright.kernels.statics.line.upright import is_slack

# Columns of a line's counterweight; all zero: it has none.
MASS = 0  # kg, for each cable
HELD = 1  # N, its weight for each cable
RATIO = 2  # of the tension of the dead span to that of the free span
SPEED, LENGTH = 3, 4  # m/s, m: of its line, which gets longer as it rises; at the begin of a step
COUNTERWEIGHT = 5


@jit
def hang(weights, lines, states, dt, lengths, after):
    """Replace each counterweight by an equivalent spring and length (m) for a step of *dt* (s).

    *weights* (m, COUNTERWEIGHT). *lengths* and *after* (m,) are set, and the springs in *lines*.
    """
    for i in range(weights.shape[0]):
        own, row = weights[i], lines[i]
        if own[MASS] == 0.0 or is_slack(row, states[i]):
            continue
        soft = 0.25 * dt * dt / own[MASS]
        above = row[WEIGHT] * states[i, DEAD] * row[WINCH_RISE]
        row[END_SPRING] = own[RATIO] * soft
        own[LENGTH] = lengths[i]
        lengths[i] = after[i] = lengths[i] + 0.5 * dt * own[SPEED] - soft * (own[HELD] - above)


@jit
def rise(weights, lines, states, dt, lengths, moved):
    """Set the *lengths* (m,), m, and speeds of counterweights after a step with the midpoint *states*.

    Not *moved*: each stands still.
    """
    for i in range(weights.shape[0]):
        own = weights[i]
        if own[MASS] == 0.0 or is_slack(lines[i], states[i]):
            continue
        before, own[SPEED], lengths[i] = own[SPEED], 0.0, own[LENGTH]
        if moved:
            pull = own[RATIO] * exp(states[i, TAU]) + lines[i, WEIGHT] * states[i, DEAD] * lines[i, WINCH_RISE]
            own[SPEED] = before + dt * (pull - own[HELD]) / own[MASS]
            lengths[i] += 0.5 * dt * (before + own[SPEED])
