"""Finishes a print: joins its log and makes its record."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cablewright.machine.log.join import join_log
from cablewright.machine.log.log import read_log
from cablewright.printing.heightfield import HeightField
from cablewright.printing.track import Track
from cablewright.progress import Progress
from cablewright.studies.prints.record import UNUSED, Recorder
from cablewright.studies.prints.result import PrintRecord
from cablewright.studies.prints.run import Timing


def finish(
    folder: Path,
    track: Track,
    print_speed: float,
    true_structure: HeightField | None = None,
    progress: Progress | None = None,
) -> tuple[PrintRecord, Path]:
    """Join the log of the print in *folder* and make its record; return both. May be done again.

    Raises `InputError` where there is no log, `EnvironmentFault` where it cannot be written.
    """
    joined = join_log(folder)
    with read_log(joined) as log:
        recorder = Recorder(log.head, track, print_speed)
        for count, entry in enumerate(log.entries(without=UNUSED)):
            recorder.add(entry)
            if progress is not None and count % 1000 == 0:
                progress("reading the log (bytes)", log.position, log.size)
        return recorder.finish(true_structure, notes=tuple(log.notes)), joined


def step_times(timing: Timing) -> dict[str, float | int]:
    """Duration of the control steps, s, by the wall clock and by the processor, and how many exceeded the period.

    ``over``: by the wall clock; ``over_by_itself``: by the processor. Of a real-time print also how many ended late.
    """
    if not timing.wall:
        return {"count": 0}
    wall, processor = np.array(timing.wall), np.array(timing.processor)
    times: dict[str, float | int] = {
        "count": len(wall),
        "mean": float(wall.mean()),
        "p99": float(np.percentile(wall, 99.0)),
        "max": float(wall.max()),
        "processor_mean": float(processor.mean()),
        "processor_p99": float(np.percentile(processor, 99.0)),
        "processor_max": float(processor.max()),
        "over": int(np.count_nonzero(wall > timing.period)),
        "over_by_itself": int(np.count_nonzero(processor > timing.period)),
    }
    if timing.lateness:
        late = np.array(timing.lateness)
        times |= {"late": int(np.count_nonzero(late > 0.0)), "latest": float(late.max())}
    return times
