"""Pictures of a trajectory of the platform, and of tensions, speeds and powers along it."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from cablewright.analyses.motion.inverse_dynamics import InverseDynamics
from cablewright.analyses.motion.trajectory import Trajectory
from cablewright.apps import style
from cablewright.apps.space_axes import bounds, space
from cablewright.foundation.data_frames import COORDINATES


def trajectory_picture(found: Trajectory) -> Figure:
    """Draw the path in space, and coordinates, speeds and accelerations over time."""
    whole = (slice(None), 0)
    drawn, (place, *panels) = style.grid(9.6, 6.0, (3, 2), whole, (0, 1), (1, 1), (2, 1), width_ratios=(1.1, 1.6))
    low, high = bounds(found.poses[:, :3])
    around = 0.05 * max(float((high - low).max()), 1e-3)
    path, _ = space(drawn, place, low - around, high + around, "m")
    path.plot(*found.poses[:, :3].T, color=style.BLUE)
    path.plot(*found.poses[:1, :3].T, "o", color=style.ORANGE, label="start")
    size, unit = style.time_unit(found.duration)
    rows = (
        (found.poses, "position in m"),
        (found.velocities, "speed in m/s"),
        (found.accelerations, "acceleration in m/s²"),
    )
    for row, (values, label) in enumerate(rows):
        axes = drawn.add_subplot(panels[row], sharex=drawn.axes[1] if row else None)
        for k in range(3):
            axes.plot(found.times / size, values[:, k], linewidth=1.1, label=COORDINATES[k], **style.curve(k))
        if values[:, 3:].any():
            turn = axes.twinx()
            for k in (3, 4, 5):
                turn.plot(found.times / size, values[:, k], linewidth=0.9, label=COORDINATES[k], **style.curve(k))
            turn.set_ylabel(("rad", "rad/s", "rad/s²")[row])
            turn.grid(visible=False)
        axes.set_ylabel(label)
        axes.tick_params(labelbottom=row == 2)
    axes.set_xlabel(f"time in {unit}")
    style.legend_below(drawn, *drawn.axes, columns=7)
    return drawn


def dynamics_picture(found: InverseDynamics) -> Figure:
    """Draw tensions, speeds of cables and powers over time; times without tensions within the limits are grey."""
    size, unit = style.time_unit(found.trajectory.duration)
    time = found.trajectory.times / size
    drawn, panels = style.subplots(9.6, 7.0, 3, 1, sharex=True)
    rows = (
        (found.tensions, "tension in N"),
        (found.length_rates, "speed of the cable in m/s"),
        (found.power, "power in W"),
    )
    for axes, (values, label) in zip(panels, rows, strict=True):
        for i, name in enumerate(found.lines):
            axes.plot(time, values[:, i], linewidth=1.1, label=style.label(name), **style.curve(i))
        axes.set_ylabel(label)
        axes.fill_between(time, 0, 1, where=~np.asarray(found.held.ok), transform=axes.get_xaxis_transform(),
                          color=style.GREY, alpha=0.25, linewidth=0.0)  # fmt: skip
    panels[-1].set_xlabel(f"time in {unit}")
    panels[0].set_title(f"{style.label(found.robot)}: {style.label(found.trajectory.source)}")
    style.legend_below(drawn, panels[0], columns=min(len(found.lines), 8))
    return drawn
