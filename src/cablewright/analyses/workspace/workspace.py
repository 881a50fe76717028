"""The workspace of a robot by a criterion: its volume with an error, its surface, its slices, or a plain node count."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.analyses.workspace.criterion import Law, Question, ask
from cablewright.analyses.workspace.refinement import Refined, SearchBox, refine
from cablewright.errors import InputError
from cablewright.models.statics import Model
from cablewright.progress import Progress
from cablewright.robot import Robot
from cablewright.triangle_mesh import TriangleMesh

__all__ = ["NodeCount", "Workspace", "count_nodes", "workspace"]

Array = NDArray[np.float64]

NODES = (3, 400)  # fewest and most along a side
TOLERANCES = (1e-5, 0.5)
NEAR = 1e-9  # of a box's height: a section this far inside its floor is that on the floor


@dataclass(frozen=True, eq=False)
class Workspace:
    """Where a criterion holds in a box, as a closed surface."""

    question: Question
    box: SearchBox
    mesh: TriangleMesh  # m
    volume_error: float  # m^3; see `refine`
    unseen: float  # m^3: of the error, parts or holes so small that random places may have missed them
    nodes: int  # how many places were tried
    cells: tuple[int, int, int]  # of the finest lattice along the sides of the box
    converged: bool  # whether the error is what was asked for

    @property
    def volume(self) -> float:
        """m^3."""
        return self.mesh.volume

    @property
    def fraction(self) -> float:
        """Share of the box."""
        return self.volume / self.box.volume

    def slices(self, heights: ArrayLike) -> Array:
        """Areas (k,), m^2, of the sections at *heights* (k,), m."""
        low, high = self.box.low[2], self.box.high[2]
        floor = low + NEAR * (high - low)
        inside = [low <= z <= high for z in np.atleast_1d(heights)]
        areas = [self.mesh.section_area(2, max(z, floor)) for z in np.atleast_1d(heights)]
        return np.where(inside, areas, 0.0)


@dataclass(frozen=True, eq=False)
class NodeCount:
    """Which nodes of a grid are inside; each counts as an equal part of the box, as in Jung 2020.

    Nodes on the sides of the box stand for as much as others, so that the volume is off by about one cell's width of
    its surface: 2.97 instead of 3.19 m^3 for his Table 1.
    """

    question: Question
    box: SearchBox
    inside: NDArray[np.bool_]  # (X, Y, Z)

    @property
    def nodes(self) -> int:
        """How many nodes there are."""
        return int(self.inside.size)

    @property
    def counted(self) -> int:
        """How many of them are inside."""
        return int(self.inside.sum())

    @property
    def fraction(self) -> float:
        """Share of the nodes."""
        return self.counted / self.nodes

    @property
    def volume(self) -> float:
        """That share of the box, m^3."""
        return self.fraction * self.box.volume

    @property
    def volume_error(self) -> float:
        """Half of what the boundary's cells take, and what the count is off by in a box that is full, m^3."""
        cells = np.array(self.inside.shape) - 1
        corners = [self.inside[i : i + cells[0], j : j + cells[1], k : k + cells[2]] for i, j, k in np.ndindex(2, 2, 2)]
        crossed = np.any(corners, axis=0) & ~np.all(corners, axis=0)
        ends = 1.0 - float(np.prod(cells / (cells + 1.0)))
        return 0.5 * float(crossed.mean()) * self.box.volume + ends * self.volume

    @property
    def axes(self) -> tuple[Array, Array, Array]:
        """Coordinates of the nodes along x, y, z, m."""
        x, y, z = (
            np.linspace(float(self.box.low[axis]), float(self.box.high[axis]), self.inside.shape[axis])
            for axis in range(3)
        )
        return x, y, z

    def slices(self) -> Array:
        """Areas (Z,), m^2, of the layers of nodes: the share of a layer's nodes times the floor of the box."""
        sides = self.box.high - self.box.low
        return np.asarray(self.inside.mean(axis=(0, 1)) * sides[0] * sides[1])


def box_of(robot: Robot, ends: ArrayLike | None) -> SearchBox:
    """The box from *ends* (6,) x0, x1, y0, y1, z0, z1, m, or the robot's frame. Raises `InputError`."""
    if ends is None:
        return SearchBox(np.array(robot.scene.frame_min), np.array(robot.scene.frame_max))
    numbers = np.asarray(ends, dtype=np.float64)
    if numbers.shape != (6,) or not np.isfinite(numbers).all():
        raise InputError(f"box: 6 finite numbers are wanted, x0,x1,y0,y1,z0,z1 in m; got {numbers.tolist()}")
    low, high = numbers[::2], numbers[1::2]
    if (low >= high).any():
        axis = int(np.argmax(low >= high))
        raise InputError(f"box: {'xyz'[axis]} from {low[axis]:g} to {high[axis]:g} m: lowest < highest is wanted")
    return SearchBox(low, high)


def workspace(
    model: Model,
    criterion: str = "exact",
    *,
    tolerance: float | None = None,
    grid: int | None = None,
    box: ArrayLike | None = None,
    point: str = "nozzle",
    wrench: ArrayLike | None = None,
    wrench_box: tuple[ArrayLike, ArrayLike] | None = None,
    arm: float = 1.0,
    orientations: ArrayLike | None = None,
    retraction: float | Law | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Workspace:
    """Where in the frame of *model*, or a *box* (x0, x1, y0, y1, z0, z1, m), a *criterion* holds.

    ``closed-form``, ``improved-closed-form`` and ``exact`` are the methods of `distribute`: tensions of straight lines
    within their limits balance the weight and the platform's own wrench, or *wrench* (n,), N and N m, in its place.
    ``capacity``: they balance each wrench of *wrench_box*, the lowest and the highest (n,), moments on an *arm* (m).
    ``wrench-closure``: any wrench, with tensions without limit. ``static``: the inverse problem with all that the
    fidelity of *model* has, sag among it, and every limit of the hardware at rest.

    A place is that of the nozzle or, by *point*, the platform's origin. *orientations* (K, 3), rotation vectors of at
    most pi, rad: a place counts if the criterion holds for each, the total-orientation workspace; unrotated if None.
    *retraction* is the platform's length, m, or a `Law` of it.

    The surface is refined until the volume's error is at most *tolerance* of it (0.002 if neither is given), or to
    *grid* nodes along the longest side. Parts, holes and walls thinner than a sixteenth of that side can be missed;
    random places (*seed*) look for them, and their share is in the error. Raises `InputError`.
    """
    where = box_of(model.robot, box)
    if tolerance is not None and grid is not None:
        raise InputError("grid and tolerance: give one of them")
    if tolerance is not None and not TOLERANCES[0] <= tolerance <= TOLERANCES[1]:
        raise InputError(f"tolerance {tolerance:g}: {TOLERANCES[0]:g} to {TOLERANCES[1]:g} of the volume is allowed")
    if seed < 0:
        raise InputError(f"seed {seed}: 0 or more is wanted")
    given: dict[str, Any] = {"point": point, "wrench": wrench, "wrench_box": wrench_box, "arm": arm}
    asked = ask(model, criterion, _heights(where), **given, orientations=orientations, retraction=retraction)
    finest = None if grid is None else _checked_grid(grid) - 1
    tolerance = 2e-3 if tolerance is None else tolerance
    found = refine(partial(asked.tending, progress=progress), where, tolerance=tolerance, finest=finest, seed=seed)
    return _as_workspace(asked, where, found)


def count_nodes(
    model: Model,
    criterion: str = "exact",
    *,
    grid: int = 41,
    box: ArrayLike | None = None,
    point: str = "nozzle",
    wrench: ArrayLike | None = None,
    wrench_box: tuple[ArrayLike, ArrayLike] | None = None,
    arm: float = 1.0,
    orientations: ArrayLike | None = None,
    retraction: float | Law | None = None,
    progress: Progress | None = None,
) -> NodeCount:
    """Which nodes of *grid* along each side of the box are inside; all else as for `workspace`."""
    where = box_of(model.robot, box)
    given: dict[str, Any] = {"point": point, "wrench": wrench, "wrench_box": wrench_box, "arm": arm}
    asked = ask(model, criterion, _heights(where), **given, orientations=orientations, retraction=retraction)
    along = np.arange(_checked_grid(grid)) / (grid - 1)
    shares = np.stack(np.meshgrid(along, along, along, indexing="ij"), axis=-1).reshape(-1, 3)
    inside = asked.margin(where.at(shares), progress, "nodes") >= 0.0
    return NodeCount(asked, where, inside.reshape(grid, grid, grid))


def _heights(box: SearchBox) -> tuple[float, float]:
    return float(box.low[2]), float(box.high[2])


def _checked_grid(grid: int) -> int:
    if not NODES[0] <= grid <= NODES[1]:
        raise InputError(f"grid {grid}: {NODES[0]} to {NODES[1]} nodes along a side are allowed")
    return grid


def _as_workspace(asked: Question, where: SearchBox, found: Refined) -> Workspace:
    return Workspace(asked, where, found.mesh, found.error, found.unseen, found.poses, found.cells, found.converged)
