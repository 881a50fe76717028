"""Pictures in space: axes of one scale without perspective, the machine's frame, and the colours of an error."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection  # type: ignore[import-untyped]

from cablewright.apps import style
from cablewright.apps.pictures.path import ErrorScale, box_edges
from cablewright.arrays import Array
from cablewright.robot import Robot
from cablewright.triangle_mesh import TriangleMesh

_OUTLIERS: Final = 0.002  # of the values at each end, if they would take much of the scale
_FLATTEST: Final = 0.3  # of the longest side: a thinner box has no room for its labels
_ZOOM: Final = 0.88  # leaves room for the labels, of which layouts do not know
_ELEVATION: Final = 22.0  # degrees
_AZIMUTH: Final = -62.0
_LIGHT: Final = np.array([0.2, -0.55, 0.81]) / np.linalg.norm([0.2, -0.55, 0.81])
_PANE: Final = (0.975, 0.98, 0.985, 1.0)


def space(
    drawn: Figure, where: SubplotSpec, low: Array, high: Array, unit: str, zoom: float = _ZOOM
) -> tuple[Any, bool]:
    """Return axes from *low* to *high* (3,), seen from a corner, and whether they all have one scale.

    What has the higher zorder lies above, wherever it is.
    """
    extent = np.maximum(high - low, 1e-12)
    shown = np.maximum(extent, _FLATTEST * extent.max())
    labels = [f"{name} in {unit}" for name in "xyz"]
    return _axes(drawn, where, (low, low + extent), shown, labels, zoom), bool((shown == extent).all())


def heights(drawn: Figure, where: SubplotSpec, low: Sequence[float], high: Sequence[float]) -> Any:
    """Return axes for an error in mm over a plane in m, from *low* to *high* (3,); heights have their own scale."""
    lower, upper = np.array(low), np.array(high)
    sides = upper[:2] - lower[:2]
    shown = np.append(sides, 0.7 * sides.max())
    return _axes(drawn, where, (lower, upper), shown, ["x in m", "y in m", "vertical error in mm"], _ZOOM)


def _axes(
    drawn: Figure, where: SubplotSpec, ends: tuple[Array, Array], shown: Array, labels: list[str], zoom: float
) -> Any:
    """Return axes in a box with sides as *shown*."""
    low, high = ends
    inches = drawn.get_figwidth() * where.get_position(drawn).width
    axes: Any = drawn.add_subplot(where, projection="3d", computed_zorder=False)
    axes.set_proj_type("ortho")
    axes.view_init(elev=_ELEVATION, azim=_AZIMUTH)
    axes.set_box_aspect(shown / np.linalg.norm(shown), zoom=zoom)
    for at, (name, side) in enumerate(zip("xyz", (axes.xaxis, axes.yaxis, axes.zaxis), strict=True)):
        getattr(axes, f"set_{name}lim")(float(low[at]), float(high[at]))
        getattr(axes, f"set_{name}label")(labels[at])
        bins = max(2, round(1.3 * inches * shown[at] / shown.max()))
        prune = ("upper", "lower", None)[at]  # x and y meet there
        side.set_major_locator(MaxNLocator(bins, steps=[1, 2, 5, 10], prune=prune, min_n_ticks=1))
        side.set_pane_color(_PANE)
        side.line.set_color(style.GREY)
        side.labelpad = 0.0
    axes.tick_params(labelsize=7.5, pad=-1.0)
    return axes


def draw_frame(axes: Any, robot: Robot) -> None:
    """Draw the frame's edges and the exit points."""
    edges = box_edges(robot.scene.frame_min, robot.scene.frame_max)
    axes.add_collection3d(Line3DCollection(edges, colors=style.GREY, linewidths=0.8, zorder=1), autolim=False)
    exits = np.array([line.exit_point for line in robot.lines])
    axes.scatter(*exits.T, s=16, c=style.INK, marker="s", depthshade=False, zorder=2)


def add_faces(
    axes: Any, corners: Array, colours: Any, zorder: float, alpha: float = 1.0, edge: Any = None, width: float = 0.25
) -> None:
    """Draw faces (F, c, 3) in their colours, with edges of the same unless told."""
    if len(corners):
        drawn = Poly3DCollection(
            corners,
            facecolors=colours,
            edgecolors=colours if edge is None else edge,
            linewidths=width,
            alpha=alpha,
            zorder=zorder,
        )
        axes.add_collection3d(drawn, autolim=False)


def add_surface(axes: Any, mesh: TriangleMesh, colours: Array, darkest: float) -> None:
    """Draw a closed mesh in *colours*, (F, 3) or one (3,); what is turned away from the light is darker."""
    normals = mesh.normals
    seen = normals @ towards_eye() > 0.0
    light = darkest + (1.0 - darkest) * np.clip(normals @ _LIGHT, 0.0, 1.0)
    add_faces(axes, mesh.corners[seen], (light[:, None] * colours)[seen], zorder=3, width=0.6)  # no seams


def add_lines(axes: Any, pieces: Array, zorder: float, width: float, colours: Any) -> None:
    """Draw pieces (p, 2, 3) in their colours."""
    if len(pieces):
        axes.add_collection3d(
            Line3DCollection(pieces, colors=colours, linewidths=width, capstyle="round", zorder=zorder), autolim=False
        )


def point(axes: Any, at: Array, name: str, *, above: bool, label: str) -> None:
    """Mark a point with a name of few letters, above or below it; *label* is for the legend."""
    ring = {"color": "white", "markeredgecolor": style.INK, "markeredgewidth": 1.5, "markersize": 7}
    axes.plot(*at[:, None], "o", **ring, label=label, zorder=20)
    size = max(high - low for low, high in (axes.get_xlim(), axes.get_ylim(), axes.get_zlim()))
    lifted = at + np.array([0.0, 0.0, (1 if above else -1) * 0.04 * size])
    box = {"boxstyle": "round,pad=0.12", "facecolor": "white", "edgecolor": "none", "alpha": 0.8}
    side = "bottom" if above else "top"
    axes.text(*lifted, name, ha="center", va=side, fontsize=8.5, fontweight="bold", zorder=21, bbox=box)


def towards_eye() -> Array:
    """Return the direction (3,) in which the eye is."""
    elevation, azimuth = np.radians([_ELEVATION, _AZIMUTH])
    level = np.cos(elevation)
    return np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])


def scale_of(values: Array) -> ErrorScale:
    """Return the scale of some finite values, over which a few outliers have no power."""
    if len(values) == 0:
        return ErrorScale(0.0, 1.0, "neither")
    low, high = float(values.min()), float(values.max())
    core = np.quantile(values, [_OUTLIERS, 1.0 - _OUTLIERS])
    if high - low > 1.5 * np.ptp(core) > 0.0:
        extend = {(True, True): "both", (True, False): "min", (False, True): "max"}
        beyond = extend.get((low < core[0], high > core[1]), "neither")
        return ErrorScale(float(core[0]), float(core[1]), beyond)
    margin = 0.0 if high - low > 1e-9 else max(1e-6, 0.05 * abs(high))
    return ErrorScale(low - margin, high + margin, "neither")


def bar(drawn: Figure, axes: Axes | list[Axes], scale: ErrorScale, text: str, **where: Any) -> ScalarMappable:
    """Draw the scale of an error's colours beside *axes* and return what turns values into colours."""
    colours = ScalarMappable(Normalize(scale.low, scale.high), style.error_colours())
    made = drawn.colorbar(
        colours, ax=axes, extend=scale.extend, **({"shrink": 0.75, "aspect": 28, "pad": 0.02} | where)
    )
    made.set_label(text)
    made.ax.yaxis.set_major_locator(MaxNLocator(7))
    made.outline.set_visible(False)
    return colours
