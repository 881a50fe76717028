"""One step of the velocity control of a point platform: rates of the cable lengths."""

from math import exp, hypot, isfinite, sqrt
from typing import NamedTuple

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.control.length_change_split import split
from cablewright.kernels.layout import NOT_CONVERGED, OK, PREFERRED, TAU, WRENCH, Packed
from cablewright.kernels.rotation import matrix
from cablewright.kernels.statics.inverse import solve_inverse
from cablewright.kernels.statics.inverse_scratch import inverse_workspace
from cablewright.kernels.statics.line.upright import lengths_of
from cablewright.kernels.statics.taut import FOUND, SOFTNESS, STRETCH, WHOLE, draw, soften

# Rows of the lengths that `hold` writes: at rest at the target, and now and after the step, pushed and at rest.
REST, PUSHED, PUSHED_THEN, NOW, THEN = 0, 1, 2, 3, 4
HELD = 5
SAME = 1e-14  # m or m/s^2, and of a larger number: rounding of a target that goes on

# Numbers of `steer`: mass, kg; share, velocity and largest speed of `calm`, the first 0 without; limit of drums, rad/s.
MASS, SHARE, FASTER, MOST, LIMIT = 0, 1, 2, 3, 4


class PointGains(NamedTuple):
    """Gains and limits of the control of a point, see `VelocitySettings` and `SlackSettings`."""

    gain: float  # 1/s
    most: float  # m/s, of a correction
    internal_gain: float  # 1/s
    planned_excess: float  # m
    switch_margin: float  # share of the mean tension
    excess_rate: float  # m/s
    manages: bool  # one line is slack on purpose
    by_lengths: bool


@jit(allocates=True)
def hold(packed, mass, position, velocity, accelerations, dt, near, at, known, lengths, tensions):
    """Compute the cable lengths (HELD, m), m, and tensions (m,), N, that hold a point of *mass*, kg, on its path.

    *packed* is a batch of one row. *accelerations* (2, 3), m/s^2: now and after *dt*, s. The rows of a point that is
    not accelerated are 0. NaN where no tensions hold it. *near* (2, m, 6): states of the lines at rest and pushed, of
    which *known* are known, *at* (2, 3) a position, m, and an acceleration, m/s^2: those with which the next step
    begins, unless the path changes. Returns how many of them are known.
    """
    m = packed.lines.shape[1]
    own = Packed(packed.freedoms, packed.lines[0], packed.platform[0].copy(), packed.general)
    work, pose = inverse_workspace(own), position.copy()
    at_rest = near[0].copy()
    goes_on = known > 0 and is_same(position, at[0])
    held = goes_on or solve_held(own, pose, at_rest, work, known > 0) == OK
    lengths_of(own, at_rest, lengths[REST])
    for i in range(m):
        tensions[i] = exp(at_rest[i, TAU])
    lengths[PUSHED:] = 0.0
    moves = accelerations.any()
    if moves:
        lengths[NOW] = lengths[REST]
        if known < 2:
            near[1] = at_rest
        _push(own, packed, -mass, accelerations[0])
        pushed = goes_on and known > 1 and is_same(accelerations[0], at[1])
        pushed = pushed or solve_held(own, pose, near[1], work, held or known > 1) == OK
        lengths_of(own, near[1], lengths[PUSHED])
        for k in range(3):
            pose[k] += dt * velocity[k]
        _push(own, packed, -mass, accelerations[1])
        pushed = solve_held(own, pose, near[1], work, pushed) == OK
        lengths_of(own, near[1], lengths[PUSHED_THEN])
        _push(own, packed, 0.0, accelerations[1])
        near[0] = at_rest
        stays = solve_held(own, pose, near[0], work, held) == OK
        lengths_of(own, near[0], lengths[THEN])
        if stays:
            at[0], at[1] = pose, accelerations[1]
            return 2 if pushed else 1
    near[0], at[0] = at_rest, position
    return 1 if held else 0


@jit
def is_same(vector, other):
    """Return whether two vectors (n,) are the same but for rounding."""
    for k in range(vector.shape[0]):
        if not abs(vector[k] - other[k]) <= SAME * max(1.0, abs(vector[k])):
            return False
    return True


@jit
def _push(own, packed, share, acceleration):
    """Add a *share*, kg, of an *acceleration* (3,), m/s^2, to the force on the platform."""
    for k in range(3):
        own.platform[WRENCH + k] = packed.platform[0, WRENCH + k] + share * acceleration[k]


@jit(allocates=True)
def solve_held(own, pose, states, work, known):
    """Solve for the *states* (m, 6), from their values where these are *known*; near no tensions if all else fails."""
    code, _ = solve_inverse(own, pose, states, work, known)
    if known and code != OK:
        code, _ = solve_inverse(own, pose, states, work, False)
    if code == NOT_CONVERGED:
        bare = Packed(own.freedoms, own.lines.copy(), own.platform, own.general)
        bare.lines[:, PREFERRED] = 0.0
        code, _ = solve_inverse(bare, pose, states, work, False)
    return code


@jit(allocates=True)
def follow(packed, free, gains, held, position, target, velocity, swing, dt, rates):
    """Write the rates (m,), m/s, of the lengths that move a point to its *target* (3,), m, at a *velocity* (3,), m/s.

    *free* (3, p): motions that it may make. *held* (HELD, m): lengths, see `hold`; *swing* (3,), m/s: velocity at which
    it follows its swinging platform. Returns directions (m, 3) and lengths (m,), m, of straight lines in the middle of
    the step.
    """
    m = packed.lines.shape[0]
    middle, found, planes = position + 0.5 * dt * velocity, np.empty((m, FOUND)), np.empty((m, 4))
    toward, per_motion = np.empty((m, 3)), np.empty((m, 3))
    draw(packed, middle, found, planes, toward, per_motion)
    lead, leading = np.zeros(m), np.zeros(m)
    if np.isfinite(held[PUSHED:]).all():
        for i in range(m):
            lead[i] = held[PUSHED, i] - held[NOW, i]
            leading[i] = (held[PUSHED_THEN, i] - held[THEN, i] - lead[i]) / dt
    error = target - position
    if gains.by_lengths and lead.any():  # the estimate takes what lengths lead by for a motion of the platform
        moving, motion = np.empty(m), np.empty(free.shape[1])
        work = _gradients(toward, free)
        work[:, -1] = lead
        split(work, moving, motion)
        for k in range(3):
            for j in range(free.shape[1]):
                error[k] += free[k, j] * motion[j]
    share, size = min(gains.gain, 0.5 / dt), 0.0
    for k in range(3):
        size += (share * error[k]) ** 2
    size = sqrt(size)
    if size > gains.most:
        share *= gains.most / size
    for i in range(m):
        rates[i] = leading[i]
        for k in range(3):
            rates[i] += toward[i, k] * (velocity[k] + share * error[k] + swing[k])
    return toward, found[:, WHOLE].copy()


@jit(allocates=True)
def pursue(
    packed, hosts, free, gains, held, chosen, rest, position, target, velocity, swing, excess, tensions, dt,
    planned, line, rates,
):  # fmt: skip
    """Write the *rates* (m,), m/s, of the lengths that follow the path and balance the tensions.

    They are those of `follow` and `balance`; *rest* (3,), m: position at which *held* lengths hold the point. Returns
    whether all lines have tangents, and the largest error of a tension, see `balance`.
    """
    toward, whole = follow(packed, free, gains, held, position, target, velocity, swing, dt, rates)
    if not np.isfinite(toward).all():
        return False, np.nan
    return True, balance(
        packed, hosts, free, gains, held, chosen, toward, whole, rest, excess, tensions, dt, planned, line, rates
    )


@jit(allocates=True)
def calm(rotation, mean, share, faster, most):
    """Return the velocity (x, y), m/s, at which a point follows the platform that swings below it, to damp the swing.

    *rotation* (3,), rad: of that platform. *mean* (2,): mean direction of its axis in plan view, NaN at first; it moves
    to the present one by a *share*. *faster*: m/s for each unit of their difference; *most*: largest speed, m/s.
    """
    turned = np.empty((3, 3))
    matrix(rotation, turned)
    x, y = -turned[0, 2], -turned[1, 2]
    if np.isnan(mean[0]) or np.isnan(mean[1]):
        mean[0], mean[1] = x, y
    mean[0] += (x - mean[0]) * share
    mean[1] += (y - mean[1]) * share
    size = faster * hypot(x - mean[0], y - mean[1])
    if size > most:
        faster *= most / size
    return faster * (x - mean[0]), faster * (y - mean[1])


@jit(allocates=True)
def balance(
    packed, hosts, free, gains, held, chosen, toward, whole, target, excess, tensions, dt, planned, line, rates
):
    """Add to *rates* (m,) changes of length that bring the tensions to *chosen* ones (m,), N, or leave a line slack.

    *hosts* (w,): lines with a winch. *toward*, *whole*: of `follow`. *excess* (m,), m, is estimated, and *tensions*
    (m,), N, or empty, are measured. *planned* (m,), m, and the slack *line* (1,) change. Returns the largest error of a
    tension, N; inf: one is not known, and counts as right; NaN: none chosen.
    """
    m = packed.lines.shape[0]
    for i in range(m):
        if not isfinite(held[REST, i]):
            return np.nan
    softness, error, most = np.empty((m, SOFTNESS)), np.empty(m), 0.0
    soften(packed.lines, whole, toward, softness)
    if gains.manages:
        _choose(gains, chosen, line)
        for i in range(m):
            goal, change = gains.planned_excess if i == line[0] else 0.0, gains.excess_rate * dt
            planned[i] += min(max(goal - planned[i], -change), change)
    if gains.manages or tensions.shape[0] == 0:
        found, planes, there = np.empty((m, FOUND)), np.empty((m, 4)), np.empty((m, 3))
        draw(packed, target, found, planes, there, there.copy())
        for i in range(m):
            error[i] = held[REST, i] - found[i, WHOLE] + planned[i] - excess[i]
    else:
        for i in range(m):
            error[i] = softness[i, STRETCH] * (tensions[i] - chosen[i])
    for i in range(m):
        if not isfinite(error[i]):
            error[i], most = 0.0, np.inf
    own, moving, motion = error[hosts], np.empty(hosts.shape[0]), np.empty(free.shape[1])
    work = _gradients(toward, free)[hosts]
    work[:, -1] = own
    split(work, moving, motion)
    gain = min(gains.internal_gain, 0.5 / dt)
    for j in range(hosts.shape[0]):
        off = own[j] - moving[j]
        most = max(most, abs(off / softness[hosts[j], STRETCH]))
        rates[hosts[j]] += min(max(gain * off, -gains.most), gains.most)
    return np.nan if gains.manages else most


@jit(allocates=True)
def steer(
    plain, packed, hosts, free, gains, swing, mean, position, velocity, accelerations, estimated, tensions, dt, delay,
    known, near, at, moving, planned, line, chosen, speeds,
):  # fmt: skip
    """Write the speeds (w,), rad/s, of the drums that `pursue` a target, with lengths as of `hold`.

    *plain*: a batch of one row, see `hold`. *swing* (5,), see SWING: platform and limits; *mean* (2,): see `calm`.
    *estimated* (6 + 3 m,): position, rotation, excess, lengths and radii at the drums; *delay*, s, for which the point
    goes on at *moving* (6,). *chosen* (m,), N, become the tensions at rest. Returns how many of the states *near* are
    known, whether the speeds are, the largest error of a tension, and the share of the speeds that their limit allows.
    """
    m = packed.lines.shape[0]
    lengths, rates, turned, place = np.empty((HELD, m)), np.empty(m), np.zeros(3), np.empty(3)
    excess = estimated[6 : 6 + m]
    speeds[:] = 0.0
    for i in range(m):
        if not isfinite(estimated[6 + m + i]):
            return known, False, np.nan, 0.0
    known = hold(plain, swing[MASS], position, velocity, accelerations, dt, near, at, known, lengths, chosen)
    if swing[SHARE] > 0.0:
        turned[0], turned[1] = calm(estimated[3:6], mean, swing[SHARE], swing[FASTER], swing[MOST])
    for k in range(3):
        place[k] = estimated[k] + delay * moving[k]
    drawn, error = pursue(
        packed, hosts, free, gains, lengths, chosen, position, place, position, velocity, turned, excess, tensions, dt,
        planned, line, rates,
    )  # fmt: skip
    if not drawn:
        return known, False, np.nan, 0.0
    fastest = 1e-300
    for j in range(hosts.shape[0]):
        speeds[j] = rates[hosts[j]] / estimated[6 + 2 * m + hosts[j]]
        fastest = max(fastest, abs(speeds[j]))
    share = min(1.0, swing[LIMIT] / fastest)
    for j in range(hosts.shape[0]):
        speeds[j] *= share
    return known, True, error, share


@jit
def _choose(gains, chosen, line):
    """Choose the slack line: that of the smallest tension, or the present one within the switch margin."""
    smallest, mean = 0, 0.0
    for i in range(chosen.shape[0]):
        mean += chosen[i] / chosen.shape[0]
        if chosen[i] < chosen[smallest]:
            smallest = i
    if line[0] < 0 or chosen[line[0]] - chosen[smallest] > gains.switch_margin * mean:
        line[0] = smallest


@jit(allocates=True)
def _gradients(toward, free):
    """The gradients (m, p + 1) of the lengths by the motions that are *free* (3, p), and a column of zeros."""
    found = np.zeros((toward.shape[0], free.shape[1] + 1))
    for i in range(found.shape[0]):
        for j in range(free.shape[1]):
            for k in range(3):
                found[i, j] += toward[i, k] * free[k, j]
    return found
