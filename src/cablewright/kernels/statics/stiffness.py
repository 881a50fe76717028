"""Tangent stiffness of the platform, and each line's stiffness along its own chord."""

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import copy
from cablewright.kernels.layout import OK, SINGULAR, robot_of
from cablewright.kernels.statics.equilibrium import condense, evaluate, workspace
from cablewright.kernels.statics.line.interface import stiffen_line
from cablewright.kernels.statics.line.upright import is_slack, lengths_of
from cablewright.kernels.statics.platform import keep_free_part


@jit(allocates=True)
def stiffness_rows(packed, poses, states, tangent, chords, axial, arms, codes):
    """Write tangent stiffnesses (N, n, n), and of each line its chord (N, m, 3) and stiffness along it (N, m), N/m.

    *arms* (N, m, 3): from the platform's origin to where each line ends, world, m.
    *packed* has one row or N; poses (N, n) and states (N, m, 6) are those of equilibria. Writes codes (N,).
    """
    work = workspace(robot_of(packed, 0))
    for j in range(poses.shape[0]):
        own = robot_of(packed, j)
        codes[j] = _stiffness(own, poses[j], states[j], work, tangent[j], chords[j], axial[j], arms[j])


@jit
def _stiffness(packed, pose, states, work, tangent, chords, axial, arms):
    """One row of `stiffness_rows`. Returns a code."""
    lengths_of(packed, states, work.lengths)
    evaluate(packed, work.lengths, pose, states, work)
    if not condense(packed, states, work):
        return SINGULAR
    for k in range(packed.freedoms):
        copy(work.stiffness[k], tangent[k])
    keep_free_part(packed, tangent)
    for i in range(packed.lines.shape[0]):
        row, y = packed.lines[i], states[i]
        if is_slack(row, y):
            copy(work.arms[i], arms[i])
            axial[i], chords[i, :] = 0.0, 0.0
        else:
            axial[i] = stiffen_line(row, y, i, work, work.spatial, chords[i], arms[i])
    return OK
