"""All lines of a point platform drawn straight: what a control loop asks of them at each step."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cablewright.arrays import Array
from cablewright.kernels.statics import taut
from cablewright.models.packed_views import blank_states
from cablewright.models.statics import Model
from cablewright.solvers.one_line import TAUT


class Taut(NamedTuple):
    """All lines drawn straight at one place of B: (m, ...)."""

    angles: Array  # (m,) rad: gamma_taut
    free: Array  # (m,) m from the sheave to B
    lengths: Array  # (m,) m from the winch to B
    toward: Array  # (m, 3) unit: how a line's length grows as B moves
    planes: Array  # (m, 4) as kernels take them


def taut_at(model: Model, position: Array) -> Taut:
    """Draw all lines straight to *position* (3,), m. NaN for a line that has no tangent there."""
    m = model.m
    found, planes, toward = np.empty((m, taut.FOUND)), np.empty((m, 4)), np.empty((m, 3))
    place = np.array(position, dtype=np.float64)
    taut.draw(model.packed.lines, place, TAUT, blank_states(), found, planes, toward)
    angles, free, lengths = np.ascontiguousarray(found.T)
    return Taut(angles, free, lengths, toward, planes)
