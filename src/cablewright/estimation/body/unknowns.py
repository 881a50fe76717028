"""The unknown numbers of the machine, and what they do to the lengths of its lines.

Of each line: error of its home length, share of its drum's radius, error of its exit point, gain and zero of its load
cell, zero of its swivel. Of all: turn of the inertial unit, and a wrench for a platform of another mass and centre. All
are constant, so that the filter has no motion to predict: the pose is that of the equilibrium of the corrected lengths.
Only the length by which cable lies unevenly on a drum changes, with the cable that is wound.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from cablewright.arrays import Array
from cablewright.estimation.body.settings import BodySettings


class Layout:
    """Places of the unknowns in the state, for *m* lines: slices."""

    def __init__(self, m: int) -> None:
        """Home lengths first, then radii, exit points by line, uneven lengths, gains, zeros, tilt, load, swivels."""
        bounds = np.cumsum([0, m, m, 3 * m, m, m, m, 2, 6, m]).tolist()
        parts = [slice(low, high) for low, high in pairwise(bounds)]
        self.home, self.radius, self.exit, self.uneven, self.gain, self.zero, self.tilt, self.load, self.swivel = parts
        self.m, self.size = m, bounds[-1]


def prior(settings: BodySettings, layout: Layout) -> Array:
    """Return the variances (size,) of the unknowns before any measurement."""
    told, platform = settings.deviations, settings.model.robot.platform
    weight = platform.mass * settings.model.robot.scene.gravity
    variances = np.zeros(layout.size)
    variances[layout.home] = told.home_length**2
    variances[layout.radius] = told.drum_radius**2
    variances[layout.exit] = told.exit_point**2
    variances[layout.uneven] = told.uneven**2
    if settings.swivels is not None:
        variances[layout.swivel] = settings.swivels.zero**2
    if settings.cells is not None:
        variances[layout.gain], variances[layout.zero] = settings.cells.gain**2, settings.cells.zero**2
    if settings.tilt is not None:
        gravity = settings.model.robot.scene.gravity
        variances[layout.tilt] = settings.tilt.turn**2 + (settings.tilt.bias / gravity) ** 2
    variances[layout.load] = np.array([0.0, 0.0, told.mass, told.centre, told.centre, 0.0]) ** 2 * weight**2
    return variances


def length_gradients(layout: Layout, paid: Array, toward: Array, toward_home: Array) -> Array:
    """Return what the unknowns do to the lengths: (m, size), m per unit.

    *paid* (m,): m of cable since home. *toward*, *toward_home* (m, 3): directions of the lines now and at home, where
    an exit point's error was part of the home length.
    """
    m = layout.m
    found, lines = np.zeros((m, layout.size)), np.arange(m)
    found[lines, lines] = 1.0
    found[lines, layout.radius.start + lines] = paid
    found[lines, layout.uneven.start + lines] = 1.0
    columns = layout.exit.start + 3 * lines[:, None] + np.arange(3)
    found[lines[:, None], columns] = toward - toward_home
    return found


def wind(settings: BodySettings, layout: Layout, unknowns: Array, covariance: Array, wound: Array) -> None:
    """Let the uneven lengths change by the cable (m,), m, that was *wound*; the two arrays change in place."""
    told = settings.deviations
    keep = np.exp(-np.abs(wound) / told.uneven_length)
    own = layout.uneven
    unknowns[own] *= keep
    covariance[own] *= keep[:, None]
    covariance[:, own] *= keep
    places = np.arange(own.start, own.stop)
    covariance[places, places] += (1.0 - keep * keep) * told.uneven**2
