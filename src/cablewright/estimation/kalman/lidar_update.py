"""What horizontal lidars tell the filter: each line's distance and angle to its wall, and so their own biases.

Each is an equation rho(state) = 0 at the moment when the beam passed the middle of what it saw, carried to now by what
encoders and gyro told since: so a turn that comes late counts where it belongs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.estimation.chain.state import Looked
from cablewright.estimation.kalman.state import FilterSettings, FilterState, correct, fuse, likely
from cablewright.estimation.lidar import localisation
from cablewright.estimation.lidar.constraints import SeenLine, wrapped
from cablewright.estimation.lidar.localisation import LidarTurn
from cablewright.signals import Scan

__all__ = ["Equation", "doubt", "equations_of", "look", "measure", "place", "swept_by"]

Array = NDArray[np.float64]

_SETTLED: Final = 4.0  # s from the first place on ...
_DOUBT: Final = 4.0  # ... in which this is the variance of a lidar's readings, times theirs
_UNSEEN: Final = 3.5  # s without a wall across
_SHARES: Final = (np.arange(9) + 0.5) / 9.0  # of a line's rays
_SAID: Final = 3  # times in a row that a reading does not fit until it is said
_REACH: Final = 4.0  # m: about as far as the sheaves are, for how B's way bends


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
    turning, since = state.turning.at(times), state.since(times)
    moved = since.moved[-1] - since.moved  # (n, 3) m, world
    yaw = state.yaw - state.gyro_yaw + float(turning[-1, 0])
    c, s = math.cos(yaw), math.sin(yaw)
    level = moved[:, :2] @ np.array([[c, -s], [s, c]])
    drift = np.column_stack([level, turning[:, 0] - turning[-1, 0]])
    which = settings.chain.lidars.index(scan.source)
    turn = LidarTurn(scan.angles, scan.ranges, which, turning[:, 1:], drift)
    kept = localisation.look(settings.chain.walls, turn)
    state.looked = Looked(scan, turn, kept, since.moved[-1], float(turning[-1, 0]))


def place(settings: FilterSettings, state: FilterState) -> None:
    """Let the lines that were found tell where the drum is."""
    looked, state.looked = state.looked, None
    assert looked is not None
    source, seen = looked.scan.source, looked.kept.seen
    watch, room = state.watch, settings.chain.walls.room
    if not seen:
        watch.say(source, "walls", "no wall is in sight: no straight line long enough")
        return
    swept = [swept_by(state, looked.scan, one, settings.chain.walls.lidars[one.lidar].yaw) for one in seen]
    left, used, refused = set(range(len(seen))), 0.0, 0.0
    while left:
        found = equations_of(settings, state, looked, swept, left)
        if not found:
            break
        rivals = {each.seen: sum(other.fits and other.wall == each.wall for other in found) for each in found}
        best = min(found, key=lambda each: (not each.fits, rivals[each.seen], each.size))
        if not best.fits:
            refused = sum(seen[i].line.length for i in {each.seen for each in found})
            break
        left.discard(best.seen)
        _take(state, best)
        state.across[room.walls[best.wall].kind] = state.time
        used += seen[best.seen].line.length
    _judge(state, source, used, refused)


def _take(state: FilterState, equation: Equation) -> None:
    """Fuse one line."""
    if state.nis is not None:
        state.nis.append((f"wall {equation.wall}", equation.size, 2))
    correction, state.P = fuse(state.P, equation.H, equation.innovation, equation.R)
    correct(state, correction)


class Swept(NamedTuple):
    """How the beam passed a line, whose rays are as evenly spread as they are."""

    middle: float  # s, when it passed the middle of the points
    before: float  # s from then to the end of the turn
    along: float  # m along the line, from the lidar's foot on it to the points' middle
    rate: float  # s/m: by how much earlier the points are, the farther along
    aside: float  # m along the line, from B's foot on it to the lidar's
    bent: float  # s: what the line turns by if the drum's rate of turn is off by 1 rad/s, from the end of the turn back
    shifted: float  # m s: what its points' middle is off then
    gone: Array  # (2, m + 4) of `FilterState.gone`: since the end of the turn, and since the middle


def swept_by(state: FilterState, scan: Scan, one: SeenLine, yaw: float) -> Swept:
    """Say how the beam of a lidar that is mounted at *yaw* (rad) passed a line that it saw."""
    ends = one.line.ends - one.mount
    first, last = np.arctan2(ends[:, 1], ends[:, 0]).tolist()
    bearings = first + wrapped(last - first) * _SHARES
    along = one.line.distance * np.tan(bearings - one.line.angle)
    end = scan.first_angle + scan.angle_step * (len(scan.ranges) - 1)
    turn = math.tau / abs(scan.angle_step) if scan.angle_step else 1.0
    before = scan.period * (((end - bearings + yaw) * math.copysign(1.0, scan.angle_step)) % math.tau) * turn / math.tau
    away, middle = along - along.mean(), float(before.mean())
    spread = max(float(away @ away), 1e-9)
    aside = float(math.cos(one.line.angle) * one.mount[1] - math.sin(one.line.angle) * one.mount[0])
    turned = before * (along + aside)  # the drum turns about B
    return Swept(
        scan.time - middle,
        middle,
        float(along.mean()),
        float(away @ before) / spread,
        aside,
        float(away @ turned) / spread,
        float(turned.mean()),
        state.gone([scan.time, scan.time - middle]),
    )


def equations_of(
    settings: FilterSettings, state: FilterState, looked: Looked, swept: list[Swept], chosen: set[int]
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
                found.append(_equation(settings, state, looked, swept[i], i, j))
    return found


def _equation(settings: FilterSettings, state: FilterState, looked: Looked, swept: Swept, i: int, j: int) -> Equation:
    one, wall, lay, J = looked.kept.seen[i], settings.chain.walls.room.walls[j], state.layout, state.jacobian
    line, bias, m = one.line, float(state.bias[one.lidar]), len(state.radii)
    since_end, since_middle = state.moved(swept.gone)
    x, y = (state.position - since_end)[:2].tolist()
    yaw = state.yaw - state.gyro_yaw + looked.yaw
    c, s = math.cos(yaw), math.sin(yaw)
    n, (nx, ny), (ahead, left) = np.array(wall.normal), wall.normal, one.mount.tolist()
    turned = wrapped(yaw + line.angle - wall.azimuth) - float(line.per_bias[0]) * bias
    off = nx * (x + c * ahead - s * left) + ny * (y + s * ahead + c * left) - wall.distance
    off += line.distance - float(line.per_bias[1]) * bias
    # Who turns a line about the middle of its points moves it at its foot, where its distance is told.
    rate, along, alone = swept.rate, swept.along, float(swept.gone[1, m + 3])
    toward = n @ J[:2] * state.radii
    H = np.zeros((2, lay.size))
    H[0, lay.attitude.stop - 1] = 1.0
    H[1, lay.position][:2] = n
    if state.free:
        H[0, lay.velocity][:2] = rate * n
        H[1, lay.velocity][:2] = (rate * along - alone) * n
        H[1, lay.radii] = -toward * swept.gone[1, :m]
    else:
        H[0, lay.radii] = by_rates = rate * toward * state.rates
        H[1, lay.radii] = along * by_rates - toward * swept.gone[1, :m]
        H[1, lay.velocity][:2] = -alone * n
    H[1, lay.attitude] = _by_attitude(n, yaw, np.array([ahead, left, settings.chain.walls.lidars[one.lidar].mount[2]]))
    late = state.felt - looked.scan.time
    bent = late + swept.bent
    shifted = late * (along + swept.aside) + swept.shifted
    H[1, lay.gyro] = (state.felt - swept.middle) * H[1, lay.attitude]
    H[:, lay.gyro.stop - 1] = bent, along * bent - shifted
    H[:, lay.bias.start + one.lidar] = -line.per_bias
    R = line.covariance + settings.wall_angle**2 * _levered(along)
    R[0, 0] += wall.angle_sigma**2
    R[1, 1] += settings.wall**2 + wall.distance_sigma**2
    _add_unknown_motion(settings, state, swept, looked.scan.begin, since_middle, R)
    R *= doubt(state)
    innovation = np.array([-turned, -off])
    fits, size = likely(state.P, H, innovation, R)
    return Equation(i, j, innovation, H, R, size, fits)


def _by_attitude(n: Array, yaw: float, point: Array) -> Array:
    """By how much a *point* (3,) of the drum, level axes, goes along *n* as tilt x and y, and yaw, grow: (3,)."""
    c, s = math.cos(yaw), math.sin(yaw)
    ahead, left = n[0] * c + n[1] * s, n[1] * c - n[0] * s  # the normal along the drum's axes
    x, y, z = point.tolist()
    return np.array([-left * z, ahead * z, left * x - ahead * y])


def _add_unknown_motion(
    settings: FilterSettings, state: FilterState, swept: Swept, begin: float, moved: Array, R: Array
) -> None:
    """Add what the linearisation since the beam passed leaves out, and turns and motion that nothing told."""
    blind, far = min(swept.before, 1.0), math.sqrt(float(moved @ moved))
    R[1, 1] += (far * far / (2.0 * _REACH)) ** 2 + settings.travel**2 * far
    R[0, 0] += settings.gyro_noise**2 * abs(state.felt - swept.middle)
    if state.free:
        R += settings.push**2 * blind * swept.rate**2 * _levered(swept.along)
        R[1, 1] += settings.push**2 * blind**3
    if state.coarse or begin < state.blind:
        R += (settings.turning * max(blind, 0.2)) ** 2 * _levered(-swept.aside)
        R[1, 1] += (settings.turning * settings.bend) ** 2


def _levered(arm: float) -> Array:
    """What a turn of variance 1, rad^2, does to a line's angle and to its distance at an *arm*, m, from there."""
    return np.array([[1.0, arm], [arm, arm * arm]])


def _judge(state: FilterState, source: str, used: float, refused: float) -> None:
    """Say what is wrong with a turn of which lines of *used* metres fit, and *refused* are nowhere near a wall."""
    watch = state.watch
    if used:
        unseen = [kind for kind, last in state.across.items() if state.time - last > _UNSEEN]
        if unseen:
            watch.say(source, "walls", "all walls in sight bound the same direction: the place along them is not known")
        else:
            watch.clear(source, "walls")
        state.fixed = state.time
    elif not refused:
        watch.say(source, "walls", "no wall is in sight at a yaw that is allowed")
    if refused > used:
        state.refused[source] = state.refused.get(source, 0) + 1
        watch.say(source, "gate", "its walls put the drum elsewhere than it can be: not used")
    else:
        state.refused[source] = 0
        watch.clear(source, "gate")


def doubt(state: FilterState) -> float:
    """By how much more the variance of a lidar's reading is while swing and rates, which bend a turn, settle."""
    return _DOUBT if state.time - state.begun < _SETTLED else 1.0


def measure(
    state: FilterState, what: str, H: Array, innovation: Array, R: Array, fault: tuple[str, str], sentence: str
) -> bool:
    """Fuse one measurement, or say why it is not used."""
    fits, size = likely(state.P, H, innovation, R)
    if state.nis is not None:
        state.nis.append((what, size, len(innovation)))
    if not fits:
        state.refused[what] = state.refused.get(what, 0) + 1
        if sentence and state.refused[what] >= _SAID:
            state.watch.say(*fault, sentence)
        return False
    state.refused[what] = 0
    state.watch.clear(*fault)
    correction, state.P = fuse(state.P, H, innovation, R)
    correct(state, correction)
    return True
