"""WireX files of both versions: what is carried, what is named as lost, and round trips."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import cablewright as cw
from cablewright.exchange.robot_toml import robot_toml
from cablewright.exchange.translation_result import ImportedRobot
from cablewright.exchange.wirex import VERSIONS, read_wirex
from cablewright.exchange.wirex_output import wirex
from cablewright.foundation.errors import InputError
from cablewright.robot import Robot, library_names, load, loads
from exchange import samples


def read(folder: Path, text: str) -> ImportedRobot:
    path = folder / "own.wcrfx"
    path.write_text(text)
    return read_wirex(path)


@pytest.fixture
def own(tmp_path: Path) -> ImportedRobot:
    return read(tmp_path, samples.wirex())


def test_all_features_are_carried(own: ImportedRobot) -> None:
    robot = own.robot
    assert (robot.name, robot.description, robot.source) == ("own", "a test", "someone")
    assert robot.n == 6
    assert [line.exit_point for line in robot.lines] == samples.EXITS
    assert [line.platform_point for line in robot.lines] == samples.ENDS
    assert [line.name for line in robot.lines] == [str(k) for k in range(1, 9)]
    kinds = [line.sheave.kind for line in robot.lines]
    assert kinds == ["swivel", "swivel", "eyelet", *["swivel"] * 5]
    assert robot.lines[1].sheave.axis == (0.8, 0.0, 0.6)
    assert [robot.lines[k].sheave.wrap for k in (0, 4, 7)] == ["over", "under", "under"]
    line, platform = robot.lines[0], robot.platform
    assert line.tension_limits == (12.0, 720.0)
    assert (line.winch.drum_radius, line.winch.max_speed, line.winch.capacity) == (0.045, 1.5, 25.0)
    assert line.cable.stiffness == pytest.approx(7.5e10 * np.pi * 0.0015**2)
    assert (line.cable.linear_density, line.cable.breaking_load, line.cable.diameter) == (0.0091, 9000.0, 0.003)
    assert (platform.mass, platform.centre_of_mass) == (31.5, (0.01, 0.0, 0.2))
    assert (platform.inertia, platform.inertia_products) == ((2.0, 3.0, 4.0), (0.1, 0.0, 0.0))


@pytest.mark.parametrize("version", VERSIONS)
def test_what_is_not_carried_is_named(version: str, tmp_path: Path) -> None:
    lost = " ".join(read(tmp_path, samples.wirex(version)).lost)
    theirs = ["controller.ipo_clock", "swing_angle", "damping", "max_length", "meter_cost", "material", "max_jerk"]
    theirs += ["motor_type", "motor.inertia", "l_drum", "a11 to a32"]
    theirs += ["cable.min_length"] if version == "0.32" else ["inertiatensor.Ixx"]
    assert [each for each in theirs if each not in lost] == []


def test_every_attribute_is_read_or_named(tmp_path: Path) -> None:
    """A mark put on any attribute of the file changes the robot, or is named as lost, or is an error."""
    import re

    text = samples.wirex(cable=samples.CABLE.format(more="min_length='2'"))
    before = read(tmp_path, text)
    lost = " ".join(before.lost)
    silent = {"id", "generator", "winchtype", "name", "description"}  # of parts, and of who wrote the file
    for match in re.finditer(r"(\w+)='(-?[0-9.e]+)'", text):
        if match[1] in silent or match[1] in lost:
            continue
        changed = text[: match.start(2)] + repr(float(match[2]) + 0.015625) + text[match.end(2) :]
        try:
            after = read(tmp_path, changed)
        except InputError:
            continue
        assert after.robot != before.robot or after.lost != before.lost, match[0]


@pytest.mark.parametrize("version", VERSIONS)
def test_round_trip_is_the_identity(version: str, tmp_path: Path) -> None:
    first = read(tmp_path, samples.wirex(version)).robot
    again = read(tmp_path, wirex(first, version).text).robot
    assert again == first


def test_the_toml_loads_as_the_robot(own: ImportedRobot) -> None:
    text = robot_toml(own, "cablewright import")
    assert loads(text) == own.robot
    assert all(f"# lost: {each}\n" in text for each in own.lost)
    assert all(f"# assumed: {each}\n" in text for each in own.assumed)


def refusal_of(robot: Robot) -> str:
    """What a WireX file cannot describe of a robot, as it is said; empty if nothing."""
    lines = robot.lines
    if robot.platform.plane is not None:
        return "platform.plane; not supported"
    if any(line.sheave.kind not in ("eyelet", "swivel") for line in lines):
        return "a universal joint; not supported|a pulley in a fixed plane; not supported"
    if any(line.advantage > 1 for line in lines):
        return "an advantage over 1; not supported"
    if any(line.platform_sheave is not None for line in lines):
        return "on the platform; not supported"
    if len({line.cable for line in lines}) > 1:
        return "lines with different cables; not supported"
    return "different minimum tensions" if len({line.tension_limits[0] for line in lines}) > 1 else ""


@pytest.mark.parametrize("name", library_names())
def test_library_robots(name: str, tmp_path: Path) -> None:
    """What the format can describe comes back with the same geometry and the same cable; else it is rejected by
    name."""
    robot = load(name)
    if refused := refusal_of(robot):
        with pytest.raises(InputError, match=refused):
            wirex(robot)
        return
    found = wirex(robot)
    again = read(tmp_path, found.text).robot
    for line, other in zip(robot.lines, again.lines, strict=True):
        assert (other.exit_point, other.platform_point) == (line.exit_point, line.platform_point)
        assert (other.sheave.kind, other.tension_limits) == (line.sheave.kind, line.tension_limits)
        assert other.cable.stiffness == pytest.approx(line.cable.stiffness, rel=1e-14)
    assert again.platform.mass == robot.platform.mass
    if any(line.winch_exit is not None for line in robot.lines):
        assert any("winch_exit" in each for each in found.lost)


def length_over_swivel(exit_point: np.ndarray, axis: np.ndarray, radius: float, end: np.ndarray) -> float:
    """Arc and span over a sheave that swivels about *axis*, along which the cable comes, by the angle at its centre."""
    away = end - exit_point
    height = away @ axis
    level = np.linalg.norm(away - height * axis)
    if radius == 0.0:
        return float(np.linalg.norm(away))
    x, z = level - radius, height  # from the centre of the wheel
    span = np.sqrt(x * x + z * z - radius * radius)
    # the cable leaves where the radius is across the span; it touched at the angle pi
    leaves = np.arctan2(z, x) + np.arccos(radius / np.hypot(x, z))
    return float(span + radius * (np.pi - leaves))


def lengths(robot: Robot, pose: np.ndarray) -> np.ndarray:
    from scipy.spatial.transform import Rotation

    turn, found = Rotation.from_rotvec(pose[3:]), []
    for line in robot.lines:
        axis = np.array(getattr(line.sheave, "axis", (0.0, 0.0, 1.0)), float)
        axis *= (-1.0 if getattr(line.sheave, "wrap", "over") == "under" else 1.0) / np.linalg.norm(axis)
        end = pose[:3] + turn.apply(line.platform_point)
        found.append(length_over_swivel(np.array(line.exit_point), axis, getattr(line.sheave, "radius", 0.0), end))
    return np.array(found)


def test_lengths_agree_with_an_independent_formula(own: ImportedRobot) -> None:
    for pose in ([0.0, 0.0, 1.2, 0, 0, 0], [0.4, -0.3, 1.0, 0.1, -0.05, 0.2], [-0.7, 0.2, 1.6, 0, 0.1, -0.3]):
        ours = cw.inverse(own.robot, pose, cable="rigid").lengths
        np.testing.assert_allclose(ours, lengths(own.robot, np.array(pose)), atol=1e-9, rtol=0)


@pytest.mark.parametrize("name", ["ipanema1", "ipanema2", "ipanema3", "expo2015-lucia", "caroca"])
def test_lengths_of_standard_robots_agree_with_that_formula(name: str) -> None:
    """Sheaves that cables come to from below, and from above."""
    robot = load(name)
    low, high = np.array(robot.scene.frame_min), np.array(robot.scene.frame_max)
    for share in (0.3, 0.45, 0.6):
        pose = np.array([*(low + share * (high - low)), 0.05, -0.1 * share, 0.08])
        ours = cw.inverse(robot, pose, cable="rigid").lengths
        np.testing.assert_allclose(ours, lengths(robot, pose), atol=1e-9, rtol=0)


BAD = {
    "entity bomb": (
        '<!DOCTYPE m [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]><models version="0.32">&b;</models>',
        "entities are not supported",
    ),
    "external entity": ('<!DOCTYPE m [<!ENTITY a SYSTEM "file:///etc/passwd">]><models>&a;</models>', "entities"),
    "entity of an external type": ('<!DOCTYPE m SYSTEM "http://h/m.dtd"><models>&a;</models>', "the entity 'a'"),
    "default": ("<!DOCTYPE m [<!ATTLIST m a CDATA 'x'>]><models version='0.32'/>", "default value"),
    "cut short": (samples.wirex()[:900], "not well-formed"),
    "attribute twice": (samples.wirex().replace("motionpattern=", "name='b' motionpattern="), "not well-formed"),
    "deep": ("<models version='0.32'>" + "<a>" * 40, "nested deeper"),
    "another root": ("<robots/>", "root element <robots>: must be <models>"),
    "encoding": ('<?xml version="1.0" encoding="klingon"?><models/>', "encoding"),
    "newer": (samples.wirex("0.40"), "must be 0.31 or 0.32"),
    "no version": (samples.wirex().replace("version='0.32'", ""), "no attribute 'version'"),
    "not finite": (samples.wirex(platform="mass='nan'"), "platform.mass = 'nan'"),
    "unit in the number": (samples.wirex(platform="mass='31 kg'"), "without a unit"),
    "no mass": (samples.wirex(platform=""), "no attribute 'mass'"),
    "negative stiffness": (samples.wirex(cable=samples.CABLE.replace("7.5e10", "-7.5e10")), "cable.elasticity"),
    "negative radius": (samples.wirex(chains=samples.CHAINS.replace("radius='0.05'", "radius='-1'", 1)), "base.radius"),
    "two of one name": (
        samples.wirex(chains=samples.chain("1", (0, 0, 1), (0, 0, 0)) + samples.chain("1", (1, 0, 1), (0.1, 0, 0))),
        "2 lines are named '1'",
    ),
    "mirrored": (
        samples.wirex(chains=samples.chain("1", (0, 0, 1), (0, 0, 0), samples.MIRRORED)),
        "left-handed axes",
    ),
    "no rotation": (
        samples.wirex(chains=samples.chain("1", (0, 0, 1), (0, 0, 0), samples.DOWN.replace("0.6", "0.7"))),
        "no rotation",
    ),
    "planar": (samples.wirex(pattern="1R2T"), "must be 3R3T or 3T"),
    "no lines": (samples.wirex(chains=""), "no <chain>"),
    "no cable": (samples.wirex(cable="", winch=""), "give --cable"),
    "another winch": (
        samples.wirex(winch=samples.WINCH.replace("name='drum'", "name='a'") + samples.WINCH.replace("'drum'", "'b'")),
        "winchtype = 'drum'",
    ),
    "skew tensor": (samples.wirex().replace("Iyx='0.1'", "Iyx='0.2'"), "a tensor is symmetric"),
    "millimetres": (
        samples.wirex(
            chains="".join(
                samples.chain(str(k), [1e3 * each for each in a], [1e3 * each for each in b])
                for k, (a, b) in enumerate(zip(samples.EXITS, samples.ENDS, strict=True))
            )
        ),
        "at most 1000 m is read: are lengths in the unit of the format?",
    ),
    "no body": (samples.wirex().replace("Izz='4'", "Izz='9'"), "no body has these moments"),
}


@pytest.mark.parametrize("what", BAD)
def test_bad_files_are_one_line(what: str, tmp_path: Path) -> None:
    text, words = BAD[what]
    with pytest.raises(InputError, match=r"^[^\n]*$") as caught:
        read(tmp_path, text)
    assert words in str(caught.value)
    assert "own.wcrfx" in str(caught.value)


def test_large_files_are_not_read(tmp_path: Path) -> None:
    """A gigabyte that takes no disk: only as much as is allowed is read of it."""
    path = tmp_path / "huge.wcrfx"
    with path.open("wb") as file:
        file.truncate(1 << 30)
    with pytest.raises(InputError, match="larger than 4194304 bytes"):
        read_wirex(path)


def test_many_elements_are_rejected(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="more than 20000 elements"):
        read(tmp_path, "<models version='0.32'>" + "<a/>" * 30_000 + "</models>")
