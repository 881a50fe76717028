"""Pictures of rooms from above: a survey with ellipses and residuals, and a lidar scan with its walls."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cablewright.apps import style
from cablewright.calibration.survey.result import Survey
from cablewright.foundation.arrays import Array
from cablewright.studies.walls import Walls

_MAGNIFIED: Final = 100.0  # times that the ellipses are enlarged
_SIGMAS: Final = 2.4477  # of an ellipse that holds 95 %
_MAX_BARS: Final = 40


def survey_picture(found: Survey) -> Figure:
    """Draw the plan and the residuals of a survey."""
    drawn, (room, bars) = style.subplots(9.6, 5.2, 1, 2, width_ratios=(1.15, 1.0))
    _draw_room(room, found)
    _draw_residuals(bars, found)
    style.legend_below(drawn, room, bars, columns=3)
    return drawn


def _draw_room(axes: Axes, found: Survey) -> None:
    """Draw the plan: points with enlarged 95 % ellipses, and each wall within the box around the points."""
    exits = [(one.line, one.exit_point) for one in found.exits if one.exit_point is not None]
    winches = [(one.line, one.winch_exit) for one in found.exits if one.winch_exit is not None]
    everything = [place[:2] for _, place in exits + winches] + [axis.point[:2] for axis in found.axes] + [np.zeros(2)]
    upright = [wall for wall in found.walls if wall.normal[2] == 0]
    everything += [wall.distance * wall.normal[:2] for wall in upright]
    points = np.array(everything)
    low, high = points.min(axis=0), points.max(axis=0)
    for i, wall in enumerate(upright):
        along = np.array([-wall.normal[1], wall.normal[0]])
        ends = _within(wall.distance * wall.normal[:2], along, low - 0.2, high + 0.2)
        axes.plot(*ends.T, color=style.GREY, linewidth=2.2, label="wall" if i == 0 else None)
        x, y = ends.mean(axis=0) - 0.03 * float(np.max(high - low)) * wall.normal[:2]
        turned = 90.0 if abs(wall.normal[0]) > abs(wall.normal[1]) else 0.0
        name = style.label(wall.name)
        axes.text(x, y, name, rotation=turned, ha="center", va="center", color=style.INK, fontsize=8.5)
    first = 0
    for one in found.exits:
        for place, colour in ((one.exit_point, style.BLUE), (one.winch_exit, style.ORANGE)):
            if place is not None:
                part = found.covariance[first : first + 2, first : first + 2]
                style.ellipse(axes, place[:2], part, _MAGNIFIED * _SIGMAS, colour)
                first += 3
    if winches:
        xy = np.array([place[:2] for _, place in winches])
        axes.plot(*xy.T, "s", color=style.ORANGE, markersize=8, fillstyle="none", label="winch exit")
    if exits:
        xy = np.array([place[:2] for _, place in exits])
        axes.plot(*xy.T, "o", color=style.BLUE, markersize=4, label="exit point")
    for line, place in exits or winches:
        name = style.label(line, 16)
        axes.annotate(name, (place[0], place[1]), xytext=(7, 7), textcoords="offset points", fontsize=8)
    axes.plot([], [], color=style.BLUE, linewidth=0.9, label=f"95 % ellipse, enlarged {_MAGNIFIED:g} times")
    axes.plot(0, 0, "+", color=style.INK, markersize=8, label="origin")
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.08)
    axes.set(xlabel="x in m", ylabel="y in m", title="from above")


def _within(point: Array, along: Array, low: Array, high: Array) -> Array:
    """Return the ends (2, 2) of the part of a line within a box, or of one metre of it where it passes the box by."""
    slanted = np.abs(along) > 1e-9
    steps = np.concatenate([((bound - point) / np.where(slanted, along, 1.0))[slanted] for bound in (low, high)])
    reach = []
    for end in (-1.0, 1.0):
        ahead = steps[steps * end > 0]
        reach.append(float(ahead[np.abs(ahead).argmin()]) if len(ahead) else 0.5 * end)
    return np.array([point + step * along for step in reach])


def _draw_residuals(axes: Axes, found: Survey) -> None:
    """Draw the residual of each marker, the largest first, with the expected one."""
    rows = [row for row in found.residuals if not np.isnan(row.residual)]
    rows = sorted(rows, key=lambda row: row.residual, reverse=True)[:_MAX_BARS]
    axes.set_title("residuals")
    if not rows:
        axes.text(0.5, 0.5, "no marker is checked\nby another one", ha="center", va="center", transform=axes.transAxes)
        axes.set(xticks=[], yticks=[])
        return
    places = np.arange(len(rows))
    colours = [style.RED if row.suspect else style.BLUE for row in rows]
    axes.barh(places, [1e3 * row.residual for row in rows], color=colours, height=0.6)
    expected = [1e3 * row.sigma for row in rows]
    axes.plot(expected, places, "|", color=style.INK, markersize=9, label="expected residual, one sigma")
    axes.set_yticks(places, [style.label(row.point, 14) for row in rows], fontsize=7.5 if len(rows) < 25 else 5.5)
    axes.invert_yaxis()
    axes.set(xlim=(0, None), xlabel="distance from the fit in mm")


_MAX_POINTS: Final = 20_000
_LABEL_AT: Final = (0.5, 0.3, 0.6, 0.4, 0.7)  # along the wall, so that a window's number is beside its wall's


def walls_picture(found: Walls) -> Figure:
    """Draw a scan and its walls, numbered as in the table."""
    points, lines = found.points, found.lines
    drawn, axes = style.axes(7.4, 6.4)
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
    axes.set(xlabel="x in m, lidar's frame", ylabel="y in m", title="walls in the scan")
    style.legend_below(drawn, axes, columns=2)
    return drawn
