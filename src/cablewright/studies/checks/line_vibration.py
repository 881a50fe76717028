"""Lines that vibrate about as slowly as the platform: then its modes have other frequencies than the check says."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from cablewright.analyses.modes import modes
from cablewright.foundation.arrays import Array
from cablewright.models.inertia import with_inertia
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse

FACTOR: Final = 2.0
"""First own frequency of a line over the platform's slowest mode, from which on that is right to 0.3 %."""

_PLACES: Final = 50  # along a path, at most


def slow_lines(robot: Robot, poses: Array, retraction: Array | None) -> Iterator[str]:
    """Yield a sentence on lines whose own vibration is within `FACTOR` of the slowest mode along *poses* (k, n).

    *retraction*: (k,) m. Some of the poses are examined, evenly.
    """
    rows = np.unique(np.linspace(0, len(poses) - 1, _PLACES).astype(np.int64))
    drawn = None if retraction is None else retraction[rows]
    held = solve_inverse(Model.full(with_inertia(robot)), poses[rows], retraction=drawn)
    if not held.ok.any():
        return
    found = modes(held[held.ok])
    own, slowest = found.line_frequencies, found.lowest
    ratio = np.where(slowest[:, None] > 0.0, own / slowest[:, None], np.nan)
    near = np.flatnonzero(np.fmin.reduce(ratio, axis=0) < FACTOR)
    if not len(near):
        return
    row = int(np.nanargmin(ratio[:, near].min(axis=1)))
    line = near[int(np.nanargmin(ratio[row, near]))]
    names = ", ".join(robot.lines[each].name for each in near)
    yield (
        f"own vibration of line {names}: {own[row, line]:.3g} Hz is less than {FACTOR:g} times the platform's slowest "
        f"mode there, {slowest[row]:.3g} Hz, and may move it by more than 0.3 %"
    )
