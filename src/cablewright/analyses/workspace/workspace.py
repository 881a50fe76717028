"""The workspace of a robot under a criterion: volume with an error, surface and slices, or a count of grid nodes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Unpack

import numpy as np
from numpy.typing import ArrayLike

from cablewright.analyses.workspace.criterion import Criterion, Options, criterion_figures
from cablewright.analyses.workspace.refinement import RefinementSettings, SearchBox, checked_grid, refine
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError
from cablewright.foundation.progress import Progress
from cablewright.foundation.results import Figure, Pictured, Result
from cablewright.foundation.triangle_mesh import TriangleMesh
from cablewright.models.statics import Model
from cablewright.robot import Robot

GRID = 41  # default number of nodes along a side
SECTIONS = 21  # number of heights at which a workspace reports its area
MAX_NODES = 20_000_000
NEAR = 1e-9  # of the box's height: a section on the floor is taken this far above it


COUNTED = (
    Figure("box", "m", "Box that was searched: min and max corner, world.", "box.corners", shown="m"),
    Figure("volume", "m^3", "Volume of the workspace."),
    Figure("volume_error", "m^3", "Estimated error of the volume.", digits=2),
    Figure("fraction", "1", "Share of the box that is inside.", name="share of the box", shown="%"),
    Figure("nodes", "1", "Number of places tried."),
)
SLICE = (
    Figure("heights", "m", "Height of the section.", name="height", shown="m"),
    Figure("areas", "m^2", "Area of the section that is inside.", name="area"),
)
VERDICTS = {
    "empty": "no place in the box was found inside",
    "not-converged": "the volume's error stays over the tolerance: give a larger --tolerance, or a smaller --box "
    "around it; one without thickness has an area",
}


@dataclass(frozen=True, eq=False, repr=False)
class Workspace(Pictured):
    """The region of a box where a criterion holds, as a closed surface."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok, empty, or not-converged: the error is over the tolerance."),
        *criterion_figures("criterion"),
        Figure("count", "", "How the volume is found.", lambda _found: "volume", detail=True),
        *COUNTED,
        Figure(
            "unseen", "m^3", "Part of the error: volumes so small that random places may have missed them.", detail=True
        ),
        Figure("cells", "1", "Cells of the finest lattice along the sides of the box."),
        Figure("surface_area", "m^2", "Area of the boundary.", "mesh.area"),
        Figure("slices", "", "Level sections.", "sections", parts=SLICE),
    )
    HEADLINES: ClassVar = ("robot", "criterion", "volume", "volume_error", "status")

    criterion: Criterion
    mesh: TriangleMesh  # m
    volume_error: float  # m^3; see `refine`
    unseen: float  # m^3, part of the error: parts or holes so small that random points may have missed them
    nodes: int  # number of evaluated positions
    cells: tuple[int, int, int]  # of the finest lattice along the sides of the box
    converged: bool  # whether the error is at most the tolerance

    @property
    def status(self) -> str:
        """Status of the computed workspace: ok, empty or not-converged."""
        return "empty" if not self.volume else "ok" if self.converged else "not-converged"

    @property
    def refusal(self) -> str:
        """Why the workspace is empty, or its computation did not converge, in a sentence; else an empty text."""
        return VERDICTS.get(self.status, "")

    @property
    def box(self) -> SearchBox:
        """The box that was searched for the workspace."""
        return self.criterion.box

    @property
    def sections(self) -> dict[str, Array]:
        """Heights (k,), m, from the bottom of the box to its top, and areas (k,), m^2, of the sections there."""
        heights = np.linspace(self.box.low[2], self.box.high[2], SECTIONS)
        return {"heights": heights, "areas": self.slices(heights)}

    @property
    def volume(self) -> float:
        """Volume of the workspace, m^3: that enclosed by its surface."""
        return self.mesh.volume

    @property
    def fraction(self) -> float:
        """Volume of the workspace as a share of the searched box."""
        return self.volume / self.box.volume

    def slices(self, heights: ArrayLike) -> Array:
        """Return the areas (k,), m^2, of the level sections at *heights* (k,), m; 0 outside the box."""
        low, high = self.box.low[2], self.box.high[2]
        floor = low + NEAR * (high - low)
        inside = [low <= z <= high for z in np.atleast_1d(heights)]
        areas = [self.mesh.section_area(2, max(z, floor)) for z in np.atleast_1d(heights)]
        return np.where(inside, areas, 0.0)


@dataclass(frozen=True, eq=False, repr=False)
class NodeCount(Result):
    """Nodes of a grid over a box that are in the workspace."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok, or empty."),
        *criterion_figures("criterion"),
        Figure("count", "", "How the volume is found.", lambda _found: "nodes", detail=True),
        *COUNTED,
        Figure("counted", "1", "Number of nodes inside."),
        Figure("slices", "", "Layers of nodes.", "sections", parts=SLICE),
    )
    HEADLINES: ClassVar = ("robot", "criterion", "volume", "nodes", "counted")

    criterion: Criterion
    inside: Mask  # (X, Y, Z)

    @property
    def columns(self) -> dict[str, Array | Mask]:
        """Columns (k,) of `to_frame`: the nodes, m, and whether they are inside."""
        nodes = self.box.grid(self.inside.shape).reshape(-1, 3)
        return dict(zip("xyz", nodes.T, strict=True)) | {"inside": self.inside.ravel()}

    @property
    def status(self) -> str:
        """Status of the count: ok or empty."""
        return "ok" if self.counted else "empty"

    @property
    def refusal(self) -> str:
        """Why the workspace is empty, or its computation did not converge, in a sentence; else an empty text."""
        return VERDICTS.get(self.status, "")

    @property
    def sections(self) -> dict[str, Array]:
        """Heights (Z,), m, of the layers of nodes, and their areas (Z,), m^2."""
        return {"heights": self.axes[2], "areas": self.slices()}

    @property
    def box(self) -> SearchBox:
        """The box that the grid of nodes fills, its sides included."""
        return self.criterion.box

    @property
    def axes(self) -> tuple[Array, Array, Array]:
        """Coordinates of the nodes along x, y, z, m."""
        return self.box.axes(self.inside.shape)

    @property
    def places(self) -> Array:
        """Positions (N, 3) of the nodes that are inside, m: z changes fastest, then y, then x."""
        return self.box.grid(self.inside.shape)[self.inside]

    @property
    def nodes(self) -> int:
        """Number of nodes of the grid."""
        return int(self.inside.size)

    @property
    def counted(self) -> int:
        """Number of nodes inside the workspace."""
        return int(self.inside.sum())

    @property
    def fraction(self) -> float:
        """Share of the grid's nodes inside the workspace."""
        return self.counted / self.nodes

    @property
    def volume(self) -> float:
        """`fraction` of the box, m^3, as in Jung 2020.

        Nodes on the sides of the box count as much as others, which overestimates the volume by about one cell's width
        of its surface there: 2.97 instead of 3.19 m^3 for his Table 1. `trapezoid_volume` avoids this.
        """
        return self.fraction * self.box.volume

    @property
    def trapezoid_volume(self) -> float:
        """Volume, m^3, in which a node on a side of the box counts half, one on an edge a quarter."""
        widths = [np.r_[0.5, np.ones(len(axis) - 2), 0.5] * (axis[1] - axis[0]) for axis in self.axes]
        return float(np.einsum("ijk,i,j,k->", self.inside.astype(np.float64), *widths))

    @property
    def volume_error(self) -> float:
        """Error of `volume`, m^3: half of the cells at the boundary, plus the overestimate of a box that is full."""
        cells = np.array(self.inside.shape) - 1
        corners = [self.inside[i : i + cells[0], j : j + cells[1], k : k + cells[2]] for i, j, k in np.ndindex(2, 2, 2)]
        crossed = np.any(corners, axis=0) & ~np.all(corners, axis=0)
        ends = 1.0 - float(np.prod(cells / (cells + 1.0)))
        return 0.5 * float(crossed.mean()) * self.box.volume + ends * self.volume

    def slices(self) -> Array:
        """Return the areas (Z,), m^2, of the layers of nodes: the share of a layer's nodes that are inside."""
        sides = self.box.high - self.box.low
        return np.asarray(self.inside.mean(axis=(0, 1)) * sides[0] * sides[1])


def workspace(
    robot: Robot | Model,
    criterion: str = "exact",
    *,
    tolerance: float | None = None,
    grid: int | None = None,
    seed: int = 0,
    progress: Progress | None = None,
    **options: Unpack[Options],
) -> Workspace:
    """Compute the region of a *box* (x0, x1, y0, y1, z0, z1, m; default: the robot's frame) where a *criterion* holds.

    ``closed-form``, ``improved-closed-form`` and ``exact`` are methods of `distribute`: tensions of straight lines
    within their limits balance the weight and the platform's own wrench, or *wrench* (n,), N and N m, in its place.
    ``capacity``: they balance each wrench of *wrench_box*, the lowest and the highest (n,), moments divided by *arm*
    (default: 1 m). ``wrench-closure``: tensions without upper limit balance any wrench. ``static``: the inverse problem
    has a solution under all laws of the model, such as sag, and it is within every limit of the hardware at rest.

    *options* are keyword arguments. *cable* is by default ``catenary`` for ``static``, else ``rigid``; *sheave*
    simplifies the sheaves as built; *tension_limits*, N, replace the lines' own. A position is that of the *point*
    ``nozzle`` (default) or ``origin``, the platform's. *orientations* (K, 3) are rotation vectors of at most pi, rad
    (default: unrotated): the criterion has to hold under each, the total-orientation workspace; without any, the
    workspace is empty. *retraction* is the platform's retraction length, m, or a `RetractionLaw`. *margins*: who
    computes the criterion, such as `SharedMargin` of `running/executors/parallel_margins.py`; by default this program.

    The surface is refined until the volume's error is at most *tolerance* of the volume (default: 0.002), or to *grid*
    nodes along the longest side. The result has not converged if that takes more than some 20 million evaluations.
    Parts, holes and walls thinner than a sixteenth of the longest side can be missed; random points (*seed*) look for
    them, and their volume is part of the error. Raises `InputError`.

    A planar robot has no volume: see `workspace_area`.

    Examples
    --------
    >>> import cablewright as cw
    >>> cw.workspace(cw.load("jung2020-table1"), tolerance=0.02).status
    'ok'
    """
    settings = RefinementSettings.of(tolerance, grid, seed)
    chosen = Criterion.of(robot, criterion, **options)

    def margin(places: Array, stage: str) -> Array:
        return chosen.continuous_margin(places, progress, stage)

    found = refine(margin, chosen.box, replace(settings, continuous=chosen.continuous))
    return Workspace(chosen, found.mesh, found.error, found.unseen, found.places, found.cells, found.converged)


def count_nodes(
    robot: Robot | Model,
    criterion: str = "exact",
    *,
    grid: int | None = None,
    step: float | None = None,
    progress: Progress | None = None,
    flat: bool = False,
    **options: Unpack[Options],
) -> NodeCount:
    """Evaluate the criterion at the nodes of a grid: *grid* along each side (default: 41), or at most *step* (m) apart.

    *flat*: whether the box may be flat, as in `workspace_area`; two nodes are then in one place. *options* and other
    arguments are as for `workspace`. Raises `InputError`.
    """
    if grid is not None and step is not None:
        raise InputError("grid and step: give one of them, not both")
    chosen = Criterion.of(robot, criterion, flat=flat, **options)
    counts = (checked_grid(GRID if grid is None else grid),) * 3 if step is None else _counts(chosen.box, step)
    if flat and chosen.box.is_flat:
        x, y, z = (2 if axis == chosen.box.flat_axis else count for axis, count in enumerate(counts))
        counts = x, y, z
    inside = chosen.margin(chosen.box.grid(counts).reshape(-1, 3), progress, "nodes") >= 0.0
    return NodeCount(chosen, inside.reshape(counts))


def _counts(box: SearchBox, step: float) -> tuple[int, int, int]:
    """(3,) numbers of nodes along x, y, z, at most *step* (m) apart. Raises `InputError`."""
    shortest = float((box.high - box.low).min())
    if not 0.0 < step <= shortest:
        raise InputError(f"step {step:g} m: more than 0 and at most {shortest:g} m, a side of the box, is allowed")
    x, y, z = (int(np.ceil(side / step - 1e-9)) + 1 for side in box.high - box.low)
    if x * y * z > MAX_NODES:
        raise InputError(f"step {step:g} m: {x * y * z} nodes; at most {MAX_NODES} are allowed")
    return x, y, z
