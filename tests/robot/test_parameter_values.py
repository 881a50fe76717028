"""Laws of the registry: reading and setting a number of a robot are inverse, and move nothing else."""

from __future__ import annotations

from typing import Any

import pytest

import cases
from cablewright.foundation.errors import InputError
from cablewright.robot import KINDS, Kind, Parameter, Robot, load, nominal, with_value
from cablewright.robot.parameter_values import with_exit_point
from cablewright.robot.parameters import KINDS_OF, parameters_of, why_not

ROBOTS = cases.robots()
HELD = [
    pytest.param(robot, kind, id=f"{robot.name}-{kind.name}")
    for robot in ROBOTS
    for kind in KINDS.values()
    if kind.described and why_not(robot, kind, None, False) is None
    if kind.name != "build_up" or all(line.winch.build_up for line in robot.lines)  # a file without it does not take it
]
PLACES = {
    "sheave_radius": "sheave.radius",
    "linear_density": "cable.linear_density",
    "drum_radius": "winch.drum_radius",
    "build_up": "winch.build_up",
}


def leaves(value: Any, place: str = "") -> dict[str, Any]:
    """Values of a description, by place: ``lines.0.exit_point.x``."""
    if isinstance(value, tuple):
        names = "xyz" if len(value) == 3 and isinstance(value[0], float) else map(str, range(len(value)))
        value = dict(zip(names, value, strict=True))
    if not isinstance(value, dict):
        return {place[1:]: value}
    return {key: held for name, part in value.items() for key, held in leaves(part, f"{place}.{name}").items()}


def differing(one: Robot, other: Robot) -> set[str]:
    before, after = leaves(one.model_dump()), leaves(other.model_dump())
    assert before.keys() == after.keys()
    return {place for place, value in before.items() if after[place] != value}


def expected(robot: Robot, parameter: Parameter) -> set[str]:
    """The places that a number's change moves."""
    if not KINDS[parameter.kind].per_line:
        return {f"platform.{parameter.kind}"}
    at = [line.name for line in robot.lines].index(parameter.line or "")
    line, kind = robot.lines[at], parameter.kind
    places = [PLACES.get(kind, kind)]
    if kind == "modulus":
        places = ["cable.axial_stiffness" if line.cable.axial_stiffness is not None else "cable.young_modulus"]
    if kind in ("exit_point.x", "exit_point.y") and line.winch_exit is not None:
        places.append(kind.replace("exit_point", "winch_exit"))
    return {f"lines.{at}.{place}" for place in places}


@pytest.mark.parametrize(("robot", "kind"), HELD)
def test_reading_and_setting_are_inverse_and_move_nothing_else(robot: Robot, kind: Kind) -> None:
    for parameter in parameters_of(robot, kind.name):
        was = nominal(robot, parameter)
        value = was * 2.0 if was else 0.37
        changed = with_value(robot, parameter, value)
        assert with_value(robot, parameter, was) == robot
        assert differing(robot, changed) == expected(robot, parameter)
        if kind.nominal is None:
            assert nominal(changed, parameter) == value
            assert differing(robot, with_value(changed, parameter, was)) <= expected(robot, parameter)
            assert nominal(with_value(changed, parameter, was), parameter) == was
        else:  # a factor: what there is then is the nominal
            assert nominal(changed, parameter) == was
            assert with_value(changed, parameter, 0.5) == robot


@pytest.mark.parametrize(
    "kind",
    [kind for kind in KINDS.values() if kind.shareable and kind.described and kind.name != "build_up"],
    ids=lambda kind: kind.name,
)
def test_a_shared_number_is_that_of_every_line(kind: Kind) -> None:
    robot = load("house-printer")
    together = with_value(robot, Parameter(kind.name), 0.8)
    apart = robot
    for parameter in parameters_of(robot, kind.name):
        apart = with_value(apart, parameter, 0.8)
    assert together == apart != robot


def test_what_no_description_has_is_not_set() -> None:
    robot = load("house-printer")
    for name in ("length_offset", "length_scale"):
        with pytest.raises(InputError, match=f"{name}: is not a number of a robot file"):
            with_value(robot, Parameter(name, "south-west"), 0.5)
    with pytest.raises(InputError, match=r"build_up: line 'south-west' has no winch.build_up"):
        with_value(robot, Parameter("build_up", "south-west"), 0.5)
    with pytest.raises(InputError, match="it must be above 0"):
        with_value(robot, Parameter("mass"), 0.0)
    with pytest.raises(InputError, match="unknown line 'x'"):
        with_value(robot, Parameter("modulus", "x"), 2.0)


def test_the_winch_exit_follows_sideways_and_rises_as_given() -> None:
    line = load("merlet2023").lines[0]
    (x, y, z), (cx, cy, cz) = line.exit_point, line.winch_exit
    moved = with_exit_point(line, (x + 0.5, y - 0.25, z + 1.0), rise=0.125)
    assert (moved.exit_point, moved.winch_exit) == ((x + 0.5, y - 0.25, z + 1.0), (cx + 0.5, cy - 0.25, cz + 0.125))
    assert with_exit_point(line, line.exit_point) == line


def test_short_names_are_the_axes_in_order() -> None:
    for name, kinds in KINDS_OF.items():
        axes = "xy" if name == "tilt_offset" else "xyz"  # a yaw has a name of its own
        assert [kind.name for kind in kinds] == ([name] if name in KINDS else [f"{name}.{axis}" for axis in axes])
        assert [kind.axis for kind in kinds] == (
            [*range(len(axes))] if name not in KINDS else [None if "." not in name else "xyz".index(name[-1])]
        )
    assert set(KINDS) <= set(KINDS_OF)
