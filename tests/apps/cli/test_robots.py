"""`robots` and `schema`: what is printed can be read back."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import get_args

import jsonschema
import pytest

from cablewright.foundation.choices import FileKind
from cablewright.machine.files import machine_names, machine_text
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


EXAMPLES = Path(__file__).parents[3] / "examples"
FILES = {
    "robot": [library_text(name) for name in library_names()],
    "job": [(EXAMPLES / name).read_text() for name in ("house.toml", "helix.toml", "blind-machines.toml")],
    "machine": [machine_text(name) for name in machine_names()],
    "uncertainty": [(EXAMPLES / "uncertain.toml").read_text()],
    "calibration": ['schema = 1\nunknowns = ["exit_point"]\nlevel = "1 deg"\n'],
    "survey": [(EXAMPLES / "survey.toml").read_text()],
}


@pytest.mark.parametrize("kind", get_args(FileKind))
def test_the_schema_of_a_kind_is_one_and_takes_its_files(cli, kind: str) -> None:
    answer = cli("schema", kind)
    assert (answer.code, answer.err) == (0, "")
    schema = json.loads(answer.out)
    validator = jsonschema.validators.validator_for(schema)
    validator.check_schema(schema)
    for text in FILES[kind]:
        validator(schema).validate(tomllib.loads(text))
    assert list(validator(schema).iter_errors({"schema": 1, "no such key": 1}))
