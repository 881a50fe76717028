"""Geometry of a solved line: directions, plane, end points; the part of the interface of lines that solves nothing.

Arguments are as in `interface`. *general* is that of `Packed`, None of a robot whose lines are all upright: Numba then
compiles upright lines alone. *guide* (GUIDE_SIZE,) is scratch.
"""

from math import cos, sin

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import copy
from cablewright.kernels.layout import AZIMUTH, EXIT_X, GUIDE
from cablewright.kernels.statics.line.sheave import contact_angle
from cablewright.kernels.statics.line.spatial import ARM
from cablewright.kernels.statics.line.spatial_lines import carry_placed, leave_placed, shape_placed, turn_placed
from cablewright.kernels.statics.line.upright_lines import carry_upright, leave_upright, start_upright


@jit
def shape_line(row, y, guide, origin, plane):
    """Write the point (3,), world, and the *plane* (4,) in which the free span of a solved line is drawn.

    *plane*: as set by `place`, and so it remains of an upright line, with the exit point; of others it becomes their
    span's. Returns where in it the span begins, m: along it, and up.
    """
    for k in range(3):
        origin[k] = row[EXIT_X + k]
    if row[GUIDE] == 0.0:
        return start_upright(row, y)
    shape_placed(row, y, guide, origin, plane)
    return 0.0, 0.0


@jit
def end_of_line(row, i, work, spatial):
    """Return the arm (m, world) from the platform's origin to where a drawn or evaluated line leaves the platform."""
    if spatial is not None and row[GUIDE] > 0.0:
        return spatial.records[i, ARM], spatial.records[i, ARM + 1], spatial.records[i, ARM + 2]
    return work.arms[i, 0], work.arms[i, 1], work.arms[i, 2]


@jit
def hang_in_plane(row, y, pose, i, work, spatial, plane):
    """Write the *plane* (4,) of a drawn line, as set by `place`; of lines out of the plane that of their free span."""
    if spatial is None or row[GUIDE] == 0.0:
        copy(work.planes[i], plane)
        return
    x, across, z = end_of_line(row, i, work, spatial)
    plane[0], plane[1] = heading_of_line(row, y, plane, True)
    plane[2] = (pose[0] + x - row[EXIT_X]) * plane[0] + (pose[1] + across - row[EXIT_X + 1]) * plane[1]
    plane[3] = pose[2] + z - row[EXIT_X + 2]


@jit
def heading_of_line(row, y, plane, general):
    """Return the horizontal unit vector of the plane in which the free span of a solved line hangs.

    *plane* (4,): as set by `place`.
    """
    if general is not None and row[GUIDE] > 0.0:
        return cos(y[AZIMUTH]), sin(y[AZIMUTH])
    return plane[0], plane[1]


@jit
def turn_line(row, y, plane, guide, general):
    """Return the angle (rad) by which a solved cable turns at its exit point."""
    if general is not None and row[GUIDE] > 0.0:
        return turn_placed(row, y, plane, guide)
    return contact_angle(row, y)


@jit
def directions_of_line(row, y, plane, guide, general):
    """Return two unit vectors of a solved line: of the free span at the exit point, and of the dead span to the winch.

    The second is zero where the dead span is not modelled.
    """
    if general is not None and row[GUIDE] > 0.0:
        return leave_placed(row, y, plane, guide)
    return leave_upright(row, y, plane)


@jit
def carry_exit(row, plane, step, scale, general):
    """Move the exit point by *scale* times *step* (3,), m; the winch, whose place is given from it, stays."""
    for k in range(3):
        row[EXIT_X + k] += scale * step[k]
    if general is not None and row[GUIDE] > 0.0:
        carry_placed(row, step, scale)
    else:
        carry_upright(row, plane, step, scale)
