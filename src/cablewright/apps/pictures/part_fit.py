"""Pictures of a part in the volume that the nozzle reaches, and of the reach from above."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from cablewright.apps import style
from cablewright.apps.space_axes import add_faces, bounds, draw_frame, frame_points, space
from cablewright.foundation.arrays import Array
from cablewright.studies.part_fit import Fit


def fit_picture(found: Fit) -> Figure:
    """Draw the volume that the nozzle reaches with the part in it, and the reach over the part's height from above."""
    drawn = style.figure(10.4, 5.8)
    grid = drawn.add_gridspec(1, 2, width_ratios=(1.2, 1.0))
    low, high = bounds(*frame_points(found.robot), found.placed)
    axes, _ = space(drawn, grid[0, 0], low, high, "m")
    draw_frame(axes, found.robot)
    add_faces(axes, _surface(found), style.BLUE, zorder=3, alpha=0.16, width=0.0)
    axes.scatter(*found.placed.T, s=2, c=style.RED, depthshade=False, zorder=6, label="part")
    axes.set_title("reach of the nozzle, and the part")
    _from_above(drawn.add_subplot(grid[0, 1]), found)
    size = "fits as it is" if found.fits else "is drawn at its largest scale"
    drawn.suptitle(f"largest scale {found.scale:.3g}: the part {size}", fontsize=10)
    return drawn


def _from_above(axes: Any, found: Fit) -> None:
    """Draw where the nozzle reaches at all heights of the part, or of a plane the reach itself, and the part."""
    x, y, z = found.reach.axes
    turn = found.reach.directions.T
    across = (0, 1) if len(y) > 1 else (0, 2)
    names = ("x", "xyz"[across[1]]) if (turn == np.eye(3)).all() else ("to the right", "up the plane")
    if len(y) > 1:
        free = found.reach.up_to(float(found.placed[:, 2].min()), float(found.placed[:, 2].max()))
        side, words = y, "at all heights of the part"
    else:
        free, side, words = found.reach.cells[:, 0, :], z, "in the plane"
    axes.pcolormesh(x, side, np.where(free, 1.0, np.nan).T, cmap=ListedColormap([style.BLUE]), alpha=0.25, zorder=1)
    axes.plot(*(found.placed @ turn)[:, list(across)].T, ".", markersize=2, color=style.RED)
    for line in found.robot.lines:
        axes.plot(*(np.array(line.exit_point) @ turn)[list(across)], "s", color=style.INK, markersize=4)
    axes.set_aspect("equal")
    axes.margins(0.04)
    axes.set(xlabel=f"{names[0]} in m", ylabel=f"{names[1]} in m", title=f"reach {words}")


def _surface(found: Fit) -> Array:
    """Return the faces (F, 4, 3), m, between cells that hold and cells that do not; of a plane its cells."""
    cells = np.pad(found.reach.cells, 1).astype(np.int8)
    flat = [k for k, axis in enumerate(found.reach.axes) if len(axis) == 1]
    ends = [np.resize(axis, max(len(axis), 2)) for axis in found.reach.axes]
    faces = []
    for k in flat or range(3):
        a, b = (j for j in range(3) if j != k)
        for index in np.argwhere(np.diff(cells, axis=k) != 0):
            corner = index - 1
            corner[k] += 1
            square = []
            for da, db in ((0, 0), (1, 0), (1, 1), (0, 1)):
                at = corner.copy()
                at[a] += da
                at[b] += db
                square.append([ends[j][at[j]] for j in range(3)])
            faces.append(square)
    return np.array(faces).reshape(-1, 4, 3) @ found.reach.directions
