"""Platform dynamics: a drum that hangs from the point where the lines meet, on quasi-static lines.

A line weighs little beside the drum and its waves pass in milliseconds: at each moment it has its static shape, and
only the drum has inertia. One step of the implicit midpoint rule is the Newton iteration of `equilibrium` with the
drum's mass in the platform's balance: see `docs/decisions/0009-implicit-midpoint.md`.
"""

from math import atan2, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.layout import NOT_CONVERGED, NOT_FINITE, OK, PLATFORM_WEIGHT, SINGULAR, WEIGHT
from cablewright.kernels.newton import copy, solve
from cablewright.kernels.rotation import compose, matrix, rotate
from cablewright.kernels.statics.equilibrium import (
    add_eliminated,
    eliminate,
    evaluate,
    is_slack,
    step_line,
    workspace_of,
)
from cablewright.kernels.statics.line import force_change

STEPS = 30
MOVE_TOLERANCE = 1e-9  # m and rad: size of the last Newton step of the midpoint
LENGTH_TOLERANCE = 1e-7  # m: residual of the line equations before that step, which squares it

# Entries of a drum, the body that hangs from the platform point, in its own frame with z up its axis.
MASS = 0  # kg, total
CENTRE = 1  # m: centre of mass below the platform point
INERTIA = 2  # 2..4: kg m^2, principal, about the platform point
DRAG = 5  # N s/m on the platform point's speed
SWING_DAMPING, YAW_DAMPING = 6, 7  # N m s
YAW_STIFFNESS, YAW_REST = 8, 9  # N m/rad, rad
RELAXATION = 10  # s: a line's force increases by this time the rate of its elastic force (Kelvin-Voigt)
DRUM = 11

# Entries of a motion: of the platform point, and of the drum about it, in world axes.
PLACE, VELOCITY, TURN, RATE = 0, 3, 6, 9  # m, m/s, rotation vector rad, rad/s
MOTION = 12


class Swing(NamedTuple):
    """Scratch of one moving drum."""

    system: NDArray[np.float64]  # (6, 6)
    rhs: NDArray[np.float64]  # (6, 1)
    middle: NDArray[np.float64]  # (MOTION,): the motion at the midpoint of the step
    rotation: NDArray[np.float64]  # (3, 3)
    inertia: NDArray[np.float64]  # (3, 3), world
    move: NDArray[np.float64]  # (3, 1)
    lengths: NDArray[np.float64]  # (m,)
    place: NDArray[np.float64]  # (3,)
    pulled: NDArray[np.float64]  # (3,): rate of the lines' force due to the change of their lengths, N/s


@jit(allocates=True)
def moving_workspace(m):
    """Scratch for *m* lines, and of the drum."""
    swing = Swing(
        np.zeros((6, 6)),
        np.zeros((6, 1)),
        np.zeros(MOTION),
        np.eye(3),
        np.eye(3),
        np.zeros((3, 1)),
        np.zeros(m),
        np.zeros(3),
        np.zeros(3),
    )
    return workspace_of(None, 3, m), swing


@jit
def midpoint_step(packed, drum, motion, before, after, dt, states, work, swing):
    """Advance *motion* (MOTION,) by *dt* (s) while the lengths change linearly from *before* to *after* (m,).

    *packed* is a point platform of the drum's weight; *states* are those of the lines at the midpoint, updated in
    place. Returns a code; unless it is OK *motion* is unchanged.
    """
    middle = swing.middle
    copy(motion, middle)
    for i in range(before.shape[0]):
        swing.lengths[i] = 0.5 * (before[i] + after[i])
    code = NOT_CONVERGED
    for _ in range(STEPS):
        for k in range(3):
            swing.place[k] = middle[PLACE + k] = motion[PLACE + k] + 0.5 * dt * middle[VELOCITY + k]
            middle[TURN + k] = motion[TURN + k]
        compose(
            0.5 * dt * middle[RATE], 0.5 * dt * middle[RATE + 1], 0.5 * dt * middle[RATE + 2], middle[TURN : TURN + 3]
        )
        worst, unbalanced, _ = evaluate(packed, swing.lengths, swing.place, states, work)
        if not (worst == worst and unbalanced == unbalanced):
            return NOT_FINITE
        if not _condense(packed, before, after, dt, states, work, swing):
            return SINGULAR
        _assemble(drum, motion, packed.platform[PLATFORM_WEIGHT], dt, work, swing)
        if not solve(swing.system, swing.rhs, 6, 1):
            return SINGULAR
        move = _apply(packed, dt, states, work, swing)
        if move < MOVE_TOLERANCE and worst < LENGTH_TOLERANCE:
            code = OK
            break
    if code == OK:
        for k in range(3):
            motion[PLACE + k] += dt * middle[VELOCITY + k]
            motion[VELOCITY + k] = 2.0 * middle[VELOCITY + k] - motion[VELOCITY + k]
            motion[RATE + k] = 2.0 * middle[RATE + k] - motion[RATE + k]
        compose(dt * middle[RATE], dt * middle[RATE + 1], dt * middle[RATE + 2], motion[TURN : TURN + 3])
    return code


@jit
def _condense(packed, before, after, dt, states, work, swing):
    """As `equilibrium.condense`, and add the effect of the changes of length to swing.pulled. False if singular."""
    swing.pulled[:] = 0.0
    for i in range(packed.lines.shape[0]):
        row, y, steps, plane = packed.lines[i], states[i], work.steps[i], work.planes[i]
        if is_slack(row, y):
            continue
        if not eliminate(row, work.blocks[i], steps, 4):
            return False
        add_eliminated(row, y, work.forces[i], steps, work.arms[i], plane, work.wrench, work.stiffness)
        dh, dv = force_change(work.forces[i, 0], work.forces[i, 1], row[WEIGHT], steps, 3)
        rate = (after[i] - before[i]) / dt
        swing.pulled[0] -= rate * dh * plane[0]
        swing.pulled[1] -= rate * dh * plane[1]
        swing.pulled[2] -= rate * dv
    return True


@jit
def _assemble(drum, motion, weight, dt, work, swing):
    """Write the Newton system of the drum's balance at the midpoint: forces, then moments about the platform point."""
    A, b, middle, R, J = swing.system, swing.rhs, swing.middle, swing.rotation, swing.inertia
    matrix(middle[TURN : TURN + 3], R)
    for i in range(3):
        for j in range(3):
            J[i, j] = 0.0
            for k in range(3):
                J[i, j] += R[i, k] * drum[INERTIA + k] * R[j, k]
    mass, relax = drum[MASS], drum[RELAXATION]
    cx, cy, cz = -drum[CENTRE] * R[0, 2], -drum[CENTRE] * R[1, 2], -drum[CENTRE] * R[2, 2]
    wx, wy, wz = middle[RATE], middle[RATE + 1], middle[RATE + 2]
    inverse = 2.0 / dt
    A[:, :] = 0.0
    for i in range(3):
        A[i, i] = mass * inverse + drum[DRAG]
        for j in range(3):
            A[i, j] += (0.5 * dt + relax) * work.stiffness[i, j]
            A[3 + i, 3 + j] = J[i, j] * inverse
    _cross(A, 0, 3, -mass * inverse * cx, -mass * inverse * cy, -mass * inverse * cz)
    _cross(A, 3, 0, mass * inverse * cx, mass * inverse * cy, mass * inverse * cz)
    # right-hand side: applied forces less mass times acceleration
    for i in range(3):
        force = work.wrench[i] + relax * swing.pulled[i] - drum[DRAG] * middle[VELOCITY + i]
        for j in range(3):
            force -= relax * work.stiffness[i, j] * middle[VELOCITY + j]
        b[i, 0] = force - mass * inverse * (middle[VELOCITY + i] - motion[VELOCITY + i])
    ax = inverse * (middle[VELOCITY] - motion[VELOCITY])
    ay = inverse * (middle[VELOCITY + 1] - motion[VELOCITY + 1])
    az = inverse * (middle[VELOCITY + 2] - motion[VELOCITY + 2]) + weight / mass
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
    damping = (drum[SWING_DAMPING], drum[SWING_DAMPING], drum[YAW_DAMPING])
    for k in range(3):
        A[3 + k, 3 + k] += damping[k]
        b[3 + k, 0] -= damping[k] * middle[RATE + k]
    # the twisted lines are a weak spring about the vertical
    b[5, 0] -= drum[YAW_STIFFNESS] * (atan2(R[1, 0], R[0, 0]) - drum[YAW_REST])


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
    """Take the Newton step in swing.rhs. Returns the size of the drum's move, m and rad."""
    middle, step = swing.middle, swing.rhs
    size = 0.0
    for k in range(3):
        middle[VELOCITY + k] += step[k, 0]
        middle[RATE + k] += step[3 + k, 0]
        swing.move[k, 0] = 0.5 * dt * step[k, 0]
        size += step[k, 0] ** 2 + step[3 + k, 0] ** 2
    for i in range(packed.lines.shape[0]):
        row, y = packed.lines[i], states[i]
        if not is_slack(row, y):
            step_line(row, y, work.steps[i], work.arms[i], work.planes[i], swing.move)
    return 0.5 * dt * sqrt(size)
