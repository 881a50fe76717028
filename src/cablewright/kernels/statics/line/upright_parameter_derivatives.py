"""Derivatives of an upright line's wrench and tension by its parameters, for `linearise`.

The columns are those of `layout.PARAMETERS`.
"""

from math import cos, exp, sin

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import solve
from cablewright.kernels.layout import (
    ARC_COMPLIANCE,
    DEAD,
    DEAD_COMPLIANCE,
    EXIT,
    FREE,
    FREE_COMPLIANCE,
    LENGTH,
    MODULUS,
    PARAMETERS,
    PHI,
    POINT,
    PSI,
    PULLS,
    RADIUS,
    SHEAVE,
    SIDE,
    TAU,
    UNKNOWNS,
    WEIGHT,
    WEIGHT_FACTOR,
)
from cablewright.kernels.statics.line.catenary import span
from cablewright.kernels.statics.line.sheave import wrap
from cablewright.kernels.statics.line.upright import force_change, system
from cablewright.kernels.statics.line.vertical_plane import sideways
from cablewright.kernels.statics.platform import add_force, gradient_by_pose

OWN = (LENGTH, MODULUS, EXIT + 2, SHEAVE, WEIGHT_FACTOR)  # those whose effect stays in the line's plane


@jit
def write_upright(row, y, length, i, work, right):
    """Write the derivatives of an upright line's wrench by its parameters, see `interface.change_line`."""
    if not _add_own(row, y, length, i, work, right):
        return False
    _add_points(row, y, i, work, right)
    return True


@jit
def write_tension_upright(row, y, length, i, work, own, by_pose):
    """Write the derivatives of an upright line's tension by its parameters, see `interface.change_tension`."""
    plane, steps, changes = work.planes[i], work.steps[i], work.changes
    if not _own_changes(row, y, length, i, work):
        return False
    for k in range(len(OWN)):
        own[OWN[k]] = -changes[TAU, k]
    along, up = steps[TAU, 1], steps[TAU, 2]
    gradient_by_pose(work.arms[i], along * plane[0], along * plane[1], up, by_pose)
    for k in range(2):
        own[EXIT + k] = -by_pose[k]
    for axis in range(3):
        for k in range(3):
            own[POINT + axis] += by_pose[k] * work.rotation[k, axis]
    return True


@jit
def _own_changes(row, y, length, i, work):
    """Write minus the derivatives of line *i*'s unknowns by the parameters in OWN, its ends held, to work.changes."""
    plane, changes = work.planes[i], work.changes
    system(row, y, plane[2], plane[3], length, work.blocks[i], changes[:, 0])
    _parameter_residuals(row, y, changes)
    return solve(work.blocks[i], changes, int(row[UNKNOWNS]), len(OWN))


@jit
def _add_own(row, y, length, i, work, right):
    """Write the columns of line *i*'s parameters in OWN: the wrench of the force changes."""
    plane, arm, changes = work.planes[i], work.arms[i], work.changes
    if not _own_changes(row, y, length, i, work):
        return False
    h, v = work.forces[i, 0], work.forces[i, 1]
    for k in range(len(OWN)):
        dh, dv = force_change(h, v, row[WEIGHT], changes, k)
        if OWN[k] == WEIGHT_FACTOR:
            dv -= row[WEIGHT] * y[FREE]
        dh, dv = row[PULLS] * dh, row[PULLS] * dv
        _write(right, arm, dh * plane[0], dh * plane[1], dv, i * PARAMETERS + OWN[k], work.trial)
    return True


@jit
def _add_points(row, y, i, work, right):
    """Write the columns of line *i*'s exit point in x and y, and of its platform point.

    Moving the exit point by d or the platform point by -d changes the span equally; the latter also moves the force.
    """
    plane, arm, steps, turned = work.planes[i], work.arms[i], work.steps[i], work.rotation
    h, v = work.forces[i, 0], work.forces[i, 1]
    ex, ey = plane[0], plane[1]
    kxx, kzx = force_change(h, v, row[WEIGHT], steps, 1)
    kxz, kzz = force_change(h, v, row[WEIGHT], steps, 2)
    pulls, v = row[PULLS], v + row[WEIGHT] * y[FREE]
    h, v, kxx, kxz, kzx, kzz = pulls * h, pulls * v, pulls * kxx, pulls * kxz, pulls * kzx, pulls * kzz
    across = sideways(row, plane[2], h, kxx)
    xx, yy, xy = ex * ex * kxx + ey * ey * across, ey * ey * kxx + ex * ex * across, ex * ey * (kxx - across)
    column = i * PARAMETERS + EXIT
    _write(right, arm, xx, xy, ex * kzx, column, work.trial)
    _write(right, arm, xy, yy, ey * kzx, column + 1, work.trial)
    column = i * PARAMETERS + POINT
    for axis in range(3):
        dx, dy, dz = turned[0, axis], turned[1, axis], turned[2, axis]
        along = ex * dx + ey * dy
        fx, fy = xx * dx + xy * dy + ex * kxz * dz, xy * dx + yy * dy + ey * kxz * dz
        _write(right, arm, -fx, -fy, -(kzx * along + kzz * dz), column + axis, work.trial)
        if right.shape[0] == 6:
            right[3, column + axis] -= dy * v - dz * h * ey
            right[4, column + axis] -= dz * h * ex - dx * v
            right[5, column + axis] -= (dx * ey - dy * ex) * h


@jit
def _write(right, arm, fx, fy, fz, column, wrench):
    """Set a column to the wrench of a force at *arm*."""
    wrench[:] = 0.0
    add_force(arm, fx, fy, fz, wrench)
    for k in range(right.shape[0]):
        right[k, column] = wrench[k]


@jit
def _parameter_residuals(row, y, out):
    """Write the derivatives of the line's equations by the parameters in OWN to columns of *out*."""
    out[:, :] = 0.0
    t = exp(y[TAU])
    wrapped = wrap(row, y)
    strain = t * row[ARC_COMPLIANCE]
    out[2, 0] = -1.0
    out[2, 1] = row[RADIUS] * wrapped * strain / (1.0 + strain) ** 2
    out[1, 2] = 1.0
    _span_residuals(row, t, y[PHI], y[FREE], row[FREE_COMPLIANCE], out, 0, 1)
    sheave = 1.0 if row[RADIUS] > 0.0 else 0.0
    reach = sheave if row[UNKNOWNS] < 6.0 else 0.0  # a swivel's centre lies one radius from its axis
    turn = sheave * row[SIDE]
    out[0, 3] = reach - turn * sin(y[PHI])
    out[1, 3] = turn * cos(y[PHI])
    out[2, 3] = wrapped / (1.0 + strain)
    if row[UNKNOWNS] > 3.0:
        _span_residuals(row, t, y[PSI], y[DEAD], row[DEAD_COMPLIANCE], out, 4, 3)
        out[3, 2] = 1.0
        out[3, 3] = -turn * cos(y[PSI])
        out[4, 3] = reach + turn * sin(y[PSI])


@jit
def _span_residuals(row, t, direction, length, compliance, out, x, z):
    """As `_parameter_residuals`, of a span with equations *x* and *z*: by modulus (column 1) and weight (column 4).

    The shape of an inextensible span depends on the ratios of its forces alone (Euler), so that its derivative by the
    weight is minus that by the start force.
    """
    weight = row[WEIGHT]
    h, v = t * cos(direction), t * sin(direction)
    stretch, sag = compliance * length, 0.5 * weight * compliance * length * length
    out[x, 1] = -stretch * h
    out[z, 1] = -stretch * v - sag
    if weight > 0.0:
        _, _, hh, hv, vv, _, _, _ = span(h, v, length, weight, compliance)
        out[x, 4] = -(h * (hh - stretch) + v * hv)
        out[z, 4] = -(h * hv + v * (vv - stretch)) + sag
