"""Modes of the platform: where each takes its points, much enlarged, and whose energy it has."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec

from cablewright.analyses.modes import FREEDOMS, Modes
from cablewright.apps import style
from cablewright.apps.space_axes import add_lines, space
from cablewright.arrays import Array
from cablewright.models.rotation import placed
from cablewright.robot import RigidPlatform

_ROOM: Final = 0.45  # of the platform's largest side: what is shown around it
_ZOOM: Final = 0.78  # leaves room for the labels of tall boxes too
_MIN_ROOM: Final = 0.1  # of the frame's largest side: a point's and a small body's room
_SWING: Final = 0.3  # of the picture's largest side: the largest motion drawn


def modes_picture(found: Modes) -> Figure:
    """Draw the modes of a single equilibrium, three in a row. Call within `style.drawing`."""
    n = len(found.frequencies)
    rows = n // 3
    drawn = style.figure(9.6, 4.6 * rows)
    grid = drawn.add_gridspec(2 * rows, 3, height_ratios=(3.6, 1.0) * rows)
    for mode in range(n):
        row, column = divmod(mode, 3)
        _shape(drawn, grid[2 * row, column], found, mode)
        _shares(drawn.add_subplot(grid[2 * row + 1, column]), found, mode)
    handles, names = drawn.axes[0].get_legend_handles_labels()
    drawn.legend(handles, names, loc="outside lower center", ncols=4)
    return drawn


def _shape(drawn: Figure, where: SubplotSpec, found: Modes, mode: int) -> None:
    """Draw the platform at rest with the motion of its points, all to one scale."""
    held = found.equilibrium
    centre, points = _body(found)
    low, high = _room(found, np.vstack([centre, points]))
    axes, _ = space(drawn, where, low, high, "m", zoom=_ZOOM)
    size = float((high - low).max())
    exits = np.array([line.exit_point for line in held.model.robot.lines])
    away = exits - points
    stubs = points + away * np.minimum(1.0, 0.35 * size / np.linalg.norm(away, axis=1))[:, None]
    add_lines(axes, np.stack([points, stubs], axis=1), 2, 0.9, style.GREY)
    spokes = np.stack([np.broadcast_to(centre, points.shape), points], axis=1)
    add_lines(axes, spokes, 3, 1.4, style.INK)
    ends = np.vstack([centre, points])
    moved = _motion(found, mode, ends)
    arrows = moved * (_SWING * size / max(float(np.linalg.norm(moved, axis=1).max()), 1e-300))
    axes.plot([], [], color=style.GREY, linewidth=0.9, label="lines, from their ends at the platform")
    if len(np.unique(points, axis=0)) > 1:
        axes.plot([], [], color=style.INK, label="platform, from its centre of mass")
    axes.quiver(*ends.T, *arrows.T, color=style.ORANGE, linewidth=1.6, arrow_length_ratio=0.25, zorder=5)
    axes.plot([], [], color=style.ORANGE, label="motion of its points, enlarged")
    axes.plot(*centre[:, None], "o", color=style.BLUE, markersize=5, zorder=6, label="centre of mass")
    frequency = float(found.frequencies[mode])
    axes.set_title(f"{mode + 1}: " + (f"{frequency:.3g} Hz" if frequency >= 0 else "unstable"))


def _shares(axes: Axes, found: Modes, mode: int) -> None:
    """Draw the shares of energy as bars."""
    names = FREEDOMS[: len(found.frequencies)]
    shares = 100.0 * found.participation[:, mode]
    colours = [style.ORANGE if k == found.dominant[mode] else style.GREY for k in range(len(names))]
    axes.bar(names, shares, color=colours, width=0.7)
    axes.set(ylim=(0, 100), yticks=(0, 50, 100))
    axes.grid(visible=False, axis="x")
    axes.set_ylabel("% of energy" if mode % 3 == 0 else "")


def _body(found: Modes) -> tuple[Array, Array]:
    """The centre of mass (3,) and the platform points (m, 3), world."""
    held = found.equilibrium
    platform = held.model.robot.platform
    if not isinstance(platform, RigidPlatform):
        return held.pose, held.platform_points
    return placed(held.pose, [platform.centre_of_mass])[0], held.platform_points


def _motion(found: Modes, mode: int, points: Array) -> Array:
    """Motion (k, 3) of points of the platform, world."""
    shape, pose = found.shapes[:, mode], found.equilibrium.pose
    moved = np.broadcast_to(shape[:3], points.shape)
    if len(shape) == 6:
        moved = moved + np.cross(shape[3:], points - pose[:3])
    return np.asarray(moved)


def _room(found: Modes, points: Array) -> tuple[Array, Array]:
    """Lowest and highest corner (3,) of what is shown."""
    scene: Any = found.equilibrium.model.robot.scene
    frame = float(np.max(np.subtract(scene.frame_max, scene.frame_min)))
    low, high = points.min(axis=0), points.max(axis=0)
    around = _ROOM * max(float((high - low).max()), _MIN_ROOM * frame)
    return low - around, high + around
