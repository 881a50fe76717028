"""The machine's state by one error-state Kalman filter that fuses all sensors: `step` takes a frame, tells an estimate.

Encoders carry position and lengths on, the gyro the attitude; walls, floor, line angles, gravity and the distance
sensor correct them together with what they depend on: radii of the winch drums, biases of gyro, accelerometer and
lidars. The paper's chain finds the first place. docs/estimation.md has the equations.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.estimation import slackness
from cablewright.estimation.chain import observer
from cablewright.estimation.chain.state import ObserverState
from cablewright.estimation.kalman import attitude, lidar_update, line_update, vertical_update
from cablewright.estimation.kalman.state import FilterSettings, FilterState, Layout, add_unknown
from cablewright.estimation.reading_checks import KEPT, UNHURRIED, felt, line_faults, queue, seen, turned
from cablewright.estimation.tilt import rotation_vector
from cablewright.estimation.time_buffer import Trail
from cablewright.kernels import layout
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

__all__ = ["FilterSettings", "FilterState", "start", "step"]

Array = NDArray[np.float64]

_FIRST: Final = 0.01  # m: of the chain's first place
_FIRST_TILT: Final = math.radians(0.15)
_FIRST_YAW: Final = math.radians(0.5)
_FIRST_LENGTH: Final = 5e-3  # m: of lengths besides the place's
_GAP: Final = 0.1  # s without readings, or a step and a half, after which a sensor is not gone by
_TURNED: Final = math.radians(2.0)  # of the drum, while the clock jumped
_DOUBTED: Final = 2  # turns in a row of which most does not fit: B is as unsure as at first
_AGAIN: Final = 10.0  # s from one search for the place to the next
_LET_OUT: Final = 5e-3  # m per root second: by which a winch that is not told makes a line slack
_GOES: Final = 0.01  # m/s: who is as fast does not stand
_RESTS: Final = 4.0  # s of counts that stand, after which B stands too if no lidar sees it go
_FASTEST: Final = 0.05  # m/s: about as fast as B goes while nothing tells
_CALM: Final = np.array([1.0, 1.0, 0.2])  # upwards it goes less than level
_GROUND: Final = 0.1  # m: of what lies under the valve, at first
_TRIES: Final = 5  # readings of the distance sensor in a row that do not fit: then the ground is another


def start(settings: FilterSettings) -> FilterState:
    """Return the state before the first frame: nothing is known."""
    chain = observer.start(settings.chain)
    own = settings.chain
    lay = Layout.of(own.model.m, len(own.lidars))
    weight = float(own.model.packed.platform[layout.PLATFORM_WEIGHT])
    return FilterState(
        chain.intake,
        lay,
        slackness.start(own.slackness),
        weight / own.model.robot.scene.gravity,
        chain,
        np.zeros((lay.size, lay.size)),
    )


def step(settings: FilterSettings, state: FilterState, frame: SensorFrame) -> Estimate:
    """Take one frame; *state* changes in place. Raises nothing for what a frame holds: faults are in the estimate."""
    if state.chain is not None:
        estimate = observer.step(settings.chain, state.chain, frame)
        if not _begin(settings, state, state.chain, frame.time):
            return _guess(estimate)
        return _estimate(settings, state)
    if not frame.time > state.time:
        _clock_back(state, frame.time)
    dt = frame.time - state.time if math.isfinite(state.time) else 0.0
    _tick(settings, state, frame.time, dt)
    told = _hear(settings, state, frame)
    if state.time - state.told > state.gap:
        _go_free(state)
    if state.free:
        _drift(settings, state, dt)
    line_update.draw(settings, state)
    _see(settings, state)
    while dt > UNHURRIED and (state.pending or state.looked is not None):
        _see(settings, state)
    if told is not None and state.taut is not None:
        state.slackness = slackness.step(settings.chain.slackness, state.slackness, told, state.taut)
        heard = state.slackness
        line_faults(state.watch, settings.chain.model.robot.lines, np.isnan(heard.excess), heard.stuck)
        line_update.listen(settings, state)
    state.watch.check(state.time)
    if _astray(settings, state):
        _again(settings, state)
        return _guess(_estimate(settings, state))
    return _estimate(settings, state)


def _tick(settings: FilterSettings, state: FilterState, now: float, dt: float) -> None:
    """Let the clock go on."""
    state.time, state.gap = now, max(_GAP, 1.5 * dt)
    if now - state.slackness.time > settings.chain.slackness.quiet:
        state.slackness = state.slackness._replace(excess=np.full_like(state.slackness.excess, np.nan))
    if state.coarse:  # in so long a step a drum turns by what no gyro that is read once in it tells
        yaw = state.layout.attitude.stop - 1
        state.P[yaw, yaw] += (settings.turning * dt) ** 2


def _hear(settings: FilterSettings, state: FilterState, frame: SensorFrame) -> LineAngles | None:
    """Take all readings but those of the lines' angles, of which the last is returned."""
    told: LineAngles | None = None
    for reading in frame.readings:
        if state.watch.heard(reading, frame.time) is None:
            continue
        if isinstance(reading, LineAngles):
            told = reading
        else:
            _take(settings, state, reading)
    return told


def _begin(settings: FilterSettings, state: FilterState, chain: ObserverState, now: float) -> bool:
    """Take over from the chain once it has a place."""
    state.time = now
    if chain.tracker is None or chain.lengths is None or chain.taut is None or chain.angles is None:
        return False
    if chain.pose is None or chain.pose.status != "ok":
        return False
    lay, m = state.layout, settings.chain.model.m
    state.position, state.lengths = chain.tracker.pose.copy(), chain.lengths.copy()
    state.velocity, state.yaw = chain.velocity.copy(), chain.yaw + chain.anchor_yaw
    state.tilt, state.slackness = np.zeros(2), chain.slackness
    state.lean, state.gyro, state.turn_rate = np.zeros(2), np.zeros(3), np.zeros(3)  # a second tells no bias
    state.leans.clear()
    state.radii, state.bias = chain.radius.radii.copy(), np.zeros(len(settings.chain.lidars) + 1)
    state.angles, state.rates, state.ground = np.zeros(m), np.zeros(m), 0.0
    state.way, state.turning, state.gyro_yaw = Trail(m + 4, KEPT), Trail(3, KEPT), 0.0
    state.drifted = np.zeros(4)
    heard = state.intake = chain.intake
    state.told = now if heard.encoders is None else heard.encoders.time
    state.felt = now if heard.inertial is None else heard.inertial.time
    state.begun, state.fixed, state.free = now, now, False
    state.looked = None
    state.pending.clear()
    state.refused.clear()
    state.across = dict.fromkeys({wall.kind for wall in settings.chain.walls.room.walls}, now)
    line_update.draw(settings, state, at_once=True)
    if state.taut is None:
        return False
    state.P = _first(settings, lay, state.taut.toward)
    state.chain = None
    return True


def _first(settings: FilterSettings, lay: Layout, toward: Array) -> Array:
    """Covariance of what the chain hands over."""
    size = np.zeros(lay.size)
    size[lay.attitude] = _FIRST_TILT, _FIRST_TILT, _FIRST_YAW
    size[lay.lengths], size[lay.radii] = _FIRST_LENGTH, settings.radius
    size[lay.gyro], size[lay.lean], size[lay.ground] = settings.gyro, settings.lean, _GROUND
    lidars = settings.chain.walls.lidars
    size[lay.bias] = [max(lidar.bias_sigma, 1e-6) for lidar in lidars] + [settings.height_bias]
    P = np.diag(size**2)
    rows = np.r_[lay.position, lay.lengths]
    by_place = np.vstack([np.eye(3), toward])
    P[np.ix_(rows, rows)] += _FIRST**2 * (by_place @ by_place.T)
    return P


def _guess(estimate: Estimate) -> Estimate:
    """Return *estimate* as one that nobody should go by."""
    return replace(estimate, valid=False)


def _astray(settings: FilterSettings, state: FilterState) -> bool:
    """Whether most of what a lidar sees has not fitted for some turns: the place may be another than believed."""
    turns = max((state.refused.get(source, 0) for source in settings.chain.lidars), default=0)
    lost = not np.isfinite(state.position).all() or not np.isfinite(state.P).all()
    return lost or (turns >= settings.chain.believe and state.time - state.begun > _AGAIN)


def _again(settings: FilterSettings, state: FilterState) -> None:
    """Look for the place from the beginning, with the faults that are known."""
    state.chain = observer.start(settings.chain)
    state.chain.intake = state.intake
    state.refused.clear()


def _clock_back(state: FilterState, now: float) -> None:
    """Begin to count time anew: nothing of the past can be put in order with what comes."""
    state.watch.restart(now, f"the clock jumped back from {state.time:g} to {now:g} s: began to count anew")
    state.intake.forget()
    for trail in (state.way, state.turning):
        trail.clear()
    state.pending.clear()
    state.leans.clear()
    heard = state.slackness
    state.slackness = heard._replace(time=-math.inf, heard=np.full_like(heard.heard, -np.inf))
    state.looked = None
    state.drawn = state.listened = -math.inf
    state.time, state.told, state.felt, state.fixed, state.begun = -math.inf, now, now, now, now
    state.went = now
    state.across = dict.fromkeys(state.across, now)
    add_unknown(state, _FASTEST)  # how far it went and turned meanwhile is not known
    yaw = state.layout.attitude.stop - 1
    state.P[yaw, yaw] += _TURNED**2


def _take(settings: FilterSettings, state: FilterState, reading: Reading) -> None:
    """Take what is not of the lines."""
    own = settings.chain
    if isinstance(reading, Inertial):
        if felt(state.intake, own.tilt, reading):
            attitude.feel(settings, state, reading)
    elif isinstance(reading, Encoders):
        _count(settings, state, reading)
    elif isinstance(reading, DistanceReading):
        _sound(settings, state, reading)
    elif isinstance(reading, Scan) and reading.source in (*own.lidars, "vertical") and seen(state.intake, reading):
        queue(state.pending, reading, own.walls.keep)


def _count(settings: FilterSettings, state: FilterState, reading: Encoders) -> None:
    """Carry B and the lengths on; counts that come after a gap tell nothing, since lidars told meanwhile."""
    own = settings.chain
    by, since = turned(state.intake, reading, own.counts, own.fastest)
    late = reading.time - state.told > state.gap
    state.told = reading.time
    if by is None:
        if since > 0.0:
            add_unknown(state, _FASTEST * since)
    else:
        still = reading.time - state.went
        if by.any():
            state.went = reading.time
            if state.free:
                _hold(state)
        elif state.gap < still <= state.gap + _RESTS:  # the drum stands, or the encoders do
            _go_free(state)
        elif state.free and not late and not state.watch.has("encoders", "stand"):
            _rest(state)
        if not late:
            state.angles = state.angles + by
            if not state.free:
                line_update.carry(settings, state, by, since)
    state.way.add(reading.time, np.concatenate([state.angles, state.drifted]))


def _sound(settings: FilterSettings, state: FilterState, reading: DistanceReading) -> None:
    """Let the distance sensor tell how high B is over what lies under the valve."""
    valve, lay = settings.chain.valve, state.layout
    if valve is None or not math.isfinite(reading.distance):
        return
    H = np.zeros((1, lay.size))
    H[0, lay.position][2], H[0, lay.ground] = 1.0, -1.0
    off = np.array([reading.distance + valve - float(state.position[2]) + state.ground])
    R = np.array([[settings.level_height**2]])
    fits = lidar_update.measure(state, "distance", H, off, R, ("distance", "gate"), "")
    if not fits and state.refused["distance"] > _TRIES:
        state.P[lay.ground, lay.ground] += float(off[0]) ** 2


def _go_free(state: FilterState) -> None:
    """Let B go on as it went, since no encoder tells; it may as well have stopped."""
    if state.free:
        return
    state.free = True
    _doubt_velocity(state, 0.5 * _FASTEST * _CALM)


def _rest(state: FilterState) -> None:
    """Believe that B stands: no winch drum has turned for a while, and no lidar saw it go."""
    state.free = False
    _doubt_velocity(state, np.zeros(3))
    state.rates = np.zeros_like(state.rates)


def _doubt_velocity(state: FilterState, deviation: Array) -> None:
    """Let the velocity be known to a standard *deviation* (3,), m/s, and hang together with nothing else."""
    velocity = state.layout.velocity
    state.P[velocity] = 0.0
    state.P[:, velocity] = 0.0
    state.P[velocity, velocity] = np.diag(deviation**2)


def _hold(state: FilterState) -> None:
    """Go by the encoders again."""
    state.free = False  # what its velocity was off stays in the covariance, for turns that began before
    state.begun = state.time  # such turns are bent: lidars count less for a while
    add_unknown(state, _FIRST)
    state.watch.clear("encoders", "stand")


def _drift(settings: FilterSettings, state: FilterState, dt: float) -> None:
    """Carry B and the lengths on by its velocity."""
    lay, taut = state.layout, state.taut
    if taut is None or not dt > 0.0:
        return
    F = np.eye(lay.size)
    F[lay.position, lay.velocity] = dt * np.eye(3)
    F[lay.lengths, lay.velocity] = dt * taut.toward
    P = F @ state.P @ F.T
    P[lay.velocity, lay.velocity] += np.diag((settings.push * _CALM) ** 2) * dt
    P[lay.lengths, lay.lengths] += _LET_OUT**2 * dt * np.eye(len(state.lengths))
    state.P = 0.5 * (P + P.T)
    moved = dt * state.velocity
    state.position = state.position + moved
    state.lengths = state.lengths + taut.toward @ moved
    state.drifted = state.drifted + np.append(moved, dt)
    state.way.add(state.time, np.concatenate([state.angles, state.drifted]))


def _see(settings: FilterSettings, state: FilterState) -> None:
    """Do the next bit of work on the lidars' turns: as much as there is time for in one step."""
    if state.looked is not None:
        source = state.looked.scan.source
        lidar_update.place(settings, state)
        _stand(state)
        if state.refused.get(source, 0) and not state.free:
            state.went = max(state.went, state.time - state.gap)  # if the counts stand, B may not
        if state.refused.get(source, 0) >= _DOUBTED:
            add_unknown(state, _FIRST)
            yaw = state.layout.attitude.stop - 1
            state.P[yaw, yaw] += _FIRST_YAW**2
        return
    if not state.pending:
        return
    scan = state.pending.pop(0)
    if scan.time - state.felt > state.gap:
        attitude.coast(settings, state, scan.time)
    if scan.source == "vertical":
        vertical_update.vertical(settings, state, scan)
    else:
        lidar_update.look(settings, state, scan)


def _stand(state: FilterState) -> None:
    """Say that the counts stand while the lidars see the drum go."""
    spread = float(np.trace(state.P[state.layout.velocity, state.layout.velocity]))
    if state.free and state.time - state.told < state.gap and _sure(state.velocity, spread):
        state.watch.say("encoders", "stand", "no winch drum turns by its counts, but the drum goes on: not used")


def _sure(velocity: Array, spread: float) -> bool:
    """Whether B goes, by a velocity with that variance in space."""
    speed = float(np.sqrt(velocity @ velocity))
    return speed > _GOES and speed > 2.0 * math.sqrt(spread)


def _estimate(settings: FilterSettings, state: FilterState) -> Estimate:
    """Say what is believed, and how surely."""
    if not state.free:
        state.velocity = state.jacobian @ (state.radii * state.rates)
    late = min(max(state.time - state.told, 0.0), state.gap) if not state.free else 0.0
    place, paid = state.position + late * state.velocity, late * state.radii * state.rates
    turning = min(max(state.time - state.felt, 0.0), state.gap) * state.turn_rate
    covariance = _covariance(settings, state)
    own = settings.chain
    sure = float(covariance[0, 0] + covariance[1, 1] + covariance[2, 2]) <= settings.unsure**2
    x, y = (state.tilt + turning[:2]).tolist()
    out = line_update.excess(state)
    return Estimate(
        state.time,
        frozen(place),
        frozen(state.velocity),
        frozen(rotation_vector(state.yaw + float(turning[2]), x, y)),
        frozen(state.lengths + paid),
        frozen(out),
        out > own.slackness.slack,
        frozen(state.radii),
        covariance,
        state.watch.faults,
        valid=sure and state.time - state.fixed <= own.lost and not state.watch.has("encoders", "lost"),
        clearance=float(place[2]) + state.clearance_off,
    )


def _covariance(settings: FilterSettings, state: FilterState) -> Array:
    """Covariance (9, 9) of position, velocity and rotation in space."""
    lay = state.layout
    G = np.zeros((9, lay.size))
    G[:3, lay.position] = np.eye(3)
    if state.free:
        G[3:6, lay.velocity] = np.eye(3)
    else:
        G[3:6, lay.radii] = state.jacobian * (state.radii * state.rates)
    c, s = math.cos(state.yaw), math.sin(state.yaw)
    G[6:, lay.attitude] = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]
    found = G @ state.P @ G.T
    diagonal = found.reshape(-1)[::10]
    diagonal[3:6] += settings.speed**2
    late = state.time - state.felt
    diagonal[6:] += settings.tremble**2
    if late > state.gap:
        diagonal[6:8] += settings.swing**2
        diagonal[8] += settings.turning**2 * late * (1.0 + late)
    made = 0.5 * (found + found.T)
    made.flags.writeable = False
    return np.asarray(made)
