"""Pictures of the tension of each line along a print, and of the share of each limit that is used."""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cablewright.analyses.feasibility import LIMITS
from cablewright.apps import style
from cablewright.apps.quantities import quantity
from cablewright.apps.report.check_summary import Digest, grouped
from cablewright.foundation.arrays import Array
from cablewright.robot import Line
from cablewright.studies.checks.path_statics import extreme, median
from cablewright.studies.checks.result import LARGEST, SMALLEST

MAX_LINES: Final = 8
"""Lines that one picture shows; where there are more, those nearest to their limits."""

_USED: Final = {
    "winch speed": ("winch speed", "m/s", 1.0),
    "winch torque": ("winch torque", "N m", 1.0),
    "swing": ("swing of the sheave", "degrees", 180 / math.pi),
    "lever": ("angle of the lever", "degrees", 180 / math.pi),
}
"""Title, unit and the factor to it from SI of the limits that are drawn, by name."""

_FAR: Final = 4.0  # a limit this many times above the highest tension is written, not drawn


class Use(NamedTuple):
    """The part of one limit's range that each line uses.

    NaN where a line has no value, infinite where no bound.
    """

    title: str
    unit: str  # as it is drawn
    low: Array  # (m,)
    high: Array  # (m,)
    allowed: Array  # (m, 2)


def tensions(digest: Digest) -> Figure | None:
    """Draw min, median and max tension of each line along the print, with limits, in panels on common axes.

    Nothing is drawn where no tension is known.
    """
    check = digest.check
    if math.isnan(extreme(np.fmax, check.statics.tensions)):
        return None
    lines = digest.nearest_lines(MAX_LINES)
    drawn, panels, columns = style.panels(len(lines), 1.9, spare=0.7, sharex=True, sharey=True)
    starts = digest.stretches
    seconds, unit = style.time_unit(check.law.duration)
    time = np.append(check.law.time[starts], check.law.duration) / seconds
    low = grouped(SMALLEST, check.statics.lines.lowest_tension, starts)
    middle = grouped(median, check.statics.tensions, starts)
    high = grouped(LARGEST, check.statics.lines.highest_tension, starts)
    top = float(np.nanmax(high[:, lines], initial=0.0))
    for i, axes in zip(lines, panels, strict=True):
        axes.fill_between(time, _held(low[:, i]), _held(high[:, i]), step="post", color=style.BLUE, alpha=0.3, lw=0)
        marker = "o" if len(starts) == 1 else ""
        axes.step(time, _held(middle[:, i]), where="post", color=style.BLUE, linewidth=1.3, marker=marker)
        _draw_tension_limits(axes, check.robot.lines[i], top)
        axes.set_title(style.label(check.robot.lines[i].name), fontsize=9.5)
    panels[0].margins(x=0)
    bottom, upper = panels[0].get_ylim()
    panels[0].set_ylim(bottom, upper + 0.12 * (upper - bottom))  # room for the text on a limit far above
    style.outer_labels(panels, columns, f"time in {unit}", "tension in N")
    return drawn


def _held(values: Array) -> Array:
    """Repeat the last value, so that steps reach the end."""
    return np.append(values, values[-1:])


def _draw_tension_limits(axes: Axes, line: Line, top: float) -> None:
    low, high = line.tension_limits
    limit: dict[str, Any] = {"color": style.RED, "linewidth": 1.2, "linestyle": style.DASHED}
    axes.axhline(low, **limit)
    if high <= _FAR * max(top, low):
        axes.axhline(high, **limit)
    else:
        text = f"max allowed {quantity(high, 'N')}, far above"
        axes.text(0.99, 0.97, text, ha="right", va="top", transform=axes.transAxes, fontsize=8, color=style.RED)


def uses(digest: Digest) -> list[Use]:
    """Return the used ranges of winch speed, winch torque, swing and lever angle, where known, in the units drawn."""
    lines, known = digest.check.robot.lines, []
    for limit in LIMITS:
        if limit.name in _USED:
            title, unit, factor = _USED[limit.name]
            values = limit.values(digest.check.statics.lines)
            low, high = SMALLEST(values) * factor, LARGEST(values) * factor
            if np.isfinite(high).any():
                known.append(Use(title, unit, low, high, limit.allowed(lines) * factor))
    return known


def limits(digest: Digest) -> Figure | None:
    """Draw for each quantity and line the range used, and the range allowed; None if nothing is known."""
    known = uses(digest)
    if not known:
        return None
    lines = digest.nearest_lines(MAX_LINES)
    drawn, panels, _ = style.panels(len(known), 1.15 + 0.24 * len(lines))
    for use, axes in zip(known, panels, strict=True):
        _draw_use(axes, use, lines, [style.label(digest.check.robot.lines[i].name, 16) for i in lines])
    return drawn


def _draw_use(axes: Axes, use: Use, lines: list[int], names: list[str]) -> None:
    """Draw the ranges of one quantity: allowed pale with its ends marked, used blue, or orange if it goes outside."""
    places = np.arange(len(lines))
    low, high, allowed = use.low[lines], use.high[lines], use.allowed[lines]
    for place, (lower, upper) in zip(places, allowed, strict=True):
        if math.isfinite(upper):
            begin = lower if math.isfinite(lower) else 0.0
            axes.barh(place, upper - begin, left=begin, height=0.62, color="#e9edf1", zorder=1)
        for end in (lower, upper):
            if math.isfinite(end):
                axes.plot([end, end], [place - 0.36, place + 0.36], color=style.INK, linewidth=2, zorder=3)
    outside = (low < allowed[:, 0]) | (high > allowed[:, 1])
    colours = [style.RED if out else style.BLUE for out in outside]
    ends = np.concatenate([low, high, allowed[np.isfinite(allowed)]])
    span = float(np.nanmax(ends) - np.nanmin(ends)) or float(np.nanmax(np.abs(high)))
    width = np.maximum(high - low, 0.004 * span)  # a range of one value is still seen
    axes.barh(places, width, left=low, height=0.34, color=colours, zorder=2)
    axes.set_yticks(places, names)
    axes.set_ylim(len(lines) - 0.4, -0.6)
    axes.grid(visible=False, axis="y")
    axes.use_sticky_edges = False
    axes.margins(x=0.03)
    if not np.isfinite(allowed).any() and np.nanmin(low) >= 0 and "degrees" not in use.unit:
        axes.set_xlim(left=0)
    axes.set_xlabel(f"{use.title} in {use.unit}")
