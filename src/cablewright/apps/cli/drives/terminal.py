"""Input at the terminal: a held key, and typed orders, a line each."""

from __future__ import annotations

import os
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
from cablewright.foundation.errors import EnvironmentFault

if TYPE_CHECKING:
    from cablewright.live.drives.printing import PersonOperator
    from cablewright.machine.drives.virtual.rig import VirtualRig

_HELD: Final = 0.1  # s for which one key counts as held


class Button:
    """A key of the terminal that counts as held while bytes arrive; read by a thread.

    Each byte is the key; its end, or the letter q, is the end.
    """

    def __init__(self) -> None:
        """Begin to read."""
        self._pressed, self.over = -float("inf"), False
        threading.Thread(target=self._read, daemon=True).start()

    def held(self) -> bool:
        """Whether the key that allows motion is held now."""
        return not self.over and time.monotonic() - self._pressed < _HELD

    def ended(self) -> bool:
        """Whether the person at the terminal has quit."""
        return self.over

    def _read(self) -> None:
        number = sys.stdin.fileno()
        while True:
            try:
                data = os.read(number, 64)
            except OSError:
                data = b""
            if not data or b"q" in data:
                self.over = True
                return
            self._pressed = time.monotonic()


@contextmanager
def button() -> Iterator[Button]:
    """Open the key of the terminal, without echo and without waiting for the end of a line.

    Keys from before are forgotten. Raises `EnvironmentFault` where the standard input is no such terminal.
    """
    if not sys.stdin.isatty() or sys.platform == "win32":
        why = "a key has to be held at a terminal (Linux or macOS); the standard input is none"
        raise EnvironmentFault(f"drives jog: {why}")
    import termios
    import tty

    number = sys.stdin.fileno()
    before = termios.tcgetattr(number)
    try:
        tty.setcbreak(number)
        termios.tcflush(number, termios.TCIFLUSH)
        yield Button()
    finally:
        termios.tcsetattr(number, termios.TCSADRAIN, before)


_LONGEST: Final = 200  # characters of a line that are looked at
REFILL: Final = "refill"


@dataclass
class TypedLines:
    """Lines of the standard input, read in a thread. ``waited``: s, age of the oldest line returned last."""

    waited: float = 0.0
    _lines: SimpleQueue[tuple[float, str]] = field(default_factory=SimpleQueue)
    _gone: threading.Event = field(default_factory=threading.Event)

    def begin(self) -> None:
        """Start to read typed lines from the standard input."""
        threading.Thread(target=self._read, daemon=True).start()

    def typed(self) -> list[str]:
        """Return the lines of text that were typed since the last call."""
        found: list[tuple[float, str]] = []
        with suppress(Empty):
            while True:
                found.append(self._lines.get_nowait())
        self.waited = time.monotonic() - found[0][0] if found else 0.0
        return [line for _, line in found]

    def over(self) -> bool:
        """Whether the standard input has ended."""
        return self._gone.is_set() and self._lines.empty()

    def _read(self) -> None:
        try:
            with suppress(OSError):  # of a terminal that belongs to another job: there is no input
                for line in sys.stdin.buffer:
                    self._lines.put((time.monotonic(), line[:_LONGEST].decode(errors="replace")))
        finally:
            self._gone.set()


@contextmanager
def typed_orders() -> Iterator[PersonOperator]:
    """An operator who obeys the lines of the standard input; its end stops the machine."""
    from cablewright.live.drives.printing import WORDS, PersonOperator

    lines = TypedLines()
    lines.begin()
    tell(f"the machine obeys: {', '.join(WORDS)}, quit; Ctrl-C stops and brakes it")
    yield PersonOperator(lines.typed, lines.over, tell, age=lambda: lines.waited)


def person_beside(rig: VirtualRig) -> Callable[[], bool]:
    """Callback of each tick that refills virtual drives when the standard input has the line `REFILL`."""
    if hasattr(signal, "SIGTTIN"):  # in the background of a shell there is no input, and nothing stops
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
