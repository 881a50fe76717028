"""The workspace in a plane: the area where a criterion holds, with an error, and its outlines.

The plane is searched as the volume of a plate on which the criterion does not change from one side to the other.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Unpack

import numpy as np

from cablewright.analyses.workspace.criterion import Criterion, Options, criterion_figures
from cablewright.analyses.workspace.refinement import FIRST, MIN_CELLS, RefinementSettings, SearchBox, refine
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.progress import Progress
from cablewright.foundation.results import Figure, Pictured
from cablewright.models.statics import Model
from cablewright.robot import Robot

THICKNESS = MIN_CELLS / FIRST  # of the longest side: the plate is as thick as the fewest cells are wide
SAME = 1e-9  # of the thickness: distance of points of an outline that are one
VERDICTS = {
    "empty": "no place in the box was found inside",
    "not-converged": "the area's error stays over the tolerance: give a larger --tolerance, or a smaller --box",
}


@dataclass(frozen=True, eq=False, repr=False)
class WorkspaceArea(Pictured):
    """The region of a plane where a criterion holds, within closed outlines."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok, empty, or not-converged: the error is over the tolerance."),
        *criterion_figures("criterion"),
        Figure("count", "", "Measured quantity.", lambda _found: "area", detail=True),
        Figure("box", "m", "Box that was searched: min and max corner, world.", "box.corners", shown="m"),
        Figure("normal", "", "Axis across the plane: x, y or z; of a tilted plane its unit vector."),
        Figure("area", "m^2", "Area of the workspace."),
        Figure("area_error", "m^2", "Estimated error of the area.", digits=2),
        Figure("fraction", "1", "Share of the box that is inside.", name="share of the box", shown="%"),
        Figure("nodes", "1", "Number of places tried."),
        Figure("unseen", "m^2", "Part of the error: areas so small that random places miss them.", detail=True),
        Figure("perimeter", "m", "Length of all outlines."),
        Figure("outlines", "m", "Closed outlines, world; those of holes run the other way.", detail=True),
    )
    HEADLINES: ClassVar = ("robot", "criterion", "area", "area_error", "status")

    criterion: Criterion
    outlines: tuple[Array, ...]  # (P, 3) each, m
    area: float  # m^2
    area_error: float  # m^2
    unseen: float  # m^2
    nodes: int
    converged: bool

    @property
    def status(self) -> str:
        """Status of the computed area: ok, empty or not-converged."""
        return "empty" if not self.area else "ok" if self.converged else "not-converged"

    @property
    def refusal(self) -> str:
        """Sentence that explains why there is no converged area; empty if there is one."""
        return VERDICTS.get(self.status, "")

    @property
    def box(self) -> SearchBox:
        """The region that was searched, flat along one axis, or about the part of a tilted plane."""
        return self.criterion.box

    @property
    def normal(self) -> str:
        """The axis across the plane, or the components of its unit normal."""
        return self.criterion.search_plane.name

    @property
    def fraction(self) -> float:
        """Area of the workspace as a share of the searched box."""
        return self.area / self.criterion.search_plane.area_in(self.box)

    @property
    def perimeter(self) -> float:
        """Length of all outlines of the workspace, m."""
        return float(sum(np.linalg.norm(each - np.roll(each, 1, axis=0), axis=1).sum() for each in self.outlines))


def workspace_area(
    robot: Robot | Model,
    criterion: str = "exact",
    *,
    tolerance: float | None = None,
    grid: int | None = None,
    seed: int = 0,
    progress: Progress | None = None,
    **options: Unpack[Options],
) -> WorkspaceArea:
    """Compute the region of a plane where a *criterion* holds; arguments as for `workspace`.

    The *box* has two equal ends, those of the plane. Without one it is the part of the frame in the plane of a planar
    robot: a point whose exit points have one coordinate in common, and which nothing pulls along that axis. What keeps
    the platform in the plane is not looked at. Of a platform in a tilted plane the part of that plane in the *box* is
    searched, which is then not flat. Raises `InputError`, also for a robot that is not planar and no box.

    Examples
    --------
    >>> import cablewright as cw
    >>> level = cw.workspace_area(cw.load("jung2020"), box=[-1, 1, -1, 1, 0.8, 0.8])
    >>> f"{level.area:.2f} m^2"
    '2.81 m^2'
    """
    settings = RefinementSettings.of(tolerance, grid, seed)
    chosen = Criterion.of(robot, criterion, flat=True, **options)
    box, search_plane = chosen.box, chosen.search_plane
    if not (box.is_flat or search_plane.is_tilted):
        raise InputError("workspace_area: the robot is not planar; give a flat box, with two equal ends along one axis")
    axis = search_plane.axis
    thickness = THICKNESS * float(np.delete(box.high - box.low, axis).max())
    high, tried = box.high.copy(), 0
    high[axis] = box.low[axis] + thickness

    def margin(places: Array, stage: str) -> Array:
        """Return the margin of the criterion in the plane; of a tilted plane, negative where that leaves the box.

        It is the same for all positions across the plane.
        """
        nonlocal tried
        first, second = np.delete(places, axis, axis=1).T
        _, one, all_of = np.unique(first + 1j * second, return_index=True, return_inverse=True)
        flat = search_plane.onto(places[one])
        tried += len(flat)
        margins = chosen.continuous_margin(flat, progress, stage)
        inside = ((box.low <= flat) & (flat <= box.high)).all(axis=1) | (not search_plane.is_tilted)
        return np.where(inside, margins, -np.inf)[all_of]

    found = refine(margin, SearchBox(box.low, high), replace(settings, continuous=chosen.continuous))
    outlines = []
    for outline in found.mesh.section(axis, box.low[axis] + 0.5 * thickness):
        points = np.zeros((len(outline), 3))
        points[:, (axis + 1) % 3], points[:, (axis + 2) % 3] = outline.T
        points = search_plane.onto(points)
        apart = np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1) > SAME * thickness
        outlines.append(points[apart])  # edges across the plate all meet the surface at one place
    size = thickness * abs(float(search_plane.normal[axis]))
    area, error, unseen = (part / size for part in (found.mesh.volume, found.error, found.unseen))
    return WorkspaceArea(chosen, tuple(outlines), area, error, unseen, tried, found.converged)
