"""The estimator of Merlet and Papegay 2023, section III: `step` takes a frame and returns an estimate.

About once a second lidars give the platform's pose and line accelerometers the slack line; from both follow the lengths
(update). At every step in between encoders, and creep as described, predict the lengths, and a forward solve the
platform's position.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final

import numpy as np

from cablewright.estimation import slackness, tilt
from cablewright.estimation.height import HeightSettings, estimate_height
from cablewright.estimation.known_creep import KnownCreep, known_creep
from cablewright.estimation.lidar import localisation
from cablewright.estimation.lidar.localisation import WallPose, WallState
from cablewright.estimation.lidar.wall_lines import LidarTurn, scanned, turn_of
from cablewright.estimation.merlet2023 import drum_radius, lengths
from cablewright.estimation.merlet2023.state import Located, ObserverSettings, ObserverState
from cablewright.estimation.reading_checks import (
    HISTORY_LENGTH,
    ReadingChecks,
    Turns,
    accept_imu,
    advance,
    drum_rotation,
    follow_angles,
    process_turns,
    read,
    report_line_sensors,
)
from cablewright.estimation.time_buffer import TimeBuffer
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import Status
from cablewright.foundation.signals import Distance, Encoders, Estimate, Inertial, Scan, SensorFrame, frozen
from cablewright.solvers.continuation import TrackerSettings
from cablewright.solvers.taut import taut_at

_BIAS_GAIN: Final = 0.1  # of the update of the yaw rate's bias by one lidar yaw
_STUCK_ENCODER_ERROR: Final = 0.01  # m of a length's change without rotation of any drum
_AROUND: Final = np.linspace(-math.pi, math.pi, 360, endpoint=False)
_SQUARE_ROOM: Final = 2.0 / np.maximum(np.abs(np.cos(_AROUND)), np.abs(np.sin(_AROUND)))
_FRESH: Final = 0.5  # s: oldest end of a turn from which a first position is found, unless B stands still
_STANDS: Final = 1e-3  # m/s of each line, up to which B does
_STALE_TURNS: Final = 2.5  # turns without a scan after which a lidar's older turns are dropped
_SAME_POSITION: Final = 0.03  # m from the expected position, for an ambiguous one to be accepted
_FLOOR_TOLERANCE: Final = 0.02  # m above the expected floor, of floor points, ...
_FLOOR_DRIFT: Final = 0.02  # ... and how much more for each metre that B moved without seeing the floor
_MAX_ENCODER_GAP: Final = 0.1  # s without counts


def start(settings: ObserverSettings) -> ObserverState:
    """Return the estimator's state before the first frame.

    Runs the kernels once, so that no step waits for their compilation.
    """
    scene = settings.model.robot.scene
    middle = 0.5 * (np.array(scene.frame_min) + np.array(scene.frame_max))
    no_reading = slackness.start(settings.slackness)
    hung = lengths.hang_at(settings.slackness, no_reading, middle, TrackerSettings(certify=settings.certify))
    if not isinstance(hung, str):
        tracker, paid_out = hung
        lengths.move_to(settings.slackness, no_reading, tracker, paid_out, middle)
    first = turn_of(settings.walls.lidars[0], 0, settings.walls.search, _AROUND, _SQUARE_ROOM)
    localisation.step(settings.walls, localisation.start(), first)
    return ObserverState(
        checks=ReadingChecks.of(settings),
        slackness=no_reading,
        turns=Turns(TimeBuffer(3, HISTORY_LENGTH), TimeBuffer(3, HISTORY_LENGTH)),
        creep=known_creep(settings.model.robot),
        located=Located(localisation.start()),
        radius=drum_radius.start(settings.radius),
        tilt=tilt.start(),
    )


def step(settings: ObserverSettings, state: ObserverState, frame: SensorFrame) -> Estimate:
    """Return the estimate after one frame; *state* changes in place. No frame raises an error; faults are reported."""
    if not state.checks.has_time(frame):
        return _estimate(settings, state)
    dt = advance(state, frame.time, _restart)
    line_angles = read(settings, settings, state, frame, _HANDLERS)
    if state.turns.pending:
        state.located.gather_start = min(state.located.gather_start, state.time)
    _predict_position(settings, state, dt)
    process_turns(settings, state, dt, _process_turn)
    complete = state.located.gathered_sources.issuperset((*settings.lidars, "vertical"))
    due = complete or state.time - state.located.gather_start > settings.gather_time
    if due and not state.turns.pending and state.turns.extracted is None:
        _update_lengths(settings, state)
    if state.tracker is not None:
        state.taut = taut_at(settings.model, state.tracker.pose)
        follow_angles(settings, state, line_angles, state.taut)
        if line_angles:
            report_line_sensors(state.monitor, settings.model.robot.lines, state.slackness)
    elif line_angles and np.isfinite(state.located.position_offset).all():
        follow_angles(
            settings,
            state,
            line_angles,
            taut_at(settings.model, state.located.position_offset + state.odometry.position),
        )
    state.monitor.check_timeouts(state.time)
    return _estimate(settings, state)


def _process_turn(settings: ObserverSettings, state: ObserverState) -> None:
    """Do the next part of the work on the queued lidar scans: as much as one time step has time for."""
    if state.turns.extracted is not None:
        _localise(settings, state, state.turns.extracted)
    elif state.turns.pending:
        _extract(settings, state, state.turns.pending.pop(0))


def _restart(state: ObserverState, now: float) -> None:
    """Restart at time *now*, s."""
    located = state.located
    located.gathered_sources.clear()
    located.last_turn_times.clear()
    located.turn_ends, located.gather_start = (), math.inf
    located.wall_state = WallState(yaw=located.wall_state.yaw, position=located.wall_state.position)
    located.last_position_time = located.last_full_position_time = located.last_length_time = now
    state.odometry.last_yaw_time = -math.inf
    state.tilt = state.tilt._replace(time=-math.inf)


def _keep_distance(_settings: ObserverSettings, state: ObserverState, reading: Distance) -> None:
    """Keep the last distance."""
    state.last_distance = reading


def _predict_attitude(settings: ObserverSettings, state: ObserverState, reading: Inertial) -> None:
    """Integrate yaw and tilt to the time of an IMU *reading*."""
    last = state.checks.last_imu
    accepted = accept_imu(state.checks, settings.tilt, reading)
    if not accepted:
        if accepted is not None:
            state.odometry.yaw_rate = 0.0
        return
    rate = float(reading.rate[2]) - state.odometry.yaw_rate_bias
    state.odometry.yaw_rate = rate
    if last is not None:
        state.odometry.yaw += rate * min(max(reading.time - last.time, 0.0), 1.0)
    state.tilt = tilt.step(settings.tilt, state.tilt, reading, rate)
    state.turns.attitudes.add(reading.time, (state.odometry.yaw, state.tilt.x, state.tilt.y))


def _predict_lengths(settings: ObserverSettings, state: ObserverState, reading: Encoders) -> None:
    """Add what the encoders count to the lengths."""
    rotation, dt = drum_rotation(state.checks, reading, settings.counts_per_radian, settings.max_drum_speed)
    if state.tracker is None:
        _watch_standing(state, reading.time, rotation, dt)
    if state.drum_angles is None:
        state.drum_angles = np.zeros(settings.model.m)
        return
    if rotation is None:
        if dt > 0.0:
            state.radius = drum_radius.without_reference(state.radius)
        return
    state.drum_angles = state.drum_angles + rotation
    if reading.time - dt < state.located.last_length_time - _MAX_ENCODER_GAP:  # a lidar state has included the rotation
        state.radius = drum_radius.without_reference(state.radius)
    elif state.lengths is not None:
        state.lengths = state.lengths + state.radius.radii * rotation


_HANDLERS: Final[dict[type, Callable[[ObserverSettings, ObserverState, Any], None]]] = {
    Inertial: _predict_attitude,
    Encoders: _predict_lengths,
    Distance: _keep_distance,
}
"""What reads each kind of reading, but scans, line angles and climate."""


def _watch_standing(state: ObserverState, now: float, rotation: Array | None, dt: float) -> None:
    """Note when lines have moved last, by the *rotation* (m,), rad, of the drums in *dt*, s, until *now*, s."""
    if rotation is None or not float(np.abs(state.radius.radii * rotation).max()) <= _STANDS * dt:
        state.odometry.last_motion_time = now
    state.odometry.last_motion_time = min(state.odometry.last_motion_time, now)  # what was before is not known


def _predict_position(settings: ObserverSettings, state: ObserverState, dt: float) -> None:
    """Follow the equilibrium from the last lengths to the current ones; *dt*: s since the last step."""
    if state.creep is not None:
        _creep(state, state.creep, dt)
    tracker, paid_out = state.tracker, state.lengths
    if tracker is None or paid_out is None:
        return
    before = tracker.pose
    status = tracker.step(paid_out) if (paid_out > 0.0).all() else Status.NOT_CONVERGED
    if status is not Status.OK:
        state.monitor.report("encoders", "lost", f"the equilibrium could not be followed: {status.value}")
        return
    state.monitor.clear("encoders", "lost")
    state.lengths = lengths.followed(tracker, paid_out)
    moved = tracker.pose - before
    state.odometry.position = state.odometry.position + moved
    state.odometry.distance_without_floor += float(np.sqrt(moved @ moved))
    if state.checks.last_encoders is not None:
        state.turns.motion.add(state.checks.last_encoders.time, state.odometry.position)
    if dt > 0.0:
        gain = min(1.0, dt / settings.slackness.smoothing_time)
        state.odometry.velocity = state.odometry.velocity + gain * (moved / dt - state.odometry.velocity)


def _creep(state: ObserverState, creep: KnownCreep, dt: float) -> None:
    """Let cables creep for *dt*, s: lengths, and those by which radii are found from the next lidar state."""
    if state.tracker is None or state.lengths is None:
        return
    creep.follow(state.tracker.tensions, state.time)
    grown = 1.0 + dt * creep.rates
    state.lengths = state.lengths * grown
    last = state.radius.last_lengths
    if last is not None:
        state.radius = state.radius._replace(last_lengths=last * grown)


def _extract(settings: ObserverSettings, state: ObserverState, scan: Scan) -> None:
    """Process one lidar scan: height of a vertical one, lines of a horizontal one; its pose is the next step's work."""
    state.located.gathered_sources.add(scan.source)
    times = scan.times
    attitudes, positions = state.turns.attitudes.at(times), state.turns.motion.at(times)
    if scan.source == "vertical":
        if settings.height is not None:
            _update_height(settings.height, state, scan, attitudes[:, 1:], float(positions[len(times) // 2, 2]))
        return
    late = state.time - float(times[-1]) > _FRESH and state.odometry.last_motion_time > float(times[0])
    if state.tracker is None and late:
        return  # the platform's motion since then is unknown
    _drop_stale_turns(settings, state, scan)
    end, yaw = positions[-1], float(attitudes[-1, 0])
    offset = state.located.yaw_offset if math.isfinite(state.located.yaw_offset) else 0.0
    state.located.turn_ends = *state.located.turn_ends[-1:], (end, yaw)
    lidar, walls = settings.lidars.index(scan.source), settings.walls
    moved = positions[:, :2] - end[:2] if settings.deskew else None
    state.turns.extracted = scanned(scan, walls.lidars[lidar], lidar, walls.search, attitudes, moved, offset + yaw)


def _update_height(settings: HeightSettings, state: ObserverState, scan: Scan, tilts: Array, z: float) -> None:
    """Update the offset of the height and the clearance by a vertical turn; *z*: m, odometry in its middle."""
    reach = _FLOOR_TOLERANCE + _FLOOR_DRIFT * state.odometry.distance_without_floor
    height = state.located.height = estimate_height(
        settings, scan, tilts, float(state.located.position_offset[2]) + z, reach
    )
    if math.isfinite(height.over_structure):
        state.clearance_offset = height.over_structure - z
    if height.note:
        state.monitor.report("vertical", "floor", height.note)
    else:
        state.monitor.clear("vertical", "floor")
        state.located.position_offset[2], state.odometry.distance_without_floor = height.over_floor - z, 0.0


def _localise(settings: ObserverSettings, state: ObserverState, turn: LidarTurn) -> None:
    """Compute the drum's pose from the lines of a turn, and update by it."""
    lasers = settings.lasers if state.tracker is None else ()
    (last, last_yaw), (end, yaw) = state.located.turn_ends[0], state.located.turn_ends[-1]
    moved = float(end[0] - last[0]), float(end[1] - last[1]), yaw - last_yaw
    state.located.wall_state, pose = localisation.step(settings.walls, state.located.wall_state, turn, lasers, moved)
    state.located.wall_pose, state.turns.extracted = pose, None
    _update_position(settings, state, turn, pose, end, yaw)


def _drop_stale_turns(settings: ObserverSettings, state: ObserverState, scan: Scan) -> None:
    """Drop turns of lidars that have become silent: odometry has moved them too far."""
    state.located.last_turn_times[scan.source] = scan.time
    limit, last = _STALE_TURNS * len(scan.ranges) * scan.period, state.located.last_turn_times
    stale = [i for i, name in enumerate(settings.lidars) if scan.time - last.get(name, -math.inf) > limit]
    if any(turn.lidar in stale for turn in state.located.wall_state.turns):
        kept = tuple(turn for turn in state.located.wall_state.turns if turn.lidar not in stale)
        state.located.wall_state = replace(state.located.wall_state, turns=kept)


def _update_position(
    settings: ObserverSettings, state: ObserverState, turn: LidarTurn, pose: WallPose, end: Array, yaw: float
) -> None:
    """Update the offsets of position and yaw, or report why not. *end*, *yaw*: odometry at the end of the turn."""
    known = bool(np.isfinite(state.located.position_offset[:2]).all())
    if pose.status != "ok":
        state.monitor.report(turn.source, "walls", pose.note)
    else:
        state.monitor.clear(turn.source, "walls")
    offset = pose.position - end[:2]
    if pose.status == "parallel" and known:
        offset = _across_walls(settings, pose, state.located.position_offset[:2] + end[:2]) - end[:2]
    elif not (pose.status == "ok" or (pose.status == "ambiguous" and known)):
        return
    error = float(np.hypot(*(offset - state.located.position_offset[:2]))) if known else 0.0
    if pose.status == "ambiguous" and error > _SAME_POSITION:
        return  # probably the other one of two positions; the fault has been reported
    if error > settings.gate and state.located.rejections < settings.max_rejections:
        state.located.rejections += 1
        sentence = f"its walls place the drum {error:.2f} m from the expected position: not used"
        state.monitor.report(turn.source, "gate", sentence)
        return
    state.located.rejections = 0
    state.monitor.clear(turn.source, "gate")
    state.located.position_offset[:2], state.located.last_position_time = offset, state.time
    if pose.status != "parallel":
        state.located.last_full_position_time = state.time
    if math.isfinite(pose.yaw):
        _update_yaw(state, pose.yaw - yaw, turn.end)


def _across_walls(settings: ObserverSettings, pose: WallPose, expected: Array) -> Array:
    """Move *expected* (2,), m, across parallel walls to where those within the gate put it; it stays along them."""
    moves = []
    for each in pose.constraints:
        normal = np.array(each.normal)
        distance = each.offset - float(normal @ expected)
        if abs(distance) <= settings.gate:
            moves.append(distance * normal)
    return expected + np.mean(moves, axis=0) if moves else expected


def _update_yaw(state: ObserverState, offset: float, time: float) -> None:
    """Set the *offset* of yaw from odometry, rad, and update the bias of the yaw rate."""
    since = time - state.odometry.last_yaw_time
    if 0.5 < since < 5.0 and math.isfinite(state.located.yaw_offset):
        state.odometry.yaw_rate_bias -= _BIAS_GAIN * math.remainder(offset - state.located.yaw_offset, math.tau) / since
    if not since <= 0.5:
        state.odometry.last_yaw_time = time
    state.located.yaw_offset = offset


def _update_lengths(settings: ObserverSettings, state: ObserverState) -> None:
    """Compute the lengths that hang the drum at the lidars' position, and the radii of the winch drums from them."""
    state.located.gathered_sources.clear()
    state.located.gather_start = math.inf
    if (
        math.isnan(state.located.position_offset[2])
        and state.last_distance is not None
        and settings.valve_depth is not None
    ):
        height = state.last_distance.distance + settings.valve_depth  # over the ground or material below
        state.located.position_offset[2] = height - state.odometry.position[2]
    target = state.located.position_offset + state.odometry.position
    if not np.isfinite(target).all():
        return
    angular = settings.slackness
    if state.tracker is None or state.lengths is None or state.monitor.is_active("encoders", "lost"):
        hung = lengths.hang_at(angular, state.slackness, target, TrackerSettings(certify=settings.certify))
        if isinstance(hung, str):
            state.monitor.report("walls", "hang", hung)
            return
        state.tracker, state.lengths = hung
        state.monitor.clear("encoders", "lost")
    else:
        state.lengths, status = lengths.move_to(angular, state.slackness, state.tracker, state.lengths, target)
        if status is not Status.OK:
            sentence = f"the drum cannot be moved to the lidars' position: {status.value}"
            state.monitor.report("walls", "hang", sentence)
            return
    state.monitor.clear("walls", "hang")
    _update_radii(settings, state, state.lengths)


def _update_radii(settings: ObserverSettings, state: ObserverState, found: Array) -> None:
    """Update the radii of the winch drums with the lengths *found* (m,), m, if there is a new lidar position."""
    new = state.located.last_full_position_time > state.located.last_length_time
    state.located.lidar_states += new
    state.located.last_length_time = max(state.located.last_length_time, state.located.last_full_position_time)
    if state.drum_angles is None or not new or state.located.lidar_states < settings.walls.kept_turns:
        return
    last_lengths, last_angles = state.radius.last_lengths, state.radius.last_angles
    if last_lengths is not None and last_angles is not None:
        if (state.drum_angles != last_angles).any():
            state.monitor.clear("encoders", "stand")
        elif float(np.abs(found - last_lengths).max()) > _STUCK_ENCODER_ERROR:
            state.monitor.report("encoders", "stand", "no winch drum turns by its counts, but lengths change")
            return
    known = np.isfinite(state.slackness.excess) & (settings.model.lines.counterweight == 0.0)
    state.radius = drum_radius.step(settings.radius, state.radius, found, state.drum_angles, known)


def _estimate(settings: ObserverSettings, state: ObserverState) -> Estimate:
    """Return the state as an estimate; lengths are NaN until the first position is known."""
    yaw = state.odometry.yaw + (state.located.yaw_offset if math.isfinite(state.located.yaw_offset) else 0.0)
    position, velocity, valid = state.located.position_offset + state.odometry.position, np.zeros(3), False
    paid_out = excess = np.full(settings.model.m, np.nan)
    if state.tracker is not None and state.lengths is not None and state.taut is not None:
        position, velocity, paid_out = state.tracker.pose, state.odometry.velocity, state.lengths
        excess = lengths.current_excess(settings.slackness, state.slackness, state.taut, paid_out)
        current = state.time - state.located.last_position_time <= settings.position_timeout
        valid = current and not state.monitor.is_active("encoders", "lost")
    return Estimate(
        state.time,
        frozen(position),
        frozen(velocity),
        frozen(tilt.rotation_vector(yaw, state.tilt.x, state.tilt.y)),
        frozen(paid_out),
        frozen(excess),
        excess > settings.slackness.threshold,
        frozen(state.radius.radii),
        faults=state.monitor.faults,
        valid=valid,
        clearance=float(state.odometry.position[2]) + state.clearance_offset,
    )
