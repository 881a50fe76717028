"""A platform that retracts: a drive moves some platform points, and a part of the mass, along the body."""

from math import exp

from cablewright.kernels import jit
from cablewright.kernels.layout import FREE, PLATFORM_WEIGHT, POINT_X, PULLS, WEIGHT
from cablewright.kernels.plant.dynamics import MASS, MOMENTUM, PART, THRUST
from cablewright.kernels.plant.winding import DRUM_END, LIMITED, STALLED
from cablewright.kernels.rotation import rotate
from cablewright.kernels.statics.line.solved_line import heading_of_line
from cablewright.kernels.statics.line.upright import is_slack, start_force

# Entries of a beam; an empty array: the platform has one length.
LENGTH, SPEED = 0, 1  # m, m/s
LEAST, MOST = 2, 3  # m
MAX_SPEED, LAG, MAX_FORCE = 4, 5, 6  # m/s, s, N
ALONG = 7  # 7..9: unit vector in which points move as it grows, platform frame
MOVING_MASS = 10  # kg
MOVING = 11  # 11..13: m, centre of the moving mass at a length of 0, platform frame
BEAM = 14


@jit
def turn_drive(beam, speed, pull, dt, flags):
    """Move the retraction drive for *dt* (s) towards the commanded *speed* (m/s) against a *pull* (N).

    Positive speeds lengthen the platform. *pull*, of lines and weight, is positive where it lengthens. *flags* (1,)
    receive LIMITED, STALLED and DRUM_END. Returns the acceleration.
    """
    target = min(max(speed, -beam[MAX_SPEED]), beam[MAX_SPEED])
    if target != speed:
        flags[0] |= LIMITED
    if (target < 0.0 and pull > beam[MAX_FORCE]) or (target > 0.0 and -pull > beam[MAX_FORCE]):
        target = 0.0
        flags[0] |= STALLED
    before = beam[SPEED]
    keep = exp(-dt / beam[LAG]) if beam[LAG] > 0.0 else 0.0
    length = beam[LENGTH] + target * dt + (before - target) * beam[LAG] * (1.0 - keep)
    beam[SPEED] = target + (before - target) * keep
    if length < beam[LEAST] or length > beam[MOST]:
        length = min(max(length, beam[LEAST]), beam[MOST])
        beam[SPEED] = 0.0
        flags[0] |= DRUM_END
    beam[LENGTH] = length
    return (beam[SPEED] - before) / dt


@jit
def pull_along(packed, body, beam, moved, states, planes, rotation):
    """Return the force (N) with which lines and weight pull the retracting platform longer.

    *moved* (m,): 1 of lines whose points move.
    """
    x, y, z = rotate(rotation, beam[ALONG], beam[ALONG + 1], beam[ALONG + 2])
    pull = -beam[MOVING_MASS] * packed.platform[PLATFORM_WEIGHT] / body[MASS] * z
    for i in range(packed.lines.shape[0]):
        row = packed.lines[i]
        if moved[i] == 0.0 or is_slack(row, states[i]):
            continue
        h, v = start_force(states[i])
        v += row[WEIGHT] * states[i, FREE]
        ex, ey = heading_of_line(row, states[i], planes[i], packed.general)
        pull -= row[PULLS] * ((h * ex) * x + (h * ey) * y + v * z)
    return pull


@jit
def set_points(lines, beam, moved, fixed, length):
    """Write the positions of the platform points that move, for a *length* (m) of the platform.

    *fixed* (m, 3): at a length of 0.
    """
    for i in range(lines.shape[0]):
        if moved[i] == 0.0:
            continue
        for k in range(3):
            lines[i, POINT_X + k] = fixed[i, k] + length * beam[ALONG + k]


@jit
def set_part(body, beam, acceleration):
    """Write the position, momentum and inertial force of the platform's moving part to *body*."""
    for k in range(3):
        body[THRUST + k] = beam[MOVING_MASS] * acceleration * beam[ALONG + k]
        body[MOMENTUM + k] = beam[MOVING_MASS] * beam[SPEED] * beam[ALONG + k]
        body[PART + k] = beam[MOVING + k] + beam[LENGTH] * beam[ALONG + k]
