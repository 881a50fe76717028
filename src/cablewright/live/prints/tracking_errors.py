"""Errors of the platform against its target, and tensions against their limits, in every step of a print.

Pauses, stops and refills are included: from the first step that prints on, and of tensions from the first step at all.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from cablewright.control.attitude import Attitude
from cablewright.foundation.arrays import Array
from cablewright.foundation.results import Figure, Result
from cablewright.foundation.signals import PrintState
from cablewright.live.prints.steps_table import Rows, in_state
from cablewright.models.rotation import angle_between
from cablewright.robot import Robot


@dataclass(frozen=True, repr=False)
class WholeErrors(Result):
    """True tracking errors over every step of a print; NaN where the log has no truth."""

    FIGURES: ClassVar = (
        Figure("position_rms", "m", "Root mean square distance in space of the printing point from its target, "
               "in every step since the first that printed, pauses and stops included.", shown="mm"),
        Figure("position_max", "m", "Largest of these distances.", shown="mm"),
        Figure("orientation_max", "rad", "Largest angle of a rigid platform from its scheduled rotation in these "
               "steps; 0 for a point platform.", shown="deg"),
        Figure("min_tension_margin", "N", "Smallest distance of a true tension at a sheave from the line's limits in "
               "these steps; negative: outside.", shown="N", digits=3),
        Figure("tension_error_rms", "N", "Root of the mean square of the distance of each line's tension at its sheave "
               "from the one that the control chose, in the steps that print; of the true tensions, of a real machine "
               "of the measured ones; null where none are chosen.", shown="N", digits=3),
        Figure("tension_error_max", "N", "Largest of these distances.", shown="N", digits=3),
        Figure("start_tension_margin", "N", "The same in the steps before, in which the machine stands as it was homed "
               "and goes to the beginning of the path.", detail=True, shown="N", digits=3),
    )  # fmt: skip

    position_rms: float
    position_max: float
    orientation_max: float
    min_tension_margin: float
    start_tension_margin: float
    tension_error_rms: float = math.nan
    tension_error_max: float = math.nan


class WholeErrorSums:
    """Sums of tracking errors, block by block of steps."""

    def __init__(self, robot: Robot, attitude: Attitude | None) -> None:
        """*attitude*: rotation of a rigid platform along the path; None for a point, or if it is not known."""
        self._attitude, self._rigid = attitude, robot.n == 6
        self._limits = np.array([line.tension_limits for line in robot.lines])
        self._begun, self._count, self._squares = False, 0, 0.0
        self._position = self._orientation = math.nan
        self._margin = self._before = math.nan
        self._tensions, self._off, self._most_off = 0, 0.0, math.nan

    def add(self, rows: Rows) -> None:
        """Add *rows* of consecutive steps of a print."""
        prints = in_state(rows, PrintState.PRINTING)
        first = 0 if self._begun else int(np.argmax(prints)) if prints.any() else len(rows)
        self._begun = self._begun or bool(prints.any())
        margins = np.minimum(rows["tensions"] - self._limits[:, 0], self._limits[:, 1] - rows["tensions"])
        self._before = _least(self._before, margins[:first])
        self._margin = _least(self._margin, margins[first:])
        self._add_tensions(rows[prints])
        chosen = rows[first:]
        away = np.linalg.norm(chosen["true_position"] - chosen["target"], axis=1)
        away = away[np.isfinite(away)]
        if not len(away):
            return
        self._count += len(away)
        self._squares += float(away @ away)
        self._position = float(np.fmax(self._position, away.max()))
        self._add_orientation(chosen)

    def _add_tensions(self, rows: Rows) -> None:
        shown = np.where(np.isfinite(rows["tensions"]), rows["tensions"], rows["read_tensions"])
        off = np.abs(shown - rows["chosen_tensions"])
        off = off[np.isfinite(off)]
        if len(off):
            self._tensions, self._off = self._tensions + len(off), self._off + float(off @ off)
            self._most_off = float(np.fmax(self._most_off, off.max()))

    def _add_orientation(self, rows: Rows) -> None:
        if not self._rigid:
            self._orientation = 0.0
        elif self._attitude is not None:
            scheduled = self._attitude.rotations(rows["target"][:, 2])
            angles = angle_between(scheduled, rows["true_rotation"])
            angles = angles[np.isfinite(angles)]
            if len(angles):
                self._orientation = float(np.fmax(self._orientation, angles.max()))

    def result(self) -> WholeErrors:
        """Return the tracking errors of all steps."""
        rms = math.sqrt(self._squares / self._count) if self._count else math.nan
        tensions = math.sqrt(self._off / self._tensions) if self._tensions else math.nan
        found = (rms, self._position, self._orientation, self._margin, self._before)
        return WholeErrors(*found, tensions, self._most_off)


def _least(now: float, margins: Array) -> float:
    known = margins[np.isfinite(margins)]
    return float(np.fmin(now, known.min())) if len(known) else now
