"""Check, before a person orders a motion by hand, that the platform can be held on the straight way to its goal."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.models.free_coordinates import decided_by_weight
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse

POSES: Final = 33
"""Poses along the way at which tensions are solved."""


def reach(robot: Robot, begin: Array, goal: Array, low: Array, high: Array) -> dict[str, Any]:
    """Return whether the platform can be held on the straight way from the pose *begin* (n,) to *goal* (3,), m.

    *low* and *high* (3,), m: corners within which motions by hand stay. The point that moves is the nozzle of a rigid
    platform, and of a point platform the platform. ``margin``: N, smallest distance of a tension from its limits.
    Obstacles and what is printed are not looked at.
    """
    for axis, least, at, most in zip("xyz", low, goal, high, strict=True):
        if not least <= at <= most:
            return {"holds": False, "why": f"{axis} = {at:.3f} m is outside {least:g} to {most:g} m"}
    model = Model.of(robot)
    rigid = robot.n > 3
    from_here = model.nozzle(begin) if rigid else begin
    poses = np.tile(begin, (POSES, 1))
    poses[:, :3] = np.linspace(from_here, goal, POSES)
    poses = model.at_nozzle(poses) if rigid else poses
    poses[:, decided_by_weight(robot)] = np.nan
    found = solve_inverse(model, poses)
    margins = np.where(found.holds, np.nan_to_num(found.margin(), nan=-np.inf), -np.inf)
    length = float(np.linalg.norm(goal - from_here))
    worst = int(np.argmin(margins))
    if margins[worst] < 0.0:
        first = int(np.flatnonzero(margins < 0.0)[0])
        why = f"from {length * first / (POSES - 1):.3f} m on, no tensions within the limits hold the platform"
        return {"holds": False, "why": why, "length": length}
    return {"holds": True, "why": "", "length": length, "margin": float(margins[worst])}
