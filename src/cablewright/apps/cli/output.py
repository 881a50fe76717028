"""What commands print: one JSON object, or text for people; notes and the reason for a no on stderr."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import typer

from cablewright.errors import AnswerError
from cablewright.results import Result, plain

SCHEMA = 2
"""Version of the JSON that commands print."""

NO = 1
"""Exit code of a command whose answer is no."""

MAX_ROWS = 60
"""Rows of a table that people see."""


def answer(found: Result, as_json: bool, **files: object) -> int:
    """Print a result, the *files* that were written and its notes; return the exit code, 1 for a no.

    The reason for a no is one line on stderr.
    """
    if as_json:
        print_json(found.to_dict() | files)
    else:
        print_text(found, files)
    for note in getattr(found, "notes", ()):
        tell(f"note: {note}")
    if found.refusal:
        tell(f"cablewright: {found.refusal}")
    return NO if found.refusal else 0


@contextmanager
def refused(as_json: bool, status: str = "", **known: object) -> Iterator[None]:
    """With --json, an `AnswerError` inside is printed as a refusal, with what is *known*, before it is raised on.

    With a *status* the JSON has that of the error, or *status* where the error has none.
    """
    try:
        yield
    except AnswerError as reason:
        if as_json:
            word = "refused" if not status else status if reason.status is None else reason.status.word
            print_json({"status": word, "reason": str(reason)} | known)
        raise


def print_json(values: Mapping[str, Any]) -> None:
    """Print one JSON object: numbers that are not finite as null."""
    typer.echo(json.dumps({"schema": SCHEMA} | plain(values)))


def print_text(found: Result, files: Mapping[str, object]) -> None:
    """Print the figures of a result: labels and values, then its tables, then the files that were written."""
    from cablewright.apps.figures import sheets, summary

    rows = summary(found)
    colour = typer.colors.RED if found.refusal else typer.colors.GREEN
    for label, value in rows:
        mark = label in ("status", "verdict", "feasible") and not os.environ.get("NO_COLOR")
        typer.echo(f"{label:<{_width(rows)}}  {typer.style(value, fg=colour, bold=True) if mark else value}")
    for sheet in sheets(found):
        typer.echo("")
        if sheet.title:
            typer.echo(sheet.title)
        _print_sheet(sheet.head, sheet.rows, sheet.numeric)
    for what, file in files.items():
        if file is not None:
            typer.echo(f"{what:<{_width(rows)}}  {file}")


def tell(line: str) -> None:
    """Say something to the person, apart from the result."""
    typer.echo(line, err=True)


def _width(rows: list[tuple[str, str]]) -> int:
    return max((len(label) for label, _ in rows), default=0)


def _print_sheet(head: tuple[str, ...], rows: list[tuple[str, ...]], numeric: tuple[bool, ...]) -> None:
    """Print a table; of a long one every few rows, the first and the last among them."""
    shown = rows
    if len(rows) > MAX_ROWS:
        shown = [rows[round(k * (len(rows) - 1) / (MAX_ROWS - 1))] for k in range(MAX_ROWS)]
    every = [head, *shown] if head else shown
    widths = [max(len(row[k]) for row in every) for k in range(len(numeric))]
    for row in every:
        cells = (
            f"{cell:{'>' if right else '<'}{width}}" for cell, right, width in zip(row, numeric, widths, strict=True)
        )
        typer.echo("  ".join(cells).rstrip())
    if len(shown) < len(rows):
        typer.echo(f"{len(shown)} of {len(rows)} rows; --json has all")
