"""Update by horizontal lidars: each line's angle and distance to its wall, which also show the lidars' range biases.

Each is an equation rho(state) = 0 at the time when the beam passed the middle of the line, related to the current state
by the rotations that encoders and gyro measured since. So a turn that arrives late is used at its own time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from cablewright.arrays import Array
from cablewright.estimation.chain.state import ExtractedTurn
from cablewright.estimation.kalman.state import (
    FilterSettings,
    FilterState,
    moving_velocity,
    passes_gate,
    update_state,
)
from cablewright.estimation.lidar import localisation
from cablewright.estimation.lidar.constraints import ObservedLine, contradicting_walls, find_constraints
from cablewright.estimation.lidar.localisation import LidarTurn, drift_of
from cablewright.models.rotation import wrap_angle
from cablewright.signals import Scan

_SETTLING_TIME: Final = 4.0  # s from the start in which ...
_SETTLING_FACTOR: Final = 4.0  # ... the variance of a lidar's measurements is so many times as large
_WALL_TIMEOUT: Final = 3.5  # s without any wall of a kind
_SHARES: Final = (np.arange(9) + 0.5) / 9.0  # of a line's rays
_REPORTED: Final = 3  # rejections in a row from which they are reported
_DOUBTFUL_WALL: Final = 4.0  # sigmas of its survey, of a wall's error that is reported
_LINE_LENGTH: Final = 4.0  # m, typical, for the curvature of B's path


@dataclass(frozen=True, eq=False)
class WallObservation:
    """One line matched with one wall: innovation (2,) of angle and distance, Jacobian H (2, n), noise R (2, 2)."""

    line: int  # index
    wall: int  # index
    innovation: Array
    H: Array
    R: Array
    nis: float  # normalised innovation squared
    passes: bool  # the gate


def extract(settings: FilterSettings, state: FilterState, scan: Scan) -> None:
    """Find the lines in one turn of a horizontal lidar; `update`, in the next time step, uses them."""
    times = scan.times
    attitudes, motion = state.attitude_history.at(times), state.motion_since(times)
    moved = motion.displacement[-1] - motion.displacement  # (n, 3) m, world
    drift = drift_of(moved[:, :2], attitudes[:, 0], state.yaw - state.gyro_yaw + float(attitudes[-1, 0]))
    lidar = settings.chain.lidars.index(scan.source)
    turn = LidarTurn(scan.angles, scan.ranges, lidar, attitudes[:, 1:], drift)
    features = localisation.extract(settings.chain.walls, turn)
    state.extracted_turn = ExtractedTurn(scan, turn, features, motion.displacement[-1], float(attitudes[-1, 0]))


def update(settings: FilterSettings, state: FilterState) -> None:
    """Update by the lines of the extracted turn, one after another; the most certain match comes first."""
    extracted, state.extracted_turn = state.extracted_turn, None
    assert extracted is not None
    source, lines = extracted.scan.source, extracted.features.lines
    walls = settings.chain.walls.room.walls
    if not lines:
        state.monitor.report(source, "walls", "no wall is in sight: no straight line long enough")
        return
    lidars = settings.chain.walls.lidars
    sweeps = [sweep_of(state, extracted.scan, one, lidars[one.lidar].yaw) for one in lines]
    left, used, rejected = set(range(len(lines))), 0.0, 0.0
    while left:
        found = wall_observations(settings, state, extracted, sweeps, left)
        if not found:
            break
        rivals = {each.line: sum(other.passes and other.wall == each.wall for other in found) for each in found}
        best = min(found, key=lambda each: (not each.passes, rivals[each.line], each.nis))
        if not best.passes:
            rejected = sum(lines[i].line.length for i in {each.line for each in found})
            break
        left.discard(best.line)
        update_state(state, source, best.H, best.innovation, best.R)
        state.last_wall_times[walls[best.wall].kind] = state.time
        used += lines[best.line].line.length
    _report(settings, state, extracted, used, rejected)
    _report_walls(settings, state)


def _report_walls(settings: FilterSettings, state: FilterState) -> None:
    """Report walls that are elsewhere than their survey's standard deviation can explain."""
    for j, wall in enumerate(settings.chain.walls.room.walls):
        error = float(state.wall_errors[j, 0])
        wrong = abs(error) > _DOUBTFUL_WALL * wall.distance_sigma > 0.0
        sentence = f"wall {wall.name!r} is {1e3 * error:+.1f} mm from where it was surveyed"
        state.monitor.set("room", wall.name, sentence, active=wrong)


class Sweep(NamedTuple):
    """When the beam swept over a line, whose points are taken to be evenly spread in bearing."""

    middle_time: float  # s, when it passed the middle of the points
    time_to_end: float  # s from then to the end of the turn
    middle_offset: float  # m along the line, from the foot of the lidar's perpendicular to the points' middle
    time_slope: float  # s/m: time to the end of the turn per offset along the line
    lidar_offset: float  # m along the line, from B's foot to the lidar's
    angle_per_rate: float  # s: error of the line's angle per error of the drum's rate of turn
    offset_per_rate: float  # m s: error of the distance at the points' middle likewise
    change: Array  # (2, m + 4), see `FilterState.change_since`: since the end of the turn, and since `middle_time`


def sweep_of(state: FilterState, scan: Scan, one: ObservedLine, yaw: float) -> Sweep:
    """Compute how the beam of a lidar that is mounted at *yaw* (rad) swept over a line."""
    ends = one.line.ends - one.mount
    first, last = np.arctan2(ends[:, 1], ends[:, 0]).tolist()
    bearings = first + wrap_angle(last - first) * _SHARES
    along = one.line.distance * np.tan(bearings - one.line.angle)
    end = scan.first_angle + scan.angle_step * (len(scan.ranges) - 1)
    turn = math.tau / abs(scan.angle_step) if scan.angle_step else 1.0
    before = scan.period * (((end - bearings + yaw) * math.copysign(1.0, scan.angle_step)) % math.tau) * turn / math.tau
    centred, middle = along - along.mean(), float(before.mean())
    square = max(float(centred @ centred), 1e-9)
    lidar_offset = float(math.cos(one.line.angle) * one.mount[1] - math.sin(one.line.angle) * one.mount[0])
    turned = before * (along + lidar_offset)  # the drum turns about B
    return Sweep(
        scan.time - middle,
        middle,
        float(along.mean()),
        float(centred @ before) / square,
        lidar_offset,
        float(centred @ turned) / square,
        float(turned.mean()),
        state.change_since([scan.time, scan.time - middle]),
    )


def wall_observations(
    settings: FilterSettings, state: FilterState, extracted: ExtractedTurn, sweeps: list[Sweep], chosen: set[int]
) -> list[WallObservation]:
    """Match each *chosen* line with each wall that its lidar can see and that has about the line's direction."""
    room, lidar = settings.chain.walls.room, settings.chain.walls.lidars[extracted.turn.lidar]
    yaw = state.yaw - state.gyro_yaw + extracted.end_yaw
    sigma = math.sqrt(float(state.P[state.layout.yaw, state.layout.yaw]))
    gate = 5.0 * sigma + math.radians(3.0)
    found = []
    for i in sorted(chosen):
        one = extracted.features.lines[i]
        for j, wall in enumerate(room.walls):
            if lidar.visible_walls is not None and wall.name not in lidar.visible_walls:
                continue
            if abs(wrap_angle(wall.azimuth - one.line.angle - yaw)) <= gate:
                found.append(_wall_observation(settings, state, extracted, sweeps[i], i, j))
    return found


def _wall_observation(
    settings: FilterSettings, state: FilterState, extracted: ExtractedTurn, sweep: Sweep, i: int, j: int
) -> WallObservation:
    one, wall, lay, J = extracted.features.lines[i], settings.chain.walls.room.walls[j], state.layout, state.jacobian
    (wall_off, wall_turn), (mount_x, mount_y, mount_yaw) = (
        state.wall_errors[j].tolist(),
        state.mount_errors[one.lidar].tolist(),
    )
    line, bias, m = one.line, float(state.range_bias[one.lidar]), len(state.radii)
    since_end, since_middle = state.displacement(sweep.change)
    x, y = (state.position - since_end)[:2].tolist()
    yaw = state.yaw - state.gyro_yaw + extracted.end_yaw
    c, s = math.cos(yaw), math.sin(yaw)
    n, (nx, ny), (ahead, left) = np.array(wall.normal), wall.normal, one.mount.tolist()
    ahead, left = ahead + mount_x, left + mount_y
    lidar_x, lidar_y = x + c * ahead - s * left, y + s * ahead + c * left
    from_reference = wall.along[0] * lidar_x + wall.along[1] * lidar_y - wall.reference
    turn = wrap_angle(yaw + mount_yaw + line.angle - wall.azimuth - wall_turn) - float(line.bias_slopes[0]) * bias
    off = nx * lidar_x + ny * lidar_y - wall.distance - wall_off + wall_turn * from_reference
    off += line.distance - float(line.bias_slopes[1]) * bias
    # Rotating a line about the middle of its points shifts its perpendicular distance.
    slope, along, coasting_time = sweep.time_slope, sweep.middle_offset, float(sweep.change[1, m + 3])
    toward = n @ J[:2] * state.radii
    H = np.zeros((2, lay.size))
    H[0, lay.yaw] = 1.0
    H[1, lay.position][:2] = n
    if state.coasting:
        H[0, lay.velocity][:2] = slope * n
        H[1, lay.velocity][:2] = (slope * along - coasting_time) * n
        H[1, lay.radii] = -toward * sweep.change[1, :m]
    else:
        H[0, lay.radii] = by_rates = slope * toward * state.drum_rates
        H[1, lay.radii] = along * by_rates - toward * sweep.change[1, :m]
        H[1, lay.velocity][:2] = -coasting_time * n
    H[1, lay.stretch] = -(n @ J[:2]) * (state.last_encoder_time - sweep.middle_time - coasting_time)
    height = settings.chain.walls.lidars[one.lidar].mount[2]
    H[1, lay.attitude] = _attitude_slopes(n, yaw, np.array([ahead, left, height]))
    late = state.last_imu_time - extracted.scan.time
    angle = late + sweep.angle_per_rate
    offset = late * (along + sweep.lidar_offset) + sweep.offset_per_rate
    H[1, lay.gyro_bias] = (state.last_imu_time - sweep.middle_time) * H[1, lay.attitude]
    H[:, lay.gyro_bias.stop - 1] = angle, along * angle - offset
    H[:, lay.range_bias.start + one.lidar] = -line.bias_slopes
    H[:, lay.walls.start + 2 * j] = 0.0, -1.0
    H[:, lay.walls.start + 2 * j + 1] = -1.0, from_reference
    first = lay.mounts.start + 3 * one.lidar
    H[1, first : first + 2] = nx * c + ny * s, ny * c - nx * s
    H[0, first + 2] = 1.0
    H[1, lay.clock] = by_clock = -float(n @ moving_velocity(state)[:2])
    off += by_clock * state.clock_error
    R = line.covariance + settings.wall_angle_sigma**2 * _lever_covariance(along)
    R[1, 1] += settings.wall_sigma**2
    _add_motion_noise(settings, state, sweep, extracted.scan.begin, since_middle, R)
    R *= noise_factor(state)
    innovation = np.array([-turn, -off])
    passes, nis = passes_gate(state.P, H, innovation, R)
    return WallObservation(i, j, innovation, H, R, nis, passes)


def _attitude_slopes(n: Array, yaw: float, point: Array) -> Array:
    """Derivative (3,) of n . point by tilt x and y, and yaw; *point* (3,), m, of the drum along its level axes."""
    c, s = math.cos(yaw), math.sin(yaw)
    ahead, left = n[0] * c + n[1] * s, n[1] * c - n[0] * s  # the normal along the drum's axes
    x, y, z = point.tolist()
    return np.array([-left * z, ahead * z, left * x - ahead * y])


def _add_motion_noise(
    settings: FilterSettings, state: FilterState, sweep: Sweep, begin: float, moved: Array, R: Array
) -> None:
    """Add the error of linearising the displacement since the sweep, and unmeasured rotation and motion."""
    dt, far = min(sweep.time_to_end, 1.0), math.sqrt(float(moved @ moved))
    R[1, 1] += (far * far / (2.0 * _LINE_LENGTH)) ** 2 + settings.travel_noise**2 * far
    R[0, 0] += settings.gyro_noise**2 * abs(state.last_imu_time - sweep.middle_time)
    if state.coasting:
        R += settings.velocity_noise**2 * dt * sweep.time_slope**2 * _lever_covariance(sweep.middle_offset)
        R[1, 1] += settings.velocity_noise**2 * dt**3
    if state.has_long_steps or begin < state.imu_gap_end:
        R += (settings.turn_rate_sigma * max(dt, 0.2)) ** 2 * _lever_covariance(-sweep.lidar_offset)
        R[1, 1] += (settings.turn_rate_sigma * settings.skew_time) ** 2


def _lever_covariance(arm: float) -> Array:
    """Covariance (2, 2) of a line's angle and distance for a rotation of variance 1, rad^2, at an *arm*, m."""
    return np.array([[1.0, arm], [arm, arm * arm]])


def _report(
    settings: FilterSettings, state: FilterState, extracted: ExtractedTurn, used: float, rejected: float
) -> None:
    """Report the faults of a turn. *used*, *rejected*: m, length of the lines that match a wall, and of the others."""
    monitor, source = state.monitor, extracted.scan.source
    if used:
        unseen = [kind for kind, last in state.last_wall_times.items() if state.time - last > _WALL_TIMEOUT]
        if unseen:
            monitor.report(source, "walls", localisation.SENTENCES["parallel"])
        else:
            monitor.clear(source, "walls")
        state.last_position_time = state.time
    elif not rejected:
        monitor.report(source, "walls", "no line in sight can be a wall at the estimated yaw")
    if rejected > used:
        state.rejections[source] = state.rejections.get(source, 0) + 1
        sentence, chain = "its walls contradict the estimated position: not used", settings.chain.walls
        yaws = state.yaw - chain.yaw_step, state.yaw + chain.yaw_step
        seen = find_constraints(extracted.features.lines, chain.visible, chain.room, yaws)
        why = contradicting_walls(seen, chain.room, chain.gate)
        monitor.report(source, "gate", f"{sentence}; {why}" if why else sentence)
    else:
        state.rejections[source] = 0
        monitor.clear(source, "gate")


def noise_factor(state: FilterState) -> float:
    """Factor on the variance of a lidar's measurement: larger while swing and rates, which distort a turn, settle."""
    return _SETTLING_FACTOR if state.time - state.settling_start < _SETTLING_TIME else 1.0


def gated_update(
    state: FilterState, what: str, H: Array, innovation: Array, R: Array, fault: tuple[str, str], sentence: str
) -> bool:
    """Update by one measurement if it passes the gate, else count and report the rejection; return whether it did."""
    if not passes_gate(state.P, H, innovation, R)[0]:
        state.rejections[what] = state.rejections.get(what, 0) + 1
        if sentence and state.rejections[what] >= _REPORTED:
            state.monitor.report(*fault, sentence)
        return False
    state.rejections[what] = 0
    state.monitor.clear(*fault)
    update_state(state, fault[0], H, innovation, R)
    return True
