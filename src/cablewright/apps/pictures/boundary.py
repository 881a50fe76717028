"""Frequencies along the boundary of a workspace, and which way the platform swings there (Jung 2020, Fig. 12)."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec

from cablewright.analyses.modes import FREEDOMS
from cablewright.analyses.workspace.boundary_modes import Boundary
from cablewright.apps import style
from cablewright.apps.space_axes import draw_frame, space

_OF_FREEDOMS: Final = (style.BLUE, style.GREEN, style.INK, "#56b4e9", "#cc79a7", style.ORANGE)


def boundary_picture(found: Boundary) -> Figure:
    """Draw the places by their lowest frequency, and by the freedom of that mode. Call within `style.drawing`."""
    drawn = style.figure(10.4, 5.2)
    grid = drawn.add_gridspec(1, 2)
    places = np.tile(found.places, (len(found.nodes.criterion.orientations), 1))[found.known]
    lowest = found.lowest[found.known]
    left = _frame(drawn, grid[0, 0], found)
    colours = {"cmap": style.error_colours().reversed(), "norm": Normalize(*found.spread[::2])}
    shown = left.scatter(*places.T, c=lowest, s=9, depthshade=False, **colours)
    bar = drawn.colorbar(shown, ax=left, shrink=0.6, pad=0.02)
    bar.set_label("lowest frequency in Hz")
    bar.outline.set_visible(False)
    left.set_title("lowest frequency")
    right = _frame(drawn, grid[0, 1], found)
    named = found.modes.dominant[found.known, 0]
    for k, (name, colour) in enumerate(zip(FREEDOMS, _OF_FREEDOMS, strict=True)):
        chosen = named == k
        if chosen.any():
            told = f"{name}, {100.0 * chosen.mean():.0f} %"
            right.scatter(*places[chosen].T, color=colour, s=9, depthshade=False, label=told)
    right.legend(loc="upper center", bbox_to_anchor=(0.5, -0.02), ncols=3, markerscale=2.0)
    right.set_title("what the lowest mode mostly is")
    drawn.suptitle(_title(found), x=0.01, ha="left", fontsize=11, fontweight="bold")
    return drawn


def _frame(drawn: Figure, where: SubplotSpec, found: Boundary) -> Any:
    robot, box = found.nodes.criterion.model.robot, found.nodes.box
    exits = [line.exit_point for line in robot.lines]
    ends = np.vstack([robot.scene.frame_min, robot.scene.frame_max, exits, box.low, box.high])
    axes, _ = space(drawn, where, ends.min(axis=0), ends.max(axis=0), "m")
    draw_frame(axes, robot)
    return axes


def _title(found: Boundary) -> str:
    criterion, (lowest, median, greatest) = found.nodes.criterion, found.spread
    name = style.label(criterion.model.robot.name)
    told = f"{name}, boundary by {criterion.name}: {lowest:.3g} to {greatest:.3g} Hz, "
    told += f"median {median:.3g} Hz" + ("" if found.modes.geometric else ", without geometric stiffness")
    return told.replace("-", "\N{MINUS SIGN}") if lowest < 0.0 else told
