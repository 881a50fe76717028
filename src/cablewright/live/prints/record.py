"""The record of a print, computed from the steps of its log alone, in one pass with bounded memory.

Errors are cross-track, seen from above, positive left of the path, of the steps that printed: true ones where the log
has the truth, and estimated ones. Each is measured to the path near the current distance, so that another branch at a
crossing, or another layer, is not mistaken for it.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Final

import numpy as np

from cablewright.control.attitude import Attitude
from cablewright.foundation.progress import Progress
from cablewright.foundation.signals import Distance, Inertial, LineAngles, PrintState, Scan
from cablewright.live.fault_count import FaultCount, count_faults
from cablewright.live.prints.line_tensions import LineTensions
from cablewright.live.prints.lines import LineStatistics
from cablewright.live.prints.path_errors import PathErrors
from cablewright.live.prints.result import PrintRecord, Span
from cablewright.live.prints.steps_table import ERRORS, STATES, StepsTable, in_state, row_type
from cablewright.live.prints.structure import StructureScans, structure_of
from cablewright.live.prints.tracking_errors import WholeErrorSums
from cablewright.live.prints.vibration import VibrationWindows
from cablewright.machine.log.head import LogHead
from cablewright.machine.log.join import join_log
from cablewright.machine.log.log import Entry, read_log
from cablewright.printing.arc_length_path import Track
from cablewright.printing.heightfield import HeightField
from cablewright.running.running_statistics import Moments, ThinnedRows

UNUSED: Final = (Inertial, Distance, "/scan/north", "/scan/south")
"""Signals that are not used: ``log.entries(without=UNUSED)`` is faster and gives the same record."""

_BLOCK: Final = 2048  # steps that are processed together
_MAX_SPANS: Final = 10_000
_DONE: Final = 0.02  # m before its end a layer counts as finished


def record(
    entries: Iterable[Entry],
    head: LogHead,
    track: Track,
    *,
    print_speed: float,
    true_structure: HeightField | None = None,
    attitude: Attitude | None = None,
) -> PrintRecord:
    """Return the record of the print that followed *track* (of the platform), from the *entries* and *head* of its log.

    *print_speed*: m/s, planned. *true_structure*: the true structure at the end, if known. *attitude*: rotation of a
    rigid platform.
    """
    recorder = Recorder(head, track, print_speed, attitude)
    for entry in entries:
        recorder.add(entry)
    return recorder.finish(true_structure)


def finish(
    folder: Path,
    track: Track,
    print_speed: float,
    true_structure: HeightField | None = None,
    progress: Progress | None = None,
    attitude: Attitude | None = None,
    seen: Recorder | None = None,
) -> tuple[PrintRecord, Path]:
    """Join the log of the print in *folder* and make its record; return the record and the joined log's path.

    *track*, *print_speed* (m/s), *true_structure* and *attitude*: as in `record`. *seen* has all steps of the log, so
    that it need not be read. May be repeated, without *seen*.

    Raises `InputError` where there is no log, `EnvironmentFault` where it cannot be written.
    """
    joined = join_log(folder)
    if seen is not None:
        return seen.finish(true_structure), joined
    with read_log(joined) as log:
        recorder = Recorder(log.head, track, print_speed, attitude)
        for count, entry in enumerate(log.entries(without=UNUSED)):
            recorder.add(entry)
            if progress is not None and count % 1000 == 0:
                progress("reading the log (bytes)", log.position, log.size)
        return recorder.finish(true_structure, notes=tuple(log.notes)), joined


class Recorder:
    """Computes the record of a print from its steps. Its memory grows only with the number of layers."""

    def __init__(self, head: LogHead, track: Track, print_speed: float, attitude: Attitude | None = None) -> None:
        """Start with no steps; arguments: see `record`."""
        self.head, self.track, self.print_speed = head, track, print_speed
        m = head.robot.m
        self._carrying, self._whole = attitude, WholeErrorSums(head.robot, attitude)
        self._table = StepsTable(head.robot, head.settings, head.period, _BLOCK)
        self._true, self._estimated = PathErrors(track, print_speed, "true_"), PathErrors(track, print_speed, "")
        self._lines = LineStatistics(head)
        self._estimation_error, self._attitude, self._climate = Moments(), Moments(2), Moments(2)
        self._rows = ThinnedRows(row_type(m).itemsize // 8)
        self._states, self._travelled = np.zeros(len(STATES)), 0.0
        self._last_position = np.full((1, 3), np.nan)  # m, true, of the last row
        self._steps, self._start_time, self._time = 0, math.nan, math.nan
        self._first_distance, self._distance = math.nan, 0.0
        self._spans: list[Span] = []
        self._barrier_stops = self._refills = 0
        self._faults: FaultCount = {}
        self._notices: Counter[str] = Counter()
        self._expected = np.full(m, np.nan)  # Hz, at the start of the vibration window
        self._vibration, self._tensions = VibrationWindows(m), LineTensions(head.robot, head.settings)
        lidar = head.settings.lidars.get("vertical")
        self._structure = None if lidar is None else StructureScans(lidar, track)

    def add(self, entry: Entry) -> None:
        """Add one step of the print."""
        if not self._steps:
            self._start_time = entry.frame.time
        self._steps += 1
        self._time = entry.frame.time
        self._table.put(entry)
        self._add_progress(entry)
        if entry.estimate is not None:
            count_faults(self._faults, entry.estimate.faults, self._time)
            if self._structure is not None:
                self._structure.set_pose(entry.estimate, self._distance)
        for notice in entry.frame.notices:
            subject = f"{notice.subject}: " if notice.subject else ""
            self._notices[subject + notice.condition.value] += 1
        for reading in entry.frame.readings:
            if isinstance(reading, LineAngles):
                self._add_vibration(reading, entry)
            elif isinstance(reading, Scan) and reading.source == "vertical" and self._structure is not None:
                self._structure.add(reading)
        if self._table.full:
            self._flush()

    def _add_vibration(self, reading: LineAngles, entry: Entry) -> None:
        """Add the lines' angles; expected frequencies are computed at both ends of a window."""
        complete = self._vibration.add(reading)
        if not complete and not self._vibration.window_begins:
            return
        estimate, expected = entry.estimate, np.full(self.head.robot.m, np.nan)
        if estimate is not None and estimate.valid:
            mass = self.head.settings.carrier.empty_mass + self._table.left
            expected = self._tensions.frequencies(estimate, mass)
        if complete:
            self._vibration.close(self._table.temperature, 0.5 * (self._expected + expected))
        else:
            self._expected = expected

    def _add_progress(self, entry: Entry) -> None:
        """Add distance and state."""
        progress, now, spans = entry.progress, entry.frame.time, self._spans
        if progress is None:
            return
        if math.isnan(self._first_distance):
            self._first_distance = progress.distance
        self._distance = max(self._distance, progress.distance)
        if spans and spans[-1].state is progress.state:
            spans[-1] = Span(progress.state, spans[-1].begin, now, spans[-1].reason or progress.reason)
            return
        if progress.state is PrintState.PAUSED:
            self._barrier_stops += "barrier" in progress.reason.lower() or self._table.broken
        self._refills += progress.state is PrintState.REFILLING
        if len(spans) < _MAX_SPANS:
            spans.append(Span(progress.state, spans[-1].end if spans else now, now, progress.reason))

    def _flush(self) -> None:
        """Add the collected rows to the statistics."""
        rows = self._table.take()
        if not len(rows):
            return
        if self._carrying is not None:
            for who in ("", "true_"):
                rows[f"{who}position"] = self._carrying.nozzles_at(rows[f"{who}position"], rows[f"{who}rotation"])
        self._whole.add(rows)
        printing = in_state(rows, PrintState.PRINTING)
        chosen = printing & np.isfinite(rows["distance"])
        if chosen.any():
            errors = *self._true.add(rows[chosen]), *self._estimated.add(rows[chosen])
            for name, values in zip(ERRORS, errors, strict=True):
                rows[name][chosen] = values
        self._estimation_error.add(rows["estimated_offset"] - rows["offset"])
        rotation = rows["rotation"][printing]
        self._attitude.add(np.column_stack([rotation[:, 2], np.hypot(rotation[:, 0], rotation[:, 1])]))
        self._climate.add(np.column_stack([rows["temperature"], rows["humidity"]]))
        step, state = np.nan_to_num(np.maximum(rows["step"], 0.0)), rows["state"]
        known = np.isfinite(state)
        self._states += np.bincount(state[known].astype(np.int64), step[known], len(STATES))
        positions = np.concatenate([self._last_position, rows["true_position"]])
        self._travelled += float(np.nansum(np.linalg.norm(np.diff(positions, axis=0), axis=1)))
        self._last_position = positions[-1:]
        self._lines.add(rows, printing)
        self._rows.add(rows.view(np.float64).reshape(len(rows), -1))

    def finish(self, true_structure: HeightField | None = None, notes: tuple[str, ...] = ()) -> PrintRecord:
        """Return the record of the print.

        *true_structure*: the true structure at the end, if known; *notes*: notes of the log.
        """
        self._flush()
        rows = self._rows.rows.view(row_type(self.head.robot.m)).ravel()
        masses = self.head.settings.carrier.empty_mass + rows["left"]
        rows["taut"], rows["estimated_tensions"] = self._tensions.series(rows, masses)
        vibration, spools = self._vibration.result(), self._lines.spools()
        tensions = rows["estimated_tensions"][in_state(rows, PrintState.PRINTING)]
        done, begun = self._layers()
        true = self._true.result()
        settings = self.head.settings
        extrusion = settings.extrusion
        density = settings.carrier.powder_density if extrusion is None else extrusion.density
        bead = None if extrusion is None else extrusion.bead
        return PrintRecord(
            head=self.head,
            track=self.track,
            print_speed=self.print_speed,
            steps=self._steps,
            duration=self._time - self._start_time + self.head.period,
            begin=self._first_distance,
            distance=self._distance,
            travelled=self._travelled if true.error.count else math.nan,
            layers=done,
            layers_begun=begun,
            whole=self._whole.result(),
            true=true,
            estimated=self._estimated.result(),
            estimation_error=self._estimation_error.summary(),
            yaw=self._attitude.summary(0),
            tilt=self._attitude.summary(1),
            temperature=self._climate.summary(0),
            humidity=self._climate.summary(1),
            states={state: float(time) for state, time in zip(STATES, self._states, strict=True) if time > 0.0},
            spans=tuple(self._spans),
            barrier_stops=self._barrier_stops,
            refills=self._refills,
            faults=self._faults,
            notices=self._notices,
            rows=rows,
            lines=self._lines.result(spools, vibration, tensions),
            spools=spools,
            vibration=vibration,
            structure=structure_of(self._structure, true_structure, self.track, self._distance, density, bead),
            log_notes=notes,
        )

    def _layers(self) -> tuple[int, int]:
        """Number of layers finished, and of layers begun."""
        visits = self.track.visits
        ends = np.append(visits.begin[1:], self.track.length)
        proper, done = visits.number > 0, ends <= self._distance + _DONE
        begun = proper & (visits.begin < self._distance)
        finished = np.setdiff1d(visits.number[proper & done], visits.number[begun & ~done])
        return len(finished), len(np.unique(visits.number[begun]))
