"""Count of the faults that estimates report along a log."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from cablewright.foundation.results import Figure
from cablewright.foundation.signals import Fault

FaultCount = dict[tuple[str, str], tuple[float, float, int]]
"""Start and end, s, and number of steps, by source and sentence."""


def fault_figures(begin: str, end: str) -> tuple[Figure, ...]:
    """Return the figures of each item of a `FaultCount`; *begin* and *end* are the keys of its times."""
    return (
        Figure("source", "", "Sensor or part of the machine that is at fault.", lambda item: item[0][0]),
        Figure("sentence", "", "What is wrong, in a sentence.", lambda item: item[0][1]),
        Figure(begin, "s", "When the fault began.", lambda item: item[1][0], shown="s"),
        Figure(end, "s", "When the fault was reported last.", lambda item: item[1][1], shown="s"),
        Figure("steps", "1", "Number of steps in which it was reported.", lambda item: item[1][2]),
    )


_MAX_FAULTS: Final = 1000


def count_faults(counted: FaultCount, faults: Iterable[Fault], now: float) -> None:
    """Add the *faults* of one step at *now*, s, to the counts; at most 1000 kinds are counted."""
    for fault in faults:
        key = fault.source, fault.sentence
        if key in counted:
            since, _, steps = counted[key]
            counted[key] = since, now, steps + 1
        elif len(counted) < _MAX_FAULTS:
            counted[key] = fault.since, now, 1
