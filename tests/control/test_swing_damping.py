"""A drum that swings below a point is damped by the platform's following it, also late."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
import pytest

from cablewright.control.swing_damping import ADDED, MOST_SPEED, SwingDamping, SwingState, follow

PERIOD = 0.01  # s
GRAVITY = 9.81
OWN = 0.01  # share of critical damping of the pendulum itself


def swing(settings: SwingDamping, *, delay: float = 0.0, lag: float = 0.02, tilt: float = 0.0, time: float = 25.0):
    """Amplitudes (k,), rad, of each second of a swing that begins with 0.01 rad, and where the platform has gone, m.

    An own integration of the pendulum: the command comes late by *delay*, s, and the winches have a *lag*, s; a sensor
    has an error of *tilt*, rad.
    """
    state, rate = SwingState(), settings.rate
    late = deque([0.0] * round(delay / PERIOD))
    angle, turning, speed, place = 0.01, 0.0, 0.0, 0.0
    angles = []
    for _ in range(round(time / PERIOD)):
        rotation = np.array([0.0, -(angle + tilt), 0.0])  # the drum is in +x of the platform
        late.append(float(follow(settings, state, rotation, PERIOD)[0]))
        command = late.popleft()
        for _ in range(4):
            dt = PERIOD / 4.0
            acceleration = (command - speed) / lag
            turning += dt * (-(rate**2) * angle - 2.0 * OWN * rate * turning - acceleration / settings.length)
            angle += dt * turning
            speed += dt * acceleration
            place += dt * speed
        angles.append(angle)
    return np.abs(np.array(angles)).reshape(-1, round(1.0 / PERIOD)).max(axis=1), place


DRUM = SwingDamping.of(GRAVITY, 0.45, 0.25)


def settling(amplitudes: np.ndarray) -> int:
    """Seconds until a tenth of the first amplitude remains."""
    return int(np.argmax(amplitudes < 0.1 * 0.01))


@pytest.mark.parametrize("delay", [0.0, 0.02, 0.04])
def test_it_settles_in_less_than_half_of_the_time(delay: float) -> None:
    with_damping, _ = swing(DRUM, delay=delay)
    without, _ = swing(SwingDamping(DRUM.rate, DRUM.length, 0.0), delay=delay, time=60.0)
    assert 0 < settling(with_damping) <= 0.25 * settling(without)


def test_it_is_stable_at_a_delay_of_40_ms_with_a_gain_of_seven() -> None:
    amplitudes, _ = swing(SwingDamping(DRUM.rate, DRUM.length, 7.0 * ADDED), delay=0.04)
    assert amplitudes[-1] < 1e-4


def test_a_sensor_that_has_an_error_leads_the_platform_nowhere() -> None:
    _, place = swing(DRUM, tilt=math.radians(0.5))
    _, right = swing(DRUM)
    assert place == pytest.approx(right, abs=1e-4)


def test_the_platform_follows_to_the_side_of_the_drum_at_a_limited_speed() -> None:
    state = SwingState(np.zeros(2))
    found = follow(DRUM, state, np.array([0.0, -0.3, 0.0]), PERIOD)
    assert found == pytest.approx([MOST_SPEED, 0.0, 0.0])
    found = follow(DRUM, SwingState(np.zeros(2)), np.array([0.3, 0.0, 0.0]), PERIOD)
    assert found == pytest.approx([0.0, MOST_SPEED, 0.0])


def test_the_rate_is_that_of_the_pendulum() -> None:
    assert DRUM.rate == pytest.approx(math.sqrt(GRAVITY * 0.45 / (0.45**2 + 0.25**2)))
