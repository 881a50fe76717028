"""Pictures of the lines in a print: angles, tensions, radii on the winch drums, and frequencies."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.figure import Figure

from cablewright.apps import style
from cablewright.apps.pictures.simulation import line_angle
from cablewright.foundation.arrays import Array, Indices
from cablewright.foundation.signals import PrintState
from cablewright.live.prints.result import PrintRecord
from cablewright.live.prints.steps_table import in_state

_MAX_LINES: Final = 12  # that a picture has room for


def angles_picture(found: PrintRecord) -> Figure | None:
    """Draw the angles of the lines that are taut most and least often: Fig. 7 of Merlet and Papegay 2023."""
    taut, measured = found.rows["taut"], found.rows["measured"]
    if not (np.isfinite(taut).any() and np.isfinite(measured).any()):
        return None
    shares = np.array([line.taut for line in found.lines])
    order = np.argsort(np.where(np.isfinite(shares), shares, 2.0), kind="stable")
    rows = _last_layer(found)
    drawn, axes = style.subplots(9.6, 4.8, 2, 1, sharex=True)
    time, unit = _time(found, rows)
    for axis, i in zip(axes, (int(order[-1]), int(order[0])), strict=True):
        line_angle(axis, time, found.lines[i].name, shares[i], measured[rows, i], taut[rows, i])
        axis.set_ylim(*_reach(np.degrees(np.concatenate([measured[rows, i], taut[rows, i]]))))
    axes[1].set_xlabel(f"time in {unit}")
    return drawn


def _last_layer(found: PrintRecord) -> Indices:
    """Return the rows that printed in the last layer of which much was printed; all rows, where none was."""
    rows, begins = found.rows, found.track.visits.begin
    printing = in_state(rows, PrintState.PRINTING) & np.isfinite(rows["distance"])
    visit = np.searchsorted(begins, rows["distance"], side="right") - 1
    counts = np.bincount(np.maximum(visit[printing], 0), minlength=len(begins))
    if not counts.any():
        return np.arange(len(rows))
    return np.flatnonzero(printing & (visit == np.flatnonzero(counts >= 0.7 * counts.max())[-1]))


def _time(found: PrintRecord, rows: Indices) -> tuple[Array, str]:
    """Return the times of *rows*, and their unit."""
    time = found.rows["time"][rows]
    size, unit = style.time_unit(float(np.ptp(time)))
    return time / size, unit


def _reach(values: Array) -> tuple[float, float]:
    """Return the ends of an axis that shows all but a few outliers, with room above for a legend."""
    low, high = np.quantile(values[np.isfinite(values)], [0.002, 0.998]).tolist()
    margin = max(0.1 * (high - low), 1.0)
    return low - margin, high + 2.5 * margin


def tensions_picture(found: PrintRecord) -> Figure | None:
    """Draw the tension of each line in the last layer: true, and as estimated from the lines that are taut."""
    rows = _last_layer(found)
    kinds = (
        ("true", found.rows["tensions"][rows], style.GREY, 2.0),
        ("estimated", found.rows["estimated_tensions"][rows], style.BLUE, 0.8),
    )
    known = [each for each in kinds if np.isfinite(each[1]).any()]
    if not known:
        return None
    time, unit = _time(found, rows)
    drawn, axes, columns = style.panels(min(len(found.lines), _MAX_LINES), 1.6, spare=1.0, sharex=True, sharey=True)
    for i, axis in enumerate(axes):
        for name, values, colour, width in known:
            axis.plot(time, values[:, i], color=colour, linewidth=width, label=name)
        axis.set_title(f"line {style.label(found.lines[i].name)}")
        axis.margins(x=0.01)
    axes[0].set_ylim(bottom=min(0.0, -0.03 * axes[0].get_ylim()[1]))  # a slack line's tension, 0 N, is seen
    style.outer_labels(axes, columns, f"time in {unit}", "tension in N")
    style.legend_below(drawn, *axes, columns=2)
    return drawn


def coiling_picture(found: PrintRecord) -> Figure | None:
    """Draw the radius at which cable leaves each winch drum, against the length paid out."""
    known = [i for i, each in enumerate(found.spools) if np.isfinite(each.radii).any()][:_MAX_LINES]
    if not known:
        return None
    drawn, axes, columns = style.panels(len(known), 1.9, spare=1.0, sharey=True)
    for axis, i in zip(axes, known, strict=True):
        each = found.spools[i]
        for name, radii, colour, width, dashes in (
            ("even winding", each.regular, style.INK, 0.9, style.DASHED),
            ("true", each.true_radii, style.GREY, 2.4, "-"),
            ("estimated", each.radii, style.BLUE, 1.1, "-"),
        ):
            axis.plot(each.lengths, 1e3 * radii, color=colour, linewidth=width, linestyle=dashes, label=name)
        uneven = f": irregularity {1e3 * each.irregularity:.2f} mm" if np.isfinite(each.irregularity) else ""
        axis.set_title(style.label(found.lines[i].name) + uneven)
    style.outer_labels(axes, columns, "cable paid out in m", "radius in mm")
    style.legend_below(drawn, *axes, columns=3)
    return drawn


def ringing_picture(found: PrintRecord) -> Figure | None:
    """Draw first frequencies of the lines over time, and their difference from a string's over the temperature."""
    ringing = found.vibration
    if not np.isfinite(ringing.frequencies).any():
        return None
    drawn, (over, warm) = style.subplots(9.6, 3.6, 1, 2, width_ratios=(1.6, 1.0))
    size, unit = style.time_unit(found.duration)
    for line, colour, own, expected in zip(
        found.lines, style.COLOURS, ringing.frequencies.T, ringing.expected.T, strict=False
    ):
        known = np.isfinite(own)
        if not known.any():
            continue
        dots = {"marker": ".", "linestyle": "none", "color": colour, "markersize": 4}
        over.plot(ringing.times / size, expected, color=colour, linewidth=0.8, alpha=0.5)
        over.plot(ringing.times[known] / size, own[known], label=style.label(line.name), **dots)
        warm.plot(ringing.temperatures[known], 1e2 * (own / expected - 1.0)[known], **dots)
    over.set(
        xlabel=f"time in {unit}",
        ylabel="frequency in Hz",
        title="measured; thin: a string with the same tension",
        ylim=(0.0, None),
    )
    warm.set(xlabel="room temperature in °C", ylabel="measured minus expected in %", title="against the temperature")
    style.legend_below(drawn, over, columns=len(style.COLOURS))
    return drawn
