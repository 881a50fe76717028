"""Interval equations of lines that do not hang in a vertical plane, for certificates: their rows and wrenches.

Nothing here is compiled for a robot without such lines: see `Packed`.
"""

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.certificates.interval import add
from cablewright.kernels.certificates.jets import OWN, SLOPED, of
from cablewright.kernels.layout import GUIDE, UPRIGHT
from cablewright.kernels.statics.line.spatial_enclosure import centre_of, enclose_spatial
from cablewright.kernels.statics.platform_enclosure import component


@jit
def enclose_spatial_line(general, row, y, length, pose, omega, i, at_solution, work):
    """Enclose the equations of line *i* *at_solution*, or else its Jacobian over the box.

    Returns False if the line hangs in a vertical plane. The midpoints of its unknowns are written with the equations,
    which come first.
    """
    if general is None or row[GUIDE] == UPRIGHT:
        return False
    _enclose(row, y, length, pose, omega, i, at_solution, work)
    return True


@jit(allocates=True)
def _enclose(row, y, length, pose, omega, i, at_solution, work):
    start, end, first, n = work.offsets[i], work.offsets[i + 1], work.offsets[-1], pose.shape[0]
    equations, wrench = np.zeros((OWN, SLOPED, 2)), np.zeros((6, SLOPED, 2))
    centre, box, radius = work.centre[start:end], np.zeros(end - start), np.zeros(n)
    if at_solution:
        centre_of(row, y, pose, work.rotation, work.arm, work.moved, centre)
    else:
        box[:], radius[:] = work.radius[start:end], work.radius[first:]
    given = (pose, radius, omega, work.rotation, length, np.zeros(3))
    enclose_spatial(row, y, centre, box, given, work.arm, work.moved, equations, wrench)
    if at_solution:
        work.residual[start:end] = equations[: end - start, 0]
        for j in range(n):
            total = add(component(work.residual, first + j), of(wrench[j], 0))
            work.residual[first + j, 0], work.residual[first + j, 1] = total
    else:
        _write_jacobian(equations, wrench, start, end, first, work.low, work.high)


@jit
def _write_jacobian(equations, wrench, start, end, first, low, high):
    """Write a line's own block and its rows by the pose; add its share of the platform's rows."""
    n, count = low.shape[0] - first, end - start
    for j in range(count):
        for c in range(count):
            low[start + j, start + c], high[start + j, start + c] = of(equations[j], 1 + c)
        for c in range(n):
            low[start + j, first + c], high[start + j, first + c] = of(equations[j], 1 + OWN + c)
    for j in range(n):
        for c in range(count):
            low[first + j, start + c], high[first + j, start + c] = of(wrench[j], 1 + c)
        for c in range(n):
            total = add((low[first + j, first + c], high[first + j, first + c]), of(wrench[j], 1 + OWN + c))
            low[first + j, first + c], high[first + j, first + c] = total
