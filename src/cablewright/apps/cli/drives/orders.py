"""What a person types at the terminal, a line each: orders to a print, and to whoever stands beside virtual drives."""

from __future__ import annotations

import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Final

from cablewright.apps.cli.output import tell

if TYPE_CHECKING:
    from cablewright.machine.drives.virtual.rig import VirtualRig
    from cablewright.studies.drives.printing import PersonOperator

_LONGEST: Final = 200  # characters of a line that are looked at
REFILL: Final = "refill"


@dataclass
class TypedLines:
    """Lines of the standard input, read beside the work. ``waited``: s, of the oldest line that was returned last."""

    waited: float = 0.0
    _lines: SimpleQueue[tuple[float, str]] = field(default_factory=SimpleQueue)
    _gone: threading.Event = field(default_factory=threading.Event)

    def begin(self) -> None:
        """Begin to read."""
        threading.Thread(target=self._read, daemon=True).start()

    def typed(self) -> list[str]:
        """The lines since the last call."""
        found: list[tuple[float, str]] = []
        with suppress(Empty):
            while True:
                found.append(self._lines.get_nowait())
        self.waited = time.monotonic() - found[0][0] if found else 0.0
        return [line for _, line in found]

    def over(self) -> bool:
        """Whether no more come."""
        return self._gone.is_set() and self._lines.empty()

    def _read(self) -> None:
        try:
            with suppress(OSError):  # of a terminal that belongs to another job: nobody types
                for line in sys.stdin.buffer:
                    self._lines.put((time.monotonic(), line[:_LONGEST].decode(errors="replace")))
        finally:
            self._gone.set()


@contextmanager
def typed_orders() -> Iterator[PersonOperator]:
    """An operator who obeys the lines of the standard input; its end stops the machine."""
    from cablewright.studies.drives.printing import WORDS, PersonOperator

    lines = TypedLines()
    lines.begin()
    tell(f"the machine obeys: {', '.join(WORDS)}, quit; Ctrl-C stops and brakes it")
    yield PersonOperator(lines.typed, lines.over, tell, age=lambda: lines.waited)


def person_beside(rig: VirtualRig) -> Callable[[], bool]:
    """Fills the drum of virtual drives where the standard input says `REFILL`; asked at every tick, it ends nothing."""
    if hasattr(signal, "SIGTTIN"):  # in the background of a shell nobody types, and nothing stops
        signal.signal(signal.SIGTTIN, signal.SIG_IGN)
    lines = TypedLines()
    lines.begin()

    def obey() -> bool:
        for line in lines.typed():
            word = " ".join(line.split())
            if word == REFILL:
                rig.refill()
                tell(f"the drum holds {rig.plant.settings.carrier.powder:g} kg again")
            elif word:
                tell(f"no order {word!r}; virtual drives know: {REFILL}")
        return False

    return obey
