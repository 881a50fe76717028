"""Pictures of modes at a pose, and of the lowest frequencies along a workspace boundary (Jung 2020, Fig. 12)."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec

from cablewright.analyses.modes import FREEDOMS, Modes
from cablewright.analyses.swing_identification import ORDERS
from cablewright.analyses.workspace.boundary_frequencies import Boundary
from cablewright.apps import style
from cablewright.apps.space_axes import add_lines, bounds, machine, space
from cablewright.foundation.arrays import Array
from cablewright.models.rotation import placed
from cablewright.studies.measured_modes import MeasuredModes

_ROOM: Final = 0.45  # of the platform's largest side: the space shown around it
_ZOOM: Final = 0.7  # leaves room for the labels of tall boxes too
_MIN_ROOM: Final = 0.1  # of the frame's largest side: the min size counted for a platform
_SWING: Final = 0.3  # of the picture's largest side: the longest arrow


def modes_picture(found: Modes) -> Figure:
    """Draw the modes of a single equilibrium, three in a row."""
    n = len(found.frequencies)
    columns = style.beside(3)
    rows = -(-n // columns)
    drawn = style.figure(3.2 * columns, 4.6 * rows)
    grid = drawn.add_gridspec(2 * rows, columns, height_ratios=(3.6, 1.0) * rows)
    for mode in range(n):
        row, column = divmod(mode, columns)
        _shape(drawn, grid[2 * row, column], found, mode)
        _shares(drawn.add_subplot(grid[2 * row + 1, column]), found, mode)
    style.legend_below(drawn, drawn.axes[0], columns=4)
    return drawn


def _shape(drawn: Figure, where: SubplotSpec, found: Modes, mode: int) -> None:
    """Draw the platform at rest with the motion of its points, all to one scale."""
    held = found.equilibrium
    centre, points = _body(found)
    robot = held.model.robot
    frame = float(np.max(np.subtract(robot.scene.frame_max, robot.scene.frame_min)))
    low, high = bounds(centre, points)
    around = _ROOM * max(float((high - low).max()), _MIN_ROOM * frame)
    axes, _ = space(drawn, where, low - around, high + around, "m", zoom=_ZOOM)
    size = float((high - low).max()) + 2.0 * around
    exits = np.array([line.exit_point for line in robot.lines])
    away = exits - points
    stubs = points + away * np.minimum(1.0, 0.35 * size / np.linalg.norm(away, axis=1))[:, None]
    add_lines(axes, np.stack([points, stubs], axis=1), 2, 0.9, style.GREY)
    spokes = np.stack([np.broadcast_to(centre, points.shape), points], axis=1)
    add_lines(axes, spokes, 3, 1.4, style.INK)
    ends = np.vstack([centre, points])
    moved = _motion(found, mode, ends)
    arrows = moved * (_SWING * size / max(float(np.linalg.norm(moved, axis=1).max()), 1e-300))
    axes.plot([], [], color=style.GREY, linewidth=0.9, label="ends of the lines")
    if len(np.unique(points, axis=0)) > 1:
        axes.plot([], [], color=style.INK, label="platform points from the centre of mass")
    axes.quiver(*ends.T, *arrows.T, color=style.ORANGE, linewidth=1.6, arrow_length_ratio=0.25, zorder=5)
    axes.plot([], [], color=style.ORANGE, label="motion, enlarged")
    axes.plot(*centre[:, None], "o", color=style.BLUE, markersize=5, zorder=6, label="centre of mass")
    frequency = float(found.frequencies[mode])
    axes.set_title(f"{mode + 1}: " + (f"{frequency:.3g} Hz, {found.motion[mode]}" if frequency >= 0 else "unstable"))


def _shares(axes: Axes, found: Modes, mode: int) -> None:
    """Draw the share of the mode's energy in each freedom as bars."""
    names = FREEDOMS[: len(found.frequencies)]
    shares = 100.0 * found.participation[:, mode]
    colours = [style.ORANGE if k == found.dominant[mode] else style.GREY for k in range(len(names))]
    axes.bar(names, shares, color=colours, width=0.7)
    axes.set(ylim=(0, 100), yticks=(0, 50, 100))
    axes.grid(visible=False, axis="x")
    axes.set_ylabel("% of energy" if mode % style.beside(3) == 0 else "")


def _body(found: Modes) -> tuple[Array, Array]:
    """Return the centre of mass (3,) and the platform points (m, 3), m, world."""
    held = found.equilibrium
    return placed(held.pose, [held.model.robot.platform.centre_of_mass])[0], held.platform_points


def _motion(found: Modes, mode: int, points: Array) -> Array:
    """Return the motion (k, 3) of points of the platform, world, to the scale of the mode's shape."""
    shape, pose = found.shapes[:, mode], found.equilibrium.pose
    moved = np.broadcast_to(shape[:3], points.shape)
    if len(shape) == 6:
        moved = moved + np.cross(shape[3:], points - pose[:3])
    return np.asarray(moved)


_OF_FREEDOMS: Final = (style.BLUE, style.GREEN, style.INK, style.SKY, style.PINK, style.ORANGE)


def swing_picture(found: MeasuredModes) -> Figure:
    """Draw the strongest channel of a recorded swing with its modes, and the frequencies identified at each order."""
    swing = found.swing
    drawn = style.figure(9.6, 6.4)
    above, below = drawn.subplots(2, 1)
    strongest = int((swing.record**2).sum(axis=0).argmax())
    unit = {"positions": "position, m", "inertial": "inertial unit", "load-cells": "tension"}[found.record.signal]
    above.plot(swing.times, swing.record[:, strongest], color=style.GREY, linewidth=3.0, label="recorded")
    above.plot(swing.times, swing.fit[:, strongest], color=style.ORANGE, linewidth=1.0, label="measured modes together")
    above.set(xlabel="time, s", ylabel=unit, xlim=(swing.times[0], swing.times[-1]))
    above.set_title("channel with the most energy, without its mean")
    above.legend(loc="upper right")
    matched = found.model.frequencies[[k for k in found.matched if k >= 0]]
    highest = 1.2 * float(max(swing.frequencies.max(), matched.max(initial=0.0)))
    top = float(ORDERS[-1] + 2)
    below.vlines(found.model.frequencies, 0.0, top, color=style.BLUE, linewidth=1.6, label="model")
    below.vlines(swing.frequencies, 0.0, top, color=style.ORANGE, linewidth=1.6, label="measured")
    below.plot(swing.poles[:, 1], swing.poles[:, 0], "o", color=style.INK, markersize=3, label="poles of an order")
    below.set_ylim(0.0, top)
    below.set(xlabel="frequency, Hz", ylabel="number of poles", xlim=(0.0, highest))
    below.set_title("a mode is what repeats over orders")
    below.legend(loc="upper right")
    return drawn


def boundary_picture(found: Boundary) -> Figure:
    """Draw positions by their lowest frequency, and by the degree of freedom with most energy in that mode."""
    drawn, panels = style.grid(10.4, 5.2, (1, 2), (0, 0), (0, 1))
    places = np.tile(found.places, (len(found.nodes.criterion.orientations), 1))[found.known]
    lowest = found.lowest[found.known]
    robot, box = found.nodes.criterion.model.robot, found.nodes.box
    left, right = (machine(drawn, panel, robot, box.low, box.high) for panel in panels)
    colours = {"cmap": style.error_colours().reversed(), "norm": Normalize(*found.spread[::2])}
    shown = left.scatter(*places.T, c=lowest, s=9, depthshade=False, **colours)
    style.colour_bar(drawn, left, shown, "lowest frequency in Hz", shrink=0.6)
    left.set_title("lowest frequency")
    named = found.modes.dominant[found.known, 0]
    for k, (name, colour) in enumerate(zip(FREEDOMS, _OF_FREEDOMS, strict=True)):
        chosen = named == k
        if chosen.any():
            share = f"{name}, {100.0 * chosen.mean():.0f} %"
            right.scatter(*places[chosen].T, color=colour, s=9, depthshade=False, label=share)
    right.legend(loc="upper center", bbox_to_anchor=(0.5, -0.02), ncols=3, markerscale=2.0)
    right.set_title("freedom with most energy in the lowest mode")
    low, median, high = (style.minus(f"{value:.3g} Hz") for value in found.spread)
    text = f"{style.label(robot.name)}, boundary by {found.nodes.criterion.name}: {low} to {high}, median {median}"
    style.headline(drawn, text + ("" if found.modes.geometric else ", without geometric stiffness"))
    return drawn
