"""Pauses, the way to the path and the start of a jog excite no swing; a stop and a jog that is let go are as before."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cablewright.control import manual, path_follower
from cablewright.control.manual import LEASE, ManualSettings, ManualState
from cablewright.control.path_follower import GuideMode, GuideState, Target, TimedPath
from cablewright.control.speed_smoothing import RampMean
from cablewright.foundation.signals import Order, OrderKind
from cablewright.printing.job import Job, Motion

DT = 0.01
FREQUENCY = 1.7  # Hz, for which ramps are shaped
REACH = 1.6 / FREQUENCY  # s, of the mean
WRONG = ((1.0, 0.1), (0.9, 0.1), (1.1, 0.1), (0.75, 0.3), (1.25, 0.3))
FOLLOW, HOLD, PAUSE, APPROACH = GuideMode.FOLLOW, GuideMode.HOLD, GuideMode.PAUSE, GuideMode.APPROACH
BY_HAND = ManualSettings((-1.0, -1.0, 0.0), (1.0, 1.0, 2.0), 0.5, deceleration=0.8)


def period(_place: np.ndarray) -> float:
    return 1.0 / FREQUENCY


@pytest.fixture
def sharp(tmp_path: Path) -> TimedPath:
    """A straight path at 0.3 m/s whose ramps are not shaped."""
    (tmp_path / "part.gcode").write_text("M83\nG0 X0 Y0 Z1000 F18000\nG1 X6000 E9\n")
    motion = Motion(acceleration=0.5, print_speed=0.3, travel_speed=0.3)
    return TimedPath.of(Job(name="line", gcode=tmp_path / "part.gcode", motion=motion))


def swing(velocities: np.ndarray, frequency: float) -> float:
    """The amplitude, m, of an undamped mode about a target that has come to a steady velocity (k, 3), m/s."""
    jumps, rate = np.diff(velocities, axis=0, prepend=velocities[:1]), 2.0 * np.pi * frequency
    waves = (jumps * np.exp(1j * rate * DT * np.arange(len(jumps)))[:, None]).sum(axis=0) / rate
    return float(np.linalg.norm(np.abs(waves)))


def ridden(path: TimedPath, state: GuideState, modes: list[GuideMode]) -> list[Target]:
    return [path_follower.step(path, state, DT, mode) for mode in modes]


def speeds(targets: list[Target]) -> np.ndarray:
    return np.array([each.velocity for each in targets])


def left_of(calm: np.ndarray, wild: np.ndarray) -> None:
    """Assert that the calm course leaves at most the share of `WRONG` of the wild course's swing of a mode."""
    for factor, most in WRONG:
        around = [factor * FREQUENCY * share for share in (0.8, 0.9, 1.0, 1.1, 1.2)]  # the wild one may be lucky
        worst = max(swing(wild, each) for each in around)
        assert swing(calm, factor * FREQUENCY) <= most * worst, factor


@pytest.mark.parametrize("mode", [PAUSE, FOLLOW])
def test_a_pause_and_its_end_leave_no_swing(sharp: TimedPath, mode: GuideMode) -> None:
    found = []
    for path in (replace(sharp, period=period), sharp):
        state = GuideState(path_time=8.0, speed_factor=1.0 if mode is PAUSE else 0.0)
        steady = ridden(path, state, [FOLLOW if mode is PAUSE else HOLD] * 3)
        found.append(speeds(steady + ridden(path, state, [mode] * 400)))
    left_of(*found)
    np.testing.assert_allclose(found[0][-1], found[1][-1], atol=1e-12)
    late = (found[0].sum(axis=0) - found[1].sum(axis=0))[0] * DT
    assert abs(late) == pytest.approx(0.3 * 0.5 * REACH, rel=0.05)  # as far as it goes in half of the mean


def test_a_pause_that_is_taken_back_goes_on_without_a_jump(sharp: TimedPath) -> None:
    path, state = replace(sharp, period=period), GuideState(path_time=8.0, speed_factor=1.0)
    found = speeds(ridden(path, state, [FOLLOW] * 5 + [PAUSE] * 40 + [FOLLOW] * 400))
    assert np.abs(np.diff(found, axis=0)).max() <= 0.5 * DT * 1.01
    assert found[-1][0] == pytest.approx(0.3)


def test_a_stop_is_as_it_was_to_the_bit(sharp: TimedPath) -> None:
    """On the path from full speed, during the approach, and in the midst of a pause from the speed that it has."""
    calm = replace(sharp, period=period)
    states = [GuideState(path_time=8.0, speed_factor=1.0) for _ in range(2)]
    one, other = (
        ridden(path, state, [FOLLOW] * 3 + [HOLD] * 90) for path, state in zip((calm, sharp), states, strict=True)
    )
    np.testing.assert_array_equal(speeds(one), speeds(other))
    goal = sharp.track.at(sharp.distance(5.0)).position
    states = [GuideState(path_time=5.0, position=goal + np.array([0.0, 1.5, 0.3]), speed=0.25) for _ in range(2)]
    one, other = (ridden(path, state, [HOLD] * 90) for path, state in zip((calm, sharp), states, strict=True))
    np.testing.assert_array_equal(speeds(one), speeds(other))
    state = GuideState(path_time=8.0, speed_factor=1.0)
    ridden(calm, state, [PAUSE] * 45)
    assert 0.1 < state.speed_factor < 0.9
    same = GuideState(path_time=state.path_time, speed_factor=state.speed_factor)
    np.testing.assert_array_equal(speeds(ridden(calm, state, [HOLD] * 90)), speeds(ridden(sharp, same, [HOLD] * 90)))


@pytest.mark.parametrize("far", [1.5, 0.05, 1e-3])
def test_the_way_to_the_path_leaves_no_swing_and_arrives(sharp: TimedPath, far: float) -> None:
    goal = sharp.track.at(sharp.distance(5.0)).position
    found = []
    for path in (replace(sharp, period=period), sharp):
        state = GuideState(path_time=5.0, position=goal + np.array([0.0, far, 0.0]))
        targets = ridden(path, state, [APPROACH] * 1500)
        np.testing.assert_allclose(targets[-1].position, goal, atol=1e-9)
        assert targets[-1].arrived
        found.append(speeds(targets))
        assert np.linalg.norm(np.diff(found[-1], axis=0), axis=1).max() <= 0.5 * DT * 1.01
        assert found[-1][:, 1].max() <= 1e-12  # it never goes back
    worst = [max(swing(wild, factor * FREQUENCY) for factor in np.linspace(0.7, 1.3, 13)) for wild in found]
    assert worst[0] <= 0.3 * worst[1] + 1e-6


def test_a_tour_stops_at_its_places(sharp: TimedPath) -> None:
    places = np.array([[0.5, 0.1, 1.2], [0.3, 0.2, 1.1]])
    path, state = replace(sharp, tour=places, period=period), GuideState()
    state.position = sharp.track.at(0.0).position.copy()
    targets = ridden(path, state, [APPROACH] * 4000)
    for place in places:
        assert any(np.allclose(target.position, place, atol=1e-12) for target in targets)
    assert targets[-1].arrived


def jogged(settings: ManualSettings, orders: list[tuple[float, float, float]], last: float) -> np.ndarray:
    """Velocities of a jog with one order each 0.1 s, until *last*, s, and of the 4 s after it."""
    state, found = ManualState(), []
    for k in range(round((last + 4.0) / DT)):
        now = k * DT
        if now < last and k % 10 == 0:
            wish = orders[min(k // 10, len(orders) - 1)]
            order = Order(OrderKind.JOG, time=now, arguments={"velocity": wish})
            manual.begin(settings, state, order, now, (np.array([0.0, 0.0, 1.0]), np.zeros(3)) if k == 0 else None)
        found.append(manual.step(settings, state, now, DT).velocity)
    return np.array(found)


def test_a_jog_starts_without_a_swing(sharp: TimedPath) -> None:
    calm, wild = (jogged(each, [(0.2, 0.0, 0.0)], 2.5)[:240] for each in (replace(BY_HAND, period=period), BY_HAND))
    left_of(calm, wild)


def test_a_jog_that_is_let_go_stops_as_before_to_the_bit() -> None:
    calm, wild = (jogged(each, [(0.2, 0.0, 0.0)], 2.5) for each in (replace(BY_HAND, period=period), BY_HAND))
    released = round((2.4 + LEASE) / DT) - 2  # the lease of the last order
    np.testing.assert_array_equal(calm[released:], wild[released:])
    assert not calm[-1].any()


def test_a_jog_is_let_go_in_its_start() -> None:
    """From the speed that it has, by the deceleration of a released jog."""
    calm = jogged(replace(BY_HAND, period=period), [(0.2, 0.0, 0.0)], 0.3)[:, 0]
    top = int(calm.argmax())
    assert 0.02 < calm[top] < 0.15
    falls = -np.diff(calm[top:])
    np.testing.assert_allclose(falls[: int(calm[top] / 0.008)], 0.8 * DT, atol=1e-12)
    assert top * DT <= 0.2 + LEASE + 2 * DT


@pytest.mark.parametrize("turned", [(-0.2, 0.0, 0.0), (0.0, 0.2, 0.0), (0.05, 0.0, 0.0)])
def test_a_jog_that_turns_or_slows_down_does_so_as_before(turned: tuple[float, float, float]) -> None:
    orders = [(0.2, 0.0, 0.0)] * 25 + [turned]
    calm, wild = (jogged(each, orders, 6.0) for each in (replace(BY_HAND, period=period), BY_HAND))
    np.testing.assert_allclose(calm[249:262], wild[249:262], atol=1e-15)


def test_a_held_jog_stays_within_its_limits() -> None:
    velocities = jogged(replace(BY_HAND, period=period), [(0.14, -0.14, 0.14)], 18.0)
    places = np.array([0.0, 0.0, 1.0]) + DT * np.cumsum(velocities, axis=0)
    assert (np.abs(places - [0.0, 0.0, 1.0]) <= 1.0 + 1e-9).all()
    assert np.abs(places[-1] - [0.0, 0.0, 1.0]).max() == pytest.approx(1.0, abs=1e-3)
    assert np.linalg.norm(np.diff(velocities, axis=0), axis=1).max() <= 0.8 * DT * (1.0 + 1e-9)


@pytest.mark.parametrize("far", [0.8, 0.01])
def test_a_motion_to_a_place_leaves_no_swing_and_arrives(far: float) -> None:
    found = []
    for settings in (replace(BY_HAND, period=period), BY_HAND):
        state, velocities = ManualState(), []
        order = Order(OrderKind.GO_TO, arguments={"position": (far, 0.0, 1.0)})
        manual.begin(settings, state, order, 0.0, (np.array([0.0, 0.0, 1.0]), np.zeros(3)))
        for k in range(2000):
            motion = manual.step(settings, state, k * DT, DT)
            velocities.append(motion.velocity)
            if motion.done:
                break
        assert motion.done
        assert state.position == pytest.approx([far, 0.0, 1.0], abs=2e-6)
        found.append(np.array(velocities))
    worst = [max(swing(wild, factor * FREQUENCY) for factor in np.linspace(0.75, 1.25, 11)) for wild in found]
    assert worst[0] <= 0.3 * worst[1]


def test_where_one_step_is_longer_than_the_mean_there_is_none() -> None:
    mean = RampMean()
    assert mean.take(np.zeros(1), np.ones(1), lambda: 0.3, 1.0) == 1.0
    assert mean.asked(np.ones(1)) == 1.0
    assert mean.pending(np.ones(1), 1.0) == pytest.approx(0.0)


def test_a_place_is_gone_to_from_a_jog_at_the_limits_without_leaving_them() -> None:
    state, settings = ManualState(), replace(BY_HAND, period=period)
    velocity = {"velocity": (0.2, 0.0, 0.0)}
    begin = (np.array([0.4, 0.0, 1.0]), np.zeros(3))
    manual.begin(settings, state, Order(OrderKind.JOG, arguments=velocity), 0.0, begin)
    farthest = 0.0
    for k in range(1500):
        now = k * DT
        if state.position[0] < 0.9 and state.goal is None:
            manual.begin(settings, state, Order(OrderKind.JOG, time=now, arguments=velocity), now, None)
        elif state.goal is None:
            manual.begin(settings, state, Order(OrderKind.GO_TO, arguments={"position": (0.5, 0.0, 1.0)}), now, None)
        motion = manual.step(settings, state, now, DT)
        farthest = max(farthest, float(state.position[0]))
        if motion.done:
            break
    assert 0.9 < farthest <= 0.9 + 0.2**2 / (2 * 0.5) + 0.01
    assert state.position[0] == pytest.approx(0.5, abs=2e-6)
