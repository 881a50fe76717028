"""A tensile test: force over elongation with the band and the secant, and the cable's tangent modulus by force."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cablewright.apps import style
from cablewright.arrays import Array
from cablewright.calibration.tensile.modulus import PAPER_SPREAD, TensileResult
from cablewright.calibration.tensile.recording import TensileTest

_MAX_POINTS: Final = 20_000  # of a curve: the picture cannot show more


def tensile_picture(result: TensileResult) -> Figure:
    """Draw the test, the modulus found, and the tangent moduli."""
    drawn = style.figure(9.0, 4.4)
    curves, slopes = drawn.subplots(1, 2, sharey=True, width_ratios=(1.25, 1))
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
    axes.set(xlabel="elongation in mm", ylabel="force in kN")
    axes.set_title("force over elongation")


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
    axes.set(xlabel="tangent modulus in GPa")
    axes.set_xlim(left=min(axes.get_xlim()[0], 0.65 * nominal), right=max(axes.get_xlim()[1], 1.35 * nominal))
    axes.set_title("stiffness by force")


def _curve(axes: Axes, elongation: Array, force: Array, **look: Any) -> None:
    step = -(-len(force) // _MAX_POINTS)
    axes.plot(elongation[::step] * 1e3, force[::step] / 1e3, **look)


def _colour(rising: bool) -> str:
    return style.BLUE if rising else style.ORANGE
