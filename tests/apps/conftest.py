"""The command line, called in this process."""

from __future__ import annotations

import io
import json
import re
from collections.abc import Callable, Iterator
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from typing import Any

import pytest
from matplotlib.figure import Figure

from cablewright.apps import style
from cablewright.apps.cli import main

MARKUP = re.compile(r"\\math")  # of TeX, which pictures do not typeset; a name may have a dollar


def _no_constant(word: str) -> None:
    raise ValueError(f"{word} is no JSON")


@dataclass(frozen=True)
class Outcome:
    """What a command answered."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> dict[str, Any]:
        """The one object on stdout; NaN and Infinity, which Python would let pass, are rejected."""
        found = json.loads(self.out, parse_constant=_no_constant)
        assert isinstance(found, dict)
        assert found["schema"] == 3
        return found

    def figure(self, label: str) -> str:
        """What people read of a figure."""
        return next(row.removeprefix(label).strip() for row in self.out.splitlines() if row.startswith(f"{label}  "))

    @property
    def rows(self) -> list[list[str]]:
        """The cells of all lines that people read: what stands apart by two spaces or more."""
        return [re.split(r" {2,}", row.strip()) for row in self.out.splitlines() if row.strip()]

    @property
    def refusal(self) -> str:
        """The line of a bad input: the only one on stderr, with nothing on stdout."""
        assert self.code == 2, self
        assert self.out == ""
        assert self.err.endswith("\n")
        assert self.err.count("\n") == 1, self.err
        assert self.err.startswith("cablewright: ")
        line = self.err.removeprefix("cablewright: ").strip()
        assert line
        return line

    @property
    def no(self) -> str:
        """The sentence of a no: the last line on stderr."""
        assert self.code == 1, self
        assert "Traceback" not in self.err
        return self.err.splitlines()[-1].removeprefix("cablewright: ")


@pytest.fixture(scope="session")
def cli() -> Callable[..., Outcome]:
    """Run a command. Kernels are compiled before the first, so that no notice of it is on stderr."""

    def run(*arguments: object) -> Outcome:
        out, err = io.StringIO(), io.StringIO()
        with redirect_stdout(out), redirect_stderr(err):
            code = main.run([str(argument) for argument in arguments])
        return Outcome(code, out.getvalue(), err.getvalue())

    run("inverse", "merlet2023", "--at", "0,0,1")
    run("forward", "merlet2023", "--lengths", "10,10,10,10")
    return run


def ticks(drawn: Figure) -> list[str]:
    """All labels of ticks of a figure, great and small."""
    return [
        label.get_text()
        for axes in drawn.get_axes()
        for axis in axes._axis_map.values()
        for label in axis.get_ticklabels(which="both")
    ]


@pytest.fixture(autouse=True)
def _ticks_are_plain_text(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """No picture that any test here draws shows raw markup at an axis."""
    drawn: list[Figure] = []
    made = style.figure

    def figure(width: float, height: float) -> Figure:
        drawn.append(made(width, height))
        return drawn[-1]

    monkeypatch.setattr(style, "figure", figure)
    yield
    assert [text for each in drawn for text in ticks(each) if MARKUP.search(text)] == []
