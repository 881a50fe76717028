"""Pictures of the error of the nozzle along a path: from above, from the side, and by height."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike

from cablewright.analyses.accuracy.compensation import COMPENSATIONS
from cablewright.apps import style
from cablewright.apps.quantities import quantity
from cablewright.apps.report.check_summary import Band, Digest
from cablewright.apps.report.thinning import Pieces, coarse_corners, worst_of_each_place
from cablewright.apps.space_axes import as_seen, box_edges, towards_eye
from cablewright.foundation.arrays import Array
from cablewright.foundation.memory_mapped import blocks, let_go, taken
from cablewright.robot import Robot

View = Callable[[Array], Array]
"""Projects points (k, 3) on the plane of a picture, (k, 2)."""

_MAX_PLAN: Final = 30_000
_MAX_SIDE: Final = 40_000
_SIDE_SPAN: Final = 4  # samples
MAX_NAMES: Final = 12
"""Lines that a picture has room to name and to draw to the place with the largest error."""


def error_scale(digest: Digest) -> style.ErrorScale:
    """Return the colour scale, mm, of the uncompensated error of extruding moves."""
    return style.scale_of(taken(digest.check.error_uncompensated, digest.extruding) * 1e3)


def plan(digest: Digest) -> Figure:
    """Draw the extruded path from above, coloured by error; where layers overlap, the largest error."""
    robot, samples = digest.check.robot, digest.check.samples
    drawn, axes = style.axes(7.4, 6.4, aspect="equal", xlabel="x in m", ylabel="y in m")
    low, high = robot.scene.frame_min, robot.scene.frame_max
    style.rectangle(axes, low, high, linewidth=1.4)
    pieces = worst_of_each_place(samples, digest.extruding, digest.check.error_uncompensated, _MAX_PLAN)
    exits = np.array([line.exit_point for line in robot.lines])
    extent = max(float(np.ptp([*exits[:, :2], low[:2], high[:2]], axis=0).max()), 1e-3)
    width = float(
        np.clip(digest.check.beads.typical.width / extent * 5.5 * 72, 1.0, 4.0)
    )  # points: as wide as the bead
    _draw_pieces(drawn, axes, _from_above, pieces, digest, width)
    _mark_worst(axes, _from_above, digest)
    _plan_exits(axes, robot, exits)
    axes.margins(0.09)
    axes.autoscale_view()
    return drawn


def side_view(digest: Digest) -> Figure:
    """Draw frame, path, and lines to the position of the largest error, seen from a corner, without perspective."""
    robot, samples = digest.check.robot, digest.check.samples
    drawn, axes = style.axes(7.4, 6.4, aspect="equal")
    axes.set_axis_off()
    _draw_box(axes, robot)
    pieces = coarse_corners(samples, digest.extruding, _MAX_SIDE, _SIDE_SPAN)
    nearest_last = np.argsort(samples.positions[pieces.end] @ towards_eye(), kind="stable")
    _draw_pieces(drawn, axes, as_seen, Pieces(pieces.begin[nearest_last], pieces.end[nearest_last]), digest, 1.4)
    exits = as_seen(np.array([line.exit_point for line in robot.lines]))
    if digest.worst is not None:
        tied = as_seen(digest.line_ends)
        for i in digest.nearest_lines(MAX_NAMES):
            axes.plot(*zip(exits[i], tied[i], strict=True), color=style.INK, linewidth=0.8, alpha=0.75)
    _mark_worst(axes, as_seen, digest)
    axes.plot(*exits.T, "o", color=style.INK, markersize=4.5)
    if robot.m <= MAX_NAMES:
        for line, end in zip(robot.lines, exits, strict=True):
            _text(axes, end, (0, 7), style.label(line.name), "center")
    axes.margins(0.06)
    return drawn


def _draw_box(axes: Axes, robot: Robot) -> None:
    """Draw the frame: its floor shaded, hidden edges pale, three edges with their length."""
    edges = box_edges(robot.scene.frame_min, robot.scene.frame_max)
    along_x, _, far_along_x = edges[:3]
    axes.fill(*as_seen(np.vstack([along_x, far_along_x[::-1]])).T, color="#f1f4f7", zorder=0)
    corners = edges.reshape(-1, 3)
    hidden_corner = corners[np.argmin(corners @ towards_eye())]
    for edge in edges:
        hidden = bool((edge == hidden_corner).all(axis=1).any())
        width, alpha = (0.7, 0.5) if hidden else (1.1, 1.0)
        axes.plot(*as_seen(edge).T, color=style.GREY, linewidth=width, alpha=alpha, zorder=1)
    for edge, name, offset in ((edges[0], "x", (-6, -12)), (edges[6], "y", (14, -10)), (edges[8], "z", (-26, 0))):
        size = float(np.abs(edge[1] - edge[0]).max())
        _text(axes, as_seen(edge).mean(axis=0), offset, f"{name}: {size:.3g} m", "center")


def _from_above(points: Array) -> Array:
    """Project *points* (k, 3) on the plan, (k, 2)."""
    return points[:, :2]


def _draw_pieces(drawn: Figure, axes: Axes, view: View, pieces: Pieces, digest: Digest, width: float) -> None:
    """Draw pieces of the path in the colours of their error, with the scale beside them."""
    if len(pieces) == 0:
        axes.set_title(digest.nothing_drawn)
        return
    scale = error_scale(digest)
    values = digest.check.error_uncompensated[pieces.end] * 1e3
    look = {"cmap": style.error_colours(), "norm": Normalize(scale.low, scale.high), "linewidths": width, "zorder": 2}
    begin, end = (view(digest.check.samples.positions[rows]) for rows in (pieces.begin, pieces.end))
    bundle = style.pieces(axes, begin, end, values, **look)
    style.colour_bar(drawn, axes, bundle, "error without compensation in mm", extend=scale.extend)


def _mark_worst(axes: Axes, view: View, digest: Digest) -> None:
    """Ring the place with the largest error and write it on the side away from the part."""
    at = digest.worst
    if at is None:
        return
    worst = quantity(float(digest.check.error_uncompensated[at]), "m")
    place = view(digest.check.samples.positions[at : at + 1])[0]
    axes.plot(*place, zorder=5, markeredgewidth=1.6, **style.RING)
    left = bool(place[0] < _middle(view, digest))
    _text(axes, place, (-11 if left else 11, -13), f"largest: {worst}", "right" if left else "left")


def _middle(view: View, digest: Digest) -> float:
    """Half-way across what is extruded, or else the whole path."""
    positions, rows = digest.check.samples.positions, digest.extruding
    low, high = np.inf, -np.inf
    for at in blocks(len(rows) or len(positions)):
        across = view(positions[rows[at] if len(rows) else at])[:, 0]
        low, high = min(low, float(across.min())), max(high, float(across.max()))
        let_go(positions)
    return (low + high) / 2


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


def _text(axes: Axes, at: ArrayLike, offset: tuple[float, float], text: str, side: str) -> None:
    """Write beside the point *at* (2,); *offset* in points of 1/72 inch."""
    x, y = np.asarray(at).tolist()
    box = {"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.75}
    look: dict[str, Any] = {"color": style.INK, "fontsize": 8.5, "zorder": 6, "bbox": box}
    axes.annotate(text, (x, y), xytext=offset, textcoords="offset points", ha=side, **look)


_FLOOR: Final = 1e-3  # mm: smaller errors are of the model, not of a machine
_DOTTED: Final = (0, (1, 1.4))


def error_by_height(digest: Digest) -> Figure | None:
    """Draw errors of extruding moves against height: the uncompensated one plainly, all of them on a log axis.

    Nothing is drawn where nothing is extruded or no error is known.
    """
    heights = digest.heights
    if len(heights.z) == 0:
        return None
    drawn, (plain, log) = style.subplots(9.0, 4.0, 1, 2, sharey=True, width_ratios=(1, 1.5))
    check, without = digest.check, COMPENSATIONS["none"].words
    kinds = [
        (without, check.error_uncompensated, style.RED),
        (COMPENSATIONS["elastic"].words, check.error_elastic_only, style.ORANGE),
    ]
    if check.expected is not None and check.expected.sample is not None:
        kinds.append((f"expected {COMPENSATIONS['full'].words} (rms)", check.expected.rms, style.BLUE))
    for words, error, colour in kinds:
        found = Band(*(1e3 * part for part in heights.band(error)))
        if words == without:
            _draw(plain, heights.z, found, colour, words)
            plain.set_title(words)
        _draw(log, heights.z, Band(*(np.maximum(part, _FLOOR) for part in found)), colour, words)
    plain.set(xlabel="error in mm", ylabel="height of the nozzle in m")
    plain.xaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
    log.set(xscale="log", xlim=(_FLOOR / 2, None))
    style.log_ticks(log.xaxis, *log.get_xlim())
    log.xaxis.set_major_formatter(lambda value, _: ("≤ " if value < _FLOOR * 1.01 else "") + style.power(value))
    log.set(xlabel="error in mm, log axis", title="by compensation")
    log.plot([], [], color=style.GREY, label="median")
    log.plot([], [], color=style.GREY, linestyle=_DOTTED, linewidth=1.5, label="max")
    style.legend_below(drawn, log, columns=5)
    return drawn


def _draw(axes: Axes, z: Array, found: Band, colour: str, name: str) -> None:
    """Draw the median as a line, the max as a dotted one, the band between them; of a single height, rings."""
    marker = "o" if len(z) == 1 else ""
    axes.fill_betweenx(z, found.middle, found.high, color=colour, alpha=0.18, linewidth=0)
    axes.plot(found.middle, z, color=colour, marker=marker, label=name)
    axes.plot(found.high, z, color=colour, marker=marker, mfc="none", linestyle=_DOTTED, linewidth=1.5)
