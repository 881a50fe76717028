"""A button that a person holds: any key of a terminal, repeated by it. A pipe is nobody who holds one."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from cablewright.errors import EnvironmentFault

_HELD: Final = 0.1  # s for which one key counts as held


class Button:
    """Reads the standard input on a thread. Each byte is the button; its end, or the letter q, is the end."""

    def __init__(self) -> None:
        """Begin to read."""
        self._pressed, self.over = -float("inf"), False
        threading.Thread(target=self._read, daemon=True).start()

    def held(self) -> bool:
        """Whether it is held now."""
        return not self.over and time.monotonic() - self._pressed < _HELD

    def ended(self) -> bool:
        """Whether the person has ended it."""
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
    """A button on the terminal, without echo and without waiting for the end of a line.

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
