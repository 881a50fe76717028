"""The lines of a machine in motion as they hang: from logged poses and unstrained lengths, line by line.

The platform need not be in equilibrium. A line that is shorter than the straight way, by errors of the description, is
drawn straight.
"""

from __future__ import annotations

import numpy as np

from cablewright.arrays import Array
from cablewright.kernels.layout import Code
from cablewright.kernels.statics.line.sheave import straight
from cablewright.models.packed_views import blank_states
from cablewright.models.statics import Model
from cablewright.solvers.one_line import TAUT, hang, planes_and_arms


def hanging_lines(model: Model, poses: Array, lengths: Array) -> Array:
    """Return line states (F, m, 6) of lines with unstrained *lengths* (F, m), m, at *poses* (F, n), m and rad.

    NaN where neither length nor pose is known. Raises `InputError` for a robot with lines out of their vertical plane.
    """
    model.robot.require_lines_in_plane("a line by its length alone")
    states = blank_states(*lengths.shape)
    planes = planes_and_arms(model.packed.lines, poses)[0]
    for k, i in np.ndindex(lengths.shape):
        row, plane, own = model.packed.lines[i], planes[k, i], states[k, i]
        known = bool(np.isfinite(plane).all())
        if known and np.isfinite(lengths[k, i]) and hang(row, plane, float(lengths[k, i]), own) == Code.OK:
            continue
        if not (known and straight(row, plane[2], plane[3], TAUT, own)):
            own[:] = np.nan
    return states
