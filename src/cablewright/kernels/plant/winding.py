"""Winches: a motor that follows a wanted speed, and cable that is wound on a drum turn by turn, none like the other."""

from math import exp, sqrt

from cablewright.kernels import jit

TURN = 6.283185307179586

# Columns of a winch. Angles are of the drum, wound cable counted positive; speeds pay out.
ANGLE, SPEED = 0, 1  # rad, rad/s
HELD = 2  # m: all cable of the winch, wound or out
HEIGHT = 3  # m: from the winch to the sheave; 0 where the dead span is not modelled
MIDDLE = 4  # m: radius at which the dead span is upright
STRAIN = 5  # of the cable, by warmth
WINCH = 6

# Entries of a motor, by its drum.
MOST_SPEED, LAG, MOST_TORQUE = 0, 1, 2  # rad/s, s, N m
MOTOR = 3

LIMITED, STALLED, DRUM_END = 1, 2, 4  # what a winch says, added up


@jit
def turn_winches(winches, motor, radii, wound, sideways, asked, tensions, dt, lengths, says):
    """Turn all drums for *dt* (s) towards the speeds *asked* (m,), rad/s, and set the *lengths* (m,) they leave.

    *radii*, *wound* and *sideways* (m, k), m, hold radius, wound length and place along the drum after each turn;
    *tensions* (m,), N, what the motors pull against. *says* (m,) gets the sum of what there is to say.
    """
    keep = exp(-dt / motor[LAG]) if motor[LAG] > 0.0 else 0.0
    for i in range(winches.shape[0]):
        own = winches[i]
        wanted = min(max(asked[i], -motor[MOST_SPEED]), motor[MOST_SPEED])
        if wanted != asked[i]:
            says[i] |= LIMITED
        if wanted < 0.0 and tensions[i] * radius_at(radii[i], own[ANGLE]) > motor[MOST_TORQUE]:
            wanted = 0.0
            says[i] |= STALLED
        turned = wanted * dt + (own[SPEED] - wanted) * motor[LAG] * (1.0 - keep)
        own[SPEED] = wanted + (own[SPEED] - wanted) * keep
        angle = own[ANGLE] - turned
        last = TURN * (radii.shape[1] - 1)
        if angle < 0.0 or angle > last:
            angle = min(max(angle, 0.0), last)
            own[SPEED] = 0.0
            says[i] |= DRUM_END
        own[ANGLE] = angle
        lengths[i] = length_out(own, radii[i], wound[i], sideways[i])


@jit
def radius_at(radii, angle):
    """Radius (m) at which cable leaves a drum with *angle* (rad) wound."""
    turn = min(int(angle / TURN), radii.shape[0] - 2)
    share = angle / TURN - turn
    return radii[turn] + share * (radii[turn + 1] - radii[turn])


@jit
def length_out(own, radii, wound, sideways):
    """Unstrained length (m) from the winch's nominal exit to the platform: what is not wound, less the detour."""
    turn = min(int(own[ANGLE] / TURN), radii.shape[0] - 2)
    share = own[ANGLE] / TURN - turn
    radius = radii[turn] + share * (radii[turn + 1] - radii[turn])
    on_drum = wound[turn] + TURN * share * (radii[turn] + 0.5 * share * (radii[turn + 1] - radii[turn]))
    aside = sideways[turn] + share * (sideways[turn + 1] - sideways[turn])
    off = radius - own[MIDDLE]
    detour = 0.0
    if own[HEIGHT] > 0.0:
        detour = sqrt(own[HEIGHT] ** 2 + aside * aside + off * off) - own[HEIGHT]
    return (own[HELD] - on_drum) * (1.0 + own[STRAIN]) - detour
