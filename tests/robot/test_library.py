"""The robots that come with cablewright: their numbers are those of their papers."""

import math

import pytest

from cablewright.live.rest_pose import rest_pose
from cablewright.robot import Eyelet, RigidPlatform, Swivel, UniversalJoint, library_names, library_text, load

BODIES = {
    "building-printer": 8,
    "cable-robot-simulator": 8,
    "caroca": 8,
    "cogiro": 8,
    "expo2015-lucia": 8,
    "fast-telescope": 6,
    "grab-four-lines": 4,
    "grab-prototype": 4,
    "ipanema": 8,
    "ipanema1": 8,
    "ipanema2": 8,
    "ipanema3": 8,
    "jung2020": 8,
    "jung2020-table1": 8,
    "nist-robocrane": 6,
}
POINTS = {
    **dict.fromkeys(("hangprinter-v4", "house-printer", "maslow4", "merlet2023", "paty2021", "skycam", "wang2021"), 4),
    "hangprinter-five": 5,
    "wall-plotter": 2,
}
CORNERS = {(-1, -1), (1, -1), (1, 1), (-1, 1)}


def test_the_library_has_these_robots() -> None:
    assert library_names() == tuple(sorted([*BODIES, *POINTS]))


@pytest.mark.parametrize("name", library_names())
def test_each_loads_under_its_own_name_and_says_what_is_assumed(name: str) -> None:
    robot = load(name)
    assert robot.name == name
    assert robot.source
    assert robot.description
    assert (robot.m, robot.n) == ((BODIES[name], 6) if name in BODIES else (POINTS[name], 3))
    assert "# assumed" in library_text(name)
    low, high = robot.scene.frame_min, robot.scene.frame_max
    for line in robot.lines:
        assert all(a <= x <= b for a, x, b in zip(low, line.exit_point, high, strict=True))


@pytest.mark.parametrize("name", library_names())
def test_each_is_held_at_rest_within_its_limits(name: str) -> None:
    assert rest_pose(load(name)).held


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


def test_jung2020() -> None:
    robot, initial = load("jung2020"), load("jung2020-table1")
    assert (initial.scene, initial.platform) == (robot.scene, robot.platform)
    corners = [(1, 1), (1, -1), (-1, -1), (-1, 1)]
    for k, (line, first) in enumerate(zip(robot.lines, initial.lines, strict=True)):
        x, y = corners[k % 4]
        assert first.exit_point == (x, y, 2)
        assert line.exit_point == ((0.925 * x, y, 2) if k < 4 else (x, 0.925 * y, 2))
        assert line.platform_point == first.platform_point == (0.02 * x, 0.02 * y, 1.8 if k < 4 else -0.2)
        assert line.sheave == Eyelet()
        assert (line.cable.stiffness, line.tension_limits) == (130e3, (10, 200))
        assert line.model_copy(update={"exit_point": first.exit_point}) == first


def test_the_beam_of_jung2020() -> None:
    platform = load("jung2020").platform
    assert isinstance(platform, RigidPlatform)
    assert (platform.mass, platform.centre_of_mass, platform.nozzle) == (10, (0, 0, 0), (0, 0, 0))
    width, length = 0.04, 2.0  # Eq. 6
    across, along = 10 / 12 * (width**2 + length**2), 10 / 12 * (width**2 + width**2)
    assert platform.inertia == pytest.approx((across, across, along), rel=1e-15)
    retraction = platform.retraction
    assert retraction is not None
    assert (retraction.length, retraction.least, retraction.most) == (2, 1.2, 2)
    assert retraction.lines == ("1", "2", "3", "4")


def test_cogiro() -> None:
    robot = load("cogiro")
    assert isinstance(robot.platform, RigidPlatform)
    assert robot.platform.mass == 91.058
    assert robot.platform.inertia_products == (-0.453, 3.012, -1.539)
    for k, line in enumerate(robot.lines):
        (x, y, z), (bx, by, bz) = line.exit_point, line.platform_point
        assert (abs(x), abs(y), z) == pytest.approx((7.3, 5.3, 5.4), abs=0.3)
        assert (abs(bx), abs(by), bz) == pytest.approx((0.5, 0.38, 0 if k % 2 == 0 else 1), abs=0.12)
        assert isinstance(line.sheave, Swivel)


def test_grab_four_lines_hangs_stably() -> None:
    robot = load("grab-four-lines")
    assert isinstance(robot.platform, RigidPlatform)
    assert robot.platform.mass == 8.0064
    for line in robot.lines:
        x, y, _ = line.exit_point
        east, north = math.copysign(1, x - 1.1), math.copysign(1, y)
        assert line.exit_point == (1.1 + 1.1 * east, 1.1 * north, 1)
        assert line.platform_point == (0.13 * east, 0.225 * north, 0.255)
        assert line.platform_point[2] > robot.platform.centre_of_mass[2]
