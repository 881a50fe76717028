"""The callback by which a long computation reports its progress."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[str, int, int], None]
"""Called with the stage, its completed units and its total: ``progress("reading log", 3, 10)``."""


def silent(_stage: str, _done: int, _total: int) -> None:
    """Report no progress."""
