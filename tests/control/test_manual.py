"""By hand the platform goes to the ordered goal, no faster than allowed, and stops when requests end."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from cablewright.control import manual
from cablewright.control.manual import LEASE, MAX_SPEED, ManualSettings, ManualState, TargetMotion
from cablewright.foundation.signals import Order, OrderKind
from cablewright.models.plane import directions, within
from cablewright.robot import Plane

LIMITS = ManualSettings((-1.0, -1.0, 0.0), (1.0, 1.0, 2.0), 0.5, park=(0.0, 0.0, 1.5))
DT = 0.01


def moved(order: Order, *, again: float = 0.0, seconds: float = 20.0) -> list[TargetMotion]:
    """All steps until it is done; a jog is ordered *again* and again for so many seconds."""
    state, steps = ManualState(), []
    manual.begin(LIMITS, state, order, 0.0, (np.array([0.0, 0.0, 1.0]), np.zeros(3)))
    for k in range(round(seconds / DT)):
        if k * DT < again:
            manual.begin(LIMITS, state, replace(order, time=k * DT), k * DT, None)
        steps.append(manual.step(LIMITS, state, k * DT, DT))
        if steps[-1].done:
            return steps
    raise AssertionError("it does not finish")


def changes(steps: list[TargetMotion]) -> np.ndarray:
    velocities = np.array([np.zeros(3), *(step.velocity for step in steps)])
    return np.linalg.norm(np.diff(velocities, axis=0), axis=1) / DT


@pytest.mark.parametrize("goal", [(0.5, -0.2, 1.4), (0.0, 0.0, 1.001), (-1.0, 1.0, 0.0)])
def test_it_arrives_at_rest_within_its_limits(goal: tuple[float, float, float]) -> None:
    steps = moved(Order(OrderKind.GO_TO, arguments={"position": goal}))
    speeds = np.array([np.linalg.norm(step.velocity) for step in steps])
    assert speeds.max() <= MAX_SPEED * (1.0 + 1e-12)
    assert speeds[-1] == 0.0
    assert changes(steps).max() <= 0.5 * (1.0 + 1e-9) + 1e-4  # and the last micrometre
    np.testing.assert_allclose(steps[-1].position, goal, atol=2e-6)
    far = math.dist(goal, (0.0, 0.0, 1.0))
    if far > MAX_SPEED**2 / 0.5:
        assert len(steps) * DT == pytest.approx(far / MAX_SPEED + MAX_SPEED / 0.5, abs=0.15)


@pytest.mark.parametrize(
    ("kind", "arguments"),
    [(OrderKind.GO_TO, {"position": (0.9, 0.0, 1.0)}), (OrderKind.JOG, {"velocity": (0.2, 0, 0)})],
)
def test_it_stops_before_the_lines_cannot_hold_a_rigid_platform(
    kind: OrderKind, arguments: dict[str, tuple[float, ...]]
) -> None:
    turned, asked = np.array([0.0, 0.1, 0.0]), []

    def holds(place: np.ndarray, rotation: np.ndarray) -> bool:
        asked.append(rotation)
        return bool(place[0] <= 0.4)

    limits, state, order = replace(LIMITS, holds=holds), ManualState(), Order(kind, arguments=arguments)
    manual.begin(limits, state, order, 0.0, (np.array([0.0, 0.0, 1.0]), turned))
    steps = []
    for k in range(1000):
        if kind is OrderKind.JOG:
            manual.begin(limits, state, replace(order, time=k * DT), k * DT, None)
        steps.append(manual.step(limits, state, k * DT, DT))
        if steps[-1].done:
            break
    assert steps[-1].failure == "no tensions hold the platform farther on"
    assert 0.35 < steps[-1].position[0] < 0.4
    assert changes(steps).max() <= 0.5 * (1.0 + 1e-9)
    assert all(np.array_equal(rotation, turned) for rotation in asked)
    back = replace(order, arguments={key: (-0.1, 0.0, 1.0 if key == "position" else 0.0) for key in arguments})
    manual.begin(limits, state, back, 20.0, None)
    assert manual.step(limits, state, 20.0, DT).failure == ""  # the way back is free


def test_a_jog_ends_without_repetition() -> None:
    order = Order(OrderKind.JOG, arguments={"velocity": (0.0, 0.2, 0.0)})
    steps = moved(order, again=1.0)
    assert steps[60].velocity == pytest.approx([0.0, 0.2, 0.0])
    assert len(steps) * DT == pytest.approx(1.0 + LEASE + 0.2 / 0.5, abs=0.03)
    alone = moved(order)
    assert len(alone) * DT == pytest.approx(LEASE + LEASE, abs=0.03)  # it never came to full speed
    assert changes(steps).max() <= 0.5 * (1.0 + 1e-9)


@pytest.mark.parametrize(
    ("order", "says"),
    [
        (Order(OrderKind.JOG, arguments={"velocity": (0.2, 0.2, 0.0)}), "at most 0.25"),
        (Order(OrderKind.JOG, arguments={"velocity": (0.2, math.nan, 0.0)}), "three finite numbers"),
        (Order(OrderKind.JOG), "three finite numbers"),
        (Order(OrderKind.GO_TO, arguments={"position": (0.0, 0.0)}), "three finite numbers"),
        (Order(OrderKind.GO_TO, arguments={"position": (0.0, 1.5, 1.0)}), "y = 1.5 m is outside -1 to 1 m"),
        (Order(OrderKind.PARK), ""),
    ],
)
def test_what_cannot_be_obeyed_is_rejected(order: Order, says: str) -> None:
    assert says in manual.refusal(LIMITS, order, 0.0)
    assert bool(manual.refusal(LIMITS, order, 0.0)) == bool(says)


def test_without_a_parking_place_parking_is_rejected() -> None:
    assert "no parking position" in manual.refusal(
        ManualSettings((0.0,) * 3, (1.0,) * 3, 0.5), Order(OrderKind.PARK), 0.0
    )


def test_an_order_that_is_old_moves_nothing() -> None:
    order = Order(OrderKind.JOG, time=1.0, arguments={"velocity": (0.0, 0.1, 0.0)})
    assert manual.refusal(LIMITS, order, 1.1) == ""
    assert "over 0.2 s ago" in manual.refusal(LIMITS, order, 1.3)


@pytest.mark.parametrize("velocity", [(0.0, 0.2, 0.0), (-0.14, 0.14, 0.14), (0.0, 0.0, -0.25)])
def test_a_jog_that_is_held_stops_at_the_limits(velocity: tuple[float, float, float]) -> None:
    order = Order(OrderKind.JOG, arguments={"velocity": velocity})
    steps = moved(order, again=19.0)
    places = np.array([step.position for step in steps])
    assert (places <= np.array(LIMITS.max_position) + 1e-9).all()
    assert (places >= np.array(LIMITS.min_position) - 1e-9).all()
    far = np.abs(places[-1] - [0.0, 0.0, 1.0]).max()
    assert far == pytest.approx(1.0, abs=1e-3)
    assert changes(steps).max() <= 0.5 * (1.0 + 1e-9)


def test_from_outside_it_moves_only_inwards() -> None:
    state = ManualState()
    outside = np.array([0.0, 1.2, 1.0])
    for way, goes in ((0.1, False), (-0.1, True)):
        manual.begin(
            LIMITS, state, Order(OrderKind.JOG, arguments={"velocity": (0.0, way, 0.0)}), 0.0, (outside, np.zeros(3))
        )
        assert manual.step(LIMITS, state, 0.1, DT).velocity.any() == goes


def test_motions_stay_in_a_tilted_plane() -> None:
    plane = Plane(normal=(0.2, 1.0, 0.3), distance=0.02)
    settings = replace(LIMITS, plane=plane)
    begin = within(plane, np.array([0.0, 0.0, 1.0]))
    along = directions(plane, 3)[:, 0] * 0.2

    def refused(kind: OrderKind, **arguments: tuple[float, ...]) -> str:
        return manual.refusal(settings, Order(kind, arguments=arguments), 0.0)

    assert refused(OrderKind.JOG, velocity=tuple(along)) == ""
    assert "leaves the plane with normal 0.1881, 0.9407, 0.2822 at 0.02 m by 0.188 m/s" in refused(
        OrderKind.JOG, velocity=(0.0, 0.2, 0.0)
    )
    goal = within(plane, np.array([0.4, 0.0, 0.8]))
    assert refused(OrderKind.GO_TO, position=tuple(goal)) == ""
    off = refused(OrderKind.GO_TO, position=tuple(goal + 3e-3 * np.array(plane.across)))
    nearest = ", ".join(f"{x:.6f}" for x in goal)
    assert "position is 3 mm off the plane" in off
    assert f"nearest in it: {nearest} m" in off
    for order, again in (
        (Order(OrderKind.JOG, arguments={"velocity": tuple(along)}), 12.0),  # until the frame ends it
        (Order(OrderKind.GO_TO, arguments={"position": tuple(goal)}), 0.0),
    ):
        state, steps = ManualState(), []
        manual.begin(settings, state, order, 0.0, (begin, np.zeros(3)))
        while not (steps and steps[-1].done):
            now = len(steps) * DT
            if now < again:
                manual.begin(settings, state, replace(order, time=now), now, None)
            steps.append(manual.step(settings, state, now, DT))
        assert max(abs(plane.height(step.position)) for step in steps) < 1e-9
        assert (steps[-1].position <= 1.0 + 1e-9)[[0, 1]].all()
    np.testing.assert_allclose(steps[-1].position, goal, atol=2e-6)


def test_a_platform_that_lags_its_target_settles_at_the_place_it_was_sent_to() -> None:
    order, state, off, steps = Order(OrderKind.GO_TO, arguments={"position": (0.1, 0.0, 1.0)}), ManualState(), 1e-3, []
    manual.begin(LIMITS, state, order, 0.0, (np.array([0.0, 0.0, 1.0]), np.zeros(3)))
    while not (steps and steps[-1].done):
        steps.append(manual.step(LIMITS, state, len(steps) * DT, DT, off))
        off *= 0.99 if not steps[-1].velocity.any() else 1.0
    assert off == pytest.approx(1e-4, rel=0.02)
    assert steps[-1].failure == ""
    now, back = 20.0, replace(order, arguments={"position": (0.0, 0.0, 1.0)})
    manual.begin(LIMITS, state, back, now, (np.array([0.1, 0.0, 1.0]), np.zeros(3)))
    while not (found := manual.step(LIMITS, state, now, DT, 4.2e-4)).done:
        now += DT
    assert found.failure == "the platform stands 0.42 mm off its goal: it has not come nearer in 10 s"


def test_a_goal_ordered_again_is_waited_for_again() -> None:
    settings, state, now = ManualSettings((-1.0, -1.0, 0.0), (1.0, 1.0, 2.0), 0.5, 0.2), ManualState(), 0.0
    place, order = np.array([0.1, 0.0, 1.0]), Order(OrderKind.GO_TO, "anna", 0.0, {"position": (0.1, 0.0, 1.0)})
    waited = []
    for _ in range(2):
        manual.begin(settings, state, order, now, (place, np.zeros(3)))
        begin, motion = now, manual.step(settings, state, now, 0.02, off=0.01)
        while not motion.done:
            now += 0.02
            motion = manual.step(settings, state, now, 0.02, off=0.01)
        assert "off its goal" in motion.failure
        waited.append(now - begin)
        now += 1.0
    assert waited[1] == pytest.approx(waited[0], abs=0.03)
