"""The machine's state by one error-state Kalman filter of all sensors: `step` takes a frame, returns an estimate.

Encoders predict position and lengths, the gyro the attitude. Walls, floor, line angles, gravity and the distance sensor
update them, and with them the radii of the winch drums and the biases of gyro, accelerometer and lidars. It begins at
a position that others have found. docs/estimation.md has the equations.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from cablewright.arrays import Array
from cablewright.estimation import slackness
from cablewright.estimation.kalman import attitude, lidar_update, line_update, vertical_update
from cablewright.estimation.kalman.fading import fade_clock, fade_survey
from cablewright.estimation.kalman.ground_map import GroundMap
from cablewright.estimation.kalman.state import FilterLayout, FilterSettings, FilterState, diagonal, inflate_position
from cablewright.estimation.reading_checks import (
    HISTORY_LENGTH,
    LONG_STEP,
    MAX_LEAP,
    ReadingChecks,
    accept_imu,
    drum_rotation,
    queue_scan,
    report_line_sensors,
)
from cablewright.estimation.slackness import SlacknessState
from cablewright.estimation.tilt import rotation_vector
from cablewright.estimation.time_buffer import TimeBuffer
from cablewright.kernels.covariance import add_multiples
from cablewright.models.packed_views import PlatformNumbers
from cablewright.signals import (
    Climate,
    Distance,
    Encoders,
    Estimate,
    Inertial,
    LineAngles,
    Reading,
    Scan,
    SensorFrame,
    frozen,
)

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
_MAX_DISTANCE: Final = 1e3  # m
_MAX_GROUND_REJECTIONS: Final = 5  # readings of the distance sensor in a row, after which the ground has changed


class FirstState(NamedTuple):
    """What the filter begins with."""

    time: float  # s
    position: Array  # (3,) m, world, of B
    velocity: Array  # (3,) m/s
    yaw: float  # rad
    lengths: Array  # (m,) m
    radii: Array  # (m,) m
    slackness: SlacknessState


def start(settings: FilterSettings, checks: ReadingChecks) -> FilterState:
    """Return the state before `begin`."""
    own = settings.machine
    lay = FilterLayout.of(own.model.m, len(own.lidars), len(own.walls.room.walls))
    weight = float(PlatformNumbers(own.model.packed.platform).weight)
    return FilterState(
        checks,
        lay,
        slackness.start(own.slackness),
        weight / own.model.robot.scene.gravity,
        np.zeros((lay.size, lay.size)),
    )


def step(settings: FilterSettings, state: FilterState, frame: SensorFrame) -> Estimate:
    """Return the estimate after one frame; *state* changes in place. No frame raises an error; faults are reported."""
    if not state.checks.has_time(frame):
        return estimate(settings, state)
    dt = _advance_clock(settings, state, frame.time)
    line_angles = []
    fade_clock(state, dt)
    fade_survey(state, dt)
    for reading in state.checks.accepted(frame):
        if isinstance(reading, LineAngles):
            line_angles.append(reading)
        else:
            _process(settings, state, reading)
    if state.time - state.last_encoder_time > state.max_gap:
        _start_coasting(state)
    if state.coasting:
        _predict_coasting(settings, state, dt)
    line_update.update_jacobian(settings, state)
    if settings.machine.height is not None:
        state.ground_map.passing(*state.position[:2].tolist())
    _process_scan(settings, state)
    while dt > LONG_STEP and (state.pending_scans or state.extracted_turn is not None):
        _process_scan(settings, state)
    if line_angles and state.taut is not None:
        for reading in line_angles:  # all of them, as lines vibrate
            state.slackness = slackness.step(settings.machine.slackness, state.slackness, reading, state.taut)
        report_line_sensors(state.monitor, settings.machine.model.robot.lines, state.slackness)
        line_update.update(settings, state)
    state.monitor.check_timeouts(state.time)
    return estimate(settings, state)


def _advance_clock(settings: FilterSettings, state: FilterState, now: float) -> float:
    """Advance the clock to *now*, s; return by how much, 0 where it was set."""
    if not 0.0 < now - state.time <= MAX_LEAP and math.isfinite(state.time):
        _restart_clock(state, now)
    dt = now - state.time if math.isfinite(state.time) else 0.0
    state.time, state.max_gap = now, max(_MAX_GAP, 1.5 * dt)
    if now - state.slackness.time > settings.machine.slackness.timeout:
        state.slackness = state.slackness._replace(excess=np.full_like(state.slackness.excess, np.nan))
    if state.has_long_steps:  # the gyro, read once a step, does not measure the rotation
        yaw = state.layout.yaw
        state.P[yaw, yaw] += (settings.turn_rate_sigma * dt) ** 2
    return dt


def begin(settings: FilterSettings, state: FilterState, first: FirstState) -> bool:
    """Take the state over from those who found the *first* one; return whether lines have tangents there."""
    now = state.time = first.time
    lay, m = state.layout, settings.machine.model.m
    state.position, state.lengths = first.position.copy(), first.lengths.copy()
    state.velocity, state.yaw = first.velocity.copy(), first.yaw
    state.tilt, state.slackness = np.zeros(2), first.slackness
    state.accelerometer_bias, state.gyro_bias, state.angular_rate = np.zeros(2), np.zeros(3), np.zeros(3)
    state.measured_tilts.clear()
    state.radii, state.range_bias = first.radii.copy(), np.zeros(len(settings.machine.lidars) + 1)
    if settings.layers is not None:
        state.layer_radii = settings.layers.radii(state.lengths)
    state.wall_errors = np.zeros((len(settings.machine.walls.room.walls), 2))
    state.mount_errors, state.vertical_mount_error = np.zeros((len(settings.machine.lidars), 3)), np.zeros(6)
    state.zeros, state.clock_error, state.stretch_rates = np.zeros(m), 0.0, np.zeros(m)
    state.compliances, state.loosened, state.by_compliance = np.ones(m), np.zeros(m), np.zeros((3, m))
    state.drum_angles, state.drum_rates, state.ground_height = np.zeros(m), np.zeros(m), 0.0
    state.motion_history, state.attitude_history = TimeBuffer(m + 4, HISTORY_LENGTH), TimeBuffer(3, HISTORY_LENGTH)
    state.gyro_yaw, state.coasted, state.stretching, state.unfaded = 0.0, np.zeros(4), 0.0, 0.0
    checks = state.checks
    state.last_encoder_time = now if checks.last_encoders is None else checks.last_encoders.time
    state.last_imu_time = now if checks.last_imu is None else checks.last_imu.time
    state.settling_start, state.last_position_time, state.coasting = now, now, False
    state.extracted_turn = None
    state.shaken_time = state.shaken_since = state.bounce_end = -math.inf
    state.angles_refused_since = math.inf
    state.pending_scans.clear()
    state.rejections.clear()
    state.ground_map.interrupt()
    state.last_wall_times = dict.fromkeys({wall.kind for wall in settings.machine.walls.room.walls}, now)
    line_update.update_jacobian(settings, state, at_once=True)
    if state.taut is None:
        return False
    state.P = _initial_covariance(settings, state, state.taut.toward)
    state.survey_variances = diagonal(state.P)[lay.surveyed].copy()
    return True


def _initial_covariance(settings: FilterSettings, state: FilterState, toward: Array) -> Array:
    """Covariance of the state that it begins with."""
    lay, clock = state.layout, state.checks.clock
    sigma = np.zeros(lay.size)
    lidars = settings.machine.walls.lidars
    turn = max(one.turn_sigma for one in lidars)  # of a mount that was taken to be exact
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
    sigma[lay.zeros], sigma[lay.stretch] = settings.zero_sigma, settings.stretch_rate_sigma * state.lengths
    sigma[lay.compliances] = settings.compliance_sigma
    sigma[lay.clock] = 0.0 if clock is None else clock.sigma
    P = np.diag(sigma**2)
    rows = np.r_[lay.position, lay.lengths]
    spread = np.vstack([np.eye(3), toward])
    P[np.ix_(rows, rows)] += (_POSITION_SIGMA**2 + (turn * _WALL_RANGE) ** 2) * (spread @ spread.T)
    return P


def is_lost(settings: FilterSettings, state: FilterState) -> bool:
    """Whether a lidar's turns have been rejected too often in a row: the position may be wrong."""
    turns = max((state.rejections.get(source, 0) for source in settings.machine.lidars), default=0)
    lost = not math.isfinite(float(state.P.sum()) + float(state.position.sum()))  # no number in it is near overflow
    return lost or (turns >= settings.machine.max_rejections and state.time - state.settling_start > _MIN_TRACKING_TIME)


def _is_contradicted(settings: FilterSettings, state: FilterState) -> bool:
    """Whether all horizontal lidars see walls that are elsewhere, turn after turn: B may be where they say."""
    return all(state.rejections.get(source, 0) >= _DOUBTFUL_TURNS for source in settings.machine.lidars)


def _restart_clock(state: FilterState, now: float) -> None:
    """Restart at time *now*, s: earlier readings cannot be ordered with later ones."""
    state.monitor.restart(now, f"the clock jumped from {state.time:g} to {now:g} s: earlier readings are dropped")
    state.checks.reset()
    state.motion_history.clear()
    state.attitude_history.clear()
    state.pending_scans.clear()
    state.measured_tilts.clear()
    state.slackness = slackness.restarted(state.slackness)
    state.extracted_turn, state.ground_map = None, GroundMap()
    state.taut_time = state.last_angle_time = state.shaken_time = state.shaken_since = state.bounce_end = -math.inf
    state.time = -math.inf
    state.last_encoder_time = state.last_motion_time = state.last_imu_time = now
    state.last_position_time = state.settling_start = now
    state.last_wall_times = dict.fromkeys(state.last_wall_times, now)
    inflate_position(state, _COASTING_SPEED)  # moved for an unknown time
    yaw = state.layout.yaw
    state.P[yaw, yaw] += _JUMP_YAW**2


def _process(settings: FilterSettings, state: FilterState, reading: Reading) -> None:
    """Process any reading but line angles."""
    own, checks = settings.machine, state.checks
    if isinstance(reading, Inertial):
        if accept_imu(checks, own.tilt, reading):
            attitude.predict(settings, state, reading)
    elif isinstance(reading, Encoders):
        _predict_from_encoders(settings, state, reading)
    elif isinstance(reading, Distance):
        _update_ground(settings, state, reading)
    elif isinstance(reading, Climate) and state.creep is not None:
        state.creep.read(reading)
    elif isinstance(reading, Scan) and reading.source in (*own.lidars, "vertical"):
        queue_scan(checks, state.pending_scans, reading, own.walls.kept_turns)


def _predict_from_encoders(settings: FilterSettings, state: FilterState, reading: Encoders) -> None:
    """Predict B and the lengths; counts after a gap are not used, because lidars have updated meanwhile."""
    own = settings.machine
    rotation, dt = drum_rotation(state.checks, reading, own.counts_per_radian, own.max_drum_speed)
    late = reading.time - state.last_encoder_time > state.max_gap
    state.last_encoder_time = reading.time
    if rotation is None:
        if dt > 0.0:
            inflate_position(state, _COASTING_SPEED * dt)
    else:
        rest = reading.time - state.last_motion_time
        if any(rotation.tolist()):
            state.last_motion_time = reading.time
            if state.coasting:
                _stop_coasting(state)
        elif state.max_gap < rest <= state.max_gap + _REST_TIME:  # B is at rest, or the encoders are stuck
            _start_coasting(state)
        elif state.coasting and not late and not state.monitor.is_active("encoders", "stand"):
            _set_at_rest(state)
        if not late:
            state.drum_angles = state.drum_angles + rotation
            if not state.coasting:
                line_update.predict(settings, state, rotation, dt)
    state.motion_history.add(reading.time, np.concatenate([state.drum_angles, state.coasted]))


def _update_ground(settings: FilterSettings, state: FilterState, reading: Distance) -> None:
    """Update by the distance sensor: height of B over the ground under the valve."""
    depth, lay = settings.machine.valve_depth, state.layout
    if depth is None or not abs(reading.distance) < _MAX_DISTANCE or reading.time < state.bounce_end:
        return
    H = np.zeros((1, lay.size))
    H[0, lay.position][2], H[0, lay.ground] = 1.0, -1.0
    innovation = np.array([reading.distance + depth - float(state.position[2]) + state.ground_height])
    R = np.array([[settings.distance_sigma**2]])
    passes = lidar_update.gated_update(state, "distance", H, innovation, R, ("distance", "gate"), "")
    if not passes and state.rejections["distance"] > _MAX_GROUND_REJECTIONS:
        state.P[lay.ground, lay.ground] += float(innovation[0]) ** 2


def _start_coasting(state: FilterState) -> None:
    """Predict without encoders from now on, at the last velocity or any smaller one."""
    if state.coasting:
        return
    state.coasting = True
    _set_velocity_sigma(state, 0.5 * _COASTING_SPEED * _DIRECTIONS)


def _set_at_rest(state: FilterState) -> None:
    """Take B to be at rest: no winch drum has turned for a while, and no lidar saw B move."""
    state.coasting = False
    _set_velocity_sigma(state, np.zeros(3))
    state.drum_rates = np.zeros_like(state.drum_rates)


def _set_velocity_sigma(state: FilterState, sigma: Array) -> None:
    """Give the velocity a standard deviation *sigma* (3,), m/s, and no correlation."""
    velocity = state.layout.velocity
    state.P[velocity] = 0.0
    state.P[:, velocity] = 0.0
    state.P[velocity, velocity] = np.diag(sigma**2)


def _stop_coasting(state: FilterState) -> None:
    """Predict from the encoders again. The velocity keeps its covariance, for turns that began before."""
    state.coasting = False
    state.settling_start = state.time  # turns that began before are distorted: lidars count less for a while
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
    moved = dt * state.velocity
    state.position = state.position + moved
    state.lengths = state.lengths + taut.toward @ moved
    state.coasted = state.coasted + np.append(moved, dt)
    state.motion_history.add(state.time, np.concatenate([state.drum_angles, state.coasted]))


def _process_scan(settings: FilterSettings, state: FilterState) -> None:
    """Do the next part of the work on the queued lidar turns: as much as one time step has time for."""
    if state.extracted_turn is not None:
        source = state.extracted_turn.source
        lidar_update.update(settings, state)
        _report_stuck_encoders(state)
        rejections = state.rejections.get(source, 0)
        if rejections and not state.coasting:  # B may move though the counts do not
            state.last_motion_time = max(state.last_motion_time, state.time - state.max_gap)
        if rejections >= _DOUBTFUL_TURNS:
            inflate_position(state, _POSITION_SIGMA)
            yaw = state.layout.yaw
            state.P[yaw, yaw] += _YAW_SIGMA**2
        return
    if not state.pending_scans:
        return
    scan = state.pending_scans.pop(0)
    if scan.time - state.last_imu_time > state.max_gap:
        attitude.predict_without_imu(settings, state, scan.time)
    if scan.times[0] < state.bounce_end:
        return
    if scan.source == "vertical":
        vertical_update.update(settings, state, scan)
    else:
        lidar_update.extract(settings, state, scan)


def _report_stuck_encoders(state: FilterState) -> None:
    """Report that the counts are constant while the lidars see B move."""
    variance = float(np.trace(state.P[state.layout.velocity, state.layout.velocity]))
    if state.coasting and state.time - state.last_encoder_time < state.max_gap and _is_moving(state.velocity, variance):
        state.monitor.report("encoders", "stand", "no winch drum turns by its counts, but the drum moves: not used")


def _is_moving(velocity: Array, variance: float) -> bool:
    """Whether a *velocity* (3,), m/s, with that *variance* in space is certainly not zero."""
    speed = float(np.sqrt(velocity @ velocity))
    return speed > _MIN_SPEED and speed > 2.0 * math.sqrt(variance)


def estimate(settings: FilterSettings, state: FilterState) -> Estimate:
    """Return the state, predicted to the current time, with its covariance."""
    if not state.coasting:
        state.velocity = state.jacobian @ (state.radii * state.drum_rates)
    dt = min(max(state.time - state.last_encoder_time, 0.0), state.max_gap) if not state.coasting else 0.0
    position, paid_out = state.position + dt * state.velocity, dt * state.radii * state.drum_rates
    late, (wx, wy, wz) = min(max(state.time - state.last_imu_time, 0.0), state.max_gap), state.angular_rate.tolist()
    covariance = _covariance(settings, state)
    own, monitor = settings.machine, state.monitor
    sure = float(covariance[0, 0] + covariance[1, 1] + covariance[2, 2]) <= settings.max_position_sigma**2
    current = state.time - state.last_position_time <= own.position_timeout
    x, y = state.tilt.tolist()
    excess = line_update.excess(state)
    return Estimate(
        state.time,
        _sealed(position),
        frozen(state.velocity),
        frozen(rotation_vector(state.yaw + late * wz, x + late * wx, y + late * wy)),
        _sealed(state.lengths + paid_out),
        _sealed(excess),
        excess > own.slackness.threshold,
        frozen(state.radii),
        covariance,
        monitor.faults,
        valid=sure and current and not monitor.is_active("encoders", "lost") and not _is_contradicted(settings, state),
        clearance=float(position[2]) + state.clearance_offset,
        consistency=state.consistency.means,
    )


def _sealed(fresh: Array) -> Array:
    """Return a *fresh* array, of which nobody else has a reference, as read-only."""
    fresh.flags.writeable = False
    return fresh


def _covariance(settings: FilterSettings, state: FilterState) -> Array:
    """Covariance (9, 9) of position, velocity and rotation in space."""
    lay = state.layout
    size = lay.radii.stop  # of the states that these depend on, which come first
    G = np.zeros((9, size))
    G[:3, lay.position] = _EYE
    if state.coasting:
        G[3:6, lay.velocity] = _EYE
    else:
        G[3:6, lay.radii] = state.jacobian * (state.radii * state.drum_rates)
    x = lay.attitude.start
    G[6, x] = G[7, x + 1] = math.cos(state.yaw)
    G[7, x] = sine = math.sin(state.yaw)
    G[6, x + 1] = -sine
    G[8, x + 2] = 1.0
    covariance = G @ state.P[:size, :size] @ G.T
    diagonal = covariance.reshape(-1)[::10]
    diagonal[3:6] += settings.velocity_sigma**2
    dt = state.time - state.last_imu_time
    diagonal[6:] += settings.attitude_sigma**2
    if dt > state.max_gap:
        diagonal[6:8] += settings.swing_sigma**2
        diagonal[8] += settings.turn_rate_sigma**2 * dt * (1.0 + dt)
    return _sealed(0.5 * (covariance + covariance.T))
