"""Commands that ask whether a pose is held say no where the lines lift the platform off a plane that only pushes."""

from __future__ import annotations

from pathlib import Path

import pytest

import cablewright as cw
import planar_robots
from cablewright.studies.part_fit import fit

LIFTED = "lifts off its plane"


@pytest.mark.parametrize("command", ["inverse", "modes", "accuracy"])
def test_a_sled_in_the_air_is_not_held(cli, tmp_path: Path, command: str) -> None:
    said = cli(command, planar_robots.sled(tmp_path, 5.0), "--at", "0,0,0")
    assert said.code == 1
    assert LIFTED in said.err
    assert cli(command, planar_robots.sled(tmp_path, 60.0), "--at", "0,0,0").code == 0


def test_lengths_that_lift_a_sled_are_out_of_limits(cli, tmp_path: Path) -> None:
    file = planar_robots.sled(tmp_path, 5.0)
    lengths = ",".join(f"{each:.9g}" for each in cw.inverse(cw.load(str(file)), [0.0, 0.0, 0.0]).lengths)
    said = cli("forward", file, "--lengths", lengths, "--json")
    assert said.code == 1
    assert said.json["status"] == "out-of-limits"
    assert LIFTED in said.err
    near = cli("interference", file, "--at", "0,0,0")
    assert near.code == 1
    assert "cannot be held: out-of-limits" in near.err


def test_a_part_fits_where_the_sled_is_pressed(cli, tmp_path: Path) -> None:
    job = tmp_path / "part.gcode"
    job.write_text("G21\nG90\nG1 X-100 Y0 Z0 F1000 E0\nG1 X100 Y0 E10\n")
    said = cli("fit", planar_robots.sled(tmp_path, 5.0), job)
    assert said.code == 1
    assert "holds its nozzle nowhere" in said.err
    assert fit(cw.load(str(planar_robots.sled(tmp_path, 60.0))), cw.load_job(job)).fits
