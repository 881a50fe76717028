"""How far off the nozzle is at each height: without, with stretch alone and with full compensation."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from cablewright.analyses.accuracy.compensation import COMPENSATIONS
from cablewright.apps import style
from cablewright.apps.report.digest import Band, Digest
from cablewright.arrays import Array

_RAISED: Final = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_FLOOR: Final = 1e-6  # mm: below it the arithmetic speaks, not the machine


def error_by_height(digest: Digest) -> Figure | None:
    """Draw errors of what is extruded against height: the uncompensated one plainly, all of them on a log axis.

    Nothing is drawn where nothing is extruded or no error is known.
    """
    heights = digest.heights
    if len(heights.z) == 0:
        return None
    drawn = style.figure(9.0, 4.0)
    plain, log = drawn.subplots(1, 2, sharey=True, width_ratios=(1, 1.5))
    kinds = (
        ("none", digest.check.error_uncompensated, style.RED),
        ("elastic", digest.check.error_elastic_only, style.ORANGE),
        ("full", digest.check.error_compensated, style.BLUE),
    )
    for name, error, colour in kinds:
        found, words = heights.band(error * 1e3), COMPENSATIONS[name].words
        if name == "none":
            _draw(plain, heights.z, found, colour, words)
            plain.set_title(words)
        _draw(log, heights.z, Band(*(np.maximum(part, _FLOOR) for part in found)), colour, words)
    plain.set(xlabel="error in mm", ylabel="height of the nozzle in m")
    plain.xaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
    log.set_xscale("log")
    log.set_xlim(left=_FLOOR / 2)
    log.xaxis.set_major_locator(LogLocator(numticks=12))
    log.xaxis.set_major_formatter(FuncFormatter(_millimetres))
    log.xaxis.set_minor_formatter(NullFormatter())
    log.set(xlabel="error in mm, log axis")
    log.set_title("all three")
    _legend(drawn, log)
    return drawn


def _draw(axes: Axes, z: Array, found: Band, colour: str, name: str) -> None:
    """Draw the median as a line and the highest as a dotted one, with the band between them; of one height, rings."""
    marker = "o" if len(z) == 1 else ""
    axes.fill_betweenx(z, found.middle, found.high, color=colour, alpha=0.18, linewidth=0)
    axes.plot(found.middle, z, color=colour, marker=marker, label=name)
    axes.plot(found.high, z, color=colour, marker=marker, mfc="none", linestyle=(0, (1, 1.4)), linewidth=1.5)


def _legend(drawn: Figure, axes: Axes) -> None:
    from matplotlib.lines import Line2D

    handles, names = axes.get_legend_handles_labels()
    handles += [
        Line2D([], [], color=style.GREY),
        Line2D([], [], color=style.GREY, linestyle=(0, (1, 1.4)), linewidth=1.5),
    ]
    drawn.legend(handles, [*names, "median", "highest"], loc="outside lower center", ncols=5)


def _millimetres(value: float, _position: int) -> str:
    if value >= 0.999e-3:
        return f"{value:g}"
    power = round(math.log10(value))
    text = "10" + str(power).translate(_RAISED)
    return f"≤ {text}" if value < _FLOOR * 1.01 else text
