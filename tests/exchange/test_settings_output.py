"""Settings of wall plotters and Maslows that are written, read back."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest

from cablewright.apps.cli.main import run
from cablewright.exchange.formats import read_robot
from cablewright.exchange.maslow import read_maslow
from cablewright.exchange.walls.settings_output import WALLS
from cablewright.foundation.errors import InputError
from cablewright.robot import Line, Robot, load, loads

WALL = """
kinematics:
  WallPlotter:
    left_axis: 0
    left_anchor_x: -267.125
    left_anchor_y: 250
    right_axis: 1
    right_anchor_x: 268.5
    right_anchor_y: 249.75
    segment_length: 10
axes:
  x:
    max_rate_mm_per_min: 5000
  y:
    max_rate_mm_per_min: 4321.5
"""
MASLOW = """
Maslow_vertical: {vertical}
kinematics:
  MaslowKinematics:
    tlX: -27.6
    tlY: 2064.9
    tlZ: 100.3
    trX: 2924.3
    trY: 2066.5
    trZ: 56.3
    blX: 0
    blY: 0
    blZ: 34.2
    brX: 2953.2
    brY: 0
    brZ: 78.3
axes:
  a:
    max_rate_mm_per_min: 1500
  d:
    max_rate_mm_per_min: 1400
"""
FILES = {
    "wallplotter": ("wall.yaml", WALL),
    "maslow": ("maslow.yaml", MASLOW.format(vertical="true")),
    "maslow that lies": ("maslow.yaml", MASLOW.format(vertical="false")),
    "polargraph": ("m.gcode", "M665 S5 L-300.5 R301.25 T500 B-650.125 H1035\nM203 X120 Y110.5\n"),
    "polargraph of M503": ("m.gcode", "echo:  M665 S5.00 L-325.00 R325.00 T450.00 B-450.00 H1200.0\n"),
    "maslow-classic": (
        "c.txt",
        "$1=1219.2 (machine height, mm)\n$2=2978.4 (distance between motors, mm)\n$3=463\n$10=3360\n$13=63.5\n",
    ),
}


def of(folder: Path, name: str, text: str) -> Robot:
    folder.mkdir()
    (folder / name).write_text(text)
    return read_robot([folder / name]).robot


@pytest.mark.parametrize("case", FILES)
def test_written_files_are_read_as_the_same_robot(case: str, tmp_path: Path) -> None:
    name, text = FILES[case]
    first = of(tmp_path / "first", name, text)
    made = WALLS[case.split()[0]](first)
    again = of(tmp_path / "again", name, made.text)
    for one, other in zip(first.lines, again.lines, strict=True):
        assert other.exit_point == pytest.approx(one.exit_point, abs=1e-11)
        assert (other.name, other.winch) == (one.name, one.winch)
    assert again.platform.plane == first.platform.plane
    assert again.scene.frame_min == pytest.approx(first.scene.frame_min, abs=1e-11)
    assert any("platform.mass" in each for each in made.lost)
    assert all(each in made.text for each in made.lost)


def test_numbers_by_hand(tmp_path: Path) -> None:
    text = WALLS["polargraph"](of(tmp_path / "p", *FILES["polargraph"])).text
    assert "M665 L-300.5 R301.25 T500 B-650.125 H1035\nM203 X120 Y110.5\nM500\n" in text
    text = WALLS["maslow-classic"](of(tmp_path / "c", *FILES["maslow-classic"])).text
    for line in ("$1=1219.2 (", "$2=2978.4 (", "$3=463 (", "$10=3360 (", "$13=63.5 (", "$7=2 ("):
        assert f"\n{line}" in text


def test_a_platform_point_shifts_the_exit_points(tmp_path: Path) -> None:
    robot = of(tmp_path / "p", *FILES["wallplotter"])
    table = robot.model_dump(by_alias=True)
    for line in table["lines"]:
        line["platform_point"] = (0.0, 0.0, 0.02)
    text = WALLS["wallplotter"](Robot.model_validate(table)).text
    assert "left_anchor_y: 230\n" in text
    assert "right_anchor_y: 229.75\n" in text


def test_anchors_count_from_the_zero_of_gcode(tmp_path: Path) -> None:
    table = of(tmp_path / "p", *FILES["polargraph"]).model_dump(by_alias=True)
    table["platform"]["plane"]["gcode_zero"] = (0.1, 0.0, -0.2)
    made = WALLS["polargraph"](Robot.model_validate(table))
    assert "M665 L-400.5 R201.25 T700 B-450.125 H1035\n" in made.text
    table["platform"]["plane"]["gcode_zero"] = None
    made = WALLS["polargraph"](Robot.model_validate(table))
    assert "M665 L-300.5 R301.25 T500 B-650.125 H1035\n" in made.text
    assert any("G-code in the world's coordinates" in each for each in made.lost)


def test_belts_are_said_to_differ_in_height_only_where_they_do(tmp_path: Path) -> None:
    file = tmp_path / "m.yaml"
    text = MASLOW.format(vertical="true")
    for heights, differ in ((("100.3", "56.3", "34.2", "78.3"), True), (("100.3",) * 4, False)):
        own = text
        for before, now in zip(("100.3", "56.3", "34.2", "78.3"), heights, strict=True):
            own = own.replace(f"Z: {before}", f"Z: {now}")
        file.write_text(own)
        (note,) = [each for each in read_maslow(file).assumed if each.startswith("lines.platform_point")]
        assert "100.3 mm out of the board" in note
        assert ("differ" in note) is differ


def test_a_belt_behind_the_board_is_rejected(tmp_path: Path) -> None:
    file = tmp_path / "m.yaml"
    file.write_text(MASLOW.format(vertical="true").replace("tlZ: 100.3", "tlZ: -100.3"))
    with pytest.raises(InputError, match=r"tlZ = -100\.3: must be 0 mm or more"):
        read_maslow(file)


def test_a_zero_that_a_maslow_does_not_have_is_noted(tmp_path: Path) -> None:
    robot = of(tmp_path / "m", *FILES["maslow that lies"])
    assert not any("gcode_zero" in each for each in WALLS["maslow"](robot).lost)
    table = robot.model_dump(by_alias=True)
    x, y, _ = table["platform"]["plane"]["gcode_zero"]
    table["platform"]["plane"]["gcode_zero"] = (x + 0.01, y - 0.02, 0.0)
    lost = WALLS["maslow"](Robot.model_validate(table)).lost
    assert any("add 10 mm to X and -20 mm to Y of G-code" in each for each in lost)


@pytest.mark.parametrize("target", ["wallplotter", "polargraph"])
def test_a_lean_that_the_format_does_not_have_is_noted(target: str, tmp_path: Path) -> None:
    robot = of(tmp_path / "c", *FILES["maslow-classic"])
    assert any("leans by 15 degrees" in each for each in WALLS[target](robot).lost)
    assert not any("leans" in each for each in WALLS["maslow-classic"](robot).lost)


def test_anchors_that_are_no_corners_are_rejected(tmp_path: Path) -> None:
    table = of(tmp_path / "m", *FILES["maslow that lies"]).model_dump(by_alias=True)
    for line, at in zip(table["lines"], ((1.0, 2.0), (4.0, 2.0), (0.0, 0.0), (0.9, 0.0)), strict=True):
        line["exit_point"] = (*at, 0.0)
    with pytest.raises(InputError, match="robot 'maslow': the top anchors are not above"):
        WALLS["maslow"](Robot.model_validate(table))


@pytest.mark.parametrize(
    ("target", "robot", "message"),
    [
        ("wallplotter", "hangprinter-v4", "no point platform in a platform.plane"),
        ("maslow", "wall-plotter", "2 lines on 2 winches; a Maslow 4 has 4"),
        ("polargraph", "maslow4", "4 lines on 4 winches"),
    ],
)
def test_robots_of_another_kind(target: str, robot: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        WALLS[target](load(robot))


def test_a_zero_aside_of_the_sheets_middle_is_no_classic_maslow() -> None:
    table = load("wall-plotter").model_dump(by_alias=True)
    table["platform"]["plane"]["gcode_zero"] = (0.1, 0.0, 0.8)
    with pytest.raises(InputError, match="origin in the middle of the sheet"):
        WALLS["maslow-classic"](Robot.model_validate(table))


def test_own_gcode_of_the_library_is_where_its_firmware_has_it() -> None:
    """Of FluidNC half the distance of the anchors below them; of a Maslow where the diagonals of its anchors meet."""
    text = WALLS["wallplotter"](load("wall-plotter")).text
    assert dict(re.findall(r"(\w+_anchor_\w): (\S+)", text)) == {
        "left_anchor_x": "-700", "left_anchor_y": "700", "right_anchor_x": "700", "right_anchor_y": "700"
    }  # fmt: skip
    assert not any("gcode_zero" in each for each in WALLS["maslow"](load("maslow4")).lost)


def test_two_heights_are_no_polargraph(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"0\.25 mm apart in height; .*export wallplotter"):
        WALLS["polargraph"](of(tmp_path / "p", *FILES["wallplotter"]))


def test_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["export", "maslow", "maslow4", "--out", "maslow.yaml"]) == 0
    assert run(["import", "maslow.yaml", "--out", "back.toml"]) == 0
    ours, back = load("maslow4"), loads(Path("back.toml").read_text())
    for line in back.lines:
        assert min(abs(_belt(ours, each) - _belt(back, line)) for each in ours.lines) < 1e-6  # of the file's normal
    np.testing.assert_allclose(_heights(back), _heights(ours), atol=5e-5)  # the library's lowest anchor is 35 um inside


def _heights(robot: Robot) -> list[tuple[float, float]]:
    """How far out of its board each belt begins and ends; by the belts' names, m."""
    height = robot.platform.plane.height
    lines = sorted(robot.lines, key=lambda each: each.name)
    return [(height(each.platform_point), height(each.exit_point)) for each in lines]


def _belt(robot: Robot, line: Line) -> float:
    """How long a belt is from its anchor to the sled 0.9 m up the board, m."""
    at = np.add(0.9 * np.array(robot.platform.plane.directions[1]), line.platform_point)
    return math.dist(line.exit_point, at)
