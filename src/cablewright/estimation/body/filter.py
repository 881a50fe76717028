"""Pose of a rigid platform: the equilibrium of its lines' lengths, which load cells and inertial unit correct.

Encoders say what was paid out since home; the pose is the equilibrium of the lengths, with sag and slack. What is not
known of the machine (home lengths, drum radii, exit points, zeros and gains of cells, the mounting of the unit, the
load) is a state of constants with sigmas. Load cells and accelerometer measure combinations of them: a Kalman filter of
the constants, linearised at each equilibrium.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array
from cablewright.estimation.body import counts, diagnosis, measurement
from cablewright.estimation.body.correction import correct
from cablewright.estimation.body.measurement import Slopes
from cablewright.estimation.body.settings import BodySettings
from cablewright.estimation.body.state import BodyState, corrected, follow, set_load
from cablewright.estimation.reading_checks import accepted
from cablewright.models.rotation import motion_between
from cablewright.signals import (
    BeamLength,
    Climate,
    Encoders,
    Estimate,
    Inertial,
    SensorFrame,
    Swivels,
    Tensions,
    frozen,
)

_SPEED_SIGMA: Final = 0.01  # m/s and rad/s, of the velocity by the lengths
_SHAKING_TIME: Final = 1.0  # s over which the platform's swing is watched
_SUDDEN: Final = 0.2  # share of one change of the specific force that counts at once
_CALM: Final = 0.02  # m/s^2: of the platform's acceleration that the lengths do not show


def step(settings: BodySettings, state: BodyState, frame: SensorFrame) -> Estimate:
    """Return the estimate after one frame; *state* changes in place. No frame raises an error."""
    dt = frame.time - state.time
    if not dt > 0.0:
        state.monitor.restart(frame.time, f"the clock jumped from {state.time:g} to {frame.time:g} s")
        state.window.begin, dt = math.nan, math.inf
    state.time, before = frame.time, state.pose
    for beam in accepted(state.monitor, frame.of(BeamLength), frame.time):
        _read_beam(settings, state, beam.length)
    for encoders in accepted(state.monitor, frame.of(Encoders), frame.time):
        counts.read(settings, state, encoders)
    state.gradients[_by_radius(state)] = state.paid
    state.lengths = corrected(state)
    found = follow(state)
    for climate in accepted(state.monitor, frame.of(Climate), frame.time):
        state.creep.read(climate)
    state.creep.advance(state.tensions, frame.time, settings.interval)
    _smooth_velocity(settings, state, before, dt)
    _read_forces(settings, state, frame)
    slopes = None
    if frame.time - state.window.begin >= settings.interval - 1e-9 and found:
        slopes = _measure(settings, state)
    elif math.isnan(state.window.begin):
        state.window.begin, state.window.velocity = frame.time, state.velocity.copy()
        measurement.set_gradients(state)
        slopes = measurement.slopes_of(state)
    diagnosis.give_up(state)
    state.monitor.check_timeouts(frame.time)
    return _estimate(settings, state, slopes, found)


def _by_radius(state: BodyState) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Where the gradients of the lengths by the drums' radii are."""
    lines = np.arange(state.layout.m)
    return lines, state.layout.radius.start + lines


def _read_beam(settings: BodySettings, state: BodyState, length: float) -> None:
    """Take the measured length of a platform that retracts."""
    own = settings.model.robot.retraction
    if own is None or not math.isfinite(length):
        return
    state.retraction = min(max(length, own.least), own.most)
    set_load(state, settings.model)


def _smooth_velocity(settings: BodySettings, state: BodyState, before: Array, dt: float) -> None:
    if not math.isfinite(dt):
        state.velocity = np.zeros(6)
        return
    moved = motion_between(before, state.pose) / dt
    state.velocity = state.velocity + min(1.0, dt / settings.smoothing_time) * (moved - state.velocity)


def _read_forces(settings: BodySettings, state: BodyState, frame: SensorFrame) -> None:
    """Add the readings of load cells, inertial unit and swivels to the window, less what is predicted of them."""
    expected, m = measurement.predictions(state), state.layout.m
    if settings.cells is not None:
        for reading in accepted(state.monitor, frame.of(Tensions), frame.time):
            if reading.source == settings.cells.source and len(reading.tensions) == m:
                state.window.tensions.append(reading.tensions - expected[:m])
                diagnosis.read(settings, state, reading.tensions)
    if settings.tilt is not None:
        for unit in accepted(state.monitor, frame.of(Inertial), frame.time):
            size = math.sqrt(float(unit.acceleration @ unit.acceleration))
            if size > 0.0:
                state.window.tilts.append(unit.acceleration[:2] / size - expected[m : m + 2])
                _shake(state, unit.acceleration, unit.time)
    if settings.swivels is not None:
        for turned in accepted(state.monitor, frame.of(Swivels), frame.time):
            if len(turned.angles) == m:
                off = turned.angles - expected[m + 2 :]
                state.window.swivels.append(np.arctan2(np.sin(off), np.cos(off)))


def _shake(state: BodyState, force: Array, now: float) -> None:
    """Follow the mean of the specific force, and how much it changes: a platform that swings."""
    if state.specific_force is None:
        state.specific_force, state.shaken_at = force.copy(), now
        return
    share = min(1.0, (now - state.shaken_at) / _SHAKING_TIME)
    state.shaken_at = now
    change = force - state.specific_force
    state.specific_force = state.specific_force + share * change
    size = float(change @ change)
    state.shaking = max(state.shaking + share * (size - state.shaking), _SUDDEN * size)


def _measure(settings: BodySettings, state: BodyState) -> Slopes | None:
    """Close the window: correct the unknowns by its readings."""
    window, passed = state.window, state.time - state.window.begin
    begun = state.velocity if window.velocity is None else window.velocity
    change = (state.velocity - begun)[:3] / max(passed, 1e-9)
    slopes = correct(settings, state, math.sqrt(float(change @ change) + state.shaking) + _CALM)
    window.begin, window.velocity = state.time, state.velocity.copy()
    for each in (window.tensions, window.tilts, window.swivels):
        each.clear()
    return slopes


def _estimate(settings: BodySettings, state: BodyState, slopes: Slopes | None, found: bool) -> Estimate:
    pose = state.pose
    if slopes is not None:
        state.pose_covariance = measurement.pose_covariance(state, slopes)
    covariance = np.zeros((9, 9))
    covariance[np.ix_(_POSE, _POSE)] = state.pose_covariance
    covariance[range(3, 6), range(3, 6)] = _SPEED_SIGMA**2
    excess = state.lengths - state.taut.lengths
    return Estimate(
        state.time,
        frozen(pose[:3]),
        frozen(state.velocity[:3]),
        frozen(pose[3:]),
        frozen(state.lengths),
        frozen(excess),
        excess > settings.slack_threshold,
        frozen(counts.radii(settings, state)),
        covariance=frozen(covariance),
        faults=state.monitor.faults,
        valid=found and state.homed and not state.monitor.is_active("encoders", "quiet"),
        consistency=state.consistency,
    )


_POSE: Final = (0, 1, 2, 6, 7, 8)
