"""The garbage collector during a control loop, whose steps it must not delay."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def without_old_objects(*, paced: bool) -> Iterator[None]:
    """Leave the objects of before the loop out of its collections, which would traverse them again and again.

    *paced*: the loop keeps to the clock; nothing is collected but what it collects itself between its steps. Objects
    that a program has frozen before stay frozen after.
    """
    frozen = gc.get_freeze_count() > 0
    if paced:
        gc.collect()
        gc.disable()
    gc.freeze()
    try:
        yield
    finally:
        gc.enable()
        if not frozen:
            gc.unfreeze()
