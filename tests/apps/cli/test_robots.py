"""`robots` and `schema`: what is printed can be read back."""

from __future__ import annotations

import json

import jsonschema
import pytest

from cablewright.robot import library_names, library_text, load, loads


def test_robots_lists_the_library(cli) -> None:
    answer = cli("robots")
    assert (answer.code, answer.err) == (0, "")
    assert tuple(line.split()[0] for line in answer.out.splitlines()[2:]) == library_names()
    assert answer.out.splitlines()[1].split() == ["name", "lines", "freedoms", "description"]


def test_robots_as_json(cli) -> None:
    rows = cli("robots", "--json").json["robots"]
    assert [row["name"] for row in rows] == list(library_names())
    size = {row["name"]: (row["lines"], row["freedoms"]) for row in rows}
    assert (size["paty2021"], size["jung2020"], size["grab-four-lines"]) == ((4, 3), (8, 6), (4, 6))


@pytest.mark.parametrize("name", library_names())
def test_a_printed_robot_is_that_robot(cli, name: str) -> None:
    answer = cli("robots", name)
    assert answer.out == library_text(name)
    assert loads(answer.out) == load(name)
    assert cli("robots", name, "--json").json["file"] == answer.out


def test_the_schema_is_a_json_schema(cli) -> None:
    answer = cli("schema")
    assert (answer.code, answer.err) == (0, "")
    jsonschema.validators.validator_for(json.loads(answer.out)).check_schema(json.loads(answer.out))
