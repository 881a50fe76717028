"""The true errors of a print while it runs, for prints without a log."""

from __future__ import annotations

from typing import Final

import numpy as np

from cablewright.foundation.signals import PrintState
from cablewright.live.prints.loop import Printer, Step
from cablewright.live.prints.path_errors import PathErrors
from cablewright.live.prints.plan import MachineTwin
from cablewright.live.prints.steps_table import StepsTable, in_state
from cablewright.live.prints.tracking_errors import WholeErrorSums
from cablewright.machine.log.log import Entry
from cablewright.machine.simulated.simulated_machine import SimulatedMachine

_BLOCK: Final = 256  # steps


class TrueErrors:
    """A `StepRecorder` that keeps only the sums of the true errors, equal to those of a print's record."""

    def __init__(self, twin: MachineTwin, machine: SimulatedMachine) -> None:
        path = twin.path
        self._attitude, self._machine = path.attitude, machine
        self._table = StepsTable(twin.robot, machine.settings, machine.period, _BLOCK)
        self.path = PathErrors(path.track, path.print_speed, "true_")
        self.whole = WholeErrorSums(twin.robot, path.attitude)
        self.distance = 0.0  # m along the path, reached

    def add(self, printer: Printer, step: Step, *, last: bool) -> None:  # noqa: ARG002
        """Add the true position error of one step."""
        self._table.put(Entry(step.frame, step.command, self._machine.truth, step.estimate, step.progress, step.orders))
        self.distance = max(self.distance, step.progress.distance)
        if last or self._table.full:
            self._sum()

    def _sum(self) -> None:
        rows = self._table.take()
        if self._attitude is not None:
            rows["true_position"] = self._attitude.nozzles_at(rows["true_position"], rows["true_rotation"])
        self.whole.add(rows)
        chosen = in_state(rows, PrintState.PRINTING) & np.isfinite(rows["distance"])
        if chosen.any():
            self.path.add(rows[chosen])
