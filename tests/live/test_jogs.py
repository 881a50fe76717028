"""A jog that is let go stops within a stated distance, which is checked before it begins."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cablewright.control import manual
from cablewright.control.manual import LEASE, ManualSettings, ManualState
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Order, OrderKind
from cablewright.live.drives import actions
from virtual_drives import Bench, bench

BEGIN = (0.0, -0.5, 1.0)


class Hand:
    """Holds a button until what it watches says so, and ends all three seconds later."""

    def __init__(self, found: Bench, at: float) -> None:
        self.found, self.at, self.track = found, at, list[tuple[float, np.ndarray, float]]()
        self.let_go: int | None = None

    def held(self) -> bool:
        rig = self.found.rig
        self.track.append((rig.now, rig.plant.truth.position, float(rig.plant.rig.winches.lengths_out()[0])))
        if self.let_go is None and self.speed() > self.at:
            self.let_go = len(self.track)
        return self.let_go is None

    def speed(self) -> float:
        if len(self.track) < 12:
            return 0.0
        (then, there, out), (now, here, length) = self.track[-11], self.track[-1]
        return max(float(np.linalg.norm(here - there)), abs(length - out)) / (now - then)

    def ends(self) -> bool:
        return self.let_go is not None and self.found.rig.now > self.track[self.let_go - 1][0] + 3.0


def homed(folder: Path) -> Bench:
    found = bench(begin=BEGIN, jog_tension=500.0)
    place = found.rig.plant.truth.position
    assert actions.home(found.robot, found.twin.owner, folder / "m", place, lambda: found.port).status == "done"
    return found


def test_the_platform_stops_within_the_run_out_when_it_is_let_go(tmp_path: Path) -> None:
    found = homed(tmp_path)
    hand, pulls, step = Hand(found, 0.15), [0.0], found.rig.plant.step

    def watched(command):  # type: ignore[no-untyped-def]
        frame = step(command)
        pulls.append(float(found.rig.plant.truth.tensions.max()))
        return frame

    found.rig.plant.step = watched  # type: ignore[method-assign]
    answer = actions.jog_platform(
        found.robot, found.twin.owner, tmp_path / "m", (0.2, 0.0, 0.0), hand.held, hand.ends, lambda: found.port
    )
    assert answer.status == "done", answer.reason
    assert hand.let_go is not None
    at, end = hand.track[hand.let_go - 1][1], found.rig.plant.truth.position
    assert 0.005 < end[0] - at[0] < 0.05  # it was 0.29 m with the acceleration of a path
    assert max(np.linalg.norm(place - at) for _, place, _ in hand.track[hand.let_go :]) < 0.05
    assert max(pulls) < 600.0


def test_a_winch_stops_within_the_run_out_when_it_is_let_go(tmp_path: Path) -> None:
    found = homed(tmp_path)
    hand = Hand(found, 0.17)
    answer = actions.jog_winch(
        found.robot, found.twin.owner, tmp_path / "m", "south-west", 0.18, hand.held, hand.ends, lambda: found.port
    )
    assert answer.status == "done", answer.reason
    assert hand.let_go is not None
    gone = found.rig.plant.rig.winches.lengths_out()[0] - hand.track[hand.let_go - 1][2]
    assert 0.005 < gone < 0.05


def test_a_jog_that_would_run_on_too_far_is_rejected_before_anything_is_opened(tmp_path: Path) -> None:
    found = bench(begin=BEGIN, deceleration=0.2)
    arguments = (found.robot, found.twin.owner, tmp_path / "m")
    hand = Hand(found, 1.0)
    with pytest.raises(InputError, match=r"from 0\.25 m/s it runs on by 0\.2\d\d m .* at most 0\.1 m is allowed"):
        actions.jog_platform(*arguments, (0.25, 0.0, 0.0), hand.held, hand.ends, lambda: found.port)
    with pytest.raises(InputError, match=r"at most 0\.1 m is allowed \(drives\.jog_run_out\): go slower"):
        actions.jog_winch(*arguments, "south-west", 0.25, hand.held, hand.ends, lambda: found.port)
    assert found.rig.now == 0.0


@pytest.mark.parametrize("speed", [0.05, 0.2])
def test_who_is_gone_is_obeyed_for_the_lease_and_the_ramp_alone(speed: float) -> None:
    """No order to stand comes: by the sum of the speeds it goes on by no more than the checked distance."""
    plan = ManualSettings((-9.0,) * 3, (9.0,) * 3, 0.05, deceleration=1.0, max_run_out=0.1, delay=0.01)
    plan.require_run_out(speed)
    state, dt, gone = ManualState(), 0.01, 0.0
    order = Order(OrderKind.JOG, arguments={"velocity": (speed, 0.0, 0.0)})
    manual.begin(plan, state, order, 0.0, (np.zeros(3), np.zeros(3)))
    state.velocity[0] = speed
    for k in range(200):
        gone += dt * float(manual.step(plan, state, k * dt, dt).velocity[0])
    assert gone == pytest.approx(speed * LEASE + speed**2 / 2.0, abs=1.01 * speed * dt)
    assert not state.velocity.any()
    fast = Order(OrderKind.JOG, time=0.0, arguments={"velocity": (0.24, 0.0, 0.0)})
    slow = ManualSettings((-9.0,) * 3, (9.0,) * 3, 0.05, deceleration=0.05, max_run_out=0.1)
    assert "at most 0.1 m is allowed" in manual.refusal(slow, fast, 0.0)
