"""The numbers of a robot that may be uncertain: their names, which robots have them, their values in the file."""

import dataclasses
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cablewright.foundation.errors import InputError, UnknownName
from cablewright.robot import (
    KINDS,
    Eyelet,
    Parameter,
    Robot,
    library_names,
    library_text,
    load,
    nominal,
    parameters_of,
    update,
)
from cablewright.robot.line import Line

HOUSE, BEAM, COGIRO = load("house-printer"), load("jung2020"), load("cogiro")
NAMES = [line.name for line in HOUSE.lines]
OF_LINES = [kind.name for kind in KINDS.values() if kind.per_line]
SHAREABLE = [kind.name for kind in KINDS.values() if kind.shareable]


def with_line(robot: Robot, index: int, **changes: Any) -> Robot:
    """The robot with another value in one line; ``cable`` and ``sheave`` take a table of changes."""
    line = robot.lines[index]
    for part in ("cable", "sheave"):
        if isinstance(changes.get(part), dict):
            changes[part] = getattr(line, part).model_copy(update=changes[part])
    lines = list(robot.lines)
    lines[index] = line.model_copy(update=changes)
    return robot.model_copy(update={"lines": tuple(lines)})


def said(robot: Robot, kind: str) -> list[float]:
    """Values in the file of each line, or of the platform; read without the code under test."""
    key, _, axis = kind.partition(".")
    read: dict[str, Any] = {
        "modulus": lambda line: 1.0,
        "length_offset": lambda line: 0.0,
        "length_scale": lambda line: 1.0,
        "sheave_radius": lambda line: line.sheave.radius,
        "linear_density": lambda line: line.cable.linear_density,
        "drum_radius": lambda line: line.winch.drum_radius,
        "build_up": lambda line: line.winch.build_up or 0.0,
        "creep_compliance": lambda line: 0.0,
        "exit_compliance": lambda line: line.exit_compliance or 0.0,
        "tension_offset": lambda line: 0.0,
        "tension_scale": lambda line: 1.0,
        "swivel_offset": lambda line: 0.0,
    }
    place = {"x": 0, "y": 1, "z": 2}.get(axis)
    if key in ("temperature", "tilt_offset", "yaw_offset"):
        return [0.0]
    if not KINDS[kind].per_line:
        value = getattr(robot.platform, key)
        return [value if place is None else value[place]]
    return [read[key](line) if place is None else getattr(line, key)[place] for line in robot.lines]


def has(robot: Robot, kind: str) -> bool:
    if kind == "sheave_radius":
        return not any(isinstance(line.sheave, Eyelet) for line in robot.lines)
    if kind == "drum_radius":
        return all(line.winch.drum_radius is not None for line in robot.lines)
    if kind == "counterweight":
        return all(line.counterweight is not None for line in robot.lines)
    return robot.n == 6 or not kind.startswith(("platform_point", "centre_of_mass", "moment", "tilt", "yaw"))


def test_the_kinds_are_listed_in_order_and_cannot_be_changed() -> None:
    axes = [f".{axis}" for axis in "xyz"]
    assert list(KINDS) == [
        "modulus",
        *(f"exit_point{axis}" for axis in axes),
        *(f"platform_point{axis}" for axis in axes),
        *(
            "sheave_radius",
            "linear_density",
            "length_offset",
            "length_scale",
            "drum_radius",
            "build_up",
            "counterweight",
            "creep_compliance",
            "exit_compliance",
        ),
        *("temperature", "mass"),
        *(f"centre_of_mass{axis}" for axis in axes),
        *(f"force{axis}" for axis in axes),
        *(f"moment{axis}" for axis in axes),
        *("tension_offset", "tension_scale", "swivel_offset", "tilt_offset.x", "tilt_offset.y", "yaw_offset"),
    ]
    with pytest.raises(TypeError):
        KINDS["modulus"] = KINDS["mass"]  # type: ignore[index]
    with pytest.raises(dataclasses.FrozenInstanceError):
        KINDS["modulus"].name = "mass"  # type: ignore[misc]


@pytest.mark.parametrize("name", KINDS)
def test_a_kind_describes_itself(name: str) -> None:
    kind = KINDS[name]
    assert kind.name == name
    assert kind.meaning
    units = {
        **dict.fromkeys(("modulus", "length_scale", "tension_scale"), "1"),
        **dict.fromkeys(("swivel_offset", "tilt_offset", "yaw_offset"), "rad"),
        "tension_offset": "N",
        "linear_density": "kg/m",
        "build_up": "1/m",
        "creep_compliance": "1/N",
        "exit_compliance": "m/N",
        "temperature": "K",
        "mass": "kg",
        "counterweight": "kg",
        "force": "N",
        "moment": "N m",
    }
    assert kind.unit == units.get(name.partition(".")[0], "m")


ROBOTS = [load(name) for name in library_names()]


@pytest.mark.parametrize("kind", KINDS)
def test_a_nominal_value_is_what_the_file_says(kind: str) -> None:
    for robot in ROBOTS:
        if not has(robot, kind):
            with pytest.raises(InputError, match=kind):
                parameters_of(robot, kind)
            continue
        parameters = parameters_of(robot, kind)
        assert [nominal(robot, parameter) for parameter in parameters] == said(robot, kind), robot.name
        lines = [line.name for line in robot.lines] if KINDS[kind].per_line else [None]
        assert parameters == tuple(Parameter(kind, line) for line in lines), robot.name
        assert {parameter.unit for parameter in parameters} == {KINDS[kind].unit}


@given(st.sampled_from([kind for kind in OF_LINES if has(HOUSE, kind)]), st.sets(st.sampled_from(NAMES), min_size=1))
def test_lines_come_in_the_order_of_the_robot(kind: str, names: set[str]) -> None:
    found = parameters_of(HOUSE, kind, sorted(names, reverse=True))
    assert [parameter.line for parameter in found] == [name for name in NAMES if name in names]


@pytest.mark.parametrize("kind", SHAREABLE)
def test_lines_that_agree_may_share_a_number(kind: str) -> None:
    assert parameters_of(HOUSE, kind, shared=True) == (Parameter(kind),)
    assert nominal(HOUSE, Parameter(kind)) == said(HOUSE, kind)[0]


@pytest.mark.parametrize(
    ("kind", "changes", "match"),
    [
        ("sheave_radius", {"sheave": {"radius": 0.04}}, "0.05 m of 'south-west', 0.04 m of 'north-east'"),
        ("linear_density", {"cable": {"linear_density": 0.02}}, "0.03 kg/m of 'south-west', 0.02 kg/m of 'north-east'"),
    ],
)
def test_lines_that_differ_share_no_number_unless_it_is_relative(kind: str, changes: Any, match: str) -> None:
    robot = with_line(HOUSE, 2, **changes)
    for call in (lambda: parameters_of(robot, kind, shared=True), lambda: nominal(robot, Parameter(kind))):
        with pytest.raises(InputError, match=rf"^{kind}: the lines have no {kind} in common: {match}$"):
            call()
    assert len(parameters_of(robot, kind)) == 4
    for relative in ("modulus", "length_offset", "length_scale"):
        assert parameters_of(robot, relative, shared=True) == (Parameter(relative),)


@pytest.mark.parametrize(
    ("robot", "kind", "options", "message"),
    [
        (HOUSE, "modullus", {}, "unknown parameter 'modullus'; did you mean 'modulus'?"),
        (HOUSE, "exit_point", {}, "unknown parameter 'exit_point'; did you mean 'exit_point."),
        (HOUSE, "modulus", {"lines": ["sout-west"]}, "modulus: unknown line 'sout-west'; did you mean 'south-west'"),
        (HOUSE, "modulus", {"lines": []}, "modulus: must name at least one line"),
        (HOUSE, "modulus", {"lines": ["a", "a"]}, "modulus: names 'a' more than once"),
        (HOUSE, "modulus", {"lines": ["south-west"], "shared": True}, "modulus: is one number for all lines: leave"),
        (HOUSE, "exit_point.x", {"shared": True}, "exit_point.x cannot be shared by lines: each line has its own"),
        (HOUSE, "mass", {"shared": True}, "mass cannot be shared by lines: it is a number of the platform"),
        (HOUSE, "mass", {"lines": ["south-west"]}, "mass is a number of the platform, not of a line"),
        (HOUSE, "temperature", {"lines": ["south-west"]}, "temperature is one number for all lines, not of a line"),
        (HOUSE, "moment.x", {}, "moment.x: 'house-printer' is a point platform, which has no moment"),
        (HOUSE, "centre_of_mass.y", {}, "is a point platform, which has no centre_of_mass"),
        (HOUSE, "platform_point.z", {"lines": ["south-west"]}, "is a point platform, which has no platform_point"),
        (BEAM, "sheave_radius", {}, "sheave_radius: line '1' has an eyelet, which has no radius"),
        (BEAM, "sheave_radius", {"lines": ["2"]}, "sheave_radius: line '2' has an eyelet, which has no radius"),
        (BEAM, "sheave_radius", {"shared": True}, "sheave_radius: line '1' has an eyelet"),
        (
            with_line(HOUSE, 1, cable={"thermal_expansion": None}),
            "temperature",
            {},
            "temperature: line 'south-east' gives no cable.thermal_expansion, which this needs",
        ),
    ],
)
def test_parameters_that_a_robot_does_not_have_are_rejected_in_one_line(
    robot: Robot, kind: str, options: Any, message: str
) -> None:
    with pytest.raises(InputError) as error:
        parameters_of(robot, kind, **options)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_an_eyelet_elsewhere_is_in_nobodys_way() -> None:
    robot = with_line(HOUSE, 0, sheave=Eyelet())
    assert parameters_of(robot, "sheave_radius", [NAMES[1]]) == (Parameter("sheave_radius", NAMES[1]),)
    with pytest.raises(InputError, match="'south-west' has an eyelet"):
        nominal(robot, Parameter("sheave_radius", NAMES[0]))


def test_a_parameter_that_cannot_be_is_not_made() -> None:
    with pytest.raises(UnknownName, match="did you mean 'mass'"):
        Parameter("mas")
    with pytest.raises(InputError, match="mass is a number of the platform, not of a line"):
        Parameter("mass", "south-west")
    with pytest.raises(InputError, match=r"exit_point\.x cannot be shared by lines"):
        Parameter("exit_point.x")


def test_the_nominal_value_of_a_missing_parameter_is_rejected() -> None:
    with pytest.raises(InputError, match="unknown line 'x'"):
        nominal(HOUSE, Parameter("modulus", "x"))
    with pytest.raises(InputError, match=r"moment\.z: 'house-printer' is a point platform"):
        nominal(HOUSE, Parameter("moment.z"))


def test_labels_are_for_people() -> None:
    labels = {
        Parameter("modulus", "south-west"): "modulus of south-west",
        Parameter("modulus"): "modulus of all lines",
        Parameter("exit_point.x", "a"): "exit point x of a",
        Parameter("temperature"): "temperature",
        Parameter("mass"): "mass",
        Parameter("centre_of_mass.z"): "centre of mass z",
    }
    assert {parameter: parameter.label for parameter in labels} == labels


def test_labels_distinguish_the_parameters_of_a_robot() -> None:
    every = [one for kind in KINDS for one in (parameters_of(COGIRO, kind) if has(COGIRO, kind) else ())]
    assert len({one.label for one in every}) == len({*every}) == len(every)


def test_what_is_physical() -> None:
    bounded = {kind for kind in KINDS if kind.endswith(("_scale", "_radius", "_density", "mass", "weight", "modulus"))}
    for name, kind in KINDS.items():
        assert kind.allows(1e-9)
        assert kind.allows(0.0) == (name not in bounded)
        assert kind.allows(-1.0) == (name not in (*bounded, "creep_compliance", "exit_compliance"))
        assert kind.bound.startswith("must be at least" if kind.closed else "must be above")


def test_a_load_in_place_is_the_nominal() -> None:
    assert nominal(HOUSE.under_wrench((1.0, 2.0, 3.0)), Parameter("force.y")) == 2.0
    assert nominal(COGIRO.under_wrench((0, 0, 0), (4.0, 5.0, 6.0)), Parameter("moment.z")) == 6.0


def test_a_line_moves_with_the_retraction() -> None:
    moved = BEAM.retracted(1.6)
    line: Line = moved.lines[0]
    assert nominal(moved, Parameter("platform_point.z", line.name)) == line.platform_point[2]
    assert nominal(moved, Parameter("platform_point.z", line.name)) != BEAM.lines[0].platform_point[2]


@pytest.mark.parametrize(
    ("value", "si"), [("12 ppm/K", 12e-6), ("-12 ppm/K", -12e-6), ("1.2e-5 /K", 12e-6), (12e-6, 12e-6), (0, 0.0)]
)
def test_a_cable_may_say_how_it_grows_with_temperature(value: object, si: float) -> None:
    cable = HOUSE.lines[0].cable
    assert type(cable).model_validate(cable.model_dump() | {"thermal_expansion": value}).thermal_expansion == si
    with pytest.raises(ValueError, match="must be a finite thermal expansion"):
        type(cable).model_validate(cable.model_dump() | {"thermal_expansion": "12 1/K"})


def test_a_changed_thermal_expansion_keeps_its_unit() -> None:
    robot = HOUSE
    for index in range(HOUSE.m):
        robot = with_line(robot, index, cable={"thermal_expansion": 16e-6})
    assert 'thermal_expansion = "16 ppm/K" ' in update(library_text("house-printer"), robot)
