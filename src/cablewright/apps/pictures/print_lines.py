"""What the lines did in a print: their angles, how cable lies on the winch drums, at which frequency they ring."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from cablewright.apps import style
from cablewright.apps.pictures.print import clock
from cablewright.arrays import Array, Indices
from cablewright.signals import PrintState
from cablewright.studies.prints.result import PrintRecord
from cablewright.studies.prints.steps_table import in_state

_MAX_LINES: Final = 12  # lines that a picture has room for
_COLOURS: Final = (style.BLUE, style.ORANGE, style.GREEN, style.RED, style.INK, style.GREY)


def angles_picture(found: PrintRecord) -> Figure | None:
    """Measured angle and the taut line's, of the most and the least loaded line: Fig. 7 of Merlet and Papegay 2023."""
    taut, measured = found.rows["taut"], found.rows["measured"]
    if not (np.isfinite(taut).any() and np.isfinite(measured).any()):
        return None
    shares = np.array([line.taut for line in found.lines])
    order = np.argsort(np.where(np.isfinite(shares), shares, 2.0), kind="stable")
    rows = _last_layer(found)
    drawn = style.figure(9.6, 4.8)
    axes = drawn.subplots(2, 1, sharex=True)
    size, unit = clock(float(np.ptp(found.rows["time"][rows])))
    time = found.rows["time"][rows] / size
    for axis, line in ((axes[0], int(order[-1])), (axes[1], int(order[0]))):
        axis.plot(time, np.degrees(measured[rows, line]), color=style.ORANGE, linewidth=0.7, label="measured")
        axis.plot(time, np.degrees(taut[rows, line]), color=style.BLUE, linewidth=1.3, label="if it were taut")
        name = style.label(found.lines[line].name)
        axis.set(ylabel="angle in degrees", title=f"line {name}: taut {1e2 * shares[line]:.0f} % of the time")
        axis.legend(loc="upper right", ncols=2)
        axis.margins(x=0.01)
        axis.set_ylim(*_reach(np.degrees(np.concatenate([measured[rows, line], taut[rows, line]]))))
    axes[1].set_xlabel(f"time in {unit}")
    return drawn


def _last_layer(found: PrintRecord) -> Indices:
    """Rows that printed in the last layer of which much was printed; all, where none was."""
    rows, begins = found.rows, found.track.visits.begin
    printing = in_state(rows, PrintState.PRINTING) & np.isfinite(rows["distance"])
    visit = np.searchsorted(begins, rows["distance"], side="right") - 1
    counts = np.bincount(np.maximum(visit[printing], 0), minlength=len(begins))
    if not counts.any():
        return np.arange(len(rows))
    last = int(np.flatnonzero(counts >= 0.7 * counts.max())[-1])
    return np.flatnonzero(printing & (visit == last))


def _reach(values: Array) -> tuple[float, float]:
    """Between which values as good as all is, with room above for a legend; a few readings astray do not count."""
    known = values[np.isfinite(values)]
    low, high = np.quantile(known, [0.002, 0.998]).tolist()
    margin = max(0.1 * (high - low), 1.0)
    return low - margin, high + 2.5 * margin


def tensions_picture(found: PrintRecord) -> Figure | None:
    """Tension of each line in the last layer: true, and as the lines that are taut must bear the drum."""
    rows = _last_layer(found)
    true, believed = found.rows["tensions"][rows], found.rows["estimated_tensions"][rows]
    if not (np.isfinite(true).any() or np.isfinite(believed).any()):
        return None
    count = min(len(found.lines), _MAX_LINES)
    across = 2 if count > 1 else 1
    drawn = style.figure(9.6, 1.0 + 1.6 * -(-count // across))
    axes = drawn.subplots(-(-count // across), across, sharex=True, sharey=True, squeeze=False).ravel()
    size, unit = clock(float(np.ptp(found.rows["time"][rows])))
    time = found.rows["time"][rows] / size
    for i, axis in enumerate(axes[:count]):
        if np.isfinite(true).any():
            axis.plot(time, true[:, i], color=style.GREY, linewidth=2.0, label="true")
        axis.plot(time, believed[:, i], color=style.BLUE, linewidth=0.8, label="believed")
        axis.set_title(f"line {style.label(found.lines[i].name)}")
        axis.set_ylim(bottom=0.0)
        axis.margins(x=0.01)
        if i % across == 0:
            axis.set_ylabel("tension in N")
        if i >= count - across:
            axis.set_xlabel(f"time in {unit}")
    _one_legend(drawn, axes[0])
    _hide(axes, count)
    return drawn


def coiling_picture(found: PrintRecord) -> Figure | None:
    """Radius at which cable leaves each winch drum, against the length paid out."""
    known = [i for i, each in enumerate(found.spools) if np.isfinite(each.radii).any()][:_MAX_LINES]
    if not known:
        return None
    across = 2 if len(known) > 1 else 1
    drawn = style.figure(9.6, 1.0 + 1.9 * -(-len(known) // across))
    axes = drawn.subplots(-(-len(known) // across), across, sharey=True, squeeze=False).ravel()
    for at, (axis, i) in enumerate(zip(axes, known, strict=False)):
        each = found.spools[i]
        axis.plot(each.lengths, 1e3 * each.regular, color=style.INK, linewidth=0.9, linestyle=(0, (4, 2)),
                  label="wound evenly")  # fmt: skip
        axis.plot(each.lengths, 1e3 * each.true_radii, color=style.GREY, linewidth=2.4, label="true")
        axis.plot(each.lengths, 1e3 * each.radii, color=style.BLUE, linewidth=1.1, label="estimated")
        name = style.label(found.lines[i].name)
        axis.set_title(f"{name}: irregular by {1e3 * each.irregularity:.2f} mm")
        if at % across == 0:
            axis.set_ylabel("radius in mm")
        if at >= len(known) - across:
            axis.set_xlabel("m of cable paid out")
    _one_legend(drawn, axes[0])
    _hide(axes, len(known))
    return drawn


def ringing_picture(found: PrintRecord) -> Figure | None:
    """First frequencies of the lines over time, and against the temperature what they are off a string's."""
    ringing = found.vibration
    if not np.isfinite(ringing.frequencies).any():
        return None
    drawn = style.figure(9.6, 3.6)
    over, warm = drawn.subplots(1, 2, width_ratios=(1.6, 1.0))
    size, unit = clock(found.duration)
    for i, line in enumerate(found.lines[: len(_COLOURS)]):
        known = np.isfinite(ringing.frequencies[:, i])
        if not known.any():
            continue
        own, colour = ringing.frequencies[known, i], _COLOURS[i]
        over.plot(ringing.times / size, ringing.expected[:, i], color=colour, linewidth=0.8, alpha=0.5)
        over.plot(ringing.times[known] / size, own, ".", color=colour, markersize=4, label=style.label(line.name))
        off = 1e2 * (own / ringing.expected[known, i] - 1.0)
        warm.plot(ringing.temperatures[known], off, ".", color=colour, markersize=4)
    over.set(xlabel=f"time in {unit}", ylabel="Hz", title="measured; thin: of a string with its load")
    over.set_ylim(bottom=0.0)
    warm.set(xlabel="°C in the room", ylabel="measured over expected, % more", title="against the temperature")
    _one_legend(drawn, over)
    return drawn


def _one_legend(drawn: Figure, axes: Axes) -> None:
    handles, names = axes.get_legend_handles_labels()
    drawn.legend(handles, names, loc="outside lower center", ncols=max(1, len(names)))


def _hide(axes: NDArray[np.object_], count: int) -> None:
    for axis in axes[count:]:
        axis.set_visible(False)
