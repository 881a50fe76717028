"""Workspace against lowest frequency while numbers of a robot vary (Jung 2020, Figs. 7 and 12 to 14)."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from cablewright.apps import style
from cablewright.robot.design_variables import Change
from cablewright.studies.trade import Trade

Array = NDArray[Any]

_COLOURS: Final = (style.BLUE, style.ORANGE, style.GREEN, style.RED, style.PINK, style.INK)
_LONGEST: Final = 40
_HIDDEN: Final[dict[str, Any]] = {"color": style.GREY, "marker": "x", "linestyle": "none", "markersize": 6}
_RING: Final[dict[str, Any]] = style.RING | {"markersize": 9}


def trade_picture(found: Trade) -> Figure:
    """Draw volume and lowest frequency by the first varied number, and one against the other."""
    drawn = style.figure(12.6, 4.8)
    left, middle, right = drawn.subplots(1, 3)
    values = np.array([each.values for each in found.combinations])
    volumes = np.array([each.volume for each in found.combinations])
    spreads = [(each.least, each.median, each.greatest) for each in found.combinations]
    frequencies = np.array(spreads, dtype=np.float64)  # (C, 3), NaN where there is none
    groups = _groups(values)
    _by_first(left, found, values[:, 0], volumes, groups)
    left.set(ylabel="volume in m³", title="workspace")
    left.set_ylim(bottom=0.0)
    _by_first(middle, found, values[:, 0], frequencies[:, 0], groups)
    if len(groups) == 1:
        (rows,) = groups
        spread = frequencies[rows].T
        middle.fill_between(values[rows, 0], spread[0], spread[2], color=style.BLUE, alpha=0.13, linewidth=0.0)
        middle.plot(values[rows, 0], spread[1], "--", color=style.BLUE)
    middle.set(ylabel="lowest frequency in Hz", title="lowest frequency: min on the boundary")
    middle.set_ylim(bottom=min(0.0, float(np.nanmin(frequencies, initial=0.0))))
    _against(right, found, volumes, frequencies[:, 0], groups)
    _legend(drawn, found, values, groups)
    text = f"{style.label(found.model.robot.name)}, {found.settings.criterion}"
    style.headline(drawn, text + ("" if found.settings.geometric else ", frequencies without geometric stiffness"))
    return drawn


def _groups(values: Array) -> list[Array]:
    """Return groups of rows with the same values of all but the first varied number, each sorted by that one."""
    _, of = np.unique(values[:, 1:], axis=0, return_inverse=True)
    order = np.argsort(values[:, 0], kind="stable")
    return [order[of.ravel()[order] == k] for k in range(int(of.max()) + 1)]


def _colour(k: int, groups: list[Array]) -> Any:
    if len(groups) <= len(_COLOURS):
        return _COLOURS[k]
    return style.error_colours()(k / (len(groups) - 1))


def _by_first(axes: Axes, found: Trade, first: Array, shown: Array, groups: list[Array]) -> None:
    """Draw what is *shown* over the first varied number, a line for each set of the others."""
    for k, rows in enumerate(groups):
        axes.plot(first[rows], shown[rows], "o-", color=_colour(k, groups), markersize=4)
    hidden = ~found.clear
    axes.plot(first[hidden], shown[hidden], zorder=5, **_HIDDEN)
    change = next(iter(found.varied))
    axes.set_xlabel(style.label(change.name, _LONGEST) + ("" if change.unit == "1" else f" in {change.unit}"))
    axes.xaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))


def _against(axes: Axes, found: Trade, volumes: Array, lowest: Array, groups: list[Array]) -> None:
    """Draw the min of the lowest frequency over the volume, with a line through those not dominated."""
    for k, rows in enumerate(groups):
        axes.plot(volumes[rows], lowest[rows], "o", color=_colour(k, groups), markersize=4)
    axes.plot(volumes[~found.clear], lowest[~found.clear], zorder=5, **_HIDDEN)
    best = np.flatnonzero(found.best)
    best = best[np.argsort(volumes[best], kind="stable")]
    axes.plot(volumes[best], lowest[best], "-", color=style.INK, linewidth=1.0, zorder=1.5)
    axes.plot(volumes[best], lowest[best], zorder=4, **_RING)
    axes.set(xlabel="volume in m³", ylabel="min of the lowest frequency in Hz", title="frequency against volume")


def _legend(drawn: Figure, found: Trade, values: Array, groups: list[Array]) -> None:
    handles: list[Line2D] = []
    others = list(found.varied)[1:]
    shown = range(len(groups)) if len(groups) <= len(_COLOURS) else (0, len(groups) - 1)
    for k in shown:
        row = values[groups[k][0], 1:]
        name = ", ".join(_valued(change, value) for change, value in zip(others, row, strict=True))
        handles.append(Line2D([], [], color=_colour(k, groups), marker="o", markersize=4, label=name or "min"))
    if len(groups) == 1:
        handles.append(Line2D([], [], color=style.BLUE, linestyle="--", label="median; shaded: min to max"))
    if found.best.any():
        handles.append(Line2D([], [], **(_RING | {"linestyle": "-", "linewidth": 1.0, "label": "not dominated"})))
    if not found.clear.all():
        near = f"exit points nearer than {found.settings.clearance:g} m: sheaves collide"
        handles.append(Line2D([], [], label=near, **_HIDDEN))
    drawn.legend(handles=handles, loc="outside lower center", ncols=4)


def _valued(change: Change, value: float) -> str:
    return f"{style.label(change.name, _LONGEST)} {value:.4g}" + ("" if change.unit == "1" else f" {change.unit}")
