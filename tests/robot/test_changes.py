"""Robots from points, changed robots, arrays of points and a short line for each."""

import numpy as np
import pytest

import cablewright as cw

CORNERS = [[-2, -2, 3], [2, -2, 3], [2, 2, 3], [-2, 2, 3]]
COMMON = {"mass": 5.0, "cable": "dyneema-2mm", "tension_limits": (1.0, 500.0)}


def test_a_point_robot_from_its_exit_points() -> None:
    robot = cw.Robot.from_points(np.array(CORNERS), **COMMON)
    assert robot.n == 3
    assert robot.exit_points == pytest.approx(np.array(CORNERS))
    assert robot.scene.frame_min[2] == 0.0
    hold = cw.inverse(robot, [0.0, 0.0, 1.0])
    assert hold.ok
    assert hold.tensions == pytest.approx(hold.tensions[0])


def test_a_body_from_both_kinds_of_points_is_the_robot_of_the_library() -> None:
    known = cw.load("cable-robot-simulator")
    platform = known.platform
    line = known.lines[0]
    made = cw.Robot.from_points(
        known.exit_points,
        known.platform_points,
        mass=platform.mass,
        cable=line.cable,
        tension_limits=line.tension_limits,
        sheave=line.sheave,
        frame=[known.scene.frame_min, known.scene.frame_max],
        inertia=platform.inertia,
        centre_of_mass=platform.centre_of_mass,
    )
    pose = [0.0, 0.0, 1.5]
    assert cw.jacobian(made, pose) == pytest.approx(cw.jacobian(known, pose))


def test_what_is_changed_and_what_stays() -> None:
    robot = cw.load("house-printer")
    other = robot.with_(
        name="taller", mass="80 kg", gravity=1.62, tension_limits=(50.0, 5e3), breaking_load="20 kN",
        exit_points=robot.exit_points + np.array([0.0, 0.0, 0.5]),
    )  # fmt: skip
    assert (other.name, other.platform.mass, other.scene.gravity) == ("taller", 80.0, 1.62)
    assert all(line.tension_limits == (50.0, 5e3) and line.cable.breaking_load == 2e4 for line in other.lines)
    assert other.exit_points[:, 2] == pytest.approx(robot.exit_points[:, 2] + 0.5)
    assert other.lines[0].sheave == robot.lines[0].sheave
    assert robot.with_() == robot
    moved = cw.load("cogiro").with_(platform_points=2.0 * cw.load("cogiro").platform_points)
    assert moved.platform_points == pytest.approx(2.0 * cw.load("cogiro").platform_points)
    assert cw.changed(robot, {"exit_point.z@south-west": 8.0}).exit_points[0, 2] == 8.0


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"mas": 3.0}, "unknown change 'mas'; did you mean 'mass'"),
        ({"mass": float("nan")}, "platform.mass = nan: must be a finite mass"),
        ({"mass": "3 m"}, "unit one of kg, g, t"),
        ({"mass": -1.0}, "greater than 0"),
        ({"tension_limits": (5.0, 1.0)}, r"house-printer': tension_limits = .*must rise"),
        ({"exit_points": [[1.0, 2.0]]}, "4 rows of 3 finite numbers, m"),
        ({"exit_points": np.zeros((3, 3))}, "got 3 rows"),
        ({"exit_points": "here"}, "rows of 3 numbers"),
        ({"schema_version": 1}, "unknown change"),
        ({"lines": (), "exit_points": np.zeros((4, 3))}, "lines and exit_points, which is part of it"),
        ({"scene": cw.load("house-printer").scene, "frame_max": (9, 9, 9)}, "scene and frame_max, which is part"),
        ({"cable": cw.load("house-printer").lines[0].cable, "diameter": 0.01}, "cable and diameter, which is part"),
    ],
)
def test_a_wrong_change_is_named_in_one_line(changes: dict[str, object], text: str) -> None:
    with pytest.raises(cw.InputError, match=text) as caught:
        cw.load("house-printer").with_(**changes)
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"cable": "dynema-2mm"}, "did you mean 'dyneema-2mm'"),
        ({"inertia": (1, 1, 1)}, "unknown field of the platform 'inertia'"),
        ({"mass": "x kg"}, "platform.mass = 'x kg'"),
        ({"frame": [[0, 0, 0]]}, "frame: 2 rows"),
        ({"platform_points": [[0, 0, 0]]}, "platform_points: 4 rows"),
    ],
)
def test_wrong_points_are_named_in_one_line(changes: dict[str, object], text: str) -> None:
    points = changes.pop("platform_points", None)
    with pytest.raises(cw.InputError, match=text):
        cw.Robot.from_points(CORNERS, points, **COMMON | changes)


@pytest.mark.parametrize("name", cw.library_names())
def test_a_robot_is_one_short_line(name: str) -> None:
    robot = cw.load(name)
    assert len(repr(robot)) < 100
    assert str(robot) == repr(robot)
    assert f"{robot.m} lines" in repr(robot)
