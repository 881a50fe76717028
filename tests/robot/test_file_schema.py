"""The JSON Schema of robot files accepts what `loads` accepts, and catches what an editor should."""

import tomllib
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from cablewright.robot import json_schema, library_names, library_text

VALIDATOR = Draft202012Validator(json_schema())


def house() -> dict[str, Any]:
    return tomllib.loads(library_text("house-printer"))


def test_the_schema_is_a_schema() -> None:
    Draft202012Validator.check_schema(json_schema())


@pytest.mark.parametrize("name", library_names())
def test_each_library_file_satisfies_it(name: str) -> None:
    VALIDATOR.validate(tomllib.loads(library_text(name)))


def test_a_line_may_override_part_of_a_default() -> None:
    document = house()
    document["lines"][0] |= {"cable": {"young_modulus": 95e9}, "sheave": {"kind": "eyelet"}, "dead_elastic": False}
    document["winch"] = {"capacity": "3 m"}
    VALIDATOR.validate(document)


RIGID: dict[str, Any] = {
    "kind": "rigid",
    "mass": "1 kg",
    "inertia": ["1 kg m^2", 1, 1],
    "loads": [{"name": "full", "mass": 2, "moment": [0, "1 N m", 0]}],
    "retraction": {"length": 1, "least": "50 cm", "most": 2, "direction": [0, 0, -1], "lines": ["x"]},
}


@pytest.mark.parametrize("platform", [{"mass": 1}, {"kind": "point", "mass": 1, "loads": [{"name": "x"}]}, RIGID])
def test_a_platform_of_either_kind(platform: dict[str, Any]) -> None:
    VALIDATOR.validate(house() | {"platform": platform})


@pytest.mark.parametrize(
    "change",
    [
        {"schema": "one"},
        {"cabel": {}},
        {"line": {"name": "x"}},
        {"line": {"tension_limits": ["1 N"]}},
        {"cable": {"young_modulus": "5 kg"}},
        {"cable": {"young_modulus": -5}},
        {"platform": {}},
        {"platform": {"mass": True}},
        {"platform": {"mass": 1, "kind": "body"}},
        {"platform": {"mass": 1, "inertia": [1, 1, 1]}},
        {"platform": RIGID | {"mass": 0}},
        {"platform": RIGID | {"inertia": [1, 1]}},
        {"platform": RIGID | {"moment": ["1 kN", 0, 0]}},
        {"platform": RIGID | {"loads": [{"mass": 2}]}},
        {"platform": RIGID | {"retraction": {"length": 1}}},
        {"sheave": {"kind": "swivle"}},
        {"sheave": {"radius": "5 mm", "lvr": 3}},
        {"lines": [{}]},
        {"lines": 3},
        {"name": 3},
    ],
)
def test_it_rejects(change: dict[str, Any]) -> None:
    assert not VALIDATOR.is_valid(house() | change)
