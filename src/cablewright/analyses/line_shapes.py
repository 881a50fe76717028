"""The sagging lines of solved poses as polylines."""

from __future__ import annotations

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.kernels.collision.clearance import Surroundings, drawn_lines
from cablewright.kernels.collision.polyline_of_line import MAX_POINTS
from cablewright.kernels.layout import Packed


def polylines(packed: Packed, pose: Array, states: Array, tolerance: float, ends: float = 0.0) -> list[Array]:
    """Return the free span of each line at one pose, (k, 3) m, world, from its sheave to the platform.

    *packed*: the robot's numbers in one row; *pose* (n,); *states* (m, 6): see `LineStates`; *tolerance*: largest
    distance from the curve to its chords, m. Points are *ends* (m) from either end as well. Empty where a state is not
    finite.
    """
    m = packed.lines.shape[-2]
    points, counts = np.zeros((m, MAX_POINTS, 3)), np.zeros(m, np.int64)
    rows = packed._replace(lines=packed.lines.reshape(1, m, -1), platform=packed.platform.reshape(1, -1))
    drawn_lines(rows, pose[None], states[None], _free(m, tolerance, ends), points, counts)
    return [own[:count] for own, count in zip(points, counts, strict=True)]


def _free(m: int, tolerance: float, ends: float) -> Surroundings:
    """Nothing around *m* thin lines."""
    return Surroundings(
        radii=np.zeros(m),
        shared=np.zeros((m, m), dtype=np.int64),
        beams=np.empty((0, 2, 3)),
        beam_radii=np.empty(0),
        bodies=np.empty((0, 6)),
        ends=float(ends),
        tolerance=float(tolerance),
    )
