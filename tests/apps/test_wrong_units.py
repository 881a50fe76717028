"""Numbers in the wrong unit, and files of other programs in the place of a robot: the message names the next step."""

from __future__ import annotations

import contextlib
import math
from pathlib import Path

import numpy as np
import pytest

from cablewright.apps.cli.parsing import lengths_of, pose_of
from cablewright.foundation.errors import InputError
from cablewright.robot import library_names, load
from cablewright.robot.plausibility import units_inside


@pytest.mark.parametrize("name", library_names())
def test_places_and_lengths_in_millimetres_are_named_and_those_in_metres_are_not(name: str) -> None:
    robot = load(name)
    corners = np.array([robot.scene.frame_min, robot.scene.frame_max])
    for share in (0.1, 0.5, 0.95):
        place = corners[0] + share * np.ptp(corners, axis=0)
        assert pose_of(",".join(map(repr, place.tolist())), robot) == place.tolist()
        reach = max(math.dist(place, line.exit_point) for line in robot.lines)
        lengths = [reach * line.advantage + line.dead_length for line in robot.lines]
        assert lengths_of(",".join(map(repr, lengths)), robot) == lengths
        with pytest.raises(InputError, match=r"--lengths = .*: is in m, and .* are these mm, is .* meant"):
            lengths_of(",".join(repr(1e3 * length) for length in lengths), robot)
    with pytest.raises(InputError, match=r"--at = .*: is in m, and .* are these mm"):
        pose_of(",".join(map(repr, (1e3 * corners[1]).tolist())), robot)


def test_a_pose_in_millimetres_is_bad_input(cli) -> None:
    said = cli("inverse", "merlet2023", "--at", "300,200,1000").refusal
    assert said == "--at = 1000: is in m, and 'merlet2023' is 11.9 m large: are these mm, is 1 meant?"
    assert "--lengths = 10430: is in m" in cli("forward", "merlet2023", "--lengths", ",".join(["10430"] * 4)).refusal


def test_a_free_freedom_and_rotations_are_not_lengths() -> None:
    robot = load("cogiro")
    assert np.isnan(pose_of("0,0,free,100,0,0", robot)[2])


def test_bounds_have_their_unit(cli, tmp_path: Path) -> None:
    (tmp_path / "part.gcode").write_text("G1 X1 E1\n")
    job = tmp_path / "job.toml"
    job.write_text('schema = 1\nname = "a"\ngcode = "part.gcode"\nscale = 0\n[motion]\nprint_speed = 2400\njerk = 0\n')
    said = cli("check", "merlet2023", str(job)).refusal
    assert "scale = 0: must be at least 0.0001;" in said
    assert "motion.print_speed = 2400: must be at most 1000 m/s" in said
    assert "motion.jerk = 0: must be at least 1e-06 m/s^3" in said


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("printer.cfg", "[printer]\nkinematics: winch\n"),
        ("config.g", "M669 K6 ; Hangprinter\n"),
        ("maslow.yaml", "name: Maslow\nkinematics:\n  Maslow:\n"),
        ("robot.yml", "a: 1\n"),
        ("robot.xml", "<?xml version='1.0'?><bodies/>"),
        ("plain.cfg", "a = 1\n"),
    ],
)
def test_files_of_other_programs_name_import(cli, tmp_path: Path, name: str, text: str) -> None:
    file = tmp_path / name
    file.write_text(text)
    said = cli("inverse", str(file), "--at", "0,0,1").refusal
    assert f"`cablewright import {file} --out robot.toml`" in said


def test_a_missing_file_names_no_import(cli, tmp_path: Path) -> None:
    said = cli("inverse", str(tmp_path / "printer.cfg"), "--at", "0,0,1").refusal
    assert "no such file" in said
    assert "import" not in said


@pytest.mark.parametrize(("unit", "size"), [("mm", 1e-3), ("cm", 1e-2), ("inch", 0.0254), ("ft", 0.3048)])
@pytest.mark.parametrize("name", ["house-printer", "merlet2023", "ipanema", "hangprinter-v4", "maslow4"])
def test_places_outside_of_the_robot_are_noted_with_the_units_that_explain_them(
    name: str, unit: str, size: float, capsys: pytest.CaptureFixture[str]
) -> None:
    robot = load(name)
    corners = np.array([robot.scene.frame_min, robot.scene.frame_max])
    for share in (0.05, 0.6, 0.9):
        place = corners[0] + share * np.ptp(corners, axis=0)
        if not units_inside([tuple(place / size)], robot):
            continue  # as near in m as in the unit
        text, said = ",".join(map(repr, (place / size).tolist())), ""
        with contextlib.suppress(InputError):  # in mm, far from a robot, they are rejected
            pose_of(text, robot)
            said = capsys.readouterr().err
            assert "note: --at = " in said
            assert f"{unit} (" in said
        if not said:
            with pytest.raises(InputError, match="are these mm"):
                pose_of(text, robot)
    assert units_inside([tuple(corners[1] / size)], robot)


@pytest.mark.parametrize("name", library_names())
def test_places_in_the_robot_and_a_little_beside_it_are_not_noted(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    robot = load(name)
    corners = np.array([robot.scene.frame_min, robot.scene.frame_max])
    beside = 0.1 * np.ptp(corners, axis=0).max()
    for place in (corners.mean(axis=0), corners[0] - beside, corners[1] + beside):
        pose_of(",".join(map(repr, place.tolist())), robot)
    pose_of("0,0,free", robot)
    reach = max(math.dist(corners[0], line.exit_point) * line.advantage + line.dead_length for line in robot.lines)
    lengths_of(",".join([repr(reach)] * robot.m), robot)
    assert capsys.readouterr().err == ""


def test_a_place_in_millimetres_or_inches_of_a_house_is_noted(cli) -> None:
    answer = cli("inverse", "house-printer", "--at", "300,200,100")
    assert "note: --at = 300: is in m, and 'house-printer' is 26 m large: are these mm (300 mm)" in answer.err
    assert "inch (7.62 m)" in answer.err


def test_lengths_in_inches_and_rotations_in_degrees_are_noted(capsys: pytest.CaptureFixture[str]) -> None:
    robot = load("ipanema")
    lengths_of(",".join(["120"] * robot.m), robot)
    assert "inch (3.05 m)" in capsys.readouterr().err
    pose_of("0,0,1,0,0,20", robot)
    assert "are these deg?" in capsys.readouterr().err
