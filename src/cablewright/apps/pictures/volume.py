"""A workspace by a criterion: its surface in the frame, and sections through it."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from cablewright.analyses.workspace.criterion import RetractionLaw
from cablewright.analyses.workspace.workspace import Workspace
from cablewright.apps import style
from cablewright.apps.space_axes import add_surface, machine

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
    style.headline(drawn, _title(found))
    return drawn


def _title(found: Workspace) -> str:
    criterion = found.criterion
    robot = style.label(criterion.model.robot.name)
    text = f"{robot}, {criterion.name}: {found.volume:.4g} m³ of the {criterion.point}"
    text += f", {100.0 * found.fraction:.1f} % of the box"
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
    codes, points = [], []
    for outline in found.mesh.section(axis, inner):
        closed = np.vstack([outline, outline[:1]])
        points.append(closed[:, ::-1] if flip else closed)
        codes += [Path.MOVETO, *[Path.LINETO] * (len(outline) - 1), Path.CLOSEPOLY]
    if points:
        shape = Path(np.concatenate(points), codes)
        axes.add_patch(PathPatch(shape, facecolor="#bcd7ea", edgecolor=style.BLUE, linewidth=1.4, zorder=3))
    style.rectangle(axes, low, high, (across, up), zorder=2)
    spare = _MARGIN * sides.max()
    axes.set_xlim(low[across] - spare, high[across] + spare)
    axes.set_ylim(low[up] - spare, high[up] + spare)
    style.round_ticks(axes, 5)
    axes.set(aspect="equal", xlabel=f"{'xyz'[across]} in m", ylabel=f"{'xyz'[up]} in m")
    name = "largest level section" if axis == 2 else "section"
    axes.set_title(style.minus(f"{name} at {'xyz'[axis]} = {at:.3g} m{more}"))
