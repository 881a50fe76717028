"""Settings of a Maslow, and configurations of Klipper and RepRapFirmware: read, written, and read again."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import cablewright as cw
from cablewright.exchange.formats import READ, ImportOptions, read_robot
from cablewright.exchange.klipper_config import klipper_anchors
from cablewright.exchange.robot_toml import robot_toml
from cablewright.exchange.rrf_config import rrf_config
from cablewright.exchange.translation_result import ImportedRobot
from cablewright.foundation.errors import InputError
from cablewright.machine.drums import drums_of
from cablewright.robot import load, loads
from exchange.samples import FORK, KLIPPER, MASLOW, RRF, wirex

FILES = {"maslow.yaml": MASLOW, "printer.cfg": KLIPPER, "config.g": RRF}


def read(folder: Path, name: str, text: str) -> ImportedRobot:
    (folder / name).write_text(text)
    return read_robot([folder / name])


@pytest.mark.parametrize("name", FILES)
def test_the_toml_loads_as_the_robot(name: str, tmp_path: Path) -> None:
    found = read(tmp_path, name, FILES[name])
    assert loads(robot_toml(found, "cablewright import")) == found.robot
    assert found.assumed


def test_maslow(tmp_path: Path) -> None:
    """Distances between anchors are those of the file; belts fall by its Z, and so press the sled onto the board."""
    found = read(tmp_path, "maslow.yaml", MASLOW)
    robot = found.robot
    exits = {line.name: np.array(line.exit_point) for line in robot.lines}
    across = exits["top right"] - exits["top left"]
    assert np.linalg.norm(across) == pytest.approx(math.dist((25.4, 2080.0, 100.0), (3000.5, 2095.25, 56.0)) * 1e-3)
    assert across[0] == pytest.approx(2.9751)
    plane = robot.platform.plane
    assert plane is not None
    (sled,) = {line.platform_point for line in robot.lines}
    falls = {name: plane.height(sled) - plane.height(at) for name, at in exits.items()}
    assert falls == pytest.approx({"top left": 0.1, "top right": 0.056, "bottom left": 0.034, "bottom right": 0.078})
    assert plane.height(sled) == pytest.approx(0.1)
    held = cw.inverse(robot, robot.platform.plane.gcode_zero, cable="rigid").checked()
    pulls = np.sum([held.tensions[i] * (exits[line.name] - held.pose - sled) / held.lengths[i]
                    for i, line in enumerate(robot.lines)], axis=0)  # fmt: skip
    assert pulls @ plane.across < 0.0
    assert plane.across[2] == pytest.approx(math.sin(math.radians(15.0)))
    assert robot.freedoms == 2
    assert "maslow_calibration_grid_size: a robot file has no such key" in found.lost
    assert found.robot.platform.plane is not None
    assert found.robot.platform.plane.one_sided  # a board pushes, and does not pull


def test_a_flat_maslow_has_no_gravity_in_its_plane(tmp_path: Path) -> None:
    robot = read(tmp_path, "maslow.yaml", MASLOW.replace("vertical: true", "vertical: false")).robot
    assert robot.platform.plane is not None
    assert robot.platform.plane.across == (0.0, 0.0, 1.0)
    line = robot.lines[1]
    assert line.exit_point == pytest.approx((3.0005, 2.09525, 0.044))
    at = cw.inverse(robot, (1.5, 1.0, 0.0), cable="rigid")
    assert at.lengths[1] == pytest.approx(math.dist((1.5, 1.0, 0.056), (3.0005, 2.09525, 0.0)), abs=1e-9)


def test_klipper(tmp_path: Path) -> None:
    found = read(tmp_path, "printer.cfg", KLIPPER)
    robot = found.robot
    assert [line.name for line in robot.lines] == ["A", "B", "C", "D"]
    assert robot.lines[0].exit_point == (0.0, -2.00025, -0.1)
    assert robot.lines[0].winch.drum_radius == pytest.approx(0.04, abs=1e-10)
    assert "stepper.step_pin: a robot file has no such key" in found.lost
    again = read(tmp_path, "printer.cfg", klipper_anchors(robot).text)
    assert again.robot == robot
    assert again.lost == ()


def test_reprapfirmware(tmp_path: Path) -> None:
    found = read(tmp_path, "config.g", RRF)
    robot = found.robot
    assert [line.name for line in robot.lines] == ["A", "B", "C", "D"]
    assert robot.lines[3].exit_point == (0.0, 0.0, 2.345)
    assert [line.advantage for line in robot.lines] == [2, 2, 2, 4]
    assert [line.winch.drum_radius for line in robot.lines] == [0.065239, 0.065135, 0.065296, 0.064673]
    assert [line.tension_limits for line in robot.lines] == [(0.0, 35.0)] * 3 + [(2.5, 30.0)]
    assert {line.cable.stiffness for line in robot.lines} == {20000.0}
    assert robot.platform.mass == 2.5
    growth = [2.0 * line.winch.build_up * line.winch.drum_radius**2 for line in robot.lines]
    np.testing.assert_allclose(growth, 0.0356e-3, rtol=1e-12)
    assert [line.winch.drum_length for line in robot.lines][3] == 4 * 2.345
    assert robot.lines[0].winch.drum_length == pytest.approx(2 * math.hypot(1.6045, 0.11408) + 0.1, rel=1e-14)
    lost = " ".join(found.lost)
    assert all(word in lost for word in ("M666 L", "M666 H", "M666 J", "M669 P", "M669 S"))
    assert [line.dead_length for line in robot.lines] == [0.1, 0.1, 0.1, 0.0]


def test_reprapfirmware_comes_back(tmp_path: Path) -> None:
    robot = read(tmp_path, "config.g", RRF).robot
    text = rrf_config(robot, drums_of(robot), None, 200, np.array([(0.3, -0.2, 0.1), (-0.3, 0.4, 0.6)])).text
    assert read(tmp_path, "config.g", text).robot == robot


def test_reprapfirmware_takes_the_height_of_the_last_anchor_alone(tmp_path: Path) -> None:
    assert read(tmp_path, "config.g", RRF.replace("D0:0:2345.0", "D2345")).robot.lines[3].exit_point == (0, 0, 2.345)


def steps_of_the_fork(apart: float, spans: int, rotation_distance: float, growth: float) -> float:
    """Turns of a spool, from the origin, by the fork's law: mm of its lines are of the nozzle, not of the cable."""
    radius = rotation_distance * spans / (2 * math.pi)
    k2 = -growth * spans
    return 2 / rotation_distance * radius / k2 * (math.sqrt(radius**2 + apart * k2) - radius)


def test_klipper_of_hangprinters(tmp_path: Path) -> None:
    """Each winch turns as by the law of the fork; forces there are of all spans."""
    found = read(tmp_path, "printer.cfg", FORK)
    robot = found.robot
    assert robot.platform.mass == 1.5
    assert [line.advantage for line in robot.lines] == [2, 2, 3, 4]
    assert [line.tension_limits for line in robot.lines] == [(0.0, 30.0), (2.0, 40.0), (0.0, 20.0), (2.0, 30.0)]
    assert {line.cable.stiffness for line in robot.lines} == {25000.0}
    assert [line.dead_length for line in robot.lines] == [0.0, 1.0, 0.0, 0.5]
    for drum, line, turn in zip(drums_of(robot), robot.lines, (220, 220, 150, 110), strict=True):
        origin = math.hypot(*line.exit_point) * line.advantage + line.dead_length
        for apart in (-300.0, 40.0, 250.0):
            length = origin + 1e-3 * apart * line.advantage
            angles = drum.angles(np.array([origin, length]))
            assert (angles[1] - angles[0]) / (2 * math.pi) == pytest.approx(
                steps_of_the_fork(apart, line.advantage, turn, 0.04), rel=1e-9
            )
    lost = " ".join(found.lost)
    assert "stepper.gear_ratio: a machine file has it" in lost
    assert "printer.max_velocity: a job has it" in lost
    assert not any(key in lost for key in ("weight", "advantage", "buildup", "spring", "max_force", "guy"))
    assert not any("platform.mass" in each or "tension_limits" in each for each in found.assumed)


def test_reprapfirmware_before_m666(tmp_path: Path) -> None:
    """R, Q, U and O were letters of M669, and M669 W no weight; X, Y and Z of M666 were end switches."""
    text = """M669 K6
M669 A0.0:-1500.0:-110.0 B1300.0:1200.0:-110.0 C-1300.0:800.0:-110.0 D2200.0 P1000
M669 Q0.05 R60:60:60:61 U4:4:4:3 L20:20:20:20 W7500:7500:7500:4000
M666 X0 Y0 Z0
"""
    found = read(tmp_path, "config.g", text)
    robot = found.robot
    assert [line.advantage for line in robot.lines] == [4, 4, 4, 3]
    assert [line.winch.drum_radius for line in robot.lines] == [0.06, 0.06, 0.06, 0.061]
    assert [line.cables for line in robot.lines] == [2, 2, 2, 3]
    assert all(line.dead_length == 0.0 for line in robot.lines)
    assert 2.0 * robot.lines[0].winch.build_up * 0.06**2 == pytest.approx(2 * 0.05e-3)
    assert "platform.mass: 2 kg" in found.assumed
    assert "lines.cables: 2, 2, 2, 3, what RepRapFirmware of 2019 takes without O" in found.assumed
    lost = " ".join(found.lost)
    assert all(word in lost for word in ("M666 X: the end switch", "M669 W", "M669 P", "M666 L"))


def test_reprapfirmware_without_spools(tmp_path: Path) -> None:
    """The firmware's default values replace missing ones of a file."""
    found = read(tmp_path, "config.g", RRF.replace("Q0.0356 R65.239:65.135:65.296:64.673", "W2.5"))
    assert {line.winch.drum_radius for line in found.robot.lines} == {0.075}
    assert found.robot.lines[0].winch.build_up == pytest.approx(0.5 * 0.007e-3 / 0.075**2)
    assert any("winch.drum_radius: 75 mm, what RepRapFirmware takes" in each for each in found.assumed)


SECTION = """name: Own
Maslow_vertical: false
Maslow_tlX: 1.0
kinematics:
  MaslowKinematics:
    tlX: 25.4
    tlY: 2080.0
    tlZ: 100.0
    trX: 3000.5
    trY: 2095.25
    trZ: 56.0
    blZ: 34.0
    brX: 3010.0   # measured
    brY: 0
    brZ: 78.0
    armLength: 123.4
    fixedZ: true
    maxSegmentLength: 5
axes:
  x:
    tlX: 7.0
"""


def test_maslow_of_2025(tmp_path: Path) -> None:
    """Anchors in a section of kinematics are those of the old layout; earlier values are reported as replaced."""
    old = read(tmp_path, "maslow.yaml", MASLOW.replace("vertical: true", "vertical: false")).robot
    found = read(tmp_path, "maslow.yaml", SECTION)
    assert found.robot.lines == old.lines
    lost = " ".join(found.lost)
    assert all(f"{key}: " in lost for key in ("armLength", "fixedZ", "maxSegmentLength"))
    assert "Maslow_tlX: the anchors of MaslowKinematics are read" in found.lost
    raised = read(tmp_path, "maslow.yaml", SECTION.replace("fixedZ: true", "workThickness: 12"))
    falls = [[line.platform_point[2] - line.exit_point[2] for line in robot.lines] for robot in (raised.robot, old)]
    assert falls[0] == pytest.approx([each + 0.012 for each in falls[1]], abs=1e-12)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("kinematics:\n  parallel_delta:\n", "is a FluidNC configuration with kinematics: 'parallel_delta'"),
        ("kinematics:\n  CoreXY:\n", "is a FluidNC configuration with kinematics: 'CoreXY'"),
        ("winch:\n  ros__parameters:\n    rate: 3\n", "is a file of ROS parameters"),
        ("points:\n- frame: [1, 2]\n  platform: 3\nname: hall\n", "is YAML with 'points', 'name'"),
        ("", "has no keys"),
    ],
)
def test_other_yaml_is_named(text: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"import reads WireX .*Maslow \(\.yaml, \.yml\).*Klipper") as caught:
        read(tmp_path, "machine.yaml", text)
    assert words in str(caught.value)
    with pytest.raises(InputError, match="a Maslow's settings have Maslow_tlX and so on, or kinematics"):
        read_robot([tmp_path / "machine.yaml"], "maslow")


BAD = {
    "maslow mirrored": ("maslow.yaml", MASLOW.replace("trX: 3000.5", "trX: -3000.5"), "another handedness"),
    "maslow upside down": ("maslow.yaml", MASLOW.replace("tlY: 2080.0", "tlY: -2080.0"), "another handedness"),
    "maslow without an anchor": ("maslow.yaml", MASLOW.replace("Maslow_trY", "trY"), "has no Maslow_trY"),
    "maslow with a unit": ("maslow.yaml", MASLOW.replace("2080.0", "2080 mm"), "without a unit"),
    "maslow twice": ("maslow.yaml", MASLOW + "maslow_tlx: 3\n", "given twice"),
    "maslow neither": ("maslow.yaml", MASLOW.replace("vertical: true", "vertical: yes"), "must be true or false"),
    "maslow section without an anchor": (
        "maslow.yaml", SECTION.replace("trY", "trW"), "has no trY, the top right anchor's y, mm in kinematics"
    ),
    "maslow section, twice": ("maslow.yaml", SECTION.replace("brY: 0", "brX: 0"), "brX is given twice"),
    "fork, too few": ("printer.cfg", FORK.replace("2, 2, 3, 4", "2, 2, 3"), "must be 4 values, one for each winch"),
    "fork, advantage": ("printer.cfg", FORK.replace("2, 2, 3, 4", "2, 2, 0, 4"), "must be a whole number, 1 or more"),
    "fork, weight": ("printer.cfg", FORK.replace("weight: 1.5", "weight: -1.5"), "must be at least 0"),
    "fork, a tiny drum": ("printer.cfg", FORK.replace("distance: 220", "distance: 1e-190"), "build_up"),
    "fork, nan": ("printer.cfg", FORK.replace("25000", "nan"), "winch_spring_constant = 'nan'"),
    "klipper of another kind": ("printer.cfg", KLIPPER.replace("winch", "delta"), "must be winch"),
    "klipper without a radius": ("printer.cfg", KLIPPER.replace("rotation_distance: 251.2\n", ""), "rotation_distance"),
    "klipper, two winches": ("printer.cfg", KLIPPER[: KLIPPER.index("[stepper_c]")], "at least 3"),
    "klipper, a gap": ("printer.cfg", KLIPPER.replace("stepper_b", "stepper_f"), "without the winches before it"),
    "klipper, section twice": ("printer.cfg", KLIPPER.replace("stepper_b", "stepper_a"), "occurs twice"),
    "klipper, nan": ("printer.cfg", KLIPPER.replace("anchor_z: 3000", "anchor_z: nan"), "stepper_d.anchor_z = 'nan'"),
    "klipper, negative": ("printer.cfg", KLIPPER.replace("251.3", "-251.3"), "must be over 0 mm"),
    "klipper, two in one place": (
        "printer.cfg", KLIPPER.replace("anchor_x: 0\n", "anchor_x:\n"), "must be a finite number"
    ),
    "klipper in m": (
        "printer.cfg",
        KLIPPER.replace("2000", "2").replace("1000", "1").replace("3000", "3").replace("-100", "-0.1"),
        "at least 0.05 m is read",
    ),
    "rrf of another kind": ("config.g", RRF.replace("K6", "K1"), "no M669 K6"),
    "rrf, ten anchors": ("config.g", RRF.replace("N4", "N10"), "must be 3 to 5 anchors"),
    "rrf, half an anchor": ("config.g", RRF.replace("A0.0:-1604.5:-114.08", "A0.0:-1604.5"), "must be X:Y:Z in mm"),
    "rrf, no anchor": ("config.g", RRF.replace("C-1440.27:741.63:-161.23 ", ""), "has no C"),
    "rrf, few radii": ("config.g", RRF.replace(":64.673", ""), "has 3 values; give one for each of the 4 anchors"),
    "rrf, advantage": ("config.g", RRF.replace("U2:2:2:4", "U2:2:2:2.5"), "must be a whole number"),
    "rrf, no spool": ("config.g", RRF.replace("R65.239", "R0"), "drum_radius"),
    "rrf, build-up": ("config.g", RRF.replace("Q0.0356", "Q-0.03"), "must be 0 mm or more"),
    "rrf, stiffness": ("config.g", RRF.replace("S20000", "S-20000"), "must be over 0 N"),
    "rrf, unit": ("config.g", RRF.replace("A0.0:-1604.5:-114.08", "A0.0:-1604.5:-114.08mm"), "config.g"),
}  # fmt: skip


@pytest.mark.parametrize("what", BAD)
def test_bad_files_are_one_line(what: str, tmp_path: Path) -> None:
    name, text, words = BAD[what]
    with pytest.raises(InputError, match=r"^[^\n]*$") as caught:
        read(tmp_path, name, text)
    assert words in str(caught.value)
    assert name in str(caught.value)


def test_formats_are_found_by_content(tmp_path: Path) -> None:
    """Whatever a file's name ends in; one of unknown content is rejected with the readable formats."""
    for name, text in FILES.items():
        for other in ("robot.txt", *FILES):
            assert read(tmp_path, other, text).format == read(tmp_path, name, text).format
    with pytest.raises(InputError, match=r"no format is known .*--format names one of WireX \(\.wcrfx\), CASPR"):
        read(tmp_path, "robot.dat", "")
    assert read(tmp_path, "robot.xml", '<?xml version="1.0"?>' + wirex()).format == "WireX 0.32"
    (tmp_path / "a.wcrfx").write_text("<models/>")
    with pytest.raises(InputError, match="a second file; WireX has one"):
        read_robot([tmp_path / "a.wcrfx", tmp_path / "b.wcrfx"])
    with pytest.raises(InputError, match="only a CASPR model"):
        read_robot([tmp_path / "a.wcrfx"], options=ImportOptions(cable_set="a"))
    assert all(each.carried for each in READ.values())


def test_firmware_that_has_no_such_line() -> None:
    for name in ("cogiro", "wang2021"):
        for write in (klipper_anchors, lambda robot: rrf_config(robot, (), None, 200, np.zeros((2, 3)))):
            with pytest.raises(InputError, match="has a swivel as its sheave; not supported"):
                write(load(name))
