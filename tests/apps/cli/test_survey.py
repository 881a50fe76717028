"""`survey`: what it prints, writes and rejects."""

from __future__ import annotations

import re
import shlex
import tomllib
from pathlib import Path

import numpy as np
import pytest

from cablewright.robot import library_text, load

ROOT = Path(__file__).resolve().parents[3]
FILE = ROOT / "examples" / "survey.gsi"
PLAN = ROOT / "examples" / "survey.toml"
KEYS = {
    "exits", "axes", "walls", "residuals", "rms", "unit_weight", "frame", "status", "unchecked", "covariance", "notes",
    "robot",
    "plot",
}  # fmt: skip


def test_json(cli) -> None:
    answer = cli("survey", FILE, "--plan", PLAN, "--json")
    assert (answer.code, answer.err) == (0, "")
    found = answer.json
    assert found.keys() == KEYS | {"schema"}
    assert list(found["exits"]) == ["1", "2", "3", "4"]
    assert found["exits"]["1"]["exit_point"] == pytest.approx([-2.45, -5.0, 4.03], abs=6e-3)
    assert np.shape(found["covariance"]) == (24, 24)
    sigma = found["exits"]["1"]["exit_sigma"]
    assert np.sqrt(np.diag(found["covariance"]))[:3] == pytest.approx(sigma)
    assert all(3e-4 < value < 3e-3 for value in sigma)  # the paper's "accuracy of about 1 mm"
    assert found["walls"]["west"]["normal"] == pytest.approx([-1, 0, 0], abs=1e-15)
    assert found["walls"]["west"]["rms"] is None
    assert found["frame"]["along"] == "west"
    assert len(found["residuals"]) == 33
    assert 0.5 < found["unit_weight"] < 1.5


def test_the_robot_is_written_with_its_comments(cli, tmp_path: Path) -> None:
    out = tmp_path / "mine.toml"
    answer = cli("survey", FILE, "--plan", PLAN, "--robot", "merlet2023", "--out", out, "--json")
    assert answer.code == 0
    assert answer.json["robot"] == str(out)
    before, after = library_text("merlet2023").splitlines(), out.read_text().splitlines()
    changed = [(a, b) for a, b in zip(before, after, strict=True) if a != b]
    assert len(changed) == 8
    assert all(re.match(r"(exit_point|winch_exit) = ", b) for _, b in changed)
    robot = load(str(out))
    for line in robot.lines:
        wanted = answer.json["exits"][line.name]
        assert line.exit_point == pytest.approx(wanted["exit_point"], abs=6e-6)
        assert line.winch_exit[2] == pytest.approx(wanted["winch_exit"][2], abs=6e-6)


def test_an_own_robot_keeps_its_units(cli, tmp_path: Path) -> None:
    mine = tmp_path / "in.toml"
    text = library_text("merlet2023").replace(
        "exit_point = [-2.5, -5.0, 4.03]", 'exit_point = ["-2500 mm", "-5 m", "403 cm"]  # by hand'
    )
    mine.write_text(text)
    assert cli("survey", FILE, "--plan", PLAN, "--robot", mine, "--out", mine).code == 0
    first = tomllib.loads(mine.read_text())["lines"][0]["exit_point"]
    assert [value.split()[1] for value in first] == ["mm", "m", "cm"]
    assert "# by hand" in mine.read_text()


def test_another_frame_is_noticed(cli, tmp_path: Path) -> None:
    markers = tmp_path / "there.csv"
    markers.write_text("point,x,y,z\nX1,8,1,4\nW1,8,1,0.1\nX2,13,1,4\nWEST1,0,0,0\nWEST2,0,9,0\n")
    plan = tmp_path / "plan.toml"
    plan.write_text('schema = 1\n[instrument]\nstation = ["3 m", "4 m", "1.5 m"]\n')
    out = tmp_path / "out.toml"
    answer = cli("survey", markers, "--plan", plan, "--robot", "merlet2023", "--out", out)
    assert answer.code == 0
    assert "exit point of south-west moves by" in answer.err
    assert "not surveyed, so kept as they are: north-east, north-west" in answer.err


def test_the_page_shows_what_is_printed(cli, monkeypatch) -> None:
    page = (ROOT / "docs" / "survey.md").read_text(encoding="utf-8")
    shown = re.findall(r"```text\n\$ (cablewright survey [^\n]*)\n(.*?)```", page, re.DOTALL)
    assert shown
    monkeypatch.chdir(ROOT)
    for command, text in shown:
        printed = cli(*shlex.split(command)[1:]).out.splitlines()
        assert [line for line in text.splitlines() if line not in printed] == []


def test_picture(cli, tmp_path: Path) -> None:
    file = tmp_path / "survey.png"
    assert cli("survey", FILE, "--plot", file, "--json").json["plot"] == str(file)
    assert file.read_bytes().startswith(b"\x89PNG")
    # without a wall that checks anything, without exit points, without names that fonts have
    odd = tmp_path / "odd.csv"
    odd.write_text("point,x,y,z\nA,0,0,0\nB,0,9,0\nC,1,2,3\n")
    plan = tmp_path / "plan.toml"
    plan.write_text(
        'schema = 1\n[points]\nA = "wall \\u4e16$x"\nB = "wall \\u4e16$x"\nC = "floor"\n[frame]\nalong = "\\u4e16$x"\n'
    )
    assert cli("survey", odd, "--plan", plan, "--plot", file).code == 0


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["no-such.gsi"], "no-such.gsi: no such file"),
        ([FILE, "--out", "x.toml"], "--out = 'x.toml': give --robot too"),
        ([FILE, "--robot", "merlet"], "did you mean 'merlet2023'?"),
        ([FILE, "--plan", "no-such.toml"], "no-such.toml: no such file"),
        ([FILE, "--plot", "x.jpg"], "a name that ends in .png"),
        ([FILE, "--plan", FILE], "not TOML"),
        ([ROOT / "examples" / "tensile.csv"], "no column 'point'"),
        ([ROOT / "examples" / "scan.csv"], "no column 'point'"),
    ],
)
def test_rejections(cli, arguments: list, says: str) -> None:
    assert says in cli("survey", *arguments).refusal


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "missing key 'schema'"),
        ("schema = 2", "written for a newer cablewright"),
        ("schema = 1\n[instrumnt]", "did you mean 'instrument'?"),
        ('schema = 1\n[instrument]\nangle = "5 mm"', "instrument.angle = '5 mm': must be a finite angle"),
        ('schema = 1\n[points]\nX1 = "exit of 1"', "X1 = 'exit of 1'"),
        ("schema = 1\n[lines.1.exit]\noffset = [1, 2]", "lines"),
    ],
)
def test_plans_that_are_rejected(cli, tmp_path: Path, text: str, says: str) -> None:
    plan = tmp_path / "plan.toml"
    plan.write_text(text)
    if says.startswith("X1"):
        markers = tmp_path / "x.csv"
        markers.write_text("point,x,y,z\nX1,1,2,3\nWEST1,0,0,0\nWEST2,0,5,0\n")
        answer = cli("survey", markers, "--plan", plan, "--robot", "merlet2023")
        assert "unknown line (marker 'X1') 'of 1'" in answer.refusal
        return
    line = cli("survey", FILE, "--plan", plan).refusal
    assert says in line
    assert str(plan) in line
