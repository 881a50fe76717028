"""Angles over time, as Merlet and Papegay 2023 draw them: of the platform (Figs. 5 and 6) and of a line (Fig. 7)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes

from cablewright.apps import style
from cablewright.arrays import Array


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
