"""Guides that are wheels in robot files: read, rejected in one line, written back, moved along, and drawn."""

from __future__ import annotations

import math
import tomllib

import numpy as np
import pytest
from jsonschema import Draft202012Validator

from cablewright.analyses.sheave_ratio import sheave_rules
from cablewright.apps.web.scene import route
from cablewright.exchange.losses import keys_given, lost_keys
from cablewright.exchange.robot_toml import plain_toml
from cablewright.foundation.errors import InputError
from cablewright.robot import GuideSheave, Parameter, Robot, json_schema, loads, update, with_value
from cablewright.robot.design_variables import Change

WHEEL = '{ centre = [-2.0, -1.0, "1200 mm"], axis = [0, 0, 2], radius = "30 mm" }  # turned'
TEXT = """schema = 1
name = "wheels"
[scene]
frame_min = [-2, -2, 0]
frame_max = [2, 2, 3]
[platform]
mass = 8
[cable]
axial_stiffness = 1e5
linear_density = 0.02
breaking_load = 4e3
diameter = "2 mm"
[sheave]
kind = "eyelet"
[line]
tension_limits = [5, 400]
[[lines]]
name = "a"
exit_point = [-2, -2, 3]
winch_exit = [0, -1.2, 1.2]
guides = [
  [-0.5, -0.2, 1.0],
  GIVEN
]
[[lines]]
name = "b"
exit_point = [2, -2, 3]
[[lines]]
name = "c"
exit_point = [2, 2, 3]
[[lines]]
name = "d"
exit_point = [-2, 2, 3]
"""


def text(wheel: str = WHEEL) -> str:
    return TEXT.replace("GIVEN", wheel)


def first_wheel(robot: Robot) -> GuideSheave:
    wheel = robot.lines[0].guides[1]
    assert isinstance(wheel, GuideSheave)
    return wheel


def test_it_is_read_in_si() -> None:
    assert first_wheel(loads(text())) == GuideSheave(centre=(-2.0, -1.0, 1.2), axis=(0.0, 0.0, 2.0), radius=0.03)


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ("[0, 0, 2]", "[0, 0, 0]", r"lines\[0\].guides\[1\].axis \(line 'a'\) = \[0, 0, 0\]: must not be zero"),
        ('"30 mm"', "0", r"lines\[0\].guides\[1\].radius \(line 'a'\) = 0: must be greater than 0"),
        ('"30 mm"', '"3 kg"', r"guides\[1\].radius \(line 'a'\) = '3 kg': must be a finite length"),
        (', radius = "30 mm"', "", r"lines\[0\].guides\[1\].radius \(line 'a'\): is missing"),
        ("centre", "center", r"guides\[1\].center \(line 'a'\) = .*: unknown key; did you mean 'centre'"),
        (WHEEL, "3", r"lines\[0\].guides\[1\] \(line 'a'\) = 3: must be a list"),
        (WHEEL, "[0, 0]", r"lines\[0\].guides\[1\]\[2\] \(line 'a'\): is missing"),
        ("[0, 0, 2]", "[0, 0, -2]", r"lines\[0\].guides \(line 'a'\): guide 2: the cable passes this wheel by"),
        ('"30 mm"', "4", r"lines\[0\].guides \(line 'a'\): guide 1 is within the rim of guide 2, seen along its axis"),
    ],
)
def test_it_is_rejected_in_one_line(old: str, new: str, why: str) -> None:
    assert old in text()
    with pytest.raises(InputError, match=why) as caught:
        loads(text().replace(old, new))
    assert "\n" not in str(caught.value)
    assert "; " not in str(caught.value).partition("unknown key; ")[0]


def test_the_schema_has_it() -> None:
    validator = Draft202012Validator(json_schema())
    validator.validate(tomllib.loads(text()))
    pulley = text().replace(
        "winch_exit = [0, -1.2, 1.2]", 'sheave = { kind = "pulley", radius = 0.1, axis = [1, 0, 0] }'
    )
    validator.validate(tomllib.loads(pulley))
    for bad in (text().replace("centre", "center"), text().replace('"30 mm"', "0"), text("[1, 2]")):
        assert not validator.is_valid(tomllib.loads(bad))


def test_it_is_written_and_read_back() -> None:
    robot = loads(text())
    assert loads(plain_toml(robot)) == robot
    assert Robot.model_validate_json(robot.model_dump_json()) == robot
    assert update(text(), robot) == text()
    lost = lost_keys(keys_given(robot), "lines.name")
    assert "lines.guides: the format has nothing like it" in lost


def test_a_change_is_written_back_where_it_stands() -> None:
    robot = with_value(loads(text()), Parameter("exit_point.z", "a"), 3.25)
    changed = update(text(), robot)
    assert loads(changed) == robot
    assert '{ centre = [-2.0, -1.0, "1450 mm"], axis = [0, 0, 2], radius = "30 mm" }  # turned' in changed


def test_guides_that_all_lines_share_are_written_back() -> None:
    shared = text().replace("winch_exit = [0, -1.2, 1.2]", "").replace("[line]\n", "[line]\nwinch_exit = [10, 30, 5]\n")
    shared = shared.replace("guides = [\n  [-0.5, -0.2, 1.0],\n  " + WHEEL + "\n]", "")
    shared = shared.replace(
        "[line]\n", "[line]\nguides = [{ centre = [10, 10, 5], axis = [0, 0, -1], radius = 0.01 }]\n"
    )
    robot = loads(shared)
    lines = tuple(
        line.model_copy(update={"guides": (line.guides[0].model_copy(update={"radius": 0.02}),)})
        for line in robot.lines
    )
    changed = robot.model_copy(update={"lines": lines})
    assert loads(update(shared, changed)) == changed


def test_it_moves_with_the_exit_point() -> None:
    robot = loads(text())
    for moved in (
        with_value(robot, Parameter("exit_point.x", "a"), -1.9),
        Change("exit_point.x@a").on(robot, -1.9),
    ):
        assert first_wheel(moved).centre == pytest.approx((-1.9, -1.0, 1.2))
        assert first_wheel(moved).axis == (0.0, 0.0, 2.0)
        line = moved.lines[0]
        assert line.dead_span().length == pytest.approx(robot.lines[0].dead_span().length, abs=1e-14)


def test_it_is_drawn_round_its_rim() -> None:
    line = loads(text()).lines[0]
    points = np.array(route(line))
    assert tuple(points[0]) == line.winch_exit
    assert tuple(points[-1]) == line.exit_point
    away = np.linalg.norm(points - (-2.0, -1.0, 1.2), axis=1)
    on_rim = np.abs(away - 0.03) < 1e-12
    assert on_rim.sum() > 3
    assert away.min() > 0.03 - 1e-12
    drawn = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    assert line.dead_span().length * (1 - 1e-3) < drawn < line.dead_span().length


def test_its_radius_counts_for_the_wear_of_the_cable() -> None:
    (rule,) = sheave_rules(loads(text()))
    assert (rule.line, rule.value) == ("a", pytest.approx(30.0))


def test_without_wheels_they_are_points_at_their_centres() -> None:
    line = loads(text()).lines[0]
    points = [line.winch_exit, line.guides[0], first_wheel(loads(text())).centre, line.exit_point]
    assert line.dead_span(wheels=False).length == pytest.approx(sum(map(math.dist, points, points[1:])), abs=1e-14)
