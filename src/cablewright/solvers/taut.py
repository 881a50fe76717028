"""All lines of a point platform drawn straight: what a control loop asks of them at each step."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import layout
from cablewright.kernels.sheave import straight, whole_length
from cablewright.models.statics import Model
from cablewright.solvers.one_line import TAUT

__all__ = ["Taut", "taut_at"]

Array = NDArray[np.float64]


class Taut(NamedTuple):
    """All lines drawn straight at one place of B: (m, ...)."""

    angles: Array  # (m,) rad: gamma_taut
    free: Array  # (m,) m from the sheave to B
    lengths: Array  # (m,) m from the winch to B
    toward: Array  # (m, 3) unit: how a line's length grows as B moves
    planes: Array  # (m, 4) as kernels take them


def taut_at(model: Model, position: Array) -> Taut:
    """Draw all lines straight to *position* (3,), m. NaN for a line that has no tangent there."""
    lines, y = model.packed.lines, np.zeros(layout.STATE)
    found = np.full((len(lines), 3), np.nan)
    planes, toward = np.empty((len(lines), 4)), np.full((len(lines), 3), np.nan)
    px, py, pz = position.tolist()
    for i, row in enumerate(lines):
        dx, dy, dz = px - row[layout.EXIT_X], py - row[layout.EXIT_Y], pz - row[layout.EXIT_Z]
        x = math.hypot(dx, dy)
        ex, ey = (dx / x, dy / x) if x > 0.0 else (1.0, 0.0)
        planes[i] = ex, ey, x, dz
        if straight(row, x, dz, TAUT, y):
            phi = y[layout.PHI]
            found[i] = phi, y[layout.FREE], whole_length(row, y)
            toward[i] = math.cos(phi) * ex, math.cos(phi) * ey, math.sin(phi)
    return Taut(found[:, 0], found[:, 1], found[:, 2], toward, planes)
