"""Pictures of a simulated motion, a replayed log, and angles as in Merlet and Papegay 2023 (Figs. 5 to 7)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cablewright.apps import style
from cablewright.foundation.arrays import Array
from cablewright.live.compare_loops import LoopComparison
from cablewright.live.error_statistics import SLACK
from cablewright.live.replay import Replay, Replays
from cablewright.live.simulate import Simulation


def simulation_picture(simulated: Simulation) -> Figure:
    """Draw the simulated motion, sampled about once a second."""
    found = simulated.drive
    columns = np.array(found.path).reshape(-1, 6 + len(found.lines)).T
    time, x, y, _, tilt, yaw = columns[:6]
    whole = (slice(None), 0)
    drawn, (place, *panels) = style.grid(9.6, 6.0, (3, 2), whole, (0, 1), (1, 1), (2, 1), width_ratios=(1.0, 1.9))
    above = drawn.add_subplot(place)
    above.plot(x, y, color=style.BLUE)
    above.plot(x[:1], y[:1], "o", color=style.ORANGE, label="start")
    above.set(xlabel="x in m", ylabel="y in m", title="path of the platform, from above")
    above.set_aspect("equal", adjustable="datalim")
    above.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12))
    axes = [drawn.add_subplot(panels[0])]
    axes += [drawn.add_subplot(panel, sharex=axes[0]) for panel in panels[1:]]
    axes[0].plot(time, np.degrees(tilt), color=style.BLUE, linewidth=0.9)
    axes[0].set(ylabel="tilt in degrees", title="platform")
    axes[1].plot(time, np.degrees(yaw), color=style.BLUE)
    axes[1].set_ylabel("yaw in degrees")
    for i, (name, excess) in enumerate(zip(found.lines, columns[6:], strict=True)):
        axes[2].plot(time, 1e3 * excess, linewidth=1.1, label=style.label(name), **style.curve(i))
    axes[2].axhline(1e3 * SLACK, color=style.GREY, linewidth=0.8)
    axes[2].set(xlabel="time in s", ylabel="excess in mm", title="lines: slack above the grey line")
    axes[2].legend(loc="upper center", bbox_to_anchor=(0.5, -0.35), ncols=style.beside(4))
    for each in axes[:2]:
        each.tick_params(labelbottom=False)
    return drawn


def loops_picture(found: LoopComparison) -> Figure:
    """Draw the errors of closed loops over time: a curve for each combination, of all its seeds."""
    drawn, axes = style.axes(8.0, 4.6)
    names = list(dict.fromkeys(run.name for run in found.runs))
    for run in found.runs:
        look = style.curve(names.index(run.name))
        first = run is next(each for each in found.runs if each.name == run.name)
        axes.plot(run.times, 1e3 * run.errors, linewidth=1.2, label=run.name if first else None, **look)
    axes.set(xlabel="time in s", ylabel="distance from the target in mm", ylim=(0.0, None))
    axes.set_title(f"{style.label(found.robot)}: controller, estimator, plant")
    style.legend_below(drawn, axes, columns=3)
    return drawn


_BEFORE_LINES: Final = 7  # columns of a trace before the lines'


def replay_picture(replayed: Replay | Replays) -> Figure:
    """Draw the replays of one log by one estimator or two; lines by the last. Call within `style.drawing`."""
    found = (replayed,) if isinstance(replayed, Replay) else replayed.each
    last = found[-1]
    m = last.head.robot.m
    traces = [np.array(one.trace, dtype=np.float64).reshape(-1, _BEFORE_LINES + 2 * m).T for one in found]
    trace = traces[-1]
    corners = ((0, 0), (0, 1), (1, 0), (1, 1))
    drawn, places = style.grid(9.6, 8.2, (3, 2), *corners, (2, slice(None)))
    axes: list[Axes] = []
    for place in places:
        axes.append(drawn.add_subplot(place, sharex=axes[0] if axes else None))
    names = ["estimated"] if len(found) == 1 else [one.estimator for one in found]
    colours = [style.ORANGE, style.BLUE][-len(found) :]
    for axis, (own, true), name in ((axes[0], (1, 3), "yaw"), (axes[1], (2, 4), "tilt")):
        estimated = {whose: (each[own], colour) for each, colour, whose in zip(traces, colours, names, strict=True)}
        platform_angle(axis, trace[0], name, trace[true], estimated)
    axes[1].set_ylim(bottom=0.0)
    taut, measured = trace[_BEFORE_LINES : _BEFORE_LINES + m], trace[_BEFORE_LINES + m :]
    order = np.argsort(last.slack_steps)
    for axis, line in ((axes[2], int(order[0])), (axes[3], int(order[-1]))):
        share = 1.0 - last.slack_steps[line] / max(last.valid, 1)
        line_angle(axis, trace[0], last.head.robot.lines[line].name, share, measured[line], taut[line])
    _draw_errors(axes[4], found, traces, colours)
    return drawn


def _draw_errors(axis: Axes, found: Sequence[Replay], traces: Sequence[Array], colours: Sequence[str]) -> None:
    """Draw the errors of the position, and the bound below which an estimator expects 95 % of them."""
    axis.set(xlabel="time in s", ylabel="error in mm", title="position error")
    if not any(np.isfinite(trace[5]).any() for trace in traces):
        axis.text(0.5, 0.5, "the log has no true positions", transform=axis.transAxes, ha="center")
        return
    for one, trace, colour in zip(found, traces, colours, strict=True):
        if np.isfinite(trace[6]).any():
            bound: dict[str, Any] = {"color": style.GREY, "alpha": 0.35, "linewidth": 0.0, "label": "95 % bound"}
            axis.fill_between(trace[0], 0.0, 1e3 * trace[6], **bound)
        axis.plot(trace[0], 1e3 * trace[5], color=colour, linewidth=1.0, label=one.estimator)
    axis.set_ylim(0.0, 1.25e3 * max(float(np.nanmax(trace[5], initial=0.0)) for trace in traces))
    axis.legend(loc="upper right", ncols=3)


def platform_angle(axes: Axes, time: Array, name: str, true: Array, estimated: Mapping[str, tuple[Array, str]]) -> None:
    """Draw the true angle, rad, over *time* where it is known, and the *estimated* ones with their colours, by name."""
    if np.isfinite(true).any():
        axes.plot(time, np.degrees(true), color=style.GREY, linewidth=2.4, label="true")
    for label, (values, colour) in estimated.items():
        axes.plot(time, np.degrees(values), color=colour, linewidth=0.9, label=label)
    axes.set(ylabel=f"{name} in degrees", title=f"{name} of the platform")
    axes.legend(loc="upper right", ncols=3)
    axes.margins(x=0.01, y=0.2)


def line_angle(axes: Axes, time: Array, name: str, taut_share: float, measured: Array, taut: Array) -> None:
    """Draw the *measured* angle of a line, rad, over *time*, and the one it would have if it were *taut*."""
    axes.plot(time, np.degrees(measured), color=style.ORANGE, linewidth=0.8, label="measured")
    axes.plot(time, np.degrees(taut), color=style.BLUE, linewidth=1.2, label="of the taut line")
    title = f"line {style.label(name)}: taut {100.0 * taut_share:.0f} % of the time"
    axes.set(ylabel="angle in degrees", title=title)
    axes.legend(loc="upper right", ncols=2)
    axes.margins(x=0.01, y=0.2)
