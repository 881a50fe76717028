"""Linearisation at an equilibrium: motion of the platform, and change of tensions, per line length or parameter."""

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import copy, solve
from cablewright.kernels.layout import OK, PARAMETERS, SINGULAR
from cablewright.kernels.statics.equilibrium import condense, evaluate
from cablewright.kernels.statics.line.interface import change_line, change_tension
from cablewright.kernels.statics.line.upright import is_slack
from cablewright.kernels.statics.platform import keep_free_columns, keep_free_part


@jit
def linearise(packed, lengths, pose, states, work, stiffness, motion):
    """Write the tangent stiffness (n, n) and the motion (n, m, 10) of the platform per line parameter.

    Parameters: unstrained length (m/m), relative modulus (m per unit), exit point x, y, z (m/m), radius of the sheave
    (m/m), relative weight of the cable (m per unit), platform point x, y, z (m/m). Where the dead span is modelled its
    winch exit follows the exit point horizontally, so that the plane of the line stays, and its height.
    Motion of a rigid body: translation and rotation about world axes. Returns a code.
    """
    m, n = packed.lines.shape[0], packed.freedoms
    evaluate(packed, lengths, pose, states, work)
    if not condense(packed, states, work):
        return SINGULAR
    for k in range(n):
        copy(work.stiffness[k], stiffness[k])
    keep_free_part(packed, stiffness)
    right = motion.reshape((n, m * PARAMETERS))
    for i in range(m):
        row, y = packed.lines[i], states[i]
        right[:, i * PARAMETERS : (i + 1) * PARAMETERS] = 0.0
        if is_slack(row, y):
            continue
        if not change_line(row, y, lengths[i], pose, i, work, work.spatial, right):
            return SINGULAR
    keep_free_columns(packed, right)
    if not solve(work.stiffness, right, n, m * PARAMETERS):
        return SINGULAR
    keep_free_columns(packed, right)
    return OK


@jit
def tension_changes(packed, lengths, pose, states, work, own, by_pose):
    """Write the derivatives of the logarithm of each line's tension at the sheave.

    *own* (m, 10): per parameter of the line, see `linearise`, with the platform held; *by_pose* (m, n): per motion of
    the platform, 1/m and 1/rad about world axes. Those of a slack line are zero. Returns a code.
    """
    evaluate(packed, lengths, pose, states, work)
    if not condense(packed, states, work):
        return SINGULAR
    for i in range(packed.lines.shape[0]):
        row, y = packed.lines[i], states[i]
        own[i, :], by_pose[i, :] = 0.0, 0.0
        if is_slack(row, y):
            continue
        if not change_tension(row, y, lengths[i], pose, i, work, work.spatial, own[i], by_pose[i]):
            return SINGULAR
    return OK
