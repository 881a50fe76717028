"""Update by the vertical lidar: distances of floor, ground and walls, which also show its range bias.

The bias is the same in every range, so it changes the height the less the farther aside the floor is measured; and it
changes the sum of the distances to two opposite walls, which is known.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from cablewright.arrays import Array, Mask
from cablewright.estimation.height import FLOOR_MAJORITY, HeightSettings, floor_points, height_over_structure, tilted
from cablewright.estimation.kalman.ground_map import FLOOR
from cablewright.estimation.kalman.lidar_update import gated_update, noise_factor
from cablewright.estimation.kalman.state import (
    FilterSettings,
    FilterState,
    MotionSince,
    inflate_position,
    moving_velocity,
    passes_gate,
    update_state,
)
from cablewright.signals import Scan

_RINGS: Final = {
    "aside": (35.0, 70.0),
    "below": (0.0, 35.0),
}  # degrees from the axis: two parts of the floor, the one more often free first
_WALL_COSINE: Final = math.cos(math.radians(60.0))  # rays farther from the axis meet walls
_WALL_HEIGHT: Final = 0.1  # m over the floor, from which points are taken for a wall's
_MIN_POINTS: Final = 8  # of a wall; twice as many of the floor
_GATE: Final = 3.0  # sigmas from the expected value, of points and heights
_MIN_SHARE: Final = 0.4  # of the points of the fullest level, for a level to be the floor
_WALL_BAND: Final = 0.03  # m from the expected wall, of its points
_MINORITY_FACTOR: Final = 3.0  # times its height over the expected floor: standard deviation of a doubtful floor
_REFUSALS: Final = 1  # turns before this one that refused a floor that is lower, or was one before, to believe it
_TRUSTED: Final = 3e-3  # m from the expected floor, of one that tells the heights of all ground in sight ...
_TRUSTED_SIGMA: Final = 1.5e-3  # m, of the height before: less than where ground alone tells it
_MIN_GROUND: Final = 40  # points on ground that was seen before
_GROUND_BAND: Final = 0.02  # m from the median, of points on such ground: cells are coarse, and some lie on flanks
_GROUND_REACH: Final = 0.03  # m, of their median, besides the uncertainty of the height
_LAID_SIGMA: Final = 2e-3  # m, of their mean, by what was laid since
_LOWEST: Final = -0.1  # m over the floor, of points that are seen on the ground
_FLOOR_BAND: Final = 0.01  # m from the expected floor, besides the uncertainty of the height


class VerticalTurn(NamedTuple):
    """The rays of one turn that came back, and the pose of the drum at each."""

    ranges: Array  # (k,) m
    axis_cosine: Array  # (k,) cosine of each ray's angle from the drum's axis, downwards
    rays: Array  # (k, 3) unit, level, along the drum's axes
    points: Array  # (k, 3) m from B, level, along the drum's axes
    beams: Array  # (k, 3) m from the lidar, likewise
    yaw: Array  # (k,) rad
    gyro_time: Array  # (k,) s over which the gyro is integrated since
    rotation: Array  # (k, m) rad, of the winch drums since
    coasting_time: Array  # (k,) s without encoders since ...
    counted_time: Array  # (k,) ... and with them
    position: Array  # (k, 3) m, world, of B, by the estimate at ...
    estimate: Array  # ... (3,) m


def update(settings: FilterSettings, state: FilterState, scan: Scan) -> None:
    """Update by one turn of the vertical lidar."""
    height = settings.machine.height
    if height is None:
        return
    attitudes, motion = state.attitude_history.at(scan.times), state.motion_since(scan.times)
    turn = _turn(state, height, scan, attitudes, motion)
    over = height_over_structure(height, scan, attitudes[:, 1:])
    if math.isfinite(over):
        state.clearance_offset = over - float((state.position - motion.displacement[len(attitudes) // 2])[2])
    _update_floor(settings, state, height, turn)
    _update_walls(settings, state, height, turn)


def _turn(
    state: FilterState, height: HeightSettings, scan: Scan, attitudes: Array, motion: MotionSince
) -> VerticalTurn:
    x, y = np.array(height.axes)
    good = np.flatnonzero(np.isfinite(scan.ranges) & (scan.ranges > 0.0))
    angles = scan.angles[good]
    straight = np.cos(angles)[:, None] * x + np.sin(angles)[:, None] * y
    tilts, ranges = attitudes[good, 1:], scan.ranges[good]
    rays = tilted(straight, tilts)
    place, turn = state.vertical_mount_error[:3], state.vertical_mount_error[3:]
    rays = rays + np.cross(turn, rays)
    beams = ranges[:, None] * rays
    arms = tilted(np.broadcast_to(height.mount + place, rays.shape), tilts)
    yaw = state.yaw - state.gyro_yaw + attitudes[good, 0]
    gyro_time = state.last_imu_time - scan.times[good]
    return VerticalTurn(
        ranges,
        -straight[:, 2],
        rays,
        arms + beams,
        beams,
        yaw,
        gyro_time,
        motion.rotation[good],
        motion.coasting_time[good],
        state.last_encoder_time - scan.times[good] - motion.coasting_time[good],
        state.position - motion.displacement[good],
        state.position,
    )


def _moved(state: FilterState, turn: VerticalTurn) -> Array:
    """By how much (3,), m, updates and the drum's clock have moved B's place at the rays of a *turn*."""
    return state.position - turn.estimate - state.clock_error * moving_velocity(state)


def _update_floor(settings: FilterSettings, state: FilterState, height: HeightSettings, turn: VerticalTurn) -> None:
    """Update by the points near the expected floor, in two rings: below and aside, where the bias counts less.

    What was seen of the ground before tells what is no floor, and the height where none is in sight.
    """
    sigma, before = height.sigma or settings.height_bias_sigma, _level_sigma(state)
    band = _FLOOR_BAND + _GATE * before
    seen, trusted = False, False
    for ring, (low, high) in _RINGS.items():
        heights = _heights(state, height, turn)
        inside = (turn.axis_cosine <= math.cos(math.radians(low))) & (turn.axis_cosine > math.cos(math.radians(high)))
        good = inside.copy()
        good[inside] = floor_points(
            height, turn.points[inside], heights[inside], _GATE * sigma * turn.axis_cosine[inside], _MIN_SHARE, band
        )
        count = int(np.count_nonzero(good))
        if count < 2 * _MIN_POINTS:
            continue
        over, is_floor = float(heights[good].mean()), _is_floor(state, turn, good)
        if is_floor is False and over > 0.0:
            continue
        most = count >= FLOOR_MAJORITY * int(np.count_nonzero(inside))
        H, R = _level(settings, state, height, turn, good)
        if over > 0.0 and not most:  # it may be no floor
            if over**2 > _GATE**2 * float((H @ state.P @ H.T + R)[0, 0]):
                continue
            R += (_MINORITY_FACTOR * over) ** 2
        what, innovation = f"height {ring}", np.array([-over])
        if over < 0.0 or (most and is_floor):  # nothing is below a floor
            refusals = state.rejections.get(what, 0)
            if refusals >= _REFUSALS and not passes_gate(state.P, H, innovation, R)[0]:
                inflate_position(state, [0.0, 0.0, over])
        seen, sentence = True, "its floor is not at the expected height: not used"
        if gated_update(state, what, H, innovation, R, ("vertical", "gate"), sentence):
            trusted |= before < _TRUSTED_SIGMA and abs(over) < _TRUSTED
    if seen:
        state.monitor.clear("vertical", "floor")
    else:
        state.monitor.report("vertical", "floor", "no floor in sight near the expected height")
    if trusted:
        _remember_ground(state, height, turn)
    else:
        _update_by_ground(settings, state, height, turn)


def _level_sigma(state: FilterState) -> float:
    """Standard deviation, m, of what a ray straight down adds up: height, range bias and mount."""
    lay = state.layout
    below = [lay.position.start + 2, lay.range_bias.stop - 1, lay.vertical_mount.start + 2]
    return math.sqrt(max(0.0, float(state.P[np.ix_(below, below)].sum())))


def _heights(state: FilterState, height: HeightSettings, turn: VerticalTurn) -> Array:
    """Heights (k,), m, of the points of a *turn* over the floor."""
    place = turn.position + _moved(state, turn)
    return np.asarray(place[:, 2] + turn.points[:, 2] - height.floor - float(state.range_bias[-1]) * turn.rays[:, 2])


def _level(
    settings: FilterSettings, state: FilterState, height: HeightSettings, turn: VerticalTurn, good: Mask
) -> tuple[Array, Array]:
    """Jacobian (1, n) of the mean height, m, of the *good* points, and the variance (1, 1), m^2, of its noise."""
    lay, sigma = state.layout, height.sigma or settings.height_bias_sigma
    x, y, _ = turn.points[good].mean(axis=0).tolist()
    steep = turn.rays[good, 2]
    H = np.zeros((1, lay.size))
    H[0, lay.position][2] = 1.0
    H[0, lay.radii] = -state.jacobian[2] * state.radii * turn.rotation[good].mean(axis=0)
    coasting_time = float(turn.coasting_time[good].mean())
    H[0, lay.velocity][2] = -coasting_time
    H[0, lay.stretch] = -state.jacobian[2] * turn.counted_time[good].mean()
    H[0, lay.attitude] = y, -x, 0.0
    H[0, lay.gyro_bias] = turn.gyro_time[good].mean() * H[0, lay.attitude]
    H[0, lay.range_bias.stop - 1] = -float(steep.mean())
    bx, by, _ = turn.beams[good].mean(axis=0).tolist()
    H[0, lay.vertical_mount] = 0.0, 0.0, 1.0, by, -bx, 0.0
    H[0, lay.clock] = -float(moving_velocity(state)[2])
    own = settings.height_sigma**2 + _coasting_variance(settings, coasting_time)
    R = noise_factor(state) * np.array([[sigma**2 * float(steep @ steep) / len(steep) ** 2 + own]])
    return H, R


def _places(state: FilterState, turn: VerticalTurn, chosen: Mask) -> Array:
    """Places (j, 2), m, world, of the *chosen* points (k,) of a *turn*, j of them."""
    c, s = np.cos(turn.yaw[chosen]), np.sin(turn.yaw[chosen])
    x, y, _ = turn.points[chosen].T
    away = np.stack([c * x - s * y, s * x + c * y], axis=1)
    return np.asarray((turn.position[chosen] + _moved(state, turn))[:, :2] + away)


def _ground_points(state: FilterState, height: HeightSettings, turn: VerticalTurn) -> tuple[Mask, Array]:
    """Which points (k,) of a *turn* are near enough to tell heights of the ground, and these (j,), m over the floor."""
    heights = _heights(state, height, turn)
    near = (turn.axis_cosine > math.cos(math.radians(_RINGS["aside"][1]))) & (heights > _LOWEST)
    return near, heights[near]


def _remember_ground(state: FilterState, height: HeightSettings, turn: VerticalTurn) -> None:
    """Remember the ground of a *turn* in which the floor was in sight."""
    near, heights = _ground_points(state, height, turn)
    state.ground_map.write(_places(state, turn, near), heights, state.time)


def _is_floor(state: FilterState, turn: VerticalTurn, level: Mask) -> bool | None:
    """Whether the points of a *level* (k,) were floor when they were seen before; None: most were not seen."""
    expected, known = state.ground_map.at(_places(state, turn, level), state.time)
    if np.count_nonzero(known) < 0.5 * len(known):
        return None
    return float(np.median(expected[known])) < FLOOR


def _known_ground(state: FilterState, height: HeightSettings, turn: VerticalTurn) -> tuple[Mask, float] | None:
    """Points (k,) of a *turn* whose ground was seen before, and how far over it they are on average, m; None: too few.

    Of these at least half are about equally far over it, and not very far: the others are of what has come or gone.
    """
    near, heights = _ground_points(state, height, turn)
    expected, known = state.ground_map.at(_places(state, turn, near), state.time)
    if np.count_nonzero(known) < _MIN_GROUND:
        return None
    over = heights - expected
    middle = float(np.median(over[known]))
    same = known & (np.abs(over - middle) < _GROUND_BAND)
    too_far = abs(middle) > _GROUND_REACH + _GATE * _level_sigma(state)
    if too_far or np.count_nonzero(same) < 0.5 * np.count_nonzero(known):
        return None
    chosen = near.copy()
    chosen[near] = same
    return chosen, float(over[same].mean())


def _update_by_ground(settings: FilterSettings, state: FilterState, height: HeightSettings, turn: VerticalTurn) -> None:
    """Update by the ground that was seen before, where no floor tells the height.

    It is known no better than to what was laid since, however often it is seen, and never believed against the state.
    """
    found = _known_ground(state, height, turn)
    if found is None:
        return
    good, over = found
    H, R = _level(settings, state, height, turn, good)
    R, innovation = R + _LAID_SIGMA**2, np.array([-over])
    if not passes_gate(state.P, H, innovation, R)[0]:
        return
    update_state(state, "vertical", H, innovation, R)
    lost = _LAID_SIGMA**2 - float((H @ state.P @ H.T)[0, 0])
    if lost > 0.0:
        inflate_position(state, [0.0, 0.0, math.sqrt(lost)])


def _update_walls(settings: FilterSettings, state: FilterState, height: HeightSettings, turn: VerticalTurn) -> None:
    """Update by the points near each expected wall."""
    flat = np.flatnonzero(turn.axis_cosine < _WALL_COSINE)
    rays, points, beams = turn.rays[flat], turn.points[flat], turn.beams[flat]
    rotation, coasting_times, gyro_time = turn.rotation[flat], turn.coasting_time[flat], turn.gyro_time[flat]
    counted_time = turn.counted_time[flat]
    lay, sigma = state.layout, height.sigma or settings.height_bias_sigma
    c, s = np.cos(turn.yaw[flat]), np.sin(turn.yaw[flat])
    above = turn.position[flat, 2] + points[:, 2] > height.floor + _WALL_HEIGHT
    for j, wall in enumerate(settings.machine.walls.room.walls):
        position = turn.position[flat] + _moved(state, turn)
        n, along = np.array(wall.normal), np.array(wall.along)
        wall_off, wall_turn = state.wall_errors[j].tolist()
        ahead, left = n[0] * c + n[1] * s, n[1] * c - n[0] * s  # the normal along the drum's axes
        steep = ahead * rays[:, 0] + left * rays[:, 1]
        across = ahead * points[:, 0] + left * points[:, 1]
        sideways = (along[0] * c + along[1] * s) * points[:, 0] + (along[1] * c - along[0] * s) * points[:, 1]
        from_reference = position[:, :2] @ along + sideways - wall.reference
        off = position[:, :2] @ n + across - wall.distance - wall_off + wall_turn * from_reference
        off -= float(state.range_bias[-1]) * steep
        good = above & (steep > 0.5) & (np.abs(off) < _WALL_BAND)
        if np.count_nonzero(good) >= _MIN_POINTS:
            good &= np.abs(off - np.median(off[good])) < _GATE * sigma
        count = int(np.count_nonzero(good))
        if count < _MIN_POINTS:
            continue
        x, y, z = points[good].mean(axis=0).tolist()
        a, b = float(ahead[good].mean()), float(left[good].mean())
        H = np.zeros((1, lay.size))
        H[0, lay.position][:2] = n
        H[0, lay.radii] = -(n @ state.jacobian[:2]) * state.radii * rotation[good].mean(axis=0)
        coasting_time = float(coasting_times[good].mean())
        H[0, lay.velocity][:2] = -n * coasting_time
        H[0, lay.stretch] = -(n @ state.jacobian[:2]) * counted_time[good].mean()
        H[0, lay.attitude] = -b * z, a * z, b * x - a * y
        H[0, lay.gyro_bias] = gyro_time[good].mean() * H[0, lay.attitude]
        H[0, lay.range_bias.stop - 1] = -float(steep[good].mean())
        bx, by, bz = beams[good].mean(axis=0).tolist()
        H[0, lay.vertical_mount] = a, b, 0.0, -b * bz, a * bz, b * bx - a * by
        H[0, lay.walls.start + 2 * j] = -1.0
        H[0, lay.walls.start + 2 * j + 1] = float(from_reference[good].mean())
        H[0, lay.clock] = -float(n @ moving_velocity(state)[:2])
        own = settings.wall_sigma**2 + _coasting_variance(settings, coasting_time)
        R = noise_factor(state) * np.array([[sigma**2 / count + own]])
        innovation = np.array([-float(off[good].mean())])
        gated_update(state, f"vertical {wall.name}", H, innovation, R, ("vertical", "wall"), "")


def _coasting_variance(settings: FilterSettings, coasting_time: float) -> float:
    """Variance, m^2, of B's position after a prediction without encoders over *coasting_time*, s."""
    return settings.velocity_noise**2 * coasting_time**3
