"""The filter's attitude: a drum that bounces, a tilt that is wrong, and accelerations that no drum has."""

from __future__ import annotations

import copy

import numpy as np
import pytest

from cablewright.estimation.kalman import attitude
from cablewright.estimation.kalman.state import FilterState
from cablewright.foundation.signals import Inertial
from cablewright.live.estimator_settings import started_settings
from cablewright.robot import load
from twins import SETTINGS

KNOWN = started_settings(load("merlet2023"), SETTINGS).filter


def taught(later: FilterState) -> FilterState:
    """As sure of tilt and biases as after hours."""
    state = copy.deepcopy(later)
    sure, lay = np.ones(len(state.P)), state.layout
    sure[lay.tilt], sure[lay.gyro_bias], sure[lay.accelerometer_bias] = 0.5, 0.02, 0.02
    state.P *= np.outer(sure, sure)
    return state


def test_a_bounce_leaves_no_tilt(later: FilterState) -> None:
    """Rates one way come with large accelerations: those that were left out would stay in the tilt."""
    state, omega, size, fading = taught(later), 2.0 * np.pi * 4.5, 5e-3, 2.0
    begin, bias = state.attitude.tilt.copy(), state.built.accelerometer_bias.copy()
    off = []
    for step in range(1, 301):
        t = 0.01 * step
        grown, wave = np.exp(-fading * t), omega * t
        lean = size * grown * np.sin(wave)
        rate = size * grown * (omega * np.cos(wave) - fading * np.sin(wave))
        beat = grown * (5.0 * np.cos(wave) + 2.5 * np.cos(2.0 * wave))
        force = np.array([-9.81 * bias[1], 9.81 * bias[0] + beat, 9.81])
        reading = Inertial(later.attitude.last_imu_time + t, force, state.built.gyro_bias + np.array([rate, 0.0, 0.0]))
        attitude.read(KNOWN, state, reading)
        off.append(state.attitude.tilt[0] - begin[0] - lean)
    assert np.abs(off).max() < 2.5e-3


def test_a_tilt_that_is_wrong_is_right_again_after_some_seconds(later: FilterState) -> None:
    """Gravity and the suspension contradict it each time: it is not taken for a drum that is shaken for ever."""
    state, random = taught(later), np.random.default_rng(5)
    lean = 0.03
    state.attitude.tilt = state.attitude.tilt + np.array([lean, 0.0])
    bias = state.built.accelerometer_bias.copy()
    wrong = []
    for step in range(1, 2001):
        force = np.array([-9.81 * bias[1], 9.81 * bias[0], 9.81]) + 0.03 * random.standard_normal(3)
        rate = state.built.gyro_bias + 0.002 * random.standard_normal(3)
        attitude.predict(KNOWN, state, Inertial(later.attitude.last_imu_time + 0.01 * step, force, rate))
        wrong.append(float(np.linalg.norm(state.attitude.tilt)))
    assert wrong[0] > 0.9 * lean
    assert max(wrong[1000:]) < 2e-3
    assert np.linalg.norm(state.built.accelerometer_bias - bias) < 2e-3


@pytest.mark.parametrize("force", [1e20, 1e160, 1e300, np.inf, np.nan])
def test_an_acceleration_that_no_drum_has_changes_nothing(later: FilterState, force: float) -> None:
    """One of them, with a rate that is possible, would leave no number in the covariance."""
    state, usual = copy.deepcopy(later), np.array([0.0, 0.0, 9.81])
    for step in range(1, 21):
        wrong = np.array([force, 0.0, 9.81])
        reading = Inertial(
            later.attitude.last_imu_time + 0.01 * step, wrong if step == 5 else usual, np.full(3, 1e-4 * step)
        )
        attitude.read(KNOWN, state, reading)
    assert np.isfinite(state.P).all()
    assert np.linalg.norm(state.attitude.tilt - later.attitude.tilt) < 2e-3
