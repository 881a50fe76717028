"""The static workspace: its boundary in the frame, a section through its middle, and which limit ends it where."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from scipy.spatial import cKDTree

from cablewright.analyses.workspace.boundary_limits import BoundaryLimits
from cablewright.apps import style
from cablewright.apps.quantities import quantity
from cablewright.apps.space_axes import add_point, add_surface, machine
from cablewright.arrays import Array, Mask
from cablewright.studies.accuracy import AccuracyStudy

_LIMIT_COLOURS: Final = (style.BLUE, style.ORANGE, style.GREEN, style.RED, style.PINK, style.SKY, style.YELLOW)
_MARKERS: Final = "osD^v<>Pp"
_BETWEEN: Final = 8  # places whose errors colour a point of the boundary
_MAX_LIMITS: Final = 8  # that a legend has room for


def workspace(study: AccuracyStudy) -> Figure | None:
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
    _section(section, study, found, colours)
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


def _section(axes: Axes, study: AccuracyStudy, found: BoundaryLimits, colours: ScalarMappable) -> None:
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
    frame = style.rectangle(axes, scene.frame_min, scene.frame_max, (0, 2))
    cells.set_clip_path(frame)  # the cell of a node on a side is half outside
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
