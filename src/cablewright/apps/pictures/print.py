"""Pictures of a print: error and speed along its path, angles and states over time, from the record's thinned rows."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from cablewright.apps import style
from cablewright.apps.pictures.simulation import platform_angle
from cablewright.foundation.arrays import Array, Indices
from cablewright.foundation.signals import PrintState
from cablewright.live.prints.result import PathFollowing, PrintRecord
from cablewright.running.running_statistics import Histogram

_MAX_LAYERS: Final = 4  # whose errors are drawn over the distance
_CORE: Final = 0.002  # share of the steps that may lie beyond the end of a scale
_COLOURS: Final = {
    PrintState.OFF: style.GREY,
    PrintState.TENSIONING: style.PINK,
    PrintState.HOMING: style.PINK,
    PrintState.MANUAL: style.YELLOW,
    PrintState.IDLE: style.GREY,
    PrintState.READY: style.SKY,
    PrintState.PRINTING: style.GREEN,
    PrintState.PAUSED: style.ORANGE,
    PrintState.REFILLING: style.BLUE,
    PrintState.STOPPED: style.RED,
    PrintState.FAULT: style.INK,
}


def path_picture(found: PrintRecord) -> Figure | None:
    """Draw the path from above, coloured by the platform's sideways error: the true one, and the estimated one."""
    kinds = (
        ("true", found.rows["true_position"][:, :2], 1e3 * found.rows["offset"], found.true.worst),
        ("estimated", found.rows["position"][:, :2], 1e3 * found.rows["estimated_offset"], found.estimated.worst),
    )
    panels = [each for each in kinds if np.isfinite(each[2]).any()]
    if not panels:
        return None
    sizes = np.abs(np.concatenate([values[np.isfinite(values)] for _, _, values, _ in panels]))
    largest = max(float(np.quantile(sizes, 1.0 - _CORE)), 1e-3)
    everywhere = np.concatenate([places[np.isfinite(values)] for _, places, values, _ in panels])
    wide, deep = np.maximum(np.ptp(everywhere, axis=0), 0.1)
    width = 3.9 if len(panels) == 2 else 6.0
    drawn, axes = style.subplots(
        width * len(panels) + 0.9,
        float(np.clip(width * deep / wide, 1.2, 7.0)) + 1.6,
        1,
        len(panels),
        sharex=True,
        sharey=True,
    )
    look = {"cmap": style.signed_colours(), "norm": Normalize(-largest, largest), "linewidths": 2.2}
    for each, (title, places, values, worst) in zip(axes, panels, strict=True):
        joined = np.flatnonzero(np.isfinite(values[1:]) & np.isfinite(values[:-1]))
        joined = joined[np.argsort(np.abs(values[joined + 1]), kind="stable")]  # the largest errors on top
        bundle = style.pieces(each, places[joined], places[joined + 1], values[joined + 1], **look)
        if worst is not None:
            title += style.minus(f"; largest, in the ring: {1e3 * worst.value:+.1f} mm")
            each.plot(*worst.place, zorder=5, **style.RING)
        each.set(title=title, xlabel="x in m", aspect="equal")
        each.margins(0.07)
        each.autoscale_view()
    axes[0].set_ylabel("y in m")
    beyond = "both" if float(sizes.max()) > largest else "neither"
    text = "sideways error in mm, positive to the left of the path"
    style.colour_bar(drawn, list(axes), bundle, text, extend=beyond, location="bottom", shrink=0.6)
    return drawn


def errors_picture(found: PrintRecord) -> Figure | None:
    """Draw the sideways error along some layers, and its statistics of each layer."""
    best = found.best
    printed = np.flatnonzero(np.isfinite(best.by_layer.mean) & (best.by_layer.number > 0))
    if not len(printed):
        return None
    many = len(printed) > 1
    drawn, axes = style.subplots(9.6, 5.6 if many else 3.4, 2 if many else 1, 1)
    _along(axes[0], found, printed)
    if many:
        _by_layer(axes[1], best, printed)
    for each in axes:
        each.axhline(0.0, color=style.GREY, linewidth=0.8)
        each.set_ylabel("sideways error in mm")
        each.legend(loc="upper right", ncols=_MAX_LAYERS)
        each.margins(y=0.25)
    return drawn


def _along(axes: Axes, found: PrintRecord, printed: Indices) -> None:
    begins, distance = found.track.visits.begin, found.rows["distance"]
    chosen = printed[np.unique(np.linspace(0, len(printed) - 1, _MAX_LAYERS).round().astype(int))]
    visit = np.searchsorted(begins, distance, side="right") - 1
    errors = 1e3 * found.rows["offset" if found.has_truth else "estimated_offset"]
    colours = style.error_colours()(np.linspace(0.0, 1.0, len(chosen)))
    for each, colour in zip(chosen, colours, strict=True):
        rows = visit == each
        label = f"layer {found.track.visits.number[each]}"
        axes.plot(distance[rows] - begins[each], errors[rows], color=colour, linewidth=0.9, label=label)
    title = "true error" if found.has_truth else "estimated error"
    axes.set(xlabel="distance along the layer's path in m", title=title)
    axes.margins(x=0.01)


def _by_layer(axes: Axes, best: PathFollowing, printed: Indices) -> None:
    layers = best.by_layer
    number = layers.number[printed].astype(float)
    mean, spread = 1e3 * layers.mean[printed], 1e3 * layers.deviation[printed]
    low, high = 1e3 * layers.min[printed], 1e3 * layers.max[printed]
    blue: dict[str, Any] = {"color": style.BLUE}
    if len(printed) > 12:
        axes.fill_between(number, low, high, alpha=0.15, linewidth=0, label="min to max", **blue)
        axes.fill_between(number, mean - spread, mean + spread, alpha=0.3, linewidth=0, label="one sigma", **blue)
        axes.plot(number, mean, label="mean", **blue)
    else:
        axes.vlines(number, low, high, alpha=0.35, linewidth=3, label="min to max", **blue)
        axes.vlines(number, mean - spread, mean + spread, linewidth=6, label="one sigma", **blue)
        axes.plot(number, mean, "o", color="white", markeredgecolor=style.INK, markersize=5, label="mean")
        axes.set_xticks(number)
        axes.margins(x=0.1)
    axes.set(xlabel="layer", title="each layer")


def speed_picture(found: PrintRecord) -> Figure | None:
    """Draw the speed along the path: its distribution, and over time."""
    kinds = [
        (name, colour, own, found.rows[column])
        for name, colour, own, column in (
            ("estimated", style.ORANGE, found.estimated, "estimated_speed"),
            ("true", style.BLUE, found.true, "speed"),
        )
        if own.speed.count
    ]
    if not kinds:
        return None
    drawn, (often, over) = style.subplots(9.6, 3.4, 1, 2, width_ratios=(1.0, 1.7))
    size, unit = style.time_unit(found.duration)
    for name, colour, own, values in kinds:
        counts = own.speeds.counts
        often.stairs(1e2 * counts / max(1, counts.sum()), 1e3 * own.speeds.edges, color=colour, linewidth=1.3)
        over.plot(found.rows["time"] / size, 1e3 * values, color=colour, linewidth=0.7, label=name)
    nominal = 1e3 * found.print_speed
    for line in (often.axvline, over.axhline):
        line(nominal, color=style.INK, linewidth=0.8, linestyle=style.DASHED)
    low, high = _reach(kinds[-1][2].speeds)
    often.set(
        xlim=(1e3 * low, 1e3 * high),
        xlabel="speed along the path in mm/s",
        ylabel="share of the steps in %",
        title="distribution; dashed: print speed",
    )
    over.set(xlabel=f"time in {unit}", ylabel="speed along the path in mm/s", title="while printing")
    over.legend(loc="lower right", ncols=2)
    over.set_ylim(0.0, max(1.3 * nominal, 1.1e3 * high))
    return drawn


def _reach(histogram: Histogram) -> tuple[float, float]:
    """Return the ends of an axis that shows all but a few of the values."""
    below = np.cumsum(histogram.counts) / max(1, int(histogram.counts.sum()))
    first, last = np.searchsorted(below, [_CORE, 1.0 - _CORE])
    last = min(int(last) + 1, len(histogram.counts))
    margin = 0.1 * (histogram.edges[last] - histogram.edges[first])
    return float(histogram.edges[first] - margin), float(histogram.edges[last] + margin)


def drum_picture(found: PrintRecord) -> Figure | None:
    """Draw yaw and tilt of the platform over time: Figs. 5 and 6 of Merlet and Papegay 2023."""
    true, estimated = found.rows["true_rotation"], found.rows["rotation"]
    if not np.isfinite(estimated).any():
        return None
    drawn, axes = style.subplots(9.6, 4.8, 2, 1, sharex=True)
    size, unit = style.time_unit(found.duration)
    time = found.rows["time"] / size
    platform_angle(axes[0], time, "yaw", true[:, 2], {"estimated": (estimated[:, 2], style.BLUE)})
    tilts = np.hypot(*true[:, :2].T), np.hypot(*estimated[:, :2].T)
    platform_angle(axes[1], time, "tilt", tilts[0], {"estimated": (tilts[1], style.BLUE)})
    axes[1].set(xlabel=f"time in {unit}", ylim=(0.0, None))
    return drawn


def states_picture(found: PrintRecord) -> Figure | None:
    """Draw the state of the print and its progress over time."""
    if not found.spans:
        return None
    states = [state for state in reversed(PrintState) if any(span.state is state for span in found.spans)]
    size, unit = style.time_unit(found.duration)
    drawn, (axes, progress) = style.subplots(
        9.6, 2.4 + 0.3 * len(states), 2, 1, sharex=True, height_ratios=(0.3 * len(states) + 0.3, 1.6)
    )
    shortest = found.duration / size / 800.0  # anything shorter would not be seen
    for row, state in enumerate(states):
        bars = [(s.begin / size, max((s.end - s.begin) / size, shortest)) for s in found.spans if s.state is state]
        axes.broken_barh(bars, (row - 0.38, 0.76), color=_COLOURS[state])
    axes.set_yticks(range(len(states)), [str(state) for state in states])
    axes.grid(visible=False, axis="y")
    axes.set_title("state")
    progress.plot(found.rows["time"] / size, found.rows["distance"], color=style.BLUE)
    progress.set(xlabel=f"time in {unit}", ylabel="distance in m", title="distance along the path")
    progress.margins(x=0.01)
    return drawn


def steps_picture(times: Array) -> Figure:
    """Draw the distribution of the computing times of the control steps, *times* (k,), s."""
    drawn, axes = style.axes(9.6, 3.0)
    known = 1e3 * times[np.isfinite(times) & (times > 0.0)]
    edges = np.geomspace(max(1e-3, known.min()), 1.001 * known.max(), 80)
    axes.stairs(*np.histogram(known, edges), color=style.BLUE, fill=True)
    half, p99 = np.percentile(known, (50.0, 99.0)).tolist()
    for at in (half, p99):
        axes.axvline(at, color=style.INK, linewidth=0.9, linestyle=style.DASHED)
    title = f"computing time of a step: median {half:.2g} ms, 99th percentile {p99:.2g} ms"
    axes.set(xscale="log", yscale="log", xlabel="time in ms", ylabel="number of steps", title=title)
    style.log_ticks(axes.xaxis, *axes.get_xlim())
    style.log_ticks(axes.yaxis, *axes.get_ylim())
    return drawn
