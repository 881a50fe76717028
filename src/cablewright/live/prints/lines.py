"""Statistics of each line in a print: time taut, tensions, excess length, cable wound and paid out."""

from __future__ import annotations

import numpy as np

from cablewright.estimation.slackness import SlacknessSettings
from cablewright.foundation.arrays import Array, Mask
from cablewright.live.error_statistics import spread
from cablewright.live.prints.result import LineUse
from cablewright.live.prints.spooling_regularity import SpoolRadii, SpoolStatistics
from cablewright.live.prints.steps_table import Rows
from cablewright.live.prints.vibration import VibrationRecord
from cablewright.machine.log.head import LogHead
from cablewright.running.running_statistics import Moments


class LineStatistics:
    """Accumulated tensions, lengths and slack of each line of a print."""

    def __init__(self, head: LogHead) -> None:
        """Start with no steps."""
        m = head.robot.m
        self._names = tuple(line.name for line in head.robot.lines)
        self._taut, self._true_taut, self._tension, self._excess = (Moments(m) for _ in range(4))
        self._hours, self._wound = np.zeros(m), np.zeros(m)
        self._spools = SpoolStatistics(head.robot, head.settings.winch)
        self._last_row: Rows | None = None

    def add(self, rows: Rows, printing: Mask) -> None:
        """Add *rows* of steps, of which some are *printing* (k,)."""
        slack, valid = rows["slack"], rows["valid"] == 1.0
        taut = np.where(valid[:, None] & np.isfinite(slack), slack == 0.0, np.nan)
        excess = rows["true_excess"]
        true_taut = np.where(np.isfinite(excess), excess <= SlacknessSettings.threshold, np.nan)
        self._taut.add(taut[printing])
        self._true_taut.add(true_taut[printing])
        self._tension.add(rows["tensions"][printing])
        self._excess.add(np.where(valid[:, None], rows["excess"], np.nan)[printing])
        step = np.nan_to_num(np.maximum(rows["step"], 0.0))
        self._hours += (step[:, None] * (taut == 1.0)).sum(axis=0) / 3600.0
        chosen = printing & valid
        self._spools.add(rows["lengths"][chosen], rows["radii"][chosen])
        self._spools.add(rows["true_lengths"][printing], rows["true_radii"][printing], true=True)
        self._wind(rows)

    def _wind(self, rows: Rows) -> None:
        """Add the cable wound and paid out: by encoders and estimated radii if known, else by true lengths."""
        joined = rows if self._last_row is None else np.concatenate([self._last_row, rows])
        self._last_row = rows[-1:]
        measured = np.abs(np.diff(joined["turned"], axis=0)) * joined["radii"][1:]
        true = np.abs(np.diff(joined["true_lengths"], axis=0))
        self._wound += np.nan_to_num(np.where(np.isfinite(measured), measured, true)).sum(axis=0)

    def spools(self) -> tuple[SpoolRadii, ...]:
        """Return the radii of each winch drum by length paid out."""
        return self._spools.result()

    def result(
        self, spools: tuple[SpoolRadii, ...], vibration: VibrationRecord, estimated: Array
    ) -> tuple[LineUse, ...]:
        """Return all lines' statistics, with the *estimated* tensions (k, m), N, of some steps."""
        tension = Moments(len(self._names))
        tension.add(estimated)
        return tuple(
            LineUse(
                name,
                float(self._taut.mean[i]),
                float(self._true_taut.mean[i]),
                float(self._tension.mean[i]),
                float(self._tension.max[i]),
                float(tension.mean[i]),
                float(tension.max[i]),
                float(self._excess.max[i]),
                float(self._hours[i]),
                float(self._wound[i]),
                spools[i].irregularity,
                spools[i].true_irregularity,
                spread(vibration.frequencies[:, i]).median,
                float(vibration.slopes[i]),
                float(vibration.slope_sigmas[i]),
            )
            for i, name in enumerate(self._names)
        )
