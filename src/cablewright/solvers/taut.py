"""All lines of a point platform as straight tangents, for each step of a control loop."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cablewright.arrays import Array
from cablewright.kernels.statics import taut
from cablewright.models.packed_views import blank_states
from cablewright.models.statics import Model
from cablewright.solvers.one_line import TAUT


class Taut(NamedTuple):
    """The straight lines to one position of the platform point B."""

    angles: Array  # (m,) rad, free angle of the taut line: gamma_taut
    free: Array  # (m,) m from the sheave to B
    lengths: Array  # (m,) m from the winch to B
    toward: Array  # (m, 3) unit vectors: gradients of the lengths with respect to B
    planes: Array  # (m, 4) of the lines, see `kernels.wrench.place`


def taut_at(model: Model, position: Array) -> Taut:
    """Return the straight lines to *position* (3,), m; NaN for a line without a tangent there."""
    m = model.m
    found, planes, toward = np.empty((m, taut.FOUND)), np.empty((m, 4)), np.empty((m, 3))
    place = np.array(position, dtype=np.float64)
    taut.draw(model.packed.lines, place, TAUT, blank_states(), found, planes, toward)
    angles, free, lengths = np.ascontiguousarray(found.T)
    return Taut(angles, free, lengths, toward, planes)
