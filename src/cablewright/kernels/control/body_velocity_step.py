"""One step of the velocity control of a rigid platform with a winch for each line: rates of the cable lengths."""

from math import exp, inf, isfinite, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.control.point_velocity_step import is_same, solve_held
from cablewright.kernels.dense_systems import solve
from cablewright.kernels.layout import OK, PARAMETERS, TAU, WEIGHT, WRENCH, Packed
from cablewright.kernels.motion.inertia import push
from cablewright.kernels.statics.inverse_scratch import inverse_workspace
from cablewright.kernels.statics.line.upright import SLACK_TENSION, lengths_of
from cablewright.kernels.statics.linearise import linearise
from cablewright.kernels.statics.platform import between, shift_pose
from cablewright.kernels.statics.taut import FOUND, SOFTNESS, STRETCH, WHOLE, draw, soften


class BodyGains(NamedTuple):
    """Gains, limits and the mass of the control of a rigid platform, see `VelocitySettings`."""

    gain: float  # 1/s
    most: float  # m/s, of a correction
    lag: float  # s
    mass: float  # kg
    centre: NDArray[np.float64]  # (3,) m, of the mass, platform frame


class HeldStep(NamedTuple):
    """How lengths hold the platform now, row 0, and after the step, row 1."""

    poses: NDArray[np.float64]  # (2, 6) m and rad
    wrenches: NDArray[np.float64]  # (2, 6) N and N m, by which it is accelerated
    states: NDArray[np.float64]  # (2, m, 6) of the lines
    lengths: NDArray[np.float64]  # (2, m) m
    tensions: NDArray[np.float64]  # (2, m) N


@jit(allocates=True)
def hold(row, gains, velocity, accelerations, dt, near, at, known, held):
    """Solve for the lengths that hold the platform at the first of the *held* poses, and after *dt*, s; write *held*.

    *row*: the robot, a batch of one row. *velocity* (6,): m/s and rad/s; *accelerations* (2, 3), m/s^2: now and after
    *dt*. *near* (m, 6): states of the lines, where *known*, *at* (2, 6) a pose and an acceleration: those with which
    the next step begins, unless the path changes. Returns whether lengths hold both.
    """
    own = Packed(row.freedoms, row.lines[0], row.platform[0].copy(), row.general)
    work = inverse_workspace(own)
    held.poses[1] = held.poses[0]
    shift_pose(held.poses[1], dt * velocity)
    push(held.poses, accelerations, gains.mass, gains.centre, held.wrenches)
    held.states[0] = near
    goes_on = known and is_same(held.poses[0], at[0]) and is_same(accelerations[0], at[1, :3])
    for j in range(2):
        for k in range(6):
            own.platform[WRENCH + k] = row.platform[0, WRENCH + k] + held.wrenches[j, k]
        if j == 1:
            held.states[1] = held.states[0]
        solved = j == 0 and goes_on
        if not solved and solve_held(own, held.poses[j], held.states[j], work, known or j == 1) != OK:
            return False
        lengths_of(own, held.states[j], held.lengths[j])
        for i in range(own.lines.shape[0]):
            tension = exp(held.states[j, i, TAU])
            unstrained = own.lines[i, WEIGHT] == 0.0 and tension < 2.0 * SLACK_TENSION
            held.tensions[j, i] = 0.0 if unstrained else tension
    near[:], at[0], at[1, :3] = held.states[1], held.poses[1], accelerations[1]
    return True


@jit(allocates=True)
def pursue(row, packed, gains, held, reached, share, tensions, delay, dt, chosen, rates):
    """Write the *rates* (m,), m/s, of the lengths that follow the *held* ones from where the platform is.

    *reached* (6,): that pose; *share*: of the speed of the path at which it moves. *tensions* (m,), N, estimated, or
    empty, are those *delay*, s, before. The pose decides what moves the platform, tensions what does not: the changes
    of stretch that they show, less the motion by their wrench. *chosen* (m,), N, become the tensions that the path
    wants. Returns the largest error of a tension, N, inf where one is not known; NaN where there are no rates.
    """
    m, error = rates.shape[0], inf
    found, planes, toward, per_motion = np.empty((m, FOUND)), np.empty((m, 4)), np.empty((m, 3)), np.empty((m, 6))
    draw(packed, reached, found, planes, toward, per_motion)
    motion, change = np.empty(6), share * (held.tensions[1] - held.tensions[0]) / dt
    between(reached, held.poses[0], motion)
    chosen[:] = held.tensions[0] - gains.lag * change
    rates[:] = 0.0
    if tensions.shape[0] > 0:
        off = tensions + delay * change - held.tensions[0]
        if np.isfinite(off).all():
            error = np.abs(off).max()
        if m > 6:
            if not _yield(row, held, off, per_motion, motion):
                return np.nan
            softness = np.empty((m, SOFTNESS))
            soften(packed.lines, found[:, WHOLE].copy(), toward, softness)
            rates[:] = softness[:, STRETCH] * off
    gain, size = min(gains.gain, 0.5 / dt), 0.0
    for i in range(m):
        for k in range(6):
            rates[i] += per_motion[i, k] * motion[k]
        rates[i] *= gain
        size += rates[i] ** 2
    if not isfinite(size):
        return np.nan
    shorter = min(1.0, gains.most / max(sqrt(size), 1e-300))
    for i in range(m):
        rates[i] = shorter * rates[i] + (held.lengths[1, i] - held.lengths[0, i]) / dt
    return error


@jit(allocates=True)
def _yield(row, held, off, per_motion, motion):
    """Take from *motion* (6,) that by the wrench of tensions *off* (m,), N, at *held* lengths; False if singular."""
    own, m = Packed(row.freedoms, row.lines[0], row.platform[0].copy(), row.general), off.shape[0]
    for k in range(6):
        own.platform[WRENCH + k] += held.wrenches[0, k]
    stiffness, by_lines, wrench = np.empty((6, 6)), np.empty((6, m, PARAMETERS)), np.zeros((6, 1))
    work = inverse_workspace(own).base
    if linearise(own, held.lengths[0], held.poses[0], held.states[0], work, stiffness, by_lines) != OK:
        return False
    for k in range(6):
        for i in range(m):
            wrench[k, 0] += per_motion[i, k] * off[i]
    if not solve(stiffness, wrench, 6, 1):
        return False
    for k in range(6):
        motion[k] -= wrench[k, 0]
    return True
