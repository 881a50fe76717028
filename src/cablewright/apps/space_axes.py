"""Axes for 3-D pictures: one scale, no perspective, the machine's frame, and objects in it."""

from __future__ import annotations

from itertools import combinations, product
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection  # type: ignore[import-untyped]
from numpy.typing import ArrayLike

from cablewright.apps import style
from cablewright.foundation.arrays import Array
from cablewright.foundation.triangle_mesh import TriangleMesh
from cablewright.robot import Robot

_FLATTEST: Final = 0.3  # of the longest side: a thinner box has no room for its labels
_ZOOM: Final = 0.88  # leaves room for the labels, which matplotlib's layout does not count
_ELEVATION: Final = 22.0  # degrees
_AZIMUTH: Final = -62.0
_LIGHT: Final = np.array([0.2, -0.55, 0.81]) / np.linalg.norm([0.2, -0.55, 0.81])
_PANE: Final = (0.975, 0.98, 0.985, 1.0)


def space(
    drawn: Figure, where: SubplotSpec, low: Array, high: Array, unit: str, zoom: float = _ZOOM
) -> tuple[Any, bool]:
    """Return 3-D axes from *low* to *high* (3,), seen from a corner, and whether they all have one scale.

    Objects with a higher zorder are drawn over the rest, wherever they are.
    """
    extent = np.maximum(high - low, 1e-12)
    shown = np.maximum(extent, _FLATTEST * extent.max())
    labels = [f"{name} in {unit}" for name in "xyz"]
    return _axes(drawn, where, (low, low + extent), shown, labels, zoom), bool((shown == extent).all())


def heights(drawn: Figure, where: SubplotSpec, low: ArrayLike, high: ArrayLike) -> Any:
    """Return 3-D axes for an error in mm over a plane in m, from *low* to *high* (3,).

    Heights have their own scale.
    """
    lower, upper = np.asarray(low), np.asarray(high)
    sides = upper[:2] - lower[:2]
    shown = np.append(sides, 0.7 * sides.max())
    return _axes(drawn, where, (lower, upper), shown, ["x in m", "y in m", "vertical error in mm"], _ZOOM)


def machine(drawn: Figure, where: SubplotSpec, robot: Robot, *points: ArrayLike) -> Any:
    """Return 3-D axes around frame, exit points and *points*, (3,) or (k, 3), m; frame and exit points are drawn."""
    low, high = bounds(*frame_points(robot), *points)
    axes, _ = space(drawn, where, low, high, "m")
    draw_frame(axes, robot)
    return axes


def frame_points(robot: Robot) -> tuple[ArrayLike, ...]:
    """Return two opposite corners of the frame and the exit points, each (3,), m."""
    return (robot.scene.frame_min, robot.scene.frame_max, *(line.exit_point for line in robot.lines))


def bounds(*points: ArrayLike) -> tuple[Array, Array]:
    """Return the lowest and the highest corner (3,) of the box around *points*, each (3,) or (k, 3)."""
    stacked = np.vstack([np.atleast_2d(np.asarray(each, dtype=float)) for each in points])
    return np.nanmin(stacked, axis=0), np.nanmax(stacked, axis=0)


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


def box_edges(low: ArrayLike, high: ArrayLike) -> Array:
    """Return the edges (12, 2, 3) of a box: four along x, four along y, four along z."""
    corners = np.array(list(product(*zip(np.asarray(low), np.asarray(high), strict=True))))
    pairs = [pair for pair in combinations(range(8), 2) if (pair[0] ^ pair[1]) in (1, 2, 4)]
    return corners[sorted(pairs, key=lambda pair: -(pair[0] ^ pair[1]))]


def draw_frame(axes: Any, robot: Robot) -> None:
    """Draw the frame's edges and the exit points."""
    add_lines(axes, box_edges(robot.scene.frame_min, robot.scene.frame_max), 1, 0.8, style.GREY)
    exits = np.array([line.exit_point for line in robot.lines])
    axes.scatter(*exits.T, s=16, c=style.INK, marker="s", depthshade=False, zorder=2)


def add_faces(
    axes: Any, corners: Array, colours: Any, zorder: float, alpha: float = 1.0, edge: Any = None, width: float = 0.25
) -> None:
    """Draw faces (F, c, 3) in their colours; the edges have the same colours unless *edge* is given."""
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
    """Draw a closed mesh in *colours*, (F, 3) or one (3,); faces that look away from the light are darker."""
    normals = mesh.normals
    seen = normals @ towards_eye() > 0.0
    light = darkest + (1.0 - darkest) * np.clip(normals @ _LIGHT, 0.0, 1.0)
    add_faces(axes, mesh.corners[seen], (light[:, None] * colours)[seen], zorder=3, width=0.6)  # no seams


def add_lines(axes: Any, pieces: Array, zorder: float, width: float, colours: Any) -> None:
    """Draw straight pieces (p, 2, 3), each with its own colour."""
    if len(pieces):
        axes.add_collection3d(
            Line3DCollection(pieces, colors=colours, linewidths=width, capstyle="round", zorder=zorder), autolim=False
        )


def add_point(axes: Any, at: Array, name: str, *, above: bool, label: str) -> None:
    """Mark a point with a name of few letters, above or below it; *label* is for the legend."""
    axes.plot(*at[:, None], **(style.RING | {"markersize": 7, "fillstyle": "full"}), markerfacecolor="white",
              markeredgewidth=1.5, label=label, zorder=20)  # fmt: skip
    size = max(high - low for low, high in (axes.get_xlim(), axes.get_ylim(), axes.get_zlim()))
    lifted = at + np.array([0.0, 0.0, (1 if above else -1) * 0.04 * size])
    box = {"boxstyle": "round,pad=0.12", "facecolor": "white", "edgecolor": "none", "alpha": 0.8}
    side = "bottom" if above else "top"
    axes.text(*lifted, name, ha="center", va=side, fontsize=8.5, fontweight="bold", zorder=21, bbox=box)


def towards_eye() -> Array:
    """Return the direction (3,) from the scene to the eye."""
    elevation, azimuth = np.radians([_ELEVATION, _AZIMUTH])
    level = np.cos(elevation)
    return np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])


def as_seen(points: Array) -> Array:
    """Project *points* (k, 3), m, on a plane before the eye: (k, 2), m, to the right and upwards."""
    right = np.array([-np.sin(np.radians(_AZIMUTH)), np.cos(np.radians(_AZIMUTH)), 0.0])
    return np.asarray(points @ np.stack([right, np.cross(towards_eye(), right)], axis=1))
