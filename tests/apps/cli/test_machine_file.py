"""A machine file for one's own robot: it is read, it follows the robot, and the machine prints."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest

from cablewright.foundation.errors import InputError
from cablewright.live.simulate import simulate
from cablewright.machine.files import machine_text
from cablewright.machine.simulated.machine_file import machine_file
from cablewright.machine.simulated.settings import TwinSettings, load_twin
from cablewright.robot import Robot, load, loads

pytestmark = pytest.mark.usefixtures("undrawn")

OWN = """
schema = 1
name = "attic"
scene = { frame_min = [-1, -1, 0], frame_max = [1, 1, 2] }
platform = { mass = "3 kg" }
sheave = { kind = "eyelet" }
winch = { drum_radius = "30 mm" }
line = { tension_limits = ["1 N", "200 N"] }
lines = [
    { name = "a", exit_point = [-1, -1, 2] },
    { name = "b", exit_point = [1, -1, 2] },
    { name = "c", exit_point = [1, 1, 2] },
    { name = "d", exit_point = [-1, 1, 2] },
]
[cable]
young_modulus = "60 GPa"
diameter = "1 mm"
fill_factor = 0.6
linear_density = "0.6 g/m"
breaking_load = "1 kN"
"""
RING = """
schema = 1
name = "ring"
helix = { radius = "0.2 m", layers = 1, layer_height = "2 mm", first_height = "0.3 m" }
bead = { width = "10 mm", height = "2 mm" }
motion = { print_speed = "50 mm/s", travel_speed = "50 mm/s", acceleration = "0.1 m/s^2" }
"""


def settings(robot: Robot, folder: Path) -> TwinSettings:
    (folder / "machine.toml").write_text(machine_file(robot))
    return load_twin(folder / "machine.toml")


def test_its_numbers_are_the_robots(tmp_path: Path) -> None:
    robot = load("house-printer")
    found = settings(robot, tmp_path).owner
    winch = robot.lines[0].winch
    assert found.name == found.robot == robot.name
    assert found.drum.empty_mass == robot.platform.mass
    assert found.winch.max_speed * winch.drum_radius == pytest.approx(winch.max_speed, rel=0.01)
    assert found.winch.max_torque == pytest.approx(winch.max_torque, rel=0.01)
    assert 15.0 + 25.9 < found.winch.held <= found.winch.capacity  # dead span and the frame's diagonal
    assert not found.lidars


@pytest.mark.parametrize("plant", ["dynamic", "quasi-static"])
@pytest.mark.parametrize("robot", [load("house-printer"), load("merlet2023"), loads(OWN)], ids=lambda each: each.name)
def test_the_machine_holds_its_place(robot: Robot, plant: str, tmp_path: Path) -> None:
    low, high = robot.scene.frame_min, robot.scene.frame_max
    middle = [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), low[2] + 0.3 * (high[2] - low[2])]
    found = simulate(robot, settings(robot, tmp_path), hold=middle, duration=2.0, plant=plant)
    assert not found.drive.notices
    assert found.drive.distance < 0.02


@pytest.mark.slow  # in test_new.py, with the robot of a layout
def test_an_own_robot_is_checked_and_printed_without_editing(cli, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "attic.toml").write_text(OWN)
    (tmp_path / "ring.toml").write_text(RING)
    assert cli(*shlex.split("check attic.toml ring.toml --json")).json["feasible"]
    (tmp_path / "machine.toml").write_text(cli("machines", "--for", "attic.toml").out)
    found = cli(*shlex.split("print attic.toml ring.toml --machine machine.toml --plant quasi-static --out run --json"))
    assert found.code == 0
    assert found.json["status"] == "finished"
    assert found.json["max_error_in_space"] < 0.05


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('winch = { drum_radius = "30 mm" }', "", "line 'a' has no winch.drum_radius; not supported"),
        ('linear_density = "0.6 g/m"', "linear_density = 0", "line 'a' has a cable without weight"),
        (
            'diameter = "1 mm"\nfill_factor = 0.6', 'section = "0.5 mm^2"',
            "line 'a' has no cable.diameter; not supported",
        ),
    ],
)  # fmt: skip
def test_a_robot_that_no_plant_can_simulate(old: str, new: str, says: str) -> None:
    robot = loads(OWN.replace(old, new))
    with pytest.raises(InputError, match=r"^machines --for: ") as refusal:
        machine_file(robot)
    assert says in str(refusal.value)


@pytest.mark.parametrize("plant", ["dynamic", "quasi-static"])
@pytest.mark.parametrize(("name", "place"), [("cogiro", [0, 0, 1]), ("jung2020", [0, 0, 0.5]), ("ipanema", [0, 0, 1])])
def test_the_machine_of_a_body_holds_its_place(name: str, place: list[float], plant: str, tmp_path: Path) -> None:
    robot = load(name)
    twin = settings(robot, tmp_path)
    assert twin.owner.body.empty_mass == robot.platform.mass
    assert (twin.owner.retraction is None) == (robot.retraction is None)
    found = simulate(robot, twin, hold=place, duration=2.0, plant=plant)
    assert not found.drive.notices
    assert found.drive.distance < 0.02
    assert found.drive.readings["Inertial"] > 5


def test_a_body_of_unknown_inertia_gets_radii_of_gyration(tmp_path: Path) -> None:
    robot = load("ipanema")
    platform = robot.platform.model_copy(update={"inertia": None})
    twin = settings(robot.model_copy(update={"platform": platform}), tmp_path)
    assert twin.owner.body.gyration == (0.08, 0.08, 0.08)


@pytest.mark.parametrize("name", ['say "attic"', "a\nb = 1", "\\", "\u2028 \u00e9 \U0001f916", "\x1b[31m"])
def test_a_name_writes_no_key_of_its_own(name: str, tmp_path: Path) -> None:
    assert settings(load("house-printer").model_copy(update={"name": name}), tmp_path).owner.name == name


def test_a_name_and_a_robot_are_one_too_many(cli) -> None:
    assert "not both" in cli("machines", "merlet2023", "--for", "merlet2023").refusal


@pytest.mark.parametrize("command", ["print house-printer ring.toml", "simulate house-printer --loop 5 --height 2"])
def test_the_machine_of_another_robot_is_rejected(cli, command: str, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ring.toml").write_text(RING)
    (tmp_path / "machine.toml").write_text(machine_file(loads(OWN)))
    found = cli(*shlex.split(command), "--machine", "machine.toml")
    assert "machine 'attic': robot = 'attic', but the robot is 'house-printer'" in found.refusal


def test_a_height_over_the_floor_needs_some(cli, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    text = machine_text("merlet2023").replace('robot = "merlet2023"', "")
    (tmp_path / "machine.toml").write_text(text)
    (tmp_path / "ring.toml").write_text(RING.replace("0.3 m", "0 m"))
    found = cli(*shlex.split("print merlet2023 ring.toml --machine machine.toml --plant quasi-static --out run"))
    assert "height = structure: the path begins on the floor" in found.refusal


@pytest.mark.parametrize("command", ["print merlet2023 ring.toml --out run", "simulate merlet2023 --loop 5"])
def test_without_a_simulation_nothing_is_simulated(cli, command: str, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("ring.toml").write_text(RING)
    owner, _, _ = machine_text("merlet2023").partition("# Parameters of the simulation alone")
    Path("real.toml").write_text(owner)
    found = cli(*command.split(), "--machine", "real.toml")
    assert found.code == 2
    assert "real.toml: no table [simulation], without which a machine cannot be simulated: add it" in found.refusal
