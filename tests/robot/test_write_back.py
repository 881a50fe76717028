"""Writing back: what changed is changed where it stands, everything else stays byte for byte."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cablewright.foundation.errors import InputError
from cablewright.robot import Robot, library_names, library_text, load, loads, update

PATY = library_text("paty2021")
HEADED = library_text("merlet2023").replace(
    "winch_exit = [2.5, 5.0, 0.0]\n",
    "winch_exit = [ 2.5, '500 cm', 0.0 ] # measured\n\n[lines.cable] # worn\nyoung_modulus = '95 GPa' # softer\n",
)


def edited(text: str, edit: Callable[[dict[str, Any]], None]) -> Robot:
    """Return the robot of a text after an edit of its dump."""
    values = loads(text).model_dump()
    edit(values)
    return Robot.model_validate(values)


def rewritten(text: str, edit: Callable[[dict[str, Any]], None]) -> list[tuple[str, str]]:
    """Return the lines of the text that `update` changed, before and after."""
    robot = edited(text, edit)
    result = update(text, robot)
    assert loads(result) == robot
    before, after = text.splitlines(), result.splitlines()
    assert len(before) == len(after)
    return [pair for pair in zip(before, after, strict=True) if pair[0] != pair[1]]


@pytest.mark.parametrize("name", library_names())
def test_nothing_changed_changes_nothing(name: str) -> None:
    assert update(library_text(name), load(name)) == library_text(name)


def test_a_changed_value_keeps_its_unit_and_comment() -> None:
    def edit(values: dict[str, Any]) -> None:
        values["scene"]["gravity"] = 9.80665

    assert rewritten(PATY, edit) == [
        ('gravity = "9.81 m/s^2"          # assumed: the paper does not print it',
         'gravity = "9.80665 m/s^2"          # assumed: the paper does not print it')
    ]  # fmt: skip


def test_one_coordinate_leaves_the_others_alone() -> None:
    def edit(values: dict[str, Any]) -> None:
        values["lines"][2]["winch_exit"] = (2.5, 5.0, 0.01)

    assert rewritten(HEADED, edit) == [
        ("winch_exit = [ 2.5, '500 cm', 0.0 ] # measured", "winch_exit = [ 2.5, '500 cm', 0.01 ] # measured")
    ]


def test_a_default_changed_equally_for_all_is_changed_once() -> None:
    def edit(values: dict[str, Any]) -> None:
        for line in values["lines"]:
            line["cable"]["section"] = 12.27e-6
            line["tension_limits"] = (20.0, 5150.0)

    assert rewritten(PATY, edit) == [
        ('section = "12.566370614359172 mm^2"  # assumed: full 4 mm circle, the paper\'s section S0 is not given',
         'section = "12.27 mm^2"  # assumed: full 4 mm circle, the paper\'s section S0 is not given'),
        ('tension_limits = ["0.51 kN", "5.15 kN"]  # 5 % and 50 % of the breaking load',
         'tension_limits = ["0.02 kN", "5.15 kN"]  # 5 % and 50 % of the breaking load'),
    ]  # fmt: skip


def test_a_default_changed_for_some_is_overridden_in_those_lines() -> None:
    def edit(values: dict[str, Any]) -> None:
        values["lines"][1]["cable"]["young_modulus"] = 95e9
        values["lines"][3]["winch"]["drum_radius"] = 0.2

    robot = edited(PATY, edit)
    result = update(PATY, robot)
    assert loads(result) == robot
    added = [line for line in result.splitlines() if line not in PATY.splitlines()]
    assert added == ['cable = {young_modulus = "95 GPa"}', "winch = {drum_radius = 0.2}"]
    assert [line for line in PATY.splitlines() if line not in result.splitlines()] == []


def test_a_line_with_a_table_of_its_own_takes_further_keys() -> None:
    def edit(values: dict[str, Any]) -> None:
        values["lines"][2]["cable"] |= {"young_modulus": 90e9, "breaking_load": 11e3}
        values["lines"][2]["dead_elastic"] = False
        values["lines"][2]["winch"]["capacity"] = 200.0

    robot = edited(HEADED, edit)
    result = update(HEADED, robot)
    assert loads(result) == robot
    assert "young_modulus = '95 GPa' # softer" not in result
    assert '"90 GPa" # softer' in result


def test_names_and_missing_values_can_change() -> None:
    def edit(values: dict[str, Any]) -> None:
        values["name"] = 'a "new" name'
        values["lines"][0]["name"] = "sw"
        for line in values["lines"]:
            line["cable"]["diameter"] = None

    result = update(PATY, edited(PATY, edit))
    assert loads(result) == edited(PATY, edit)
    assert "diameter" not in result


def test_a_retracted_robot_is_written_back() -> None:
    text, robot = library_text("jung2020"), load("jung2020").retracted(1.25)
    result = update(text, robot)
    assert loads(result) == robot
    before, after = text.splitlines(), result.splitlines()
    changed = [pair for pair in zip(before, after, strict=True) if pair[0] != pair[1]]
    assert changed[0] == ('length = "2.0 m"', 'length = "1.25 m"')
    assert changed[1] == ("platform_point = [0.02, 0.02, 1.8]", "platform_point = [0.02, 0.02, 1.05]")
    assert len(changed) == 5


LOADED = PATY.replace(
    'mass = "200 kg"\n',
    'mass = "200 kg"\n\n[[platform.loads]]\nname = "windy"\nforce = ["1 kN", 0, 0] # gust\n',
)


def test_a_load_keeps_its_units_and_comment() -> None:
    def edit(values: dict[str, Any]) -> None:
        values["platform"]["loads"] = ({"name": "gusty", "force": (2000.0, 0.0, 5.0)},)

    assert rewritten(LOADED, edit) == [
        ('name = "windy"', 'name = "gusty"'),
        ('force = ["1 kN", 0, 0] # gust', 'force = ["2 kN", 0, 5.0] # gust'),
    ]


def test_what_the_file_leaves_to_its_default_is_added() -> None:
    def edit(values: dict[str, Any]) -> None:
        values["platform"] |= {"force": (0.0, 3.0, 0.0), "nozzle": (0.0, 0.0, -0.2)}
        values["platform"]["retraction"]["direction"] = (0.0, 0.1, 1.0)
        values["platform"]["loads"] = ()

    text = library_text("jung2020").replace("nozzle = [0.0, 0.0, 0.0]\n", "").replace("direction = [0, 0, 1]\n", "")
    robot = edited(text, edit)
    result = update(text, robot)
    assert loads(result) == robot
    added = [line for line in result.splitlines() if line not in text.splitlines()]
    assert sorted(added) == ["direction = [0.0, 0.1, 1.0]", "force = [0.0, 3.0, 0.0]", "nozzle = [0.0, 0.0, -0.2]"]


def test_a_load_takes_further_values() -> None:
    def edit(values: dict[str, Any]) -> None:
        values["platform"]["loads"] = ({"name": "windy", "mass": 250.0},)

    robot = edited(LOADED, edit)
    result = update(LOADED, robot)
    assert loads(result) == robot
    assert "gust" not in result
    assert "mass = 250.0" in result


def test_loads_and_a_retraction_come_and_go() -> None:
    def edit(values: dict[str, Any]) -> None:
        values["platform"]["loads"] = ({"name": "full", "mass": 13.0}, {"name": "windy", "force": (9.0, 0.0, 0.0)})
        values["platform"]["retraction"] = None

    text = library_text("jung2020")
    result = update(text, edited(text, edit))
    assert loads(result) == edited(text, edit)
    assert result.count("[[platform.loads]]") == 2
    assert "retraction" not in result
    assert loads(update(result, load("jung2020"))) == load("jung2020")


def test_a_robot_under_load_is_written_back() -> None:
    robot = loads(LOADED).under_load("windy")
    assert loads(update(LOADED, robot)) == robot


@pytest.mark.parametrize(
    ("edit", "match"),
    [
        (lambda values: values.update(lines=values["lines"][:3]), "has 4 lines, the robot has 3"),
        (lambda values: values["lines"][0]["cable"].update(diameter=None), "more than values"),
    ],
)
def test_what_is_no_change_of_values_is_rejected(edit: Callable[[dict[str, Any]], None], match: str) -> None:
    with pytest.raises(InputError, match=match):
        update(PATY, edited(PATY, edit))


def test_a_text_that_is_no_robot_is_rejected() -> None:
    with pytest.raises(InputError, match="the file to update"):
        update("schema = 1", load("paty2021"))


QUANTITIES = st.floats(0.9, 1.1)


@settings(max_examples=25, deadline=None)
@given(st.sampled_from([PATY, HEADED, library_text("wang2021")]), st.lists(QUANTITIES, min_size=12, max_size=12))
def test_any_numbers_come_back_exactly(text: str, factors: list[float]) -> None:
    def edit(values: dict[str, Any]) -> None:
        values["platform"]["mass"] *= factors[0]
        for line, factor in zip(values["lines"], factors[1:5], strict=True):
            line["cable"]["young_modulus"] *= factor
            line["sheave"]["radius"] *= 2 - factors[5]
        for line, factor in zip(values["lines"], factors[6:10], strict=True):
            x, y, z = line["exit_point"]
            line["exit_point"] = (x, y, z * factor)
            line["tension_limits"] = (line["tension_limits"][0] * factor, line["tension_limits"][1])

    robot = edited(text, edit)
    assert loads(update(text, robot)) == robot
