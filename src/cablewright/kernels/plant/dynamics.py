"""Platform dynamics: a rigid body on quasi-static lines.

A line weighs little beside the body and its waves pass in milliseconds: at each moment it has its static shape, and
only the body has inertia. One step of the implicit midpoint rule is the Newton iteration of `equilibrium` with the
body's mass in the platform's balance: see `docs/decisions/0009-implicit-midpoint.md`. A drum that hangs from a point
platform, where all lines meet, is a body on whose lines its rotation does nothing: the lines' balance then has three
rows instead of six.
"""

from math import atan2, inf, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import copy, solve
from cablewright.kernels.layout import (
    MASS_X,
    NORMAL,
    NOT_CONVERGED,
    NOT_FINITE,
    OK,
    PLATFORM_WEIGHT,
    SINGULAR,
)
from cablewright.kernels.plant.counterweights import COUNTERWEIGHT, HELD
from cablewright.kernels.rotation import compose, matrix, rotate
from cablewright.kernels.statics.equilibrium import evaluate, workspace
from cablewright.kernels.statics.line.interface import advance_line, condense_line, condense_moving_line
from cablewright.kernels.statics.line.upright import is_slack
from cablewright.kernels.statics.platform import (
    add_turning,
    hold,
    is_held,
    pose_of,
    weight_without_moment,
)

STEPS = 30
MOVE_TOLERANCE = 1e-9  # m and rad: size of the last Newton step of the midpoint
LENGTH_TOLERANCE = 1e-7  # m: residual of the line equations before that step, which squares it

# Entries of a body, in its own frame, whose origin is the platform's; of a drum the lines' point, with z up its axis.
MASS = 0  # kg, total
CENTRE = 1  # 1..3: m, of mass
INERTIA = 4  # 4..12: kg m^2, tensor about the origin, row by row
DRAG = 13  # N s/m on the origin's speed
SWING_DAMPING, YAW_DAMPING = 14, 15  # N m s
YAW_STIFFNESS, YAW_REST = 16, 17  # N m/rad, rad
RELAXATION = 18  # s: a line's force increases by this time the rate of its elastic force (Kelvin-Voigt)
THRUST = 19  # 19..21: N, mass times relative acceleration of a part that moves along the body
MOMENTUM = 22  # 22..24: kg m/s, its mass times its relative velocity
PART = 25  # 25..27: m, its centre
BODY = 28

# Entries of a motion: of the body's origin, and of the body about it, in world axes.
PLACE, VELOCITY, TURN, RATE = 0, 3, 6, 9  # m, m/s, rotation vector rad, rad/s
MOTION = 12


class Swing(NamedTuple):
    """Working memory of the dynamics of one body with n degrees of freedom.

    n is 6, or 3 of a body that hangs from a point platform.
    """

    system: NDArray[np.float64]  # (6, 6)
    rhs: NDArray[np.float64]  # (6, 1)
    middle: NDArray[np.float64]  # (MOTION,): the motion at the midpoint of the step
    rotation: NDArray[np.float64]  # (3, 3)
    inertia: NDArray[np.float64]  # (3, 3), world
    move: NDArray[np.float64]  # (n, 1)
    lengths: NDArray[np.float64]  # (m,)
    place: NDArray[np.float64]  # (n,)
    pulled: NDArray[np.float64]  # (n,): rate of the lines' wrench due to the change of their lengths, N/s, N m/s
    turning: NDArray[np.float64]  # (3, 6): part of the stiffness against moments that is of forces on moving arms
    relaxing: NDArray[np.float64]  # (n, n): stiffness, without that of lines with a counterweight
    weights: NDArray[np.float64]  # (m, COUNTERWEIGHT): see `counterweights`
    ends: NDArray[np.float64]  # (m, 3): acceleration of each platform point in the last step, m/s^2
    on_plane: NDArray[np.float64]  # (2,): force on the platform's plane along its normal, N: last, and most so far


@jit(allocates=True)
def moving_workspace(packed):
    """Allocate a `Swing` for the lines of *packed*, the degrees of freedom of their balance, and those of the body."""
    n, m = packed.freedoms, packed.lines.shape[0]
    swing = Swing(
        np.zeros((6, 6)),
        np.zeros((6, 1)),
        np.zeros(MOTION),
        np.eye(3),
        np.eye(3),
        np.zeros((n, 1)),
        np.zeros(m),
        np.zeros(n),
        np.zeros(n),
        np.zeros((3, 6)),
        np.zeros((n, n)),
        np.zeros((m, COUNTERWEIGHT)),
        np.zeros((m, 3)),
        np.full(2, -inf),
    )
    return workspace(packed), swing


@jit
def midpoint_step(packed, body, motion, before, after, dt, states, work, swing):
    """Advance *motion* (MOTION,) by *dt* (s) while the lengths change linearly from *before* to *after* (m,).

    *packed* has the weight of the *body* (BODY,), and unless it is a point platform its centre of mass; *states* are
    those of the lines at the midpoint, updated in place. Returns a code; unless it is OK *motion* is unchanged.
    """
    middle = swing.middle
    copy(motion, middle)
    for i in range(before.shape[0]):
        swing.lengths[i] = 0.5 * (before[i] + after[i])
    code = NOT_CONVERGED
    for _ in range(STEPS):
        for k in range(3):
            middle[PLACE + k] = motion[PLACE + k] + 0.5 * dt * middle[VELOCITY + k]
            middle[TURN + k] = motion[TURN + k]
        compose(
            0.5 * dt * middle[RATE], 0.5 * dt * middle[RATE + 1], 0.5 * dt * middle[RATE + 2], middle[TURN : TURN + 3]
        )
        pose_of(middle[PLACE : PLACE + 3], middle[TURN : TURN + 3], swing.place)
        worst, unbalanced, _ = evaluate(packed, swing.lengths, swing.place, states, work)
        if not (worst == worst and unbalanced == unbalanced):
            return NOT_FINITE
        if not _condense(packed, before, after, dt, states, work, swing):
            return SINGULAR
        _assemble(packed, body, motion, dt, work, swing)
        _hold(packed, swing)
        if not solve(swing.system, swing.rhs, 6, 1):
            return SINGULAR
        move = _apply(packed, dt, states, work, swing)
        if move < MOVE_TOLERANCE and worst < LENGTH_TOLERANCE:
            code = OK
            break
    if code == OK:
        swing.on_plane[1] = max(swing.on_plane[0], swing.on_plane[1])
        for k in range(3):
            motion[PLACE + k] += dt * middle[VELOCITY + k]
            motion[VELOCITY + k] = 2.0 * middle[VELOCITY + k] - motion[VELOCITY + k]
            motion[RATE + k] = 2.0 * middle[RATE + k] - motion[RATE + k]
        compose(dt * middle[RATE], dt * middle[RATE + 1], dt * middle[RATE + 2], motion[TURN : TURN + 3])
    return code


@jit
def _condense(packed, before, after, dt, states, work, swing):
    """As `equilibrium.condense`, and set swing.pulled, swing.turning and swing.relaxing. False if singular.

    The cable of a counterweight does not relax: its length is not given.
    """
    pulled, turning, weights = swing.pulled, swing.turning, swing.weights
    pulled[:] = 0.0
    turning[:, :] = 0.0
    weigh(packed.platform, work.rotation, turning)
    for i in range(packed.lines.shape[0]):
        row, y = packed.lines[i], states[i]
        rate = (after[i] - before[i]) / dt
        if weights[i, HELD] > 0.0 or is_slack(row, y):
            continue
        if not condense_moving_line(row, y, i, rate, work, work.spatial, pulled, turning):
            return False
    for i in range(packed.freedoms):
        copy(work.stiffness[i], swing.relaxing[i])
    for i in range(packed.lines.shape[0]):
        row, y = packed.lines[i], states[i]
        if weights[i, HELD] > 0.0 and not is_slack(row, y) and not condense_line(row, y, i, work, work.spatial):
            return False
    return True


@jit
def weigh(platform, rotation, turning):
    """Add the contribution of the weight at the rotated centre of mass to the stiffness."""
    x, y, z = rotate(rotation, platform[MASS_X], platform[MASS_X + 1], platform[MASS_X + 2])
    add_turning(turning, 0, x, y, z, 0.0, 0.0, -platform[PLATFORM_WEIGHT])


@jit
def _assemble(packed, body, motion, dt, work, swing):
    """Write the Newton system of the body's balance at the midpoint: forces, then moments about its origin."""
    A, b, middle, R, J = swing.system, swing.rhs, swing.middle, swing.rotation, swing.inertia
    n = packed.freedoms
    matrix(middle[TURN : TURN + 3], R)
    turn_tensor(R, body[INERTIA : INERTIA + 9], J)
    mass, relax = body[MASS], body[RELAXATION]
    cx, cy, cz = rotate(R, body[CENTRE], body[CENTRE + 1], body[CENTRE + 2])
    wx, wy, wz = middle[RATE], middle[RATE + 1], middle[RATE + 2]
    inverse = 2.0 / dt
    A[:, :] = 0.0
    for i in range(3):
        A[i, i] = mass * inverse + body[DRAG]
        for j in range(3):
            A[3 + i, 3 + j] = J[i, j] * inverse
    for i in range(n):
        for j in range(n):
            A[i, j] += (0.5 * dt + relax) * swing.relaxing[i, j] + 0.5 * dt * (
                work.stiffness[i, j] - swing.relaxing[i, j]
            )
    _cross(A, 0, 3, -mass * inverse * cx, -mass * inverse * cy, -mass * inverse * cz)
    _cross(A, 3, 0, mass * inverse * cx, mass * inverse * cy, mass * inverse * cz)
    # right-hand side: applied forces less mass times acceleration
    for i in range(3):
        force = work.wrench[i] + relax * swing.pulled[i] - body[DRAG] * middle[VELOCITY + i]
        for j in range(3):
            force -= relax * swing.relaxing[i, j] * middle[VELOCITY + j]
        b[i, 0] = force - mass * inverse * (middle[VELOCITY + i] - motion[VELOCITY + i])
    ax = inverse * (middle[VELOCITY] - motion[VELOCITY])
    ay = inverse * (middle[VELOCITY + 1] - motion[VELOCITY + 1])
    az = inverse * (middle[VELOCITY + 2] - motion[VELOCITY + 2])
    az += weight_without_moment(packed) / mass
    ex = inverse * (wx - motion[RATE])
    ey = inverse * (wy - motion[RATE + 1])
    ez = inverse * (wz - motion[RATE + 2])
    dot, square = wx * cx + wy * cy + wz * cz, wx * wx + wy * wy + wz * wz
    b[0, 0] -= mass * (ey * cz - ez * cy + wx * dot - cx * square)
    b[1, 0] -= mass * (ez * cx - ex * cz + wy * dot - cy * square)
    b[2, 0] -= mass * (ex * cy - ey * cx + wz * dot - cz * square)
    hx, hy, hz = rotate(J, wx, wy, wz)
    tx, ty, tz = rotate(J, ex, ey, ez)
    b[3, 0] = -tx - (wy * hz - wz * hy) - mass * (cy * az - cz * ay)
    b[4, 0] = -ty - (wz * hx - wx * hz) - mass * (cz * ax - cx * az)
    b[5, 0] = -tz - (wx * hy - wy * hx) - mass * (cx * ay - cy * ax)
    damping = (body[SWING_DAMPING], body[SWING_DAMPING], body[YAW_DAMPING])
    for k in range(3):
        A[3 + k, 3 + k] += damping[k]
        b[3 + k, 0] -= damping[k] * middle[RATE + k]
    # the twisted lines are a weak spring about the vertical
    b[5, 0] -= body[YAW_STIFFNESS] * (atan2(R[1, 0], R[0, 0]) - body[YAW_REST])
    _add_moments(n - 3, relax, middle, work, swing)
    _add_part(body, wx, wy, wz, swing)


@jit
def _add_moments(moments, relax, middle, work, swing):
    """Add the lines' *moments*, 3 or none, and what rotation does to their forces."""
    A, b, turning = swing.system, swing.rhs, swing.turning
    for i in range(moments):
        for j in range(3):
            A[3 + i, j] -= relax * turning[i, j]
            A[3 + i, 3 + j] -= relax * turning[i, 3 + j]
            b[i, 0] -= relax * swing.relaxing[i, 3 + j] * middle[RATE + j]
        moment = work.wrench[3 + i] + relax * swing.pulled[3 + i]
        for j in range(3):
            moment -= relax * (swing.relaxing[3 + i, j] - turning[i, j]) * middle[VELOCITY + j]
            moment -= relax * (swing.relaxing[3 + i, 3 + j] - turning[i, 3 + j]) * middle[RATE + j]
        b[3 + i, 0] += moment


@jit
def _add_part(body, wx, wy, wz, swing):
    """Take off the force on a part that moves along the body: of its relative and its Coriolis acceleration."""
    b, R = swing.rhs, swing.rotation
    fx, fy, fz = rotate(R, body[THRUST], body[THRUST + 1], body[THRUST + 2])
    px, py, pz = rotate(R, body[MOMENTUM], body[MOMENTUM + 1], body[MOMENTUM + 2])
    fx += 2.0 * (wy * pz - wz * py)
    fy += 2.0 * (wz * px - wx * pz)
    fz += 2.0 * (wx * py - wy * px)
    rx, ry, rz = rotate(R, body[PART], body[PART + 1], body[PART + 2])
    b[0, 0] -= fx
    b[1, 0] -= fy
    b[2, 0] -= fz
    b[3, 0] -= ry * fz - rz * fy
    b[4, 0] -= rz * fx - rx * fz
    b[5, 0] -= rx * fy - ry * fx


@jit
def force_on_plane(packed, wrench):
    """Return the part along the normal of a *wrench* (n,) on the platform, N: positive lifts off. Only with a plane."""
    platform = packed.platform
    return platform[NORMAL] * wrench[0] + platform[NORMAL + 1] * wrench[1] + platform[NORMAL + 2] * wrench[2]


@jit
def _hold(packed, swing):
    """Leave the system in the directions that the platform's plane leaves free: a point does not turn there.

    The force on the plane is what the balance lacks across it, with the inertia.
    """
    if not is_held(packed.general, packed.platform):
        return
    wrench = swing.rhs.reshape(6)  # contiguous, as all that `hold` takes
    swing.on_plane[0] = force_on_plane(packed, wrench)
    if packed.freedoms == 3:
        for k in range(3, 6):
            wrench[k] = 0.0
            for j in range(6):
                swing.system[k, j] = swing.system[j, k] = 0.0
            swing.system[k, k] = 1.0
    hold(packed, wrench, swing.system)


@jit
def turn_tensor(R, tensor, turned):
    """Write a symmetric *tensor* (9,) of the body's frame in the world's axes: R T R^T."""
    for i in range(3):
        for j in range(3):
            turned[i, j] = 0.0
            for k in range(3):
                side = 0.0
                for each in range(3):
                    side += R[i, each] * tensor[3 * each + k]
                turned[i, j] += side * R[j, k]


@jit
def _cross(A, row, column, x, y, z):
    """Add the matrix of the cross product with (x, y, z) to a block of *A*."""
    A[row, column + 1] -= z
    A[row, column + 2] += y
    A[row + 1, column] += z
    A[row + 1, column + 2] -= x
    A[row + 2, column] -= y
    A[row + 2, column + 1] += x


@jit
def _apply(packed, dt, states, work, swing):
    """Take the Newton step in swing.rhs. Returns the size of the body's move, m and rad."""
    middle, step = swing.middle, swing.rhs
    size = 0.0
    for k in range(3):
        middle[VELOCITY + k] += step[k, 0]
        middle[RATE + k] += step[3 + k, 0]
        size += step[k, 0] ** 2 + step[3 + k, 0] ** 2
    for k in range(packed.freedoms):
        swing.move[k, 0] = 0.5 * dt * step[k, 0]
    for i in range(packed.lines.shape[0]):
        row, y = packed.lines[i], states[i]
        if not is_slack(row, y):
            advance_line(row, y, i, swing.move, work, work.spatial)
    return 0.5 * dt * sqrt(size)
