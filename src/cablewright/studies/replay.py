"""Runs an estimator on a machine's log and compares it with the truth where the log has it."""

from __future__ import annotations

import math
import time
from array import array
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.errors import UnknownName
from cablewright.estimation.lidar.room import Laser
from cablewright.machine.log.log import Entry, LogHead, read_log
from cablewright.progress import Progress
from cablewright.signals import Estimate, LineAngles, Scan, Truth
from cablewright.solvers.taut import Taut
from cablewright.studies.estimator_settings import OBSERVERS
from cablewright.studies.fault_count import FaultCount, count_faults

__all__ = ["CHI2_95", "SLACK", "ErrorStatistics", "Replay", "bound", "replay", "spread"]

Array = NDArray[np.float64]

CHI2_95: Final = 7.8147
"""95 % quantile of the chi-square distribution with 3 degrees of freedom."""

SLACK: Final = 5e-3
"""True excess from which a slack line has to be identified, m."""

_MAX_REST_MOTION: Final = 3e-3  # m in the last second, for a step to count as static ...
_MIN_HISTORY: Final = 0.75  # s of that second that have to be known
_TURNS: Final = 3  # of each horizontal lidar, before errors count
_TRACE: Final = 0.1  # s between points of a picture
_MAX_TRACE: Final = 100_000


@dataclass(frozen=True)
class ErrorStatistics:
    """Count, root mean square, median, 95 % and 99 % quantiles and largest size of some errors."""

    count: int
    rms: float
    median: float
    p95: float
    p99: float
    most: float


def spread(values: Array) -> ErrorStatistics:
    """Return the statistics of the sizes of *values* (k,); NaN for none."""
    size = np.abs(values[np.isfinite(values)])
    if not len(size):
        return ErrorStatistics(0, *(math.nan,) * 5)
    middle, p95, p99 = np.percentile(size, (50.0, 95.0, 99.0)).tolist()
    return ErrorStatistics(len(size), float(np.sqrt((size**2).mean())), middle, p95, p99, float(size.max()))


def bound(covariance: Array) -> float:
    """95 % quantile, m, of the size of an error with that *covariance* (3, 3), m^2.

    By two moments of its square, as a chi-square distribution (Satterthwaite; Wilson and Hilferty).
    """
    trace, square = float(np.trace(covariance)), float(np.sum(covariance * covariance))
    if not square > 0.0:
        return 0.0
    numbers = trace * trace / square
    root = 1.0 - 2.0 / (9.0 * numbers) + 1.645 * math.sqrt(2.0 / (9.0 * numbers))
    return math.sqrt(trace * root**3)


_COLUMNS: Final = (
    "time", "x", "y", "z", "yaw", "tilt", "moving", "excess_error", "true_excess", "named", "clean", "nees",
)  # fmt: skip


@dataclass(eq=False)
class Replay:
    """Result of a replay. Errors are estimated less true, of counted steps; see `column`."""

    head: LogHead
    estimator: str
    steps: int = 0
    duration: float = 0.0
    """s on the machine's clock."""
    notes: tuple[str, ...] = ()
    """Faults of the file."""
    faults: FaultCount = field(default_factory=dict)
    """By source and sentence: start and end (s), number of steps."""
    valid: int = 0
    """Number of steps with a valid estimate."""
    begin: float = math.nan
    """s, from which errors are counted: each horizontal lidar has turned three times."""
    slack_steps: Array = field(default_factory=lambda: np.zeros(0))
    """Number of valid steps in which each line was estimated to be slack, (m,)."""
    step_times: array[float] = field(default_factory=lambda: array("d"))
    """s of processor time of each step."""
    trace: list[tuple[float, ...]] = field(default_factory=list)
    """Each 0.1 s: time, yaw, tilt, true yaw, true tilt, error of position and its `bound`, then gamma taut and measured
    by line."""
    errors: dict[str, array[float]] = field(default_factory=lambda: {name: array("d") for name in _COLUMNS})
    """By column, of counted steps: see `column`."""
    radii: list[array[float]] = field(default_factory=list)
    """By line: relative errors of the winch drums' radii, of counted steps."""

    def column(self, name: str) -> Array:
        """Return a column of the errors (k,): m and rad; ``moving``, ``named`` and ``clean`` are 0 or 1.

        ``true_excess``: of the slackest line, ``excess_error``: of its estimate. ``named``: each line with an excess
        over `SLACK` is estimated to be slack; ``clean``: no taut line is. ``nees``: the position's normalised
        estimation error squared; NaN without a covariance.
        """
        return np.array(self.errors[name])

    @property
    def radius_errors(self) -> Array:
        """Relative errors of the radii (k, m), of counted steps."""
        return np.array(self.radii).reshape(len(self.radii), -1).T

    def counted(self, *, moving: bool) -> NDArray[np.bool_]:
        """Return which counted steps are moving, or static, (k,)."""
        return np.asarray((self.column("moving") > 0.5) == moving)

    def position(self, *, moving: bool) -> Array:
        """Return sizes of the position's errors in space, (k,) m, of moving or static steps."""
        columns = [self.column(name)[self.counted(moving=moving)] for name in ("x", "y", "z")]
        return np.asarray(np.sqrt(sum(c**2 for c in columns)))

    def level(self, *, moving: bool) -> Array:
        """Return sizes of the position's errors seen from above, (k,) m."""
        columns = [self.column(name)[self.counted(moving=moving)] for name in ("x", "y")]
        return np.asarray(np.hypot(*columns))

    def slack_identified(self) -> tuple[int, float]:
        """Return the number of steps with a line slack by over `SLACK`, and the share with exactly these identified."""
        due = self.column("true_excess") > SLACK
        right = due & (self.column("named") > 0.5) & (self.column("clean") > 0.5)
        count = int(np.count_nonzero(due))
        return count, float(np.count_nonzero(right)) / count if count else math.nan

    def coverage(self) -> tuple[float, float]:
        """Return the share of steps whose position is within its 95 % ellipsoid, and the mean of ``nees``, at best 3.

        NaN for an estimator without a covariance.
        """
        nees = self.column("nees")
        nees = nees[np.isfinite(nees)]
        return (float(np.mean(nees <= CHI2_95)), float(nees.mean())) if len(nees) else (math.nan, math.nan)


def replay(
    path: str | Path,
    estimator: str = "paper",
    lasers: Sequence[Laser] = (),
    *,
    progress: Progress | None = None,
) -> Replay:
    """Run *estimator* on the log at *path*. *lasers*: what an operator measured at the start.

    Raises `InputError` for a file that is no log, an estimator that is not there, a machine that cannot be observed.
    """
    if estimator not in OBSERVERS:
        raise UnknownName("estimator", estimator, OBSERVERS)
    with read_log(path) as log:
        one = OBSERVERS[estimator]
        settings = one.settings(log.head.robot, log.head.settings, lasers)
        turning = tuple(name for name in ("north", "south") if name in log.head.settings.lidars)
        state, collector = one.start(settings), _ErrorCollector(Replay(log.head, estimator), turning)
        for entry in log.entries():
            begin = time.thread_time()
            estimate = one.step(settings, state, entry.frame)
            collector.add(entry, estimate, state.taut, time.thread_time() - begin)
            if progress is not None and collector.found.steps % 500 == 0:
                progress("replaying (bytes)", log.position, log.size)
        collector.found.notes = tuple(log.notes)
    return collector.found


class _ErrorCollector:
    """Collects the errors of estimates, step by step."""

    def __init__(self, found: Replay, lidars: tuple[str, ...]) -> None:
        """Fill *found*."""
        m = found.head.robot.m
        self.found = found
        found.slack_steps = np.zeros(m)
        found.radii = [array("d") for _ in range(m)]
        self._turns = dict.fromkeys(lidars, 0)
        self._recent: deque[tuple[float, Array]] = deque()
        self._angles = np.full(m, np.nan)
        self._traced = -math.inf

    def add(self, entry: Entry, estimate: Estimate, taut: Taut | None, seconds: float) -> None:
        """Add one step."""
        found, now = self.found, entry.frame.time
        found.steps += 1
        found.duration = now
        found.step_times.append(seconds)
        count_faults(found.faults, estimate.faults, now)
        for scan in entry.frame.of(Scan):
            assert isinstance(scan, Scan)
            if scan.source in self._turns:
                self._turns[scan.source] += 1
        for reading in entry.frame.of(LineAngles):
            assert isinstance(reading, LineAngles)
            self._angles = reading.angles
        if not estimate.valid:
            return
        found.valid += 1
        found.slack_steps += estimate.slack
        counts = min(self._turns.values()) >= _TURNS
        if entry.truth is not None and counts:
            if math.isnan(found.begin):
                found.begin = now
            self._compare(now, estimate, entry.truth)
        if now - self._traced >= _TRACE - 1e-9 and len(found.trace) < _MAX_TRACE:
            self._traced = now
            self._add_trace(now, estimate, entry.truth, taut)

    def _compare(self, now: float, estimate: Estimate, truth: Truth) -> None:
        self._recent.append((now, truth.position))
        while now - self._recent[0][0] > 1.0 + 1e-9:
            self._recent.popleft()
        off = estimate.position - truth.position
        covariance = estimate.covariance
        nees = math.nan if covariance is None else float(off @ np.linalg.solve(covariance[:3, :3], off))
        line = int(np.argmax(truth.excess))
        slack, excess = estimate.slack, truth.excess
        row = (
            now, *off.tolist(), math.remainder(estimate.yaw - float(truth.rotation[2]), math.tau),
            _tilt_of(estimate.rotation) - _tilt_of(truth.rotation),
            float(not self._is_static(now, truth)),
            float(estimate.excess[line] - excess[line]), float(excess[line]),
            float(slack[excess > SLACK].all()), float(not slack[excess <= 0.0].any()), nees,
        )  # fmt: skip
        for name, value in zip(_COLUMNS, row, strict=True):
            self.found.errors[name].append(value)
        for column, value in zip(self.found.radii, (estimate.radii / truth.radii - 1.0).tolist(), strict=True):
            column.append(value)

    def _is_static(self, now: float, truth: Truth) -> bool:
        """Whether the drum has hardly moved in the last second."""
        since, place = self._recent[0]
        return now - since > _MIN_HISTORY and float(np.sqrt(((truth.position - place) ** 2).sum())) <= _MAX_REST_MOTION

    def _add_trace(self, now: float, estimate: Estimate, truth: Truth | None, taut: Taut | None) -> None:
        true = (math.nan,) * 3
        if truth is not None:
            away = float(np.sqrt(((estimate.position - truth.position) ** 2).sum()))
            true = float(truth.rotation[2]), _tilt_of(truth.rotation), away
        within = math.nan if estimate.covariance is None else bound(estimate.covariance[:3, :3])
        angles = np.full(len(self._angles), np.nan) if taut is None else taut.angles
        row = (now, estimate.yaw, _tilt_of(estimate.rotation), *true, within, *angles.tolist(), *self._angles.tolist())
        self.found.trace.append(row)


def _tilt_of(rotation: Array) -> float:
    """Angle between the drum's axis and the vertical, rad, for small tilts."""
    return float(np.hypot(rotation[0], rotation[1]))
