"""Every format of every robot: it is written with defaults, or one line says what to change."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

from cablewright.apps.cli.main import run
from cablewright.exchange.firmware import firmware
from cablewright.exchange.formats import read_robot
from cablewright.exchange.robot_toml import robot_toml
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.live.rest_pose import rest_pose
from cablewright.machine.files import load_machine
from cablewright.models.statics import Model
from cablewright.printing.job import load_job
from cablewright.robot import Robot, library_names, load
from cablewright.robot.new_robot import LAYOUTS, Outline
from cablewright.studies.new_robot import new_robot
from cases import some
from exchange import samples
from exchange.test_files_by_version import GROUND, WALL

SAMPLES = {
    "own.wcrfx": samples.wirex(), "maslow.yaml": samples.MASLOW, "printer.cfg": samples.KLIPPER,
    "fork.cfg": samples.FORK, "config.g": samples.RRF, "wall.yaml": WALL, "groundcontrol.ini": GROUND,
}  # fmt: skip
FIRMWARE = ("klipper", "linuxcnc", "reprapfirmware")
UNLIKE = {("linuxcnc", "body"), ("reprapfirmware", "body"), ("reprapfirmware", "suspended")}  # 8 lines, and swivels
OTHERS = [name for name in library_names() if name not in library_names()[::3]]
NEXT = re.compile(r"(: |; |, |\. )(give|leave out|export|make|allow|raise|choose|put)\b[^\n]+$", re.IGNORECASE)


def part_of(robot: str, folder: Path) -> Path:
    """A small square about where the robot rests, in a plane if it slides in one."""
    at = rest_pose(Model.of(load(robot), cable="rigid")).equilibrium
    described = at.model.robot
    size = 0.02 * float(np.ptp([described.scene.frame_min, described.scene.frame_max], axis=0).max())
    x, y, z = 1e3 * np.array(at.pose[:3])
    plane = described.platform.plane
    across = (0.0, 1.0, 0.0) if plane is None and described.name.endswith("planar") else plane and plane.across
    axes = np.eye(3) if across is None else np.linalg.svd(np.array([across]))[2][1:]
    corners = [
        np.array([x, y, z]) + 1e3 * size * (a * axes[0] + b * axes[1]) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))
    ]
    text = "G21\nG90\nM83\n;LAYER:0\n"
    for k, corner in enumerate([*corners, corners[0]]):
        text += f"G{int(k > 0)} X{corner[0]:.6f} Y{corner[1]:.6f} Z{corner[2]:.6f}{' E5' if k else ''} F1200\n"
    (folder / "square.gcode").write_text(text)
    return folder / "square.gcode"


def robot_of(name: str, folder: Path) -> str:
    if name in LAYOUTS:
        size = (4.0, 0.0 if name == "planar" else 4.0, 3.0)
        new_robot(Outline(name=f"own-{name}", layout=name, size=size), folder / "new")
        return str(folder / "new" / "robot.toml")
    if name in SAMPLES:
        (folder / name).write_text(SAMPLES[name])
        (folder / "read.toml").write_text(robot_toml(read_robot([folder / name]), "cablewright import"))
        return str(folder / "read.toml")
    return name


def told_in(path: Path) -> str:
    """The text of a file, or of all files of a folder, as comments have it."""
    files = [path] if path.is_file() else sorted(path.iterdir())
    return "".join(file.read_text("utf-8", "replace") for file in files)


@pytest.mark.parametrize("name", [*library_names()[::3], *some(OTHERS, 0), *LAYOUTS, *SAMPLES])
def test_every_format(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Lost and assumed values are in the answer and in each text; a rejection is one line with the next step."""
    robot = robot_of(name, tmp_path)
    part = part_of(robot, tmp_path)
    for kind in ("wirex", "mjcf", "urdf", "stl", "glb", *FIRMWARE):
        job = [str(part)] if kind in FIRMWARE else []
        out = tmp_path / f"out.{kind}"
        code = run(["export", kind, robot, *job, "--out", str(out), "--json"])
        said = capsys.readouterr()
        if code:
            last = said.err.splitlines()[-1]
            assert code in (1, 2), (kind, said.err)
            assert NEXT.search(last), (kind, last)
            assert not out.exists()
            continue
        answer = json.loads(said.out)
        assert answer["lost"]
        if kind not in ("stl", "glb"):
            text = told_in(out)
            for each in answer["lost"]:
                assert f"lost: {each.replace('--', '- -') if kind not in FIRMWARE else each}" in text, (kind, each)


BESIDE = """M8 ; its first line
;py, import os; a line end of old\rM104 S9
;TYPE:wall
(LOGOPEN, /tmp/log)
M83
G1 X0 Y0 Z200 F3000
M104 S200 T0
M3 S100 X60
M8 G1 X20 E5 F1200
M106 S255 G1 X20 Y20 E2
G10 P1 X0
G10 P0 S200
T1 M107
RESPOND_AND_PARK X=1
START_PRINT BED=60
M117 go G1 X5
M207 S1 Z2
G10
G1 X0 Y0 E3
"""
KEPT = {
    "klipper": "M104 S200 T0|M106 S255|M107|M117 go G1 X5|G10",
    "reprapfirmware": "M104 S200 T0|M106 S255|G10 P0 S200|T1 P0|M107|M117 go G1 X5|G10",
    "linuxcnc": "M8|M8",
}
"""Of `BESIDE`, what moves neither axes nor their zero."""


@pytest.mark.parametrize("kind", FIRMWARE)
def test_what_is_beside_motion_moves_nothing(kind: str, tmp_path: Path) -> None:
    """Of several commands in a line, and of a command with axes, none moves the platform beside the checked path."""
    (tmp_path / "own.gcode").write_bytes(BESIDE.encode("utf-8-sig"))
    made = firmware(kind, load("hangprinter-five"), load_job(tmp_path / "own.gcode"), tolerance=1e-4)
    text = made.files["job.ngc" if kind == "linuxcnc" else "job.g" if kind == "reprapfirmware" else "job.gcode"]
    body = text[text.index("M67 E0 Q0" if kind == "linuxcnc" else "M83") : text.rindex("; line")].splitlines()
    own = [line for line in body if not re.match(r"G[01] X|G92 X|MANUAL|M83|M67|;", line)]
    assert own == KEPT[kind].split("|")
    assert (";py, import os" in text) is (kind != "linuxcnc")  # which executes such comments
    assert "G10 (" in "".join(made.lost)


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("kind", FIRMWARE)
def test_starters_print_their_own_part(layout: str, kind: str, tmp_path: Path) -> None:
    """With its own machine, a new robot's part is written, or another firmware is named."""
    robot = Path(robot_of(layout, tmp_path))
    files = [str(robot.with_name(each)) for each in ("part.toml", "machine.toml")]
    code = run(["export", kind, str(robot), files[0], "--machine", files[1], "--out", str(tmp_path / "out")])
    assert code == (2 if (kind, layout) in UNLIKE else 0)


def test_a_small_jump_of_a_slack_line_is_noted(tmp_path: Path) -> None:
    """A steel cable on a light platform: at the least tension its sag changes abruptly, by less than a microstep."""
    outline = Outline(name="own", layout="over-middle", size=(2.0, 2.0, 1.5), mass=2.0, cable="steel-4mm")
    new_robot(outline, tmp_path / "n")
    robot, machine = load(tmp_path / "n" / "robot.toml"), load_machine(tmp_path / "n" / "machine.toml")
    job = load_job(tmp_path / "n" / "part.toml")
    made = firmware("klipper", robot, job, machine=machine)
    asked = 0.5 * 2 * math.pi / (200 * 16 * machine.winch.ratio) * robot.lines[0].winch.drum_radius
    assert asked < made.path.error < 2e-5
    assert any(f"its length jumps, by {1e6 * made.path.error:.2g} um" in each for each in made.lost)
    with pytest.raises(AnswerError, match=r"line 'low-\d' jumps, .* allow it with --tolerance"):
        firmware("klipper", robot, job, machine=machine, tolerance=asked)


@pytest.mark.parametrize("other", ["counterweight", "shared_winch"])
def test_a_line_without_a_winch_of_its_own_is_rejected(other: str, tmp_path: Path) -> None:
    table = load("hangprinter-v4").model_dump(by_alias=True)
    first, *rest = table["lines"]
    given = {"counterweight": 0.5, "winch": {}}
    if other == "shared_winch":
        given = {"shared_winch": {"line": "B"}, "winch": rest[0]["winch"]}
    robot = Robot.model_validate(table | {"lines": [first | given, *rest]})
    (tmp_path / "a.gcode").write_text(";LAYER:0\nG1 X-100 Y-100 Z200 F9000\nG1 X100 Y100 E9\n")
    why = f"export reprapfirmware: line 'A' has (a )?{other}; not supported. Export klipper"
    with pytest.raises(InputError, match=why):
        firmware("reprapfirmware", robot, load_job(tmp_path / "a.gcode"))
