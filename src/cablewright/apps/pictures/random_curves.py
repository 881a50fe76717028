"""Picture of many random curves, to choose one."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from cablewright.apps import style
from cablewright.printing.random_curve import Curves

_WIDTH = 12.0  # inches
_WIDE = 14  # max number of curves side by side, of a square area
_GAP = 0.12  # between two, of the area's shorter side
_TITLE = 0.19  # inches, for a curve's number


def curves_picture(found: Curves) -> Figure:
    """Draw numbered curves row by row, each in its area, m, all at one scale."""
    curves, required = found.ranked, found.requirements
    x, y = required.area
    gap = _GAP * min(x, y)
    columns = min(len(curves), max(4, round(_WIDE * math.sqrt(y / x))))
    rows = math.ceil(len(curves) / columns)
    scale = _WIDTH / (columns * (x + gap))  # inches per metre
    pitch = np.array([x + gap, y + gap + _TITLE / scale])
    drawn, axes = style.axes(_WIDTH, rows * pitch[1] * scale + 0.4)
    axes.set_title(f"{len(curves)} closed curves of {required.length:g} m in {x:g} × {y:g} m, the best cover first")
    half, lines = 0.5 * np.array([x, y]), []
    for place, one in enumerate(curves):
        row, column = divmod(place, columns)
        centre = pitch * [column, -row]
        lines.append(one.curve.even(400) + centre)
        style.rectangle(axes, centre - half, centre + half, linewidth=0.5)
        axes.text(centre[0], centre[1] + 0.5 * y, str(one.number), ha="center", va="bottom", fontsize=7.5)
    axes.add_collection(LineCollection(lines, colors=style.BLUE, linewidths=1.0))
    ends = 0.5 * pitch
    axes.set(aspect="equal", xlim=(-ends[0], columns * pitch[0] - ends[0]), ylim=(ends[1] - rows * pitch[1], ends[1]))
    axes.set_axis_off()
    return drawn
