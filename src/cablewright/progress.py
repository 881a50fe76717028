"""How far a long computation has come: what it calls now and then."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[str, int, int], None]
"""Called with a stage, how much of it is done, and how much there is to do: ``progress("reading log", 3, 10)``."""


def silent(_stage: str, _done: int, _total: int) -> None:
    """The progress of whoever asked for none."""
