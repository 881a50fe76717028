"""The robots that come with cablewright: their numbers are those of their papers."""

import math

import pytest

from cablewright.robot import Eyelet, Swivel, UniversalJoint, library_names, library_text, load

CORNERS = {(-1, -1), (1, -1), (1, 1), (-1, 1)}


def test_the_library_has_these_robots() -> None:
    assert library_names() == ("house-printer", "merlet2023", "paty2021", "wang2021")


@pytest.mark.parametrize("name", library_names())
def test_each_loads_under_its_own_name_and_says_what_is_assumed(name: str) -> None:
    robot = load(name)
    assert robot.name == name
    assert robot.source
    assert robot.description
    assert (robot.m, robot.n) == (4, 3)
    assert "# assumed" in library_text(name)
    low, high = robot.scene.frame_min, robot.scene.frame_max
    for line in robot.lines:
        assert all(a <= x <= b for a, x, b in zip(low, line.exit_point, high, strict=True))


def test_paty2021() -> None:
    robot = load("paty2021")
    assert robot.platform.mass == 200
    assert {(line.exit_point[0] / 7.5, line.exit_point[1] / 7.5) for line in robot.lines} == CORNERS
    for line in robot.lines:
        x, y, z = line.exit_point
        assert (z, line.winch_exit) == (15, (x, y, 0))
        assert line.tension_limits == (510, 5150)
        assert (line.dead_elastic, line.arc_elastic) == (True, False)
        cable, sheave = line.cable, line.sheave
        assert cable.stiffness == pytest.approx(102.2e9 * math.pi * 2e-3**2, rel=1e-15)
        assert (cable.linear_density, cable.breaking_load, cable.diameter) == (0.03, 10290, 0.004)
        assert isinstance(sheave, UniversalJoint)
        assert (sheave.radius, sheave.lever, sheave.lever_weight) == (0.05, 0.104, 6.85)
        assert (sheave.lever_mass_centre, sheave.wrap) == (0.0706, "over")
        assert (sheave.swing, sheave.lever_range) == (math.pi / 4, (-math.pi / 2, 0))
        assert sheave.facing is not None
        inward = (x + 7.5 * math.sqrt(2) * math.cos(sheave.facing), y + 7.5 * math.sqrt(2) * math.sin(sheave.facing))
        assert inward == pytest.approx((0, 0), abs=1e-12)


def test_house_printer_is_paty2021_with_other_limits_and_with_winches() -> None:
    paty, house = load("paty2021"), load("house-printer")
    assert (house.scene, house.platform) == (paty.scene, paty.platform)
    for ours, theirs in zip(house.lines, paty.lines, strict=True):
        assert ours.tension_limits == (20, 5150)
        same = ours.model_copy(update={"tension_limits": theirs.tension_limits, "winch": theirs.winch})
        assert same == theirs
        winch = ours.winch
        assert (winch.drum_radius, winch.max_speed, winch.max_torque, winch.capacity) == (0.1, 1, 600, 60)


def test_merlet2023() -> None:
    robot = load("merlet2023")
    assert robot.platform.mass == 40
    for line in robot.lines:
        x, y, z = line.exit_point
        assert (abs(x), abs(y), z, line.winch_exit) == (2.5, 5, 4.03, (x, y, 0))
        assert line.sheave == Swivel(radius=0.0375)
        assert line.cable.stiffness == pytest.approx(7.07e5, rel=1e-3)
        assert line.cable.linear_density == 6.8e-3
        radius, ratio = line.winch.drum_radius, 4 / 459
        assert radius is not None
        assert line.winch.max_speed == pytest.approx(4000 * 2 * math.pi / 60 * ratio * radius, rel=1e-3)
        assert line.winch.max_torque == pytest.approx(0.32 / ratio)
        assert line.winch.capacity == 250


def test_wang2021() -> None:
    robot = load("wang2021")
    assert [line.exit_point[2] for line in robot.lines] == [3, 0.2, 3, 0.2]
    for line in robot.lines:
        assert line.sheave == Swivel(radius=0.075)
        assert not isinstance(line.sheave, Eyelet)
        assert (line.winch_exit, line.dead_length) == (None, 0)
