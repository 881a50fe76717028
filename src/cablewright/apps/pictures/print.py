"""How a print went: beside its path, along it, in time. Each picture is of a record's thinned rows."""

from __future__ import annotations

from functools import cache
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Colormap, LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from cablewright.apps import style
from cablewright.arrays import Array
from cablewright.signals import PrintState
from cablewright.studies.prints.result import PathFollowing, PrintRecord
from cablewright.studies.running_statistics import Histogram

_MAX_LAYERS: Final = 4  # whose errors are drawn place by place
_CORE: Final = 0.002  # of the steps at each end may be beyond a colour scale
_COLOURS: Final = {
    PrintState.IDLE: style.GREY,
    PrintState.READY: "#56b4e9",
    PrintState.PRINTING: style.GREEN,
    PrintState.PAUSED: style.ORANGE,
    PrintState.REFILLING: style.BLUE,
    PrintState.STOPPED: style.RED,
    PrintState.FAULT: style.INK,
}


def clock(seconds: float) -> tuple[float, str]:
    """The size in seconds and the name of the unit in which *seconds* are told on an axis."""
    for size, name in ((3600.0, "h"), (60.0, "min")):
        if seconds >= 3.0 * size:
            return size, name
    return 1.0, "s"


def path_picture(found: PrintRecord) -> Figure | None:
    """The path from above, coloured by how far beside it the platform was: truly, and as it was believed."""
    panels = [
        (title, place, found.rows[column])
        for title, place, column in (
            ("true", "true_position", "offset"),
            ("estimated", "position", "estimated_offset"),
        )
        if np.isfinite(found.rows[column]).any()
    ]
    if not panels:
        return None
    everything = 1e3 * np.concatenate([values[np.isfinite(values)] for _, _, values in panels])
    largest = max(float(np.quantile(np.abs(everything), 1.0 - _CORE)), 1e-3)
    low, high = found.track.positions[:, :2].min(axis=0), found.track.positions[:, :2].max(axis=0)
    wide, deep = np.maximum(high - low, 0.1)
    width = 3.9
    drawn = style.figure(width * len(panels) + 0.9, float(np.clip(width * deep / wide, 2.6, 7.0)) + 0.8)
    axes = drawn.subplots(1, len(panels), sharex=True, sharey=True, squeeze=False).ravel()
    bundle = None
    for each, (title, place, values) in zip(axes, panels, strict=True):
        bundle = _coloured(each, found.rows[place][:, :2], 1e3 * values, largest)
        worst = found.true.worst if place == "true_position" else found.estimated.worst
        if worst is not None:
            largest_error = f"{1e3 * worst.value:+.1f}".replace("-", "\N{MINUS SIGN}")
            title += f"; largest, in the ring: {largest_error} mm"
            each.plot(*worst.place, "o", markersize=11, markerfacecolor="none", markeredgecolor=style.INK, zorder=5)
        each.set(title=title, xlabel="x in m", aspect="equal")
        each.margins(0.07)
        each.autoscale_view()
    axes[0].set_ylabel("y in m")
    assert bundle is not None
    beyond = "both" if float(np.abs(everything).max()) > largest else "neither"
    bar = drawn.colorbar(bundle, ax=list(axes), extend=beyond, shrink=0.7, aspect=30, pad=0.02)
    bar.set_label("beside the path in mm, left of it positive")
    bar.outline.set_visible(False)
    return drawn


def _coloured(axes: Axes, places: Array, values: Array, largest: float) -> LineCollection:
    """Pieces between rows that follow each other, the largest errors on top."""
    joined = np.flatnonzero(np.isfinite(values[1:]) & np.isfinite(values[:-1]))
    joined = joined[np.argsort(np.abs(values[joined + 1]), kind="stable")]
    bundle = LineCollection(
        np.stack([places[joined], places[joined + 1]], axis=1),  # type: ignore[arg-type]  # (p, 2, 2) is one
        array=values[joined + 1],
        cmap=_signed_colours(),
        norm=Normalize(-largest, largest),
        linewidths=2.2,
        capstyle="round",
    )
    axes.add_collection(bundle)
    return bundle


@cache
def _signed_colours() -> Colormap:
    """From blue over a pale grey that still is seen on white to orange."""
    return LinearSegmentedColormap.from_list("signed", [style.BLUE, "#c3cad2", style.RED])


def errors_picture(found: PrintRecord) -> Figure | None:
    """How far beside the path, along some layers, and of each layer."""
    best, column = found.best, "offset" if found.has_truth else "estimated_offset"
    printed = np.flatnonzero(np.isfinite(best.by_layer.mean) & (best.by_layer.number >= 0))
    if not len(printed):
        return None
    many = len(printed) > 1
    drawn = style.figure(9.6, 5.6 if many else 3.4)
    axes = drawn.subplots(2 if many else 1, 1, squeeze=False).ravel()
    _along(axes[0], found, column, printed)
    if many:
        _by_layer(axes[1], best, printed)
    return drawn


def _along(axes: Axes, found: PrintRecord, column: str, printed: NDArray[np.int64]) -> None:
    begins = found.track.visits.begin
    chosen = printed[np.unique(np.linspace(0, len(printed) - 1, _MAX_LAYERS).round().astype(int))]
    visit = np.searchsorted(begins, found.rows["distance"], side="right") - 1
    colours = style.error_colours()(np.linspace(0.0, 1.0, len(chosen)))
    for each, colour in zip(chosen, colours, strict=True):
        rows = visit == each
        label = f"layer {found.track.visits.number[each] + 1}"
        along = found.rows["distance"][rows] - begins[each]
        axes.plot(along, 1e3 * found.rows[column][rows], color=colour, linewidth=0.9, label=label)
    axes.axhline(0.0, color=style.GREY, linewidth=0.8)
    axes.set(xlabel="m along the layer's path", ylabel="beside the path in mm", title=_whose(found))
    axes.legend(loc="upper right", ncols=_MAX_LAYERS)
    axes.margins(x=0.01, y=0.2)


def _by_layer(axes: Axes, best: PathFollowing, printed: NDArray[np.int64]) -> None:
    layers = best.by_layer
    number = layers.number[printed] + 1.0
    mean, spread = 1e3 * layers.mean[printed], 1e3 * layers.deviation[printed]
    low, high = 1e3 * layers.min[printed], 1e3 * layers.max[printed]
    if len(printed) > 12:
        axes.fill_between(number, low, high, color=style.BLUE, alpha=0.15, linewidth=0, label="least to most")
        axes.fill_between(
            number, mean - spread, mean + spread, color=style.BLUE, alpha=0.3, linewidth=0, label="one sigma"
        )
        axes.plot(number, mean, color=style.BLUE, label="mean")
    else:
        axes.vlines(number, low, high, color=style.BLUE, alpha=0.35, linewidth=3, label="least to most")
        axes.vlines(number, mean - spread, mean + spread, color=style.BLUE, linewidth=6, label="one sigma")
        axes.plot(number, mean, "o", color="white", markeredgecolor=style.INK, markersize=5, label="mean")
        axes.set_xticks(number)
        axes.margins(x=0.1)
    axes.axhline(0.0, color=style.GREY, linewidth=0.8)
    axes.set(xlabel="layer", ylabel="beside the path in mm", title="each layer")
    axes.legend(loc="upper right", ncols=3)
    axes.margins(y=0.25)


def _whose(found: PrintRecord) -> str:
    return "true error" if found.has_truth else "error as the estimation saw it"


def speed_picture(found: PrintRecord) -> Figure | None:
    """Speed along the path: how often which, and over time."""
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
    drawn = style.figure(9.6, 3.4)
    often, over = drawn.subplots(1, 2, width_ratios=(1.0, 1.7))
    size, unit = clock(found.duration)
    for name, colour, own, values in kinds:
        often.stairs(_share(own.speeds), 1e2 * own.speeds.edges, color=colour, linewidth=1.3, label=name)
        over.plot(found.rows["time"] / size, 1e2 * values, color=colour, linewidth=0.7, label=name)
    middle = 1e2 * found.print_speed
    for axis in (often.axvline, over.axhline):
        axis(middle, color=style.INK, linewidth=0.8, linestyle=(0, (4, 2)))
    near = _reach(kinds[-1][2].speeds)
    often.set(xlim=(1e2 * near[0], 1e2 * near[1]), xlabel="cm/s along the path", ylabel="share of the steps in %")
    often.set_title("how often which speed")
    over.set(xlabel=f"time in {unit}", ylabel="cm/s along the path", title="over time, while printing")
    over.legend(loc="lower right", ncols=2)
    over.set_ylim(0.0, max(1.3 * middle, 1.1e2 * near[1]))
    return drawn


def _share(histogram: Histogram) -> Array:
    return np.asarray(1e2 * histogram.counts / max(1, int(histogram.counts.sum())))


def _reach(histogram: Histogram) -> tuple[float, float]:
    """Between which edges as good as all is."""
    gone = np.cumsum(histogram.counts) / max(1, int(histogram.counts.sum()))
    first, last = np.searchsorted(gone, [_CORE, 1.0 - _CORE])
    last = min(int(last) + 1, len(histogram.counts))
    margin = 0.1 * (histogram.edges[last] - histogram.edges[first])
    return float(histogram.edges[first] - margin), float(histogram.edges[last] + margin)


def drum_picture(found: PrintRecord) -> Figure | None:
    """Yaw and tilt of the drum over time: Figs. 5 and 6 of Merlet and Papegay 2023."""
    rows = found.rows
    if not np.isfinite(rows["rotation"]).any():
        return None
    drawn = style.figure(9.6, 4.8)
    axes = drawn.subplots(2, 1, sharex=True)
    size, unit = clock(found.duration)
    for axis, name, turned in ((axes[0], "yaw", _yaw), (axes[1], "tilt", _tilt)):
        true = np.degrees(turned(rows["true_rotation"]))
        if np.isfinite(true).any():
            axis.plot(rows["time"] / size, true, color=style.GREY, linewidth=2.2, label="true")
        seen = np.degrees(turned(rows["rotation"]))
        axis.plot(rows["time"] / size, seen, color=style.BLUE, linewidth=0.8, label="estimated")
        axis.set(ylabel=f"{name} in degrees")
        axis.legend(loc="upper right", ncols=2)
        axis.margins(x=0.01, y=0.2)
    axes[0].set_title("turn of the drum about the vertical")
    axes[1].set(xlabel=f"time in {unit}", title="angle between its axis and the vertical")
    axes[1].set_ylim(bottom=0.0)
    return drawn


def _yaw(rotation: Array) -> Array:
    return rotation[:, 2]


def _tilt(rotation: Array) -> Array:
    return np.asarray(np.hypot(rotation[:, 0], rotation[:, 1]))


def states_picture(found: PrintRecord) -> Figure | None:
    """What the print was doing when, and how far it was."""
    if not found.spans:
        return None
    states = [state for state in PrintState if any(span.state is state for span in found.spans)]
    size, unit = clock(found.duration)
    drawn = style.figure(9.6, 2.4 + 0.3 * len(states))
    axes, way = drawn.subplots(2, 1, sharex=True, height_ratios=(0.3 * len(states) + 0.3, 1.6))
    shortest = found.duration / size / 800.0  # what is shorter would not be seen
    for row, state in enumerate(reversed(states)):
        bars = [(s.begin / size, max((s.end - s.begin) / size, shortest)) for s in found.spans if s.state is state]
        axes.broken_barh(bars, (row - 0.38, 0.76), color=_COLOURS[state])
    axes.set_yticks(range(len(states)), [str(state) for state in reversed(states)])
    axes.grid(visible=False, axis="y")
    axes.set_title("what it was doing")
    way.plot(found.rows["time"] / size, found.rows["distance"], color=style.BLUE)
    way.set(xlabel=f"time in {unit}", ylabel="m of path", title="how far it was")
    way.margins(x=0.01)
    return drawn


def steps_picture(times: Array) -> Figure:
    """How long the steps of control took, *times* (k,), s."""
    drawn = style.figure(9.6, 3.0)
    axes = drawn.add_subplot()
    told = 1e3 * times[np.isfinite(times) & (times > 0.0)]
    edges = np.geomspace(max(1e-3, told.min()), 1.001 * told.max(), 80)
    axes.stairs(*np.histogram(told, edges), color=style.BLUE, fill=True)
    half, p99 = np.percentile(told, (50.0, 99.0)).tolist()
    for at in (half, p99):
        axes.axvline(at, color=style.INK, linewidth=0.9, linestyle=(0, (4, 2)))
    title = f"how long a step took: half of them up to {half:.2g} ms, 99 of 100 up to {p99:.2g} ms"
    axes.set(xscale="log", yscale="log", xlabel="ms", ylabel="steps", title=title)
    axes.yaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_major_formatter("{x:g}")
    return drawn
