"""The path in the frame, coloured by how far off the nozzle would be: from above, and from the side."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from cablewright.apps import style
from cablewright.apps.quantities import quantity
from cablewright.apps.report.digest import Digest
from cablewright.apps.report.thinning import Pieces, coarse_corners, worst_of_each_place
from cablewright.arrays import Array
from cablewright.robot import Robot

_MAX_PLAN: Final = 30_000
_MAX_SIDE: Final = 40_000
_SIDE_SPAN: Final = 4  # samples
MAX_NAMES: Final = 12
"""Lines whose names, and whose way to the worst place, a picture has room for."""
_OUTLIERS: Final = 0.002  # of the samples at each end, if they would take much of the scale


class ErrorScale(NamedTuple):
    """The ends (mm) of a colour scale, and which of them values go beyond: neither, min, max or both."""

    low: float
    high: float
    extend: str


def error_scale(digest: Digest) -> ErrorScale:
    """Return the scale of the uncompensated error of what is extruded; a few outliers do not stretch it."""
    error = digest.check.error_uncompensated[digest.extruding] * 1e3
    if len(error) == 0:
        return ErrorScale(0.0, 1.0, "neither")
    ends = np.array([error.min(), error.max()])
    core = np.quantile(error, [_OUTLIERS, 1 - _OUTLIERS])
    if np.ptp(ends) > 1.5 * np.ptp(core) > 0:
        low, high = (float(v) for v in core)
        extend = {(True, True): "both", (True, False): "min", (False, True): "max"}
        return ErrorScale(low, high, extend.get((ends[0] < low, ends[1] > high), "neither"))
    margin = 0.0 if np.ptp(ends) > 1e-9 else max(1e-6, 0.05 * float(ends[1]))
    return ErrorScale(float(ends[0]) - margin, float(ends[1]) + margin, "neither")


def plan(digest: Digest) -> Figure:
    """Draw the extruded path from above; where layers lie on each other, the largest error."""
    robot, samples = digest.check.robot, digest.check.samples
    drawn = style.figure(7.4, 6.4)
    axes = drawn.add_subplot(aspect="equal", xlabel="x in m", ylabel="y in m")
    low, high = robot.scene.frame_min, robot.scene.frame_max
    axes.add_patch(
        Rectangle(low[:2], high[0] - low[0], high[1] - low[1], fill=False, edgecolor=style.GREY, linewidth=1.4)
    )
    pieces = worst_of_each_place(samples, digest.extruding, digest.check.error_uncompensated, _MAX_PLAN)
    flat = samples.positions[:, :2]
    exits = np.array([line.exit_point for line in robot.lines])
    extent = max(float(np.ptp([*exits[:, :2], low[:2], high[:2]], axis=0).max()), 1e-3)
    width = float(np.clip(digest.check.job.bead.width / extent * 5.5 * 72, 1.0, 4.0))  # points: as wide as the bead
    _draw_pieces(drawn, axes, flat, pieces, digest, width)
    _mark_worst(axes, flat, digest)
    _plan_exits(axes, robot, exits)
    axes.margins(0.09)
    axes.autoscale_view()
    return drawn


def side_view(digest: Digest) -> Figure:
    """Draw frame, path, and the lines to the place with the largest error, seen from a corner, without perspective."""
    robot, samples = digest.check.robot, digest.check.samples
    camera = Camera()
    drawn = style.figure(7.4, 6.4)
    axes = drawn.add_subplot(aspect="equal")
    axes.set_axis_off()
    _draw_box(axes, camera, robot)
    pieces = coarse_corners(samples, digest.extruding, _MAX_SIDE, _SIDE_SPAN)
    flat = camera.project(samples.positions)
    depth = camera.depth(samples.positions[pieces.end])
    nearest_last = np.argsort(-depth, kind="stable")
    pieces = Pieces(pieces.begin[nearest_last], pieces.end[nearest_last])
    _draw_pieces(drawn, axes, flat, pieces, digest, 1.4)
    exits = camera.project(np.array([line.exit_point for line in robot.lines]))
    if digest.worst is not None:
        tied = camera.project(digest.line_ends)
        for i in digest.nearest_lines(MAX_NAMES):
            axes.plot(*zip(exits[i], tied[i], strict=True), color=style.INK, linewidth=0.8, alpha=0.75)
    _mark_worst(axes, flat, digest)
    axes.plot(*exits.T, "o", color=style.INK, markersize=4.5)
    if robot.m <= MAX_NAMES:
        for line, end in zip(robot.lines, exits, strict=True):
            _text(axes, end, (0, 7), style.label(line.name), "center")
    axes.margins(0.06)
    return drawn


@dataclass(frozen=True)
class Camera:
    """A view from far away, without perspective: azimuth the eye stands in, and its elevation, rad."""

    azimuth: float = math.radians(-62)
    elevation: float = math.radians(22)

    def project(self, points: Array) -> Array:
        """(k, 3) m to (k, 2) m: to the right and up on the picture."""
        ca, sa, ce, se = self._turns()
        right = np.array([-sa, ca, 0.0])
        up = np.array([-ca * se, -sa * se, ce])
        return np.asarray(points @ np.stack([right, up], axis=1))

    def depth(self, points: Array) -> Array:
        """(k, 3) m to (k,) m: distance from the eye, up to a constant."""
        ca, sa, ce, se = self._turns()
        return np.asarray(points @ -np.array([ca * ce, sa * ce, se]))

    def _turns(self) -> tuple[float, float, float, float]:
        return math.cos(self.azimuth), math.sin(self.azimuth), math.cos(self.elevation), math.sin(self.elevation)


def box_edges(low: tuple[float, float, float], high: tuple[float, float, float]) -> Array:
    """(12, 2, 3) the edges of a box: four along x, four along y, four along z."""
    ends = np.array([low, high])
    edges = []
    for axis in range(3):
        for a in (0, 1):
            for b in (0, 1):
                corner = np.insert(np.array([a, b]), axis, 0)
                begin = ends[corner, range(3)]
                end = begin.copy()
                end[axis] = high[axis]
                edges.append((begin, end))
    return np.array(edges)


def _draw_box(axes: Axes, camera: Camera, robot: Robot) -> None:
    """Draw the frame: its floor shaded, hidden edges pale, three edges with their length."""
    low, high = robot.scene.frame_min, robot.scene.frame_max
    floor = np.array([low, (high[0], low[1], low[2]), (high[0], high[1], low[2]), (low[0], high[1], low[2])])
    axes.fill(*camera.project(floor).T, color="#f1f4f7", zorder=0)
    edges = box_edges(low, high)
    farthest = np.argmax(camera.depth(edges.reshape(-1, 3)))
    hidden_corner = edges.reshape(-1, 3)[farthest]
    for edge in edges:
        hidden = bool((edge == hidden_corner).all(axis=1).any())
        flat = camera.project(edge)
        axes.plot(*flat.T, color=style.GREY, linewidth=0.7 if hidden else 1.1, alpha=0.5 if hidden else 1.0, zorder=1)
    for edge, name, offset in (
        (edges[0], "x", (-6, -12)),
        (edges[6], "y", (14, -10)),
        (edges[8], "z", (-26, 0)),
    ):
        size = float(np.abs(edge[1] - edge[0]).max())
        _text(axes, camera.project(edge).mean(axis=0), offset, f"{name}: {size:.3g} m", "center", style.INK)


def _draw_pieces(drawn: Figure, axes: Axes, flat: Array, pieces: Pieces, digest: Digest, width: float) -> None:
    """Draw pieces of the path in the colours of their error, with the scale beside them."""
    if len(pieces) == 0:
        axes.set_title(digest.nothing_drawn)
        return
    scale = error_scale(digest)
    bundle = LineCollection(
        np.stack([flat[pieces.begin], flat[pieces.end]], axis=1),  # type: ignore[arg-type]  # (p, 2, 2) is one
        array=digest.check.error_uncompensated[pieces.end] * 1e3,
        cmap=style.error_colours(),
        norm=Normalize(scale.low, scale.high),
        linewidths=width,
        capstyle="round",
        zorder=2,
    )
    axes.add_collection(bundle)
    bar = drawn.colorbar(bundle, ax=axes, extend=scale.extend, shrink=0.75, aspect=28, pad=0.02)
    bar.set_label("error without compensation in mm")
    bar.outline.set_visible(False)


def _mark_worst(axes: Axes, flat: Array, digest: Digest) -> None:
    """Ring the place with the largest error and write it on the side away from the part."""
    at = digest.worst
    if at is None:
        return
    worst = quantity(float(digest.check.error_uncompensated[at]), "m")
    ring: dict[str, Any] = {
        "markersize": 11,
        "markerfacecolor": "none",
        "markeredgecolor": style.INK,
        "markeredgewidth": 1.6,
    }
    axes.plot(*flat[at], "o", zorder=5, **ring)
    drawn = flat[digest.extruding] if len(digest.extruding) else flat
    left = bool(flat[at, 0] < (drawn[:, 0].min() + drawn[:, 0].max()) / 2)
    _text(axes, flat[at], (-11 if left else 11, -13), f"largest: {worst}", "right" if left else "left")


def _plan_exits(axes: Axes, robot: Robot, exits: Array) -> None:
    """Draw the exit points; those above each other share one label."""
    axes.plot(*exits[:, :2].T, "s", color=style.INK, markersize=5, zorder=4)
    if robot.m > MAX_NAMES:
        return
    names: dict[tuple[float, float], list[str]] = {}
    for line in robot.lines:
        names.setdefault(line.exit_point[:2], []).append(line.name)
    middle = exits[:, 1].mean()
    for at, shared in names.items():
        _text(axes, at, (0, 7 if at[1] >= middle else -14), style.label(", ".join(shared)), "center")


def _text(
    axes: Axes,
    at: Array | tuple[float, float],
    offset: tuple[float, float],
    text: str,
    side: str,
    colour: str = style.INK,
) -> None:
    """Write beside a point; ``offset`` in printer's points."""
    axes.annotate(
        text,
        (float(at[0]), float(at[1])),
        xytext=offset,
        textcoords="offset points",
        ha=side,
        color=colour,
        fontsize=8.5,
        zorder=6,
        bbox={"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.75},
    )
