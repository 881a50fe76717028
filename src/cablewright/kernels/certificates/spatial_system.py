"""Lines out of the plane in the system of a certificate: their rows and their share of the platform's.

Nothing here is compiled for a robot without such lines: see `Packed`.
"""

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.certificates.interval import add
from cablewright.kernels.certificates.jets import OWN, SLOTS, fixed, of
from cablewright.kernels.layout import EXIT_X, GUIDE, UPRIGHT
from cablewright.kernels.statics.line.spatial_enclosure import centre_of, enclose_spatial
from cablewright.kernels.statics.platform_enclosure import component, enclose_arm


@jit
def centre_spatial(general, row, y, pose, work, centre):
    """Write the middles of a line's unknowns to *centre* (k,). False if the line is in a vertical plane."""
    if general is None or row[GUIDE] == UPRIGHT:
        return False
    enclose_arm(row, pose.shape[0], 0.0, work.rotation, work.arm)
    _centre(row, y, pose, work, centre)
    return True


@jit(allocates=True)
def _centre(row, y, pose, work, centre):
    away = np.zeros(3)
    for k in range(3):
        away[k] = pose[k] + component(work.arm, k)[0] - row[EXIT_X + k]
    centre_of(row, y, fixed(away[0], away[1], away[2]), centre)


@jit
def spatial_residual(general, row, length, pose, i, work):
    """Enclose the equations of line *i* at the solution. False if the line is in a vertical plane."""
    if general is None or row[GUIDE] == UPRIGHT:
        return False
    _residual(row, length, pose, i, work)
    return True


@jit(allocates=True)
def _residual(row, length, pose, i, work):
    start, first, n = work.offsets[i], work.offsets[-1], pose.shape[0]
    k = work.offsets[i + 1] - start
    equations, wrench = np.zeros((OWN, 1 + SLOTS, 2)), np.zeros((6, 1 + SLOTS, 2))
    centre, box, radius = work.centre[start : start + k], np.zeros(k), np.zeros(n)
    enclose_spatial(row, centre, box, pose, radius, 0.0, work.rotation, length, work.arm, work.moved, equations, wrench)
    for j in range(k):
        work.residual[start + j] = equations[j, 0]
    for j in range(n):
        work.residual[first + j, 0], work.residual[first + j, 1] = add(
            component(work.residual, first + j), of(wrench[j], 0)
        )


@jit
def spatial_jacobian(general, row, length, pose, omega, i, work):
    """Enclose the Jacobian's entries of line *i* over the box. False if the line is in a vertical plane."""
    if general is None or row[GUIDE] == UPRIGHT:
        return False
    _jacobian(row, length, pose, omega, i, work)
    return True


@jit(allocates=True)
def _jacobian(row, length, pose, omega, i, work):
    start, first, n = work.offsets[i], work.offsets[-1], pose.shape[0]
    k = work.offsets[i + 1] - start
    equations, wrench = np.zeros((OWN, 1 + SLOTS, 2)), np.zeros((6, 1 + SLOTS, 2))
    centre, box, radius = work.centre[start : start + k], work.radius[start : start + k], work.radius[first:]
    enclose_spatial(
        row, centre, box, pose, radius, omega, work.rotation, length, work.arm, work.moved, equations, wrench
    )
    low, high = work.low, work.high
    for j in range(k):
        for c in range(k):
            low[start + j, start + c], high[start + j, start + c] = of(equations[j], 1 + c)
        for c in range(n):
            low[start + j, first + c], high[start + j, first + c] = of(equations[j], 1 + OWN + c)
    for j in range(n):
        for c in range(k):
            low[first + j, start + c], high[first + j, start + c] = of(wrench[j], 1 + c)
        for c in range(n):
            at = (low[first + j, first + c], high[first + j, first + c])
            low[first + j, first + c], high[first + j, first + c] = add(at, of(wrench[j], 1 + OWN + c))
