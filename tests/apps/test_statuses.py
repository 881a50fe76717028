"""The page of statuses: each command on it gives what stands beside it."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from cablewright.foundation.errors import Status

PAGE = (Path(__file__).parents[2] / "docs" / "statuses.md").read_text("utf-8")
STATUSES = re.findall(r"^\| `([\w-]+)` \|[^|]*\| `cablewright (.*)` \|$", PAGE, re.MULTILINE)
CODES = re.findall(r"^\| (\d) \|[^|]*\| `cablewright (.*)` \|$", PAGE, re.MULTILINE)
BAD = (
    "workspce",  # unknown command
    "workspace jung2020 --gird 3",  # unknown option
    "workspace jung2020 --criterion exakt",  # misspelt choice
    "inverse paty2012 --at 0,0,1",  # unknown robot
    "inverse merlet2023",  # missing option
    "inverse merlet2023 --at 0,zero,1",  # invalid number
    "inverse merlet2023 --at 0,1",  # too few numbers
    "inverse merlet2023 --at 0,0,1 --tension-limits 200,10",  # limits in the wrong order
    "inverse merlet2023 --at 0,0,1 --slack north-wst=0.1",  # unknown line
    "modulus examples/tensile.csv --initial-length '2 ell' --robot paty2021",  # unknown unit
    "check house-printer no-such-part.gcode",  # missing file
)


@pytest.mark.parametrize(("status", "command"), STATUSES)
def test_a_command_gives_its_status(cli, status: str, command: str) -> None:
    answer = cli(*shlex.split(command), "--json")
    assert answer.json["status"] == status
    assert answer.code == (0 if status == "ok" else 1)


def test_every_status_is_on_the_page() -> None:
    named = {status for status, _ in STATUSES} | set(re.findall(r"`(lever-unstable|jumped|fold|uncertified)` \(", PAGE))
    assert named == {each.word for each in Status}


@pytest.mark.parametrize(("code", "command"), CODES)
def test_a_command_gives_its_exit_code(cli, code: str, command: str) -> None:
    assert cli(*shlex.split(command)).code == int(code)


@pytest.mark.parametrize("command", BAD)
def test_bad_input_is_one_line(cli, command: str) -> None:
    assert cli(*shlex.split(command)).refusal


def test_levers_on_their_head_are_among_all_equilibria(cli) -> None:
    (command,) = re.findall(r"`cablewright\s+(equilibria [^`]*)`", PAGE)
    assert "lever-unstable" in {each["status"] for each in cli(*shlex.split(command), "--json").json["solutions"]}


def test_the_tables_are_read() -> None:
    assert (len(STATUSES), len(CODES)) == (11, 4)
