"""What commands print: one JSON object, or text for people; progress and the reason for a no on stderr."""

from __future__ import annotations

import json
import math
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from cablewright.errors import InputError
from cablewright.file_output import write_whole
from cablewright.progress import Progress
from cablewright.results import plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SCHEMA = 1
"""Version of the JSON that commands print."""

FREE = "free"
"""How a command line marks a freedom of the pose that gravity decides."""


def print_json(values: dict[str, Any]) -> None:
    """Print one JSON object: numbers that are not finite as null."""
    typer.echo(json.dumps({"schema": SCHEMA} | plain(values)))


def tell(line: str) -> None:
    """Say something to the person, apart from the result."""
    typer.echo(line, err=True)


def numbers(text: str | None, option: str, *, free: bool = False) -> list[float] | None:
    """Comma-separated numbers of an option; where *free*, `FREE` among them is NaN. Raises `InputError`."""
    if text is None:
        return None
    try:
        return [math.nan if free and part.strip() == FREE else float(part) for part in text.split(",")]
    except ValueError:
        raise InputError(f"{option} = {text!r}: numbers with commas between them are wanted, like 0,0,1.5") from None


def limits(text: str | None) -> tuple[float, float] | None:
    """The value of --tension-limits."""
    values = numbers(text, "--tension-limits")
    if values is None:
        return None
    if len(values) != 2:
        raise InputError(f"--tension-limits = {text!r}: two numbers are wanted, lowest,highest in N")
    return values[0], values[1]


def write_picture(file: Path, draw: Callable[..., Figure], *found: object) -> None:
    """Write what *draw* makes of *found* as a PNG. Raises `EnvironmentFault` where it cannot be written."""
    from cablewright.apps import style

    with style.drawing():
        picture = style.png(draw(*found))
    write_whole(file, picture)


class _Plain:
    """Progress for a log: a line every few seconds."""

    EVERY = 2.0

    def __init__(self) -> None:
        self.stage, self.begin, self.last = "", 0.0, 0.0

    def __call__(self, stage: str, done: int, total: int) -> None:
        now = time.monotonic()
        if stage != self.stage:
            self.stage, self.begin, self.last = stage, now, now
        if now - self.last < self.EVERY or not done:
            return
        self.last = now
        rate = done / (now - self.begin)
        tell(f"{stage}: {100 * done // total} % of {total}, {rate:.0f}/s, {(total - done) / rate:.0f} s left")


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

    def __call__(self, stage: str, done: int, total: int) -> None:
        if stage not in self.tasks:
            self.tasks[stage] = self.bar.add_task(stage, total=total, rate="")
        task = self.tasks[stage]
        speed = next(t.speed for t in self.bar.tasks if t.id == task)
        self.bar.update(task, completed=done, total=total, rate=f"{speed:,.0f}/s" if speed else "")


@contextmanager
def progress() -> Iterator[Progress]:
    """A callback that shows rate and time left: a bar in a terminal, lines in a log."""
    if not sys.stderr.isatty():
        yield _Plain()
        return
    shown = _Bar()
    with shown.bar:
        yield shown
