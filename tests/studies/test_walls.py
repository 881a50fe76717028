"""`walls`: a wall known by hand, a room as survey, file and map, options that are rejected."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

import cablewright as cw

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
FILE = EXAMPLES / "scan.csv"


def test_one_wall_by_hand() -> None:
    angles = 0.01 * np.arange(-60, 60)
    found = cw.walls(cw.FileScan(angles, 2.0 / np.cos(angles), "m", "rad", ()), noise=1e-3)
    assert [len(found), found.status, found.ok] == [1, "parallel", True]
    assert found[0].distance == pytest.approx(2.0, abs=1e-9)
    assert found[0].angle == pytest.approx(0.0, abs=1e-9)


def test_a_file_and_its_parsed_scan_have_the_same_result() -> None:
    found = cw.walls(FILE)
    told = found.to_dict()
    assert told == cw.walls(cw.read_scan(str(FILE))).to_dict()
    assert json.loads(json.dumps(told, allow_nan=False)) == told
    assert len(repr(found)) < 160
    assert found.plot().axes


def test_a_room_is_a_survey_or_its_file(tmp_path: Path) -> None:
    survey = cw.survey(EXAMPLES / "survey.gsi")
    (tmp_path / "room.json").write_text(json.dumps(survey.to_dict()))
    one, other = (cw.walls(FILE, room=room).place for room in (survey, tmp_path / "room.json"))
    assert one is not None
    assert other is not None
    assert one.to_dict() == other.to_dict()
    assert one.walls == ["east", "north", "west"]
    assert math.degrees(one.pose.yaw) == pytest.approx(12.0, abs=0.1)


def test_an_empty_scan_has_no_wall() -> None:
    found = cw.walls(cw.FileScan(np.zeros(0), np.zeros(0), "m", "rad", ()))
    assert [len(found), found.status, found.ok] == [0, "no-wall", False]
    assert "no point within limits" in found.refusal


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"noise": 0.0}, "noise = 0"),
        ({"limits": (3.0, 1.0)}, "0 <= min_range < max_range"),
        ({"lasers": (cw.Laser("north", 1.0),)}, "lasers = north: give the room too"),
    ],
)
def test_wrong_options(options: dict, says: str) -> None:
    with pytest.raises(cw.InputError, match=says):
        cw.walls(FILE, **options)
