"""Files of a running print in its run folder: log, checkpoint, and durations of the control steps."""

from __future__ import annotations

import time
from array import array
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np

from cablewright.foundation.errors import InputError
from cablewright.foundation.progress import Progress
from cablewright.foundation.saved_state import LAYOUT, Snapshot, read_snapshots, save
from cablewright.live.prints.loop import Printer, Step
from cablewright.live.prints.record import Recorder
from cablewright.live.prints.snapshot_writer import SnapshotWriter
from cablewright.machine.log.log import Entry, LogWriter
from cablewright.running.run_folders import MANIFEST
from cablewright.running.signing_key import is_signed

CHECKPOINT_INTERVAL: Final = 0.5
"""Between two checkpoints, s by the wall clock."""

_PROGRESS_STEPS: Final = 50  # between progress messages


@dataclass
class Timing:
    """Durations of the control steps, s: from the arrival of a frame until its command is computed and logged."""

    period: float  # s, limit of a step
    wall: array[float] = field(default_factory=lambda: array("d"))
    processor: array[float] = field(default_factory=lambda: array("d"))
    lateness: array[float] = field(default_factory=lambda: array("d"))  # of a real-time print; negative: early

    def statistics(self) -> dict[str, float | int]:
        """Return statistics of the durations, s: by wall clock, and by processor time (``processor_``).

        ``over``: number of steps that were longer than the period by the wall clock; ``over_by_itself``: number by
        processor time. A real-time print also has ``late``, the number of steps that ended late, and ``latest``, the
        largest delay, s.
        """
        if not self.wall:
            return {"count": 0}
        wall, processor = np.array(self.wall), np.array(self.processor)
        times: dict[str, float | int] = {
            "count": len(wall),
            "mean": float(wall.mean()),
            "p99": float(np.percentile(wall, 99.0)),
            "max": float(wall.max()),
            "processor_mean": float(processor.mean()),
            "processor_p99": float(np.percentile(processor, 99.0)),
            "processor_max": float(processor.max()),
            "over": int(np.count_nonzero(wall > self.period)),
            "over_by_itself": int(np.count_nonzero(processor > self.period)),
        }
        if self.lateness:
            late = np.array(self.lateness)
            times |= {"late": int(np.count_nonzero(late > 0.0)), "latest": float(late.max())}
        return times


@dataclass
class FolderRecorder:
    """A `StepRecorder` that writes each step to the log, a checkpoint at least every half second, and progress.

    ``record``: what makes the record of the print from the same steps, instead of from the log afterwards.
    """

    log: LogWriter
    writer: SnapshotWriter
    timing: Timing
    progress: Progress | None = None
    record: Recorder | None = None
    _saved: float = field(default_factory=time.monotonic, repr=False)
    _steps: int = 0

    def add(self, printer: Printer, step: Step, *, last: bool) -> None:
        """Record one step of a print in its run folder."""
        truth = printer.machine.abilities.truth
        told = step.command, None if truth is None else truth(), step.estimate, step.progress, step.orders
        self.log.write(step.frame, *told)
        wall, processor = printer.frame_times
        self.timing.wall.append(time.perf_counter() - wall)
        self.timing.processor.append(time.thread_time() - processor)
        if self.record is not None:
            self.record.add(Entry(step.frame, *told))
        self._steps += 1
        now = time.monotonic()
        if last or now - self._saved >= CHECKPOINT_INTERVAL:
            self._saved = now
            self.writer.put(checkpoint_of(printer), after=self.log.flush())
        if self.progress is not None and self._steps % _PROGRESS_STEPS == 0:
            length = round(1e3 * printer.plan.path.track.length)
            self.progress("printing, mm", round(1e3 * step.progress.distance), length)


def checkpoint_of(printer: Printer) -> dict[str, Snapshot]:
    """Return the checkpoint of a print at one time, with its machine if that can save its whole state."""
    snapshot = printer.machine.abilities.snapshot
    whole = {} if snapshot is None else {"machine": snapshot()}
    learnt = {} if printer.learning is None else {"estimator": save(printer.learning)}
    return whole | learnt | {"print": save(printer)}


def read_checkpoint(path: Path) -> dict[str, Snapshot]:
    """Return the data of a checkpoint, see `checkpoint_of`.

    Raises `InputError` for another file, or one of another user. So it does for one that another version of this
    program wrote in another layout.
    """
    found = read_snapshots(path, is_signed=is_signed)
    if "print" not in found:
        raise InputError(f"{path}: this checkpoint has no saved state of a print")
    layout = found["print"].values.get("layout", 1)
    if layout != LAYOUT:
        raise InputError(
            f"{path}: is a checkpoint of layout {str(layout)[:60]}, this version of cablewright reads layout {LAYOUT}: "
            f"--resume with the version in {MANIFEST}, or --restart to print all again"
        )
    return found
