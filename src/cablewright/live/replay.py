"""Replay of a machine's log by an estimator, compared with the truth where the log has it."""

from __future__ import annotations

import math
import time
from array import array
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, ClassVar, Final

import numpy as np

from cablewright.estimation import encoders_only
from cablewright.estimation.body import filter as of_body
from cablewright.estimation.body.state import start as of_body_start
from cablewright.estimation.lidar.room import Laser
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.progress import Progress
from cablewright.foundation.results import Figure, Pictured, figures_dict
from cablewright.foundation.signals import Estimate, LineAngles, Scan, Truth
from cablewright.live.body_estimator import body_settings
from cablewright.live.error_statistics import CHI2_95, SLACK, ErrorStatistics, bound, spread, statistics_figures
from cablewright.live.estimator_settings import OBSERVERS, Observer
from cablewright.live.estimators import ESTIMATORS, best_estimator, reckoning_of
from cablewright.live.fault_count import FaultCount, count_faults, fault_figures
from cablewright.machine.log.head import LogHead
from cablewright.machine.log.log import Entry, read_log
from cablewright.machine.powder_load import PowderLoad
from cablewright.solvers.taut import Taut

_MAX_REST_MOTION: Final = 3e-3  # m in the last second, for a step to count as static ...
_MIN_HISTORY: Final = 0.75  # s of that second that must be known
_TURNS: Final = 3  # of each horizontal lidar, before errors count
_RADIUS_TIME: Final = 10.0  # s until the estimated radii count
_TRACE: Final = 0.1  # s between points of a picture
_MAX_TRACE: Final = 100_000
NO_ESTIMATE: Final = "no step of the log has a valid estimate"
_COLUMNS: Final = (
    "time", "x", "y", "z", "yaw", "tilt", "moving", "excess_error", "true_excess", "named", "clean", "nees",
)  # fmt: skip


POSITION_ERRORS: Final = (
    Figure("position", "m", "Errors in space.", name="in space", parts=statistics_figures("m", "mm")),
    Figure("level", "m", "Errors seen from above.", name="from above", parts=statistics_figures("m", "mm")),
    Figure("height", "m", "Errors of the height.", name="in height", parts=statistics_figures("m", "mm")),
    Figure("within_2mm", "1", "Share of the errors in space of up to 2 mm; null without any.", detail=True),
    Figure("within_20mm", "1", "Share of the errors in space of up to 20 mm; null without any.", detail=True),
)


@dataclass(frozen=True, eq=False, repr=False)
class Replay(Pictured):
    """Result of a replay. Errors are estimated less true values, of counted steps; see `column`."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok; lost: no step has a valid estimate."),
        Figure("log", "", "The log file, or the run folder."),
        Figure("robot", "", "Name of the robot.", "head.robot.name"),
        Figure("plant", "", "Plant of the simulated machine.", "head.plant"),
        Figure("seed", "1", "Seed of the simulated machine.", "head.seed"),
        Figure("severity", "", "Deviations of the simulated machine from its description; null for any other machine.",
               "head.severity"),
        Figure("estimator", "", "The estimator: paper, filter or encoders."),
        Figure("steps", "1", "Number of steps in the log."),
        Figure("duration", "s", "Time on the machine's clock at the end.", shown="s"),
        Figure("valid_share", "1", "Share of the steps with a valid estimate.", "", "valid steps", shown="%"),
        Figure("compared_from", "s", "Time from which errors count; null without the truth.", "begin", shown="s"),
        Figure("coverage", "1", "Share of positions within their 95 % ellipsoid; null for an estimator without a "
               "covariance.", lambda of: of.coverage()[0], "positions within their 95 % ellipsoid", shown="%"),
        Figure("nees", "1", "Mean of the positions' normalised estimation error squared, ideally 3; null without a "
               "covariance.", lambda of: of.coverage()[1], "mean nees (ideally 3)", 3),
        Figure("consistency", "", "How large each sensor's innovations were at the end; empty for an estimator without "
               "a covariance.", lambda of: [{"sensor": name, "nis": mean} for name, mean in of.consistency.items()],
               "innovations at the end", parts=(
                   Figure("sensor", "", "Name of the sensor."),
                   Figure("nis", "1", "Mean of its last hundred normalised innovations squared over their degrees of "
                          "freedom, ideally 1.", name="mean square, by sigma", digits=2),
               )),
        Figure("static", "", "Position errors of the steps in which the drum stands.",
               lambda of: of.errors_while(moving=False), "position errors while the drum stands",
               parts=POSITION_ERRORS),
        Figure("moving", "", "Position errors of the steps in which the drum moves.",
               lambda of: of.errors_while(moving=True), "position errors while the drum moves",
               parts=POSITION_ERRORS),
        Figure("yaw", "rad", "Errors of the drum's yaw.", lambda of: spread(of.column("yaw")),
               along="errors of the drum's angles", parts=statistics_figures("rad", "deg")),
        Figure("tilt", "rad", "Errors of the tilt of the drum's axis.", lambda of: spread(of.column("tilt")),
               along="errors of the drum's angles", parts=statistics_figures("rad", "deg")),
        Figure("lines", "", "Names of the lines.", lambda of: [line.name for line in of.head.robot.lines], "line",
               along="line"),
        Figure("taut_share", "1", "Share of the valid steps in which each line was estimated to be taut.", "", "taut",
               shown="%", along="line"),
        Figure("slack", "", "How slack lines were identified; counted are steps with an excess of over 5 mm.",
               "slack_errors", "steps with a line slack by over 5 mm", parts=(
                   Figure("steps", "1", "Number of steps with a slack line.", name="number"),
                   Figure("named_share", "1", "Share of them in which exactly the slack lines were identified; null "
                          "without any.", name="identified", shown="%"),
                   Figure("excess", "m", "Errors of the estimated excess of the slackest line.",
                          parts=statistics_figures("m", "mm")),
               )),
        Figure("radius", "", "Relative errors of the winch drums' radii after 10 s.", "radius_spread",
               "winch drum radii after 10 s", parts=(
            Figure("within_1_percent", "1", "Share of the steps in which each line's radius was within 1 %; null "
                   "without any.", name="steps within 1 %", shown="%", digits=3),
            Figure("each", "1", "Relative errors of each line's radius.", name="relative errors of the radii", parts=(
                Figure("line", "", "Name of the line."), *statistics_figures("1", "%"))),
        )),
        Figure("step_time", "s", "Processor time of a step.", name="processor time of a step", parts=(
            Figure("mean", "s", "Mean processor time of a step."),
            Figure("p99", "s", "99 % quantile of the processor time.", name="99 %"),
            Figure("max", "s", "Largest processor time of a step."),
        )),
        Figure("faults", "", "Faults that the estimates reported.", lambda of: list(of.faults.items()),
               name="sensor messages", parts=fault_figures("from", "to")),
        Figure("notes", "", "Errors of the log file.", detail=True),
    )  # fmt: skip
    HEADLINES: ClassVar = ("status", "robot", "estimator", "steps", "valid_share")

    log: str | Path
    head: LogHead
    estimator: str
    notes: tuple[str, ...]  # faults of the file
    steps: int
    duration: float  # s on the machine's clock
    valid: int  # steps with a valid estimate
    begin: float  # s, from which errors are counted: each horizontal lidar has turned three times
    slack_steps: Array  # (m,) valid steps in which each line was estimated to be slack
    faults: FaultCount
    step_times: Array  # (steps,) s of processor time
    trace: list[tuple[float, ...]]
    """Each 0.1 s: time, yaw, tilt, true yaw, true tilt, error of position and its `bound`, then by line the angles that
    taut lines would have, and the measured ones."""
    errors: Array
    """Of k counted steps, (k, 12 + m): the columns of `column`, then relative errors of the winch drums' radii."""
    consistency: Mapping[str, float]  # of the last estimate

    @property
    def status(self) -> str:
        """``ok``, or ``lost``: no step has a valid estimate."""
        return "ok" if self.valid else "lost"

    @property
    def refusal(self) -> str:
        """Sentence with the reason if no step has a valid estimate."""
        return "" if self.valid else NO_ESTIMATE

    @property
    def valid_share(self) -> float:
        """Share of the steps with a valid estimate."""
        return self.valid / max(self.steps, 1)

    @property
    def taut_share(self) -> Array:
        """Share of the valid steps in which each line was taut, (m,)."""
        return np.asarray(1.0 - self.slack_steps / max(self.valid, 1))

    @property
    def slack_errors(self) -> dict[str, Any]:
        """Statistics of steps with a line slack by over `SLACK`: share identified exactly, errors of the excess, m."""
        due = self.column("true_excess") > SLACK
        right = due & (self.column("named") > 0.5) & (self.column("clean") > 0.5)
        count = int(np.count_nonzero(due))
        share = float(np.count_nonzero(right)) / count if count else math.nan
        return {"steps": count, "named_share": share, "excess": spread(self.column("excess_error")[due])}

    @property
    def radius_spread(self) -> dict[str, Any]:
        """Share of drum radii within 1 %, (m,), and relative errors by line, after 10 s."""
        since = self.column("time") - self.begin > _RADIUS_TIME
        radii = self.radius_errors
        each = [
            {"line": line.name} | asdict(spread(column[since]))
            for line, column in zip(self.head.robot.lines, radii.T, strict=True)
        ]
        within = np.mean(np.abs(radii[since]) <= 0.01, axis=0) if since.any() else None
        return {"within_1_percent": within, "each": each}

    @property
    def step_time(self) -> dict[str, float]:
        """Mean, 99 % quantile and largest processor time of a step, s."""
        times = self.step_times
        if not len(times):
            return dict.fromkeys(("mean", "p99", "max"), math.nan)
        return {"mean": float(times.mean()), "p99": float(np.percentile(times, 99)), "max": float(times.max())}

    def errors_while(self, *, moving: bool) -> dict[str, ErrorStatistics | float]:
        """Return errors in space, in plan and in height, m, of moving or static steps; shares in the paper's bounds."""
        x, y, height = self._offsets(moving).T
        space = self.position(moving=moving)
        shares = {f"within_{mm}mm": float(np.mean(space <= 1e-3 * mm)) if len(space) else math.nan for mm in (2, 20)}
        return {"position": spread(space), "level": spread(np.hypot(x, y)), "height": spread(height)} | shares

    def column(self, name: str) -> Array:
        """Return a column of the errors (k,): time, s; ``x``, ``y``, ``z``, m; yaw and tilt, rad; or one of these.

        ``true_excess``: m, of the slackest line, ``excess_error``: m, of its estimate. ``moving``, ``named`` and
        ``clean`` are 0 or 1. ``named``: each line with an excess over `SLACK` is estimated to be slack; ``clean``: no
        taut line is. ``nees``: the position's normalised estimation error squared; NaN without a covariance.
        """
        return self.errors[:, _COLUMNS.index(name)]

    @property
    def radius_errors(self) -> Array:
        """Relative errors of the radii (k, m), of counted steps."""
        return self.errors[:, len(_COLUMNS) :]

    def _offsets(self, moving: bool) -> Array:
        """Errors of the position (k, 3), m, of moving or static steps."""
        return self.errors[(self.column("moving") > 0.5) == moving, 1:4]

    def position(self, *, moving: bool) -> Array:
        """Return the sizes of the position errors in space, (k,) m, of moving or static steps."""
        return np.asarray(np.linalg.norm(self._offsets(moving), axis=1))

    def coverage(self) -> tuple[float, float]:
        """Return the share of steps whose position is within its 95 % ellipsoid, and the mean of ``nees``, ideally 3.

        NaN for an estimator without a covariance.
        """
        nees = self.column("nees")
        nees = nees[np.isfinite(nees)]
        return (float(np.mean(nees <= CHI2_95)), float(nees.mean())) if len(nees) else (math.nan, math.nan)


_OF_LOG = ("log", "robot", "plant", "seed", "severity", "steps", "duration", "lines", "notes")
_OF_ESTIMATOR = tuple(each for each in Replay.FIGURES if each.key not in _OF_LOG or each.key == "lines")


@dataclass(frozen=True, eq=False, repr=False)
class Replays(Pictured):
    """Replays of one log by several estimators."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok; lost: an estimator has no step with a valid estimate."),
        *(each.of_part("first") if each.key != "lines" else replace(each.of_part("first"), along="", detail=True)
          for each in Replay.FIGURES if each.key in _OF_LOG),
        Figure("estimators", "", "What each estimator found, by its name.", "by_estimator", parts=_OF_ESTIMATOR),
    )  # fmt: skip
    HEADLINES: ClassVar = ("status", "robot", "steps")

    each: tuple[Replay, ...]

    @property
    def first(self) -> Replay:
        """The first replay, for properties that all replays share."""
        return self.each[0]

    @property
    def status(self) -> str:
        """Status of the replays: "ok" or "lost", see `Replay.status`."""
        return "lost" if self.refusal else "ok"

    @property
    def notes(self) -> tuple[str, ...]:
        """Errors of the log file."""
        return self.first.notes

    @property
    def refusal(self) -> str:
        """Sentence with the reason if a replay has no valid estimate."""
        lost = [each.estimator for each in self.each if not each.valid]
        return f"{NO_ESTIMATE}: {', '.join(lost)}" if lost else ""

    @property
    def by_estimator(self) -> dict[str, dict[str, Any]]:
        """Figures of each estimator."""
        return {each.estimator: figures_dict(_OF_ESTIMATOR, each) for each in self.each}


def replay(
    log: str | Path,
    estimator: str | None = None,
    *,
    lasers: Sequence[Laser] = (),
    progress: Progress | None = None,
) -> Replay:
    """Run an estimator on a machine's *log*, an MCAP file or a run folder, and compare it with the truth in the log.

    *estimator* is ``paper``, that of Merlet and Papegay 2023, ``filter``, the Kalman filter of all sensors, or
    ``encoders``, dead reckoning by these alone; None: the first one for which the machine has the sensors. *lasers*:
    distances from B to walls that an operator measured at the start. Raises `UnknownName` for another estimator,
    `InputError` for a file that is no log or a machine without the sensors that the estimator needs.

    Examples
    --------
    >>> import cablewright as cw
    >>> cw.replay("run.mcap", "filter").status  # doctest: +SKIP
    'ok'
    """
    if estimator is not None and estimator not in ESTIMATORS:
        raise UnknownName("estimator", estimator, ESTIMATORS)
    with read_log(log) as entries:
        head = entries.head
        estimator = estimator or _usual_estimator(head)
        observer = OBSERVERS[estimator] if _is_by_scans(estimator, head) else _homed(estimator, head, log)
        settings = observer.settings(head.robot, head.settings, lasers)
        turning = tuple(name for name in ("north", "south") if name in head.settings.lidars)
        state, found = observer.start(settings), _Collector(head.robot.m, turning)
        load, now = PowderLoad.of(head.settings.carrier), math.nan
        for entry in entries.entries():
            dt = head.period if math.isnan(now) else entry.frame.time - now
            load.follow(entry.orders, entry.command, dt)
            now = entry.frame.time
            begin = time.thread_time()
            observer.weigh(settings, state, head.settings.carrier.full_mass - load.gone)
            estimate = observer.step(settings, state, entry.frame)
            found.add(entry, estimate, state.taut, time.thread_time() - begin)
            if progress is not None and found.steps % 500 == 0:
                progress(f"replaying, {estimator} (bytes)", entries.position, entries.size)
        return Replay(
            log, head, estimator, tuple(entries.notes), found.steps, found.duration, found.valid, found.begin,
            found.slack_steps, found.faults, np.array(found.step_times), found.trace,
            np.array(found.errors).reshape(-1, len(_COLUMNS) + head.robot.m), found.consistency,
        )  # fmt: skip


def _usual_estimator(head: LogHead) -> str:
    """Return the estimator for the sensors of a log's machine: for a point platform with lidars that of Merlet 2023."""
    best = best_estimator(head.settings)
    return "paper" if _is_by_scans(best, head) else best


def _is_by_scans(estimator: str, head: LogHead) -> bool:
    """Whether an *estimator* finds the platform by lidars, from no pose at which it was homed."""
    return head.robot.n == 3 and estimator in OBSERVERS


def _homed(estimator: str, head: LogHead, log: str | Path) -> Observer:
    """Return the functions of an estimator that begins where the log's head says that the machine was homed."""
    if estimator == "paper":
        raise InputError(
            f"estimator = {estimator}: is only for a point platform; the platform of {head.robot.name!r} is rigid"
        )
    home = head.home
    if head.robot.n == 3:
        needs = "the encoders alone need"
        found = Observer(
            lambda robot, settings, _lasers: reckoning_of(robot, settings),
            lambda settings: encoders_only.start(settings, np.array(home)),
            encoders_only.step,
        )
    else:
        needs = "a rigid platform needs"
        found = Observer(
            lambda robot, settings, _lasers: body_settings(robot, settings, sensors=estimator == "filter"),
            lambda settings: of_body_start(settings, np.array(home)),
            of_body.step,
        )
    if home is None:
        raise InputError(f"{log}: does not say at which pose the machine was homed, which {needs}")
    return found


class _Collector:
    """Collects the errors of estimates, step by step; attributes as in `Replay`."""

    def __init__(self, m: int, lidars: tuple[str, ...]) -> None:
        """Start with no steps of a machine with *m* lines and horizontal *lidars*."""
        self.steps, self.duration, self.valid, self.begin = 0, 0.0, 0, math.nan
        self.slack_steps = np.zeros(m)
        self.faults: FaultCount = {}
        self.step_times = array("d")
        self.trace: list[tuple[float, ...]] = []
        self.errors = array("d")  # row after row
        self.consistency: Mapping[str, float] = {}
        self._turns = dict.fromkeys(lidars, 0)
        self._recent: deque[tuple[float, Array]] = deque()
        self._angles = np.full(m, np.nan)
        self._traced = -math.inf

    def add(self, entry: Entry, estimate: Estimate, taut: Taut | None, seconds: float) -> None:
        """Add one step of the replay."""
        now = entry.frame.time
        self.steps += 1
        self.duration, self.consistency = now, estimate.consistency
        self.step_times.append(seconds)
        count_faults(self.faults, estimate.faults, now)
        for scan in entry.frame.of(Scan):
            if scan.source in self._turns:
                self._turns[scan.source] += 1
        for reading in entry.frame.of(LineAngles):
            self._angles = reading.angles
        if not estimate.valid:
            return
        self.valid += 1
        self.slack_steps += estimate.slack
        counts = min(self._turns.values(), default=_TURNS) >= _TURNS
        if entry.truth is not None and counts:
            if math.isnan(self.begin):
                self.begin = now
            self._compare(now, estimate, entry.truth)
        if now - self._traced >= _TRACE - 1e-9 and len(self.trace) < _MAX_TRACE:
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
        self.errors.extend((
            now, *off.tolist(), math.remainder(estimate.yaw - float(truth.rotation[2]), math.tau),
            _tilt_of(estimate.rotation) - _tilt_of(truth.rotation),
            float(not self._is_static(now, truth)),
            float(estimate.excess[line] - excess[line]), float(excess[line]),
            float(slack[excess > SLACK].all()), float(not slack[excess <= 0.0].any()), nees,
            *(estimate.radii / truth.radii - 1.0).tolist(),
        ))  # fmt: skip

    def _is_static(self, now: float, truth: Truth) -> bool:
        """Whether the drum moved by at most 3 mm in the last second."""
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
        self.trace.append(row)


def _tilt_of(rotation: Array) -> float:
    """Angle between the drum's axis and the vertical, rad, for small tilts."""
    return float(np.hypot(rotation[0], rotation[1]))
