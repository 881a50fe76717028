"""Attitude of the platform in the filter: predicted by the gyro, updated by gravity and as a pendulum."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from cablewright.estimation.kalman.settings import FilterSettings
from cablewright.estimation.kalman.state import FilterState, apply_update, diagonal, inflate_shaken, judge, passes_gate
from cablewright.estimation.reading_checks import accept_imu
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Inertial
from cablewright.kernels import Direct
from cablewright.kernels.filtering import predict as kernel

_READINGS: Final = 10  # of the accelerometer, for one update
_INTERVAL: Final = 0.1  # s between updates
_QUIET_TIME: Final = 3.0  # s without shaking, after which it starts again
_MAX_SHAKING: Final = 20.0  # s
_LEANING: Final = 3e-4  # rad, of each update that the suspension contradicts: after some of them a wrong tilt is right
_MAX_NIS: Final = 20.0  # of one update, as it counts for the sensor's consistency
_MAX_INTERVAL: Final = 0.1  # s between readings, by which a swing is followed
_TURN: Final = Direct(kernel.turn)
_SMOOTHING: Final = 0.2  # gain of the low-pass filter of B's acceleration


def read(settings: FilterSettings, state: FilterState, reading: Inertial) -> None:
    """Predict the attitude by an IMU *reading* that is accepted."""
    if accept_imu(state.checks, settings.machine.tilt, reading):
        predict(settings, state, reading)


def predict(settings: FilterSettings, state: FilterState, reading: Inertial) -> None:
    """Integrate the attitude to the time of an accepted IMU *reading*."""
    dt = reading.time - state.attitude.last_imu_time
    if not dt <= state.motion.max_gap:
        predict_without_imu(settings, state, reading.time - 0.5 * state.motion.max_gap)
        dt = reading.time - state.attitude.last_imu_time if state.attitude.last_imu_time > -np.inf else 0.0
    rate, turned, (x, _, at) = reading.rate.tolist(), state.attitude, state.mean
    _TURN.call(x, state.P, at, *rate, float(dt), float(settings.gyro_noise), turned.angular_rate)
    turned.gyro_yaw += dt * float(turned.angular_rate[2])
    turned.last_imu_time = reading.time
    if dt > _MAX_INTERVAL:  # one rate does not determine the end of a swing
        _predict_upright(settings, state)
    state.turns.attitudes.add(reading.time, (state.attitude.gyro_yaw, *state.attitude.tilt.tolist()))
    fx, fy, _ = reading.acceleration.tolist()
    g = settings.machine.tilt.gravity
    if math.hypot(fx, fy) < g:  # up to that a bounce's are needed, too: their mean is that of gravity. NaN is not
        state.attitude.measured_tilts.append((fy / g, -fx / g))
    if len(state.attitude.measured_tilts) >= _READINGS:
        _update_by_gravity(settings, state)


def _update_by_gravity(settings: FilterSettings, state: FilterState) -> None:
    """Update by two measurements: gravity shows tilt plus accelerometer bias; the suspension, a tilt of zero."""
    measured = np.mean(state.attitude.measured_tilts, axis=0)
    state.attitude.measured_tilts.clear()
    velocity = state.hung.jacobian[:2] @ (state.lines.radii * state.motion.drum_rates)
    smoothed = state.attitude.level_acceleration
    acceleration = smoothed + _SMOOTHING * ((velocity - state.attitude.level_velocity) / _INTERVAL - smoothed)
    state.attitude.level_velocity, state.attitude.level_acceleration = velocity, acceleration
    # an accelerated drum tilts, and its accelerometer does not show that
    unseen = float(acceleration @ acceleration) / settings.machine.tilt.gravity**2
    seen = settings.gravity_sigma**2 + unseen * settings.swing_period / _INTERVAL
    upright = (settings.swing_sigma**2 + unseen) * settings.swing_period / _INTERVAL
    hangs, _ = _update_tilt(state, -state.attitude.tilt, upright, biased=False)
    if not hangs:  # it swings far, or the tilt is wrong
        diagonal(state.P)[state.layout.tilt] += _LEANING**2
    innovation = measured - state.attitude.tilt - state.built.accelerometer_bias
    rests, nis = _update_tilt(state, innovation, seen, biased=True)
    if not rests:  # B is shaken in a way that encoders do not show
        _note_shaking(state, settings.machine.tilt.gravity * float(np.hypot(*innovation)), settings.swing_period)
    judge(state, "inertial", min(nis, _MAX_NIS), len(measured))


def _update_tilt(state: FilterState, innovation: Array, variance: float, *, biased: bool) -> tuple[bool, float]:
    """Update by a tilt, *biased* as the accelerometer is or not, by less where the gate rejects it.

    Returns whether it passes, and its NIS.
    """
    lay = state.layout
    H = np.zeros((2, lay.size))
    H[:, lay.tilt] = np.eye(2)
    if biased:
        H[:, lay.accelerometer_bias] = np.eye(2)
    R = variance * np.eye(2)
    passes, nis = passes_gate(state.P, H, innovation, R)
    apply_update(state, H, innovation, R if passes else nis * R)
    return passes, nis


def _note_shaking(state: FilterState, acceleration: float, period: float) -> None:
    """Note that B is shaken by an *acceleration*, m/s^2, in swings of at most a *period*, s.

    What lasts longer than any shaking is the sensor's fault.
    """
    now = state.attitude.last_imu_time
    if now - state.attitude.shaken_time > _QUIET_TIME:
        state.attitude.shaken_since = now
    if now - state.attitude.shaken_since > _MAX_SHAKING:
        state.monitor.report("inertial", "shaken", "measures accelerations that nothing else shows: not used")
        return
    state.attitude.shaken_time = now
    inflate_shaken(state, acceleration * (period / math.tau) ** 2)


def predict_without_imu(settings: FilterSettings, state: FilterState, time: float) -> None:
    """Predict the attitude at *time*, s, without the IMU: upright, with an unknown yaw rate."""
    dt = time - state.attitude.last_imu_time
    if not 0.0 < dt < 1e6:
        state.attitude.last_imu_time = max(state.attitude.last_imu_time, time)
        return
    state.attitude.last_imu_time = state.attitude.imu_gap_end = time
    state.attitude.measured_tilts.clear()
    _predict_upright(settings, state)
    state.P[state.layout.yaw, state.layout.yaw] += settings.turn_rate_sigma**2 * dt * (1.0 + dt)
    state.attitude.angular_rate[2] = 0.0
    state.turns.attitudes.add(time, (state.attitude.gyro_yaw, 0.0, 0.0))


def _predict_upright(settings: FilterSettings, state: FilterState) -> None:
    """Predict the tilt of a drum that hangs from one point, without what it was before."""
    tilt, P = state.layout.tilt, state.P
    P[tilt] = 0.0
    P[:, tilt] = 0.0
    diagonal(P)[tilt] = settings.swing_sigma**2
    state.attitude.tilt[:] = state.attitude.angular_rate[:2] = 0.0
