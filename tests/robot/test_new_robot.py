"""A robot from nothing: each layout is a robot that holds its platform, each cable has the numbers of its source."""

from __future__ import annotations

import itertools
import math
import re
from typing import get_args

import numpy as np
import pytest

from cablewright.foundation.choices import CableName, LayoutName
from cablewright.foundation.errors import InputError
from cablewright.models.statics import Model
from cablewright.robot import Robot, loads
from cablewright.robot.cable_table import CABLES, SAFETY
from cablewright.robot.new_robot import LAYOUTS, Outline, robot_file
from cablewright.solvers.inverse import solve_inverse

SIZE = (5.0, 4.0, 3.0)


def outline(**given: object) -> Outline:
    flat = given.get("layout") == "planar"
    return Outline(**{"name": "mine", "size": (5.0, 0.0, 3.0) if flat else SIZE} | given)


def robot(**given: object) -> Robot:
    return loads(robot_file(outline(**given)))


def test_names_to_choose_from_are_those_there_are() -> None:
    assert set(get_args(LayoutName)) == set(LAYOUTS)
    assert set(get_args(CableName)) == set(CABLES)


@pytest.mark.parametrize("cable", CABLES)
@pytest.mark.parametrize("layout", LAYOUTS)
def test_it_holds_its_platform_in_the_middle(layout: str, cable: str) -> None:
    mine = robot(layout=layout, cable=cable)
    middle = np.zeros(6 if mine.n == 6 else 3)
    middle[2] = 1.0
    held = solve_inverse(Model.full(mine), middle).checked()
    assert held.unbalanced_force() < 1e-9
    assert held.margin() > -1e-6


@pytest.mark.parametrize("lines", [None, 5, 6, 9])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_exit_points_span_the_size(layout: str, lines: int | None) -> None:
    if lines is not None and LAYOUTS[layout].counts[0] == LAYOUTS[layout].counts[1]:
        pytest.skip("this layout has its own number of lines")
    size = (25.37, 0.0 if layout == "planar" else 10.05, 10.55)
    mine = robot(layout=layout, size=size, lines=lines)
    exits = np.array([line.exit_point for line in mine.lines])
    np.testing.assert_allclose(np.ptp(exits[:, :2], axis=0), size[:2], atol=2e-4)
    np.testing.assert_allclose(exits[:, :2].max(axis=0) + exits[:, :2].min(axis=0), 0.0, atol=2e-4)
    assert exits[:, 2].max() == size[2]
    low, top = np.array(mine.scene.frame_min), np.array(mine.scene.frame_max)
    assert (low[0], top[0]) == (-top[0], top[0])
    assert top[0] < 0.5 * size[0]
    assert top[2] < size[2]


@pytest.mark.parametrize(("layout", "lines"), [("suspended", 3), ("suspended", 7), ("over-middle", 5)])
def test_lines_are_as_many_as_requested(layout: str, lines: int) -> None:
    mine = robot(layout=layout, lines=lines)
    assert len(mine.lines) == lines
    assert len({line.exit_point for line in mine.lines}) == lines


def test_winches_are_below_sheaves_and_hold_the_cable() -> None:
    mine = robot()
    for line in mine.lines:
        assert line.winch_exit == (*line.exit_point[:2], 0.0)
        corners = itertools.product(*zip(mine.scene.frame_min, mine.scene.frame_max, strict=True))
        assert line.winch.capacity > 3.0 + max(math.dist(line.exit_point, corner) for corner in corners)
        assert line.winch.max_torque > line.tension_limits[1] * line.winch.drum_radius


@pytest.mark.parametrize("layout", LAYOUTS)
def test_assumed_values_are_marked(layout: str) -> None:
    """Each number of the file is requested, has a source, is in a part that is all assumed, or is marked as assumed."""
    text = robot_file(outline(layout=layout, cable="steel-4mm"))
    known = ("schema", "mass", "construction", "linear_density", "breaking_load", "diameter", "gravity", "exit_point")
    head, _, rest = text.partition("[uncertainty]")
    uncertain, _, lines = rest.partition("# Measure the exit points")
    assert "All assumed" in head.splitlines()[-2]
    assert 'name = "assumed"' in uncertain
    assert "is assumed." in lines.partition("[[lines]]")[0]
    for line in (*head.splitlines(), *lines.splitlines()):
        key = re.match(r"(\w+) = .*[0-9]", line)
        if key and key[1] not in (*known, "name", "description", "centre_of_mass", "inertia"):
            assert "assumed" in line, line
    if layout == "body":
        assert "# assumed: a cube of" in head


def test_a_cable_bears_a_fifth_of_its_breaking_load() -> None:
    for name, stock in CABLES.items():
        mine = robot(cable=name)
        assert mine.lines[0].cable == stock.cable
        assert mine.lines[0].tension_limits[1] == pytest.approx(stock.cable.breaking_load / SAFETY, rel=5e-3)


def test_cables_of_dyneema_follow_their_diameter() -> None:
    """Breaking load and mass go with the square of the diameter, stretch at a fifth of the breaking load is 0.6 %."""
    for size in range(1, 7):
        cable = CABLES[f"dyneema-{size}mm"].cable
        assert cable.diameter == pytest.approx(1e-3 * size)
        assert cable.breaking_load / cable.diameter**2 == pytest.approx(950e6, rel=5e-3)
        assert 0.2 * cable.breaking_load / cable.stiffness == pytest.approx(0.006, rel=5e-3)
    assert CABLES["dyneema-3mm"].cable.linear_density == pytest.approx(6.8e-3, rel=5e-3)  # merlet2023


@pytest.mark.parametrize(
    ("diameter", "breaks"), [(7 / 64 * 25.4e-3, 1650 * 4.4482), (1.5e-3, 2300.0), (3 / 16 * 25.4e-3, 5400 * 4.4482)]
)
def test_cables_on_sale_are_no_weaker(diameter: float, breaks: float) -> None:
    assert 950e6 * diameter**2 <= breaks <= 1.15 * 950e6 * diameter**2


def test_the_wire_rope_is_that_of_the_standard() -> None:
    """EN 12385-4, 6x19 with a fibre core: W = 0.359 kg/m per 100 d^2, K = 0.330 of the grade times d^2, d in mm."""
    cable = CABLES["steel-4mm"].cable
    assert cable.linear_density == pytest.approx(0.359 * 4.0**2 / 100.0, rel=5e-3)
    assert cable.breaking_load == pytest.approx(0.330 * 1770.0 * 4.0**2, rel=5e-3)
    assert cable.stiffness == pytest.approx(100e9 * 0.384 * 4e-3**2)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"name": "../up"}, "1 to 60 letters, digits"),
        ({"name": ""}, "1 to 60 letters"),
        ({"name": "a" * 61}, "1 to 60 letters"),
        ({"name": 'a"\nschema = 2'}, "1 to 60 letters"),
        ({"layout": "round"}, "unknown layout 'round'; allowed: body, over-middle, planar, suspended"),
        ({"cable": "dyneema-3"}, "did you mean 'dyneema-3mm'"),
        ({"size": (0.4, 4.0, 3.0)}, "size along x = 0.4 m: must be 0.5 to 100 m"),
        ({"size": (4.0, 4.0, math.nan)}, "size along z = nan m"),
        ({"layout": "planar", "size": (4.0, 4.0, 3.0)}, "size along y = 4 m: a planar robot has 0"),
        ({"lines": 2}, "lines = 2: layout suspended has 3 to 64"),
        ({"layout": "body", "lines": 6}, "lines = 6: layout body has 8"),
        ({"mass": -1.0}, "mass = -1 kg: must be a finite number over 0"),
        ({"mass": math.inf}, "mass = inf kg"),
        (
            {"mass": 100.0},
            "bears 760 N, a fifth of its breaking load; a platform of 100 kg needs 1472 N, 1.5 times its",
        ),
        ({"mass": 1e6}, "none of the table does"),
    ],
)
def test_what_no_robot_can_be(given: dict[str, object], says: str) -> None:
    with pytest.raises(InputError) as refusal:
        robot_file(outline(**given))
    assert says in str(refusal.value)


@pytest.mark.parametrize("size", [(0.5, 0.5, 0.5), (100.0, 0.5, 100.0), (0.5, 100.0, 0.5), (100.0, 100.0, 100.0)])
@pytest.mark.parametrize("layout", ["suspended", "over-middle", "body"])
def test_extreme_sizes_are_robots(layout: str, size: tuple[float, float, float]) -> None:
    for name in CABLES:
        scene = robot(layout=layout, size=size, cable=name, mass=1.0).scene
        assert all(low < high for low, high in zip(scene.frame_min, scene.frame_max, strict=True))
