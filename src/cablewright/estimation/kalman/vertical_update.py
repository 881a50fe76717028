"""What the vertical lidar tells the filter: how far the floor and the walls are, and so its own bias.

The bias lengthens a range to the floor by as much whatever its angle, and so the height the less the farther aside; and
of two walls that face each other it changes the sum of distances, which is known.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.estimation.height import MOSTLY, HeightSettings, floor_among, leaned, over_structure
from cablewright.estimation.kalman.lidar_update import doubt, measure
from cablewright.estimation.kalman.state import FilterSettings, FilterState, Since, add_unknown
from cablewright.signals import Scan

__all__ = ["vertical"]

Array = NDArray[np.float64]

_RINGS: Final = ((35.0, 70.0), (0.0, 35.0))  # degrees from the axis: two parts of the floor, the freer one first
_STEEP: Final = math.cos(math.radians(60.0))  # rays flatter than this meet walls
_OFF_FLOOR: Final = 0.1  # m over the floor, of points that are the walls'
_LEAST: Final = 8  # points of a wall, twice as many of the floor
_NEAR: Final = 3.0  # sigmas from the middle, of points that count
_MANY: Final = 0.4  # of the most that lie together, of points that are the floor
_WIDE: Final = 0.03  # m from where a wall is believed to be, of points that are looked at
_DOUBTFUL: Final = 3.0  # times that by which it is over where it should be: the floor's standard deviation
_BAND: Final = 0.01  # m likewise of the floor, besides what the height is uncertain by


class Turn(NamedTuple):
    """The rays of one turn that came back, where the drum was at each."""

    ranges: Array  # (k,) m
    down: Array  # (k,) cosine of each ray's angle from the drum's axis, downwards
    rays: Array  # (k, 3) unit, level, along the drum's axes
    points: Array  # (k, 3) m from B, likewise
    yaw: Array  # (k,) rad
    late: Array  # (k,) s from then to the last inertial reading
    turned: Array  # (k, m) rad that the winch drums turned since
    alone: Array  # (k,) s since without encoders
    place: Array  # (k, 3) m, world: B


def vertical(settings: FilterSettings, state: FilterState, scan: Scan) -> None:
    """Let one turn of the vertical lidar tell the height over the floor, and its bias."""
    height = settings.chain.height
    if height is None:
        return
    turning, since = state.turning.at(scan.times), state.since(scan.times)
    turn = _turn(state, height, scan, turning, since)
    over = over_structure(height, scan, turning[:, 1:])
    if math.isfinite(over):
        state.clearance_off = over - float((state.position - since.moved[len(turning) // 2])[2])
    _floor(settings, state, height, turn)
    _walls(settings, state, height, turn)


def _turn(state: FilterState, height: HeightSettings, scan: Scan, turning: Array, since: Since) -> Turn:
    x, y = np.array(height.axes)
    good = np.flatnonzero(np.isfinite(scan.ranges) & (scan.ranges > 0.0))
    angles = scan.angles[good]
    straight = np.cos(angles)[:, None] * x + np.sin(angles)[:, None] * y
    lean, ranges = turning[good, 1:], scan.ranges[good]
    rays = leaned(straight, lean)
    arms = leaned(np.broadcast_to(height.place, rays.shape), lean)
    place = state.position - since.moved[good]
    yaw = state.yaw - state.gyro_yaw + turning[good, 0]
    late = state.felt - scan.times[good]
    return Turn(
        ranges,
        -straight[:, 2],
        rays,
        arms + ranges[:, None] * rays,
        yaw,
        late,
        since.turned[good],
        since.alone[good],
        place,
    )


def _floor(settings: FilterSettings, state: FilterState, height: HeightSettings, turn: Turn) -> None:
    """Points near where the floor is believed to be, in two parts: below, and aside, where the bias counts less."""
    lay, sigma = state.layout, height.sigma or settings.height_bias
    unsure = math.sqrt(float(state.P[lay.position, lay.position][2, 2] + state.P[lay.bias, lay.bias][-1, -1]))
    up = turn.place[:, 2] + turn.points[:, 2] - height.floor - float(state.bias[-1]) * turn.rays[:, 2]
    band = _BAND + _NEAR * unsure
    heard = False
    for low, high in _RINGS:
        inside = (turn.down <= math.cos(math.radians(low))) & (turn.down > math.cos(math.radians(high)))
        good = inside.copy()
        good[inside] = floor_among(
            height, turn.points[inside], up[inside], _NEAR * sigma * turn.down[inside], _MANY, band
        )
        count = int(np.count_nonzero(good))
        if count < 2 * _LEAST:
            continue
        over = float(up[good].mean())
        if over < -band:  # however far below it may be: nothing is under a floor
            add_unknown(state, [0.0, 0.0, over])
        x, y, _ = turn.points[good].mean(axis=0).tolist()
        steep = turn.rays[good, 2]
        H = np.zeros((1, lay.size))
        H[0, lay.position][2] = 1.0
        H[0, lay.radii] = -state.jacobian[2] * state.radii * turn.turned[good].mean(axis=0)
        alone = float(turn.alone[good].mean())
        H[0, lay.velocity][2] = -alone
        H[0, lay.attitude] = y, -x, 0.0
        H[0, lay.gyro] = turn.late[good].mean() * H[0, lay.attitude]
        H[0, lay.bias.stop - 1] = -float(steep.mean())
        own = settings.height**2 + _wandered(settings, alone)
        R = doubt(state) * np.array([[sigma**2 * float(steep @ steep) / count**2 + own]])
        if over > 0.0 and count < MOSTLY * np.count_nonzero(inside):  # it may as well be no floor
            if over**2 > _NEAR**2 * float((H @ state.P @ H.T + R)[0, 0]):
                continue
            R += (_DOUBTFUL * over) ** 2
        off, heard = np.array([-over]), True
        measure(state, "height", H, off, R, ("vertical", "gate"), "its floor is not where it should be: not used")
    if heard:
        state.watch.clear("vertical", "floor")
    else:
        state.watch.say("vertical", "floor", "no floor in sight where it should be")


def _walls(settings: FilterSettings, state: FilterState, height: HeightSettings, turn: Turn) -> None:
    """Walls on both sides: their distances' sum is known."""
    flat = np.flatnonzero(turn.down < _STEEP)
    rays, points, place = turn.rays[flat], turn.points[flat], turn.place[flat]
    turned, alone, late = turn.turned[flat], turn.alone[flat], turn.late[flat]
    lay, sigma = state.layout, height.sigma or settings.height_bias
    c, s = np.cos(turn.yaw[flat]), np.sin(turn.yaw[flat])
    rising = place[:, 2] + points[:, 2] > height.floor + _OFF_FLOOR
    for wall in settings.chain.walls.room.walls:
        n = np.array(wall.normal)
        ahead, left = n[0] * c + n[1] * s, n[1] * c - n[0] * s  # the normal along the drum's axes
        steep = ahead * rays[:, 0] + left * rays[:, 1]
        across = ahead * points[:, 0] + left * points[:, 1]
        off = place[:, :2] @ n + across - wall.distance - float(state.bias[-1]) * steep
        good = rising & (steep > 0.5) & (np.abs(off) < _WIDE)
        if np.count_nonzero(good) >= _LEAST:
            good &= np.abs(off - np.median(off[good])) < _NEAR * sigma
        count = int(np.count_nonzero(good))
        if count < _LEAST:
            continue
        x, y, z = points[good].mean(axis=0).tolist()
        a, b = float(ahead[good].mean()), float(left[good].mean())
        H = np.zeros((1, lay.size))
        H[0, lay.position][:2] = n
        H[0, lay.radii] = -(n @ state.jacobian[:2]) * state.radii * turned[good].mean(axis=0)
        by_itself = float(alone[good].mean())
        H[0, lay.velocity][:2] = -n * by_itself
        H[0, lay.attitude] = -b * z, a * z, b * x - a * y
        H[0, lay.gyro] = late[good].mean() * H[0, lay.attitude]
        H[0, lay.bias.stop - 1] = -float(steep[good].mean())
        own = settings.wall**2 + wall.distance_sigma**2 + _wandered(settings, by_itself)
        R = doubt(state) * np.array([[sigma**2 / count + own]])
        measure(state, f"vertical {wall.name}", H, np.array([-float(off[good].mean())]), R, ("vertical", "wall"), "")


def _wandered(settings: FilterSettings, alone: float) -> float:
    """Variance, m^2, of how far B is from where its velocity led it in the s that no encoder told."""
    return settings.push**2 * alone**3
