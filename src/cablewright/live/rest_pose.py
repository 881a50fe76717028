"""A pose to show a robot at before any job: it rests within its limits, near the middle of its frame.

And a lattice of poses about it, each solved at rest, for the viewer.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array, Indices, Mask
from cablewright.models.free_coordinates import decided_by_weight
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse

_HEIGHTS: Final = (0.4, 0.3, 0.5, 0.2, 0.6, 0.1, 0.7, 0.05, 0.8)  # shares of the frame's height, the best first
_ASIDE: Final = (0.0, 0.15, -0.15, 0.3, -0.3)  # shares of the frame's width from its middle


@dataclass(frozen=True, eq=False)
class Lattice:
    """Poses on a grid about the middle of the frame, unrotated, each solved at rest.

    ``axes``: values of the nozzle's x, y and z, m; one alone where weight or a plane decides. ``found``: x is fastest.
    """

    axes: tuple[Array, Array, Array]
    found: Equilibrium
    notes: tuple[str, ...]  # the meaning of each row: a sentence without its end


@dataclass(frozen=True, eq=False)
class RestPose:
    """A pose and its lines.

    ``held``: whether it is an equilibrium within the robot's limits; ``row``: index of its row in *lattice*.
    """

    equilibrium: Equilibrium
    held: bool
    note: str
    lattice: Lattice
    row: int


def rest_pose(robot: Robot | Model) -> RestPose:
    """Return the first pose of a few near the middle of the frame that the robot holds, unrotated, at rest.

    Of a robot with fewer winches than degrees of freedom, weight decides the rotation. Where it holds none of them, the
    first is returned with ``held`` False and the reason as a note; its tensions are not those of an equilibrium.
    """
    model = Model.of(robot)
    places = _places(model.robot)
    poses = _poses(model, places)
    found = solve_inverse(model, poses)
    held = found.holds
    fits = held & (np.nan_to_num(found.margin(), nan=-1.0) >= 0.0)
    best = int(np.argmax(2 * fits + held))  # the first of those that are best
    notes = tuple(_note(found, k, bool(fits[k])) for k in range(len(places)))
    order, axes = _in_order(places, np.isfinite(poses[:, :3]))
    row = int(np.flatnonzero(_same(places[order], places[best], axes))[0])
    lattice = Lattice(axes, found[order], tuple(notes[k] for k in order))
    return RestPose(found[best], bool(held[best]), notes[best], lattice, row)


def _note(found: Equilibrium, k: int, fits: bool) -> str:
    if fits:
        return "at rest: an equilibrium within the limits of the robot file"
    if found.holds[k]:
        return "at rest: an equilibrium, but with tensions outside the limits of the robot file"
    return f"not in equilibrium: {found[k].sentence()}; the lines are drawn as near to it as they come"


def _in_order(places: Array, chosen: Mask) -> tuple[Indices, tuple[Array, Array, Array]]:
    """Return the rows of a lattice, x fastest, and its axes; *chosen* (k, 3): coordinates that are no free ones."""
    x, y, z = (
        np.unique(own if own_chosen.any() else own[:1]) for own, own_chosen in zip(places.T, chosen.T, strict=True)
    )
    kept = np.flatnonzero(np.isin(places[:, 0], x) & np.isin(places[:, 1], y) & np.isin(places[:, 2], z))
    return kept[np.lexsort(places[kept].T)], (x, y, z)


def _same(places: Array, wanted: Array, axes: tuple[Array, Array, Array]) -> Mask:
    """Which places agree with *wanted* along all axes that have more than one value."""
    varied = [len(each) > 1 for each in axes]
    return np.asarray((places[:, varied] == wanted[varied]).all(axis=1))


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
    poses[:, decided_by_weight(model.robot)] = np.nan
    if model.robot.platform.plane is not None:
        normal = np.abs(np.array(model.free_directions)[:3]).sum(axis=1)
        poses[:, int(np.argmin(normal))] = np.nan
    return poses
