"""Planned faults of simulated lines: one that breaks, one that leaves its sheave."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.kernels.layout import EXIT_Z, PULLS, RADIUS, TAU, WEIGHT
from cablewright.kernels.statics.line.upright import SLACK_TENSION
from cablewright.machine.simulated.settings import FaultPlan
from cablewright.robot import Robot

FALLEN: Final = 0.02  # m, by which a cable that has left its sheave lies nearer to the axle, if a plan does not say
_AXLE: Final = 1e-3  # m, least radius


class LineFaults:
    """Planned line faults; each lasts from its time on."""

    SAVED = ("_begun",)

    def __init__(self, robot: Robot, faults: Sequence[FaultPlan]) -> None:
        """Take the *faults* whose source is a line."""
        names = [line.name for line in robot.lines]
        self._plans = [(fault, names.index(fault.line)) for fault in faults if fault.source == "line" and fault.line]
        self._begun = np.zeros(len(self._plans), dtype=np.int64)

    def broken(self) -> list[int]:
        """Return the numbers, from 0, of the lines that a planned fault of the simulation has broken."""
        return [
            i for (fault, i), begun in zip(self._plans, self._begun, strict=True) if begun and fault.kind == "broken"
        ]

    def begin(self, time: float, lines: Array, states: Array) -> None:
        """Begin the faults due at *time*, s, on the packed *lines* and their *states*."""
        for k, (fault, i) in enumerate(self._plans):
            if not self._begun[k] and time >= fault.begin:
                self._begun[k] = 1
                if fault.kind == "broken":
                    states[i, TAU] = np.log(SLACK_TENSION)
                _change(fault, lines[i])


def _change(fault: FaultPlan, row: Array) -> None:
    """Change a line's packed *row*: a broken one weighs and pulls nothing, as a slack one without weight."""
    if fault.kind == "broken":
        row[WEIGHT] = row[PULLS] = 0.0
        return
    size = FALLEN if fault.size is None else fault.size
    if row[RADIUS] > 0.0:
        row[RADIUS] = max(_AXLE, row[RADIUS] - size)
    else:
        row[EXIT_Z] -= size
