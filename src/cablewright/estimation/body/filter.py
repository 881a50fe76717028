"""Estimator of a rigid platform's pose: the equilibrium of its line lengths, corrected by load cells and tilt.

Encoders give the lengths paid out since home; the pose is the equilibrium of the lengths, with sag and slack. The
unknown constants of the machine (home lengths, drum radii, exit points, zeros and gains of cells, the mounting of the
unit, the load) are a state with sigmas. Load cells and accelerometer measure combinations of them: a Kalman filter of
the constants, linearised at each equilibrium.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

import numpy as np

from cablewright.estimation.body import diagnosis, encoder_lengths, measurement
from cablewright.estimation.body.correction import correct
from cablewright.estimation.body.settings import BodySettings
from cablewright.estimation.body.state import BodyState, corrected, follow, set_load
from cablewright.estimation.body.updates.update import Slopes
from cablewright.estimation.measured_tensions import smoothed
from cablewright.estimation.reading_checks import accepted, by_machine_clock
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import (
    BeamLength,
    Climate,
    Encoders,
    Estimate,
    SensorFrame,
    Tensions,
    per_line,
)
from cablewright.kernels import Direct
from cablewright.kernels.filtering import body_lengths
from cablewright.kernels.filtering.reckoning import AXES, OF_LINES, ROTATION, SPEED
from cablewright.models.rotation import motion_between, moved

_SPEED_SIGMA: Final = 0.01  # m/s and rad/s, of the velocity by the lengths
_TELL: Final = Direct(body_lengths.tell)
_CALM: Final = 0.02  # m/s^2: of the platform's acceleration that the lengths do not show


def step(settings: BodySettings, state: BodyState, frame: SensorFrame) -> Estimate:
    """Return the estimate after one frame; *state* changes in place. No frame raises an error."""
    dt = frame.time - state.latest.time
    if not dt > 0.0:
        state.monitor.restart(frame.time, f"the clock jumped from {state.latest.time:g} to {frame.time:g} s")
        state.window.begin, dt = math.nan, math.inf
        state.motion.ways.clear()
    state.latest.time, before = frame.time, state.pose
    if state.latest.clock is not None:
        frame = replace(frame, readings=by_machine_clock(state.latest.clock, frame.readings, frame.time))
    for beam in accepted(state.monitor, frame.of(BeamLength), frame.time):
        _read_beam(settings, state, beam.length)
    for encoders in accepted(state.monitor, frame.of(Encoders), frame.time):
        encoder_lengths.read(settings, state, encoders)
    first, (m, size) = state.layout.radius.start, state.belief.gradients.shape
    state.belief.gradients.flat[first : first + m * (size + 1) : size + 1] = state.wound.paid  # by the drums' radii
    state.lengths = corrected(state)
    found = follow(state)
    motion = motion_between(before, state.pose)
    state.motion.way = moved(state.motion.way, motion)
    state.motion.ways.add(frame.time, state.motion.way)
    for climate in accepted(state.monitor, frame.of(Climate), frame.time):
        state.creep.read(climate)
    state.creep.advance(state.tensions, frame.time, settings.interval)
    _smooth_velocity(settings, state, motion, dt)
    _read_sensors(settings, state, frame)
    if settings.cells is not None:
        readings = accepted(state.monitor, frame.of(Tensions), frame.time)
        share = min(1.0, dt / settings.smoothing_time)
        state.latest.tensions = smoothed(state.latest.tensions, readings, settings.cells, share, state.layout.m)
    slopes = None
    if frame.time - state.window.begin >= settings.interval - 1e-9 and found:
        slopes = _measure(settings, state)
    elif math.isnan(state.window.begin):
        state.window.begin, state.window.velocity = frame.time, state.motion.velocity.copy()
        measurement.set_gradients(state)
        slopes = measurement.slopes_of(state)
    diagnosis.give_up(state)
    state.monitor.check_timeouts(frame.time)
    return _estimate(settings, state, slopes, found)


def _read_beam(settings: BodySettings, state: BodyState, length: float) -> None:
    """Take the measured length of a platform that retracts."""
    own = settings.model.robot.retraction
    if own is None or not math.isfinite(length):
        return
    state.retraction = min(max(length, own.least), own.most)
    set_load(state, settings.model)


def _smooth_velocity(settings: BodySettings, state: BodyState, motion: Array, dt: float) -> None:
    if not math.isfinite(dt):
        state.motion.velocity = np.zeros(6)
        return
    state.motion.velocity = state.motion.velocity + min(1.0, dt / settings.smoothing_time) * (
        motion / dt - state.motion.velocity
    )


def _read_sensors(settings: BodySettings, state: BodyState, frame: SensorFrame) -> None:
    """Add the readings of all sensors but encoders to the window, less what is predicted of them."""
    if not settings.winches.plain:
        encoder_lengths.see_drums(settings, state)
    for sensor, expected in zip(settings.sensors, measurement.predicted(settings, state), strict=True):
        for reading in accepted(state.monitor, frame.of(sensor.READING), frame.time):
            whole = all(len(getattr(reading, name)) == state.layout.m for name in per_line(sensor.READING))
            shown = sensor.read(settings, state, reading) if whole else None
            if shown is not None:
                state.window.readings.setdefault(sensor, []).append(sensor.wrapped(shown - expected))


def _measure(settings: BodySettings, state: BodyState) -> Slopes | None:
    """Close the window: correct the unknowns by its readings."""
    window, passed = state.window, state.latest.time - state.window.begin
    begun = state.motion.velocity if window.velocity is None else window.velocity
    change = (state.motion.velocity - begun)[:3] / max(passed, 1e-9)
    slopes = correct(settings, state, math.sqrt(float(change @ change) + state.motion.shaking) + _CALM)
    window.begin, window.velocity = state.latest.time, state.motion.velocity.copy()
    window.readings.clear()
    window.seen.clear()
    return slopes


def _estimate(settings: BodySettings, state: BodyState, slopes: Slopes | None, holds: bool) -> Estimate:
    if slopes is not None:
        state.belief.pose_covariance = measurement.pose_covariance(state, slopes)
    m, (radii, _, turns), lines = state.layout.m, settings.drums.tables, OF_LINES
    found, shares = np.empty(lines + 3 * m + AXES**2), state.belief.unknowns[state.layout.radius]
    trace = _TELL.call(
        state.pose, state.motion.velocity, state.lengths, state.taut.lengths, radii, turns, state.wound.angles,
        shares, state.belief.pose_covariance, _SPEED_SIGMA**2, found,
    )  # fmt: skip
    found.flags.writeable = False
    excess = found[lines + m : lines + 2 * m]
    return Estimate(
        state.latest.time,
        found[:SPEED],
        found[SPEED:ROTATION],
        found[ROTATION:lines],
        found[lines : lines + m],
        excess,
        excess > settings.slack_threshold,
        found[lines + 2 * m : lines + 3 * m],
        covariance=found[lines + 3 * m :].reshape(AXES, AXES),
        faults=state.monitor.faults,
        valid=holds
        and state.home.known
        and math.isfinite(trace)
        and not (state.monitor.is_active("encoders", "quiet") or state.monitor.is_active("camera", "contradiction")),
        consistency=state.judged.consistency,
    )
