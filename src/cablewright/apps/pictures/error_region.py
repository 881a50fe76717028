"""Picture of the nozzle's region of positions at one pose: its hull, and its projections on three planes, in mm."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec

from cablewright.analyses.accuracy.error_region import PLANES, Region
from cablewright.apps import style
from cablewright.apps.quantities import quantity
from cablewright.apps.space_axes import add_faces, add_lines, bounds, space, towards_eye
from cablewright.foundation.arrays import Array

_VIEWS: Final = {"xy": "from above", "xz": "from the front", "yz": "from the side"}
_NEAR: Final = 1.5  # of the region's radius: a commanded place farther off would shrink the region to a dot
_MAX_DOTS: Final = 3000
_FEW: Final = 400  # triangles, whose edges are drawn
_SLENDER: Final = 12.0  # ratio of the sides above which one scale for both axes would leave a line


def region(found: Region, corners: Array | None = None) -> Figure:
    """Draw the hull of the region, coloured by the distance from the nominal position, and three projections.

    *corners* (S, 3), m, are drawn as dots in place of the region's own points.
    """
    points = (found.points - found.nominal) * 1e3
    dots = points if corners is None else (corners - found.nominal) * 1e3
    commanded = (found.wanted - found.nominal) * 1e3
    reach = float(np.linalg.norm(points, axis=1).max()) if len(points) else 0.0
    near = bool(np.linalg.norm(commanded) <= _NEAR * max(reach, 1e-6))
    drawn = style.figure(9.6, 7.6)
    grid = drawn.add_gridspec(2, 2, width_ratios=(1.15, 1.0))
    _solid(drawn, grid[0, 0], found, points, commanded if near else None)
    for (name, axes_of), where in zip(PLANES.items(), (grid[0, 1], grid[1, 0], grid[1, 1]), strict=True):
        axes = drawn.add_subplot(where)
        index = list(axes_of)
        outline = (found.hull.projections[name] - found.nominal[index]) * 1e3
        some = dots[:: max(1, -(-len(dots) // _MAX_DOTS)), index]
        even = _shadow(axes, outline, some, commanded[index] if near else None)
        axes.set(
            xlabel=f"{name[0]} in mm",
            ylabel=f"{name[1]} in mm",
            title=_VIEWS[name] if even else f"{_VIEWS[name]}; scales differ",
        )
    handles, names = drawn.axes[-1].get_legend_handles_labels()
    if not near:
        far = quantity(float(np.linalg.norm(commanded)) / 1e3, "m")
        drawn.supxlabel(f"The commanded place is outside the picture: {far} from the nominal one.", fontsize=8.5)
    drawn.legend(handles, names, loc="outside upper right", ncols=4)
    return drawn


def _solid(drawn: Figure, where: SubplotSpec, found: Region, points: Array, commanded: Array | None) -> None:
    """Draw the hull in space; of a flat one its points."""
    low, high = bounds(np.zeros(3), points, *([] if commanded is None else [commanded]))
    margin = 0.04 * max(float((high - low).max()), 1e-6)
    axes, even = space(drawn, where, low - margin, high + margin, "mm", zoom=1.0)
    distance = np.linalg.norm(points, axis=1)
    corners = points[found.hull.triangles]
    # Large triangles are cut so that each piece has the colour of its own place, not of three far corners.
    pieces = _cut(corners, 3) if len(corners) <= _FEW else corners
    text = "distance from the nominal place in mm"
    colours = style.error_bar(drawn, axes, style.scale_of(distance), text, location="left", pad=0.0)
    if len(pieces):
        add_faces(axes, pieces, colours.to_rgba(np.linalg.norm(pieces.mean(axis=1), axis=1)), zorder=3)
        _edges(axes, corners)
    else:
        axes.scatter(*points.T, s=10, c=colours.to_rgba(distance), depthshade=False, zorder=3)
    for at, marker, colour in ((np.zeros(3), "o", style.INK), (commanded, "*", style.RED)):
        if at is not None:
            axes.plot(*at[:, None], marker, color=colour, markeredgecolor="white", markersize=8, zorder=9)
    what = "region" if len(pieces) else "region: flat, without a volume"
    axes.set_title(what if even else f"{what}; thin side not to scale")


def _edges(axes: Any, corners: Array) -> None:
    """Draw the front edges of a hull with few triangles; those of many would cover it."""
    if len(corners) > _FEW:
        return
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    outward = ((corners.mean(axis=1) - corners.mean(axis=(0, 1))) * normals).sum(axis=1) > 0.0
    front = corners[(normals @ towards_eye() > 0.0) == outward]
    sides = np.concatenate([front[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0))])
    add_lines(axes, sides, zorder=4, width=0.5, colours=(1.0, 1.0, 1.0, 0.5))


def _cut(corners: Array, times: int) -> Array:
    """Cut each of the triangles (F, 3, 3) into four, *times* over."""
    for _ in range(times):
        a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
        ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
        parts = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
        corners = np.concatenate([np.stack(part, axis=1) for part in parts])
    return corners


def _shadow(axes: Axes, outline: Array, dots: Array, commanded: Array | None) -> bool:
    """Draw one shadow with the points that cast it; return whether both axes have one scale."""
    if len(outline) > 2:
        axes.fill(*outline.T, color=style.BLUE, alpha=0.14, linewidth=0)
    closed = np.vstack([outline, outline[:1]])
    axes.plot(*closed.T, color=style.BLUE, linewidth=1.3, label="outline")
    axes.plot(*dots.T, ".", color=style.BLUE, markersize=3.0, alpha=0.7, label="corner of the ranges")
    axes.plot(0.0, 0.0, "o", color=style.INK, markeredgecolor="white", markersize=8, label="nominal place", zorder=5)
    if commanded is not None:
        axes.plot(
            *commanded, "*", color=style.RED, markeredgecolor="white", markersize=13, label="commanded place", zorder=6
        )
    axes.margins(0.08)
    axes.autoscale_view()
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    sides = sorted((right - left, top - bottom))
    even = bool(sides[1] <= _SLENDER * sides[0])
    if even:
        axes.set_aspect("equal", adjustable="datalim")
    style.round_ticks(axes)
    return even
