"""A simulated drive: the platform's path from above, and its tilt, yaw and the excess of each line over time."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from cablewright.apps import style
from cablewright.studies.error_statistics import SLACK
from cablewright.studies.simulate import Simulation


def simulation_picture(simulated: Simulation) -> Figure:
    """Draw the drive, sampled about once a second."""
    found = simulated.drive
    columns = np.array(found.path).reshape(-1, 6 + len(found.lines)).T
    time, x, y, _, tilt, yaw = columns[:6]
    drawn = style.figure(9.6, 6.0)
    grid = drawn.add_gridspec(3, 2, width_ratios=(1.0, 1.9))
    above = drawn.add_subplot(grid[:, 0])
    above.plot(x, y, color=style.BLUE)
    above.plot(x[:1], y[:1], "o", color=style.ORANGE, label="start")
    above.set(xlabel="x in m", ylabel="y in m", title="path of the platform, from above")
    above.set_aspect("equal", adjustable="datalim")
    above.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12))
    axes = [drawn.add_subplot(grid[0, 1])]
    axes += [drawn.add_subplot(grid[row, 1], sharex=axes[0]) for row in (1, 2)]
    axes[0].plot(time, np.degrees(tilt), color=style.BLUE, linewidth=0.9)
    axes[0].set(ylabel="tilt in degrees", title="platform")
    axes[1].plot(time, np.degrees(yaw), color=style.BLUE)
    axes[1].set_ylabel("yaw in degrees")
    for i, (name, excess) in enumerate(zip(found.lines, columns[6:], strict=True)):
        axes[2].plot(time, 1e3 * excess, linewidth=1.1, label=style.label(name), **style.curve(i))
    axes[2].axhline(1e3 * SLACK, color=style.GREY, linewidth=0.8)
    axes[2].set(xlabel="time in s", ylabel="excess in mm", title="lines: slack above the grey line")
    axes[2].legend(loc="upper center", bbox_to_anchor=(0.5, -0.35), ncols=4)
    for each in axes[:2]:
        each.tick_params(labelbottom=False)
    return drawn
