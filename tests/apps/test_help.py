"""Help, completion and suggestions: what a newcomer meets first."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys

import pytest

from cablewright.apps.cli.help_examples import FURTHER
from cablewright.apps.cli.main import COMMANDS, command
from cablewright.apps.cli.output import print_text
from cablewright.foundation.results import Figure, Result

NAMES = [name for commands in COMMANDS.values() for name in commands]


def test_commands_stand_in_six_groups(cli) -> None:
    help_ = cli("--help").out
    assert list(COMMANDS) == ["Model", "Analyse", "Calibrate", "Print", "Operate", "Tools"]
    places = [help_.index(f"─ {group} ─") for group in COMMANDS]
    assert places == sorted(places)
    assert all(f" {name} " in help_ for name in NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_the_help_of_a_command_shows_its_examples(cli, name: str) -> None:
    answer = cli(name, "--help")
    assert (answer.code, answer.err) == (0, "")
    assert f"Examples: cablewright {name}" in " ".join(answer.out.split())
    assert max(map(len, answer.out.splitlines())) <= 80
    assert "…" not in answer.out  # a word that is too long for its column


@pytest.mark.parametrize("name", NAMES)
def test_further_examples_are_valid(name: str) -> None:
    for example in FURTHER[name]:
        first, *arguments = shlex.split(example)
        assert first == name
        command(name).make_context(name, arguments)


def test_help_keeps_brackets(cli) -> None:
    assert "pip install 'cablewright[web]'" in " ".join(cli("serve", "--help").out.split())
    assert "robot file's [uncertainty]" in " ".join(cli("accuracy", "--help").out.replace("│", " ").split())


@pytest.mark.parametrize("name", NAMES)
def test_each_option_has_a_sentence(name: str) -> None:
    for option in command(name).params:
        text = option.help or ""
        assert text[:1].isupper(), option.name
        assert text.endswith("."), option.name
        assert len(text.split()) >= 3, option.name


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        ("cablewright wor", ["workspace"]),
        ("cablewright workspace jung2020 --crit", ["--criterion"]),
        ("cablewright workspace jung2020 --criterion ex", ["exact"]),
    ],
)
def test_a_shell_completes(words: str, offered: list[str]) -> None:
    state = {"_CABLEWRIGHT_COMPLETE": "complete_bash", "COMP_WORDS": words, "COMP_CWORD": str(len(words.split()) - 1)}
    program = "import sys; sys.argv[0] = 'cablewright'; from cablewright.apps.cli.main import main; main()"
    ended = subprocess.run(
        [sys.executable, "-c", program], env=os.environ | state, capture_output=True, text=True, check=True
    )
    assert ended.stdout.split() == offered


def test_the_nearest_is_suggested(cli) -> None:
    assert "Did you mean 'workspace'?" in cli("workspce").refusal
    assert "--grid" in cli("workspace", "jung2020", "--gird", "3").refusal
    assert "'exact'" in cli("workspace", "jung2020", "--criterion", "exakt").refusal


class _Answer(Result):
    FIGURES = (Figure("status", "", "What became of it."),)

    def __init__(self, status: str, refusal: str) -> None:
        self.status, self._refusal = status, refusal

    @property
    def refusal(self) -> str:
        return self._refusal


@pytest.mark.parametrize(("status", "refusal", "colour"), [("ok", "", "32"), ("infeasible", "a line would push", "31")])
def test_a_verdict_is_coloured_unless_that_is_not_wanted(
    status: str, refusal: str, colour: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[str] = []
    monkeypatch.setattr("typer.echo", said.append)
    print_text(_Answer(status, refusal), {})
    assert said == [f"status  \x1b[{colour}m\x1b[1m{status}\x1b[0m"]
    monkeypatch.setenv("NO_COLOR", "1")
    print_text(_Answer(status, refusal), {})
    assert said[1:] == [f"status  {status}"]
