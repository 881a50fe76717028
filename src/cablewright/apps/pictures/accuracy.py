"""Errors of the nozzle along a path and over a plane, and the contribution of each uncertain parameter."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from cablewright.analyses.accuracy.nozzle_error import Accuracy
from cablewright.apps import style
from cablewright.apps.quantities import enlargement
from cablewright.apps.space_axes import add_faces, add_lines, bounds, frame_points, heights, machine, space
from cablewright.foundation.arrays import Array, Indices
from cablewright.studies.accuracy import AccuracyStudy

_MAX_PIECES: Final = 4000
_MAX_BINS: Final = 240
_MANY_TURNS: Final = 15  # of a helix, each of which is then one stretch
_MAX_NODES: Final = 60  # along one side of a surface
_MAX_BARS: Final = 20
_DISPLACED: Final = 0.12  # of the size of the path: about how far the displaced one is drawn from it
_SMALL: Final = 0.25  # of the frame: a smaller path is drawn without it
_LEVEL: Final = 0.02  # of its length: a path whose height varies less is drawn over its distance


def along(study: AccuracyStudy) -> Figure:
    """Draw the path with its displacement, and the components of its error against height, or distance if level."""
    found = study.accuracy
    errors = found.spread.max_error * 1e3
    drawn = style.figure(10.6, 5.2)
    grid = drawn.add_gridspec(1, 2, width_ratios=(1.05, 1.0))
    kept = _worst_of_each(errors, _MAX_PIECES)
    path, offset, shown = study.places.positions[kept], found.worst_offset[kept], errors[kept]
    times = displaced_by(study)
    moved = path + times * offset
    low, high = bounds(path, moved)
    frame = bounds(*frame_points(found.robot))
    if (high - low).max() > _SMALL * (frame[1] - frame[0]).max():
        axes, even = machine(drawn, grid[0], found.robot, low, high), True
    else:
        axes, even = space(drawn, grid[0], low, high, "m")
    known = np.isfinite(shown)
    both = known[1:] & known[:-1]
    # Where the worst corner changes to the other side, the displaced path jumps: it is not drawn through.
    steady = both & ((offset[1:] * offset[:-1]).sum(axis=1) > 0.0)
    scale = style.scale_of(errors[np.isfinite(errors)])
    colours = style.error_bar(drawn, axes, scale, "largest error in mm", shrink=0.7, pad=0.12)
    pieces = np.stack([path[:-1], path[1:]], axis=1)
    add_lines(axes, pieces[~both], 2, 0.8, style.GREY)
    add_lines(axes, np.stack([moved[:-1], moved[1:]], axis=1)[steady], 3, 0.9, style.INK)
    add_lines(axes, pieces[both], 4, 2.4, colours.to_rgba(np.maximum(shown[1:], shown[:-1])[both]))
    alone = known & ~np.append(False, both) & ~np.append(both, False)
    axes.scatter(*path[alone].T, s=14, c=colours.to_rgba(shown[alone]), depthshade=False, zorder=4)
    size = f"{times:g} × the error" if times != 1 else "the error"
    note = "" if even else "\nthin side not to scale"
    axes.set_title(f"commanded path, in colour; thin: displaced by {size}{note}")
    _components(drawn.add_subplot(grid[1]), study)
    return drawn


def displaced_by(study: AccuracyStudy) -> float:
    """Return the factor by which the error is enlarged where the picture displaces the path: 1, 2 or 5 times 10ⁿ."""
    offsets = np.linalg.norm(study.accuracy.worst_offset, axis=1)
    largest = float(np.nanmax(offsets)) if np.isfinite(offsets).any() else 0.0
    size = float(np.linalg.norm(np.ptp(study.places.positions, axis=0)))
    return enlargement(_DISPLACED * size, largest)


def _components(axes: Axes, study: AccuracyStudy) -> None:
    """Draw the error's components: the median of each stretch as a line, the range in it as a band."""
    found, distance = study.accuracy, study.places.distance
    heights = study.places.positions[:, 2]
    size = float(np.linalg.norm(np.ptp(study.places.positions, axis=0)))
    upright = distance is None or float(np.ptp(heights)) > _LEVEL * size
    at = heights if upright or distance is None else distance
    bins = _bins(study)
    kinds = (
        ("largest error", found.spread.max_error, style.INK, "-"),
        ("its horizontal part", np.linalg.norm(found.worst_offset[:, :2], axis=1), style.BLUE, "-"),
        ("its vertical part", np.abs(found.worst_offset[:, 2]), style.ORANGE, "-"),
        ("error if all numbers are nominal", found.nominal_error, style.GREEN, "--"),
    )
    for name, values, colour, dashes in kinds:
        middle, low, centre, high = _binned(at, values * 1e3, bins)
        marker = "o" if len(middle) == 1 else ""
        fill = axes.fill_betweenx if upright else axes.fill_between
        fill(middle, low, high, color=colour, alpha=0.16, linewidth=0)
        line = (centre, middle) if upright else (middle, centre)
        axes.plot(*line, dashes, color=colour, marker=marker, label=name)
    error, place = "error in mm", "height of the nozzle in m" if upright else "distance along the path in m"
    axes.set(xlabel=error if upright else place, ylabel=place if upright else error)
    (axes.set_xlim if upright else axes.set_ylim)(0.0)
    axes.set_title("parts of the error")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=2)


def _bins(study: AccuracyStudy) -> int:
    """Return the number of stretches: one for each turn of a helix with many turns, so that the curves are even."""
    if study.places.shape != "helix":
        return _MAX_BINS
    away = study.places.positions[:, :2] - study.places.positions[:, :2].mean(axis=0)
    turns = float(np.ptp(np.unwrap(np.arctan2(away[:, 1], away[:, 0])))) / (2.0 * math.pi)
    return min(int(turns), _MAX_BINS) if turns >= _MANY_TURNS else _MAX_BINS


def _binned(at: Array, values: Array, bins: int) -> tuple[Array, Array, Array, Array]:
    """Return mean place, min, median and max of the values of each stretch that has any."""
    known = np.isfinite(values)
    at, values = at[known], values[known]
    if not len(at):
        return at, at, at, at
    width = float(np.ptp(at)) / bins or 1.0
    order = np.argsort(at, kind="stable")
    # The last place is at the very end of the last stretch, not in one of its own.
    stretch = np.minimum(np.floor((at[order] - at[order[0]]) / width), bins - 1)
    starts = np.flatnonzero(np.append(True, stretch[1:] != stretch[:-1]))
    parts = np.split(values[order], starts[1:])
    places = np.array([part.mean() for part in np.split(at[order], starts[1:])])
    low, middle, high = (np.array([take(part) for part in parts]) for take in (np.min, np.median, np.max))
    return places, low, middle, high


def _worst_of_each(errors: Array, limit: int) -> Indices:
    """Return up to *limit* rows in order: the one with the largest error of each run of neighbours, and both ends."""
    if len(errors) <= limit:
        return np.arange(len(errors))
    edges = np.linspace(0, len(errors), limit - 1).astype(np.intp)
    known = np.where(np.isfinite(errors), errors, -1.0)
    worst = [low + int(known[low:high].argmax()) for low, high in pairwise(edges)]
    return np.unique([0, *worst, len(errors) - 1])


def plane(study: AccuracyStudy) -> Figure:
    """Draw the lowest and the highest vertical error as surfaces, and the largest error as a map."""
    x, y = study.places.axes
    shape = (len(x), len(y))
    spread = study.accuracy.spread
    drawn = style.figure(10.6, 4.9)
    grid = drawn.add_gridspec(1, 2, width_ratios=(1.0, 1.0))
    _surfaces(drawn, grid[0], x, y, [(part[:, 2] * 1e3).reshape(shape) for part in (spread.low, spread.high)])
    above = drawn.add_subplot(grid[1], aspect="equal", xlabel="x in m", ylabel="y in m")
    errors = (spread.max_error * 1e3).reshape(shape)
    known = errors[np.isfinite(errors)]
    scale = style.scale_of(known)
    style.cells(above, x, y, errors.T, style.error_bar(drawn, above, scale, "largest error in mm"))
    if len(known) > 3 and np.ptp(known) > 0.0:
        levels = MaxNLocator(6).tick_values(scale.low, scale.high)
        rings = above.contour(x, y, np.ma.masked_invalid(errors.T), levels, colors="white", linewidths=0.8)
        above.clabel(rings, fontsize=7.5)
    above.set_title(f"largest error at a height of {study.places.positions[0, 2]:.3g} m")
    return drawn


def _surfaces(drawn: Figure, where: SubplotSpec, x: Array, y: Array, both: list[Array]) -> None:
    """Draw two surfaces over a grid, the lower one first; heights have their own scale."""
    kept = [np.unique(np.append(np.arange(0, len(a), -(-len(a) // _MAX_NODES)), len(a) - 1)) for a in (x, y)]
    values = [one[np.ix_(*kept)] for one in both]
    known = np.concatenate([one[np.isfinite(one)] for one in values])
    low, high = (float(known.min()), float(known.max())) if len(known) else (0.0, 1.0)
    spare = 0.04 * max(high - low, 1e-6)
    axes = heights(drawn, where, (x[0], y[0], low - spare), (x[-1], y[-1], high + spare))
    nodes = np.stack(np.meshgrid(x[kept[0]], y[kept[1]], indexing="ij"), axis=-1)
    for order, (one, colour) in enumerate(zip(values, (style.BLUE, style.ORANGE), strict=True)):
        points = np.concatenate([nodes, one[..., None]], axis=-1)
        faces = np.stack([points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]], axis=2).reshape(-1, 4, 3)
        add_faces(axes, faces[np.isfinite(faces).all(axis=(1, 2))], colour, 3 + order, alpha=0.7, edge=(1, 1, 1, 0.6))
    axes.set_title("lowest and highest vertical error")
    patches = [Patch(color=style.BLUE), Patch(color=style.ORANGE)]
    axes.legend(patches, ["lowest", "highest"], loc="upper left", bbox_to_anchor=(0.0, 0.97))


def contributions(accuracy: Accuracy) -> Figure:
    """Draw how far each uncertain number alone moves the nozzle, the largest first, with the vertical part."""
    shown = accuracy.contributions[:_MAX_BARS]
    sizes, vertical = np.array([(each.effect, abs(each.offset[2])) for each in shown]).T * 1e3
    drawn, axes = style.axes(
        8.4, 1.3 + 0.27 * len(shown), xlabel="displacement of the nozzle by half the number's range in mm"
    )
    rows = np.arange(len(shown))
    axes.barh(rows, sizes, height=0.72, color=style.BLUE)
    axes.barh(rows, vertical, height=0.3, color=style.ORANGE)
    names = [style.label(each.range.parameter.label, 44) for each in shown]
    axes.set_yticks(rows, names)
    axes.set_ylim(len(shown) - 0.4, -0.6)
    axes.grid(visible=False, axis="y")
    axes.tick_params(axis="y", length=0)
    for row, size in zip(rows, sizes, strict=True):
        axes.annotate(f"{size:.3g}", (size, row), xytext=(4, 0), textcoords="offset points", va="center", fontsize=8)
    axes.margins(x=0.1)
    axes.set_xlim(left=0.0)
    handles = [Patch(color=style.BLUE), Patch(color=style.ORANGE)]
    drawn.legend(handles, ["whole displacement", "its vertical part"], loc="outside lower center", ncols=2)
    return drawn
