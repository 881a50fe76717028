"""The machine's state by the chain of Merlet and Papegay 2023, section III: `step` takes a frame, tells an estimate.

Lidars tell where the drum is about once a second, line accelerometers which line is slack, and from both the lengths
follow; encoders carry the lengths on, and a forward solve the drum, at every step in between.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.errors import Status
from cablewright.estimation import slackness, tilt
from cablewright.estimation.chain import drum_radius, lengths
from cablewright.estimation.chain.state import Looked, ObserverSettings, ObserverState
from cablewright.estimation.fault_monitor import Watch
from cablewright.estimation.height import height_of
from cablewright.estimation.lidar import localisation
from cablewright.estimation.lidar.localisation import LidarTurn, WallPose, WallState
from cablewright.estimation.reading_checks import KEPT, UNHURRIED, Intake, felt, line_faults, queue, seen, turned
from cablewright.estimation.slackness import taut_at
from cablewright.estimation.time_buffer import Trail
from cablewright.signals import (
    DistanceReading,
    Encoders,
    Estimate,
    Inertial,
    LineAngles,
    Reading,
    Scan,
    SensorFrame,
    frozen,
)
from cablewright.solvers.continuation import TrackerSettings

__all__ = ["ObserverSettings", "ObserverState", "start", "step"]

Array = NDArray[np.float64]

_LEARN: Final = 0.1  # share of the yaw rate's bias that one lidar state tells
_ENCODERS_OFF: Final = 0.01  # m that a length is off while no drum turned
_AROUND: Final = np.linspace(-math.pi, math.pi, 360, endpoint=False)
_SQUARE: Final = LidarTurn(_AROUND, 2.0 / np.maximum(np.abs(np.cos(_AROUND)), np.abs(np.sin(_AROUND))))
_STALE: Final = 2.5  # turns after which a lidar is quiet
_SAME_PLACE: Final = 0.03  # m from where it should be, of one of several places that explain a scan
_FLOOR: Final = 0.02  # m over where the floor should be, beyond which nothing is floor, ...
_FLOOR_GROWS: Final = 0.02  # ... and by how much more for each metre that B went without seeing it
_ENCODERS_GAP: Final = 0.1  # s without counts


def start(settings: ObserverSettings) -> ObserverState:
    """Return the state before the first frame: nothing is known. Kernels are loaded, so that no step is late."""
    scene = settings.model.robot.scene
    middle = 0.5 * (np.array(scene.frame_min) + np.array(scene.frame_max))
    unheard = slackness.start(settings.slackness)
    begun = lengths.hang(settings.slackness, unheard, middle, TrackerSettings(certify=settings.certify))
    if not isinstance(begun, str):
        tracker, paid = begun
        lengths.bring(settings.slackness, unheard, tracker, paid, middle)
    localisation.step(settings.walls, localisation.start(), _SQUARE)
    return ObserverState(
        Intake(Watch(dict(settings.quiet))),
        localisation.start(),
        unheard,
        drum_radius.start(settings.radius),
        tilt.start(),
        Trail(3, KEPT),
        Trail(3, KEPT),
    )


def step(settings: ObserverSettings, state: ObserverState, frame: SensorFrame) -> Estimate:
    """Take one frame; *state* changes in place. Raises nothing for what a frame holds: faults are in the estimate."""
    if not frame.time > state.time:
        _clock_back(state, frame.time)
    dt = frame.time - state.time if math.isfinite(state.time) else 0.0
    state.time = frame.time
    told: LineAngles | None = None
    for reading in frame.readings:
        source = state.watch.heard(reading, frame.time)
        if source is None:
            continue
        if isinstance(reading, LineAngles):
            told = reading
        else:
            _take(settings, state, reading)
    _carry_on(settings, state, dt)
    _see(settings, state)
    while dt > UNHURRIED and (state.pending or state.looked is not None):
        _see(settings, state)
    due = state.gathered.issuperset((*settings.lidars, "vertical")) or state.time - state.gathering > settings.gather
    if due and not state.pending and state.looked is None:
        _settle(settings, state)
    if state.tracker is not None:
        state.taut = taut_at(settings.model, state.tracker.pose)
        if told is not None:
            state.slackness = slackness.step(settings.slackness, state.slackness, told, state.taut)
            found = state.slackness
            line_faults(state.watch, settings.model.robot.lines, np.isnan(found.excess), found.stuck)
    elif told is not None and np.isfinite(state.anchor).all():
        there = taut_at(settings.model, state.anchor + state.odometry)
        state.slackness = slackness.step(settings.slackness, state.slackness, told, there)
    state.watch.check(state.time)
    return _estimate(settings, state)


def _see(settings: ObserverSettings, state: ObserverState) -> None:
    """Do the next bit of work on the lidars' turns: as much as there is time for in one step."""
    if state.looked is not None:
        _place(settings, state, state.looked)
    elif state.pending:
        _look(settings, state, state.pending.pop(0))


def _clock_back(state: ObserverState, now: float) -> None:
    """Begin to count time anew: nothing of the past can be put in order with what comes."""
    state.watch.restart(now, f"the clock jumped back from {state.time:g} to {now:g} s: began to count anew")
    state.places.clear()
    state.attitudes.clear()
    state.pending.clear()
    state.gathered.clear()
    state.tilt = state.tilt._replace(time=-math.inf)
    state.slackness = state.slackness._replace(time=-math.inf, heard=np.full_like(state.slackness.heard, -np.inf))
    state.walls = WallState(yaw=state.walls.yaw, position=state.walls.position)
    state.turns_end.clear()
    state.looked = None
    state.turn_end = None
    state.intake.forget()
    state.gathering, state.time, state.fixed, state.yaw_fixed = math.inf, -math.inf, now, -math.inf
    state.settled_at = state.whole = now


def _take(settings: ObserverSettings, state: ObserverState, reading: Reading) -> None:
    """Take what is not of the lines."""
    if isinstance(reading, Inertial):
        _turn(settings, state, reading)
    elif isinstance(reading, Encoders):
        _count(settings, state, reading)
    elif isinstance(reading, DistanceReading):
        state.depth = reading
    elif isinstance(reading, Scan) and seen(state.intake, reading) and reading.source in (*settings.lidars, "vertical"):
        queue(state.pending, reading, settings.walls.keep)
        state.gathering = min(state.gathering, state.time)


def _turn(settings: ObserverSettings, state: ObserverState, reading: Inertial) -> None:
    """Carry yaw and tilt on."""
    last = state.intake.inertial
    counts = felt(state.intake, settings.tilt, reading)
    if not counts:
        if counts is not None:
            state.yaw_rate = 0.0
        return
    rate = float(reading.rate[2]) - state.yaw_bias
    state.yaw_rate = rate
    if last is not None:
        state.yaw += rate * min(max(reading.time - last.time, 0.0), 1.0)
    state.tilt = tilt.step(settings.tilt, state.tilt, reading, rate)
    state.attitudes.add(reading.time, (state.yaw, state.tilt.x, state.tilt.y))


def _count(settings: ObserverSettings, state: ObserverState, reading: Encoders) -> None:
    """Carry the lengths on."""
    by, since = turned(state.intake, reading, settings.counts, settings.fastest)
    if state.angles is None:
        state.angles = np.zeros(len(reading.counts))
        return
    if by is None:
        if since > 0.0:
            state.radius = drum_radius.unhooked(state.radius)
        return
    state.angles = state.angles + by
    if reading.time - since < state.settled_at - _ENCODERS_GAP:  # the lidars have told meanwhile where that led
        state.radius = drum_radius.unhooked(state.radius)
    elif state.lengths is not None:
        state.lengths = state.lengths + state.radius.radii * by


def _carry_on(settings: ObserverSettings, state: ObserverState, dt: float) -> None:
    """Let the drum follow the lengths."""
    tracker, paid = state.tracker, state.lengths
    if tracker is None or paid is None:
        return
    before = tracker.pose
    status = tracker.step(paid) if (paid > 0.0).all() else Status.NOT_CONVERGED
    if status is not Status.OK:
        state.watch.say("encoders", "lost", f"the drum could not be followed: {status.value}")
        return
    state.watch.clear("encoders", "lost")
    moved = tracker.pose - before
    state.odometry = state.odometry + moved
    state.floorless += float(np.sqrt(moved @ moved))
    if state.intake.encoders is not None:
        state.places.add(state.intake.encoders.time, state.odometry)
    if dt > 0.0:
        state.velocity = state.velocity + min(1.0, dt / settings.slackness.smooth) * (moved / dt - state.velocity)


def _look(settings: ObserverSettings, state: ObserverState, scan: Scan) -> None:
    """Take one turn of a lidar: of a horizontal one its lines, for there is not the time for more in one step."""
    state.gathered.add(scan.source)
    times = scan.times
    attitudes, places = state.attitudes.at(times), state.places.at(times)
    if scan.source == "vertical":
        if settings.height is not None:
            risen = float(places[len(times) // 2, 2])
            reach = _FLOOR + _FLOOR_GROWS * state.floorless
            state.height = height_of(settings.height, scan, attitudes[:, 1:], float(state.anchor[2]) + risen, reach)
            if math.isfinite(state.height.over_structure):
                state.clearance = state.height.over_structure - risen
            if state.height.note:
                state.watch.say("vertical", "floor", state.height.note)
            else:
                state.watch.clear("vertical", "floor")
                state.anchor[2], state.floorless = state.height.over_floor - risen, 0.0
        return
    _forget_stale(settings, state, scan)
    end, yaw = places[-1], float(attitudes[-1, 0])
    drift = _drift(state, places, attitudes) if settings.straighten else None
    moved = (0.0, 0.0, 0.0)
    if state.turn_end is not None:
        was, was_yaw = state.turn_end
        moved = (float(end[0] - was[0]), float(end[1] - was[1]), yaw - was_yaw)
    state.turn_end = end, yaw
    turn = LidarTurn(scan.angles, scan.ranges, settings.lidars.index(scan.source), attitudes[:, 1:], drift, moved)
    state.looked = Looked(scan, turn, localisation.look(settings.walls, turn), end, yaw)


def _place(settings: ObserverSettings, state: ObserverState, looked: Looked) -> None:
    """Say where the drum is by the lines that were found a step before."""
    lasers = settings.lasers if state.tracker is None else ()
    state.walls, state.pose = localisation.step(settings.walls, state.walls, looked.turn, lasers, looked.kept)
    state.looked = None
    _judge(settings, state, looked.scan, state.pose, looked.end, looked.yaw)


def _forget_stale(settings: ObserverSettings, state: ObserverState, scan: Scan) -> None:
    """Leave out turns of lidars that are quiet: odometry has carried them too far."""
    state.turns_end[scan.source] = scan.time
    most = _STALE * len(scan.ranges) * scan.period
    old = [i for i, name in enumerate(settings.lidars) if scan.time - state.turns_end.get(name, -math.inf) > most]
    if any(turn.lidar in old for turn in state.walls.turns):
        kept = tuple(turn for turn in state.walls.turns if turn.lidar not in old)
        state.walls = replace(state.walls, turns=kept)


def _drift(state: ObserverState, places: Array, attitudes: Array) -> Array:
    """Where the drum was at each ray, (n, 3), from where it was at the last, along its level axes there."""
    at = state.anchor_yaw if math.isfinite(state.anchor_yaw) else 0.0
    yaw = at + float(attitudes[-1, 0])
    c, s = math.cos(yaw), math.sin(yaw)
    away = places[:, :2] - places[-1, :2]
    return np.column_stack([away @ np.array([[c, -s], [s, c]]), attitudes[:, 0] - attitudes[-1, 0]])


def _judge(
    settings: ObserverSettings, state: ObserverState, scan: Scan, pose: WallPose, end: Array, yaw: float
) -> None:
    """Believe what the walls tell, or say why not. *end* and *yaw*: by odometry, at the end of the turn."""
    known = bool(np.isfinite(state.anchor[:2]).all())
    if pose.status != "ok":
        state.watch.say(scan.source, "walls", pose.note)
    else:
        state.watch.clear(scan.source, "walls")
    anchor = pose.position - end[:2]
    if pose.status == "parallel" and known:
        anchor = _across(settings, pose, state.anchor[:2] + end[:2]) - end[:2]
    elif not (pose.status == "ok" or (pose.status == "ambiguous" and known)):
        return
    off = float(np.hypot(*(anchor - state.anchor[:2]))) if known else 0.0
    if pose.status == "ambiguous" and off > _SAME_PLACE:
        return  # the other of two places; what is wrong has been said
    if off > settings.gate and state.refused < settings.believe:
        state.refused += 1
        state.watch.say(scan.source, "gate", f"its walls put the drum {off:.2f} m from where it should be: not used")
        return
    state.refused = 0
    state.watch.clear(scan.source, "gate")
    state.anchor[:2], state.fixed = anchor, state.time
    if pose.status != "parallel":
        state.whole = state.time
    if math.isfinite(pose.yaw):
        _turn_to(state, pose.yaw - yaw, scan.time)


def _across(settings: ObserverSettings, pose: WallPose, expected: Array) -> Array:
    """*expected* (2,), m, moved across parallel walls to where those that are near put it; along them it stays."""
    moves = []
    for each in pose.constraints:
        normal = np.array(each.normal)
        off = each.offset - float(normal @ expected)
        if abs(off) <= settings.gate:
            moves.append(off * normal)
    return expected + np.mean(moves, axis=0) if moves else expected


def _turn_to(state: ObserverState, anchor: float, time: float) -> None:
    """Take a yaw, as what is to be added to odometry's; learn what the gyro is off."""
    since = time - state.yaw_fixed
    if 0.5 < since < 5.0 and math.isfinite(state.anchor_yaw):
        state.yaw_bias -= _LEARN * math.remainder(anchor - state.anchor_yaw, math.tau) / since
    if not since <= 0.5:
        state.yaw_fixed = time
    state.anchor_yaw = anchor


def _settle(settings: ObserverSettings, state: ObserverState) -> None:
    """Make a state of what the lidars told: lengths that put the drum there, and the radii of the winch drums."""
    state.gathered.clear()
    state.gathering = math.inf
    if math.isnan(state.anchor[2]) and state.depth is not None and settings.valve is not None:
        state.anchor[2] = state.depth.distance + settings.valve - state.odometry[2]  # over what lies there
    target = state.anchor + state.odometry
    if not np.isfinite(target).all():
        return
    angular = settings.slackness
    if state.tracker is None or state.lengths is None or state.watch.has("encoders", "lost"):
        hung = lengths.hang(angular, state.slackness, target, TrackerSettings(certify=settings.certify))
        if isinstance(hung, str):
            state.watch.say("walls", "hang", hung)
            return
        state.tracker, state.lengths = hung
        state.watch.clear("encoders", "lost")
    else:
        state.lengths, status = lengths.bring(angular, state.slackness, state.tracker, state.lengths, target)
        if status is not Status.OK:
            state.watch.say("walls", "hang", f"the drum cannot be brought to where the lidars put it: {status.value}")
            return
    state.watch.clear("walls", "hang")
    _measure_radii(settings, state, state.lengths)


def _measure_radii(settings: ObserverSettings, state: ObserverState, found: Array) -> None:
    """Learn the radii of the winch drums from the lengths *found* (m,), m, if the lidars told a place anew."""
    news = state.whole > state.settled_at
    state.settled += news
    state.settled_at = max(state.settled_at, state.whole)
    if state.angles is None or not news or state.settled < settings.walls.keep:
        return
    last, was = state.radius.lengths, state.radius.angles
    if last is not None and was is not None:
        if (state.angles != was).any():
            state.watch.clear("encoders", "stand")
        elif float(np.abs(found - last).max()) > _ENCODERS_OFF:
            state.watch.say("encoders", "stand", "no winch drum turns by its counts, but lengths change")
            return
    known = np.isfinite(state.slackness.excess)
    state.radius = drum_radius.step(settings.radius, state.radius, found, state.angles, known)


def _estimate(settings: ObserverSettings, state: ObserverState) -> Estimate:
    """Say what is believed."""
    m = settings.model.m
    yaw = state.yaw + (state.anchor_yaw if math.isfinite(state.anchor_yaw) else 0.0)
    rotation = frozen(tilt.rotation_vector(yaw, state.tilt.x, state.tilt.y))
    clear = float(state.odometry[2]) + state.clearance
    if state.tracker is None or state.lengths is None or state.taut is None:
        nothing = frozen(np.full(m, np.nan))
        place, still = frozen(state.anchor + state.odometry), frozen(np.zeros(3))
        slack = np.zeros(m, dtype=np.bool_)
        radii = frozen(state.radius.radii)
        return Estimate(
            state.time, place, still, rotation, nothing, nothing, slack, radii, None, state.watch.faults, False, clear
        )
    excess = lengths.excess_now(settings.slackness, state.slackness, state.taut, state.lengths)
    return Estimate(
        state.time,
        frozen(state.tracker.pose),
        frozen(state.velocity),
        rotation,
        frozen(state.lengths),
        frozen(excess),
        excess > settings.slackness.slack,
        frozen(state.radius.radii),
        None,
        state.watch.faults,
        valid=state.time - state.fixed <= settings.lost and not state.watch.has("encoders", "lost"),
        clearance=clear,
    )
