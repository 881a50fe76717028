"""A workspace by a criterion: its surface in the frame, and sections through it; of a planar one its outlines."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from cablewright.analyses.workspace.area import WorkspaceArea
from cablewright.analyses.workspace.criterion import Criterion, RetractionLaw
from cablewright.analyses.workspace.workspace import Workspace
from cablewright.apps import style
from cablewright.apps.space_axes import add_surface, machine
from cablewright.arrays import Array

_HEIGHTS: Final = 201  # of which the largest slice is shown
_MARGIN: Final = 0.05  # of the longest side
_PALE: Final = np.array([0.60, 0.80, 0.93])


def volume_picture(found: Workspace) -> Figure:
    """Draw the surface, the middle sections and the largest horizontal one."""
    drawn = style.figure(10.0, 8.4)
    grid = drawn.add_gridspec(2, 2)
    low, high = found.box.low, found.box.high
    surface = machine(drawn, grid[0, 0], found.criterion.model.robot, low, high)
    add_surface(surface, found.mesh, _PALE, darkest=0.5)
    surface.set_title("boundary, with frame and exit points")
    middle = 0.5 * (low + high)
    heights = np.linspace(low[2], high[2], _HEIGHTS)
    areas = found.slices(heights)
    largest = float(heights[areas.argmax()])
    _section(drawn.add_subplot(grid[0, 1]), found, 1, float(middle[1]))
    _section(drawn.add_subplot(grid[1, 0]), found, 2, largest, f", area {areas.max():.3g} m²")
    _section(drawn.add_subplot(grid[1, 1]), found, 0, float(middle[0]))
    style.headline(drawn, _title(found.criterion, f"{found.volume:.4g} m³", found.fraction))
    return drawn


def area_picture(found: WorkspaceArea) -> Figure:
    """Draw the outlines in their plane, the box and the exit points."""
    axis = "xyz".index(found.normal)
    across, up = [other for other in range(3) if other != axis]
    drawn = style.figure(7.0, 6.0)
    axes = drawn.add_subplot()
    _fill(axes, [outline[:, [across, up]] for outline in found.outlines])
    low, high = found.box.low, found.box.high
    style.rectangle(axes, low, high, (across, up), zorder=2)
    exits = np.array([line.exit_point for line in found.criterion.model.robot.lines])
    beside = np.ptp([*exits[:, axis], found.box.low[axis]]) > 0.0
    seen = f"exit points, seen along {found.normal}" if beside else "exit points"
    axes.plot(exits[:, across], exits[:, up], "o", color=style.INK, label=seen, zorder=4)
    corners = np.vstack([low, high, exits])
    spare = _MARGIN * float(np.ptp(corners, axis=0).max())
    (left, right), (bottom, top) = ((corners[:, each].min(), corners[:, each].max()) for each in (across, up))
    axes.set(xlim=(left - spare, right + spare), ylim=(bottom - spare, top + spare), aspect="equal")
    axes.set(xlabel=f"{'xyz'[across]} in m", ylabel=f"{'xyz'[up]} in m")
    style.round_ticks(axes, 5)
    axes.set_title(style.minus(f"plane at {found.normal} = {low[axis]:.3g} m"))
    drawn.legend(loc="outside lower center")
    style.headline(drawn, _title(found.criterion, f"{found.area:.4g} m²", found.fraction))
    return drawn


def _title(criterion: Criterion, size: str, fraction: float) -> str:
    robot = style.label(criterion.model.robot.name)
    text = f"{robot}, {criterion.name}: {size} of the {criterion.point}, {100.0 * fraction:.1f} % of the box"
    if len(criterion.orientations) > 1:
        text += f", under {len(criterion.orientations)} orientations"
    law = criterion.retraction
    if isinstance(law, RetractionLaw):
        sign = "-" if law.intercept < 0 else "+"
        text += style.minus(f"; retraction length {law.slope:.3g} z {sign} {abs(law.intercept):.3g} m")
    elif law is not None:
        text += f"; retraction length {law:.3g} m"
    return text


def _section(axes: Axes, found: Workspace, axis: int, at: float, more: str = "") -> None:
    """Draw the section at *at*, m, of coordinate *axis*; the first of the other two to the right, the second up."""
    across, up = [other for other in range(3) if other != axis]
    flip = axis == 1  # the outlines are in z, x there
    low, high = found.box.low, found.box.high
    sides = high - low
    inner = float(np.clip(at, low[axis] + 1e-9 * sides[axis], high[axis]))
    outlines = found.mesh.section(axis, inner)
    _fill(axes, [outline[:, ::-1] for outline in outlines] if flip else outlines)
    style.rectangle(axes, low, high, (across, up), zorder=2)
    spare = _MARGIN * sides.max()
    axes.set_xlim(low[across] - spare, high[across] + spare)
    axes.set_ylim(low[up] - spare, high[up] + spare)
    style.round_ticks(axes, 5)
    axes.set(aspect="equal", xlabel=f"{'xyz'[across]} in m", ylabel=f"{'xyz'[up]} in m")
    name = "largest level section" if axis == 2 else "section"
    axes.set_title(style.minus(f"{name} at {'xyz'[axis]} = {at:.3g} m{more}"))


def _fill(axes: Axes, outlines: list[Array]) -> None:
    """Fill closed outlines (P, 2); those that run the other way are holes."""
    codes = [[Path.MOVETO, *[Path.LINETO] * (len(outline) - 1), Path.CLOSEPOLY] for outline in outlines]
    if outlines:
        shape = Path(np.concatenate([np.vstack([outline, outline[:1]]) for outline in outlines]), np.concatenate(codes))
        axes.add_patch(PathPatch(shape, facecolor="#bcd7ea", edgecolor=style.BLUE, linewidth=1.4, zorder=3))
