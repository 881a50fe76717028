"""A creep test: creep and residuals over time, and the creep per load that follows, with its uncertainty."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cablewright.apps import style
from cablewright.calibration.tensile.creep import CreepResult

_MAX_POINTS: Final = 20_000  # of a curve: the picture cannot show more
_FROM: Final = 1.0  # s: what is earlier is stretch rather than creep
_BAND: Final = 2.0  # sigmas
_TICKS: Final = {
    "1 s": 1.0, "10 s": 10.0, "1 min": 60.0, "10 min": 600.0, "1 h": 3600.0, "10 h": 36e3, "4 d": 345.6e3,
    "40 d": 3.456e6,
}  # fmt: skip


def creep_picture(result: CreepResult) -> Figure:
    """Draw the strain besides the elastic one by time, and the creep per load."""
    drawn = style.figure(9.0, 4.2)
    history, law = drawn.subplots(1, 2, width_ratios=(1.25, 1))
    _draw_history(history, result)
    _draw_law(law, result)
    style.legend_below(drawn, history, law, columns=4)
    return drawn


def _draw_history(axes: Axes, result: CreepResult) -> None:
    """Draw what was measured less stretch and heat, and what the law makes of the forces."""
    assert result.test.time is not None
    step = -(-len(result.test.time) // _MAX_POINTS)
    times, crept = (result.test.time - result.test.time[0])[::step], result.crept()[::step]
    measured = crept + result.residuals[::step]
    name = "measured, less stretch and heat"
    axes.plot(times / 60.0, 1e6 * measured, ".", color=style.GREY, markersize=2, label=name)
    axes.plot(times / 60.0, 1e6 * crept, color=style.BLUE, label="law found")
    axes.set(xlabel="time in min", ylabel="strain in µm/m")
    axes.set_title("creep in the test")


def _draw_law(axes: Axes, result: CreepResult) -> None:
    """Draw the creep per load by time under a constant one, with two standard deviations."""
    times = np.geomspace(_FROM, max(result.loaded, 10.0 * _FROM), 200)
    found = np.array([result.compliance_at(time) for time in times.tolist()])
    size, sigma = 1e9 * found.T
    axes.fill_between(times, size - _BAND * sigma, size + _BAND * sigma, color=style.BLUE, alpha=0.2, linewidth=0,
                      label="two sigmas")  # fmt: skip
    axes.plot(times, size, color=style.BLUE, linestyle=style.DASHED, label="under a constant load")
    axes.set_xscale("log")
    ticks = {name: at for name, at in _TICKS.items() if at <= times[-1]}
    axes.set_xticks(list(ticks.values()), list(ticks))
    axes.set_xticks([], minor=True)
    axes.set(xlabel="time under load", ylabel="creep in µm/m per kN")
    axes.set_title("creep per load")
