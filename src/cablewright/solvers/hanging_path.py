"""Poses along a path of a robot with fewer winches than degrees of freedom, whose platform and nozzle tilt."""

from __future__ import annotations

from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.models.free_coordinates import with_free
from cablewright.models.statics import Model
from cablewright.solvers.inverse import solve_inverse

_TOLERANCE: Final = 1e-9  # m, of the nozzle
_STEPS: Final = 20


def nozzle_on_path(model: Model, poses: Array, positions: Array, retraction: Array | None = None) -> Array:
    """Return *poses* (k, n) moved so that at rest the nozzle is at *positions* (k, 3), m, however the platform tilts.

    Coordinates that are NaN, which equilibrium decides, stay NaN; where it decides a position too, the nozzle misses
    the path by that. Each pass corrects the nozzle error of the last tilt: it converges as long as the tilt changes by
    less than the move over the arm of the nozzle. *retraction* (k,), m. Poses without NaN, or with the nozzle at the
    origin, are returned as they are, and so are poses without an equilibrium.
    """
    if not np.isnan(poses).any() or not any(model.robot.platform.nozzle):
        return poses
    moved, left = poses.copy(), np.arange(len(poses))
    for _ in range(_STEPS):
        drawn = None if retraction is None else retraction[left]
        held = solve_inverse(model, moved[left], path=True, retraction=drawn)
        missed = np.where(held.ok[:, None] & np.isfinite(moved[left, :3]), positions[left] - held.nozzle, 0.0)
        moved[left, :3] += missed
        left = left[np.abs(missed).max(axis=1) > _TOLERANCE]
        if not len(left):
            break
    return moved


def hung(model: Model, poses: Array, retraction: Array | None = None) -> Array:
    """Return *poses* (k, n) completed by equilibrium, with the nozzle kept; NaN marks the coordinates to decide.

    As they are where winches hold all degrees of freedom. *retraction* (k,), m.
    """
    free = with_free(model.robot, poses)
    return poses if free is poses else nozzle_on_path(model, free, model.nozzle(poses), retraction)
