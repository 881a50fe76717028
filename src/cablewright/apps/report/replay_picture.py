"""A replay as Merlet and Papegay 2023 draw theirs: yaw (Fig. 5), tilt (Fig. 6), angles of two lines (Fig. 7)."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from cablewright.apps.report import style
from cablewright.studies.replay import Replay

__all__ = ["replay_picture"]

_BEFORE_LINES: Final = 6  # columns of a trace before the lines'


def replay_picture(found: Replay) -> Figure:
    """Draw *found*. Call within `style.drawing`."""
    m = found.head.robot.m
    trace = np.array(found.trace, dtype=np.float64).reshape(-1, _BEFORE_LINES + 2 * m).T
    time = trace[0]
    drawn = style.figure(9.6, 8.2)
    grid = drawn.add_gridspec(3, 2)
    axes: list[Axes] = []
    for place in (grid[0, 0], grid[0, 1], grid[1, 0], grid[1, 1], grid[2, :]):
        axes.append(drawn.add_subplot(place, sharex=axes[0] if axes else None))
    for axis, (own, true), name in ((axes[0], (1, 3), "yaw"), (axes[1], (2, 4), "tilt")):
        if np.isfinite(trace[true]).any():
            axis.plot(time, np.degrees(trace[true]), color=style.GREY, linewidth=2.4, label="true")
        axis.plot(time, np.degrees(trace[own]), color=style.BLUE, linewidth=1.0, label="estimated")
        axis.set(ylabel=f"{name} in degrees", title=f"{name} of the drum")
        axis.legend(loc="upper right", ncols=2)
        axis.margins(y=0.18)
    axes[1].set_ylim(bottom=0.0)
    taut, measured = trace[_BEFORE_LINES : _BEFORE_LINES + m], trace[_BEFORE_LINES + m :]
    order = np.argsort(found.slack_steps)
    for axis, line in ((axes[2], int(order[0])), (axes[3], int(order[-1]))):
        _draw_line(axis, found, line, time, taut[line], measured[line])
    axes[4].set(xlabel="time in s", ylabel="error in mm", title="position: how far from the true one")
    if np.isfinite(trace[5]).any():
        axes[4].plot(time, 1e3 * trace[5], color=style.BLUE, linewidth=1.0)
        axes[4].set_ylim(bottom=0.0)
    else:
        axes[4].text(0.5, 0.5, "the log does not have the truth", transform=axes[4].transAxes, ha="center")
    return drawn


def _draw_line(
    axis: Axes,
    found: Replay,
    line: int,
    time: NDArray[np.float64],
    taut: NDArray[np.float64],
    told: NDArray[np.float64],
) -> None:
    """Angles of one line, and how long it was taut."""
    share = 100.0 * (1.0 - found.slack_steps[line] / max(found.valid, 1))
    axis.plot(time, np.degrees(told), color=style.ORANGE, linewidth=0.9, label="measured")
    axis.plot(time, np.degrees(taut), color=style.BLUE, linewidth=1.2, label="if it were taut")
    name = style.label(found.head.robot.lines[line].name)
    axis.set(ylabel="angle in degrees", title=f"line {name}: taut {share:.0f} % of the time")
    axis.legend(loc="upper right", ncols=2)
    axis.margins(y=0.2)
