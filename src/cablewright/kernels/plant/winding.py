"""Simulated winches: motors that follow commanded speeds, and drums whose turns of cable differ in radius."""

from math import cos, exp, floor, nan, pi, sin, sqrt

from cablewright.kernels import jit

TURN = 6.283185307179586

# Columns of a winch. Angles are of the drum, wound cable counted positive; speeds pay out.
ANGLE, SPEED = 0, 1  # rad, rad/s
HELD = 2  # m: all cable of the winch, wound or paid out
HEIGHT = 3  # m: from the winch to the sheave; 0 where the dead span is not modelled
MIDDLE = 4  # m: radius at which the dead span is upright
STRAIN = 5  # of the cable, but for elasticity
OFFSET = 6  # m: length that is out besides
RATIO = 7  # of the pull on the drum, of all cables of the line, to a tension of *tensions*
BRAKE = 8  # N m: what its closed brake holds; 0: it is open, or never gives
SOFT = 9  # m/N: by which its line stretches per pull on the drum; of a closed brake
SLIPPED = 10  # rad: paid out against its brake
PULL = 11  # N: on the drum half way through the last step of a closed brake; 0: none known
SLIP, SLIP_BEFORE = 12, 13  # m: paid out against it in that step, and in the one before
CROSSING = 14  # m: height of the bump where a cable crosses the turn below it, once a turn; 0: none
CROSSING_FROM = 15  # turns wound, from which turns cross others
CROSSING_AT, CROSSING_SPAN = 16, 17  # share of a turn at which a bump begins, and that it takes
HOST = 18  # row of the line whose drum it is: its own, or another's; less than 0 of a line without a winch
SENSE = 19  # 1: paid out together with the host, -1: wound up then
ZERO = 20  # rad: its angle where that of the host is 0
MATES = 21  # number of further lines on its drum
WINCH = 22

# Entries of a motor, at its drum.
MAX_SPEED, LAG, MAX_TORQUE = 0, 1, 2  # rad/s, s, N m

LIMITED, STALLED, DRUM_END = 1, 2, 4  # flags of a winch, combined by or


@jit
def turn_winches(winches, motor, radii, wound, sideways, speeds, tensions, dt, lengths, flags):
    """Turn all drums for *dt* (s) towards the commanded *speeds* (m,), rad/s, and write the line *lengths* (m,).

    A row is a line with its cable on a drum; speeds and flags of lines on another's drum are not read. Lengths of lines
    without a winch stay.

    *radii*, *wound* and *sideways* (m, k), m: radius, wound length and position along the drum after each turn;
    *tensions* (m,), N, of one cable of each line: the load of the motors. *flags* (m,) receive LIMITED, STALLED and
    DRUM_END.
    """
    keep = exp(-dt / motor[LAG]) if motor[LAG] > 0.0 else 0.0
    for i in range(winches.shape[0]):
        own = winches[i]
        if int(own[HOST]) != i:
            continue
        target = min(max(speeds[i], -motor[MAX_SPEED]), motor[MAX_SPEED])
        if target != speeds[i]:
            flags[i] |= LIMITED
        torque = torque_of(winches, radii, tensions, i)
        if (target < 0.0 and torque > motor[MAX_TORQUE]) or (target > 0.0 and -torque > motor[MAX_TORQUE]):
            target = 0.0
            flags[i] |= STALLED
        turned = target * dt + (own[SPEED] - target) * motor[LAG] * (1.0 - keep)
        own[SPEED] = target + (own[SPEED] - target) * keep
        angle = own[ANGLE] - turned
        if own[BRAKE] > 0.0:
            radius = radius_at(own, radii[i])
            slip = min(slip_of(own, radius, torque / radius), max(angle, 0.0))
            own[SLIPPED] += slip
            angle -= slip
        last = TURN * (radii.shape[1] - 1)
        if angle < 0.0 or angle > last:
            angle = min(max(angle, 0.0), last)
            own[SPEED] = 0.0
            flags[i] |= DRUM_END
        own[ANGLE] = angle
        lengths[i] = length_out(own, radii[i], wound[i], sideways[i])
    for i in range(winches.shape[0]):
        own, host = winches[i], int(winches[i, HOST])
        if host < 0 or host == i:
            continue
        angle = own[ZERO] + own[SENSE] * winches[host, ANGLE]
        own[ANGLE] = min(max(angle, 0.0), TURN * (radii.shape[1] - 1))
        if own[ANGLE] != angle:
            flags[host] |= DRUM_END
        lengths[i] = length_out(own, radii[i], wound[i], sideways[i])


@jit
def torque_of(winches, radii, tensions, i):
    """Return the torque, N m, of all cables on the winch drum of line *i*; a positive one pays out."""
    own = winches[i]
    torque = tensions[i] * own[RATIO] * radius_at(own, radii[i])
    if own[MATES] > 0.0:
        for j in range(winches.shape[0]):
            if j != i and int(winches[j, HOST]) == i:
                torque += winches[j, SENSE] * tensions[j] * winches[j, RATIO] * radius_at(winches[j], radii[j])
    return torque


@jit
def slip_of(own, radius, pull):
    """Return the angle (rad) by which a drum slips in its closed brake under a *pull* (N), until the brake holds.

    Coulomb friction of a drum without inertia, which a line can only pay out: the length that stretches the line beyond
    the force of the brake, and by which its ends move apart. Where the last pull is known, a pull is that half way
    through a step (`dynamics.midpoint_step`): two of them and the length paid out give the motion of the ends and the
    present pull.
    """
    apart, over = 0.0, own[SOFT] * (pull - own[BRAKE] / radius)
    if own[PULL] > 0.0:
        apart = own[SOFT] * (pull - own[PULL]) + 0.5 * (own[SLIP] + own[SLIP_BEFORE])
        over += 0.5 * (apart - own[SLIP])
    own[PULL] = pull
    own[SLIP_BEFORE] = own[SLIP]
    own[SLIP] = max(over + apart, 0.0) if over > 0.0 else 0.0
    return own[SLIP] / radius


@jit
def radius_at(own, radii):
    """Return the radius (m) at which cable leaves a winch drum."""
    turn = min(int(own[ANGLE] / TURN), radii.shape[0] - 2)
    share = own[ANGLE] / TURN - turn
    return radii[turn] + share * (radii[turn + 1] - radii[turn]) + crossing(own, turn, share)[0]


@jit
def leaving(winches, radii, found):
    """Write the radii (m,), m, at which all lines leave their drums to *found*; 0 of a line without one."""
    for i in range(winches.shape[0]):
        found[i] = radius_at(winches[i], radii[i])


@jit
def paid_out(radii, wound, turns, before, now, found):
    """Write the lengths (m,), m, paid out between two angles wound, *before* and *now* (m,), rad, to *found*.

    *radii* and *wound* (m, k), m, after each of so many *turns* (m,) of a drum; 0: of a line without one, 0 then.
    Returns whether the drums hold the angles.
    """
    for i in range(turns.shape[0]):
        found[i] = 0.0
        if turns[i] > 0:
            last = turns[i] * TURN
            if not (0.0 <= before[i] <= last and 0.0 <= now[i] <= last):
                return False
            found[i] = _wound_at(radii[i], wound[i], turns[i], before[i]) - _wound_at(
                radii[i], wound[i], turns[i], now[i]
            )
    return True


@jit
def _wound_at(radii, wound, turns, angle):
    """Return the length of cable, m, on a drum with *angle*, rad, wound."""
    whole = min(int(angle / TURN), turns - 1)
    share, rise = angle / TURN - whole, radii[whole + 1] - radii[whole]
    return wound[whole] + TURN * share * (radii[whole] + 0.5 * share * rise)


@jit
def radii_by(radii, turns, angles, found):
    """Write the radii (m,), m, at which cables leave their winch drums with *angles* (m,), rad, wound.

    NaN for a line without a drum.
    """
    for i in range(turns.shape[0]):
        found[i] = nan
        if turns[i] > 0:
            turn = min(max(angles[i] / TURN, 0.0), float(turns[i]))
            whole = min(int(turn), turns[i] - 1)
            found[i] = radii[i, whole] + (turn - whole) * (radii[i, whole + 1] - radii[i, whole])


@jit
def count(winches, hosts, begin, counts_per_turn, counts):
    """Write the encoder *counts* (w,) of the motors of *hosts* (w,) since their drum angles were *begin* (m,), rad.

    Paying out counts up. *counts_per_turn* (2,): turns of a motor per radian of its drum, and counts of its turn.
    """
    for j in range(hosts.shape[0]):
        turned = begin[hosts[j]] - winches[hosts[j], ANGLE]
        counts[j] = floor(turned * counts_per_turn[0] * counts_per_turn[1])


@jit
def crossing(own, turn, share):
    """Return by how much a cable is lifted where it crosses the turn below, m, and the length wound by that, m.

    *share*: position in a *turn*. The lift is a bump in each turn, a raised cosine, whose integral over a turn is half
    its height times the angle that it takes.
    """
    if own[CROSSING] == 0.0 or turn < own[CROSSING_FROM]:
        return 0.0, 0.0
    u = min(max((share - own[CROSSING_AT]) / own[CROSSING_SPAN], 0.0), 1.0)
    passed = turn - own[CROSSING_FROM] + u - sin(2.0 * pi * u) / (2.0 * pi)
    half = 0.5 * own[CROSSING]
    return half * (1.0 - cos(2.0 * pi * u)), half * own[CROSSING_SPAN] * TURN * passed


@jit
def length_out(own, radii, wound, sideways):
    """Unstrained length (m) from the winch's nominal exit to the platform: cable not wound, less the detour.

    The detour is the extra length of a dead span that is not upright, since the cable leaves the drum elsewhere.
    """
    turn = min(int(own[ANGLE] / TURN), radii.shape[0] - 2)
    share = own[ANGLE] / TURN - turn
    over, more = crossing(own, turn, share)
    radius = radii[turn] + share * (radii[turn + 1] - radii[turn]) + over
    on_drum = wound[turn] + TURN * share * (radii[turn] + 0.5 * share * (radii[turn + 1] - radii[turn])) + more
    aside = sideways[turn] + share * (sideways[turn + 1] - sideways[turn])
    off = radius - own[MIDDLE]
    detour = 0.0
    if own[HEIGHT] > 0.0:
        detour = sqrt(own[HEIGHT] ** 2 + aside * aside + off * off) - own[HEIGHT]
    return (own[HELD] - on_drum) * (1.0 + own[STRAIN]) - detour + own[OFFSET]
