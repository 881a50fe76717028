"""The uncertainty in a robot's own file, and what is assumed where there is none."""

from __future__ import annotations

import pytest

from cablewright.foundation.errors import InputError
from cablewright.robot import Robot, assumed_uncertainty, library_names, library_text, load, loads, update
from cablewright.robot.uncertainty import modulus_ranges

TABLE = """
[uncertainty]
coverage = 3.0

[[uncertainty.parameters]]
name = "exit_point"
lines = ["south-west"]
deviation = "1 mm"

[[uncertainty.parameters]]
name = "mass"
factor = [0.9, 1.2]
"""


def house(table: str = TABLE) -> Robot:
    return loads(library_text("house-printer") + table, "house.toml")


def test_it_is_part_of_the_robot() -> None:
    robot = house()
    assert robot.uncertainty is not None
    x, *_, mass = robot.uncertainty.of(robot)
    assert (x.parameter.label, x.low, x.high, x.deviation) == ("exit point x of south-west", -7.503, -7.497, 1e-3)
    assert (mass.low, mass.high) == (180.0, 240.0)
    assert hash(robot) == hash(house())
    assert robot != load("house-printer")


def test_it_is_what_accuracy_takes_by_default() -> None:
    assert [each.parameter.label for each in house().ranges()][-1] == "mass"
    assert load("house-printer").ranges() == modulus_ranges(load("house-printer"))


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('["south-west"]', '["west"]', "uncertainty: parameters[0].lines = ['west']: unknown line 'west'"),
        ('deviation = "1 mm"', 'deviation = "1 kg"', "uncertainty.parameters[0].deviation = '1 kg': must be a finite"),
        ('name = "mass"', 'name = "mas"', "uncertainty.parameters[1].name = 'mas': unknown parameter; did you mean"),
        ("coverage = 3.0", "coverge = 3.0", "uncertainty.coverge = 3.0: unknown key; did you mean 'coverage'?"),
        ("factor = [0.9, 1.2]", "factor = [1.2, 0.9]", "uncertainty.parameters[1].factor"),
    ],
)
def test_what_does_not_fit_the_robot_is_rejected_with_its_key(old: str, new: str, says: str) -> None:
    with pytest.raises(InputError) as refusal:
        house(TABLE.replace(old, new))
    assert str(refusal.value).startswith(f"house.toml: {says}")
    assert "\n" not in str(refusal.value)


def test_a_robot_is_written_back_with_it() -> None:
    text = library_text("house-printer") + TABLE
    robot = loads(text)
    heavier = robot.model_copy(update={"platform": robot.platform.model_copy(update={"mass": 210.0})})
    assert loads(update(text, heavier)) == heavier


@pytest.mark.parametrize("name", library_names())
def test_something_is_assumed_of_every_robot_of_the_library(name: str) -> None:
    robot = load(name)
    by_kind: dict[str, list[float]] = {}
    for each in assumed_uncertainty(robot).of(robot):
        assert each.deviation is None  # uniform
        assert each.low < each.nominal < each.high
        by_kind.setdefault(each.parameter.entry.base, []).append(each.half_width)
    assert set(by_kind) == {"exit_point", "modulus", "length_offset", "mass"}
    assert by_kind["exit_point"] == pytest.approx([0.002] * 3 * robot.m)
    assert by_kind["length_offset"] == pytest.approx([0.0005] * robot.m)
    assert by_kind["mass"] == pytest.approx([0.02 * robot.platform.mass])


@pytest.mark.parametrize(
    ("name", "half_width"), [("house-printer", 0.1), ("wang2021", 0.1), ("merlet2023", 0.3), ("jung2020", 0.3)]
)
def test_steel_and_fibre_are_distinguished_by_density(name: str, half_width: float) -> None:
    robot = load(name)
    moduli = [each for each in assumed_uncertainty(robot).of(robot) if each.parameter.kind == "modulus"]
    assert [each.half_width for each in moduli] == pytest.approx([half_width] * robot.m)


def test_lines_of_both_kinds_and_of_neither() -> None:
    robot = load("house-printer")
    first, second, *rest = robot.lines
    rope = first.model_copy(update={"cable": load("jung2020").lines[0].cable})
    bare = second.cable.model_copy(update={"diameter": None, "section": None, "young_modulus": None,
                                           "axial_stiffness": second.cable.stiffness})  # fmt: skip
    unknown = second.model_copy(update={"cable": bare})
    mixed = robot.model_copy(update={"lines": (rope, unknown, *rest)})
    found = {each.parameter.line: each.half_width for each in assumed_uncertainty(mixed).of(mixed)
             if each.parameter.kind == "modulus"}  # fmt: skip
    assert list(found.values()) == pytest.approx([0.1, 0.1, 0.3, 0.3])
    assert found[first.name] == found[second.name] == pytest.approx(0.3)
