"""CSV table of the numbers that a picture shows, in a file beside the picture."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import Collection, LineCollection, QuadMesh
from matplotlib.container import BarContainer
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon

HEAD: Final = ("panel", "title", "x label", "y label", "kind", "number", "label", "x", "y", "z", "value")

Row = tuple[str, int, str, Any, Any, Any, Any]


def table_of(drawn: Figure) -> bytes:
    """Return the data of a figure's panels as CSV: one row a point, in the units of the axes; the columns of `HEAD`.

    Curves, bars, markers, maps, surfaces and areas are there, texts and frames are not. *number* counts the pieces of
    a kind; *value* is what a colour shows.
    """
    out = io.StringIO(newline="")
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(HEAD)
    for panel, axes in enumerate(drawn.axes, 1):
        texts = (axes.get_title(loc="left") or axes.get_title(), axes.get_xlabel(), axes.get_ylabel())
        writer.writerows((panel, *texts, *(_cell(each) for each in row)) for row in _rows(axes))
    return out.getvalue().encode("utf-8")


def _cell(value: Any) -> Any:
    """A number with as many digits as it has in memory; nothing for what is not there."""
    if value is None or (isinstance(value, float) and not np.isfinite(value)) or value is np.ma.masked:
        return ""
    return repr(float(value)) if isinstance(value, np.floating | float) else value


def _rows(axes: Axes) -> Iterator[Row]:
    """Yield kind, number, label, x, y, z and value of each point in a panel."""
    groups = [each for each in axes.containers if isinstance(each, BarContainer)]
    for number, group in enumerate(groups, 1):
        for bar in group.patches:
            yield (
                "bar",
                number,
                _label(group),
                bar.get_x() + 0.5 * bar.get_width(),
                bar.get_y() + bar.get_height(),
                None,
                None,
            )
    for number, line in enumerate(axes.get_lines(), 1):
        if len(line.get_xdata()):  # type: ignore[arg-type]  # what is drawn for the legend has none
            for point in _line(line):
                yield "curve", number, _label(line), *point, None
    for number, patch in enumerate((p for p in axes.patches if isinstance(p, Polygon)), 1):
        for x, y in np.asarray(patch.get_xy()).tolist():
            yield "area", number, _label(patch), x, y, None, None
    for number, each in enumerate(axes.collections, 1):
        for row in _collection(each):
            yield row[0], number, _label(each), *row[1:]


def _label(artist: Any) -> str:
    label = str(artist.get_label())
    return "" if label.startswith("_") else label


def _line(line: Line2D) -> Iterator[tuple[Any, Any, Any]]:
    """Yield the points of a curve, in the plane or in space."""
    if hasattr(line, "get_data_3d"):
        yield from zip(*(np.asarray(each, dtype=float) for each in line.get_data_3d()), strict=True)
    else:
        x, y = (np.asarray(each) for each in (line.get_xdata(), line.get_ydata()))
        yield from ((a, b, None) for a, b in zip(x.tolist(), y.tolist(), strict=True))


def _collection(each: Collection) -> Iterator[tuple[str, Any, Any, Any, Any]]:
    """Yield kind, x, y, z and value of each point that a drawn collection shows: map, lines, markers or faces."""
    shown: Any = each.get_array()
    numbers: Any = np.ma.filled(np.ma.asarray([] if shown is None else shown, dtype=float), np.nan)
    values, offsets = numbers.ravel().tolist(), np.asarray(each.get_offsets(), dtype=float)
    inside = vars(each)  # matplotlib keeps the 3-D points of projected artists under these names only
    if isinstance(each, QuadMesh):
        corners = np.asarray(each.get_coordinates(), dtype=float)
        middles = 0.25 * (corners[1:, 1:] + corners[:-1, 1:] + corners[1:, :-1] + corners[:-1, :-1])
        for (x, y), value in zip(middles.reshape(-1, 2).tolist(), values, strict=True):
            yield "map", x, y, None, value
        return
    if "_offsets3d" in inside:
        kind, pieces = "marker", [np.stack(np.broadcast_arrays(*inside["_offsets3d"]), axis=-1)]
    elif "_segments3d" in inside:
        kind, pieces = "piece", [np.asarray(piece, dtype=float) for piece in inside["_segments3d"]]
    elif "_faces" in inside:
        kind, pieces = "face", [np.asarray(piece, dtype=float) for piece in inside["_faces"]]
    elif isinstance(each, LineCollection):
        kind, pieces = "piece", [np.asarray(piece, dtype=float) for piece in each.get_segments()]
    elif offsets.any():
        kind, pieces = "marker", [offsets]
    else:
        kind, pieces = "area", [np.asarray(path.vertices, dtype=float) for path in each.get_paths()]
    for number, piece in enumerate(pieces):
        for k, point in enumerate(piece):
            at = k if kind == "marker" else number
            yield kind, *point[:3], *[None] * (3 - len(point)), values[at] if at < len(values) else None
