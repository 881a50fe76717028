"""Settings of a Maslow, and configurations of Klipper and RepRapFirmware: read, written, and read again."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import cablewright as cw
from cablewright.errors import InputError
from cablewright.exchange.formats import READ, ImportOptions, read_robot
from cablewright.exchange.klipper_config import klipper_anchors
from cablewright.exchange.robot_toml import robot_toml
from cablewright.exchange.rrf_config import rrf_config
from cablewright.exchange.translation import ImportedRobot
from cablewright.machine.drums import drums_of
from cablewright.robot import load, loads
from exchange.samples import KLIPPER, MASLOW, RRF

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
    """Distances between anchors are those of the file; the board leans, its normal out of it is up."""
    found = read(tmp_path, "maslow.yaml", MASLOW)
    robot = found.robot
    exits = {line.name: np.array(line.exit_point) for line in robot.lines}
    across = exits["top right"] - exits["top left"]
    assert np.linalg.norm(across) == pytest.approx(math.dist((25.4, 2080.0, 100.0), (3000.5, 2095.25, 56.0)) * 1e-3)
    assert across[0] == pytest.approx(2.9751)
    plane = robot.platform.plane
    assert plane is not None
    heights = {name: plane.height(at) for name, at in exits.items()}
    assert heights == pytest.approx({"top left": 0.1, "top right": 0.056, "bottom left": 0.034, "bottom right": 0.078})
    assert plane.across[2] == pytest.approx(math.sin(math.radians(15.0)))
    assert robot.freedoms == 2
    assert "maslow_calibration_grid_size: a robot file has no such key" in found.lost


def test_a_flat_maslow_feels_no_gravity_in_its_plane(tmp_path: Path) -> None:
    robot = read(tmp_path, "maslow.yaml", MASLOW.replace("vertical: true", "vertical: false")).robot
    assert robot.platform.plane is not None
    assert robot.platform.plane.across == (0.0, 0.0, 1.0)
    line = robot.lines[1]
    assert line.exit_point == (3.0005, 2.09525, 0.056)
    at = cw.inverse(robot, (1.5, 1.0, 0.0), cable="rigid")
    assert at.lengths[1] == pytest.approx(math.dist((1.5, 1.0, 0.0), (3.0005, 2.09525, 0.056)), abs=1e-9)


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
    lost = " ".join(found.lost)
    assert all(word in lost for word in ("M666 Y", "M666 L", "M666 H", "M666 J", "M669 P", "M669 S"))


def test_reprapfirmware_comes_back(tmp_path: Path) -> None:
    robot = read(tmp_path, "config.g", RRF).robot
    text = rrf_config(robot, drums_of(robot), None, 200, np.array([(0.3, -0.2, 0.1), (-0.3, 0.4, 0.6)])).text
    assert read(tmp_path, "config.g", text).robot == robot


def test_reprapfirmware_takes_the_height_of_the_last_anchor_alone(tmp_path: Path) -> None:
    assert read(tmp_path, "config.g", RRF.replace("D0:0:2345.0", "D2345")).robot.lines[3].exit_point == (0, 0, 2.345)


BAD = {
    "maslow mirrored": ("maslow.yaml", MASLOW.replace("trX: 3000.5", "trX: -3000.5"), "another handedness"),
    "maslow upside down": ("maslow.yaml", MASLOW.replace("tlY: 2080.0", "tlY: -2080.0"), "another handedness"),
    "maslow without an anchor": ("maslow.yaml", MASLOW.replace("Maslow_trY", "trY"), "has no Maslow_trY"),
    "maslow with a unit": ("maslow.yaml", MASLOW.replace("2080.0", "2080 mm"), "without a unit"),
    "maslow twice": ("maslow.yaml", MASLOW + "maslow_tlx: 3\n", "given twice"),
    "maslow neither": ("maslow.yaml", MASLOW.replace("vertical: true", "vertical: yes"), "must be true or false"),
    "klipper of another kind": ("printer.cfg", KLIPPER.replace("winch", "delta"), "must be winch"),
    "klipper without a radius": ("printer.cfg", KLIPPER.replace("rotation_distance: 251.2\n", ""), "rotation_distance"),
    "klipper, two winches": ("printer.cfg", KLIPPER[: KLIPPER.index("[stepper_c]")], "at least 3"),
    "klipper, a gap": ("printer.cfg", KLIPPER.replace("stepper_b", "stepper_f"), "without the winches before it"),
    "klipper, section twice": ("printer.cfg", KLIPPER.replace("stepper_b", "stepper_a"), "is there twice"),
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
    "rrf, six anchors": ("config.g", RRF.replace("N4", "N6"), "must be 3 to 5 anchors"),
    "rrf, half an anchor": ("config.g", RRF.replace("A0.0:-1604.5:-114.08", "A0.0:-1604.5"), "must be X:Y:Z in mm"),
    "rrf, no anchor": ("config.g", RRF.replace("C-1440.27:741.63:-161.23 ", ""), "has no C"),
    "rrf, few radii": ("config.g", RRF.replace(":64.673", ""), "has 3 values; there are 4 anchors"),
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


def test_formats_are_found_by_ending(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="of no known ending"):
        read(tmp_path, "robot.dat", "")
    with pytest.raises(InputError, match="a second file; WireX has one"):
        read_robot([tmp_path / "a.wcrfx", tmp_path / "b.wcrfx"])
    with pytest.raises(InputError, match="only a CASPR model"):
        read_robot([tmp_path / "a.wcrfx"], options=ImportOptions(cable_set="a"))
    assert all(each.carried for each in READ.values())


def test_firmware_that_has_no_such_line() -> None:
    for name, words in (("cogiro", "a body that rotates"), ("wang2021", "not straight from an eyelet")):
        for write in (klipper_anchors, lambda robot: rrf_config(robot, (), None, 200, np.zeros((2, 3)))):
            with pytest.raises(InputError, match=words if name == "wang2021" else f"{words}|has 8 lines"):
                write(load(name))
