"""How far off the nozzle is at each height: without and with partial compensation, and what is expected with all."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from cablewright.analyses.accuracy.compensation import COMPENSATIONS
from cablewright.apps import style
from cablewright.apps.report.digest import Band, Digest
from cablewright.arrays import Array

_FLOOR: Final = 1e-3  # mm: smaller errors are of the model, not of a machine
_DOTTED: Final = (0, (1, 1.4))


def error_by_height(digest: Digest) -> Figure | None:
    """Draw errors of what is extruded against height: the uncompensated one plainly, all of them on a log axis.

    Nothing is drawn where nothing is extruded or no error is known.
    """
    heights = digest.heights
    if len(heights.z) == 0:
        return None
    drawn = style.figure(9.0, 4.0)
    plain, log = drawn.subplots(1, 2, sharey=True, width_ratios=(1, 1.5))
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
    log.set_xscale("log")
    log.set_xlim(left=_FLOOR / 2)
    style.log_ticks(log.xaxis, *log.get_xlim())
    log.xaxis.set_major_formatter(lambda value, _: ("≤ " if value < _FLOOR * 1.01 else "") + style.power(value))
    log.set(xlabel="error in mm, log axis")
    log.set_title("by compensation")
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
