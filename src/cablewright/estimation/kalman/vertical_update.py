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
    heights_of,
    level_sigma,
    mean_height,
    moved,
    places_of,
    range_sigma,
    turn_of,
)
from cablewright.foundation.arrays import Mask
from cablewright.foundation.signals import Scan

_RINGS: Final = {
    "aside": (35.0, CONE),
    "below": (0.0, 35.0),
}  # degrees from the axis: two parts of the floor
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
    attitudes, motion = state.turns.attitudes.at(scan.times), state.motion_since(scan.times)
    turn = turn_of(state, height, scan, attitudes, motion)
    over = height_over_structure(height, scan, attitudes[:, 1:])
    if math.isfinite(over):
        state.clearance_offset = over - float((state.motion.position - motion.displacement[len(attitudes) // 2])[2])
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
    before = level_sigma(state)
    floors = [floor for ring in _RINGS if (floor := _floor_in(settings, state, height, turn, ring, before)) is not None]
    sentence = "its floor is not at the expected height: not used"
    accepted = refused = trusted = False
    for floor in sorted(floors, key=lambda floor: abs(floor.over)):
        over = float(heights_of(state, height, turn)[floor.good].mean())
        H, R = mean_height(settings, state, height, turn, floor.good)
        if over > 0.0 and not floor.most:  # it may be no floor
            if over**2 > GATE**2 * float((H @ state.P @ H.T + R)[0, 0]):
                continue
            R += (_MINORITY_FACTOR * over) ** 2
        innovation = np.array([-over])
        sank = floor.most and not accepted and _was_floor(state, turn, floor)
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


def _was_floor(state: FilterState, turn: VerticalTurn, floor: _Floor) -> bool:
    """Whether most points of a *floor* were floor just now."""
    were = state.built.ground_map.was_floor(places_of(state, turn, floor.good))
    return int(np.count_nonzero(were)) >= FLOOR_MAJORITY * len(were)


def _floor_in(
    settings: FilterSettings, state: FilterState, height: HeightSettings, turn: VerticalTurn, name: str, sigma: float
) -> _Floor | None:
    """Return what may be the floor in a ring of a *turn*, by a height known to *sigma*, m; None: too little."""
    low, high = _RINGS[name]
    ring = (turn.axis_cosine <= math.cos(math.radians(low))) & (turn.axis_cosine > math.cos(math.radians(high)))
    heights, good = heights_of(state, height, turn), ring.copy()
    possible = np.where(state.built.ground_map.may_be_floor(places_of(state, turn, ring)), heights[ring], np.inf)
    band, ceiling = GATE * range_sigma(settings, height) * turn.axis_cosine[ring], _FLOOR_BAND + GATE * sigma
    good[ring] = floor_points(height, turn.points[ring], possible, band, _MIN_SHARE, ceiling)
    count = int(np.count_nonzero(good))
    if count < 2 * _MIN_POINTS:
        return None
    over = float(heights[good].mean())
    return _Floor(f"height {name}", good, over, count >= FLOOR_MAJORITY * int(np.count_nonzero(ring)))


def _update_walls(settings: FilterSettings, state: FilterState, height: HeightSettings, turn: VerticalTurn) -> None:
    """Update by the points near each expected wall."""
    flat = np.flatnonzero(turn.axis_cosine < _WALL_COSINE)
    rays, points, beams = turn.rays[flat], turn.points[flat], turn.beams[flat]
    rotation, coasting_times, gyro_time = turn.rotation[flat], turn.coasting_time[flat], turn.gyro_time[flat]
    counted_time = turn.counted_time[flat]
    lay, sigma = state.layout, range_sigma(settings, height)
    c, s = np.cos(turn.yaw[flat]), np.sin(turn.yaw[flat])
    above = turn.position[flat, 2] + points[:, 2] > height.floor + _WALL_HEIGHT
    for j, wall in enumerate(settings.machine.walls.room.walls):
        position = turn.position[flat] + moved(state, turn)
        n, along = np.array(wall.normal), np.array(wall.along)
        wall_off, wall_turn = state.built.wall_errors[j].tolist()
        ahead, left = n[0] * c + n[1] * s, n[1] * c - n[0] * s  # the normal along the drum's axes
        steep = ahead * rays[:, 0] + left * rays[:, 1]
        across = ahead * points[:, 0] + left * points[:, 1]
        sideways = (along[0] * c + along[1] * s) * points[:, 0] + (along[1] * c - along[0] * s) * points[:, 1]
        from_reference = position[:, :2] @ along + sideways - wall.reference
        off = position[:, :2] @ n + across - wall.distance - wall_off + wall_turn * from_reference
        off -= float(state.built.range_bias[-1]) * steep
        good = above & (steep > 0.5) & (np.abs(off) < _WALL_BAND)
        if np.count_nonzero(good) >= _MIN_POINTS:
            good &= np.abs(off - np.median(off[good])) < GATE * sigma
        count = int(np.count_nonzero(good))
        if count < _MIN_POINTS:
            continue
        x, y, z = points[good].mean(axis=0).tolist()
        a, b = float(ahead[good].mean()), float(left[good].mean())
        H = np.zeros((1, lay.size))
        H[0, lay.position][:2] = n
        H[0, lay.radii] = -(n @ state.hung.jacobian[:2]) * state.lines.radii * rotation[good].mean(axis=0)
        coasting_time = float(coasting_times[good].mean())
        H[0, lay.velocity][:2] = -n * coasting_time
        H[0, lay.stretch] = -(n @ state.hung.jacobian[:2]) * counted_time[good].mean()
        H[0, lay.attitude] = -b * z, a * z, b * x - a * y
        H[0, lay.gyro_bias] = gyro_time[good].mean() * H[0, lay.attitude]
        H[0, lay.range_bias.stop - 1] = -float(steep[good].mean())
        bx, by, bz = beams[good].mean(axis=0).tolist()
        H[0, lay.vertical_mount] = a, b, 0.0, -b * bz, a * bz, b * bx - a * by
        H[0, lay.walls.start + 2 * j] = -1.0
        H[0, lay.walls.start + 2 * j + 1] = float(from_reference[good].mean())
        H[0, lay.clock] = -float(n @ moving_velocity(state)[:2])
        own = settings.wall_sigma**2 + coasting_variance(settings, coasting_time)
        R = noise_factor(state) * np.array([[sigma**2 / count + own]])
        innovation = np.array([-float(off[good].mean())])
        gated_update(state, f"vertical {wall.name}", H, innovation, R, ("vertical", "wall"), "")
