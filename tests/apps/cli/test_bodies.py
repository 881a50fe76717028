"""Rigid platforms on the command line: poses of three or six numbers, free ones, loads, wrenches, retraction."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

pytestmark = pytest.mark.usefixtures("undrawn")

GRAB = ("inverse", "grab-four-lines", "--at")


def test_a_pose_comes_back(cli) -> None:
    held = cli("inverse", "cogiro", "--at", "0.5,-0.3,2,0.02,0.01,-0.05", "--json").json
    assert (held["status"], len(held["pose"]), len(held["lengths"])) == ("ok", 6, 8)
    lengths = ",".join(map(repr, held["lengths"]))
    back = cli("forward", "cogiro", "--lengths", lengths, "--json").json
    np.testing.assert_allclose(back["pose"], held["pose"], atol=1e-9)


def test_a_position_alone_is_unrotated(cli) -> None:
    short, long = (cli("inverse", "jung2020", "--at", at, "--json").json for at in ("0.1,0,0.9", "0.1,0,0.9,0,0,0"))
    assert short == long


def test_a_long_rotation_vector_is_shortened_and_said(cli, caplog) -> None:
    answer = cli("inverse", "cogiro", "--at", "0,0,2,0,0,6.3", "--json")
    assert answer.json["pose"][5] == pytest.approx(6.3 - 2 * math.pi)
    assert "6.3 rad exceeds pi" in caplog.text


def test_gravity_decides_what_is_free(cli) -> None:
    held = cli(*GRAB, "1.1,0.1,-0.2,free,free,0", "--json").json
    assert held["pose"][3] != 0.0
    assert held["pose"][:3] == [1.1, 0.1, -0.2]


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ((*GRAB, "1.1,0.1,-0.2,0,0,0"), "4 lines hold 4 of the 6 degrees of freedom; 6 are given"),
        ((*GRAB, "1.1,0.1,-0.2,free,free,free"), "3 are given"),
        (("inverse", "cogiro", "--at", "0,0,2,free,0,0"), "8 lines hold all 6 degrees of freedom: none can be free"),
        (("inverse", "cogiro", "--at", "0,0,2,0"), "6 numbers are expected"),
        (("inverse", "cogiro", "--at", "0,0,2", "--load", "full"), "unknown load 'full'"),
        (("inverse", "cogiro", "--at", "0,0,2", "--wrench", "1,2"), "--wrench = '1,2'"),
        (("inverse", "cogiro", "--at", "0,0,2", "--wrench", "free,0,0"), "--wrench = 'free,0,0'"),
        (("inverse", "cogiro", "--at", "0,0,2", "--wrench", "inf,0,0"), "3 finite numbers"),
        (("inverse", "paty2021", "--at", "0,0,2", "--wrench", "0,0,0,1,0,0"), "takes no moment"),
        (("inverse", "cogiro", "--at", "0,0,2", "--retraction", "1"), "has no retraction"),
        (("inverse", "jung2020", "--at", "0,0,1", "--retraction", "3"), "retracts from 1.2 to 2 m"),
    ],
)
def test_what_cannot_be_asked(cli, arguments: tuple[str, ...], told: str) -> None:
    answer = cli(*arguments, "--json")
    assert answer.code == 2
    assert answer.out == ""
    assert told in answer.refusal


def test_a_wrench_and_a_load_are_carried(cli) -> None:
    plain, pushed = (
        cli("inverse", "cogiro", "--at", "0,0,2", *more, "--json").json["tensions"]
        for more in ((), ("--wrench", "0,0,-500"))
    )
    assert (np.array(pushed) > np.array(plain)).all()


JOB = """schema = 1
name = "wall"
gcode = "wall.gcode"
scale = 10.0
origin = [0.0, 0.0, 0.0]
[sampling]
step = "50 mm"
"""
WALL = "G90\nG1 Z50 F6000\n" + "".join(
    f"G1 X{x} Y0 Z{z} E1\nG1 X{-x} Y0 Z{z} E2\n" for z, x in ((60, 10), (90, 12), (120, 10))
)


def job(folder: Path, schedule: str) -> Path:
    (folder / "wall.gcode").write_text(WALL)
    (folder / "wall.toml").write_text(JOB + schedule)
    return folder / "wall.toml"


HEIGHTS = """[[schedule]]
z = "0.5 m"
retraction = "2 m"
rotation = ["0 deg", "0 deg", "0 deg"]
[[schedule]]
z = "1.2 m"
retraction = "1.3 m"
rotation = ["0 deg", "0 deg", "1 deg"]
"""

ALONE = ("--no-interference", "--no-expected-error")


def test_a_job_under_a_schedule(cli, tmp_path: Path) -> None:
    out = tmp_path / "run"
    answer = cli("check", "jung2020", str(job(tmp_path, HEIGHTS)), *ALONE, "--out", str(out), "--json")
    assert answer.json["max_error_compensated"] < 1e-6
    assert answer.json["max_turn_compensated"] < 1e-6
    assert answer.json["max_turn_uncompensated"] > 1e-5
    page = (out / "report.html").read_text()
    assert "rigid body of 10 kg on 8 lines" in page
    assert "retraction 1.3 m" in page


@pytest.mark.parametrize(
    ("robot", "schedule", "told"),
    [
        ("paty2021", HEIGHTS, "retraction"),
        ("cogiro", HEIGHTS, "has no retraction"),
        ("paty2021", "[[schedule]]\nz = 0\nrotation = [0, 0, 0.1]\n", "is a point"),
        ("jung2020", '[[schedule]]\nz = 0\nretraction = "3 m"\n', "schedule at 0 m"),
        ("jung2020", "[[schedule]]\nz = 0\n", "sets nothing"),
        ("jung2020", "[[schedule]]\nz = 0\nrotation = [0, 0, 4.0]\n", "longer than pi"),
        ("jung2020", "[[schedule]]\nz = 1\nretraction = 2.0\n[[schedule]]\nz = 1\nretraction = 2.0\n", "must rise"),
    ],
)
def test_a_schedule_that_cannot_be(cli, tmp_path: Path, robot: str, schedule: str, told: str) -> None:
    answer = cli("check", robot, str(job(tmp_path, schedule)), "--out", str(tmp_path / "run"))
    assert answer.code == 2
    assert told in answer.refusal
    assert not (tmp_path / "run").exists()
