"""Slack in two pictures: what a machine does while a line is let out, and what an inclinometer sees of a slack one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cablewright.apps import style
from cablewright.arrays import Array
from cablewright.models.statics import Equilibrium
from cablewright.solvers.slack import excess_lengths

_COLOURS: Final = (style.BLUE, style.ORANGE, style.GREEN, style.RED, style.INK, style.GREY)
_DASHES: Final[tuple[Any, ...]] = ("-", (0, (5, 1.5)), "-.", (0, (1, 1.2)))


def let_out_picture(found: Equilibrium, by: Array, name: str) -> Figure:
    """Draw where the platform goes and what its lines carry while line *name* is let out *by* (N,), m, rising.

    *found* is the batch that `let_out` gives. Motions are counted from where *by* is nearest to 0; where a line is
    longer than its taut length the picture is shaded and names it. Call within `style.drawing`.
    """
    drawn = style.figure(8.0, 6.2)
    motion, tension = drawn.subplots(2, 1, sharex=True, height_ratios=(1, 1.25))
    start = int(np.argmin(np.abs(by)))
    moved = 1e3 * (found.pose[:, :3] - found.pose[start, :3])
    for axis, values, colour, dash in zip("xyz", moved.T, _COLOURS, _DASHES, strict=False):
        motion.plot(1e3 * by, values, color=colour, linestyle=dash, label=axis)
    motion.set_ylabel("motion of the platform in mm")
    for i, line in enumerate(found.model.robot.lines):
        colour, dash = _COLOURS[i % len(_COLOURS)], _DASHES[i % len(_DASHES)]
        tension.plot(1e3 * by, found.tensions[:, i], color=colour, linestyle=dash, label=style.label(line.name))
    tension.set(ylabel="tension at the sheave in N", xlabel=f"{style.label(name)} let out by, in mm")
    tension.set_ylim(bottom=0.0)
    _shade(found, 1e3 * by, (motion, tension))
    for axes in (motion, tension):
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        axes.set_xlim(1e3 * by[0], 1e3 * by[-1])
    return drawn


def _shade(found: Equilibrium, x: Array, both: tuple[Axes, Axes]) -> None:
    """Shade where a line is slack, and say which in the upper picture."""
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
    """Draw how far a slack line's tangent has turned from the taut line's, over its *excess* (N,), m.

    *angles* (N,), rad, by the name of their curve; *said* is one more point, with its name. Call within
    `style.drawing`.
    """
    drawn = style.figure(6.4, 4.2)
    axes = drawn.subplots()
    for (name, turned), colour, dash in zip(angles.items(), _COLOURS * 4, _DASHES * 6, strict=False):
        axes.plot(1e2 * excess, np.degrees(turned), color=colour, linestyle=dash, label=style.label(name))
    if said is not None:
        axes.plot(1e2 * said[0], np.degrees(said[1]), "x", color=style.INK, markersize=9, label=style.label(said[2]))
    axes.set(xlabel="excess in cm", ylabel="turned from the taut line in degrees")
    axes.set_xlim(0.0, 1e2 * float(excess[-1]))
    axes.set_ylim(bottom=0.0)
    axes.legend(loc="lower right")
    return drawn
