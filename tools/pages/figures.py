"""Write ``docs/figures.md``: every figure that commands print and reports show, as the results declare them.

A test compares the page with this output. Run it from the repository root: ``python tools/pages/figures.py``.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

from cablewright.apps.cli.main import COMMANDS
from cablewright.foundation.results import Figure
from cablewright.studies.design.measures import MEASURES, Measure

PAGE = Path(__file__).resolve().parents[2] / "docs" / "figures.md"
HEAD = """# Figures

The figures of `--json` and of the report of each command, in printed order. Values are SI, angles are radians; tables
and reports use the unit of the last column, if there is one. `a.b` is the key `b` of the object
`a`, of each object in the list `a`, or of each object by name in `a`. Unknown values are `null`. Each JSON object
has `schema`, the version of its keys: 3. A command that writes files adds their names, under the name of the option.

This page is written by `tools/pages/figures.py` from the declarations in the code.
"""
OBJECTIVES = """## Objectives of design

Figures for `--objective` and `--constraint` of [`design`](design.md).

| figure | unit | better | needs a job | meaning |
| --- | --- | --- | --- | --- |"""


def page() -> str:
    """The whole page."""
    parts = [HEAD]
    for group, commands in COMMANDS.items():
        parts.append(f"## {group}\n")
        for name, (home, summary) in commands.items():
            module, kind = home.rsplit(".", 1)
            answers = getattr(import_module(f"cablewright.apps.cli.{module}"), kind).answers
            parts += [f"### {name}\n", f"{summary}\n", *map(_table, answers)]
    parts += [OBJECTIVES, *(_objective(key, each) for key, each in MEASURES.items())]
    return "\n".join(parts).rstrip() + "\n"


def _objective(key: str, measure: Measure) -> str:
    """A row of the table of objectives."""
    better, needs = "higher" if measure.higher else "lower", "yes" if measure.of_part else "no"
    return f"| `{key}` | {measure.figure.unit} | {better} | {needs} | {measure.figure.meaning} |"


def declared(answer: str) -> tuple[Figure, ...]:
    """The figures of a result, given as ``module:class``."""
    module, kind = answer.split(":")
    figures: tuple[Figure, ...] = getattr(import_module(f"cablewright.{module}"), kind).FIGURES
    return figures


def _table(answer: str) -> str:
    rows = [f"| `{path}` | {each.unit} | {each.meaning} | {each.shown} |" for path, each in _flat(declared(answer), "")]
    return "\n".join(
        [f"`{answer.split(':')[1]}`\n", "| key | unit | meaning | shown in |", "| --- | --- | --- | --- |", *rows, ""]
    )


def _flat(figures: tuple[Figure, ...], before: str) -> Iterator[tuple[str, Figure]]:
    """Every figure with its path, those of parts after the one that has them."""
    for each in figures:
        path = f"{before}{each.key}"
        yield path, each
        yield from _flat(each.parts, f"{path}.")


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
