"""Counts the faults that estimates report along a log."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from cablewright.signals import Fault

FaultCount = dict[tuple[str, str], tuple[float, float, int]]
"""Start and end, s, and number of steps, by source and sentence."""

_MAX_FAULTS: Final = 1000


def count_faults(counted: FaultCount, faults: Iterable[Fault], now: float) -> None:
    """Add the *faults* of the step at *now*, s; at most 1000 kinds are counted."""
    for fault in faults:
        key = fault.source, fault.sentence
        if key in counted:
            since, _, steps = counted[key]
            counted[key] = since, now, steps + 1
        elif len(counted) < _MAX_FAULTS:
            counted[key] = fault.since, now, 1
