"""Declared symmetry: mirror images follow, those of exit points as of platform points, and a value without image is
rejected."""

from __future__ import annotations

import pytest

from cablewright.foundation.errors import InputError, UnknownName
from cablewright.robot import load
from cablewright.robot.design_variables import Change
from cablewright.robot.symmetry import SymmetricChange

HOUSE, BEAM = load("house-printer"), load("jung2020")


def test_all_four_exit_points_follow_one() -> None:
    robot = SymmetricChange(Change("exit_point.x@south-west"), ("x", "y")).on(HOUSE, -5.0)
    assert [line.exit_point[0] for line in robot.lines] == [-5.0, 5.0, 5.0, -5.0]
    assert [line.winch_exit[0] for line in robot.lines if line.winch_exit] == [-5.0, 5.0, 5.0, -5.0]
    robot = SymmetricChange(Change("exit_point.z@south-west"), ("x",)).on(HOUSE, 12.0)
    assert [line.exit_point[2] for line in robot.lines] == [12.0, 12.0, 15.0, 15.0]


def test_platform_points_are_mirrored_about_the_platforms_middle() -> None:
    robot = SymmetricChange(Change("platform_point.y@1"), ("x", "y")).on(BEAM, 0.05)
    moved = {line.name: line.platform_point[1] for line in robot.lines if abs(line.platform_point[1]) == 0.05}
    assert moved == {"1": 0.05, "2": -0.05, "3": -0.05, "4": 0.05}


def test_what_is_of_all_lines_stays_so() -> None:
    assert SymmetricChange(Change("exits-x"), ("x", "y")).on(HOUSE, 10.0) == Change("exits-x").on(HOUSE, 10.0)
    assert SymmetricChange(Change("mass"), ("x",)).unit == "kg"


def test_lines_without_an_image_and_other_mirrors_are_rejected() -> None:
    crooked = Change("exit_point.x@south-west").on(HOUSE, -5.0)
    with pytest.raises(InputError, match=r"symmetry x: line 'south-west' of 'house-printer' has no mirror image"):
        SymmetricChange(Change("exit_point.y@south-west"), ("x",)).on(crooked, -5.0)
    with pytest.raises(UnknownName, match="unknown mirror 'z'"):
        SymmetricChange(Change("mass"), ("z",))
    with pytest.raises(UnknownName, match="unknown line 'south'"):
        SymmetricChange(Change("exit_point.z@south"), ("x",)).on(HOUSE, 5.0)


def test_spread_and_limits() -> None:
    robot = Change("exits-y").on(HOUSE, 9.0)
    assert [line.exit_point[1] for line in robot.lines] == [-4.5, -4.5, 4.5, 4.5]
    robot = Change("tension-min").on(HOUSE, 100.0)
    assert {line.tension_limits for line in robot.lines} == {(100.0, 5150.0)}
    assert (Change("tension-max").unit, Change("exits-x").unit) == ("N", "m")
    with pytest.raises(InputError, match="would be 6000 to 5150 N"):
        Change("tension-min").on(HOUSE, 6000.0)
