"""Wrenches of spatial lines on the platform, their derivatives, and the lines' stiffness."""

from math import exp

from cablewright.kernels import jit
from cablewright.kernels.layout import TAU, WEIGHT
from cablewright.kernels.statics.line.guides import BY_FORCE
from cablewright.kernels.statics.line.spatial import (
    ARM,
    CHORD,
    END_FORCE,
    GIVEN,
    PLATFORM,
    POSE,
    RESIDUAL,
    pull_along,
    turn_of,
)


@jit
def add_spatial_pull(record, pulls, wrench):
    """Add the wrench of a placed spatial line on the platform, times *pulls*, to *wrench* (n,).

    *pulls*: number of cables of the line.
    """
    gx, gy, gz = -pulls * record[END_FORCE], -pulls * record[END_FORCE + 1], -pulls * record[END_FORCE + 2]
    wrench[0] += gx
    wrench[1] += gy
    wrench[2] += gz
    if wrench.shape[0] == 6:
        ax, ay, az = record[ARM], record[ARM + 1], record[ARM + 2]
        wrench[3] += ay * gz - az * gy
        wrench[4] += az * gx - ax * gz
        wrench[5] += ax * gy - ay * gx


@jit
def wrench_change(row, y, record, steps, column, axis, pulls, out):
    """Write the change of a spatial line's wrench, times *pulls*, for *steps* of its unknowns to *out* (n,).

    *axis*: 0 to 2 where the platform turns about that world axis at the same time, else -1.
    """
    t, weight = exp(y[TAU]), row[WEIGHT]
    dg = (t * steps[0, column], t * steps[1, column], t * steps[2, column] + weight * steps[3, column])
    for i in range(3):
        out[i] = -pulls * dg[i]
    if out.shape[0] < 6:
        return
    bx, by, bz = _arm_change(record, dg, axis)
    gx, gy, gz = record[END_FORCE], record[END_FORCE + 1], record[END_FORCE + 2]
    ax, ay, az = record[ARM], record[ARM + 1], record[ARM + 2]
    out[3] = -pulls * (by * gz - bz * gy + ay * dg[2] - az * dg[1])
    out[4] = -pulls * (bz * gx - bx * gz + az * dg[0] - ax * dg[2])
    out[5] = -pulls * (bx * gy - by * gx + ax * dg[1] - ay * dg[0])


@jit
def _arm_change(record, dg, axis):
    """Change of the arm for a change *dg* of the force at the span's end; *axis*: see `wrench_change`."""
    turned, moved = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    if axis >= 0:
        turned = turn_of(axis, record[END_FORCE], record[END_FORCE + 1], record[END_FORCE + 2])
        moved = turn_of(axis, record[ARM], record[ARM + 1], record[ARM + 2])
    slip = (dg[0] - turned[0], dg[1] - turned[1], dg[2] - turned[2])
    at = PLATFORM + BY_FORCE
    bx = moved[0] + record[at] * slip[0] + record[at + 1] * slip[1] + record[at + 2] * slip[2]
    by = moved[1] + record[at + 3] * slip[0] + record[at + 4] * slip[1] + record[at + 5] * slip[2]
    bz = moved[2] + record[at + 6] * slip[0] + record[at + 7] * slip[1] + record[at + 8] * slip[2]
    return bx, by, bz


@jit
def add_spatial_rate(row, y, record, steps, pulls, rate, pulled, turning):
    """Add the terms of a spatial line whose length changes to *pulled* (n,) and *turning* (3, 6).

    The line is eliminated; see `interface.condense_moving_line`.
    """
    t, weight = exp(y[TAU]), row[WEIGHT]
    more = -rate * pulls
    dg = (
        more * t * steps[0, GIVEN],
        more * t * steps[1, GIVEN],
        more * (t * steps[2, GIVEN] + weight * steps[3, GIVEN]),
    )
    for k in range(3):
        pulled[k] += dg[k]
    if pulled.shape[0] < 6:
        return
    ax, ay, az = record[ARM], record[ARM + 1], record[ARM + 2]
    pulled[3] += ay * dg[2] - az * dg[1]
    pulled[4] += az * dg[0] - ax * dg[2]
    pulled[5] += ax * dg[1] - ay * dg[0]
    gx, gy, gz = pulls * record[END_FORCE], pulls * record[END_FORCE + 1], pulls * record[END_FORCE + 2]
    for k in range(6):
        dg = (
            t * steps[0, POSE + k],
            t * steps[1, POSE + k],
            t * steps[2, POSE + k] + weight * steps[3, POSE + k],
        )
        bx, by, bz = _arm_change(record, dg, k - 3)
        turning[0, k] += by * gz - bz * gy
        turning[1, k] += bz * gx - bx * gz
        turning[2, k] += bx * gy - by * gx


@jit
def add_spatial(row, y, record, steps, pulls, scratch, wrench, stiffness):
    """Add an eliminated spatial line's wrench and its derivatives to the platform's equations.

    As `equilibrium.add_eliminated`: the wrench after its own step. *steps* (4, 8) are the solved right-hand sides;
    *scratch* (n,).
    """
    n = wrench.shape[0]
    add_spatial_pull(record, pulls, wrench)
    wrench_change(row, y, record, steps, RESIDUAL, -1, pulls, scratch)
    for i in range(n):
        wrench[i] -= scratch[i]
    add_spatial_stiffness(row, y, record, steps, pulls, scratch, stiffness)


@jit
def add_spatial_stiffness(row, y, record, steps, pulls, scratch, stiffness):
    """Add minus the derivative of a spatial line's wrench by the pose to *stiffness* (n, n); *scratch* (n,)."""
    n = stiffness.shape[0]
    for k in range(n):
        wrench_change(row, y, record, steps, POSE + k, k - 3, pulls, scratch)
        for i in range(n):
            stiffness[i, k] -= scratch[i]


@jit
def stiffness_along(row, y, record, steps, toward):
    """Return the stiffness of an eliminated spatial line along its chord, N/m.

    Writes the chord's direction to *toward* (3,).
    """
    _, chord = pull_along(row, y, record)
    t, rate = exp(y[TAU]), 0.0
    for i in range(3):
        toward[i] = record[CHORD + i] / chord
    for i in range(3):
        for k in range(3):
            change = t * steps[i, POSE + k] + (row[WEIGHT] * steps[3, POSE + k] if i == 2 else 0.0)
            rate += toward[i] * change * toward[k]
    return rate
