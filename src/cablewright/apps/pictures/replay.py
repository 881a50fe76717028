"""A replay as Merlet and Papegay 2023 draw theirs: yaw (Fig. 5), tilt (Fig. 6), angles of two lines (Fig. 7)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cablewright.apps import style
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
    for axis, (own, true), name in ((axes[0], (1, 3), "yaw"), (axes[1], (2, 4), "tilt")):
        if np.isfinite(trace[true]).any():
            axis.plot(trace[0], np.degrees(trace[true]), color=style.GREY, linewidth=2.4, label="true")
        for each, colour, whose in zip(traces, _colours(found), names, strict=True):
            axis.plot(each[0], np.degrees(each[own]), color=colour, linewidth=1.0, label=whose)
        axis.set(ylabel=f"{name} in degrees", title=f"{name} of the drum")
        axis.legend(loc="upper right", ncols=3)
        axis.margins(y=0.18)
    axes[1].set_ylim(bottom=0.0)
    taut, measured = trace[_BEFORE_LINES : _BEFORE_LINES + m], trace[_BEFORE_LINES + m :]
    order = np.argsort(last.slack_steps)
    for axis, line in ((axes[2], int(order[0])), (axes[3], int(order[-1]))):
        _draw_line(axis, last, line, trace[0], taut[line], measured[line])
    _draw_errors(axes[4], found, traces)
    return drawn


def _colours(found: Sequence[Replay]) -> list[str]:
    """Blue is the last, orange one before it."""
    return [style.ORANGE, style.BLUE][-len(found) :]


def _draw_errors(axis: Axes, found: Sequence[Replay], traces: Sequence[Array]) -> None:
    """How far the position was off, and under what it should be in 95 of 100 steps."""
    axis.set(xlabel="time in s", ylabel="error in mm", title="position: how far from the true one")
    if not any(np.isfinite(trace[5]).any() for trace in traces):
        axis.text(0.5, 0.5, "the log does not have the truth", transform=axis.transAxes, ha="center")
        return
    labelled = len(found) > 1
    for one, trace, colour in zip(found, traces, _colours(found), strict=True):
        if np.isfinite(trace[6]).any():
            axis.fill_between(
                trace[0], 0.0, 1e3 * trace[6], color=style.GREY, alpha=0.35, linewidth=0.0, label="95 % bound"
            )
            labelled = True
        axis.plot(trace[0], 1e3 * trace[5], color=colour, linewidth=1.0, label=one.estimator)
    errors = np.concatenate([trace[5] for trace in traces])
    axis.set_ylim(0.0, 1.25e3 * float(np.nanmax(errors)))
    if labelled:
        axis.legend(loc="upper right", ncols=3)


def _draw_line(
    axis: Axes,
    found: Replay,
    line: int,
    time: Array,
    taut: Array,
    told: Array,
) -> None:
    """Angles of one line, and how long it was taut."""
    share = 100.0 * (1.0 - found.slack_steps[line] / max(found.valid, 1))
    axis.plot(time, np.degrees(told), color=style.ORANGE, linewidth=0.9, label="measured")
    axis.plot(time, np.degrees(taut), color=style.BLUE, linewidth=1.2, label="if it were taut")
    name = style.label(found.head.robot.lines[line].name)
    axis.set(ylabel="angle in degrees", title=f"line {name}: taut {share:.0f} % of the time")
    axis.legend(loc="upper right", ncols=2)
    axis.margins(y=0.2)
