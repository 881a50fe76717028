"""The first layer of the house as motion of winches, read again by small readers of their own."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

import cablewright as cw
from cablewright.exchange.firmware import Firmware, firmware
from cablewright.exchange.formats import read_robot
from cablewright.exchange.motion_export.klipper import Stepper
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.machine.files import load_machine
from cablewright.machine.settings import MachineSettings
from cablewright.printing.job import Job, load_job
from cablewright.robot import Robot, load

JOB = Path(__file__).parents[2] / "examples" / "house.toml"
MICROSTEP = math.tau / (200 * 16 * 50)  # rad of the drum, with the gear of the machine file


@dataclass
class Replayed:
    """The motion of a controller with a file: points (k, 3) mm, winches (k, m) deg, E mm, speeds mm/s, source lines."""

    points: list[list[float]] = field(default_factory=list)
    winches: list[list[float]] = field(default_factory=list)
    laid: list[float] = field(default_factory=list)
    speeds: list[float] = field(default_factory=list)
    sources: list[int] = field(default_factory=list)
    layers: list[int] = field(default_factory=list)
    corner: float = 0.0


def replay(text: str, letters: str) -> Replayed:
    """Absolute moves, as G90 and M82 say; positions begin where G92 or G10 L20 put them."""
    done, at, feed = Replayed(), dict.fromkeys(("X", "Y", "Z", "E", *letters), 0.0), 0.0
    for raw in text.splitlines():
        code, _, comment = raw.partition(";")
        words = dict(re.findall(r"([A-Z])(-?[0-9.]+)", code))
        if comment.strip().startswith("LAYER:"):
            done.layers.append(int(comment.split(":")[1].split()[0]))
        if corner := re.search(r"INSTANTANEOUS_CORNER_VELOCITY=([0-9.]+)", code):
            done.corner = float(corner[1])
        if code.startswith(("G92", "G10 L20", "G0", "G1 ")):
            at |= {key: float(words[key]) for key in at if key in words}
        if not code.startswith(("G0", "G1 ", "G92", "G10 L20")):
            continue
        feed = float(words.get("F", feed))
        done.points.append([at[key] for key in "XYZ"])
        done.winches.append([at[key] for key in letters])
        done.laid.append(at["E"])
        done.speeds.append(feed / 60.0)
        done.sources.append(int(comment.rsplit(" ", 1)[1]) if "line" in comment else 0)
    return done


@pytest.fixture(scope="module")
def house() -> tuple[Robot, Job, MachineSettings]:
    return load("house-printer"), load_job(JOB), load_machine("house-printer")


@pytest.fixture(scope="module")
def klipper(house: tuple[Robot, Job, MachineSettings]) -> Firmware:
    robot, job, machine = house
    return firmware("klipper", robot, job, machine=machine, layers=(1, 1))


@pytest.fixture(scope="module")
def linuxcnc(house: tuple[Robot, Job, MachineSettings]) -> Firmware:
    robot, job, machine = house
    return firmware("linuxcnc", robot, job, machine=machine, layers=(1, 1))


def replayed(made: Firmware) -> Replayed:
    return (
        replay(made.files["job.gcode"], "ABCD") if "job.gcode" in made.files else replay(made.files["job.ngc"], "ABCU")
    )


@pytest.mark.parametrize("name", ["klipper", "linuxcnc"])
def test_winches_are_within_half_a_microstep_of_the_model(
    name: str, house: tuple[Robot, Job, MachineSettings], request: pytest.FixtureRequest
) -> None:
    """At every point and half-way between any two, with the drums' one layer: angle times radius is the length."""
    robot, done = house[0], replayed(request.getfixturevalue(name))
    points, winches = np.array(done.points) / 1e3, np.radians(done.winches)
    radius = robot.lines[0].winch.drum_radius
    assert radius is not None
    first = cw.inverse(robot, points[:1]).lengths
    for at, turned in ((points, winches), (0.5 * (points[1:] + points[:-1]), 0.5 * (winches[1:] + winches[:-1]))):
        off = (cw.inverse(robot, at).lengths - first) / radius - turned
        assert np.abs(off).max() < 0.5 * MICROSTEP


def test_klipper_does_not_stop_on_straight_lines(klipper: Firmware) -> None:
    """Klipper's look-ahead: at a junction the angle between two moves and a winch's corner velocity slow it."""
    done = replayed(klipper)
    steps = np.diff(done.points, axis=0)
    way = np.linalg.norm(steps, axis=1)
    directions, rates = steps / way[:, None], np.diff(done.winches, axis=0) / way[:, None]
    straight = np.sum(directions[1:] * directions[:-1], axis=1) > 1 - 1e-9
    assert straight.sum() > 1000
    changes = np.abs(np.diff(rates, axis=0)).max(axis=1)
    allowed = done.corner / np.maximum(changes, 1e-12)
    speeds = np.minimum(done.speeds[2:], done.speeds[1:-1])
    assert (allowed[straight] >= speeds[straight]).all()


def test_corners_on_the_path_stay_corners(klipper: Firmware) -> None:
    done = replayed(klipper)
    steps = np.diff(done.points, axis=0)
    assert (np.linalg.norm(steps, axis=1) > 0).all()  # else Klipper plans by the winches alone, and stops


@pytest.mark.parametrize("name", ["klipper", "linuxcnc"])
def test_each_line_names_its_source(
    name: str, house: tuple[Robot, Job, MachineSettings], request: pytest.FixtureRequest
) -> None:
    """A move ends where its line of the sliced file says, times the scale."""
    job, done = house[1], replayed(request.getfixturevalue(name))
    assert job.gcode is not None
    source = job.gcode.read_text().splitlines()
    ends = {line: point for line, point in zip(done.sources, done.points, strict=True) if line}
    assert len(ends) > 100
    for line, (x, y, _) in ends.items():
        words = dict(re.findall(r"([XY])(-?[0-9.]+)", source[line - 1]))
        for axis, value in (("X", x), ("Y", y)):
            if axis in words:
                assert value == pytest.approx(20.0 * float(words[axis]), abs=2e-4)


def test_what_is_laid(house: tuple[Robot, Job, MachineSettings], klipper: Firmware, linuxcnc: Firmware) -> None:
    """E grows by the way of each line that lays; LinuxCNC's output is on for the same way."""
    done = replayed(klipper)
    path = klipper.path
    assert done.laid[-1] == pytest.approx(1e3 * path.samples.extruded_length, abs=0.01)
    assert np.all(np.diff(done.laid) >= 0.0)
    assert done.layers[-1] == 1
    laying, way, last = False, 0.0, None
    for raw in linuxcnc.files["job.ngc"].splitlines():
        if raw.startswith("M67 E0 Q"):
            laying = raw.strip() == "M67 E0 Q1"
        if raw.startswith("G1 "):
            at = np.array([float(each) for each in re.findall(r"[XYZ](-?[0-9.]+)", raw)])
            way += float(np.linalg.norm(at - last)) if laying and last is not None else 0.0
            last = at
    assert way == pytest.approx(done.laid[-1], abs=20.0)  # the first piece has no point before it here
    assert "G64 P" in linuxcnc.files["job.ngc"]


def test_linuxcnc_has_an_axis_and_a_joint_for_each_coordinate(linuxcnc: Firmware) -> None:
    from configparser import ConfigParser

    ini = ConfigParser(strict=True)
    ini.read_string(linuxcnc.files["machine.ini"])
    axes = ini["TRAJ"]["COORDINATES"]
    assert axes == "XYZABCU"
    done = replayed(linuxcnc)
    columns = np.column_stack([done.points, done.winches])
    for k, letter in enumerate(axes):
        for section in (f"AXIS_{letter}", f"JOINT_{k}"):
            assert float(ini[section]["MIN_LIMIT"]) < columns[:, k].min()
            assert float(ini[section]["MAX_LIMIT"]) > columns[:, k].max()


def test_layers_of_cable_turn_more(house: tuple[Robot, Job, MachineSettings]) -> None:
    """On a narrow drum with two layers the inner one turns more for the same length."""
    robot, job, machine = house
    winch = machine.winch.model_copy(update={"width": 0.16, "pitch": 0.0035})  # 40 turns a layer
    narrow = machine.model_copy(update={"winch": winch})
    deep = firmware("klipper", robot, job, machine=narrow, layers=(1, 1), tolerance=1e-3)
    bare = firmware("klipper", robot, job, layers=(1, 1), stepper=Stepper(ratio=50.0), tolerance=1e-3)
    one, two = (replayed(each).winches for each in (deep, bare))
    assert np.abs(one).max() < np.abs(two).max()
    assert any("one layer of cable" in each for each in bare.assumed)


def test_rejections(house: tuple[Robot, Job, MachineSettings], tmp_path: Path) -> None:
    robot, job, machine = house
    with pytest.raises(InputError, match=r"layers 4 to 900: this part has 1 to"):
        firmware("klipper", robot, job, machine=machine, layers=(4, 900))
    with pytest.raises(InputError, match="has a universal joint; not supported"):
        firmware("reprapfirmware", robot, job)
    with pytest.raises(InputError, match=r"has no winch\.drum_radius"):
        firmware("klipper", load("caroca"), job)
    eight = load("cogiro")
    wound = tuple(
        line.model_copy(update={"winch": line.winch.model_copy(update={"drum_radius": 0.05})}) for line in eight.lines
    )
    with pytest.raises(InputError, match="robot 'cogiro' has more than 6 lines; not supported"):
        firmware("linuxcnc", eight.model_copy(update={"lines": wound}), job)
    high = job.model_copy(update={"origin": (0.0, 0.0, 14.0)})
    with pytest.raises(AnswerError, match="nozzle at"):
        firmware("klipper", robot, high, machine=machine, layers=(1, 1))


def test_reprapfirmware(tmp_path: Path) -> None:
    """A Hangprinter's configuration is read back; the job is in X Y Z."""
    from exchange.samples import RRF

    (tmp_path / "own.g").write_text(RRF)
    robot = read_robot([tmp_path / "own.g"]).robot
    job = load_job(JOB).model_copy(update={"scale": 0.5})
    made = firmware("reprapfirmware", robot, job, layers=(1, 1))
    (tmp_path / "config.g").write_text(made.files["config.g"])
    again = read_robot([tmp_path / "config.g"]).robot
    assert again.lines == robot.lines
    done = replay(made.files["job.g"], "")
    np.testing.assert_allclose(np.array(done.points)[1:] / 1e3, made.path.samples.positions, atol=1e-7)
