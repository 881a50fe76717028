"""The record of a print, from its log alone, in one pass with bounded memory however long it was.

Errors are cross-track, seen from above, positive left of the path, of the steps in which it printed: the true ones
where the log has the truth, and as the estimation believed. Each is counted against the path near where the print was,
so that neither another branch at a crossing nor another layer is taken for it.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.machine.log.log import Entry, LogHead
from cablewright.printing.heightfield import HeightField
from cablewright.printing.track import Track
from cablewright.signals import DistanceReading, Inertial, LineAngles, PrintState, Scan
from cablewright.studies.fault_count import FaultCount, count_faults
from cablewright.studies.prints.line_tensions import LineTensions
from cablewright.studies.prints.lines import LineStatistics
from cablewright.studies.prints.path_errors import PathErrors
from cablewright.studies.prints.result import PrintRecord, Span
from cablewright.studies.prints.steps_table import STATES, Columns, StepsTable
from cablewright.studies.prints.structure import StructureScans, structure_of
from cablewright.studies.prints.vibration import VibrationWindows
from cablewright.studies.running_statistics import Moments, ThinnedRows

__all__ = ["UNUSED", "Recorder", "record"]

Array = NDArray[np.float64]

UNUSED: Final = (Inertial, DistanceReading, "/scan/north", "/scan/south")
"""Signals that are not looked at: ``log.entries(without=UNUSED)`` is faster and gives the same record."""

_PORTION: Final = 2048  # steps that are looked at in one go
_MAX_SPANS: Final = 10_000
_DONE: Final = 0.02  # m before its end a layer counts as finished
_DRAWN: Final = ("offset", "speed", "seen_offset", "seen_speed")


def record(
    entries: Iterable[Entry],
    head: LogHead,
    track: Track,
    *,
    print_speed: float,
    true_structure: HeightField | None = None,
) -> PrintRecord:
    """Make the record of the print whose log has *entries* and *head*, and which followed *track* (of the platform).

    *print_speed*: m/s, wanted. *true_structure*: what truly lies at the end, where that is known.
    """
    recorder = Recorder(head, track, print_speed)
    for entry in entries:
        recorder.add(entry)
    return recorder.finish(true_structure)


class Recorder:
    """Takes a print's steps one after another. What it holds grows with the number of layers alone."""

    def __init__(self, head: LogHead, track: Track, print_speed: float) -> None:
        """Begin with no step."""
        self.head, self.track, self.print_speed = head, track, print_speed
        m = head.robot.m
        self._rows = StepsTable(m, head.settings, head.period, _PORTION)
        self._true, self._seen = PathErrors(track, print_speed, "true_"), PathErrors(track, print_speed, "")
        self._lines = LineStatistics(head)
        self._off, self._turned, self._air = Moments(), Moments(2), Moments(2)
        self._thinned = ThinnedRows(Columns.width(m) + len(_DRAWN))
        self._states, self._travelled = np.zeros(len(STATES)), 0.0
        self._place = np.full((1, 3), np.nan)  # true, of the last row
        self._steps, self._begin, self._time = 0, math.nan, math.nan
        self._first, self._distance = math.nan, 0.0
        self._spans: list[Span] = []
        self._barrier_stops = self._refills = 0
        self._faults: FaultCount = {}
        self._notices: Counter[str] = Counter()
        self._expected = np.full(m, np.nan)  # Hz, as the window of vibration began
        self._vibration, self._believed = VibrationWindows(m), LineTensions(head.robot, head.settings)
        lidar = head.settings.lidars.get("vertical")
        self._scans = None if lidar is None else StructureScans(lidar, track)

    def add(self, entry: Entry) -> None:
        """Take one step."""
        if not self._steps:
            self._begin = entry.frame.time
        self._steps += 1
        self._time = entry.frame.time
        self._rows.put(entry)
        self._follow(entry)
        if entry.estimate is not None:
            count_faults(self._faults, entry.estimate.faults, self._time)
            if self._scans is not None:
                self._scans.set_pose(entry.estimate, self._distance)
        for notice in entry.frame.notices:
            self._notices[
                f"{notice.subject}: {notice.condition.value}" if notice.subject else notice.condition.value
            ] += 1
        self._hear(entry)
        if self._rows.full:
            self._digest()

    def _hear(self, entry: Entry) -> None:
        for reading in entry.frame.readings:
            if isinstance(reading, LineAngles):
                self._ring(reading, entry)
            elif isinstance(reading, Scan) and reading.source == "vertical" and self._scans is not None:
                self._scans.add(reading)

    def _ring(self, reading: LineAngles, entry: Entry) -> None:
        """Take the lines' angles; what the lines should ring at is asked for as a window begins and as it ends."""
        whole = self._vibration.add(reading)
        if not whole and not self._vibration.window_begins:
            return
        estimate, expected = entry.estimate, np.full(self.head.robot.m, np.nan)
        if estimate is not None and estimate.valid:
            expected = self._believed.frequencies(estimate, self._mass(self._rows.left))
        if whole:
            self._vibration.close(self._rows.temperature, 0.5 * (self._expected + expected))
        else:
            self._expected = expected

    def _mass(self, powder: float) -> float:
        return self.head.settings.drum.empty_mass + max(powder, 0.0)

    def _follow(self, entry: Entry) -> None:
        """Keep count of distance and states."""
        progress, now, spans = entry.progress, entry.frame.time, self._spans
        if progress is None:
            return
        if math.isnan(self._first):
            self._first = progress.distance
        self._distance = max(self._distance, progress.distance)
        if spans and spans[-1].state is progress.state:
            spans[-1] = Span(progress.state, spans[-1].begin, now, spans[-1].reason or progress.reason)
            return
        if progress.state is PrintState.PAUSED:
            self._barrier_stops += "barrier" in progress.reason.lower() or self._rows.broken
        self._refills += progress.state is PrintState.REFILLING
        if len(spans) < _MAX_SPANS:
            spans.append(Span(progress.state, spans[-1].end if spans else now, now, progress.reason))

    def _digest(self) -> None:
        """Count in the rows that have gathered."""
        rows = self._rows.take()
        if not len(rows):
            return
        printing = rows.in_state(PrintState.PRINTING)
        chosen = printing & np.isfinite(rows["distance"])
        drawn = np.full((len(rows), len(_DRAWN)), np.nan)
        for k, follower in enumerate((self._true, self._seen)):
            if chosen.any():
                drawn[chosen, 2 * k : 2 * k + 2] = np.stack(follower.add(rows.where(chosen)), axis=1)
        self._off.add(drawn[:, 2] - drawn[:, 0])
        rotation = rows["rotation"][printing]
        self._turned.add(np.column_stack([rotation[:, 2], np.hypot(rotation[:, 0], rotation[:, 1])]))
        self._air.add(np.column_stack([rows["temperature"], rows["humidity"]]))
        step, state = np.nan_to_num(np.maximum(rows["step"], 0.0)), rows["state"]
        known = np.isfinite(state)
        self._states += np.bincount(state[known].astype(np.int64), step[known], len(STATES))
        places = np.concatenate([self._place, rows["true_position"]])
        self._travelled += float(np.nansum(np.linalg.norm(np.diff(places, axis=0), axis=1)))
        self._place = places[-1:]
        self._lines.add(rows, printing)
        self._thinned.add(np.column_stack([rows.rows, drawn]))

    def finish(self, true_structure: HeightField | None = None, notes: tuple[str, ...] = ()) -> PrintRecord:
        """Tell what came of it. *true_structure*: what truly lies, where that is known; *notes*: what the log says."""
        self._digest()
        m = self.head.robot.m
        width = Columns.width(m)
        rows = Columns(m, self._thinned.rows[:, :width])
        drawn = dict(zip(_DRAWN, self._thinned.rows[:, width:].T, strict=True))
        masses = self.head.settings.drum.empty_mass + np.maximum(rows["left"], 0.0)
        drawn["taut"], drawn["believed"] = self._believed.series(rows, masses)
        ringing, coiling = self._vibration.result(), self._lines.spools()
        believed = drawn["believed"][rows.in_state(PrintState.PRINTING)]
        done, begun = self._layers()
        true = self._true.result()
        settings = self.head.settings
        density = settings.drum.powder_density if settings.extrusion is None else settings.extrusion.density
        return PrintRecord(
            head=self.head,
            track=self.track,
            print_speed=self.print_speed,
            steps=self._steps,
            duration=self._time - self._begin + self.head.period,
            begin=self._first,
            distance=self._distance,
            travelled=self._travelled if true.error.count else math.nan,
            layers=done,
            layers_begun=begun,
            true=true,
            estimated=self._seen.result(),
            estimation_error=self._off.summary(),
            yaw=self._turned.summary(0),
            tilt=self._turned.summary(1),
            temperature=self._air.summary(0),
            humidity=self._air.summary(1),
            states={state: float(time) for state, time in zip(STATES, self._states, strict=True) if time > 0.0},
            spans=tuple(self._spans),
            barrier_stops=self._barrier_stops,
            refills=self._refills,
            faults=self._faults,
            notices=self._notices,
            rows=rows,
            drawn=drawn,
            lines=self._lines.result(coiling, ringing, believed),
            spools=coiling,
            vibration=ringing,
            structure=structure_of(self._scans, true_structure, self.track, self._distance, density),
            notes=notes,
        )

    def _layers(self) -> tuple[int, int]:
        """How many layers were finished, and how many begun."""
        visits = self.track.visits
        ends = np.append(visits.begin[1:], self.track.length)
        proper = visits.number >= 0
        done = np.unique(visits.number[proper & (ends <= self._distance + _DONE)])
        begun = np.unique(visits.number[proper & (visits.begin < self._distance)])
        rest = np.unique(visits.number[proper & (ends > self._distance + _DONE) & (visits.begin < self._distance)])
        return len(np.setdiff1d(done, rest)), len(begun)
