"""Filter update by the vertical lidar: distances of floor, ground and walls, and its range bias.

The bias is the same in every range, so it changes the height the less the farther aside the floor is measured; and it
changes the sum of the distances to two opposite walls, which is known.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from cablewright.estimation.height import FLOOR_MAJORITY, HeightSettings, floor_points, height_over_structure
from cablewright.estimation.kalman.ground_update import remember_ground, update_by_ground
from cablewright.estimation.kalman.lidar_update import gated_update, noise_factor
from cablewright.estimation.kalman.settings import FilterSettings
from cablewright.estimation.kalman.state import FilterState, inflate_position, moving_velocity, passes_gate
from cablewright.estimation.kalman.vertical_scan import (
    CONE,
    GATE,
    VerticalTurn,
    coasting_variance,
    level_sigma,
    located,
    mean_height,
    range_sigma,
    turn_of,
)
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.signals import Scan
from cablewright.kernels.filtering import vertical_turn as kernel

_RINGS: Final = {
    "aside": (math.cos(math.radians(35.0)), math.cos(math.radians(CONE))),
    "below": (1.0, math.cos(math.radians(35.0))),
}  # two parts of the floor, by cosines of angles from the axis
_WALL_COSINE: Final = math.cos(math.radians(60.0))  # rays farther from the axis meet walls
_WALL_HEIGHT: Final = 0.1  # m over the floor, from which points are taken for a wall's
_MIN_POINTS: Final = 8  # of a wall; twice as many of the floor
_MIN_SHARE: Final = 0.4  # of the points of the fullest level, for a level to be the floor
_WALL_BAND: Final = 0.03  # m from the expected wall, of its points
_MINORITY_FACTOR: Final = 3.0  # times its height over the expected floor: standard deviation of a doubtful floor
_REFUSALS: Final = 1  # turns before this one that rejected a floor that is lower, or was one before, to believe it
_TRUSTED: Final = 3e-3  # m from the expected floor, of one that is a reference for all ground in sight ...
_TRUSTED_SIGMA: Final = 1.5e-3  # m, of the height before: less than with ground alone
_FLOOR_BAND: Final = 0.01  # m from the expected floor, besides the uncertainty of the height


def update(settings: FilterSettings, state: FilterState, scan: Scan) -> None:
    """Update the filter by one scan of the vertical lidar."""
    height = settings.machine.height
    if height is None:
        return
    times = scan.times
    attitudes, motion = state.turns.attitudes.at(times), state.motion_since(times)
    turn = turn_of(state, height, scan, attitudes, motion)
    over = height_over_structure(height, scan, attitudes[:, 1:])
    if math.isfinite(over):
        state.clearance_offset = over - float((state.motion.position - motion.displacement[len(times) // 2])[2])
    _update_floor(settings, state, height, turn)
    _update_walls(settings, state, height, turn)


class _Floor(NamedTuple):
    """What may be the floor in one ring."""

    what: str
    good: Mask  # (k,) points of the turn
    over: float  # m, their mean height over the expected floor
    most: bool  # of the points in the ring


def _update_floor(settings: FilterSettings, state: FilterState, height: HeightSettings, turn: VerticalTurn) -> None:
    """Update by the points near the expected floor, in two rings: below and aside, where the bias counts less.

    Earlier scans of the ground show which points are no floor, and give the height where none is in sight.
    """
    before, (places, heights) = level_sigma(state), located(state, height, turn)
    ground, scatter = state.built.ground_map.at(places), GATE * range_sigma(settings, height)
    floors = [
        floor
        for ring in _RINGS
        if (floor := _floor_in(height, turn, heights, ground.may_be_floor, ring, scatter, before)) is not None
    ]
    sentence = "its floor is not at the expected height: not used"
    accepted = refused = trusted = False
    for floor in sorted(floors, key=lambda floor: abs(floor.over)):
        over, H, R = mean_height(settings, state, height, turn, floor.good)
        if over > 0.0 and not floor.most:  # it may be no floor
            if over**2 > GATE**2 * float((H @ state.P @ H.T + R)[0, 0]):
                continue
            R += (_MINORITY_FACTOR * over) ** 2
        innovation = np.array([-over])
        were = ground.was_floor[floor.good]
        sank = floor.most and not accepted and int(np.count_nonzero(were)) >= FLOOR_MAJORITY * len(were)
        if over < 0.0 or sank:  # nothing is below a floor
            refusals = state.judged.rejections.get(floor.what, 0)
            if refusals >= _REFUSALS and not passes_gate(state.P, H, innovation, R)[0]:
                inflate_position(state, [0.0, 0.0, over])
        if not gated_update(state, floor.what, H, innovation, R, ("vertical", "gate"), sentence):
            refused = True
            continue
        accepted = True
        trusted |= before < _TRUSTED_SIGMA and abs(over) < _TRUSTED
    if accepted or refused:
        state.monitor.clear("vertical", "floor")
    else:
        state.monitor.report("vertical", "floor", "no floor in sight near the expected height")
    if trusted and not refused:
        remember_ground(state, height, turn)
    else:
        update_by_ground(settings, state, height, turn)


def _floor_in(
    height: HeightSettings, turn: VerticalTurn, heights: Array, may_be: Mask, name: str, scatter: float, sigma: float
) -> _Floor | None:
    """Return the points of a ring that may be floor; None for too few. *heights* (k,), m, of all, known to *sigma*, m.

    *may_be* (k,): points that may be floor, by earlier scans. *scatter*, m: of points of a level, along their rays.
    """
    (most, least), cosine, good = _RINGS[name], turn.rays[:, kernel.COSINE], np.zeros(len(heights), dtype=np.bool_)
    ring = np.flatnonzero((cosine <= most) & (cosine > least))
    along = turn.rays[ring, kernel.POINT : kernel.POINT + 2] @ height.heading
    possible = np.where(may_be[ring], heights[ring], np.inf)
    good[ring] = floor_points(possible, along, scatter * cosine[ring], _MIN_SHARE, _FLOOR_BAND + GATE * sigma)
    count = int(np.count_nonzero(good))
    if count < 2 * _MIN_POINTS:
        return None
    return _Floor(f"height {name}", good, float(heights[good].mean()), count >= FLOOR_MAJORITY * len(ring))


def _update_walls(settings: FilterSettings, state: FilterState, height: HeightSettings, turn: VerticalTurn) -> None:
    """Update by the points near each expected wall."""
    (x, layout, at), sigma, mean = state.mean, range_sigma(settings, height), np.empty(turn.rays.shape[1])
    rules = np.array([_WALL_COSINE, height.floor + _WALL_HEIGHT, _WALL_BAND, GATE * sigma, _MIN_POINTS])
    for j, wall in enumerate(settings.machine.walls.room.walls):
        numbers, H = np.array([*wall.normal, *wall.along, wall.reference, wall.distance]), np.empty((1, layout.size))
        count, beyond = kernel.write_wall(
            turn.rays, x, at, state.hung.jacobian, moving_velocity(state), turn.estimate, numbers, j, rules, mean, H[0]
        )
        if not count:
            continue
        own = settings.wall_sigma**2 + coasting_variance(settings, mean[kernel.COASTING_TIME])
        R = noise_factor(state) * np.array([[sigma**2 / count + own]])
        gated_update(state, f"vertical {wall.name}", H, np.array([-beyond]), R, ("vertical", "wall"), "")
