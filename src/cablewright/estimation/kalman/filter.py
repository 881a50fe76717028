"""The machine's state by one error-state Kalman filter of all sensors: `step` takes a frame, returns an estimate.

Encoders predict position and lengths, the gyro the attitude. Walls, floor, line angles, gravity and the distance sensor
update them, and with them the radii of the winch drums and the biases of gyro, accelerometer and lidars. It begins at
a position that others have found. docs/estimation.md has the equations.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final, NamedTuple

import numpy as np

from cablewright.estimation import slackness
from cablewright.estimation.camera import ERRORS
from cablewright.estimation.kalman import attitude, camera_update, lidar_update, line_update, vertical_update
from cablewright.estimation.kalman.gauss_markov import fade_clock, fade_survey
from cablewright.estimation.kalman.ground_map import GroundMap
from cablewright.estimation.kalman.settings import FilterSettings
from cablewright.estimation.kalman.state import (
    AsBuilt,
    DrumAttitude,
    DrumMotionState,
    FilterLayout,
    FilterState,
    Judged,
    Lines,
    Mean,
    diagonal,
    inflate_position,
)
from cablewright.estimation.reading_checks import (
    HISTORY_LENGTH,
    ReadingChecks,
    Turns,
    advance,
    follow_angles,
    process_turns,
    read,
    report_jump,
    report_line_sensors,
)
from cablewright.estimation.slackness import SlacknessState
from cablewright.estimation.time_buffer import TimeBuffer
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import CameraPose, Distance, Encoders, Estimate, Inertial, SensorFrame
from cablewright.kernels import Direct
from cablewright.kernels.covariance_prediction import add_multiples
from cablewright.kernels.filtering.estimate import tell
from cablewright.kernels.filtering.predict import JUMPED, ROLLED, TURNED
from cablewright.kernels.filtering.reckoning import AXES, OF_LINES
from cablewright.models.packed_views import PlatformNumbers

_POSITION_SIGMA: Final = 0.01  # m, of the first position
_WALL_RANGE: Final = 5.0  # m, typical, of a wall from a lidar
_TILT_SIGMA: Final = math.radians(0.15)  # at the start
_YAW_SIGMA: Final = math.radians(0.5)  # at the start
_LENGTH_SIGMA: Final = 5e-3  # m, at the start, besides the position's
_GROUND_SIGMA: Final = 0.1  # m, of the ground under the valve at the start
_MAX_GAP: Final = 0.1  # s without readings, or a step and a half, after which a sensor is not relied on
_JUMP_YAW: Final = math.radians(2.0)  # deviation of yaw while the clock jumped
_DOUBTFUL_TURNS: Final = 2  # rejected turns in a row after which position and yaw are as uncertain as at the start
_MIN_TRACKING_TIME: Final = 10.0  # s between two initialisations
_WINCH_DRIFT: Final = 5e-3  # m per root second, of a length whose winch is not measured
_MIN_SPEED: Final = 0.01  # m/s, from which B moves
_REST_TIME: Final = 4.0  # s of constant counts after which B is at rest unless lidars see it move
_COASTING_SPEED: Final = 0.05  # m/s, about the largest of B while nothing measures it
_DIRECTIONS: Final = np.array([1.0, 1.0, 0.2])  # vertical motion is slower
_EYE: Final = np.eye(3)
_TELL: Final = Direct(tell)
_MAX_DISTANCE: Final = 1e3  # m
_MAX_GROUND_REJECTIONS: Final = 5  # readings of the distance sensor in a row, after which the ground has changed


class FirstState(NamedTuple):
    """Initial state of the filter, found by another estimator."""

    time: float  # s
    position: Array  # (3,) m, world, of B
    velocity: Array  # (3,) m/s
    yaw: float  # rad
    lengths: Array  # (m,) m
    radii: Array  # (m,) m
    slackness: SlacknessState
    sigma: float = _POSITION_SIGMA  # m, of each coordinate


def start(settings: FilterSettings, checks: ReadingChecks) -> FilterState:
    """Return the Kalman filter's state before `begin`."""
    own = settings.machine
    errors = 0 if own.camera is None else ERRORS
    mean = Mean.of(FilterLayout.of(own.model.m, len(own.lidars), len(own.walls.room.walls), errors))
    weight = float(PlatformNumbers(own.model.packed.platform).weight)
    return FilterState(
        checks=checks,
        slackness=slackness.start(own.slackness),
        turns=Turns(TimeBuffer(1, 1), TimeBuffer(3, 1)),
        mean=mean,
        P=np.zeros((len(mean.x), len(mean.x))),
        motion=DrumMotionState(mean, weight / own.model.robot.scene.gravity),
        attitude=DrumAttitude(mean),
        lines=Lines(mean),
        built=AsBuilt(mean),
    )


def step(settings: FilterSettings, state: FilterState, frame: SensorFrame) -> Estimate:
    """Return the estimate after one frame; *state* changes in place. No frame raises an error; faults are reported."""
    if not state.checks.has_time(frame):
        return estimate(settings, state)
    dt = _advance_clock(settings, state, frame.time)
    fade_clock(state, dt)
    fade_survey(state, dt)
    line_angles = read(settings, settings.machine, state, frame, _HANDLERS)
    if state.time - state.motion.last_encoder_time > state.motion.max_gap:
        _start_coasting(state)
    if state.motion.coasting:
        _predict_coasting(settings, state, dt)
    line_update.update_jacobian(settings, state)
    if settings.machine.height is not None:
        state.built.ground_map.passing(*state.motion.position[:2].tolist())
    process_turns(settings, state, dt, _process_turn)
    if line_angles and state.taut is not None:
        follow_angles(settings.machine, state, line_angles, state.taut)
        report_line_sensors(state.monitor, settings.machine.model.robot.lines, state.slackness)
        line_update.update(settings, state)
    state.monitor.check_timeouts(state.time)
    return estimate(settings, state)


def _advance_clock(settings: FilterSettings, state: FilterState, now: float) -> float:
    """Advance the clock to *now*, s; return by how much, 0 where it was set."""
    dt = advance(state, now, _restart)
    state.motion.max_gap = max(_MAX_GAP, 1.5 * dt)
    if now - state.slackness.time > settings.machine.slackness.timeout:
        state.slackness = slackness.unknown(state.slackness)
    if state.has_long_steps:  # the gyro, read once a step, does not measure the rotation
        yaw = state.layout.yaw
        state.P[yaw, yaw] += (settings.turn_rate_sigma * dt) ** 2
    return dt


def begin(settings: FilterSettings, state: FilterState, first: FirstState) -> bool:
    """Take over the *first* state from another estimator; return whether lines have tangents there."""
    now, checks, m, mean = first.time, state.checks, settings.machine.model.m, state.mean
    walls = settings.machine.walls.room.walls
    begun = np.concatenate([first.position, first.velocity, [0.0, 0.0, first.yaw], first.lengths, first.radii])
    mean.x[:] = 0.0
    mean.x[: len(begun)] = begun
    state.lines.compliances[:] = 1.0
    state.time, state.slackness = now, first.slackness
    state.turns = Turns(TimeBuffer(m + 4, HISTORY_LENGTH), TimeBuffer(3, HISTORY_LENGTH))
    state.motion = replace(
        state.motion,
        travelled=np.zeros(m + 4),
        drum_rates=np.zeros(m),
        coasting=False,
        last_encoder_time=now if checks.last_encoders is None else checks.last_encoders.time,
        settling_start=now,
        bounce_end=-math.inf,
    )
    state.attitude = replace(
        state.attitude,
        angular_rate=np.zeros(3),
        gyro_yaw=0.0,
        measured_tilts=[],
        last_imu_time=now if checks.last_imu is None else checks.last_imu.time,
        shaken_time=-math.inf,
        shaken_since=-math.inf,
    )
    state.lines = Lines(
        mean,
        layer_radii=np.zeros(0) if settings.layers is None else settings.layers.radii(first.lengths),
        loosened=np.zeros(m),
        last_angle_time=state.lines.last_angle_time,
    )
    state.hung = replace(state.hung, by_compliance=np.zeros((3, m)))
    state.built = AsBuilt(mean, ground_map=state.built.ground_map)
    state.judged = Judged(state.judged.consistency, {}, now, dict.fromkeys({wall.kind for wall in walls}, now))
    state.built.ground_map.interrupt()
    line_update.update_jacobian(settings, state, at_once=True)
    if state.taut is None:
        return False
    state.P = _initial_covariance(settings, state, state.taut.toward, first.sigma)
    state.built.survey_variances = diagonal(state.P)[state.layout.placed]
    return True


def _initial_covariance(settings: FilterSettings, state: FilterState, toward: Array, position: float) -> Array:
    """Covariance of the state that it begins with, with a standard deviation of its *position*, m."""
    lay, clock = state.layout, state.checks.clock
    sigma = np.zeros(lay.size)
    lidars = settings.machine.walls.lidars
    turn = max((one.turn_sigma for one in lidars), default=0.0)  # of a mount that was taken to be exact
    sigma[lay.attitude] = _TILT_SIGMA, _TILT_SIGMA, math.hypot(_YAW_SIGMA, turn)
    sigma[lay.lengths], sigma[lay.radii], sigma[lay.ground] = _LENGTH_SIGMA, settings.radius_sigma, _GROUND_SIGMA
    sigma[lay.gyro_bias], sigma[lay.accelerometer_bias] = settings.gyro_bias_sigma, settings.accelerometer_bias_sigma
    sigma[lay.range_bias] = [max(lidar.bias_sigma, 1e-6) for lidar in lidars] + [settings.height_bias_sigma]
    sigma[lay.walls] = [
        each for wall in settings.machine.walls.room.walls for each in (wall.distance_sigma, wall.angle_sigma)
    ]
    sigma[lay.mounts] = [each for one in lidars for each in (one.place_sigma, one.place_sigma, one.turn_sigma)]
    if settings.machine.height is not None:
        own = settings.machine.height
        sigma[lay.vertical_mount] = np.repeat([own.place_sigma, own.turn_sigma], 3)
    sigma[lay.zeros], sigma[lay.stretch] = settings.zero_sigma, settings.stretch_rate_sigma * state.lines.lengths
    sigma[lay.compliances] = settings.compliance_sigma
    sigma[lay.clock] = 0.0 if clock is None else clock.sigma
    if settings.machine.camera is not None:
        sigma[lay.camera] = settings.machine.camera.sigmas
    P = np.diag(sigma**2)
    rows = np.r_[lay.position, lay.lengths]
    spread = np.vstack([np.eye(3), toward])
    P[np.ix_(rows, rows)] += (position**2 + (turn * _WALL_RANGE) ** 2) * (spread @ spread.T)
    return P


def is_lost(settings: FilterSettings, state: FilterState) -> bool:
    """Return whether a lidar's scans have been rejected too often in a row: the position may be wrong."""
    rejections = state.judged.rejections
    turns = max([rejections.get(source, 0) for source in settings.machine.lidars], default=0) if rejections else 0
    tracked = state.time - state.motion.settling_start > _MIN_TRACKING_TIME
    return not math.isfinite(state.judged.sound) or (turns >= settings.machine.max_rejections and tracked)


def _is_contradicted(settings: FilterSettings, state: FilterState) -> bool:
    """Whether all horizontal lidars, or without any the camera, contradict it one after another: B may be elsewhere."""
    if not settings.machine.lidars:
        return state.judged.rejections.get("camera", 0) >= _DOUBTFUL_TURNS or state.monitor.is_active(
            *camera_update.MOVED
        )
    found = state.judged.rejections
    return bool(found) and all(found.get(source, 0) >= _DOUBTFUL_TURNS for source in settings.machine.lidars)


def _restart(state: FilterState, now: float) -> None:
    """Restart at time *now*, s."""
    state.attitude.measured_tilts.clear()
    state.built.ground_map = GroundMap()
    state.hung.time = state.lines.last_angle_time = state.motion.bounce_end = -math.inf
    state.attitude.shaken_time = state.attitude.shaken_since = -math.inf
    state.motion.last_encoder_time = state.motion.last_motion_time = state.attitude.last_imu_time = now
    state.judged.last_position_time = state.motion.settling_start = now
    state.judged.last_wall_times = dict.fromkeys(state.judged.last_wall_times, now)
    inflate_position(state, _COASTING_SPEED)  # moved for an unknown time
    yaw = state.layout.yaw
    state.P[yaw, yaw] += _JUMP_YAW**2


def _predict_from_encoders(settings: FilterSettings, state: FilterState, reading: Encoders) -> None:
    """Predict B and the lengths; counts after a gap are not used, because lidars have updated meanwhile."""
    motion, now, last = state.motion, reading.time, state.checks.last_encoders
    late, rest = now - motion.last_encoder_time > motion.max_gap, now - motion.last_motion_time
    pauses = motion.max_gap < rest <= motion.max_gap + _REST_TIME
    motion.last_encoder_time, state.checks.last_encoders = now, reading
    if last is None:
        state.turns.motion.add(now, motion.travelled)
        return
    dt, rotation = float(now - last.time), np.empty(len(motion.drum_rates))
    counts = np.array(reading.counts, dtype=np.int64), np.array(last.counts, dtype=np.int64)
    rolls = not (late or motion.coasting)
    shown = line_update.reel(settings, state, counts, rotation, dt, rolls=rolls, pauses=pauses)
    if shown == JUMPED:
        report_jump(state.checks)
        if dt > 0.0:
            inflate_position(state, _COASTING_SPEED * dt)
    else:
        if shown & TURNED:
            motion.last_motion_time = now
            if motion.coasting:
                _stop_coasting(state)
        elif pauses:  # B is at rest, or the encoders are stuck
            _start_coasting(state)
        elif motion.coasting and not late and not state.monitor.is_active("encoders", "stand"):
            _set_at_rest(state)
        if not (late or shown & ROLLED):
            if motion.coasting:
                motion.drum_angles[:] += rotation
            else:
                line_update.reel(settings, state, counts, rotation, dt, rolls=True, pauses=False)
    state.turns.motion.add(now, motion.travelled)


def _update_ground(settings: FilterSettings, state: FilterState, reading: Distance) -> None:
    """Update by the distance sensor: height of B over the ground under the valve."""
    depth, lay = settings.machine.valve_depth, state.layout
    if depth is None or not abs(reading.distance) < _MAX_DISTANCE or reading.time < state.motion.bounce_end:
        return
    H = np.zeros((1, lay.size))
    H[0, lay.position][2], H[0, lay.ground] = 1.0, -1.0
    innovation = np.array([reading.distance + depth - float(state.motion.position[2]) + state.built.ground_height])
    R = np.array([[settings.distance_sigma**2]])
    passes = lidar_update.gated_update(state, "distance", H, innovation, R, ("distance", "gate"), "")
    if not passes and state.judged.rejections["distance"] > _MAX_GROUND_REJECTIONS:
        state.P[lay.ground, lay.ground] += float(innovation[0]) ** 2


_HANDLERS: Final[dict[type, Callable[[FilterSettings, FilterState, Any], None]]] = {
    Inertial: attitude.read,
    Encoders: _predict_from_encoders,
    Distance: _update_ground,
    CameraPose: camera_update.update,
}
"""What reads each kind of reading, but scans, line angles and climate."""


def _start_coasting(state: FilterState) -> None:
    """Predict without encoders from now on, at the last velocity or any smaller one."""
    if state.motion.coasting:
        return
    state.motion.coasting = True
    _set_velocity_sigma(state, 0.5 * _COASTING_SPEED * _DIRECTIONS)


def _set_at_rest(state: FilterState) -> None:
    """Take B to be at rest: no winch drum has turned for a while, and no lidar saw B move."""
    state.motion.coasting = False
    _set_velocity_sigma(state, np.zeros(3))
    state.motion.drum_rates = np.zeros_like(state.motion.drum_rates)


def _set_velocity_sigma(state: FilterState, sigma: Array) -> None:
    """Give the velocity a standard deviation *sigma* (3,), m/s, and no correlation."""
    velocity = state.layout.velocity
    state.P[velocity] = 0.0
    state.P[:, velocity] = 0.0
    state.P[velocity, velocity] = np.diag(sigma**2)


def _stop_coasting(state: FilterState) -> None:
    """Predict from the encoders again. The velocity keeps its covariance, for turns that began before."""
    state.motion.coasting = False
    state.motion.settling_start = state.time  # turns that began before are distorted: lidars count less for a while
    inflate_position(state, _POSITION_SIGMA)
    state.monitor.clear("encoders", "stand")


def _predict_coasting(settings: FilterSettings, state: FilterState, dt: float) -> None:
    """Predict B and the lengths by the velocity, without encoders, over *dt*, s."""
    lay, taut, P = state.layout, state.taut, state.P
    if taut is None or not dt > 0.0:
        return
    add_multiples(P, lay.position.start, lay.velocity.start, dt * _EYE)
    add_multiples(P, lay.lengths.start, lay.velocity.start, dt * taut.toward)
    variances = diagonal(P)
    variances[lay.velocity] += (settings.velocity_noise * _DIRECTIONS) ** 2 * dt
    variances[lay.lengths] += _WINCH_DRIFT**2 * dt
    moved = dt * state.motion.velocity
    state.motion.position += moved
    state.lines.lengths += taut.toward @ moved
    state.motion.coasted[:] += np.append(moved, dt)
    state.turns.motion.add(state.time, state.motion.travelled)


def _process_turn(settings: FilterSettings, state: FilterState) -> None:
    """Do the next part of the work on the queued lidar scans: as much as one time step has time for."""
    if state.turns.extracted is not None:
        source = state.turns.extracted.source
        lidar_update.update(settings, state)
        _report_stuck_encoders(state)
        rejections = state.judged.rejections.get(source, 0)
        if rejections and not state.motion.coasting:  # B may move though the counts do not
            state.motion.last_motion_time = max(state.motion.last_motion_time, state.time - state.motion.max_gap)
        if rejections >= _DOUBTFUL_TURNS:
            inflate_position(state, _POSITION_SIGMA)
            yaw = state.layout.yaw
            state.P[yaw, yaw] += _YAW_SIGMA**2
        return
    if not state.turns.pending:
        return
    scan = state.turns.pending.pop(0)
    if scan.time - state.attitude.last_imu_time > state.motion.max_gap:
        attitude.predict_without_imu(settings, state, scan.time)
    if scan.times[0] < state.motion.bounce_end:
        return
    if scan.source == "vertical":
        vertical_update.update(settings, state, scan)
    else:
        lidar_update.extract(settings, state, scan)


def _report_stuck_encoders(state: FilterState) -> None:
    """Report that the counts are constant while the lidars see B move."""
    variance = float(np.trace(state.P[state.layout.velocity, state.layout.velocity]))
    if (
        state.motion.coasting
        and state.time - state.motion.last_encoder_time < state.motion.max_gap
        and _is_moving(state.motion.velocity, variance)
    ):
        state.monitor.report("encoders", "stand", "no winch drum turns by its counts, but the drum moves: not used")


def _is_moving(velocity: Array, variance: float) -> bool:
    """Whether a *velocity* (3,), m/s, with that *variance* in space is certainly not zero."""
    speed = float(np.sqrt(velocity @ velocity))
    return speed > _MIN_SPEED and speed > 2.0 * math.sqrt(variance)


def estimate(settings: FilterSettings, state: FilterState) -> Estimate:
    """Return the state, predicted to the current time, with its covariance."""
    motion, own, monitor, m = state.motion, settings.machine, state.monitor, settings.machine.model.m
    found, taut, hung = np.empty(OF_LINES + 3 * m + AXES**2), state.taut, state.hung
    assert taut is not None  # `begin` has found it
    (x, _, at), ages = state.mean, (state.time - motion.last_encoder_time, state.time - state.attitude.last_imu_time)
    variance, state.judged.sound = _TELL.call(
        x, state.P, at, hung.jacobian, taut.lengths, taut.toward, hung.position, motion.drum_rates,
        state.attitude.angular_rate, settings.shown, state.judged.survey_doubt,
        *map(float, ages), motion.max_gap, motion.coasting, found,
    )  # fmt: skip
    found.flags.writeable = False
    position, excess = found[:3], found[OF_LINES + m : OF_LINES + 2 * m]
    sure = variance <= settings.max_position_sigma**2
    current = state.time - state.judged.last_position_time <= own.position_timeout
    return Estimate(
        state.time,
        position,
        found[3:6],
        found[6:OF_LINES],
        found[OF_LINES : OF_LINES + m],
        excess,
        excess > own.slackness.threshold,
        found[OF_LINES + 2 * m : OF_LINES + 3 * m],
        found[OF_LINES + 3 * m :].reshape(AXES, AXES),
        monitor.faults,
        valid=sure and current and not monitor.is_active("encoders", "lost") and not _is_contradicted(settings, state),
        clearance=float(position[2]) + state.clearance_offset,
        consistency=state.judged.consistency.means,
    )
