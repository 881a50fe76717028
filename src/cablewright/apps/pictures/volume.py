"""A workspace by a criterion: its surface in the frame, and sections through it."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch, Rectangle
from matplotlib.path import Path
from matplotlib.ticker import MaxNLocator

from cablewright.analyses.workspace.criterion import RetractionLaw
from cablewright.analyses.workspace.workspace import Workspace
from cablewright.apps import style
from cablewright.apps.space_axes import add_surface, draw_frame, space

_HEIGHTS: Final = 201  # of which the largest slice is shown
_MARGIN: Final = 0.05  # of the longest side
_PALE: Final = np.array([0.60, 0.80, 0.93])


def volume_picture(found: Workspace) -> Figure:
    """Draw the surface, the middle sections and the largest horizontal one. Call within `style.drawing`."""
    drawn = style.figure(10.0, 8.4)
    grid = drawn.add_gridspec(2, 2)
    _surface(drawn, grid[0, 0], found)
    low, high = found.box.low, found.box.high
    middle = 0.5 * (low + high)
    heights = np.linspace(low[2], high[2], _HEIGHTS)
    areas = found.slices(heights)
    largest = float(heights[areas.argmax()])
    _section(drawn.add_subplot(grid[0, 1]), found, 1, float(middle[1]))
    _section(drawn.add_subplot(grid[1, 0]), found, 2, largest, f", area {areas.max():.3g} m²")
    _section(drawn.add_subplot(grid[1, 1]), found, 0, float(middle[0]))
    drawn.suptitle(_title(found), x=0.01, ha="left", fontsize=11, fontweight="bold")
    return drawn


def _title(found: Workspace) -> str:
    criterion = found.criterion
    robot = style.label(criterion.model.robot.name)
    told = f"{robot}, {criterion.name}: {found.volume:.4g} m³ of the {criterion.point}"
    told += f", {100.0 * found.fraction:.1f} % of the box"
    if len(criterion.orientations) > 1:
        told += f", under {len(criterion.orientations)} orientations"
    law = criterion.retraction
    if isinstance(law, RetractionLaw):
        sign = "\N{MINUS SIGN}" if law.intercept < 0 else "+"
        told += f"; length {law.slope:.3g} z {sign} {abs(law.intercept):.3g} m".replace("-", "\N{MINUS SIGN}")
    elif law is not None:
        told += f"; length {law:.3g} m"
    return told


def _surface(drawn: Figure, where: Any, found: Workspace) -> None:
    """Draw the surface in the frame, what is far from the eye first."""
    robot = found.criterion.model.robot
    exits = np.array([line.exit_point for line in robot.lines])
    ends = np.vstack([robot.scene.frame_min, robot.scene.frame_max, exits, found.box.low, found.box.high])
    axes, _ = space(drawn, where, ends.min(axis=0), ends.max(axis=0), "m")
    draw_frame(axes, robot)
    add_surface(axes, found.mesh, _PALE, darkest=0.5)
    axes.set_title("boundary, with frame and exit points")


def _section(axes: Axes, found: Workspace, axis: int, at: float, more: str = "") -> None:
    """Draw the section where coordinate *axis* is *at*: x to the right, or y, and z upwards where it is in it."""
    across, up = [other for other in range(3) if other != axis]
    flip = axis == 1  # outlines come as z, x there
    low, high = found.box.low, found.box.high
    inner = float(np.clip(at, low[axis] + 1e-9 * (high - low)[axis], high[axis]))
    codes, points = [], []
    for outline in found.mesh.section(axis, inner):
        closed = np.vstack([outline, outline[:1]])
        points.append(closed[:, ::-1] if flip else closed)
        codes += [Path.MOVETO, *[Path.LINETO] * (len(outline) - 1), Path.CLOSEPOLY]
    if points:
        shape = Path(np.concatenate(points), codes)
        axes.add_patch(PathPatch(shape, facecolor="#bcd7ea", edgecolor=style.BLUE, linewidth=1.4, zorder=3))
    sides = high - low
    box = Rectangle((low[across], low[up]), sides[across], sides[up], fill=False, edgecolor=style.GREY, zorder=2)
    axes.add_patch(box)
    room = _MARGIN * sides.max()
    axes.set_xlim(low[across] - room, high[across] + room)
    axes.set_ylim(low[up] - room, high[up] + room)
    for side in (axes.xaxis, axes.yaxis):
        side.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    axes.set(aspect="equal", xlabel=f"{'xyz'[across]} in m", ylabel=f"{'xyz'[up]} in m")
    name = "largest level section" if axis == 2 else "section"
    axes.set_title(f"{name} at {'xyz'[axis]} = {at:.3g} m{more}".replace("-", "\N{MINUS SIGN}"))
