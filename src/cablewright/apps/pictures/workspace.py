"""Pictures of workspaces: surface and sections, areas by retraction length (Jung 2020, Fig.

10), limits that end them.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from scipy.spatial import cKDTree

from cablewright.analyses.workspace.area import WorkspaceArea
from cablewright.analyses.workspace.best_retraction import RetractionStudy
from cablewright.analyses.workspace.boundary_limits import BoundaryLimits
from cablewright.analyses.workspace.criterion import Criterion, RetractionLaw
from cablewright.analyses.workspace.workspace import Workspace
from cablewright.apps import style
from cablewright.apps.quantities import quantity
from cablewright.apps.space_axes import add_point, add_surface, machine
from cablewright.foundation.arrays import Array, Mask
from cablewright.studies.accuracy import AccuracyStudy

_HEIGHTS: Final = 201  # of which the largest slice is shown
_MARGIN: Final = 0.05  # of the longest side
_PALE: Final = np.array([0.60, 0.80, 0.93])


def volume_picture(found: Workspace) -> Figure:
    """Draw the surface, the middle sections and the largest horizontal one."""
    drawn, places = style.grid(10.0, 8.4, (2, 2), (0, 0), (0, 1), (1, 0), (1, 1))
    low, high = found.box.low, found.box.high
    surface = machine(drawn, places[0], found.criterion.model.robot, low, high)
    add_surface(surface, found.mesh, _PALE, darkest=0.5)
    surface.set_title("boundary, with frame and exit points")
    middle = 0.5 * (low + high)
    heights = np.linspace(low[2], high[2], _HEIGHTS)
    areas = found.slices(heights)
    largest = float(heights[areas.argmax()])
    _draw_section(drawn.add_subplot(places[1]), found, 1, float(middle[1]))
    _draw_section(drawn.add_subplot(places[2]), found, 2, largest, f", area {areas.max():.3g} m²")
    _draw_section(drawn.add_subplot(places[3]), found, 0, float(middle[0]))
    style.headline(drawn, _title(found.criterion, f"{found.volume:.4g} m³", found.fraction))
    return drawn


def area_picture(found: WorkspaceArea) -> Figure:
    """Draw the outlines in their plane, the box and the exit points."""
    axis = (search_plane := found.criterion.search_plane).axis
    across, up = [other for other in range(3) if other != axis]
    drawn, axes = style.axes(7.0, 6.0)
    _fill(axes, [outline[:, [across, up]] for outline in found.outlines])
    low, high = found.box.low, found.box.high
    style.rectangle(axes, low, high, (across, up), zorder=2)
    exits = np.array([line.exit_point for line in found.criterion.model.robot.lines])
    beside = search_plane.is_tilted or np.ptp([*exits[:, axis], found.box.low[axis]]) > 0.0
    seen = f"exit points, seen along {'xyz'[axis]}" if beside else "exit points"
    axes.plot(exits[:, across], exits[:, up], "o", color=style.INK, label=seen, zorder=4)
    corners = np.vstack([low, high, exits])
    spare = _MARGIN * float(np.ptp(corners, axis=0).max())
    (left, right), (bottom, top) = ((corners[:, each].min(), corners[:, each].max()) for each in (across, up))
    axes.set(
        xlim=(left - spare, right + spare),
        ylim=(bottom - spare, top + spare),
        aspect="equal",
        xlabel=f"{'xyz'[across]} in m",
        ylabel=f"{'xyz'[up]} in m",
    )
    style.round_ticks(axes, 5)
    tilted = f"with the normal {search_plane.name}, seen along {'xyz'[axis]}"
    axes.set_title(
        style.minus(f"plane {tilted if search_plane.is_tilted else f'at {search_plane.name} = {low[axis]:.3g} m'}")
    )
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


def _draw_section(axes: Axes, found: Workspace, axis: int, at: float, more: str = "") -> None:
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
    axes.set(xlim=(low[across] - spare, high[across] + spare), ylim=(low[up] - spare, high[up] + spare))
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


def retraction_picture(found: RetractionStudy) -> Figure:
    """Draw the areas by retraction length with the law of the best ones, and the areas by height."""
    drawn, (left, right) = style.subplots(10.4, 4.6, 1, 2, width_ratios=(1.15, 1.0))
    half, step = 0.5 * found.slice_height, 0.5 * (found.lengths[1] - found.lengths[0])
    extent = (found.heights[0] - half, found.heights[-1] + half, found.lengths[0] - step, found.lengths[-1] + step)
    look = {"origin": "lower", "aspect": "auto", "cmap": "cividis", "interpolation": "nearest"}
    shown = left.imshow(found.areas.T, extent=extent, **look)
    style.colour_bar(drawn, left, shown, "area of the slice in m²", shrink=1.0)
    for rows, colour, name in (
        (~found.fitted, "white", "largest area, not fitted"),
        (found.fitted, style.ORANGE, "largest area, fitted"),
    ):
        edge = {"markeredgecolor": style.INK, "markeredgewidth": 0.5, "markersize": 4}
        left.plot(found.heights[rows], found.best[rows], "o", color=colour, label=name, **edge)
    left.plot(found.heights, found.law.at(found.heights), color=style.RED, linewidth=1.6, label="law, clamped")
    height = f"height of the {found.law.of} in m"
    left.set(xlabel=height, ylabel="retraction length in m", xlim=extent[:2], ylim=extent[2:])
    left.grid(visible=False)
    left.set_title("area by height and retraction length")
    names = [str(curve.get_label()) for curve in left.get_lines()]
    left.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=style.legend_columns(names, 3))
    for k, name in ((0, "shortest"), (len(found.lengths) - 1, "longest")):
        colour = (style.GREEN, style.BLUE)[k > 0]
        right.plot(found.areas[:, k], found.heights, color=colour, label=f"{name}, {found.lengths[k]:.3g} m")
    right.plot(found.best_areas, found.heights, color=style.INK, linewidth=2.4, alpha=0.35, label="largest area")
    right.plot(found.held.slices(found.heights), found.heights, "--", color=style.RED, label="with the law")
    right.set(xlabel="area of the slice in m²", ylabel=height, ylim=extent[:2], xlim=(0.0, None))
    right.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2)
    right.set_title(f"volume {found.held.volume:.3g} m³ with the law, {100 * found.share:.1f} % of max")
    return drawn


_LIMIT_COLOURS: Final = (style.BLUE, style.ORANGE, style.GREEN, style.RED, style.PINK, style.SKY, style.YELLOW)
_MARKERS: Final = "osD^v<>Pp"
_BETWEEN: Final = 8  # places whose errors colour a point of the boundary
_MAX_LIMITS: Final = 8  # that a legend has room for


def workspace_errors(study: AccuracyStudy) -> Figure | None:
    """Draw boundary and section, coloured by the largest error; None without a workspace or any known error."""
    found, errors = study.workspace, study.accuracy.spread.max_error * 1e3
    known = np.isfinite(errors)
    if found is None or not known.any():
        return None
    robot = study.accuracy.robot
    sides = np.subtract(robot.scene.frame_max, robot.scene.frame_min)
    drawn = style.figure(10.6, float(np.clip(1.5 + 3.8 * sides[2] / sides[0], 4.6, 6.5)))
    grid = drawn.add_gridspec(1, 3, width_ratios=(1.0, 0.1, 1.0))
    axes = machine(drawn, grid[0], robot)
    section = drawn.add_subplot(grid[2], aspect="equal", xlabel="x in m", ylabel="z in m")
    colours = style.error_bar(drawn, [axes, section], style.scale_of(errors[known]), "largest error in mm")
    places = study.places.positions
    mesh = found.surface()
    shown = _near(places[known], errors[known], mesh.corners.mean(axis=1))
    add_surface(axes, mesh, np.asarray(colours.to_rgba(shown))[:, :3], darkest=0.7)
    _mark(axes, places, errors)
    axes.set_title("boundary of the workspace")
    _error_section(section, study, found, colours)
    style.legend_below(drawn, axes, columns=1, side="left")
    style.legend_below(drawn, section, columns=3, side="right")
    # Axes of a fixed shape leave no room for their titles.
    drawn.set_layout_engine("constrained", rect=(0.0, 0.0, 1.0, 0.95))
    return drawn


def _near(places: Array, errors: Array, points: Array) -> Array:
    """Return errors at *points* (F, 3), m: the mean of those of the nearest *places*, by inverse squared distance."""
    away, rows = cKDTree(places).query(points, range(1, min(_BETWEEN, len(places)) + 1))
    return np.asarray(np.average(errors[rows], axis=1, weights=1.0 / np.maximum(away, 1e-9) ** 2))


def _mark(axes: Any, places: Array, errors: Array) -> None:
    """Mark the places with the smallest and the largest error; the name of the lower one stands below it."""
    low, high = int(np.nanargmin(errors)), int(np.nanargmax(errors))
    highest_above = bool(places[high, 2] >= places[low, 2])
    for at, name, kind, above in ((low, "P1", "smallest", not highest_above), (high, "P2", "largest", highest_above)):
        where = style.minus(", ".join(f"{v:.3g}" for v in places[at]))
        text = f"{name}: {kind}, {quantity(float(errors[at]) / 1e3, 'm')} at ({where}) m"
        add_point(axes, places[at], name, above=above, label=text)


def _error_section(axes: Axes, study: AccuracyStudy, found: BoundaryLimits, colours: ScalarMappable) -> None:
    """Draw the nodes of the vertical plane nearest to the middle that has any, and what ends the workspace in it."""
    x, y, z = found.nodes.axes
    held = np.nonzero(found.nodes.inside.any(axis=(0, 2)))[0]
    if not len(held):
        return
    at = int(held[np.abs(y[held] - 0.5 * (y[0] + y[-1])).argmin()])
    values = np.full(found.nodes.inside.shape, np.nan)
    values[found.nodes.inside] = study.accuracy.spread.max_error * 1e3
    cells = style.cells(axes, x, z, values[:, at, :].T, colours, zorder=1)
    scene = study.accuracy.robot.scene
    # the cell of a node on a side is half outside
    cells.set_clip_path(style.rectangle(axes, scene.frame_min, scene.frame_max, (0, 2)))
    near = np.abs(found.points[:, 1] - y[at]) < 1e-6 * (y[1] - y[0])
    _ends(axes, found, near)
    axes.set_title(style.minus(f"section at y = {y[at]:.3g} m, and which limit ends the workspace"))
    spare = 0.04 * (x[-1] - x[0])
    axes.set(xlim=(x[0] - spare, x[-1] + spare), ylim=(z[0] - spare, z[-1] + spare))


def _ends(axes: Axes, found: BoundaryLimits, near: Mask) -> None:
    """Draw the boundary points that are *near*, by limit, the most frequent limit first."""
    counts = np.bincount(found.ended_by[near], minlength=len(found.limits))
    order = [int(limit) for limit in np.argsort(-counts, kind="stable") if counts[limit]]
    for place, limit in enumerate(order[:_MAX_LIMITS]):
        own = found.points[near & (found.ended_by == limit)]
        colour = _LIMIT_COLOURS[place % len(_LIMIT_COLOURS)]
        name = style.label(found.limits[limit], 40)
        look: dict[str, Any] = {"markeredgecolor": "white", "markeredgewidth": 0.6, "markersize": 5.5, "zorder": 3}
        axes.plot(own[:, 0], own[:, 2], _MARKERS[place], color=colour, label=name, **look)
