"""The target goes along the path by its law, slows down and goes on at the same place."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from cablewright.control import path_follower
from cablewright.control.path_follower import GuideMode, GuideState, TimedPath
from cablewright.foundation.errors import InputError
from cablewright.printing.job import Job, Motion
from cablewright.printing.numeric_path import Helix

DT = 0.01
MOTION = Motion(print_speed=0.03, travel_speed=0.05, acceleration=0.02)
JOB = Job(name="h", helix=Helix(radius=0.4, layers=2, layer_height=0.001, first_height=1.0), motion=MOTION)


@pytest.fixture(scope="module")
def path() -> TimedPath:
    return TimedPath.of(JOB)


def test_it_is_where_the_law_has_it(path: TimedPath) -> None:
    """At each sample the distance is that of the path, between them speed is that of the law."""
    for i in (0, 1, 5, len(path.arrival) // 2, len(path.arrival) - 1):
        assert path.distance(float(path.arrival[i])) == pytest.approx(path.track.distance[i], abs=1e-9)
    times = np.linspace(5.0, path.duration - 5.0, 500)
    speeds = [(path.distance(t + 1e-4) - path.distance(t - 1e-4)) / 2e-4 for t in times]
    np.testing.assert_allclose(speeds, 0.03, rtol=1e-3)


def follow(path: TimedPath, state: GuideState, modes: list[GuideMode]) -> list[path_follower.Target]:
    return [path_follower.step(path, state, DT, mode) for mode in modes]


def test_steps_join_and_velocity_is_that_of_the_step(path: TimedPath) -> None:
    state = GuideState()
    targets = follow(path, state, [GuideMode.FOLLOW] * 1500)
    for one, other in pairwise(targets):
        np.testing.assert_allclose(one.position + DT * one.velocity, other.position, atol=1e-12)
    assert targets[-1].path_speed == pytest.approx(0.03, rel=1e-3)
    assert np.linalg.norm(targets[-1].velocity) == pytest.approx(0.03, rel=1e-3)


def test_it_slows_down_along_the_path_and_goes_on_where_it_stood(path: TimedPath) -> None:
    state = GuideState()
    targets = follow(path, state, [GuideMode.FOLLOW] * 1000 + [GuideMode.HOLD] * 500)
    speeds = np.array([target.path_speed for target in targets])
    assert np.abs(np.diff(speeds)).max() <= 0.02 * DT * 1.1
    assert targets[-1].arrived
    assert targets[-1].path_speed == 0.0
    stood = targets[-1].distance
    assert stood - targets[999].distance == pytest.approx(0.03**2 / (2 * 0.02), rel=0.05)
    again = follow(path, state, [GuideMode.FOLLOW] * 3)
    assert again[0].distance == pytest.approx(stood)


def test_off_the_path_it_comes_back_straight_and_in_bounds(path: TimedPath) -> None:
    state = GuideState(path_time=20.0)
    goal = path.track.at(path.distance(20.0)).position
    state.position = goal + np.array([0.1, 0.2, -0.05])
    targets = follow(path, state, [GuideMode.APPROACH] * 1500)
    places = np.array([target.position for target in targets])
    way = (places - places[0]) @ (goal - places[0]) / np.linalg.norm(goal - places[0])
    assert np.abs(np.cross(places - places[0], goal - places[0])).max() < 1e-12
    speeds = np.diff(way) / DT
    assert speeds.max() <= 0.05 + 1e-9
    assert np.abs(np.diff(speeds)).max() <= 0.02 * DT * 1.1
    assert targets[-1].arrived
    np.testing.assert_allclose(targets[-1].position, goal, atol=1e-9)
    assert not any(target.extruding and target.path_speed > 0.0 for target in targets)


def test_a_lift_is_added_to_the_height_alone(path: TimedPath) -> None:
    flat = path_follower.step(path, GuideState(path_time=10.0), DT, GuideMode.HOLD)
    lifted = path_follower.step(path, GuideState(path_time=10.0, height_offset=0.07), DT, GuideMode.HOLD)
    np.testing.assert_allclose(lifted.position - flat.position, [0.0, 0.0, 0.07], atol=1e-12)


def test_it_ends(path: TimedPath) -> None:
    state = GuideState(path_time=path.duration - 0.5, speed_factor=1.0)
    targets = follow(path, state, [GuideMode.FOLLOW] * 100)
    assert targets[-1].finished
    assert not targets[0].finished
    assert targets[-1].distance == pytest.approx(path.track.length)


def test_the_first_layers_alone() -> None:
    whole, one = TimedPath.of(JOB), TimedPath.of(JOB, 1)
    assert one.track.length == pytest.approx(0.5 * whole.track.length, rel=1e-6)
    assert set(one.track.layer) == {1}


@pytest.mark.parametrize("layers", [0, -1, 3])
def test_layers_that_are_not_there_are_rejected(layers: int) -> None:
    with pytest.raises(InputError, match=rf"layers = {layers}: must be 1 to 2"):
        TimedPath.of(JOB, layers)


def test_before_the_path_begins_it_goes_through_the_places_of_the_tour_once(path: TimedPath) -> None:
    places = np.array([[0.5, 0.1, 1.2], [0.3, 0.2, 1.1]])
    touring, state = replace(path, tour=places), GuideState()
    begin = path.track.at(0.0).position
    state.position = begin.copy()
    targets = follow(touring, state, [GuideMode.APPROACH] * 2600)
    for place in places:
        reached = [k for k, target in enumerate(targets) if np.allclose(target.position, place, atol=1e-12)]
        assert reached
        assert not any(target.arrived for target in targets[: reached[-1]])
    assert targets[-1].arrived
    np.testing.assert_allclose(targets[-1].position, begin)
    for one, other in pairwise(targets):
        np.testing.assert_allclose(one.position + DT * one.velocity, other.position, atol=1e-12)
    state.position = begin + np.array([0.0, 0.0, 0.1])  # of one that left the path again: straight back to it
    again = follow(touring, state, [GuideMode.APPROACH] * 1000)
    assert np.abs(np.array([target.position for target in again])[:, :2] - begin[:2]).max() < 1e-9


def test_a_stop_in_the_tour_goes_on_with_the_same_place(path: TimedPath) -> None:
    place = np.array([[0.5, 0.1, 1.2]])
    touring, state = replace(path, tour=place), GuideState()
    state.position = path.track.at(0.0).position.copy()
    follow(touring, state, [GuideMode.APPROACH] * 200 + [GuideMode.HOLD] * 400)
    assert state.toured == 0
    targets = follow(touring, state, [GuideMode.APPROACH] * 1000)
    assert any(np.allclose(target.position, place[0]) for target in targets)
    assert state.toured == 1
