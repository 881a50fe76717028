"""Tangent stiffness of the platform, and each line's stiffness along its own chord."""

from cablewright.kernels import jit
from cablewright.kernels.layout import GUIDE, OK, PULLS, SINGULAR, WEIGHT, robot_of
from cablewright.kernels.newton import copy
from cablewright.kernels.statics.equilibrium import condense, evaluate, is_slack, workspace
from cablewright.kernels.statics.line import force_change, lengths_of, pull_of
from cablewright.kernels.statics.plane import keep_free_part
from cablewright.kernels.statics.spatial_lines import write_stiffness


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
        row, y, steps, plane = packed.lines[i], states[i], work.steps[i], work.planes[i]
        copy(work.arms[i], arms[i])
        if is_slack(row, y):
            axial[i], chords[i, :] = 0.0, 0.0
            continue
        if row[GUIDE] > 0.0:
            axial[i] = write_stiffness(row, y, i, chords[i], arms[i], work.spatial)
            continue
        h, v = work.forces[i, 0], work.forces[i, 1]
        kxx, kzx = force_change(h, v, row[WEIGHT], steps, 1)
        kxz, kzz = force_change(h, v, row[WEIGHT], steps, 2)
        _, cx, cz = pull_of(row, y, plane[2], plane[3])
        axial[i] = row[PULLS] * (cx * (kxx * cx + kxz * cz) + cz * (kzx * cx + kzz * cz))
        chords[i, 0], chords[i, 1], chords[i, 2] = plane[0] * cx, plane[1] * cx, cz
    return OK
