"""Pictures of many variants of a machine: as built, design candidates, combinations of values (Jung 2020)."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from cablewright.apps import style
from cablewright.foundation.arrays import Array
from cablewright.robot import Robot
from cablewright.robot.design_variables import Change
from cablewright.studies.campaigns.result import Campaign
from cablewright.studies.design.measures import MEASURES, Measure
from cablewright.studies.design.result import Designed, Tried
from cablewright.studies.trade import Trade


def campaign_picture(found: Campaign) -> Figure:
    """Draw the share of machines within an error, and the change of the largest error by tolerance."""
    drawn = style.figure(11.0, 4.4)
    if found.sensitivities:
        left, right = drawn.subplots(1, 2)
        _draw_sensitivities(right, found)
    else:
        left = drawn.subplots()
    _distribution(left, found)
    low, high = found.success_interval
    style.headline(
        drawn,
        f"{style.label(found.what.job.name)} on {len(found.prints)} machines of {style.label(found.what.robot.name)}: "
        f"{100 * found.success_rate:.0f} % succeed (95 % interval {100 * low:.0f} to {100 * high:.0f} %)",
    )
    return drawn


def _distribution(axes: Axes, found: Campaign) -> None:
    """Draw the share of the machines, finished or not, whose largest error is at most so large."""
    errors = np.sort(1e3 * found.errors[np.isfinite(found.errors)])
    shares = 100.0 * np.arange(1, len(errors) + 1) / len(found.prints)
    axes.step(np.r_[0.0, errors], np.r_[0.0, shares], where="post", color=style.BLUE)
    axes.axvline(1e3 * found.allowed_error, color=style.RED, linestyle="--", label="allowed")
    axes.set(
        xlabel="largest error beside the path in mm",
        ylabel="machines in %",
        title="machines within an error",
        xlim=(0.0, None),
        ylim=(0.0, 104.0),
    )
    axes.legend(loc="lower right")


def _draw_sensitivities(axes: Axes, found: Campaign) -> None:
    """Draw the mean change of the largest error if a tolerance is met exactly, with its standard error."""
    rows = found.sensitivities[::-1]
    names = [each.tolerance.replace("_", " ") for each in rows]
    changes = [1e3 * each.change for each in rows]
    errors = [1e3 * each.change_error for each in rows]
    axes.barh(names, changes, xerr=np.nan_to_num(errors), color=style.SKY, ecolor=style.INK, capsize=3)
    axes.axvline(0.0, color=style.GREY, linewidth=0.8)
    axes.set(xlabel="change of the largest error in mm, mean and its standard error", title="one tolerance met exactly")
    axes.grid(visible=False, axis="y")


_CANDIDATES = (style.BLUE, style.ORANGE, style.GREEN)


def design_picture(found: Designed) -> Figure:
    """Draw the search, the values of the candidates, and the robots seen from above."""
    drawn, (left, middle, right) = style.subplots(12.6, 4.8, 1, 3)
    if len(found.what.objectives) > 1:
        _front(left, found)
    else:
        _progress(left, found)
    _draw_values(middle, found)
    _plan(right, found)
    _name_candidates(drawn, found)
    text = f"{style.label(found.what.robot.name)}: {len(found.tried)} candidates by {found.method}"
    style.headline(drawn, text)
    return drawn


def _scaled(measure: Measure, value: float) -> float:
    return 1e3 * value if measure.figure.shown == "mm" else value


def _axis(measure: Measure) -> str:
    unit = "mm" if measure.figure.shown == "mm" else measure.figure.unit.replace("^3", "³")
    return f"{measure.key.replace('_', ' ')} in {unit}, {'higher' if measure.higher else 'lower'} is better"


def _progress(axes: Axes, found: Designed) -> None:
    """Draw the objective of each candidate that holds, and the best until then."""
    measure = MEASURES[found.what.objectives[0]]
    rows = [(k, _scaled(measure, each.figures[measure.key])) for k, each in enumerate(found.tried, 1) if each.holds]
    at, values = np.array(rows).reshape(-1, 2).T
    axes.plot(at, values, ".", color=style.GREY, markersize=4, label="candidates that hold")
    if len(at):
        best = np.maximum.accumulate(values) if measure.higher else np.minimum.accumulate(values)
        axes.step(at, best, where="post", color=style.BLUE, label="best until then")
    if found.original.holds:
        own = _scaled(measure, found.original.figures[measure.key])
        axes.axhline(own, color=style.INK, linestyle="--", label="robot as it was")
    axes.set(xlabel="candidate", ylabel=_axis(measure), title="search")
    axes.legend(loc="best")


def _front(axes: Axes, found: Designed) -> None:
    """Draw the first two objectives."""
    one, other = (MEASURES[key] for key in found.what.objectives[:2])

    def points(tried: tuple[Tried, ...]) -> Array:
        return np.array([[_scaled(each, t.figures[each.key]) for each in (one, other)] for t in tried]).reshape(-1, 2).T

    axes.plot(*points(found.holding), ".", color=style.GREY, markersize=4, label="candidates that hold")
    axes.plot(*points(found.front), "o", color=style.INK, markersize=4, label="not dominated")
    for each, colour in zip(found.chosen, _CANDIDATES, strict=False):
        axes.plot(*points((each,)), **{**style.RING, "color": colour})
    if found.original.figures:
        label = "robot as it was" if found.original.holds else "robot as it was; breaks a constraint"
        axes.plot(*points((found.original,)), "x", color=style.RED, markersize=8, label=label)
    axes.set(xlabel=_axis(one), ylabel=_axis(other), title="front")
    axes.legend(loc="best")


def _draw_values(axes: Axes, found: Designed) -> None:
    """Draw where the values of the candidates are between their bounds."""
    names = [style.label(each.name) for each in found.what.variables]
    height = 0.8 / max(len(found.chosen), 1)
    for k, (each, colour) in enumerate(zip(found.chosen, _CANDIDATES, strict=False)):
        rows = np.arange(len(names)) + (k - 0.5 * (len(found.chosen) - 1)) * height
        shares = found.shares(each.values)
        axes.barh(rows, 100.0 * shares, height=0.9 * height, color=colour)
        for row, share, value in zip(rows, shares, each.values, strict=True):
            axes.text(100.0 * share + 1.0, row, f"{value:.4g}", va="center", fontsize=7.5)
    axes.set_yticks(np.arange(len(names)), names)
    axes.invert_yaxis()
    axes.set(xlim=(0.0, 118.0), xlabel="between the bounds, %", title="values of the candidates")
    axes.grid(visible=False, axis="y")


def _plan(axes: Axes, found: Designed) -> None:
    """Draw exit points and frame from above, and the places of the part."""
    scene = found.what.robot.scene
    style.rectangle(axes, scene.frame_min, scene.frame_max)
    if found.what.places:
        x, y, _ = np.array(found.what.places).T
        axes.plot(x, y, ".", color=style.GREY, markersize=3)
    _exits(axes, found.what.robot, style.RED, "x")
    for each, colour in zip(found.chosen, _CANDIDATES, strict=False):
        _exits(axes, found.robot_of(each), colour, "o")
    axes.set(aspect="equal", xlabel="x in m", ylabel="y in m", title="exit points and places of the part")


def _exits(axes: Axes, robot: Robot, colour: str, marker: str) -> None:
    x, y = np.array([line.exit_point[:2] for line in robot.lines]).T
    axes.plot(x, y, marker, color=colour, fillstyle="none", markersize=7)


def _name_candidates(drawn: Figure, found: Designed) -> None:
    """Say below which colour is which candidate."""
    handles = [
        Line2D([], [], color=colour, linewidth=6, label=f"candidate {k}")
        for k, (_, colour) in enumerate(zip(found.chosen, _CANDIDATES, strict=False), 1)
    ]
    handles.append(Line2D([], [], color=style.RED, marker="x", linestyle="none", label="robot as it was"))
    names = [str(each.get_label()) for each in handles]
    drawn.legend(handles=handles, loc="outside lower center", ncols=style.legend_columns(names, 4))


_Numbers = NDArray[Any]

_COLOURS: Final = (style.BLUE, style.ORANGE, style.GREEN, style.RED, style.PINK, style.INK)
_LONGEST: Final = 40
_HIDDEN: Final[dict[str, Any]] = {"color": style.GREY, "marker": "x", "linestyle": "none", "markersize": 6}
_RING: Final[dict[str, Any]] = style.RING | {"markersize": 9}


def trade_picture(found: Trade) -> Figure:
    """Draw workspace volume and lowest frequency by the first varied number, and one against the other."""
    drawn, (left, middle, right) = style.subplots(12.6, 4.8, 1, 3)
    values = np.array([each.values for each in found.combinations])
    volumes = np.array([each.volume for each in found.combinations])
    spreads = [(each.least, each.median, each.greatest) for each in found.combinations]
    frequencies = np.array(spreads, dtype=np.float64)  # (C, 3), NaN where there is none
    groups = _groups(values)
    _by_first(left, found, values[:, 0], volumes, groups)
    left.set(ylabel="volume in m³", title="workspace", ylim=(0.0, None))
    _by_first(middle, found, values[:, 0], frequencies[:, 0], groups)
    if len(groups) == 1:
        (rows,) = groups
        spread = frequencies[rows].T
        middle.fill_between(values[rows, 0], spread[0], spread[2], color=style.BLUE, alpha=0.13, linewidth=0.0)
        middle.plot(values[rows, 0], spread[1], "--", color=style.BLUE)
    middle.set(
        ylabel="lowest frequency in Hz",
        title="lowest frequency: min on the boundary",
        ylim=(min(0.0, float(np.nanmin(frequencies, initial=0.0))), None),
    )
    _against(right, found, volumes, frequencies[:, 0], groups)
    _name_groups(drawn, found, values, groups)
    text = f"{style.label(found.model.robot.name)}, {found.settings.criterion}"
    style.headline(drawn, text + ("" if found.settings.geometric else ", frequencies without geometric stiffness"))
    return drawn


def _groups(values: _Numbers) -> list[_Numbers]:
    """Return groups of rows with the same values of all but the first varied number, each sorted by that one."""
    _, of = np.unique(values[:, 1:], axis=0, return_inverse=True)
    order = np.argsort(values[:, 0], kind="stable")
    return [order[of.ravel()[order] == k] for k in range(int(of.max()) + 1)]


def _colour(k: int, groups: list[_Numbers]) -> Any:
    if len(groups) <= len(_COLOURS):
        return _COLOURS[k]
    return style.error_colours()(k / (len(groups) - 1))


def _by_first(axes: Axes, found: Trade, first: _Numbers, shown: _Numbers, groups: list[_Numbers]) -> None:
    """Draw what is *shown* over the first varied number, a line for each set of the others."""
    for k, rows in enumerate(groups):
        axes.plot(first[rows], shown[rows], "o-", color=_colour(k, groups), markersize=4)
    hidden = ~found.clear
    axes.plot(first[hidden], shown[hidden], zorder=5, **_HIDDEN)
    change = next(iter(found.varied))
    axes.set_xlabel(style.label(change.name, _LONGEST) + ("" if change.unit == "1" else f" in {change.unit}"))
    axes.xaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))


def _against(axes: Axes, found: Trade, volumes: _Numbers, lowest: _Numbers, groups: list[_Numbers]) -> None:
    """Draw the min of the lowest frequency over the volume, with a line through those not dominated."""
    for k, rows in enumerate(groups):
        axes.plot(volumes[rows], lowest[rows], "o", color=_colour(k, groups), markersize=4)
    axes.plot(volumes[~found.clear], lowest[~found.clear], zorder=5, **_HIDDEN)
    best = np.flatnonzero(found.best)
    best = best[np.argsort(volumes[best], kind="stable")]
    axes.plot(volumes[best], lowest[best], "-", color=style.INK, linewidth=1.0, zorder=1.5)
    axes.plot(volumes[best], lowest[best], zorder=4, **_RING)
    axes.set(xlabel="volume in m³", ylabel="min of the lowest frequency in Hz", title="frequency against volume")


def _name_groups(drawn: Figure, found: Trade, values: _Numbers, groups: list[_Numbers]) -> None:
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
    names = [str(each.get_label()) for each in handles]
    drawn.legend(handles=handles, loc="outside lower center", ncols=style.legend_columns(names, 4))


def _valued(change: Change, value: float) -> str:
    return f"{style.label(change.name, _LONGEST)} {value:.4g}" + ("" if change.unit == "1" else f" {change.unit}")
