"""`modulus` and `creep`: what they print, write and reject."""

from __future__ import annotations

import math
import re
import shlex
from pathlib import Path

import pytest

import cablewright as cw
from cablewright.robot import library_text

ROOT = Path(__file__).resolve().parents[3]
TEST = ROOT / "examples" / "tensile.csv"
LENGTH = ("--initial-length", "2 m")
SECTION = ("--section", "12.566370614359172 mm^2")
LOAD = ("--breaking-load", "10.29 kN")
GIVEN = (*LENGTH, *SECTION, *LOAD)
KEYS = {
    "modulus", "loading", "unloading", "branch_factors", "tangent_factors", "hysteresis", "cycles", "section",
    "breaking_load", "initial_length", "axial_stiffness", "modulus_range", "permanent_set", "r_squared", "length",
    "stretch", "band", "notes", "partial", "plot", "status", "robot_file", "against_paper",
}  # fmt: skip


def test_json(cli) -> None:
    answer = cli("modulus", TEST, *GIVEN, "--json")
    assert answer.code == 0
    assert answer.err == ""
    found = answer.json
    assert found.keys() == KEYS | {"schema"}
    assert found["modulus"] == found["loading"][-1] == pytest.approx(102.2e9, rel=0.01)
    assert found["axial_stiffness"] == pytest.approx(found["modulus"] * found["section"], rel=1e-15)
    assert found["cycles"] == len(found["hysteresis"]) == 3
    assert found["band"] == [0.05, 0.5]


@pytest.mark.parametrize(
    "options",
    [
        ("--initial-length", "2", "--section", "12.566370614359172e-6", "--breaking-load", "10290"),
        ("--initial-length", "2000 mm", "--diameter", "4 mm", *LOAD),
        (*LENGTH, "--robot", "paty2021"),
        (*LENGTH, "--robot", "paty2021", "--line", "south-west"),
        (*LENGTH, "--robot", "grab-four-lines", *SECTION, *LOAD),
    ],
)
def test_ways_to_say_the_same(cli, options: tuple[str, ...]) -> None:
    same = cli("modulus", TEST, *GIVEN, "--json").json
    assert cli("modulus", TEST, *options, "--json").json["modulus"] == pytest.approx(same["modulus"], rel=1e-12)


def test_an_option_wins_over_the_robot(cli) -> None:
    found = cli("modulus", TEST, *LENGTH, "--robot", "paty2021", "--diameter", "8 mm", "--json").json
    assert found["section"] == pytest.approx(math.pi * 16e-6, rel=1e-15)
    assert found["breaking_load"] == 10290


def test_what_is_printed_can_be_pasted(cli, tmp_path: Path) -> None:
    printed = cli("modulus", TEST, *GIVEN).out
    text = library_text("paty2021")
    for key in ("young_modulus", "section", "breaking_load"):
        (line,) = re.findall(rf"^{key} = .*$", printed, re.MULTILINE)
        text = re.sub(rf"^{key} = .*$", line, text, count=1, flags=re.MULTILINE)
    file = tmp_path / "mine.toml"
    file.write_text(text)
    again = cli("modulus", TEST, *LENGTH, "--robot", file, "--json").json
    assert again["modulus"] == cli("modulus", TEST, *GIVEN, "--json").json["modulus"]
    assert "0.84,1.10, within the paper's 0.7 to 1.3: --modulus-range of accuracy" in printed


def test_the_page_shows_what_is_printed(cli, monkeypatch) -> None:
    page = (ROOT / "docs" / "modulus.md").read_text(encoding="utf-8")
    ((command, text),) = re.findall(r"```sh\n(cablewright modulus [^\n]*)\n```\n+```text\n(.*?)```", page, re.DOTALL)
    monkeypatch.chdir(ROOT)
    assert cli(*shlex.split(command)[1:]).out == text


def test_picture(cli, tmp_path: Path) -> None:
    file = tmp_path / "test.png"
    file.write_text("an earlier one")
    answer = cli("modulus", TEST, *GIVEN, "--plot", file)
    assert answer.code == 0
    assert str(file) in answer.out
    assert file.read_bytes().startswith(b"\x89PNG")
    assert sorted(tmp_path.iterdir()) == [file, file.with_name("test.png.csv")]
    assert cli("modulus", TEST, *GIVEN, "--json", "--plot", file).json["plot"] == str(file)


def test_a_picture_that_cannot_be_written(cli, tmp_path: Path) -> None:
    (tmp_path / "folder.png").mkdir()
    for file in (tmp_path / "folder.png", tmp_path / "none" / "test.png"):
        answer = cli("modulus", TEST, *GIVEN, "--plot", file)
        assert answer.code == 3
        assert answer.out == ""
        assert answer.err.count("\n") == 1
        assert str(file) in answer.err
        assert "cannot be written" in answer.err
    assert [path.name for path in tmp_path.iterdir()] == ["folder.png"]
    assert not list((tmp_path / "folder.png").iterdir())


def test_notes_are_distinguished_from_the_result(cli, tmp_path: Path) -> None:
    file = tmp_path / "once.csv"
    file.write_text("\n".join(TEST.read_text().splitlines()[:68]))
    answer = cli("modulus", file, *GIVEN, "--json")
    assert answer.code == 0
    assert answer.json["unloading"] == []
    assert answer.err.splitlines() == [f"note: {note}" for note in answer.json["notes"]]
    assert "one full loading only" in answer.err


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ((*SECTION, *LOAD), "Missing option '--initial-length'"),
        ((*LENGTH, *LOAD), "missing option '--section': give it, or --diameter, or --robot"),
        ((*LENGTH, *SECTION), "missing option '--breaking-load': give it, or --robot"),
        ((*GIVEN, "--diameter", "4 mm"), "--diameter = '4 mm': give either this or --section"),
        (("--initial-length", "2 kN", *SECTION, *LOAD), "--initial-length = '2 kN': must be a finite length"),
        (("--initial-length", "nan", *SECTION, *LOAD), "--initial-length = 'nan': must be a finite length"),
        (("--initial-length", "-2 m", *SECTION, *LOAD), "--initial-length = '-2 m': must be over 0"),
        (("--initial-length", "", *SECTION, *LOAD), "--initial-length = ''"),
        (("--initial-length", "1e9", *SECTION, *LOAD), "initial length = 1e+09 m"),
        ((*LENGTH, "--section", "0", *LOAD), "--section = '0': must be over 0"),
        ((*LENGTH, "--section", "12.57", *LOAD), "section = 12.57 m^2: must be over 0, from 1e-10 to 0.1"),
        ((*LENGTH, "--diameter", "wide", *LOAD), "--diameter = 'wide': must be a finite length"),
        ((*LENGTH, *SECTION, "--breaking-load", "10 t"), "--breaking-load = '10 t': must be a finite force"),
        ((*LENGTH, *SECTION, "--breaking-load", "20 kN"), "the highest 60"),
        ((*LENGTH, *SECTION, "--breaking-load", "10.29"), "over twice the breaking load"),
        ((*GIVEN, "--band", "0.05"), "--band = '0.05': expected two shares"),
        ((*GIVEN, "--band", "0.5,0.05"), "--band = '0.5,0.05': expected two shares"),
        ((*GIVEN, "--band", "0,0.5"), "--band"),
        ((*GIVEN, "--band", "nan,0.5"), "--band"),
        ((*GIVEN, "--band", "5 %,50 %"), "--band"),
        ((*GIVEN, "--line", "south-west"), "--line = 'south-west': give --robot too"),
        ((*GIVEN, "--robot", "paty2012"), "did you mean 'paty2021'?"),
        ((*GIVEN, "--robot", "paty2021", "--line", "southwest"), "unknown line 'southwest'"),
        ((*LENGTH, "--robot", "paty2012"), "did you mean 'paty2021'?"),
        ((*LENGTH, "--robot", "paty2021", "--line", "southwest"), "unknown line 'southwest'; did you mean"),
        ((*LENGTH, "--robot", "grab-four-lines"), "its cable is given by axial_stiffness and has no section"),
        ((*GIVEN, "--plot", "test.jpg"), "--plot = 'test.jpg': expected a name that ends in .png"),
        ((*GIVEN, "--plot", ""), "--plot"),
    ],
)
def test_options_that_cannot_be_used(cli, options: tuple[str, ...], says: str) -> None:
    assert says in cli("modulus", TEST, *options).refusal
    assert says in cli("modulus", TEST, "--json", *options).refusal


def test_lines_with_different_cables(cli, tmp_path: Path) -> None:
    text = library_text("paty2021")
    other = text.replace('name = "north-east"', 'name = "north-east"\ncable = { breaking_load = "9 kN" }', 1)
    file = tmp_path / "mine.toml"
    file.write_text(other)
    assert "different cables; name one with --line" in cli("modulus", TEST, *LENGTH, "--robot", file).refusal
    found = cli("modulus", TEST, *LENGTH, "--robot", file, "--line", "north-east", "--json").json
    assert found["breaking_load"] == 9000


@pytest.mark.parametrize("text", ["", "force\n1\n", "force,elongation\n1,x\n", "force,elongation\n" + 30 * "1,1\n"])
def test_files_that_cannot_be_used(cli, tmp_path: Path, text: str) -> None:
    file = tmp_path / "test.csv"
    file.write_text(text)
    assert cli("modulus", file, *GIVEN, "--plot", tmp_path / "p.png").refusal.startswith(str(file))
    assert list(tmp_path.iterdir()) == [file]


def test_no_file(cli, tmp_path: Path) -> None:
    assert "no such file" in cli("modulus", tmp_path / "none.csv", *GIVEN).refusal
    assert "not a regular file" in cli("modulus", tmp_path, *GIVEN).refusal


CREEP = ROOT / "examples" / "creep.csv"
CREEP_KEYS = {
    "schema", "status", "stiffness", "stiffness_sigma", "expansion", "temperature", "loaded", "creep", "parts", "noise",
    "activation_energy", "activation_energy_sigma",
    "widened", "uncertainty_file", "robot_file", "notes", "plot",
}  # fmt: skip


def test_creep_as_json(cli) -> None:
    answer = cli("creep", CREEP, *LENGTH, "--json")
    assert (answer.code, answer.err) == (0, "")
    assert answer.json.keys() == CREEP_KEYS
    assert answer.json["stiffness"] == pytest.approx(480e3, rel=1e-3)
    assert answer.json["creep"][-1]["time"] == answer.json["loaded"]


def test_the_entry_is_that_of_an_uncertainty_file(cli, tmp_path: Path) -> None:
    found = cli("creep", CREEP, *LENGTH, "--json").json
    (tmp_path / "crept.toml").write_text("schema = 1\n" + found["uncertainty_file"])
    one = cw.load_uncertainty(tmp_path / "crept.toml").of(cw.load("house-printer"))[0]
    assert (one.parameter.kind, one.low) == ("creep_compliance", 0.0)
    assert one.high == pytest.approx(found["creep"][-1]["compliance"], rel=0.05)


def test_elements_are_chosen(cli) -> None:
    plain = cli("creep", CREEP, *LENGTH, "--retardations", "none", "--json").json
    assert [part["part"] for part in plain["parts"]] == ["logarithmic"]
    own = cli("creep", CREEP, *LENGTH, "--retardations", "30 s,10 min,1 h", "--json").json
    assert [part["part"] for part in own["parts"]][:3] == ["element of 30 s", "element of 600 s", "element of 3600 s"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--retardations", "20 min,1 min"), "retardations = 1200, 60 s: expected up to 4 that rise"),
        (("--retardations", "4 h"), "the element of 4 h needs a load for 4 h, the test has 2.83 h: hold longer"),
        (("--retardations", "1 fortnight"), "--retardations"),
        (("--initial-length", "2 kg"), "--initial-length"),
    ],
)
def test_of_creep_what_is_wrong_is_one_line(cli, options: tuple[str, ...], message: str) -> None:
    answer = cli("creep", CREEP, *LENGTH, *options)
    assert answer.code == 2
    assert message in answer.err
    assert answer.err.count("\n") == 1


def test_a_tensile_test_is_too_short(cli) -> None:
    answer = cli("creep", TEST, *LENGTH)
    assert answer.code == 2
    assert "the element of 20 min needs a load for 20 min, the test has 3.25 min" in answer.err
