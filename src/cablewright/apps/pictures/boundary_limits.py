"""The static workspace: its boundary in the frame, a section through its middle, and which limit ends it where."""

from __future__ import annotations

from typing import Any, Final, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from scipy.spatial import cKDTree

from cablewright.analyses.workspace.boundary_limits import BoundaryLimits
from cablewright.apps import style
from cablewright.apps.quantities import quantity
from cablewright.apps.space_axes import add_surface, bar, draw_frame, point, scale_of, space
from cablewright.arrays import Array, Mask
from cablewright.studies.accuracy import AccuracyStudy

_Where = Literal["outside lower left", "outside lower right"]

_LIMIT_COLOURS: Final = (style.BLUE, style.ORANGE, style.GREEN, style.RED, "#cc79a7", "#56b4e9", "#f0e442")
_MARKERS: Final = "osD^v<>Pp"
_BETWEEN: Final = 8  # places whose errors colour a point of the boundary
_MAX_LIMITS: Final = 8  # that a legend has room for


def extremes(errors: Array) -> tuple[int, int] | None:
    """Return the rows of the smallest and the largest error, or None where none is known."""
    return (int(np.nanargmin(errors)), int(np.nanargmax(errors))) if np.isfinite(errors).any() else None


def workspace(study: AccuracyStudy) -> Figure | None:
    """Draw boundary and section, coloured by the largest error; None without a workspace or any known error."""
    found, errors = study.workspace, study.accuracy.spread.max_error * 1e3
    known = np.isfinite(errors)
    if found is None or not known.any():
        return None
    robot = study.accuracy.robot
    ends = np.array([robot.scene.frame_min, robot.scene.frame_max, *(line.exit_point for line in robot.lines)])
    sides = np.subtract(robot.scene.frame_max, robot.scene.frame_min)
    drawn = style.figure(10.6, float(np.clip(1.5 + 3.8 * sides[2] / sides[0], 4.6, 6.5)))
    grid = drawn.add_gridspec(1, 3, width_ratios=(1.0, 0.1, 1.0))
    axes, _ = space(drawn, grid[0], ends.min(axis=0), ends.max(axis=0), "m")
    section = drawn.add_subplot(grid[2], aspect="equal", xlabel="x in m", ylabel="z in m")
    colours = bar(drawn, [axes, section], scale_of(errors[known]), "largest error in mm")
    draw_frame(axes, robot)
    places = study.places.positions
    mesh = found.surface()
    shown = _near(places[known], errors[known], mesh.corners.mean(axis=1))
    add_surface(axes, mesh, np.asarray(colours.to_rgba(shown))[:, :3], darkest=0.7)
    _mark(axes, places, errors)
    axes.set_title("boundary of the workspace")
    _section(section, study, found, colours)
    sides_of: tuple[tuple[Any, _Where, int], ...] = (
        (axes, "outside lower left", 1),
        (section, "outside lower right", 3),
    )
    for part, at, columns in sides_of:
        handles, names = part.get_legend_handles_labels()
        if handles:
            drawn.legend(handles, names, loc=at, ncols=columns, columnspacing=1.2, handletextpad=0.2)
    drawn.set_layout_engine(
        "constrained", rect=(0.0, 0.0, 1.0, 0.95)
    )  # axes of a fixed shape leave no room for their titles
    return drawn


def _near(places: Array, errors: Array, wanted: Array) -> Array:
    """Errors at *wanted* (F, 3), m, between those of the nearest *places*: the nearer one is, the more it counts."""
    away, rows = cKDTree(places).query(wanted, range(1, min(_BETWEEN, len(places)) + 1))
    return np.asarray(np.average(errors[rows], axis=1, weights=1.0 / np.maximum(away, 1e-9) ** 2))


def _mark(axes: Any, places: Array, errors: Array) -> None:
    """Mark the places with the smallest and the largest error; the lower one of them below it."""
    found = extremes(errors)
    if found is None:
        return
    low, high = found
    for at, name in ((low, "P1"), (high, "P2")):
        other = high if at == low else low
        above = bool(places[at, 2] > places[other, 2]) or (at == high and bool(places[at, 2] == places[other, 2]))
        where = ", ".join(f"{v:.3g}" for v in places[at]).replace("-", "\N{MINUS SIGN}")
        told = f"{name}: {'smallest' if name == 'P1' else 'largest'}, {quantity(float(errors[at]) / 1e3, 'm')}"
        point(axes, places[at], name, above=above, label=f"{told} at ({where}) m")


def _section(axes: Axes, study: AccuracyStudy, found: BoundaryLimits, colours: ScalarMappable) -> None:
    """Draw the nodes of the vertical plane nearest to the middle that has any, and what ends the workspace in it."""
    x, y, z = found.nodes.axes
    held = np.nonzero(found.nodes.inside.any(axis=(0, 2)))[0]
    if not len(held):
        return
    at = int(held[np.abs(y[held] - 0.5 * (y[0] + y[-1])).argmin()])
    values = np.full(found.nodes.inside.shape, np.nan)
    values[found.nodes.inside] = study.accuracy.spread.max_error * 1e3
    shown = np.ma.masked_invalid(values[:, at, :].T)
    cells = axes.pcolormesh(
        x, z, shown, shading="nearest", cmap=colours.get_cmap(), norm=Normalize(*colours.get_clim()), zorder=1
    )
    low, high = study.accuracy.robot.scene.frame_min, study.accuracy.robot.scene.frame_max
    frame = Rectangle((low[0], low[2]), high[0] - low[0], high[2] - low[2], fill=False, edgecolor=style.GREY)
    axes.add_patch(frame)
    cells.set_clip_path(frame)  # the cell of a node on a side is half outside
    near = np.abs(found.points[:, 1] - y[at]) < 1e-6 * (y[1] - y[0])
    _ends(axes, found, near)
    axes.set_title(f"section at y = {y[at]:.3g} m, and what ends the workspace there".replace("-", "\N{MINUS SIGN}"))
    axes.set_xlim(x[0] - 0.04 * (x[-1] - x[0]), x[-1] + 0.04 * (x[-1] - x[0]))
    axes.set_ylim(z[0] - 0.04 * (x[-1] - x[0]), z[-1] + 0.04 * (x[-1] - x[0]))


def _ends(axes: Axes, found: BoundaryLimits, near: Mask) -> None:
    """Draw the boundary points that are *near*, by limit, the most frequent limit first."""
    counts = np.bincount(found.ended_by[near], minlength=len(found.limits))
    order = [int(limit) for limit in np.argsort(-counts, kind="stable") if counts[limit]]
    for place, limit in enumerate(order[:_MAX_LIMITS]):
        own = found.points[near & (found.ended_by == limit)]
        axes.plot(
            own[:, 0],
            own[:, 2],
            _MARKERS[place % len(_MARKERS)],
            color=_LIMIT_COLOURS[place % len(_LIMIT_COLOURS)],
            markeredgecolor="white",
            markeredgewidth=0.6,
            markersize=5.5,
            linestyle="none",
            label=style.label(found.limits[limit], 40),
            zorder=3,
        )
