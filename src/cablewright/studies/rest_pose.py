"""A pose to show a robot at before any job: where it can rest within its limits, near the middle of its frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from cablewright.arrays import Array
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse

_HEIGHTS: Final = (0.4, 0.3, 0.5, 0.2, 0.6, 0.1, 0.7, 0.05, 0.8)  # shares of the frame's height, the best first
_ASIDE: Final = (0.0, 0.15, -0.15, 0.3, -0.3)  # shares of the frame's width from its middle


@dataclass(frozen=True, eq=False)
class RestPose:
    """A pose and its lines. ``held``: whether it is an equilibrium within the robot's limits."""

    equilibrium: Equilibrium
    held: bool
    note: str


def rest_pose(robot: Robot | Model) -> RestPose:
    """Return the first pose of a few near the middle of the frame that the robot holds, unrotated, at rest.

    Of a robot with fewer lines than freedoms, weight decides the rotation. Where it holds none of them, the first is
    returned with ``held`` False and the reason as a note; its tensions are not those of an equilibrium.
    """
    model = Model.of(robot)
    places = _places(model.robot)
    found = solve_inverse(model, _poses(model, places))
    fits = np.flatnonzero(found.ok & (np.nan_to_num(found.margin(), nan=-1.0) >= 0.0))
    if len(fits):
        return RestPose(found[int(fits[0])], True, "at rest: an equilibrium within the limits of the robot file")
    solved = np.flatnonzero(found.ok)
    if len(solved):
        note = "at rest: an equilibrium, but with tensions outside the limits of the robot file"
        return RestPose(found[int(solved[0])], True, note)
    first = found[0]
    words = f"not in equilibrium: {first.sentence()}; the lines are drawn as near to it as they come"
    return RestPose(first, False, words)


def _places(robot: Robot) -> Array:
    """Positions (k, 3), m, of the nozzle, those to be tried first first."""
    low, high = np.array(robot.scene.frame_min), np.array(robot.scene.frame_max)
    shares = [
        (0.5 + x, 0.5 + y, z)
        for x, y in sorted(((x, y) for x in _ASIDE for y in _ASIDE), key=lambda at: abs(at[0]) + abs(at[1]))
        for z in _HEIGHTS
    ]
    return np.asarray(low + np.array(shares) * (high - low))


def _poses(model: Model, places: Array) -> Array:
    """The poses (k, n) with the nozzle there; NaN where gravity or a plane decides."""
    poses = np.array(model.unrotated_at(places))
    missing = model.freedoms - model.m
    if model.robot.platform.plane is None and missing > 0:
        free = (3, 4, 5, 1, 0) if model.n == 6 else (1, 0)
        poses[:, list(free[:missing])] = np.nan
    elif model.robot.platform.plane is not None:
        normal = np.abs(np.array(model.free_directions)[:3]).sum(axis=1)
        poses[:, int(np.argmin(normal))] = np.nan
    return poses
