"""Pictures of cable tests: force and modulus of a tensile test, strain and law of a creep test."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cablewright.apps import style
from cablewright.calibration.tensile.creep import CreepResult
from cablewright.calibration.tensile.modulus import PAPER_SPREAD, TensileResult
from cablewright.calibration.tensile.recording import TensileTest
from cablewright.foundation.arrays import Array

_MAX_POINTS: Final = 20_000  # of a curve: the picture cannot show more


def tensile_picture(result: TensileResult) -> Figure:
    """Draw the test, the modulus found, and the tangent moduli."""
    drawn, (curves, slopes) = style.subplots(9.0, 4.4, 1, 2, sharey=True, width_ratios=(1.25, 1))
    low, high = (load / 1e3 for load in result.loads)
    for axes in (curves, slopes):
        axes.axhspan(low, high, color=style.GREY, alpha=0.13, linewidth=0)
    _draw_curves(curves, result.test, result)
    _draw_slopes(slopes, result)
    name = f"band, {100 * result.band[0]:g} to {100 * result.band[1]:g} % of the breaking load"
    curves.fill_between([], [], color=style.GREY, alpha=0.13, linewidth=0, label=name)
    style.legend_below(drawn, curves, slopes, columns=3)
    return drawn


def _draw_curves(axes: Axes, test: TensileTest, result: TensileResult) -> None:
    """Draw the whole test thinly, the branches in their colours, and the secant."""
    _curve(axes, test.elongation, test.force, color=style.GREY, linewidth=0.6, label="whole test")
    last = {branch.rising: branch for branch in result.branches}
    for branch in result.branches:
        name = f"last {branch.word} (earlier ones pale)" if branch is last[branch.rising] else None
        shade = 1.0 if name else 0.35
        _curve(axes, branch.elongation, branch.force, color=_colour(branch.rising), alpha=shade, label=name)
    start = result.length - result.initial_length
    ends = np.array([start, start + result.stretch])
    secant = f"secant, {result.modulus / 1e9:.4g} GPa"
    look: dict[str, Any] = {
        "color": style.INK,
        "linestyle": style.DASHED,
        "linewidth": 1.2,
        "marker": "o",
        "markersize": 4,
    }
    axes.plot(ends * 1e3, np.array(result.loads) / 1e3, label=secant, **look)
    axes.set(xlabel="elongation in mm", ylabel="force in kN", title="force over elongation")


def _draw_slopes(axes: Axes, result: TensileResult) -> None:
    """Draw the tangent moduli of every branch, with the nominal modulus and the paper's spread about it."""
    nominal = result.modulus / 1e9
    name = f"nominal ±{100 * PAPER_SPREAD:.0f} %"
    spread = (1 - PAPER_SPREAD) * nominal, (1 + PAPER_SPREAD) * nominal
    axes.axvspan(*spread, color=style.GREEN, alpha=0.13, linewidth=0, label=name)
    axes.axvline(nominal, color=style.INK, linestyle=style.DASHED)
    last = {branch.rising: branch for branch in result.branches}
    for branch in result.branches:
        shade = 1.0 if branch is last[branch.rising] else 0.35
        colour = _colour(branch.rising)
        axes.plot(branch.tangents / 1e9, branch.tangent_forces / 1e3, color=colour, marker="o", ms=3, alpha=shade)
    axes.set(
        xlabel="tangent modulus in GPa",
        xlim=(min(axes.get_xlim()[0], 0.65 * nominal), max(axes.get_xlim()[1], 1.35 * nominal)),
        title="stiffness by force",
    )


def _curve(axes: Axes, elongation: Array, force: Array, **look: Any) -> None:
    step = -(-len(force) // _MAX_POINTS)
    axes.plot(elongation[::step] * 1e3, force[::step] / 1e3, **look)


def _colour(rising: bool) -> str:
    return style.BLUE if rising else style.ORANGE


_FROM: Final = 1.0  # s: what is earlier is stretch rather than creep
_BAND: Final = 2.0  # sigmas
_TICKS: Final = {
    "1 s": 1.0, "10 s": 10.0, "1 min": 60.0, "10 min": 600.0, "1 h": 3600.0, "10 h": 36e3, "4 d": 345.6e3,
    "40 d": 3.456e6,
}  # fmt: skip


def creep_picture(result: CreepResult) -> Figure:
    """Draw the strain without its elastic part by time, and the creep per load."""
    drawn, (history, law) = style.subplots(9.0, 4.2, 1, 2, width_ratios=(1.25, 1))
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
    axes.set(xlabel="time in min", ylabel="strain in µm/m", title="creep in the test")


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
    axes.set(xlabel="time under load", ylabel="creep in µm/m per kN", title="creep per load")
