"""A search for designs: how it went or its front, the chosen candidates' values, and where their exit points are."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from cablewright.apps import style
from cablewright.arrays import Array
from cablewright.robot import Robot
from cablewright.studies.design.measures import MEASURES, Measure
from cablewright.studies.design.result import Designed, Tried

_COLOURS = (style.BLUE, style.ORANGE, style.GREEN)


def design_picture(found: Designed) -> Figure:
    """Draw the search, the values of the candidates, and the robots seen from above."""
    drawn = style.figure(12.6, 4.8)
    left, middle, right = drawn.subplots(1, 3)
    if len(found.what.objectives) > 1:
        _front(left, found)
    else:
        _progress(left, found)
    _bars(middle, found)
    _plan(right, found)
    _legend(drawn, found)
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
    for each, colour in zip(found.chosen, _COLOURS, strict=False):
        axes.plot(*points((each,)), **{**style.RING, "color": colour})
    if found.original.figures:
        label = "robot as it was" if found.original.holds else "robot as it was; breaks a constraint"
        axes.plot(*points((found.original,)), "x", color=style.RED, markersize=8, label=label)
    axes.set(xlabel=_axis(one), ylabel=_axis(other), title="front")
    axes.legend(loc="best")


def _bars(axes: Axes, found: Designed) -> None:
    """Draw where the values of the candidates are between their bounds."""
    names = [style.label(each.name) for each in found.what.variables]
    height = 0.8 / max(len(found.chosen), 1)
    for k, (each, colour) in enumerate(zip(found.chosen, _COLOURS, strict=False)):
        rows = np.arange(len(names)) + (k - 0.5 * (len(found.chosen) - 1)) * height
        shares = found.shares(each.values)
        axes.barh(rows, 100.0 * shares, height=0.9 * height, color=colour)
        for row, share, value in zip(rows, shares, each.values, strict=True):
            axes.text(100.0 * share + 1.0, row, f"{value:.4g}", va="center", fontsize=7.5)
    axes.set_yticks(np.arange(len(names)), names)
    axes.invert_yaxis()
    axes.set_xlim(0.0, 118.0)
    axes.set(xlabel="between the bounds, %", title="values of the candidates")
    axes.grid(visible=False, axis="y")


def _plan(axes: Axes, found: Designed) -> None:
    """Draw exit points and frame from above, and the places of the part."""
    scene = found.what.robot.scene
    style.rectangle(axes, scene.frame_min, scene.frame_max)
    if found.what.places:
        x, y, _ = np.array(found.what.places).T
        axes.plot(x, y, ".", color=style.GREY, markersize=3)
    _exits(axes, found.what.robot, style.RED, "x")
    for each, colour in zip(found.chosen, _COLOURS, strict=False):
        _exits(axes, found.robot_of(each), colour, "o")
    axes.set_aspect("equal")
    axes.set(xlabel="x in m", ylabel="y in m", title="exit points and places of the part")


def _exits(axes: Axes, robot: Robot, colour: str, marker: str) -> None:
    x, y = np.array([line.exit_point[:2] for line in robot.lines]).T
    axes.plot(x, y, marker, color=colour, fillstyle="none", markersize=7)


def _legend(drawn: Figure, found: Designed) -> None:
    """Say below which colour is which candidate."""
    handles = [
        Line2D([], [], color=colour, linewidth=6, label=f"candidate {k}")
        for k, (_, colour) in enumerate(zip(found.chosen, _COLOURS, strict=False), 1)
    ]
    handles.append(Line2D([], [], color=style.RED, marker="x", linestyle="none", label="robot as it was"))
    drawn.legend(handles=handles, loc="outside lower center", ncols=4)
