"""Derivatives of a spatial line's wrench and tension by its parameters, for `linearise`.

The columns are those of `layout.PARAMETERS`. The winch exit follows the exit point in all directions; the arc on a
pulley begins in the same direction.
"""

from math import cos, exp, sin

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import solve
from cablewright.kernels.layout import (
    ARC_COMPLIANCE,
    ASIDE,
    AZIMUTH,
    COUNTERWEIGHT,
    DEAD,
    DEAD_COMPLIANCE,
    EXIT,
    FREE,
    FREE_COMPLIANCE,
    GUIDE,
    LENGTH,
    MEAN_RISE,
    MODULUS,
    PARAMETERS,
    PHI,
    POINT,
    PULLS,
    RADIUS,
    SHEAVE,
    SPANS,
    TAU,
    WEIGHT,
    WEIGHT_FACTOR,
    WINCH_RISE,
)
from cablewright.kernels.statics.line.catenary import span
from cablewright.kernels.statics.line.guides import (
    ARC,
    ARC_BY_FORCE,
    ARC_BY_RADIUS,
    BY_FORCE,
    CONTACT_POINT,
    GIVEN_WAY,
    POINT_BY_RADIUS,
    SPAN,
    SPAN_BY_RADIUS,
    towards_winch,
)
from cablewright.kernels.statics.line.spatial import (
    ARM,
    END_FORCE,
    FORCE,
    FRAME,
    PLATFORM,
    POSE,
    SIZE,
    dead_length,
    spatial_system,
)
from cablewright.kernels.statics.line.spatial_wrench import wrench_change
from cablewright.kernels.statics.line.upright import force_on_mount


@jit
def write_placed(row, y, length, pose, i, work, spatial, right):
    """Write the derivatives of a spatial line's wrench by its parameters, see `interface.change_line`."""
    if not _parameter_changes(row, y, length, i, pose, work, spatial):
        return False
    for k in range(PARAMETERS):
        _write_parameter(row, y, i, work, spatial, k, spatial.change)
        for j in range(right.shape[0]):
            right[j, i * PARAMETERS + k] = spatial.change[j]
    return True


@jit
def write_tension_placed(row, y, length, pose, i, work, spatial, own, by_pose):
    """Write the derivatives of a spatial line's tension by its parameters, see `interface.change_tension`."""
    record = spatial.records[i]
    for k in range(by_pose.shape[0]):
        by_pose[k] = _tension_change(record, y, spatial.steps[i], POSE + k)
    if not _parameter_changes(row, y, length, i, pose, work, spatial):
        return False
    for k in range(PARAMETERS):
        own[k] = -_tension_change(record, y, spatial.parameters, k)
    return True


@jit
def mount_rows(lines, states, planes, forces, dead):
    """Write the force of each line on its exit point (N, m, 3), N, and the change of its dead span as that moves.

    *dead* (N, m, 3): unstrained length that the dead span loses per motion of the exit point, with the winch fixed; 0
    of lines in vertical planes. *lines* (1 or N, m, COLUMNS), *states* (N, m, 6), *planes* (N, m, 2): directions.
    """
    for j in range(states.shape[0]):
        for i in range(states.shape[1]):
            row, y = lines[j if lines.shape[0] > 1 else 0, i], states[j, i]
            if row[GUIDE] == 0.0:
                along, forces[j, i, 2] = force_on_mount(row, y)
                forces[j, i, 0], forces[j, i, 1] = along * planes[j, i, 0], along * planes[j, i, 1]
                dead[j, i, :] = 0.0
                continue
            t, c, towards = exp(y[TAU]), cos(y[PHI]), towards_winch(row)
            free = (c * cos(y[AZIMUTH]), c * sin(y[AZIMUTH]), sin(y[PHI]))
            free_end = 1.0 if row[COUNTERWEIGHT] == 0.0 else 0.0
            strain = row[DEAD_COMPLIANCE] * (t + row[WEIGHT] * row[MEAN_RISE] * y[DEAD])
            for k in range(3):
                forces[j, i, k] = row[PULLS] * t * (free[k] + towards[k] / row[SPANS])
                dead[j, i, k] = free_end * towards[k] / (1.0 + strain)


@jit
def _parameter_changes(row, y, length, i, pose, work, spatial):
    """Write minus the derivatives of line *i*'s unknowns by its parameters, its ends held, to *spatial*."""
    record, block, changes = spatial.records[i], spatial.blocks[i], spatial.parameters
    if not spatial_system(row, y, pose, work.arms[i], work.rotation, length, record, block, spatial.steps[i]):
        return False
    changes[:, :] = 0.0
    taken = 1.0 / (1.0 + exp(y[TAU]) * row[ARC_COMPLIANCE])
    changes[3, LENGTH] = -1.0
    for k in range(3):
        changes[k, EXIT + k] = 1.0
        for axis in range(3):
            changes[k, POINT + axis] = -work.rotation[k, axis]
    _by_cable(row, y, record, taken, changes)
    _by_dead_span(row, y, record, taken, changes)
    if row[COUNTERWEIGHT] > 0.0:
        _by_counterweight(row, y, record, changes)
    return solve(block, changes, SIZE, PARAMETERS)


@jit
def _by_cable(row, y, record, taken, changes):
    """Add the derivatives of the equations by modulus and weight of the free span and the cable on the sheaves."""
    weight, compliance, free = row[WEIGHT], row[FREE_COMPLIANCE], y[FREE]
    h, v = exp(y[TAU]) * cos(y[PHI]), record[FORCE + 2]
    stretch, sag = compliance * free, 0.5 * weight * compliance * free * free
    for k in range(3):
        changes[k, MODULUS] = -stretch * record[FORCE + k] - (sag if k == 2 else 0.0)
    contact = record[FRAME + ARC] + record[PLATFORM + ARC]
    changes[3, MODULUS] = contact * taken * (1.0 - taken)
    if weight == 0.0:
        return
    _, _, hh, hv, vv, _, _, _ = span(h, v, free, weight, compliance)
    outward = -(h * (hh - stretch) + v * hv)  # the shape of an inextensible span depends on ratios of forces (Euler)
    changes[2, WEIGHT_FACTOR] = -(h * hv + v * (vv - stretch)) + sag
    for k in range(2):
        changes[k, WEIGHT_FACTOR] = outward * record[FORCE + k] / h if h > 0.0 else 0.0
    for k in range(3):
        changes[k, WEIGHT_FACTOR] -= record[PLATFORM + BY_FORCE + 3 * k + 2] * weight * free
    changes[3, WEIGHT_FACTOR] = taken * record[PLATFORM + ARC_BY_FORCE + 2] * weight * free


@jit
def write_radius(row, record, right, column):
    """Write to a *column* of *right* how the span's equations change with the radius of the sheave on the frame.

    Returns those of the cable on the sheave, and before it, with the force held, m/m; 0 without a sheave.
    """
    for k in range(SIZE):
        right[k, column] = 0.0
    if row[GUIDE] == ASIDE:
        for k in range(3):
            right[k, column] = record[FRAME + POINT_BY_RADIUS + k]
        return record[FRAME + ARC_BY_RADIUS], record[FRAME + SPAN_BY_RADIUS]
    if row[RADIUS] == 0.0:
        return 0.0, 0.0
    for k in range(3):
        right[k, column] = (record[FRAME + CONTACT_POINT + k] - record[FRAME + GIVEN_WAY + k]) / row[RADIUS]
    return record[FRAME + ARC] / row[RADIUS], 0.0


@jit
def _by_dead_span(row, y, record, taken, changes):
    """Add the derivatives of the equations by the sheave's radius, and of the dead span by all parameters."""
    tension = exp(y[TAU])
    bend = 0.5 * row[DEAD_COMPLIANCE] * row[WEIGHT] * row[MEAN_RISE]
    _, _, per_metre = dead_length(row, record[FRAME + SPAN], tension)
    on_sheave, before = write_radius(row, record, changes, SHEAVE)
    changes[3, SHEAVE] = on_sheave * taken + before * per_metre
    if record[FRAME + SPAN] == 0.0:
        return
    stretch = y[DEAD] * (row[DEAD_COMPLIANCE] * tension + bend * y[DEAD])
    changes[3, MODULUS] += stretch * per_metre
    changes[3, WEIGHT_FACTOR] -= y[DEAD] * bend * y[DEAD] * per_metre


@jit
def _by_counterweight(row, y, record, changes):
    """Write the derivatives of the fourth equation of a line with a counterweight, as LENGTH by its relative mass."""
    lift = row[WEIGHT] * row[WINCH_RISE] / row[COUNTERWEIGHT]
    bend = 0.5 * row[DEAD_COMPLIANCE] * row[WEIGHT] * row[MEAN_RISE]
    tension = exp(y[TAU])
    _, _, per_metre = dead_length(row, record[FRAME + SPAN], tension)
    changes[3, :] = 0.0
    changes[3, LENGTH] = -1.0
    changes[3, MODULUS] = lift * y[DEAD] * (row[DEAD_COMPLIANCE] * tension + bend * y[DEAD]) * per_metre
    changes[3, WEIGHT_FACTOR] = lift * y[DEAD] * (1.0 - bend * y[DEAD] * per_metre)
    if row[GUIDE] == ASIDE:
        changes[3, SHEAVE] = lift * record[FRAME + SPAN_BY_RADIUS] * per_metre


@jit
def _write_parameter(row, y, i, work, spatial, parameter, out):
    """Write the wrench's change per *parameter* (0 to 9) of `_parameter_changes`, the platform held, to *out* (n,)."""
    record, pulls = spatial.records[i], row[PULLS]
    wrench_change(row, y, record, spatial.parameters, parameter, -1, -pulls, out)
    gx, gy, gz = record[END_FORCE], record[END_FORCE + 1], record[END_FORCE + 2]
    bx, by, bz, heavier = 0.0, 0.0, 0.0, 0.0
    if parameter == WEIGHT_FACTOR:
        heavier = row[WEIGHT] * y[FREE]
        at = PLATFORM + BY_FORCE
        bx, by, bz = heavier * record[at + 2], heavier * record[at + 5], heavier * record[at + 8]
        out[2] -= pulls * heavier
    elif parameter >= POINT:
        axis = parameter - POINT
        bx, by, bz = work.rotation[0, axis], work.rotation[1, axis], work.rotation[2, axis]
    if out.shape[0] == 6:
        out[3] -= pulls * (by * gz - bz * gy + record[ARM + 1] * heavier)
        out[4] -= pulls * (bz * gx - bx * gz - record[ARM] * heavier)
        out[5] -= pulls * (bx * gy - by * gx)


@jit
def _tension_change(record, y, columns, k):
    """Change of the logarithm of the tension at the frame for column *k* of steps of the unknowns."""
    grow = record[FORCE] * columns[0, k] + record[FORCE + 1] * columns[1, k] + record[FORCE + 2] * columns[2, k]
    return grow / exp(y[TAU])
