"""A drum on twisted lines whose yaw a drive holds: laws of the control, with and without a gyro, and when it stands."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cablewright.control.yaw import GIVE_UP, YawSettings, YawState, yaw_rate
from cablewright.foundation.signals import Inertial, SensorFrame, YawAngle, frozen

SETTINGS = YawSettings(held=0.0, max_speed=0.5, travel=math.pi / 2.0, turn=1.0)
DT = 0.01


def swung(
    stiffness: float,
    damping: float,
    inertia: float,
    *,
    delay: float,
    gyro: bool,
    rest: float = 0.1,
    sign: float = 1.0,
    time: float = 120.0,
) -> tuple[np.ndarray, YawState]:
    """Yaw (k,) of a drum under the control from *rest*, rad, on; the yaw it is given is *delay* old.

    Without the *gyro* that is a lidar's, new once a second. *sign* -1: a drive that turns the wrong way.
    """
    state, yaw, rate, angle, given = YawState(), rest, 0.0, 0.0, rest
    past = [yaw] * round(delay / DT)
    found = []
    for k in range(round(time / DT)):
        past.append(yaw)
        old = past.pop(0)
        if gyro or k % 100 == 0:
            given = old
        turned = Inertial(k * DT, frozen(np.zeros(3)), frozen(np.array([0.0, 0.0, rate])))
        speed = yaw_rate(SETTINGS, state, SensorFrame(k * DT, (turned,) if gyro else ()), given, DT)
        angle += sign * speed * DT
        rate += DT * (stiffness * (rest + angle - yaw) - damping * rate) / inertia
        yaw += DT * rate
        found.append(yaw)
    return np.array(found), state


@pytest.mark.parametrize(("stiffness", "damping"), [(1.0, 0.6), (0.3, 0.3), (3.0, 1.0), (3.0, 0.3)])
@pytest.mark.parametrize("inertia", [1.0, 1.5, 2.4])
def test_with_a_gyro_yaw_is_held_on_lines_of_any_twist(stiffness: float, damping: float, inertia: float) -> None:
    """The delay is ten times that of the wireless link."""
    found, _ = swung(stiffness, damping, inertia, delay=0.1, gyro=True)
    assert np.abs(found[-1000:]).max() < 2e-3
    assert np.abs(found).max() <= 0.1 + 1e-9
    alone = swung(stiffness, damping, inertia, delay=0.1, gyro=True, sign=0.0)[0]
    assert np.abs(found[1000:2000]).max() < 0.4 * np.abs(alone[1000:2000]).max()


@pytest.mark.parametrize("delay", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("inertia", [1.0, 1.5])
def test_without_one_it_is_stable_with_angles_two_turns_old(delay: float, inertia: float) -> None:
    found, state = swung(1.0, 0.6, inertia, delay=delay, gyro=False)
    assert np.abs(found[-1000:]).max() < 2e-3
    assert state.angle == pytest.approx(-0.1, abs=5e-3)


def test_a_drive_that_turns_the_wrong_way_stands_at_the_limits() -> None:
    found, state = swung(1.0, 0.6, 1.5, delay=0.1, gyro=True, sign=-1.0, rest=0.05)
    assert abs(state.angle) <= SETTINGS.travel
    assert np.abs(found).max() < 2.0  # the drum swings past the drive
    assert np.ptp(found[-1000:]) < 0.05
    state = YawState(angle=0.3)
    for yaw in (math.nan, GIVE_UP + 0.01, -GIVE_UP - 0.01):
        assert yaw_rate(SETTINGS, state, SensorFrame(1.0), yaw, DT) == 0.0
    assert state.angle == 0.3


def test_it_goes_on_from_where_it_stood() -> None:
    """After a stop the drive begins without a jump; a lost gyro does not move it immediately either."""
    state, turned = YawState(angle=0.2, integral=-5.0), Inertial(1.0, frozen(np.zeros(3)), frozen(np.zeros(3)))
    assert yaw_rate(SETTINGS, state, SensorFrame(1.0, (turned,)), 0.05, DT) == pytest.approx(0.0, abs=0.01)
    assert yaw_rate(SETTINGS, state, SensorFrame(1.5), 0.05, DT) == pytest.approx(0.0, abs=0.01)


def test_speed_and_travel_are_within_the_drive() -> None:
    state, sum_of_speeds = YawState(), 0.0
    for k in range(3000):
        turned = Inertial(k * DT, frozen(np.zeros(3)), frozen(np.zeros(3)))
        speed = yaw_rate(SETTINGS, state, SensorFrame(k * DT, (turned,)), 0.7, DT)
        assert abs(speed) <= SETTINGS.max_speed
        sum_of_speeds += speed * DT
    assert sum_of_speeds == pytest.approx(-SETTINGS.travel, abs=1e-6)
    assert state.angle == pytest.approx(sum_of_speeds)


def test_steps_of_a_second_are_stable_too() -> None:
    """A quasi-static machine: the drum follows the drive immediately."""
    state, angle = YawState(), 0.0
    for k in range(200):
        angle += yaw_rate(SETTINGS, state, SensorFrame(float(k)), 0.1 + angle, 1.0)
    assert angle == pytest.approx(-0.1, abs=1e-3)


def test_angles_that_are_overtaken_or_ahead_of_the_clock_do_not_count() -> None:
    state = YawState()
    for now, stamp, angle in ((1.0, 1.0, 0.2), (1.1, 0.9, 0.5), (1.2, 7.0, 0.6), (1.3, 1.3, 0.3)):
        yaw_rate(SETTINGS, state, SensorFrame(now, (YawAngle(stamp, angle),)), math.nan, DT)
        assert state.angle == (0.3 if now == 1.3 else 0.2)


@pytest.mark.parametrize("encoder", [True, False])
def test_an_encoder_shows_a_drive_that_was_held_up_where_it_is(encoder: bool) -> None:
    """For a while the drive does not follow: by its commands it would be at the end of its travel."""
    state, yaw, rate, angle, stuck = YawState(), 0.3, 0.0, 0.0, []
    for k in range(6000):
        now = k * DT
        read = [Inertial(now, frozen(np.zeros(3)), frozen(np.array([0.0, 0.0, rate])))]
        read += [YawAngle(now, angle)] if encoder else []
        speed = yaw_rate(SETTINGS, state, SensorFrame(now, tuple(read)), yaw, DT)
        angle += speed * DT * (now > 30.0)
        rate += DT * ((0.3 + angle - yaw) - 0.6 * rate)
        yaw += DT * rate
        if 29.0 < now < 30.0:
            stuck.append(state.angle - angle)
    if encoder:
        assert np.abs(stuck).max() < 0.05
        assert abs(yaw) < 5e-3
        assert abs(state.angle - angle) < 0.01
    else:
        assert np.abs(stuck).max() > 0.5
        assert abs(state.angle - angle) > 0.5
