"""Exits that give: the mount of each is displaced by the force of its cable, closed with lines and platform."""

from math import cos, exp, sin

from cablewright.kernels import jit
from cablewright.kernels.layout import (
    DEAD,
    DEAD_COMPLIANCE,
    EXIT_X,
    FREE,
    FREE_COMPLIANCE,
    NOT_CONVERGED,
    OK,
    PHI,
    PSI,
    PULLS,
    TAU,
    UNKNOWNS,
    WINCH_X,
    WINCH_Z,
)
from cablewright.kernels.statics.forward import solve_warm

CLOSED = 1e-7  # m: last move of an exit in equilibrium
ROUNDS = 100


@jit
def give(lines, states, planes, ratio, compliance, displaced):
    """Move the exits of *lines* towards where their forces put them; return by how much at most, m.

    *ratio* (m,): tension of each dead span over that of its free span; *compliance* (m, 3, 3), m/N. *displaced* (m, 3),
    m, and the exits and winches in *lines* are updated in place. One step of Newton's method for each line between a
    fixed winch and a fixed platform, whose tension falls as its exit gives.
    """
    most = 0.0
    for i in range(lines.shape[0]):
        most = max(most, _give(lines[i], states[i], planes[i], ratio[i], compliance[i], displaced[i]))
    return most


@jit
def _give(row, y, plane, ratio, soft, displaced):
    """As `give`, of one line: *soft* is its compliance (3, 3)."""
    has_dead = 1.0 if row[UNKNOWNS] > 3.0 else 0.0
    tension = exp(y[TAU]) if row[PULLS] > 0.0 else 0.0
    flat, dead_flat = cos(y[PHI]), has_dead * cos(y[PSI])
    rise, dead_rise = sin(y[PHI]), has_dead * sin(y[PSI])
    pull, gx, gz = tension * (flat + ratio * dead_flat), flat + dead_flat, rise + dead_rise
    fx, fy, fz = pull * plane[0], pull * plane[1], tension * (rise + ratio * dead_rise)
    gx, gy = gx * plane[0], gx * plane[1]
    missing_along, soft_along = 0.0, 0.0
    for k in range(3):
        g = gx if k == 0 else (gy if k == 1 else gz)
        missing_along += g * (soft[k, 0] * fx + soft[k, 1] * fy + soft[k, 2] * fz - displaced[k])
        soft_along += g * (soft[k, 0] * gx + soft[k, 1] * gy + soft[k, 2] * gz)
    stretch = row[FREE_COMPLIANCE] * y[FREE] + row[DEAD_COMPLIANCE] * y[DEAD]  # m/N
    share = missing_along / (stretch + soft_along)
    fx, fy, fz = fx - share * gx, fy - share * gy, fz - share * gz
    most, aside = 0.0, 0.0
    for k in range(3):
        step = soft[k, 0] * fx + soft[k, 1] * fy + soft[k, 2] * fz - displaced[k]
        most = max(most, abs(step))
        displaced[k] += step
        row[EXIT_X + k] += step
        if k < 2:
            aside += step * plane[k]
        elif has_dead > 0.0:
            row[WINCH_Z] -= step  # the winch, told from the exit, stays where it is
    if row[UNKNOWNS] > 4.0:
        row[WINCH_X] -= aside
    return most


@jit
def close(packed, lengths, pose, states, ratio, compliance, displaced, work):
    """Let exits give until they are in equilibrium with lines and platform; all but *lengths* and *ratio* in place.

    *pose* and *states* are an equilibrium for the exits of now, evaluated in *work*. Returns a code.
    """
    for _ in range(ROUNDS):
        if give(packed.lines, states, work.planes, ratio, compliance, displaced) < CLOSED:
            return OK
        code, _, _ = solve_warm(packed, lengths, pose, states, work)
        if code != OK:
            return code
    return NOT_CONVERGED
