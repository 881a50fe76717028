"""Orders of a person at the terminal, a line each."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Final

from cablewright.apps.cli.output import tell

if TYPE_CHECKING:
    from cablewright.studies.drives.printing import PersonOperator

_LONGEST: Final = 200  # characters of a line that are looked at


@contextmanager
def typed_orders() -> Iterator[PersonOperator]:
    """An operator who obeys the lines of the standard input; its end stops the machine."""
    from cablewright.studies.drives.printing import WORDS, PersonOperator

    lines: SimpleQueue[str | None] = SimpleQueue()
    gone = threading.Event()

    def read() -> None:
        try:
            for line in sys.stdin.buffer:
                lines.put(line[:_LONGEST].decode(errors="replace"))
        finally:
            gone.set()

    def typed() -> list[str]:
        found: list[str] = []
        while True:
            try:
                line = lines.get_nowait()
            except Empty:
                return found
            if line is not None:
                found.append(line)

    threading.Thread(target=read, daemon=True).start()
    tell(f"the machine obeys: {', '.join(WORDS)}, quit; Ctrl-C stops and brakes it")
    yield PersonOperator(typed, lambda: gone.is_set() and lines.empty(), tell)
