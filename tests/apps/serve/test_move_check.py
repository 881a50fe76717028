"""Whether a way by hand can be held, before it is ordered; and which addresses of a camera are taken."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cablewright.apps.serve.access import POLICY, policy_with
from cablewright.apps.serve.launch import Address
from cablewright.apps.serve.move_check import reach
from cablewright.foundation.errors import InputError
from cablewright.live.rest_pose import rest_pose
from cablewright.models.statics import Model
from cablewright.robot import load


@pytest.mark.parametrize("name", ["house-printer", "cogiro", "grab-four-lines"])
def test_a_short_way_holds_and_one_out_of_the_frame_does_not(name: str) -> None:
    robot = load(name)
    begin = np.array(rest_pose(robot).equilibrium.pose)
    here = Model.of(robot).nozzle(begin) if robot.n > 3 else begin
    goal = here + np.array([0.0, 0.0, 0.02])
    found = reach(robot, begin, goal, here - 1.0, here + 1.0)
    assert found["holds"], found
    assert found["length"] == pytest.approx(0.02)
    assert found["margin"] >= 0.0
    assert "outside" in reach(robot, begin, here + np.array([0.0, 0.0, 1.1]), here - 1.0, here + 1.0)["why"]


def test_where_no_tensions_hold_it_says_from_where_on() -> None:
    robot = load("house-printer")
    begin, low, high = np.array([0.0, 0.0, 6.0]), np.array(robot.scene.frame_min), np.array(robot.scene.frame_max)
    found = reach(robot, begin, np.array([0.0, 0.0, high[2]]), low, high)
    assert not found["holds"]
    assert found["why"].startswith("from ")
    assert found["why"].endswith("m on, no tensions within the limits hold the platform")


@pytest.mark.parametrize("camera", ["http://192.168.1.7:8080/?action=stream", "https://cam.local/snapshot.jpg"])
def test_a_plain_address_of_a_camera_is_taken_and_no_other_picture_is_loaded(camera: str) -> None:
    assert Address(camera=camera).camera == camera
    policy = policy_with(camera).decode()
    assert f"img-src 'self' {camera.split('/')[0]}//{camera.split('/')[2]} data:;" in policy
    assert policy.replace(f" {camera.split('/')[0]}//{camera.split('/')[2]}", "").encode() == POLICY


@pytest.mark.parametrize(
    "camera",
    [
        "http://name:secret@cam/x", "ftp://cam/x", "javascript:alert(1)", "http://cam/x; script-src *", "http://cam/'x'",
        "http://cam:99999999/x", "http:///x", "cam/x", "http://cam/x#y", "http://cam/" + "x" * 400, "http://c\u00e4m/x",
        "http://[::1]:80/x",
    ],
)  # fmt: skip
def test_an_address_that_says_more_is_rejected(camera: str) -> None:
    with pytest.raises(InputError, match="--camera"):
        Address(camera=camera)


def test_a_page_with_tls_takes_no_picture_without(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Address, "_require_certificate", lambda _self: None)
    with pytest.raises(InputError, match="give its https address"):
        Address(certificate=tmp_path / "c", certificate_key=tmp_path / "k", camera="http://cam/x")
