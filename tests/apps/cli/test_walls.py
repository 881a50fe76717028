"""`walls`: what it prints and rejects, alone and with a survey's room."""

from __future__ import annotations

import json
import math
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from oracles.room import rectangle, scan

ROOT = Path(__file__).resolve().parents[3]
FILE = ROOT / "examples" / "scan.csv"
KEYS = {
    "status", "walls", "points", "used", "on_walls", "noise", "length_unit", "angle_unit", "notes", "place", "plot",
    "noise_per_metre", "kinds", "housing", "device",
}  # fmt: skip
WALL_KEYS = {
    "normal", "distance", "rms", "points", "angle", "ends", "length", "sigma_angle", "sigma_distance",
}  # fmt: skip


@pytest.fixture
def room(cli, tmp_path: Path) -> Path:
    file = tmp_path / "room.json"
    file.write_text(cli("survey", ROOT / "examples" / "survey.gsi", "--json").out)
    return file


def written(file: Path, angles: np.ndarray, ranges: np.ndarray) -> Path:
    lines = [f"{a:.6f},{r:.4f}" for a, r in zip(np.degrees(angles), ranges, strict=True)]
    file.write_text("angle (deg),distance (m)\n" + "\n".join(lines))
    return file


def test_json(cli) -> None:
    answer = cli("walls", FILE, "--json")
    assert answer.code == 0
    found = answer.json
    assert found.keys() == KEYS | {"schema"}
    assert found["status"] == "ok"
    assert len(found["notes"]) == 2
    assert answer.err.count("note: ") == 2
    for wall in found["walls"]:
        assert wall.keys() == WALL_KEYS
        assert math.hypot(*wall["normal"]) == pytest.approx(1.0)
        for end in wall["ends"]:
            assert np.dot(wall["normal"], end) == pytest.approx(wall["distance"], abs=1e-9)
    distances = sorted(wall["distance"] for wall in found["walls"] if wall["length"] > 1)
    assert distances == pytest.approx([2.1, 2.15, 3.0, 5.7], abs=2e-3)
    assert found["place"] is None
    assert found["housing"] == []
    assert found["device"] is None
    assert found["on_walls"] + sum(kind["points"] for kind in found["kinds"]) == found["used"]


def test_with_the_room_the_place_is_found(cli, room: Path) -> None:
    found = cli("walls", FILE, "--room", room, "--json").json["place"]
    # the survey's origin is below its instrument, at 0.1, -0.2 of the room
    assert found["status"] == "ok"
    assert found["position"] == pytest.approx([0.3, -0.4], abs=4e-3)
    assert math.degrees(found["yaw"]) == pytest.approx(12.0, abs=0.1)
    assert found["walls"] == ["east", "north", "west"]
    sigma = np.sqrt(np.diag(found["covariance"]))
    assert (sigma[:2] < 3e-3).all()
    assert found["candidates"][0]["explained"] > 0.7
    lasers = cli("walls", FILE, "--room", room, "--laser", "north=5.7,west=3.0", "--json")
    assert lasers.json["place"]["candidates"][0]["laser_misfit"] < 3
    doubt = cli("walls", FILE, "--room", room, "--laser", "north=1")
    assert doubt.code == 1
    assert "no position agrees with the laser" in doubt.no


def test_nothing_and_one_direction(cli, tmp_path: Path, room: Path) -> None:
    angles = np.linspace(0, math.tau, 300, endpoint=False)
    round_ = written(tmp_path / "round.csv", angles, np.full(300, 2.0))
    answer = cli("walls", round_, "--json")
    assert answer.code == 1
    assert (answer.json["status"], answer.json["walls"]) == ("no-wall", [])
    assert "no wall is in sight" in answer.no
    assert "no wall is in sight" in cli("walls", round_, "--room", room).no
    nothing = written(tmp_path / "nothing.csv", angles, np.zeros(300))
    assert "no point within limits" in cli("walls", nothing).no
    a, r = scan(rectangle(), (0.3, 0.0, 0.0), np.random.default_rng(1))
    r[np.sin(a) > 0.3] = 0.0
    corridor = written(tmp_path / "corridor.csv", a, r)
    answer = cli("walls", corridor, "--json")
    assert (answer.code, answer.json["status"]) == (0, "parallel")
    assert "nearly parallel" in answer.err
    answer = cli("walls", corridor, "--room", room, "--json")
    assert (answer.code, answer.json["place"]["status"]) == (1, "parallel")
    assert answer.json["place"]["position"] == [None, None]


def test_options(cli, tmp_path: Path) -> None:
    masked = cli("walls", FILE, "--mask", "150,190", "--json").json
    assert masked["used"] < cli("walls", FILE, "--json").json["used"]
    assert cli("walls", FILE, "--range", "0.15,3", "--json").json["used"] < masked["used"]
    assert cli("walls", FILE, "--noise", "0.005", "--json").json["noise"] == 0.005
    one, other = cli("walls", FILE, "--json").json["walls"], cli("walls", FILE, "--clockwise", "--json").json["walls"]
    assert other[0]["angle"] == pytest.approx(-one[0]["angle"])
    noisy = written(tmp_path / "noisy.csv", *scan(rectangle(), (0.3, 0.2, 0.1), np.random.default_rng(2), sigma=0.02))
    found = cli("walls", noisy, "--json").json
    assert found["noise"] == pytest.approx(0.02, rel=0.4)
    assert len([wall for wall in found["walls"] if wall["length"] > 3]) >= 3


def test_the_housing_is_left_out_and_can_be_kept(cli, tmp_path: Path) -> None:
    a, r = scan(rectangle(), (0.3, 0.2, 0.1), np.random.default_rng(3))
    own = (a > 1.0) & (a < 1.3)
    r[own] = 0.08 + np.random.default_rng(4).normal(0.0, 1e-3, own.sum())
    file = written(tmp_path / "housing.csv", a, r)
    answer = cli("walls", file, "--json")
    (part,) = answer.json["housing"]
    assert [part["begin"], part["end"]] == pytest.approx([1.0, 1.3], abs=0.02)
    assert part["distance"] == pytest.approx(0.08, abs=1e-3)
    assert part["points"] == own.sum()
    assert "left out as the device's own housing; --keep-housing uses them" in answer.err
    kept = cli("walls", file, "--keep-housing", "--json").json
    assert kept["housing"] == []
    assert kept["used"] == answer.json["used"] + own.sum()
    masked = cli("walls", file, "--mask", "55,76", "--json").json
    assert (masked["housing"], len(masked["walls"])) == ([], len(answer.json["walls"]))


def test_one_of_several_devices(cli, tmp_path: Path) -> None:
    a, r = scan(rectangle(), (0.3, 0.2, 0.1), np.random.default_rng(3))
    rows = [f"{k},{x:.6f},{y:.4f}" for k in ("front", "rear") for x, y in zip(a, r, strict=True)]
    file = tmp_path / "two.csv"
    file.write_text("topic,angle (rad),distance (m)\n" + "\n".join(rows))
    assert "scans of 2 devices: 'front', 'rear'; choose one with --device" in cli("walls", file).refusal
    assert "--device = 'left': must be one of 'front', 'rear'" in cli("walls", file, "--device", "left").refusal
    found = cli("walls", file, "--device", "rear", "--json").json
    assert (found["device"], found["points"]) == ("rear", 720)
    assert "the file names no device" in cli("walls", FILE, "--device", "rear").refusal


@pytest.mark.parametrize("count", [1, 50])
def test_points_at_one_bearing_are_no_wall(cli, tmp_path: Path, count: int) -> None:
    file = written(tmp_path / "one.csv", np.full(count, 0.3), np.linspace(1.0, 5.0, count))
    answer = cli("walls", file)
    assert answer.code == 1
    assert "are at one bearing" in answer.no
    endless = written(tmp_path / "endless.csv", np.linspace(0, 6, count), np.full(count, np.inf))
    assert "no point within limits" in cli("walls", endless).no


def test_the_page_shows_what_is_printed(cli, monkeypatch, tmp_path: Path) -> None:
    page = (ROOT / "docs" / "walls.md").read_text(encoding="utf-8")
    shown = re.findall(r"```text\n\$ (cablewright walls [^\n]*)\n(.*?)```", page, re.DOTALL)
    assert len(shown) == 2
    monkeypatch.chdir(ROOT)
    room = tmp_path / "room.json"
    room.write_text(cli("survey", "examples/survey.gsi", "--plan", "examples/survey.toml", "--json").out)
    for command, text in shown:
        arguments = [str(room) if part == "room.json" else part for part in shlex.split(command)[1:]]
        printed = iter(cli(*arguments).out.splitlines())
        assert all(line in printed for line in text.splitlines()), text  # in this order; the page may leave out lines


def test_picture(cli, tmp_path: Path) -> None:
    file = tmp_path / "walls.png"
    assert cli("walls", FILE, "--plot", file, "--json").json["plot"] == str(file)
    assert file.read_bytes().startswith(b"\x89PNG")
    empty = written(tmp_path / "empty.csv", np.zeros(3), np.zeros(3))
    assert cli("walls", empty, "--plot", file).code == 1


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["no-such.csv"], "no-such.csv: no such file"),
        ([FILE, "--unit", "inch"], "--unit = 'inch': must be one of m, mm"),
        ([FILE, "--range", "3,1"], "--range = '3,1': expected "),
        ([FILE, "--range", "nan,1"], "expected "),
        ([FILE, "--range", "-1,1"], "0 <= min_range < max_range"),
        ([FILE, "--yaw", "10"], "--yaw = '10': expected 2"),
        ([FILE, "--mask", "1,2,3"], "--mask = '1,2,3': expected pairs of bearings"),
        ([FILE, "--noise", "0"], "noise = 0: must be over 0"),
        ([FILE, "--noise", "nan"], "noise = nan: must be over 0"),
        ([FILE, "--laser", "north=1"], "--laser = 'north=1': give --room too"),
        ([FILE, "--room", FILE], "not JSON"),
        ([FILE, "--plot", "x.jpg"], "a name that ends in .png"),
        ([ROOT / "examples" / "survey.gsi"], "columns x,y or angle,distance are expected"),
    ],
)
def test_rejections(cli, arguments: list, says: str) -> None:
    assert says in cli("walls", *arguments).refusal


@pytest.mark.parametrize(
    "text", ["3", "{}", '{"walls": {"west": {"normal": [1]}}, "sigma": {"walls": {}}}', "[" * 9999]
)
def test_rooms_that_are_rejected(cli, tmp_path: Path, text: str) -> None:
    file = tmp_path / "room.json"
    file.write_text(text)
    assert "cablewright survey FILE --json" in cli("walls", FILE, "--room", file).refusal
    file.write_text(json.dumps({"walls": {}, "sigma": {"walls": {}}}))
    assert "room: 0 walls" in cli("walls", FILE, "--room", file).refusal


def test_lasers_that_are_rejected(cli, room: Path) -> None:
    for text, says in (("north", "WALL=DISTANCE"), ("north=x", "WALL=DISTANCE"), ("attic=1", "no wall 'attic'")):
        assert says in cli("walls", FILE, "--room", room, "--laser", text).refusal
