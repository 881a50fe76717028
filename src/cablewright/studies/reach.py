"""Reach of the nozzle: a grid over the frame, with nodes where tension limits and an allowed error are met."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import combinations, product
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError
from cablewright.foundation.progress import Progress, silent
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot
from cablewright.solvers.inverse import BLOCK, solve_inverse
from cablewright.studies.accuracy import accuracy

NODES: Final = 25
"""Nodes along the longest side of the frame."""

FEWEST: Final = 9
"""Nodes along a short side."""

_ROUNDING: Final = 1e-9  # m


@dataclass(frozen=True, eq=False)
class Reach:
    """Nodes at which the nozzle can be. ``axes``: coordinates of the nodes, m; ``holds``: (nx, ny, nz).

    ``directions``: rows (3, 3), unit vectors along the axes, world. They are the world's; in a plane that is not level
    they are to the right, across the plane, where there is one node, and up the plane.
    """

    axes: tuple[Array, Array, Array]
    holds: Mask
    directions: Array = field(default_factory=lambda: np.eye(3))

    @property
    def cells(self) -> Mask:
        """Mask of cells (nx - 1, ny - 1, nz - 1) with all corners reachable; of one node along an axis, one cell."""
        found = self.holds
        for k in range(3):
            if found.shape[k] > 1:
                found = np.minimum(np.take(found, range(found.shape[k] - 1), axis=k),
                                   np.take(found, range(1, found.shape[k]), axis=k))  # fmt: skip
        return np.asarray(found)

    def within(self, points: Array) -> Mask:
        """Return whether points (..., 3), m, in coordinates along the axes, are in reachable cells."""
        cells = self.cells
        inside = np.ones(points.shape[:-1], np.bool_)
        index = []
        for k, axis in enumerate(self.axes):
            at = np.searchsorted(axis, points[..., k], side="right") - 1
            if len(axis) == 1:
                index.append(np.zeros_like(at))
                continue
            inside &= (points[..., k] >= axis[0] - 1e-9) & (points[..., k] <= axis[-1] + 1e-9)
            index.append(np.clip(at, 0, len(axis) - 2))
        return np.asarray(inside & cells[tuple(index)])

    @property
    def is_flat(self) -> bool:
        """Whether the nozzle moves in a plane."""
        return any(len(axis) == 1 for axis in self.axes)

    @property
    def volume(self) -> float:
        """Volume of the cells, m^3; in a plane their area, m^2."""
        size = float(np.prod([axis[1] - axis[0] for axis in self.axes if len(axis) > 1]))
        return size * int(self.cells.sum())

    def up_to(self, low: float, high: float) -> Mask:
        """Return whether all cells from *low* to *high*, m, are reachable over each position (nx - 1, ny - 1)."""
        cells, z = self.cells, self.axes[2]
        layers = [k for k in range(cells.shape[2]) if z[k] < high - 1e-9 and z[min(k + 1, len(z) - 1)] > low + 1e-9]
        return np.asarray(cells[:, :, layers].all(axis=2))


def reach(robot: Robot, *, max_error: float | None = None, nodes: int = NODES, progress: Progress = silent) -> Reach:
    """Return where the unrotated platform can bring the nozzle: within the tension limits, with all physics, at rest.

    *max_error*: m, that the expected error of the nozzle may have, by first order of the file's uncertainty; None: any.
    Raises `InputError` where the frame's box misses the robot's plane.
    """
    axes, directions = _grid(robot, nodes)
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3) @ directions
    holds = np.zeros(len(points), np.bool_)
    model = Model.full(robot)
    for first in range(0, len(points), BLOCK):
        progress("reach", first, len(points))
        at = slice(first, first + BLOCK)
        holds[at] = held_at(model, points[at]).holds
    low, high = np.array(robot.scene.frame_min), np.array(robot.scene.frame_max)
    holds &= ((points >= low - _ROUNDING) & (points <= high + _ROUNDING)).all(axis=1)
    if max_error is not None and holds.any():
        some = np.flatnonzero(holds)
        found = accuracy(robot, model.unrotated_at(points[some]).tolist(), method="first-order")
        holds[some] = found.spread.max_error <= max_error
    progress("reach", len(points), len(points))
    return Reach((axes[0], axes[1], axes[2]), holds.reshape([len(axis) for axis in axes]), directions)


def _grid(robot: Robot, nodes: int) -> tuple[list[Array], Array]:
    """Return coordinates of nodes along three axes, m, and the directions (3, 3) of the axes: see `Reach`.

    They span the frame's box, or its section with a plane that is not level. Raises `InputError` where it has none.
    """
    low, high = np.array(robot.scene.frame_min), np.array(robot.scene.frame_max)
    plane, nozzle, directions = robot.platform.plane, np.array(robot.platform.nozzle), np.eye(3)
    fixed = {axis: at + float(nozzle[axis]) for axis, at in robot.platform.fixed.items()}
    if plane is not None and plane.axis != 2:
        right, up = plane.directions
        directions = np.array([right, np.cross(up, right), up])
        corners = [(each, plane.height(each - nozzle)) for each in map(np.array, product(*zip(low, high, strict=True)))]
        section = [a + (b - a) * (x / (x - y) if x != y else 0.0)
                   for (a, x), (b, y) in combinations(corners, 2) if x * y <= 0.0]  # fmt: skip
        if not section:
            raise InputError(
                f"robot {robot.name!r}: scene.frame_min, frame_max: the box misses the plane {plane} in which the "
                "nozzle moves; give a box around what the nozzle reaches"
            )
        along = np.array(section) @ directions.T
        low, high = along.min(axis=0), along.max(axis=0)
        fixed = {1: float(low[1])}
    step = float((high - low).max()) / (nodes - 1)
    axes = [np.linspace(a, b, max(FEWEST, round((b - a) / step) + 1)) for a, b in zip(low, high, strict=True)]
    for axis, coordinate in fixed.items():
        axes[axis] = np.array([coordinate])
    return axes, directions


def held_at(model: Model, nozzle: Array) -> Equilibrium:
    """Return the equilibria of the unrotated platform with its nozzle at positions (k, 3), m."""
    return solve_inverse(model, model.unrotated_at(nozzle))
