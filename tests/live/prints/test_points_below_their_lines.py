"""A nozzle below the point where lines meet: on the simulated machine it moves as with exit points lower by as much."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cablewright.apps.cli.main import run
from cablewright.exchange.firmware_robots import as_points
from cablewright.exchange.robot_toml import plain_toml
from cablewright.machine.simulated.machine_file import machine_file
from cablewright.robot import Robot, load

RING = "G21\nG90\nM83\n;LAYER:0\nG0 X20 Y0 Z0.6 F6000\n" + "".join(
    f"G1 X{x} Y{y} E0.5 F3000\n" for x, y in ((0, 20), (-20, 0), (0, -20), (20, 0))
)


def printed(robot: Robot, machine: Path, folder: Path, capsys: pytest.CaptureFixture[str]) -> dict[str, float]:
    (folder / "robot.toml").write_text(plain_toml(robot))
    (folder / "ring.gcode").write_text(RING)
    words = ["print", str(folder / "robot.toml"), str(folder / "ring.gcode"), "--machine", str(machine)]
    assert run([*words, "--plant", "quasi-static", "--out", str(folder / "out"), "--json"]) == 0
    return dict(json.loads(capsys.readouterr().out))


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("name", ["hangprinter-v4", pytest.param("hangprinter-five", marks=pytest.mark.slow)])
def test_it_prints_as_a_robot_whose_lines_meet_in_the_nozzle(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robot = load(name)
    machine = tmp_path / "machine.toml"
    machine.write_text(machine_file(robot))
    assert 'valve = "0 mm"' in machine.read_text()
    found = []
    for own in (robot, as_points(robot)):
        folder = tmp_path / str(len(found))
        folder.mkdir()
        found.append(printed(own, machine, folder, capsys))
    below, shifted = found
    assert below["status"] == shifted["status"] == "finished"
    for key in ("position_rms", "max_path_error", "max_height_error", "min_tension_margin"):
        assert below[key] == pytest.approx(shifted[key], rel=1e-2, abs=1e-6), key
    assert below["max_path_error"] < 3e-3
