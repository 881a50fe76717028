"""Straight lines to a point platform: their angles, lengths and directions."""

from math import cos, nan, sin, sqrt

from cablewright.kernels import jit
from cablewright.kernels.layout import EXIT_X, FREE, PHI, SPANS
from cablewright.kernels.statics.line.sheave import straight, whole_length

# Columns of a line's results.
ANGLE, REACH, WHOLE = 0, 1, 2  # rad above the horizontal, m from the sheave, m from the winch
FOUND = 3


@jit
def draw(lines, position, tension, scratch, found, planes, toward):
    """Write the straight *lines* (m, COLUMNS) to *position* (3,), m; *tension* (N) only places levers.

    *found* (m, FOUND); *planes* (m, 4) as `wrench.place` has them; *toward* (m, 3): the derivative of a line's length
    by the position: for one span the unit vector away from the sheave. NaN for a line without a tangent to the
    position. *scratch* (STATE,).
    """
    for i in range(lines.shape[0]):
        row = lines[i]
        dx, dy, dz = position[0] - row[EXIT_X], position[1] - row[EXIT_X + 1], position[2] - row[EXIT_X + 2]
        x = sqrt(dx * dx + dy * dy)
        ex, ey = (dx / x, dy / x) if x > 0.0 else (1.0, 0.0)
        planes[i, 0], planes[i, 1], planes[i, 2], planes[i, 3] = ex, ey, x, dz
        if straight(row, x, dz, tension, scratch):
            phi = scratch[PHI]
            found[i, ANGLE], found[i, REACH], found[i, WHOLE] = phi, scratch[FREE], whole_length(row, scratch)
            along, up = row[SPANS] * cos(phi), row[SPANS] * sin(phi)
            toward[i, 0], toward[i, 1], toward[i, 2] = along * ex, along * ey, up
        else:
            found[i, :], toward[i, :] = nan, nan
