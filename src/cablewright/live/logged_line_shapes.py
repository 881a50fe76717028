"""Shapes of a moving machine's lines, from logged poses and unstrained lengths, line by line.

The platform need not be in equilibrium. A line that is shorter than the straight distance, by errors of the
description, is drawn straight.
"""

from __future__ import annotations

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.kernels import batches
from cablewright.models.packed_views import blank_states
from cablewright.models.statics import Model


def hanging_lines(model: Model, poses: Array, lengths: Array) -> Array:
    """Return line states (F, m, 6) of lines with unstrained *lengths* (F, m), m, at *poses* (F, n), m and rad.

    States are NaN where the pose is not known, or a platform point is inside a sheave. A line of unknown length is
    straight.
    """
    states = blank_states(*lengths.shape)
    arrays = (np.ascontiguousarray(each, dtype=np.float64) for each in (poses, lengths))
    batches.shape_rows(model.rows(), *arrays, states)
    return states
