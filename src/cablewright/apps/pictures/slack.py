"""Pictures of slack lines: the platform while a line is let out, and inclinometer readings of a slack line."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cablewright.apps import style
from cablewright.foundation.arrays import Array
from cablewright.models.statics import Equilibrium
from cablewright.solvers.slack import excess_lengths


def let_out_picture(found: Equilibrium, by: Array, name: str) -> Figure:
    """Draw the platform's motion and the tensions while line *name* is let out *by* (N,), m, rising.

    *found* is the batch that `let_out` returns. Motion is measured from the position where *by* is nearest to 0; where
    a line is longer than its taut length the picture is shaded and names it.
    """
    drawn, (motion, tension) = style.subplots(8.0, 6.2, 2, 1, sharex=True, height_ratios=(1, 1.25))
    start = int(np.argmin(np.abs(by)))
    moved = 1e3 * (found.pose[:, :3] - found.pose[start, :3])
    for i, axis in enumerate("xyz"):
        motion.plot(1e3 * by, moved[:, i], label=axis, **style.curve(i))
    motion.set_ylabel("motion of the platform in mm")
    for i, line in enumerate(found.model.robot.lines):
        tension.plot(1e3 * by, found.tensions[:, i], label=style.label(line.name), **style.curve(i))
    tension.set(
        ylabel="tension at the sheave in N",
        xlabel=f"length by which {style.label(name)} is let out in mm",
        ylim=(0.0, None),
    )
    _shade(found, 1e3 * by, (motion, tension))
    for axes in (motion, tension):
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        axes.set_xlim(1e3 * by[0], 1e3 * by[-1])
    return drawn


def _shade(found: Equilibrium, x: Array, both: tuple[Axes, Axes]) -> None:
    """Shade where a line is slack, and name it above the upper picture."""
    excess = excess_lengths(found)
    for i, line in enumerate(found.model.robot.lines):
        slack = np.flatnonzero(excess[:, i] > 0.0)
        if len(slack) == 0:
            continue
        for axes in both:
            axes.axvspan(x[slack[0]], x[slack[-1]], color=style.GREY, alpha=0.14, linewidth=0)
        at = 0.5 * (x[slack[0]] + x[slack[-1]])
        above = both[0].get_xaxis_transform()
        both[0].text(at, 1.02, f"{style.label(line.name)} slack", transform=above, ha="center", fontsize=8.5)


def angle_over_excess(
    excess: Array, angles: Mapping[str, Array], said: tuple[float, float, str] | None = None
) -> Figure:
    """Draw the angle between a slack line's tangent and the taut line, over its *excess* (N,), m.

    *angles* (N,), rad, by the name of their curve; *said* is the excess and angle of one more point, and its name.
    """
    drawn, axes = style.axes(6.4, 4.2)
    for i, (name, angle) in enumerate(angles.items()):
        axes.plot(1e2 * excess, np.degrees(angle), label=style.label(name), **style.curve(i))
    if said is not None:
        axes.plot(1e2 * said[0], np.degrees(said[1]), "x", color=style.INK, markersize=9, label=style.label(said[2]))
    axes.set(
        xlabel="excess in cm",
        ylabel="angle from the taut line in degrees",
        xlim=(0.0, 1e2 * float(excess[-1])),
        ylim=(0.0, None),
    )
    axes.legend(loc="lower right")
    return drawn
