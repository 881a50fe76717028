"""Lowest frequencies along the boundary of a workspace, and which way the platform moves (Jung 2020, Fig. 12)."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from cablewright.analyses.modes import FREEDOMS
from cablewright.analyses.workspace.boundary_modes import Boundary
from cablewright.apps import style
from cablewright.apps.space_axes import machine

_OF_FREEDOMS: Final = (style.BLUE, style.GREEN, style.INK, style.SKY, style.PINK, style.ORANGE)


def boundary_picture(found: Boundary) -> Figure:
    """Draw the places by their lowest frequency, and by the freedom with most energy in that mode."""
    drawn = style.figure(10.4, 5.2)
    grid = drawn.add_gridspec(1, 2)
    places = np.tile(found.places, (len(found.nodes.criterion.orientations), 1))[found.known]
    lowest = found.lowest[found.known]
    robot, box = found.nodes.criterion.model.robot, found.nodes.box
    left, right = (machine(drawn, grid[0, k], robot, box.low, box.high) for k in (0, 1))
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
