"""Numbers that change a robot: what moves, what stays, and what is rejected."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from cablewright.foundation.errors import InputError, UnknownName
from cablewright.robot import KINDS, Robot, library_text, load, loads
from cablewright.robot.design_variables import NAMED, Change, changed, nearest_exits, with_box_inertia

BEAM, COGIRO, HOUSE, MERLET = (load(name) for name in ("jung2020", "cogiro", "house-printer", "merlet2023"))


def exits(robot: Robot) -> np.ndarray:
    return np.array([line.exit_point for line in robot.lines])


def points(robot: Robot) -> np.ndarray:
    return np.array([line.platform_point for line in robot.lines])


def others(robot: Robot, *keys: str) -> list[dict[str, Any]]:
    """What lines are, but for some keys."""
    return [line.model_dump(exclude=set(keys)) for line in robot.lines]


@pytest.mark.parametrize("distance", [0.0283, 0.1, 0.5])
def test_exit_points_at_corners_slide_along_the_walls(distance: float) -> None:
    """As Table 2 and 3 of Jung 2020 write them: 1 - d / root 2 along each wall."""
    made = Change("exit-distance").on(BEAM, distance)
    inner = 1.0 - distance / math.sqrt(2.0)
    wanted = np.where(np.abs(exits(BEAM)) == 0.925, np.sign(exits(BEAM)) * inner, exits(BEAM))
    np.testing.assert_allclose(exits(made), wanted, atol=1e-15)
    assert nearest_exits(made)[0] == pytest.approx(distance)
    assert others(made, "exit_point") == others(BEAM, "exit_point")
    assert (made.platform, made.scene) == (BEAM.platform, BEAM.scene)


def test_exit_points_together_are_those_of_table_1() -> None:
    np.testing.assert_array_equal(exits(Change("exit-distance").on(BEAM, 0.0)), exits(load("jung2020-table1")))


@pytest.mark.parametrize("robot", [COGIRO, MERLET])
def test_other_exit_points_part_about_their_middle(robot: Robot) -> None:
    before, made = exits(robot), Change("exit-distance").on(robot, 1.5)
    after = exits(made)
    for i, own in enumerate(before):
        j = int(np.argsort(np.linalg.norm(before - own, axis=1))[1])
        assert np.linalg.norm(after[i] - after[j]) == pytest.approx(1.5)
        np.testing.assert_allclose(after[i] + after[j], before[i] + before[j], atol=1e-12)
        np.testing.assert_allclose(np.cross(after[i] - after[j], before[i] - before[j]), 0.0, atol=1e-12)


def test_a_winch_exit_follows_sideways() -> None:
    lines = [line.model_copy(update={"winch_exit": (*line.exit_point[:2], 0.5)}) for line in MERLET.lines]
    robot = MERLET.model_copy(update={"lines": tuple(lines)})
    for change, value in (("exit-distance", 4.0), ("exit_point.x", 1.0), ("exit_point.z", 3.0)):
        for line in Change(change).on(robot, value).lines:
            assert line.winch_exit == (*line.exit_point[:2], 0.5)


def test_widths_are_how_far_points_reach() -> None:
    top, bottom = slice(0, 4), slice(4, 8)
    made = points(Change("width-top-x").on(BEAM, 0.16))
    np.testing.assert_allclose(np.ptp(made[top], axis=0), [0.16, 0.04, 0.0])
    np.testing.assert_array_equal(made[bottom], points(BEAM)[bottom])
    made = points(Change("width-bottom-y").on(BEAM, 0.0))
    np.testing.assert_allclose(np.ptp(made[bottom], axis=0), [0.04, 0.0, 0.0])
    np.testing.assert_array_equal(made[top], points(BEAM)[top])
    made = points(Change("width-x").on(COGIRO, 3.0))
    was = points(COGIRO)
    assert np.ptp(made[:, 0]) == pytest.approx(3.0)
    middle = 0.5 * (was[:, 0].min() + was[:, 0].max())
    np.testing.assert_allclose(made[:, 0] - middle, (was[:, 0] - middle) * 3.0 / np.ptp(was[:, 0]), atol=1e-12)
    np.testing.assert_array_equal(made[:, 1:], was[:, 1:])


def test_joined_names_have_one_value_and_apart_is_the_same_by_hand() -> None:
    together = Change("width-top-x+width-bottom-y").on(BEAM, 0.16)
    assert together == changed(BEAM, {Change("width-top-x"): 0.16, Change("width-bottom-y"): 0.16})
    assert together == Change("width-bottom-y + width-top-x").on(BEAM, 0.16)


ABSENT = ("length_scale", "sheave_radius", "counterweight")  # in that robot


@pytest.mark.parametrize("name", [each for each in [*NAMED, *KINDS] if each not in ABSENT])
def test_present_values_change_nothing(name: str) -> None:
    has = {"exit-distance": nearest_exits(BEAM)[0], "retraction": 2.0, "modulus": 1.0}
    has |= dict.fromkeys([each for each in NAMED if "width" in each], 0.04)
    has |= {"exits-x": 2.0, "exits-y": 2.0, "tension-min": 10.0, "tension-max": 200.0}
    if name in KINDS and KINDS[name].role != "hardware":
        with pytest.raises(UnknownName):
            Change(name)
        return
    kind, _, axis = name.partition(".")
    for line in BEAM.lines if kind in ("exit_point", "platform_point") else BEAM.lines[:1]:
        part = BEAM.platform if hasattr(BEAM.platform, kind) else line.cable if hasattr(line.cable, kind) else line
        value = has.get(name, getattr(part, kind, None))
        whose = f"{name}@{line.name}" if part is line and name not in has else name
        made = Change(whose).on(BEAM, value["xyz".index(axis)] if axis else value)
        np.testing.assert_allclose(exits(made), exits(BEAM), atol=1e-15)
        np.testing.assert_allclose(points(made), points(BEAM), atol=1e-15)
        assert made.platform == BEAM.platform
        assert others(made, "exit_point", "platform_point") == others(BEAM, "exit_point", "platform_point")


def test_figures_of_the_file() -> None:
    assert Change("mass").on(BEAM, 12.0).platform.mass == 12.0
    assert Change("centre_of_mass.z").on(BEAM, 0.3).platform.centre_of_mass == (0.0, 0.0, 0.3)
    assert Change("force.x").on(HOUSE, 7.0).platform.force == (7.0, 0.0, 0.0)
    for robot in (BEAM, HOUSE):
        made = Change("modulus").on(robot, 0.5)
        assert [2 * line.cable.stiffness for line in made.lines] == [line.cable.stiffness for line in robot.lines]
    made = Change("linear_density@3").on(BEAM, 0.1)
    assert [line.cable.linear_density for line in made.lines] == [0.1 if k == 2 else 0.0025 for k in range(8)]
    assert {line.sheave.radius for line in Change("sheave_radius").on(COGIRO, 0.07).lines} == {0.07}
    assert exits(Change("exit_point.z").on(HOUSE, 12.0))[:, 2].tolist() == [12.0] * 4
    assert exits(Change("exit_point.z@2").on(BEAM, 3.0))[:, 2].tolist() == [2.0, 3.0, *[2.0] * 6]
    assert Change("retraction").on(BEAM, 1.4) == BEAM.retracted(1.4)


def test_a_changed_robot_is_the_one_that_a_file_with_that_number_has() -> None:
    text = library_text("jung2020").replace('mass = "10 kg"', 'mass = "11 kg"').replace("0.925", "0.9")
    made = changed(BEAM, {Change("exit-distance"): 0.1 * math.sqrt(2.0), Change("mass"): 11.0})
    own = loads(text)
    np.testing.assert_allclose(exits(made), exits(own), atol=1e-15)
    assert made.platform == own.platform


def test_the_inertia_of_a_box() -> None:
    """Jung 2020, Eq. 6, which its robot's file has worked out."""
    np.testing.assert_allclose(with_box_inertia(BEAM).platform.inertia, BEAM.platform.inertia)
    made = with_box_inertia(changed(BEAM, {Change("width-top-x"): 0.3, Change("retraction"): 1.2}))
    wanted = [10 / 12 * (0.04**2 + 1.2**2), 10 / 12 * (0.3**2 + 1.2**2), 10 / 12 * (0.3**2 + 0.04**2)]
    np.testing.assert_allclose(made.platform.inertia, wanted)
    with pytest.raises(InputError, match="a point platform has no inertia"):
        with_box_inertia(HOUSE)
    with pytest.raises(InputError, match="on one line"):
        with_box_inertia(Change("width-x+width-y").on(BEAM, 0.0))


def test_units() -> None:
    names = ("exit-distance", "mass", "modulus", "force.x", "width-x+width-y", "exit_point.x@1")
    assert [Change(name).unit for name in names] == ["m", "kg", "1", "N", "m", "m"]


def test_a_single_line_has_no_neighbour() -> None:
    assert nearest_exits(HOUSE.model_copy(update={"lines": HOUSE.lines[:1]})) is None


@pytest.mark.parametrize(
    ("robot", "name", "value", "says"),
    [
        (BEAM, "width", 1.0, "unknown parameter 'width';"),
        (BEAM, "", 1.0, "unknown parameter ''"),
        (BEAM, "width-x+", 1.0, "unknown parameter ''"),
        (BEAM, "temperature", 1.0, "unknown parameter 'temperature'"),
        (BEAM, "width-x@1", 1.0, "width-x belongs to the whole robot, not to line '1'"),
        (BEAM, "mass@1", 1.0, "mass is a number of the platform, not of a line"),
        (BEAM, "exit_point.x@9", 1.0, "unknown line '9'"),
        (BEAM, "mass", 0.0, "mass = 0: it must be above 0"),
        (BEAM, "mass", math.nan, "mass = nan: must be a finite number"),
        (BEAM, "retraction", 3.0, "retracts from 1.2 to 2 m"),
        (BEAM, "exit-distance", -0.1, "must be a length of 0 or more"),
        (BEAM, "width-x", -0.1, "must be a length of 0 or more"),
        (BEAM, "sheave_radius", 0.1, "line '1' has an eyelet, which has no radius"),
        (BEAM, "platform_point.x+platform_point.y+platform_point.z", 1.0, "all platform points coincide"),
        (BEAM, "mass", 1e309, "finite number"),
        (load("jung2020-table1"), "exit-distance", 0.1, "coincide: the direction of their motion is undefined"),
        (HOUSE, "exit-distance", 1.0, "do not come in pairs: that of line 'south-west' is as near to"),
        (HOUSE, "width-x", 1.0, "a point platform, which has no width"),
        (HOUSE, "retraction", 1.0, "has no retraction"),
        (load("grab-four-lines"), "width-top-x", 1.0, "all at one height"),
    ],
)
def test_what_a_robot_cannot_have_is_rejected(robot: Robot, name: str, value: float, says: str) -> None:
    with pytest.raises(InputError, match=says):
        Change(name).on(robot, value)


def test_points_in_one_plane_have_no_width_to_change() -> None:
    flat = Change("width-top-x").on(BEAM, 0.0)
    with pytest.raises(InputError, match="of its top all have one x"):
        Change("width-top-x").on(flat, 0.1)
    assert np.ptp(points(Change("width-top-y").on(flat, 0.1))[:4, 1]) == pytest.approx(0.1)
