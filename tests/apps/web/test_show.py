"""`show`: pages of robots, jobs, runs and logs, whole or not."""

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from cablewright.apps.web.detail_levels import unpacked
from cablewright.apps.web.log_scene import log_scene
from cablewright.apps.web.png import _shaded
from cablewright.foundation.signals import Estimate, SensorFrame
from cablewright.machine.files import load_machine
from cablewright.machine.log.head import LogHead
from cablewright.machine.log.log import LogWriter, read_log
from cablewright.robot import load

ROOT = Path(__file__).parents[3]
LOOP = ROOT / "examples" / "merlet2023-loop.mcap"


def scene_of(page: Path) -> dict:
    return json.loads(re.search(r'id="scene">(.*?)</script>', page.read_text("utf-8"), re.DOTALL)[1])


def test_a_robot_alone(cli, tmp_path):
    page, png = tmp_path / "robot.html", tmp_path / "robot.png"
    answer = cli("show", "house-printer", "--out", page, "--png", png, "--json")
    assert answer.code == 0
    assert answer.json["states"] == 225
    frames = scene_of(page)["frames"]
    x, y, z = frames["lattice"]
    assert unpacked(frames["poses"]).tolist() == [pytest.approx([a, b, c]) for c in z for b in y for a in x]
    assert frames["notes"][frames["shown"]].startswith("At rest: an equilibrium within the limits")
    assert answer.json["size"] == page.stat().st_size < 2_000_000
    assert png.read_bytes().startswith(b"\x89PNG")
    assert scene_of(page)["title"] == "house-printer"


def test_a_pose_of_ones_own(cli, tmp_path):
    page = tmp_path / "robot.html"
    cli("show", "house-printer", "--at", "1,2,3", "--out", page)
    assert unpacked(scene_of(page)["frames"]["poses"]).tolist() == [[1.0, 2.0, 3.0]]


def test_a_pose_that_cannot_be_held_is_shown_and_said(cli, tmp_path):
    page = tmp_path / "robot.html"
    answer = cli("show", "house-printer", "--at", "0,0,14.99", "--out", page, "--json")
    assert answer.code == 0
    assert "Not in equilibrium" in answer.json["note"]
    assert "Not in equilibrium" in page.read_text("utf-8")


@pytest.mark.usefixtures("undrawn_here")
def test_the_folder_of_a_check(cli, tmp_path):
    run, page = tmp_path / "run", tmp_path / "run.html"
    cli(
        "check",
        "house-printer",
        ROOT / "examples" / "helix.toml",
        "--no-interference",
        "--no-expected-error",
        "--out",
        run,
    )
    answer = cli("show", "house-printer", run, "--out", page, "--json")
    assert answer.json["points"] > 1000
    scene = scene_of(page)
    assert scene["path"]["quantities"][0]["key"] == "error"
    assert scene["worst"]["label"].startswith("largest error")
    assert "belongs to another robot than wang2021" in cli("show", "wang2021", run, "--out", page).refusal
    table = run / "samples.parquet"
    table.write_bytes(table.read_bytes()[:1000])
    assert "cannot be read as Parquet" in cli("show", "house-printer", run, "--out", page).refusal


def test_a_log(cli, tmp_path):
    page = tmp_path / "log.html"
    answer = cli("show", "merlet2023", LOOP, "--out", page, "--json")
    scene = scene_of(page)
    assert answer.json["states"] == len(unpacked(scene["frames"]["times"]))
    assert "need not be in equilibrium" in answer.json["note"]
    with read_log(LOOP) as log:
        first = next(iter(log.entries()))
    assert np.allclose(unpacked(scene["frames"]["tensions"])[0], first.truth.tensions, rtol=1e-6)
    assert np.allclose(unpacked(scene["frames"]["poses"])[0][:3], first.truth.position, rtol=1e-6)
    assert {wall["name"] for wall in scene["walls"]} == {wall.name for wall in log.head.settings.room.walls}


def test_half_a_log_is_shown_as_far_as_it_goes(tmp_path):
    half = tmp_path / "half.mcap"
    data = LOOP.read_bytes()
    half.write_bytes(data[: int(0.9 * len(data))])
    whole = log_scene(LOOP)
    found = log_scene(half)
    assert 0 < len(found.path.positions) <= len(whole.path.positions)
    assert any("ut or damaged" in note for note in found.notes)


def test_a_log_without_the_truth_shows_the_estimate(tmp_path):
    path = tmp_path / "real.mcap"
    with read_log(LOOP) as log:
        entries = list(log.entries())
    head = LogHead(load("merlet2023"), load_machine("merlet2023"), 0.1, kind="real")
    with path.open("wb") as file, LogWriter(file, head) as log:
        for entry in entries:
            estimate = None if entry.truth is None else _as_estimate(entry.truth)
            log.write(SensorFrame(entry.frame.time), estimate=estimate)
    found = log_scene(path)
    assert "no truth" in found.notes[0]
    assert found.states.estimates is None
    assert np.isnan(found.states.tensions).all()
    json.loads(found.as_json())


def _as_estimate(truth):
    lines = truth.lengths
    return Estimate(truth.time, truth.position, truth.velocity, truth.rotation, lines, lines, lines > 0, lines)


def test_a_run_that_is_still_being_written(tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()
    data = LOOP.read_bytes()
    (folder / "log-000.mcap").write_bytes(data[: int(0.95 * len(data))])
    assert len(log_scene(folder).states) > 0


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("merlet2023", LOOP, "--at", "0,0,1"), "leave them out"),
        (("house-printer", LOOP), "is of robot 'merlet2023', not of 'house-printer'"),
        (("house-printer", "nowhere.gcode"), "nowhere.gcode"),
        (("house-printer", "--out", "robot.txt"), "--out"),
        (("house-printer", "--png", "robot.jpg"), "--png"),
        (("jung2021",), "jung2020"),
    ],
)
def test_bad_input_is_one_line(cli, tmp_path, monkeypatch, words, says):
    monkeypatch.chdir(tmp_path)
    assert says in cli("show", *words).refusal


def test_a_page_that_cannot_be_written_is_the_environments_fault(cli, tmp_path):
    assert cli("show", "wang2021", "--out", tmp_path / "no" / "where.html").code == 3


def test_reports_of_commands_with_a_picture(cli, tmp_path):
    page = tmp_path / "workspace.html"
    answer = cli("workspace", "jung2020", "--tolerance", "0.05", "--report", page, "--json")
    assert answer.json["report"] == str(page)
    assert scene_of(page)["meshes"][0]["name"] == "workspace"
    shutil.rmtree(tmp_path)


def test_a_long_piece_is_drawn_in_the_colours_of_its_values():
    pieces, values = np.array([[[0.0, 0, 0], [1.0, 0, 0]]]), np.array([[2.0, 4.0]])
    cut, found = _shaded(pieces, values, 0.25)
    assert cut[:, 0, 0].tolist() == [0.0, 0.25, 0.5, 0.75]
    assert cut[:, 1, 0].tolist() == [0.25, 0.5, 0.75, 1.0]
    assert found.tolist() == [2.25, 2.75, 3.25, 3.75]
