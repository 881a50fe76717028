"""How the drum leans: a pendulum's swing, biased sensors, and rotation vectors beside SciPy's."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from cablewright.estimation import tilt
from cablewright.estimation.fault_monitor import FaultMonitor
from cablewright.estimation.reading_checks import ReadingChecks, accept_imu
from cablewright.estimation.tilt import TiltSettings, TiltState, rotation_vector
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Inertial

G = 9.81
SETTINGS = TiltSettings(G)


def swung(seconds: float, size: float, bias: float = 0.0, place: float = 0.1) -> tuple[list[TiltState], np.ndarray]:
    """States, and true leans about x, of a pendulum of 0.6 m with an accelerometer *place* (m) below its joint."""
    omega = math.sqrt(G / 0.6)
    state, states, truth = tilt.start(), [], []
    for k in range(round(seconds / 0.01)):
        t = 0.01 * k
        lean, rate, speeding = (size * f for f in (math.cos(omega * t), -omega * math.sin(omega * t), 0.0))
        speeding = -(omega**2) * lean
        # along the drum's y: gravity's part, and that of the place at (0, 0, -place) that speeds up
        sideways = G * math.sin(lean) + place * speeding
        force = np.array([bias, sideways + bias, G * math.cos(lean) + place * rate**2])
        state = tilt.step(SETTINGS, state, Inertial(t, force, np.array([rate + bias, bias, 0.0])), 0.0)
        states.append(state)
        truth.append(lean)
    return states, np.array(truth)


@pytest.mark.parametrize("bias", [0.0, -0.02, 0.03])
def test_a_swing_is_followed_and_the_bias_of_sensors_is_learnt(bias: float) -> None:
    states, truth = swung(120.0, 0.05, bias)
    late = slice(9000, None)
    assert np.abs([s.x for s in states] - truth)[late].max() < 0.2 * 0.05
    assert max(abs(s.y) for s in states) < 1e-9
    assert abs(states[-1].gyro_bias[1] - bias) < 1e-9


def test_a_drum_that_hangs_still_is_upright() -> None:
    state = tilt.start()
    for k in range(300):
        state = tilt.step(SETTINGS, state, Inertial(0.01 * k, np.array([0.1, -0.2, G]), np.full(3, 0.01)), 0.0)
    assert max(abs(state.x), abs(state.y)) < 1e-12


@pytest.mark.parametrize(
    ("time", "acceleration", "rate"),
    [
        (1.0, [40.0, 2.0, G], [0.0] * 3),
        (1.0, [0.0, 0.0, G], [0.0, 0.0, 8.0]),
        (0.51, [0.0, 0.0, G], [0.0, 0.0, 8.0]),
        (1.0, [math.nan] * 3, [0.0] * 3),
        (1.0, [0.0] * 3, [math.inf, 0, 0]),
        (0.0, [1.0, 1.0, G], [1.0] * 3),
    ],
)
def test_readings_that_are_none_change_nothing(time: float, acceleration: list[float], rate: list[float]) -> None:
    state = tilt.step(SETTINGS, tilt.start(), Inertial(0.5, np.array([0.1, 0.1, G]), np.zeros(3)), 0.0)
    assert tilt.step(SETTINGS, state, Inertial(time, np.array(acceleration), np.array(rate)), 0.0) == state


def test_the_gyro_of_a_drum_that_bounces_is_integrated_without_gravity() -> None:
    state = tilt.step(SETTINGS, tilt.start(), Inertial(0.0, np.array([0.0, 0.0, G]), np.zeros(3)), 0.0)
    bounced = tilt.step(SETTINGS, state, Inertial(0.01, np.array([5.5, -3.0, G]), np.array([0.2, 0.0, 0.0])), 0.0)
    assert bounced.accelerometer_bias == state.accelerometer_bias
    assert bounced.x == pytest.approx(0.01 * (0.2 - bounced.gyro_bias[0]))
    late = Inertial(1.0, np.array([5.5, -3.0, G]), np.zeros(3))
    assert tilt.step(SETTINGS, state, late, 0.0) == state


@pytest.mark.parametrize(
    "force", [[0.0] * 3, [0.0, 0.0, 1.0], [0.0, 0.0, -G], [0.0, G, 0.0], [0.0, 3.1, G], [math.nan] * 3]
)
def test_what_is_not_gravity_is_not_taken_for_it(force: list[float]) -> None:
    """Dead, in units of g, upside down, or on its side."""
    assert not SETTINGS.has_gravity(Inertial(0.0, np.array(force), np.zeros(3)))


def test_an_axis_that_is_stuck_is_named_after_a_second_and_a_bounce_is_not() -> None:
    checks, named = ReadingChecks(FaultMonitor({})), []
    for k in range(300):
        force = np.array([0.01 * (k % 7), 5.0 if 100 <= k < 250 else 0.0, G])
        accepted = accept_imu(checks, SETTINGS, Inertial(0.01 * k, force, np.array([1e-3 * (k % 5), 0.0, 0.0])))
        named.append(checks.monitor.is_active("inertial", "implausible"))
        assert accepted is not None
        assert accepted != named[-1]
    assert named.index(True) == pytest.approx(200, abs=1)
    assert sum(named) == pytest.approx(50, abs=1)


def test_times_that_are_none_are_rejected() -> None:
    with pytest.raises(InputError, match="gravity_time = 0"):
        TiltSettings(gravity_time=0.0)


@given(st.floats(-3.1, 3.1), st.floats(-0.3, 0.3), st.floats(-0.3, 0.3))
def test_rotation_vectors_are_scipys(yaw: float, x: float, y: float) -> None:
    whole = Rotation.from_rotvec([0.0, 0.0, yaw]) * Rotation.from_rotvec([x, y, 0.0])
    found = Rotation.from_rotvec(rotation_vector(yaw, x, y))
    assert (whole.inv() * found).magnitude() < 1e-12
