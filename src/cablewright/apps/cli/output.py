"""Output of commands: one JSON object, or text; notes, progress and the reason for a no on stderr."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import typer

from cablewright.foundation.errors import AnswerError, printable
from cablewright.foundation.progress import Progress
from cablewright.foundation.results import Result, plain

if TYPE_CHECKING:
    from cablewright.apps.figures import Sheet

SCHEMA = 3
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
def refused(status: str, **known: object) -> Iterator[None]:
    """Return a context that adds *known* values and a status to the JSON of an `AnswerError` inside."""
    try:
        yield
    except AnswerError as reason:
        reason.known = {"status": status if reason.status is None else reason.status.word} | known
        raise


def print_refusal(reason: AnswerError) -> None:
    """Print a negative answer as JSON."""
    print_json({"status": "refused", "reason": str(reason)} | reason.known)


def print_json(values: Mapping[str, Any]) -> None:
    """Print a result as one JSON object, in which infinite and unknown numbers are null."""
    typer.echo(json.dumps({"schema": SCHEMA} | plain(values)))


def print_text(found: Result, files: Mapping[str, object]) -> None:
    """Print the figures of a result as text: labels and values, then its tables, then the files that were written."""
    from cablewright.apps.figures import sheets, summary

    rows = summary(found)
    width = max((len(label) for label, _ in rows), default=0)
    colour = typer.colors.RED if found.refusal else typer.colors.GREEN
    if getattr(found, "verdict", "") == "doubtful":
        colour = typer.colors.YELLOW
    pasted = getattr(found, "PASTED", ())
    listed = {each.label for each in found.figures if each.sentences}
    for label, value in rows:
        mark = label in ("status", "verdict", "feasible") and not os.environ.get("NO_COLOR")
        lines = value.split("\n") if label in pasted or label in listed else [value]
        shown = f"\n{' ' * (width + 2) if label in listed else ''}".join(map(printable, lines))
        typer.echo(f"{label:<{width}}  {typer.style(shown, fg=colour, bold=True) if mark else shown}")
    tables, written = list(sheets(found)), {what: file for what, file in files.items() if file is not None}
    for k, sheet in enumerate(tables):
        if rows or k:
            typer.echo("")
        if sheet.title:
            typer.echo(printable(sheet.title))
        _print_sheet(sheet)
    if tables and written:
        typer.echo("")
    for what, file in written.items():
        typer.echo(f"{what:<{width}}  {printable(str(file))}")


def tell(line: str) -> None:
    """Print a message for the person on stderr, apart from the result."""
    typer.echo(printable(line), err=True)


def _print_sheet(sheet: Sheet) -> None:
    """Print a table; of a long one every few rows, the first and the last among them, or the best."""
    shown = sheet.rows[:MAX_ROWS]
    if len(sheet.rows) > MAX_ROWS and not sheet.ranked:
        shown = [sheet.rows[round(k * (len(sheet.rows) - 1) / (MAX_ROWS - 1))] for k in range(MAX_ROWS)]
    every = [[printable(cell) for cell in row] for row in ([sheet.head, *shown] if sheet.head else shown)]
    widths = [max(len(row[k]) for row in every) for k in range(len(sheet.numeric))]
    for row in every:
        columns = zip(row, sheet.numeric, widths, strict=True)
        typer.echo("  ".join(f"{cell:{'>' if right else '<'}{width}}" for cell, right, width in columns).rstrip())
    if len(shown) < len(sheet.rows):
        typer.echo(f"{'the first ' if sheet.ranked else ''}{len(shown)} of {len(sheet.rows)} rows; --json has all")


def _rate(done: float) -> str:
    """The rate of *done* items per second, in words; for slow items, the time of one."""
    return f"{done:.0f}/s" if done >= 1.0 else f"{1.0 / done:.1f} s each"


class _Plain:
    """Progress for a log: a line every few seconds."""

    EVERY = 8.0  # s

    def __init__(self) -> None:
        self.stage, self.begin, self.last, self.before, self.done = "", 0.0, 0.0, 0, 0

    def restart(self) -> None:
        """Start the time of the present stage again, and count only the units that follow."""
        self.begin = self.last = time.monotonic()
        self.before = self.done

    def __call__(self, stage: str, done: int, total: int) -> None:
        now = time.monotonic()
        if stage != self.stage:
            self.stage, self.begin, self.last, self.before = stage, now, now, 0
        self.done = done
        if now - self.last < self.EVERY or done <= self.before:
            return
        self.last = now
        rate = (done - self.before) / (now - self.begin)
        tell(f"{stage}: {100 * done // total} % of {total}, {_rate(rate)}, {(total - done) / rate:.0f} s left")


class _Bar:
    """Progress for a terminal."""

    def __init__(self) -> None:
        from rich import progress as shown
        from rich.console import Console

        columns = (
            shown.TextColumn("{task.description}"),
            shown.BarColumn(),
            shown.MofNCompleteColumn(),
            shown.TextColumn("{task.fields[rate]}"),
            shown.TimeRemainingColumn(),
        )
        self.bar = shown.Progress(*columns, console=Console(stderr=True), transient=True)
        self.tasks: dict[str, Any] = {}

    def restart(self) -> None:
        """Start the time of the stages again."""
        for task in self.bar.tasks:
            self.bar.reset(task.id, completed=int(task.completed))

    def __call__(self, stage: str, done: int, total: int) -> None:
        if stage not in self.tasks:
            self.tasks[stage] = self.bar.add_task(stage, total=total, rate="")
        task = self.tasks[stage]
        speed = next(t.speed for t in self.bar.tasks if t.id == task)
        self.bar.update(task, completed=done, total=total, rate=_rate(speed) if speed else "")


@contextmanager
def progress(*kernels: str) -> Iterator[Progress]:
    """Return a callback that shows rate and time left: a bar in a terminal, lines in a log.

    Times are those of the work: *kernels*, tasks of `apps.compilation`, are compiled apart from it, where they are not.
    """
    if not sys.stderr.isatty():
        plain = _Plain()
        with compiling(*kernels, then=plain.restart):
            yield plain
        return
    shown = _Bar()
    with shown.bar, compiling(*kernels, then=shown.restart):
        yield shown


@contextmanager
def compiling(*kernels: str, then: Callable[[], None] | None = None) -> Iterator[None]:
    """Return a context that compiles *kernels*, tasks of `apps.compilation`, when the first one is needed."""
    from cablewright.solvers.row_threads import before_compiling

    def prepare() -> None:
        from cablewright.apps import compilation

        compilation.prepare(kernels, tell_compiling)
        if then is not None:
            then()

    if not kernels:
        yield
        return
    with before_compiling(prepare):
        yield


def tell_compiling(done: int, count: int, seconds: float) -> None:
    """Report the number of compiled kernels of *count*, and the estimated remaining time."""
    if done < count:
        tell(f"compiling kernels (once): {done + 1} of {count}, about {max(1.0, seconds):.0f} s")
