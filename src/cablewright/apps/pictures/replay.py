"""A replayed log: yaw, tilt, angles of two lines (Merlet and Papegay 2023, Figs. 5 to 7), and position errors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cablewright.apps import style
from cablewright.apps.over_time import line_angle, platform_angle
from cablewright.arrays import Array
from cablewright.studies.replay import Replay, Replays

_BEFORE_LINES: Final = 7  # columns of a trace before the lines'


def replay_picture(replayed: Replay | Replays) -> Figure:
    """Draw the replays of one log by one estimator or two; lines by the last. Call within `style.drawing`."""
    found = (replayed,) if isinstance(replayed, Replay) else replayed.each
    last = found[-1]
    m = last.head.robot.m
    traces = [np.array(one.trace, dtype=np.float64).reshape(-1, _BEFORE_LINES + 2 * m).T for one in found]
    trace = traces[-1]
    drawn = style.figure(9.6, 8.2)
    grid = drawn.add_gridspec(3, 2)
    axes: list[Axes] = []
    for place in (grid[0, 0], grid[0, 1], grid[1, 0], grid[1, 1], grid[2, :]):
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
