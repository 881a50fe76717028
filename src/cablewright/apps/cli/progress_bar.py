"""Progress on stderr: a bar on a terminal, lines in a log."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from cablewright.apps.cli.output import tell
from cablewright.progress import Progress


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
