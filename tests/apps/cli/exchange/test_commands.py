"""`import`, `export` and `forward --lengths FILE.csv` as people call them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cablewright.apps.cli.main import run
from cablewright.robot import library_names, load
from exchange import samples


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.wcrfx").write_text(samples.wirex())
    return tmp_path


def test_import(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["import", "own.wcrfx", "--out", "robot.toml", "--json"]) == 0
    said = capsys.readouterr()
    told = json.loads(said.out)
    assert (told["format"], told["name"], told["lines"], told["freedoms"]) == ("WireX 0.32", "own", 8, 6)
    assert all(f"note: lost: {each}" in said.err for each in told["lost"])
    assert all(f"note: assumed: {each}" in said.err for each in told["assumed"])
    text = (here / "robot.toml").read_text()
    assert all(f"# lost: {each}" in text for each in told["lost"])
    assert load("robot.toml").m == 8


def test_import_of_two_files(here: Path) -> None:
    (here / "a.xml").write_text(samples.caspr_cables())
    (here / "b.xml").write_text(samples.BODIES)
    assert run(["import", "a.xml", "b.xml", "--out", "robot.toml", "--cable", "dyneema-4mm"]) == 0
    assert load("robot.toml").lines[0].cable.diameter == 0.004


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["import", "own.wcrfx", "--out", "own.wcrfx"], "--out"),
        (["import", "none.wcrfx", "--out", "a.toml"], "none.wcrfx: no such file"),
        (["import", "own.wcrfx", "--out", "there.toml"], "there.toml: exists already"),
        (["export", "mjcf", "cogiro", "--out", "there.toml"], "there.toml: exists already"),
        (["export", "klipper", "house-printer", "--out", "a"], "give the JOB whose motion"),
        (["export", "mjcf", "cogiro", "part.gcode", "--out", "a"], "takes no JOB"),
        (["export", "mjcf", "cogiro", "--schema-version", "0.31", "--out", "a"], "only the format wirex has versions"),
        (
            ["export", "wirex", "cogiro", "--at", "0,0,1", "--out", "a"],
            "only mjcf, urdf, stl, glb are written for one pose",
        ),
        (["export", "wirex", "cogiro", "--layers", "1,2", "--out", "a"], "are only for firmware"),
        (["export", "wirex", "maslow4", "--out", "a"], "has platform.plane; not supported. Export mjcf"),
        (["export", "step", "cogiro", "--out", "a"], "step"),
        (["forward", "merlet2023", "--lengths", "none.csv"], "none.csv: no such file"),
        (["forward", "merlet2023", "--lengths", "none.csv", "--certify"], "--certify: is only for one set"),
    ],
)
def test_bad_arguments_are_one_line(
    arguments: list[str], words: str, here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "there.toml").write_text("mine")
    assert run(arguments) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    assert words in said.err
    assert (here / "there.toml").read_text() == "mine"


@pytest.mark.parametrize("version", ["0.31", "0.32"])
def test_export_of_wirex_and_back(version: str, here: Path) -> None:
    assert run(["export", "wirex", "ipanema1", "--schema-version", version, "--out", "i.wcrfx"]) == 0
    assert f'<models version="{version}">' in (here / "i.wcrfx").read_text()
    assert run(["import", "i.wcrfx", "--out", "i.toml"]) == 0
    ours, back = load("ipanema1"), load("i.toml")
    assert [line.exit_point for line in back.lines] == [line.exit_point for line in ours.lines]
    assert [line.sheave for line in back.lines] == [line.sheave for line in ours.lines]


def test_export_of_firmware(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "part.gcode").write_text(";LAYER:0\nG1 X-300 Y-300 Z200 F9000\nG1 X300 Y200 E9\n")
    assert run(["export", "klipper", "hangprinter-v4", "part.gcode", "--out", "out", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["points"] > 10
    assert 0.0 < told["path_error"] < 1e-4
    assert {path.name for path in (here / "out").iterdir()} == {"printer.cfg", "job.gcode"}
    assert run(["export", "reprapfirmware", "hangprinter-v4", "part.gcode", "--out", "rrf"]) == 0
    assert run(["import", "rrf/config.g", "--nozzle-below", "120 mm", "--out", "back.toml"]) == 0
    ours, back = load("hangprinter-v4"), load("back.toml")
    for key in ("exit_point", "platform_point", "advantage", "tension_limits"):
        for one, other in zip(back.lines, ours.lines, strict=True):
            assert getattr(one, key) == pytest.approx(getattr(other, key), abs=1e-12)
    radii = [[line.winch.drum_radius for line in robot.lines] for robot in (back, ours)]
    assert radii[0] == pytest.approx(radii[1], rel=1e-3)  # with a build-up, which the firmware cannot do without


def test_forward_of_a_log(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["inverse", "merlet2023", "--at", "0,0,1", "--json"]) == 0
    lengths = json.loads(capsys.readouterr().out)["lengths"]
    names = [line.name for line in load("merlet2023").lines]
    header = ",".join(["time (s)", *(f"length {name} (m)" for name in names)])
    rows = [",".join([str(k), *map(str, lengths)]) for k in range(3)]
    (here / "log.csv").write_text("\n".join([header, *rows]))
    assert run(["forward", "merlet2023", "--lengths", "log.csv", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["rows"], told["solved"]) == (3, 3)
    assert told["pose"][2] == pytest.approx([0.0, 0.0, 1.0], abs=1e-7)


@pytest.mark.parametrize("name", library_names())
def test_every_robot_can_be_written_at_a_pose(name: str, here: Path) -> None:
    for kind, begin in (("mjcf", b"<mujoco "), ("urdf", b"<?xml"), ("stl", b"cablewright"), ("glb", b"glTF")):
        assert run(["export", kind, name, "--out", f"robot.{kind}"]) == 0
        assert (here / f"robot.{kind}").read_bytes().startswith(begin)
