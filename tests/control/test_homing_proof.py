"""What homing says where the proof of the pose fails: what failed, and the next step."""

from __future__ import annotations

import numpy as np
import pytest

import cases
from cablewright.control.homing import Homing, HomingSettings
from cablewright.control.take_up import TakeUpSettings
from cablewright.foundation.errors import Status
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import load
from cablewright.solvers.continuation import Tracker, TrackerSettings
from cablewright.solvers.forward import solve_forward


def homing(model: Model) -> Homing:
    take_up = TakeUpSettings(model.robot.winch_names, 30.0, 650.0, 0.05)
    frame = np.full(3, -9.0), np.full(3, 9.0)
    return Homing(HomingSettings(model, take_up, lambda _: None, lambda *_: None, np.zeros(3), frame))


def slack(model: Model) -> Equilibrium:
    held = cases.poses(model, 1)[0]
    return solve_forward(model, held.lengths + 0.5 * np.eye(4)[0]).checked()


def test_a_slack_line_is_named_with_the_next_step() -> None:
    model = Model(load("merlet2023"), Fidelity(CableLaw.ELASTIC))
    found = slack(model)
    own, kept = homing(model), []
    own.settings = HomingSettings(
        model, own.settings.take_up, lambda _: None, lambda *each: kept.append(each), found.pose, own.settings.frame
    )
    said = own._certified(found.lengths, np.zeros(4, dtype=np.int64), found.pose)
    name = model.robot.lines[0].name
    assert said == (
        "the pose of the lengths is not proved to be the only one near: a massless line hangs slack and has no shape; "
        f"tension {name!r}, below the min tension, and home again"
    )
    assert not kept


@pytest.mark.parametrize("status", [Status.FOLD, Status.JUMPED])
def test_another_status_has_a_next_step_too(status: Status) -> None:
    model = Model(load("merlet2023"))
    held = cases.poses(model, 1)
    said = homing(model)._unproved(status, held)
    assert said.startswith("the pose of the lengths cannot be followed: ")
    assert status.value in said
    assert said.endswith("change the tensions, or measure another place, and home again")


def test_only_certified_tracking_has_memory_for_certificates() -> None:
    model = Model(load("merlet2023"))
    held = cases.poses(model, 1)[0]
    trackers = [Tracker(model, held.lengths, TrackerSettings(certify=asked), begin=held) for asked in (False, True)]
    for tracker in trackers:
        assert tracker.step(held.lengths + 1e-4) is Status.OK
    assert [tracker._pool is None for tracker in trackers] == [True, False]
    np.testing.assert_array_equal(trackers[0].pose, trackers[1].pose)
