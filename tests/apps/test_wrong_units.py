"""Numbers in the wrong unit, and files of other programs in the place of a robot: the message names the next step."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from cablewright.apps.cli.parsing import lengths_of, pose_of
from cablewright.errors import InputError
from cablewright.robot import library_names, load


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
