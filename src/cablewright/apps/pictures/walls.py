"""A lidar's scan from above: its points, and the walls among them."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure

from cablewright.apps import style
from cablewright.studies.walls import Walls

_MAX_POINTS: Final = 20_000
_LABEL_AT: Final = (0.5, 0.3, 0.6, 0.4, 0.7)  # along the wall, so that a window's number is beside its wall's


def walls_picture(found: Walls) -> Figure:
    """Draw a scan and its walls, numbered as in the table."""
    points, lines = found.points, found.lines
    drawn = style.figure(7.4, 6.4)
    axes = drawn.subplots()
    shown = points.xy[:: 1 + len(points) // _MAX_POINTS]
    axes.plot(*shown.T, ".", color=style.GREY, markersize=3, label=f"{len(points)} points used")
    for i, line in enumerate(lines):
        colour = style.COLOURS[i % 4]
        about = f"{i + 1}: {line.distance:.3f} m away, rms {1e3 * line.variance**0.5:.1f} mm, {line.point_count} points"
        axes.plot(*line.ends.T, color=colour, linewidth=2.0, label=about if i < 12 else None)
        away = (11 * np.cos(line.angle), 11 * np.sin(line.angle))
        x, y = line.ends[0] + _LABEL_AT[i % len(_LABEL_AT)] * (line.ends[1] - line.ends[0])
        look: dict[str, Any] = {"ha": "center", "va": "center", "color": colour, "fontweight": "bold"}
        axes.annotate(str(i + 1), (x, y), xytext=away, textcoords="offset points", **look)
    axes.plot(0, 0, "+", color=style.INK, markersize=10, label="lidar")
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.06)
    axes.set(xlabel="x in m, lidar's frame", ylabel="y in m")
    axes.set_title("walls in the scan")
    style.legend_below(drawn, axes, columns=2)
    return drawn
