"""What lidars tell the filter: each line's distance and angle to its wall, the height over the floor, their own biases.

Each is an equation rho(state) = 0 at the moment when the beam passed the middle of what it saw, carried to now by what
encoders and gyro told since: so a turn that comes late counts where it belongs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.estimation import lidar_walls
from cablewright.estimation.constraints import SeenLine, wrapped
from cablewright.estimation.filter_state import FilterSettings, FilterState, correct, fuse, likely
from cablewright.estimation.height import height_of, leaned
from cablewright.estimation.lidar_walls import LidarTurn
from cablewright.estimation.observer_state import Looked
from cablewright.signals import Scan

__all__ = ["Equation", "equations_of", "look", "measure", "place", "vertical"]

Array = NDArray[np.float64]

_REACH: Final = 4.0  # m: about as far as the sheaves are, for how B's way bends
_STEEP: Final = math.radians(60.0)  # from the axis: where the vertical lidar's rays meet walls
_OFF_FLOOR: Final = 0.1  # m over the floor, of points that are the walls'
_LEAST_POINTS: Final = 8
_NEAR: Final = 4.0  # sigmas from the middle, of points on a wall
_WIDE: Final = 0.03  # m from where a wall is believed to be, for the first look at the vertical lidar's points


@dataclass(frozen=True, eq=False)
class Equation:
    """One line taken for one wall: innovation (2,), its derivative H (2, n), and the noise's covariance R (2, 2)."""

    seen: int
    wall: int
    innovation: Array
    H: Array
    R: Array
    size: float  # squared, in standard deviations
    fits: bool


def look(settings: FilterSettings, state: FilterState, scan: Scan) -> None:
    """Find the lines of one turn of a horizontal lidar: half of the work."""
    times = scan.times
    turning, ways = state.turning.at(times), state.way.at(times)
    moved = (ways - ways[-1]) * state.radii @ state.jacobian.T  # (n, 3) m, world
    yaw = state.yaw - state.gyro_yaw + float(turning[-1, 0])
    c, s = math.cos(yaw), math.sin(yaw)
    level = moved[:, :2] @ np.array([[c, -s], [s, c]])
    drift = np.column_stack([level, turning[:, 0] - turning[-1, 0]])
    which = settings.chain.lidars.index(scan.source)
    turn = LidarTurn(scan.angles, scan.ranges, which, turning[:, 1:], drift)
    kept = lidar_walls.look(settings.chain.walls, turn)
    state.looked = Looked(scan, turn, kept, ways[-1], float(turning[-1, 0]))


def place(settings: FilterSettings, state: FilterState) -> None:
    """Let the lines that were found tell where the drum is."""
    looked, state.looked = state.looked, None
    assert looked is not None
    source, seen = looked.scan.source, looked.kept.seen
    watch, room = state.watch, settings.chain.walls.room
    if not seen:
        watch.say(source, "walls", "no wall is in sight: no straight line long enough")
        return
    left, used, refused = set(range(len(seen))), 0, 0
    while left:
        found = equations_of(settings, state, looked, left)
        if not found:
            break
        rivals = {each.seen: sum(other.fits and other.wall == each.wall for other in found) for each in found}
        best = min(found, key=lambda each: (not each.fits, rivals[each.seen], each.size))
        if not best.fits:
            refused += len({each.seen for each in found})
            break
        left.discard(best.seen)
        _take(state, best)
        state.across[room.walls[best.wall].kind] = state.time
        used += 1
    _judge(settings, state, source, used, refused)


def _take(state: FilterState, equation: Equation) -> None:
    """Fuse one line."""
    if state.nis is not None:
        state.nis.append((f"wall {equation.wall}", equation.size, 2))
    correction, state.P = fuse(state.P, equation.H, equation.innovation, equation.R)
    correct(state, correction)


def equations_of(
    settings: FilterSettings, state: FilterState, looked: Looked, chosen: set[int]
) -> list[Equation]:
    """Take each *chosen* line for each wall that its lidar can see and that stands about as the line does."""
    room, lidar = settings.chain.walls.room, settings.chain.walls.lidars[looked.turn.lidar]
    yaw = state.yaw - state.gyro_yaw + looked.yaw
    spread = math.sqrt(float(state.P[state.layout.attitude.stop - 1, state.layout.attitude.stop - 1]))
    gate = 5.0 * spread + math.radians(3.0)
    found = []
    for i in sorted(chosen):
        one = looked.kept.seen[i]
        for j, wall in enumerate(room.walls):
            if lidar.sees is not None and wall.name not in lidar.sees:
                continue
            if abs(wrapped(wall.azimuth - one.line.angle - yaw)) <= gate:
                found.append(_equation(settings, state, looked, one, i, j))
    return found


def _equation(
    settings: FilterSettings, state: FilterState, looked: Looked, one: SeenLine, i: int, j: int
) -> Equation:
    lay, wall, line = state.layout, settings.chain.walls.room.walls[j], one.line
    lidar, scan = settings.chain.walls.lidars[one.lidar], looked.scan
    now_way, J = state.angles, state.jacobian
    end = state.position - J @ (state.radii * (now_way - looked.end))
    yaw = state.yaw - state.gyro_yaw + looked.yaw
    n = np.array(wall.normal)
    c, s = math.cos(yaw), math.sin(yaw)
    R_yaw = np.array([[c, -s], [s, c]])
    lever, bias = R_yaw @ one.mount, float(state.bias[one.lidar])
    turned = wrapped(yaw + line.angle - wall.azimuth) - line.per_bias[0] * bias
    off = float(n @ (end[:2] + lever)) + line.distance - line.per_bias[1] * bias - wall.distance
    middle = scan.time - _before(scan, line.ends.mean(axis=0) - one.mount, lidar.yaw)
    back = now_way - state.way.at([middle])[0]
    H = np.zeros((2, lay.size))
    H[0, lay.attitude.stop - 1] = 1.0
    H[1, lay.position][:2] = n
    H[1, lay.radii] = -(n @ J[:2]) * state.radii * back
    H[1, lay.attitude] = _by_attitude(n, yaw, np.array([*one.mount, lidar.mount[2]]))
    H[:, lay.gyro.stop - 1] = H[:, lay.attitude.stop - 1] * (state.felt - middle)
    H[:, lay.bias.start + one.lidar] = -line.per_bias
    R = line.covariance + np.diag([settings.wall_angle**2 + wall.angle_sigma**2, settings.wall**2 + wall.distance_sigma**2])
    _add_unknown_motion(settings, state, scan, middle, back, R)
    innovation = -np.array([turned, off])
    fits, size = likely(state.P, H, innovation, R)
    return Equation(i, j, innovation, H, R, size, fits)


def _by_attitude(n: Array, yaw: float, point: Array) -> Array:
    """By how much a *point* (3,) of the drum, level axes, comes nearer to a wall as tilt x and y, and yaw, grow: (3,)."""
    c, s = math.cos(yaw), math.sin(yaw)
    ahead, left = n[0] * c + n[1] * s, n[1] * c - n[0] * s  # the normal along the drum's axes
    x, y, z = point.tolist()
    return np.array([-left * z, ahead * z, left * x - ahead * y])


def _add_unknown_motion(
    settings: FilterSettings, state: FilterState, scan: Scan, middle: float, back: Array, R: Array
) -> None:
    """Add what the linearisation since the beam passed leaves out, and turns and motion that nothing told."""
    way = state.jacobian @ (state.radii * back)
    R[1, 1] += (float(way @ way) / (2.0 * _REACH)) ** 2
    R[1, 1] += settings.travel**2 * math.sqrt(float(way @ way))
    blind = min(scan.time - middle, 1.0)
    if state.watch.unheard("inertial"):
        turn = (settings.turning * max(blind, 0.2)) ** 2
        R[0, 0] += turn
        R[1, 1] += 0.1 * turn
    if state.free:
        lay = state.layout
        speed = float(np.trace(state.P[lay.velocity, lay.velocity])) + float(state.velocity @ state.velocity)
        R[1, 1] += speed * blind**2


def _before(scan: Scan, xy: Array, yaw: float) -> float:
    """How long before the end of its turn the beam passed *xy* (2,), seen from the lidar in the platform's frame, s."""
    bearing = math.atan2(xy[1], xy[0]) - yaw
    last = scan.first_angle + scan.angle_step * (len(scan.ranges) - 1)
    return float((last - bearing) % math.tau / abs(scan.angle_step) * scan.period) if scan.angle_step else 0.0


def _judge(settings: FilterSettings, state: FilterState, source: str, used: int, refused: int) -> None:
    """Say what is wrong with a turn."""
    watch = state.watch
    if used:
        watch.clear(source, "walls")
        watch.clear(source, "gate")
        state.refused[source] = 0
        state.fixed = state.time
        return
    if refused:
        state.refused[source] = state.refused.get(source, 0) + 1
        watch.say(source, "gate", "its walls put the drum elsewhere than it can be: not used")
    else:
        watch.say(source, "walls", "no wall is in sight at a yaw that is allowed")


def vertical(settings: FilterSettings, state: FilterState, scan: Scan) -> None:
    """Let one turn of the vertical lidar tell the height over the floor, and by the walls its bias."""
    if settings.chain.height is None:
        return
    times = scan.times
    turning, ways = state.turning.at(times), state.way.at(times)
    back = state.angles - ways[len(times) // 2]
    moved = state.jacobian @ (state.radii * back)
    state.height = found = height_of(settings.chain.height, scan, turning[:, 1:])
    if math.isfinite(found.over_structure):
        state.clearance_off = found.over_structure - float((state.position - moved)[2])
    _walls(settings, state, scan, turning, ways)
    if found.note:
        state.watch.say("vertical", "floor", found.note)
        return
    state.watch.clear("vertical", "floor")
    lay = state.layout
    H = np.zeros((1, lay.size))
    H[0, lay.position][2] = 1.0
    H[0, lay.radii] = -state.jacobian[2] * state.radii * back
    H[0, lay.bias.stop - 1] = 1.0
    off = np.array([found.over_floor - float((state.position - moved)[2]) - float(state.bias[-1])])
    R = np.array([[settings.height**2]])
    measure(state, "height", H, off, R, ("vertical", "gate"), "its floor is not where it should be: not used")


def measure(
    state: FilterState, what: str, H: Array, innovation: Array, R: Array, fault: tuple[str, str], sentence: str
) -> bool:
    """Fuse one measurement, or say why it is not used."""
    fits, size = likely(state.P, H, innovation, R)
    if state.nis is not None:
        state.nis.append((what, size, len(innovation)))
    if not fits:
        state.refused[what] = state.refused.get(what, 0) + 1
        if sentence:
            state.watch.say(*fault, sentence)
        return False
    state.refused[what] = 0
    state.watch.clear(*fault)
    correction, state.P = fuse(state.P, H, innovation, R)
    correct(state, correction)
    return True


def _walls(settings: FilterSettings, state: FilterState, scan: Scan, turning: Array, ways: Array) -> None:
    """Walls on both sides of the vertical lidar tell its bias: their distances' sum is known."""
    height, room, lay = settings.chain.height, settings.chain.walls.room, state.layout
    assert height is not None
    x, y = np.array(height.axes)
    angles = scan.angles
    rays = np.cos(angles)[:, None] * x + np.sin(angles)[:, None] * y
    flat = np.flatnonzero(np.isfinite(scan.ranges) & (-rays[:, 2] < math.cos(_STEEP)))
    if len(flat) < _LEAST_POINTS:
        return
    lean = turning[flat, 1:]
    ranges = scan.ranges[flat]
    arms, ways_out = leaned(np.array([height.place]).repeat(len(flat), axis=0), lean), leaned(rays[flat], lean)
    points = arms + ranges[:, None] * ways_out
    yaw = state.yaw - state.gyro_yaw + turning[flat, 0]
    c, s = np.cos(yaw), np.sin(yaw)
    back = state.angles - ways[flat]
    place = state.position - (back * state.radii) @ state.jacobian.T
    level = np.column_stack([c * points[:, 0] - s * points[:, 1], s * points[:, 0] + c * points[:, 1]])
    rising = place[:, 2] + points[:, 2] > _OFF_FLOOR
    bias, sigma = float(state.bias[-1]), height.sigma or 2e-3
    for wall in room.walls:
        n = np.array(wall.normal)
        steep = n[0] * (c * ways_out[:, 0] - s * ways_out[:, 1]) + n[1] * (s * ways_out[:, 0] + c * ways_out[:, 1])
        off = (place[:, :2] + level) @ n - wall.distance - bias * steep
        good = rising & (steep > 0.5) & (np.abs(off) < _WIDE)
        if np.count_nonzero(good) < _LEAST_POINTS:
            continue
        good &= np.abs(off - np.median(off[good])) < _NEAR * sigma
        count = int(np.count_nonzero(good))
        if count < _LEAST_POINTS:
            continue
        H = np.zeros((1, lay.size))
        H[0, lay.position][:2] = n
        H[0, lay.radii] = -(n @ state.jacobian[:2]) * state.radii * back[good].mean(axis=0)
        H[0, lay.attitude] = _by_attitude(n, yaw[good].mean(), points[good].mean(axis=0))
        H[0, lay.bias.stop - 1] = -float(steep[good].mean())
        R = np.array([[sigma**2 / count + 2.0 * settings.wall**2]])
        measure(state, f"vertical {wall.name}", H, np.array([-float(off[good].mean())]), R, ("vertical", "wall"), "")
