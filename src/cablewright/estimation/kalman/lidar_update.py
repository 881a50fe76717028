"""Filter update by horizontal lidars: angle and distance of each scanned line to its wall, and the range biases.

Each is an equation rho(state) = 0 at the time when the beam passed the middle of the line, related to the current state
by the rotations that encoders and gyro measured since. So a scan that arrives late is used at its own time.
"""

from __future__ import annotations

import math
from collections import Counter
from typing import Final

import numpy as np

from cablewright.estimation.kalman.settings import FilterSettings
from cablewright.estimation.kalman.state import FilterState, moving_velocity, passes_gate, update_state
from cablewright.estimation.lidar import localisation
from cablewright.estimation.lidar.constraints import contradicting_walls, find_constraints
from cablewright.estimation.lidar.wall_lines import LidarTurn, scanned
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Scan
from cablewright.models.rotation import wrap_angle

_SETTLING_TIME: Final = 4.0  # s from the start in which ...
_SETTLING_FACTOR: Final = 4.0  # ... the variance of a lidar's measurements is so many times as large
_WALL_TIMEOUT: Final = 3.5  # s without any wall of a kind
_REPORTED: Final = 3  # rejections in a row from which they are reported
_DOUBTFUL_WALL: Final = 4.0  # sigmas of its survey, of a wall's error that is reported
_DOUBTFUL_SURVEY: Final = 2.2  # mean square of all walls' errors over the stated variances, that is reported
_LINE_LENGTH: Final = 4.0  # m, typical, for the curvature of B's path


Equation = tuple[Array, Array, Array]
"""One line as one wall: Jacobian H (2, n), innovation (2,) of angle and distance, and noise R (2, 2)."""


def extract(settings: FilterSettings, state: FilterState, scan: Scan) -> None:
    """Find the straight lines in one scan of a horizontal lidar; `update`, in the next time step, uses them."""
    times, walls, lidar = scan.times, settings.machine.walls, settings.machine.lidars.index(scan.source)
    attitudes, motion = state.turns.attitudes.at(times), state.motion_since(times)
    moved = motion.displacement[-1] - motion.displacement  # (n, 3) m, world
    state.attitude.turn_yaw = float(attitudes[-1, 0])
    yaw = state.attitude.yaw - state.attitude.gyro_yaw + state.attitude.turn_yaw
    state.turns.extracted = scanned(scan, walls.lidars[lidar], lidar, walls.search, attitudes, moved[:, :2], yaw)


def update(settings: FilterSettings, state: FilterState) -> None:
    """Update the filter by the lines of the extracted scan, one after another; the most certain match comes first."""
    turn, state.turns.extracted = state.turns.extracted, None
    assert turn is not None
    walls = settings.machine.walls.room.walls
    if not len(turn):
        state.monitor.report(turn.source, "walls", "no wall is in sight: no straight line long enough")
        return
    lengths = turn.lengths.tolist()
    changes = [state.change_since([turn.end, turn.end - to_end]) for to_end in turn.sweeps[:, 0].tolist()]
    left, used, rejected = set(range(len(turn))), 0.0, 0.0
    while left:
        found = equations(settings, state, turn, changes, left)
        if not found:
            break
        gates = {match: passes_gate(state.P, *equation) for match, equation in found.items()}
        best = _most_certain(gates)
        if not gates[best][0]:
            rejected = sum(lengths[i] for i in {i for i, _ in found})
            break
        line, wall = best
        left.discard(line)
        update_state(state, turn.source, *found[best])
        state.judged.last_wall_times[walls[wall].kind] = state.time
        used += lengths[line]
    _report(settings, state, turn, used, rejected)
    _report_walls(settings, state)


def _most_certain(gates: dict[tuple[int, int], tuple[bool, float]]) -> tuple[int, int]:
    """Return the line and wall whose match is the most certain, by whether each passes the gate, and its NIS.

    First those that pass, of these the ones whose wall no other line may be, of these the one with the least NIS.
    """
    claims = Counter(wall for (_, wall), (passes, _) in gates.items() if passes)
    rivals = {line: claims[wall] for line, wall in gates}
    return min(gates, key=lambda match: (not gates[match][0], rivals[match[0]], gates[match][1]))


def _report_walls(settings: FilterSettings, state: FilterState) -> None:
    """Report walls that are elsewhere than their survey's standard deviation can explain, and widen the position's.

    A wall with a large error shows alone. Of all walls the mean square of their errors over the stated variances is 1
    where the survey is as good as stated: it is that of estimate and covariance together, one step of expectation and
    maximisation (Dempster, Laird, Rubin 1977). The position is known less well by its excess, as far as errors of walls
    make its covariance.
    """
    own, walls = state.layout.walls, settings.machine.walls.room.walls
    for j, wall in enumerate(walls):
        error = float(state.built.wall_errors[j, 0])
        wrong = abs(error) > _DOUBTFUL_WALL * wall.distance_sigma > 0.0
        sentence = f"wall {wall.name!r} is {1e3 * error:+.1f} mm from where it was surveyed"
        state.monitor.set("room", wall.name, sentence, active=wrong)
    stated, found = state.built.survey_variances[: 2 * len(walls)], state.P[own, own]
    if not len(walls) or not (stated > 0.0).all():
        return
    ratio = float(np.mean((state.mean.x[own] ** 2 + np.diag(found)) / stated))
    by_walls = state.P[state.layout.position, own]
    spread = by_walls @ np.linalg.solve(found, by_walls.T)
    state.judged.survey_doubt[:] = 0.5 * max(ratio - 1.0, 0.0) * (spread + spread.T)
    sentence = f"errors of walls are {math.sqrt(ratio):.2g} times as large as their survey states: survey them again"
    state.monitor.set("room", "survey", sentence, active=ratio > _DOUBTFUL_SURVEY)


def equations(
    settings: FilterSettings, state: FilterState, turn: LidarTurn, changes: list[Array], chosen: set[int]
) -> dict[tuple[int, int], Equation]:
    """Match each *chosen* line with each wall that its lidar can see and that has about the line's direction.

    Returns equations by line and wall. *changes*: changes of each line (2, m + 4), `FilterState.change_since` the end
    of the turn, and since the beam passed the line's middle.
    """
    walls, visible = settings.machine.walls.room.walls, settings.machine.walls.visible[turn.lidar].tolist()
    yaw = state.attitude.yaw - state.attitude.gyro_yaw + state.attitude.turn_yaw
    sigma = math.sqrt(float(state.P[state.layout.yaw, state.layout.yaw]))
    gate = 5.0 * sigma + math.radians(3.0)
    matches = [
        (i, j)
        for i in sorted(chosen)
        for j, wall in enumerate(walls)
        if visible[j] and abs(wrap_angle(wall.azimuth - float(turn.angles[i]) - yaw)) <= gate
    ]
    return {(i, j): _equation(settings, state, turn, changes[i], i, j) for i, j in matches}


def _equation(settings: FilterSettings, state: FilterState, turn: LidarTurn, change: Array, i: int, j: int) -> Equation:
    """Return the equation of line *i* as wall *j*."""
    wall, lay, J, lidar = settings.machine.walls.room.walls[j], state.layout, state.hung.jacobian, turn.lidar
    m, n, (nx, ny) = len(state.lines.radii), np.array(wall.normal), wall.normal
    to_end, along, slope, lidar_offset, angle_per_rate, offset_per_rate = turn.sweeps[i].tolist()
    (wall_off, wall_turn), mount_yaw = state.built.wall_errors[j].tolist(), float(state.built.mount_errors[lidar, 2])
    bias, (angle_slope, offset_slope) = float(state.built.range_bias[lidar]), turn.bias_slopes[i].tolist()
    since_end, since_middle = state.displacement(change)
    x, y, _ = (state.motion.position - since_end).tolist()
    yaw = state.attitude.yaw - state.attitude.gyro_yaw + state.attitude.turn_yaw
    c, s = math.cos(yaw), math.sin(yaw)
    ahead, left = (turn.mount + state.built.mount_errors[lidar, :2]).tolist()
    lidar_x, lidar_y = x + c * ahead - s * left, y + s * ahead + c * left
    from_reference = wall.along[0] * lidar_x + wall.along[1] * lidar_y - wall.reference
    turned = wrap_angle(yaw + mount_yaw + float(turn.angles[i]) - wall.azimuth - wall_turn) - angle_slope * bias
    off = nx * lidar_x + ny * lidar_y - wall.distance - wall_off + wall_turn * from_reference
    off += float(turn.distances[i]) - offset_slope * bias
    # Rotating a line about the middle of its points shifts its perpendicular distance.
    coasting_time, middle_time = float(change[1, m + 3]), turn.end - to_end
    toward = n @ J[:2] * state.lines.radii
    H = np.zeros((2, lay.size))
    H[0, lay.yaw] = 1.0
    H[1, lay.position][:2] = n
    if state.motion.coasting:
        H[0, lay.velocity][:2] = slope * n
        H[1, lay.velocity][:2] = (slope * along - coasting_time) * n
        H[1, lay.radii] = -toward * change[1, :m]
    else:
        H[0, lay.radii] = by_rates = slope * toward * state.motion.drum_rates
        H[1, lay.radii] = along * by_rates - toward * change[1, :m]
        H[1, lay.velocity][:2] = -coasting_time * n
    H[1, lay.stretch] = -(n @ J[:2]) * (state.motion.last_encoder_time - middle_time - coasting_time)
    height = settings.machine.walls.lidars[lidar].mount[2]
    H[1, lay.attitude] = _attitude_slopes(n, yaw, np.array([ahead, left, height]))
    late = state.attitude.last_imu_time - turn.end
    angle = late + angle_per_rate
    offset = late * (along + lidar_offset) + offset_per_rate
    H[1, lay.gyro_bias] = (state.attitude.last_imu_time - middle_time) * H[1, lay.attitude]
    H[:, lay.gyro_bias.stop - 1] = angle, along * angle - offset
    H[:, lay.range_bias.start + lidar] = -angle_slope, -offset_slope
    H[:, lay.walls.start + 2 * j] = 0.0, -1.0
    H[:, lay.walls.start + 2 * j + 1] = -1.0, from_reference
    first = lay.mounts.start + 3 * lidar
    H[1, first : first + 2] = nx * c + ny * s, ny * c - nx * s
    H[0, first + 2] = 1.0
    H[1, lay.clock] = by_clock = -float(n @ moving_velocity(state)[:2])
    off += by_clock * state.built.clock_error
    R = turn.covariances[i] + settings.wall_angle_sigma**2 * _lever_covariance(along)
    R[1, 1] += settings.wall_sigma**2
    _add_motion_noise(settings, state, turn, i, since_middle, R)
    R *= noise_factor(state)
    return H, np.array([-turned, -off]), R


def _attitude_slopes(n: Array, yaw: float, point: Array) -> Array:
    """Derivative (3,) of n . point by tilt x and y, and yaw; *point* (3,), m, of the drum along its level axes."""
    c, s = math.cos(yaw), math.sin(yaw)
    ahead, left = n[0] * c + n[1] * s, n[1] * c - n[0] * s  # the normal along the drum's axes
    x, y, z = point.tolist()
    return np.array([-left * z, ahead * z, left * x - ahead * y])


def _add_motion_noise(
    settings: FilterSettings,
    state: FilterState,
    turn: LidarTurn,
    i: int,
    moved: Array,
    R: Array,
) -> None:
    """Add the error of linearising the displacement since the sweep of line *i*, and unmeasured rotation and motion."""
    to_end, along, slope, lidar_offset = turn.sweeps[i, :4].tolist()
    dt, far = min(to_end, 1.0), math.sqrt(float(moved @ moved))
    R[1, 1] += displacement_variance(settings, far)
    R[0, 0] += settings.gyro_noise**2 * abs(state.attitude.last_imu_time - (turn.end - to_end))
    if state.motion.coasting:
        R += settings.velocity_noise**2 * dt * slope**2 * _lever_covariance(along)
        R[1, 1] += settings.velocity_noise**2 * dt**3
    if state.has_long_steps or turn.begin < state.attitude.imu_gap_end:
        R += (settings.turn_rate_sigma * max(dt, 0.2)) ** 2 * _lever_covariance(-lidar_offset)
        R[1, 1] += (settings.turn_rate_sigma * settings.skew_time) ** 2


def displacement_variance(settings: FilterSettings, far: float) -> float:
    """Return the variance, m^2, of a displacement of B by *far*, m, that is linearised."""
    return (far * far / (2.0 * _LINE_LENGTH)) ** 2 + settings.travel_noise**2 * far


def _lever_covariance(arm: float) -> Array:
    """Covariance (2, 2) of a line's angle and distance for a rotation of variance 1, rad^2, at an *arm*, m."""
    return np.array([[1.0, arm], [arm, arm * arm]])


def _report(settings: FilterSettings, state: FilterState, turn: LidarTurn, used: float, rejected: float) -> None:
    """Report the faults of a turn. *used*, *rejected*: m, length of the lines that match a wall, and of the others."""
    monitor, source = state.monitor, turn.source
    if used:
        unseen = [kind for kind, last in state.judged.last_wall_times.items() if state.time - last > _WALL_TIMEOUT]
        if unseen:
            monitor.report(source, "walls", localisation.SENTENCES["parallel"])
        else:
            monitor.clear(source, "walls")
        state.judged.last_position_time = state.time
    elif not rejected:
        monitor.report(source, "walls", "no line in sight can be a wall at the estimated yaw")
    if rejected > used:
        state.judged.rejections[source] = state.judged.rejections.get(source, 0) + 1
        sentence, walls = "its walls contradict the estimated position: not used", settings.machine.walls
        yaws = state.attitude.yaw - walls.yaw_step, state.attitude.yaw + walls.yaw_step
        seen = find_constraints([turn], walls.visible, walls.room, yaws)
        why = contradicting_walls(seen, walls.room, walls.gate)
        monitor.report(source, "gate", f"{sentence}; {why}" if why else sentence)
    else:
        state.judged.rejections[source] = 0
        monitor.clear(source, "gate")


def noise_factor(state: FilterState) -> float:
    """Return the factor on a lidar's variance: larger while swing and rates, which distort a scan, settle."""
    return _SETTLING_FACTOR if state.time - state.motion.settling_start < _SETTLING_TIME else 1.0


def gated_update(
    state: FilterState, what: str, H: Array, innovation: Array, R: Array, fault: tuple[str, str], sentence: str
) -> bool:
    """Update by one measurement if it passes the gate, else count and report the rejection; return whether it did."""
    if not passes_gate(state.P, H, innovation, R)[0]:
        state.judged.rejections[what] = state.judged.rejections.get(what, 0) + 1
        if sentence and state.judged.rejections[what] >= _REPORTED:
            state.monitor.report(*fault, sentence)
        return False
    state.judged.rejections[what] = 0
    state.monitor.clear(*fault)
    update_state(state, fault[0], H, innovation, R)
    return True
