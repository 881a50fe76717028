"""What commands print is declared: each example runs, and each key of its JSON is a figure of the docs' table."""

from __future__ import annotations

import os
import runpy
import shlex
import shutil
from collections.abc import Iterator, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from cablewright.apps.cli.main import COMMANDS
from cablewright.foundation.results import Figure
from cases import some

ROOT = Path(__file__).parents[2]
TOOL = runpy.run_path(str(ROOT / "tools" / "pages" / "figures.py"))
HOMES = {name: home for commands in COMMANDS.values() for name, (home, _) in commands.items()}


def _kind(name: str) -> Any:
    module, kind = HOMES[name].rsplit(".", 1)
    return getattr(import_module(f"cablewright.apps.cli.{module}"), kind)


def _undeclared(value: Any, figures: tuple[Figure, ...], path: str = "") -> Iterator[str]:
    """Keys in *value* that none of *figures* declares. A mapping by name has the figures in each of its values."""
    if isinstance(value, list):
        for each in value:
            yield from _undeclared(each, figures, f"{path}[]")
    elif isinstance(value, Mapping) and figures:
        by_key = {each.key: each for each in figures}
        if not by_key.keys() & value.keys():
            for each in value.values():
                yield from _undeclared(each, figures, f"{path}.*")
            return
        for key, each in value.items():
            if key not in by_key:
                yield f"{path}.{key}"
            elif by_key[key].parts:
                yield from _undeclared(each, by_key[key].parts, f"{path}.{key}")


@pytest.fixture(scope="module")
def _elsewhere(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Examples name files of the repository, and write below `runs/`: into a copy of the examples."""
    folder = tmp_path_factory.mktemp("examples")
    shutil.copytree(ROOT / "examples", folder / "examples")
    before = Path.cwd()
    os.chdir(folder)
    yield
    os.chdir(before)


TEXT_ELSEWHERE = {"print", "check"}  # take seconds: tests of their own check their text
RESUMED = {"campaign"}  # reads its stored results
LONG = {"print", "campaign", "stages", "fit"}  # s, and tests of their own read their figures
ENDLESS = {"serve"}  # goes on until it is stopped: `tests/apps/serve` does both
LONG_LAST = sorted(HOMES.keys() - ENDLESS, key=lambda name: (name in LONG, name))


@pytest.mark.usefixtures("_elsewhere", "undrawn")
@pytest.mark.parametrize("name", some(LONG_LAST, len(LONG_LAST) - len(LONG)))
def test_the_example_of_a_command_runs_and_its_json_is_declared(cli, name: str) -> None:
    kind = _kind(name)
    command, *arguments = shlex.split(kind.example)
    assert command == name
    if name not in TEXT_ELSEWHERE:
        answer = cli(command, *arguments)
        assert answer.code == 0, answer.err
        assert answer.out
        if not kind.answers:
            return
        for made in () if name in RESUMED else ("runs", "workshop"):  # a print and a robot begin in a new folder
            shutil.rmtree(made, ignore_errors=True)
    printed = cli(command, *arguments, "--json").json
    options = {
        "schema",
        "plot",
        "report",
        "out",
        "file",
        "mesh",
        "vtu",
        "robot",
        "lengths",
        "truth",
        "log",
        "robots",
        "record",
    }
    missing = {}
    for answered in kind.answers:
        missing[answered] = {key for key in _undeclared(printed, TOOL["declared"](answered)) if key[1:] not in options}
    assert set() in missing.values(), missing


def test_the_page_of_figures_is_as_the_code_declares() -> None:
    assert (ROOT / "docs" / "figures.md").read_text(encoding="utf-8") == TOOL["page"]()


@pytest.mark.parametrize("name", HOMES)
def test_each_figure_has_a_meaning_in_a_sentence(name: str) -> None:
    for answered in _kind(name).answers:
        for path, figure in TOOL["_flat"](TOOL["declared"](answered), ""):
            assert figure.meaning.endswith("."), (answered, path)
            assert len(figure.meaning.split()) >= 2 or figure.meaning == "ok.", (answered, path)
