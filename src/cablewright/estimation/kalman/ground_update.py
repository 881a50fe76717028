"""Update of the filter's height by ground that the vertical lidar scanned before, where no floor is visible."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from cablewright.estimation.height import HeightSettings
from cablewright.estimation.kalman.settings import FilterSettings
from cablewright.estimation.kalman.state import FilterState, apply_update, passes_gate
from cablewright.estimation.kalman.vertical_scan import (
    CONE,
    GATE,
    VerticalTurn,
    level_sigma,
    located,
    mean_height,
)
from cablewright.foundation.arrays import Array, Mask
from cablewright.kernels.filtering.vertical_turn import COSINE

_CONE_COSINE: Final = math.cos(math.radians(CONE))
_MIN_GROUND: Final = 40  # points on ground that was seen before
_GROUND_BAND: Final = 0.02  # m from the median, of points on such ground: cells are coarse, and some lie on flanks
_GROUND_REACH: Final = 0.03  # m, of their median, besides the uncertainty of the height
_LAID_SIGMA: Final = 2e-3  # m, of their mean, by material laid since ...
_GROWTH_SHARE: Final = 0.3  # ... and a share of its expected height
_LOWEST: Final = -0.1  # m over the floor, of points that are seen on the ground


def remember_ground(state: FilterState, height: HeightSettings, turn: VerticalTurn) -> None:
    """Store the ground of a vertical *turn* (scan) in which the floor was visible."""
    _, places, heights = _ground_points(state, height, turn)
    state.built.ground_map.write(places, heights)


def _ground_points(state: FilterState, height: HeightSettings, turn: VerticalTurn) -> tuple[Mask, Array, Array]:
    """Points of a *turn* near enough to measure the ground: which of all (k,), their places (j, 2), heights (j,), m."""
    places, heights = located(state, height, turn)
    near = (turn.rays[:, COSINE] > _CONE_COSINE) & (heights > _LOWEST)
    return near, places[near], heights[near]


def _known_ground(
    state: FilterState, height: HeightSettings, turn: VerticalTurn, before: float
) -> tuple[Mask, float, float] | None:
    """Points (k,) of a *turn* whose ground was seen before, how far over it they are, m, and how sure it is, m.

    At least half of them are about equally far over it, and, by a height known to *before*, m, not very far: others are
    on objects that have come or gone. None: too few are.
    """
    near, places, heights = _ground_points(state, height, turn)
    expected = state.built.ground_map.at(places)
    known = expected.known
    if np.count_nonzero(known) < _MIN_GROUND:
        return None
    over = heights - expected.heights
    middle = float(np.median(over[known]))
    same = known & (np.abs(over - middle) < _GROUND_BAND)
    too_far = abs(middle) > _GROUND_REACH + GATE * before
    if too_far or np.count_nonzero(same) < 0.5 * np.count_nonzero(known):
        return None
    chosen = near.copy()
    chosen[near] = same
    grown = float(expected.may_have_grown[same].mean())
    return chosen, float(over[same].mean()), math.hypot(_LAID_SIGMA, _GROWTH_SHARE * grown)


def update_by_ground(settings: FilterSettings, state: FilterState, height: HeightSettings, turn: VerticalTurn) -> None:
    """Update the height by ground that was scanned before, where no floor is visible.

    Its errors are the same in each scan. So it is used where the state is less certain of the height than of the
    ground, never overrules the state, and corrects only B's position and the line lengths (Schmidt 1966).
    """
    before = level_sigma(state)
    found = None if before < _LAID_SIGMA else _known_ground(state, height, turn, before)
    if found is None:
        return
    good, over, sigma = found
    _, H, R = mean_height(settings, state, height, turn, good)
    innovation, variance = np.array([-over]), float((H @ state.P @ H.T)[0, 0])
    if variance <= sigma**2 or not passes_gate(state.P, H, innovation, R + sigma**2)[0]:
        return
    R += sigma**2 * variance / (variance - sigma**2)  # by which no more than that is claimed, however often it is used
    lay = state.layout
    apply_update(state, H, innovation, R, considered=np.r_[lay.velocity, lay.attitude, lay.radii.start : lay.size])
