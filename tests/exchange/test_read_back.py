"""WireX files and Klipper's winch sections, read by small readers of their own: geometry and lengths."""

from __future__ import annotations

import configparser
import math
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

import cablewright as cw
from cablewright.exchange.firmware import firmware
from cablewright.exchange.wirex_output import wirex
from cablewright.foundation.errors import InputError
from cablewright.live.rest_pose import rest_pose
from cablewright.models.statics import Model
from cablewright.printing.job import load_job
from cablewright.robot import Robot, library_names, load


def numbers(element: ET.Element, names: str) -> np.ndarray:
    return np.array([float(element.attrib[name]) for name in names.split()])


def wirex_length(base: ET.Element, end: np.ndarray) -> float:
    """Length from a chain's base point to a point of the world: over a wheel that swivels about its third axis.

    WireLib's standard roller: the cable comes along the third column of the base's rotation and leaves a wheel of that
    radius, whose centre turns about the axis towards the platform.
    """
    a, r = numbers(base, "x y z"), float(base.attrib["radius"])
    axis = numbers(base, "a13 a23 a33")
    away = end - a
    height = float(axis @ away)
    reach = float(np.linalg.norm(away - height * axis)) - r
    apart = math.hypot(reach, height)
    if r == 0.0:
        return apart
    # angle of the wheel that the cable touches: from where it comes, towards the axis, to the tangent
    free = math.sqrt(apart**2 - r**2)
    wrapped = math.pi - (math.atan2(height, reach) + math.acos(r / apart))
    return free + r * (wrapped % (2.0 * math.pi))


@pytest.mark.parametrize("name", library_names())
def test_wirex(name: str) -> None:
    robot = load(name)
    try:
        made = wirex(robot)
    except InputError:
        return
    root = ET.fromstring(made.text)
    chains = root.findall("robot/geometry/chain")
    assert [chain.attrib["id"] for chain in chains] == [line.name for line in robot.lines]
    at = rest_pose(Model.of(robot, cable="rigid")).equilibrium
    bare = [line.model_copy(update={"winch_exit": None, "guides": (), "dead_length": 0.0}) for line in robot.lines]
    lengths = at.lengths  # of fewer lines than degrees of freedom, which have no winch exit
    if robot.m >= robot.n:
        lengths = cw.inverse(robot.model_copy(update={"lines": tuple(bare)}), at.pose, cable="rigid").lengths
    turn = np.eye(3) if robot.n == 3 else rotation(at.pose[3:])
    for chain, length in zip(chains, lengths, strict=True):
        base, platform = chain.find("base"), chain.find("platform")
        assert base is not None
        assert platform is not None
        columns = np.array([[float(base.attrib[f"a{i}{j}"]) for j in (1, 2, 3)] for i in (1, 2, 3)])
        np.testing.assert_allclose(columns.T @ columns, np.eye(3), atol=1e-12)
        assert np.linalg.det(columns) == pytest.approx(1.0)
        end = at.pose[:3] + turn @ numbers(platform, "x y z")
        assert wirex_length(base, end) == pytest.approx(length, abs=1e-9)
    body, cable = root.find("robot/platform"), root.find("cable")
    assert body is not None
    assert cable is not None
    assert float(body.attrib["mass"]) == robot.platform.mass
    stiffness = float(cable.attrib["elasticity"]) * math.pi * float(cable.attrib["radius"]) ** 2
    assert stiffness == pytest.approx(robot.lines[0].cable.stiffness)
    unknown = [key for key in ("max_speed", "drum_radius", "capacity") if getattr(robot.lines[0].winch, key) is None]
    said = " ".join(each for each in made.lost if "not known; 0 is written" in each)
    assert all(f"lines.winch.{key}" in said for key in unknown)


def test_wirex_has_no_counterweights() -> None:
    table = load("ipanema1").model_dump(by_alias=True)
    first = table["lines"][0] | {"counterweight": 3.0, "winch": {}}
    with pytest.raises(InputError, match=r"has a counterweight; not supported\. Give each line a winch"):
        wirex(Robot.model_validate(table | {"lines": [first, *table["lines"][1:]]}))


def rotation(vector: np.ndarray) -> np.ndarray:
    """Rodrigues' formula."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = vector / angle
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * k + (1.0 - math.cos(angle)) * k @ k


def test_klipper_computes_the_lengths_of_printer_winch(tmp_path: Path) -> None:
    """Klipper: a winch's position is the distance to its anchor, and a turn of it is rotation_distance."""
    robot = load("hangprinter-v4")
    robot = robot.model_copy(update={"lines": tuple(x.model_copy(update={"advantage": 1}) for x in robot.lines)})
    assert isinstance(robot, Robot)
    (tmp_path / "a.gcode").write_text(";LAYER:0\nG1 X-100 Y-100 Z200 F9000\nG1 X100 Y100 E9\n")
    made = firmware("klipper", robot, load_job(tmp_path / "a.gcode"))
    config = configparser.ConfigParser(inline_comment_prefixes=("#", ";"))
    config.read_string(made.files["printer-winch.cfg"])
    assert config["printer"]["kinematics"] == "winch"
    at = np.array([120.0, -230.0, 340.0])
    lengths = cw.inverse(robot, 1e-3 * at, cable="rigid").lengths
    for letter, line, length in zip("abcd", robot.lines, lengths, strict=True):
        stepper = config[f"stepper_{letter}"]
        anchor = np.array([float(stepper[f"anchor_{axis}"]) for axis in "xyz"])
        turns = float(np.linalg.norm(at - anchor)) / float(stepper["rotation_distance"])
        radius = line.winch.drum_radius
        assert radius is not None
        assert turns == pytest.approx(length / (2.0 * math.pi * radius), rel=1e-12)
    assert any(each.startswith("printer-winch.cfg: lines.cable") for each in made.lost)
