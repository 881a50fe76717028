"""`check`: a sliced part on a robot: lengths, errors and limits of every sample, and one verdict."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from operator import attrgetter
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from cablewright.analyses.accuracy.compensation import COMPENSATIONS, Reached
from cablewright.analyses.feasibility import Finding, LineQuantities, judge
from cablewright.arrays import Array, Indices
from cablewright.models.rotation import angle_between
from cablewright.models.statics import Model
from cablewright.printing.job import Job, load_job
from cablewright.printing.path import Samples
from cablewright.printing.timing import TimeLaw
from cablewright.printing.toolpath import BY_HEIGHT, Toolpath
from cablewright.progress import Progress, silent
from cablewright.results import Figure, Result
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse
from cablewright.studies.job_poses import along

BLOCK = 128 * 64  # samples solved between two reports of progress; a multiple of the kernels' chunk
MET = 1e-6
"""Largest error (m, and rad) of the full model on the compensated path."""


@dataclass(frozen=True, eq=False)
class PathStatics:
    """Statics of k samples of a path with m lines. Arrays have one row per sample; SI."""

    codes: NDArray[np.int64]  # (k,) status of the inverse problem
    violations: Array  # (k,) N, largest excess of a tension over its limits
    tensions: Array  # (k, m) N, at the sheave
    lines: LineQuantities  # (k, m) each: quantities that have limits
    rigid_lengths: Array  # (k, m) m, paid out without compensation: cables as rigid
    lengths: Array  # (k, m) m, paid out with full compensation
    uncompensated: Array  # (k, n) poses of the full model with the rigid lengths; NaN where none
    elastic_only: Array  # (k, n) poses if elasticity but not sag is compensated
    compensated: Array  # (k, n) poses with the compensated lengths

    @classmethod
    def of(cls, full: Model, poses: Array, retraction: Array | None) -> Self:
        """Solve neighbouring *poses* (k, n), m and rad, at rest. Rows without a straight-line geometry are NaN."""

        def reached(lengths: Array, near: Array) -> Array:
            return Reached.of(full, lengths, near, retraction=retraction, path=True).poses

        held = solve_inverse(full, poses, path=True, retraction=retraction)
        rigid, elastic = (
            COMPENSATIONS[name].lengths(held, poses, retraction=retraction) for name in ("none", "elastic")
        )
        uncompensated = reached(rigid, poses)
        start = np.where(np.isnan(uncompensated), poses, uncompensated)
        return cls(
            codes=held.code,
            violations=held.violation,
            tensions=held.tensions,
            lines=LineQuantities.of(held),
            rigid_lengths=rigid,
            lengths=held.lengths,
            uncompensated=uncompensated,
            elastic_only=reached(elastic, poses),
            compensated=reached(held.lengths, start),
        )


def extreme(choose: np.ufunc, values: Array) -> float:
    """The smallest or largest of *values*, by ``np.fmin`` or ``np.fmax``; NaN where none is a number."""
    return float(choose.reduce(values, axis=None, initial=np.nan))


def median(values: Array) -> Array:
    """The lower median along the first axis of what is not NaN; NaN where that is nothing."""
    ranked = np.sort(values, axis=0)  # NaN comes last
    known = np.count_nonzero(~np.isnan(ranked), axis=0)
    at = np.maximum(known - 1, 0) // 2
    return np.asarray(np.take_along_axis(ranked, np.asarray(at)[None], axis=0)[0])


@dataclass(frozen=True)
class Place:
    """A sample of a job."""

    position: tuple[float, float, float]  # m
    layer: int
    gcode_line: int


class PlacedFinding(NamedTuple):
    """A finding and where its worst sample is."""

    finding: Finding
    place: Place


PLACE = (
    Figure("position", "m", "Position of the nozzle."),
    Figure("layer", "", "Layer; -1 before the first."),
    Figure("gcode_line", "", "Line of the G-code file."),
)
FINDING = (
    *(each.of_part("finding") for each in Finding.FIGURES),
    Figure("place", "", "Place of the worst sample.", parts=PLACE, detail=True),
)


def _extreme_of(key: str, unit: str, meaning: str, choose: np.ufunc, array: str, **more: Any) -> Figure:
    """The smallest or largest value of an array of the check."""
    return Figure(key, unit, meaning, lambda found: extreme(choose, attrgetter(array)(found)), **more)


def _of_lines(
    key: str, unit: str, meaning: str, name: str, array: str, choose: Callable[[Array], Array] = np.fmax.reduce
) -> Figure:
    """One value of each line, of an array (k, m) of the check."""
    return Figure(key, unit, meaning, lambda found: choose(attrgetter(array)(found)), name, along="line")


def _errors() -> tuple[Figure, ...]:
    """The largest errors, by what is compensated."""
    named = (("none", "uncompensated"), ("elastic", "elastic_only"), ("full", "compensated"))
    return tuple(
        _extreme_of(f"max_error_{key}", "m", f"Largest error of the nozzle {words}.", np.fmax, f"error_{key}",
                    name=f"max error {words}", digits=3, shown="mm")
        for words, key in ((COMPENSATIONS[name].words, key) for name, key in named)
    )  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class Check(Result):
    """Result of a check: k samples, m lines; SI."""

    FIGURES: ClassVar = (
        Figure("feasible", "", "Whether every sample is within all limits."),
        Figure("verdict", "", "The answer in one sentence."),
        Figure("layers", "1", "Number of layers of the part.", "layer_count"),
        Figure("layers_by", "", "Layer marker of the file; height where it has none.", "toolpath.layers_by",
               "layers by"),
        Figure("material_by", "", "What lays material: an axis, a switch, or every G1.", "toolpath.material_by",
               "material by"),
        Figure("slicer", "", "Program and version that the G-code names; empty if none.", "toolpath.slicer",
               detail=True),
        Figure("objects", "", "Names of the objects that the G-code labels.", "toolpath.objects", detail=True),
        Figure("samples", "1", "Number of samples of the path.", lambda found: len(found.samples)),
        Figure("extruded_length", "m", "Length of path on which material is laid.", "samples.extruded_length"),
        Figure("travel_length", "m", "Length of path on which none is laid.", "samples.travel_length"),
        Figure("duration", "s", "Duration of the job.", "law.duration"),
        _extreme_of("min_tension", "N", "Smallest tension, anywhere along a line.", np.fmin,
                    "statics.lines.lowest_tension", shown="N"),
        _extreme_of("max_tension", "N", "Largest tension, anywhere along a line.", np.fmax,
                    "statics.lines.highest_tension", shown="N"),
        *_errors(),
        Figure("median_error_uncompensated", "m", "Median error of the nozzle without compensation.",
               lambda found: float(median(found.error_uncompensated)), "median error without compensation", 3,
               shown="mm"),
        _extreme_of("max_turn_uncompensated", "rad", "Largest angle of the platform from its expected rotation without "
                    "compensation; 0 for a point platform.", np.fmax, "turn_uncompensated",
                    name="max turn without compensation", digits=3),
        _extreme_of("max_turn_compensated", "rad", "Largest angle of the platform from its expected rotation with full "
                    "compensation; 0 for a point platform.", np.fmax, "turn_compensated",
                    name="max turn with full compensation", digits=3),
        _extreme_of("max_winch_speed", "m/s", "Largest speed of a cable at its winch.", np.fmax,
                    "statics.lines.winch_speed", digits=3),
        _extreme_of("max_winch_torque", "N m", "Largest torque at a drum; null where no drum radius is given.", np.fmax,
                    "statics.lines.winch_torque"),
        Figure("lines", "", "Names of the lines.", lambda found: [line.name for line in found.robot.lines], "line",
               along="line"),
        _of_lines("line_min_tension", "N", "Smallest tension of each line.", "min tension",
                  "statics.lines.lowest_tension", np.fmin.reduce),
        _of_lines("line_median_tension", "N", "Median tension of each line at its sheave.", "median tension",
                  "statics.tensions", median),
        _of_lines("line_max_tension", "N", "Largest tension of each line.", "max tension",
                  "statics.lines.highest_tension"),
        Figure("line_tension_limits", "N", "Min and max tension that is allowed, of each line.",
               lambda found: [line.tension_limits for line in found.robot.lines], "limits", shown="N", along="line"),
        _of_lines("line_max_length", "m", "Largest unstrained length of each line.", "max length", "lengths"),
        _of_lines("line_max_winch_speed", "m/s", "Largest speed of each cable at its winch.", "max speed",
                  "statics.lines.winch_speed"),
        _of_lines("line_max_winch_torque", "N m", "Largest torque of each drum; null where not known.", "max torque",
                  "statics.lines.winch_torque"),
        _of_lines("line_min_swing", "rad", "Min azimuth of each sheave from where its mounting faces.", "min swing",
                  "statics.lines.swing", np.fmin.reduce),
        _of_lines("line_max_swing", "rad", "Max azimuth of each sheave from where its mounting faces.", "max swing",
                  "statics.lines.swing"),
        _of_lines("line_min_lever", "rad", "Min angle of each lever above the horizontal.", "min lever",
                  "statics.lines.lever", np.fmin.reduce),
        _of_lines("line_max_lever", "rad", "Max angle of each lever above the horizontal.", "max lever",
                  "statics.lines.lever"),
        Figure("findings", "", "Every limit, those that are broken first.", "placed_findings", "limits of the robot",
               parts=FINDING),
        Figure("ignored_words", "1", "Words of the G-code without effect, by how often they are there.", "unknown"),
    )  # fmt: skip
    HEADLINES: ClassVar = ("feasible", "layers", "samples", "max_tension", "max_error_uncompensated")

    robot: Robot
    job: Job
    samples: Samples  # positions (k, 3) of the nozzle, layer, line (of the G-code file), extruding, distance
    law: TimeLaw
    poses: Array  # (k, n) intended, of the platform's origin
    retraction: Array | None  # (k,) m, None where the job does not set it
    statics: PathStatics
    findings: tuple[Finding, ...]
    feasible: bool
    verdict: str  # one sentence
    toolpath: Toolpath
    unknown: dict[str, int]  # ignored words of the G-code, and how often
    layer_count: int

    @property
    def codes(self) -> NDArray[np.int64]:
        """(k,) status of each sample's inverse problem."""
        return self.statics.codes

    @property
    def lengths(self) -> Array:
        """(k, m) m, compensated: what the winches should pay out."""
        return self.statics.lengths

    @cached_property
    def error_uncompensated(self) -> Array:
        """(k,) m, of the nozzle."""
        return self._error(self.statics.uncompensated)

    @cached_property
    def error_compensated(self) -> Array:
        """(k,) m, of the nozzle."""
        return self._error(self.statics.compensated)

    @cached_property
    def error_elastic_only(self) -> Array:
        """(k,) m, of the nozzle."""
        return self._error(self.statics.elastic_only)

    @cached_property
    def turn_uncompensated(self) -> Array:
        """(k,) rad, rotation of the platform from the intended one; 0 for a point."""
        return self._turn(self.statics.uncompensated)

    @cached_property
    def turn_compensated(self) -> Array:
        """(k,) rad."""
        return self._turn(self.statics.compensated)

    def nozzle(self, poses: Array) -> Array:
        """Positions of the nozzle, (k, 3) m, at *poses* (k, n) of the platform, m and rad."""
        return Model(self.robot).nozzle(poses)

    def _error(self, poses: Array) -> Array:
        return np.asarray(np.linalg.norm(self.nozzle(poses) - self.samples.positions, axis=1))

    def _turn(self, poses: Array) -> Array:
        if poses.shape[1] == 3:
            return np.where(np.isnan(poses[:, 0]), np.nan, 0.0)
        return angle_between(poses[:, 3:], self.poses[:, 3:])

    @property
    def placed_findings(self) -> tuple[PlacedFinding, ...]:
        """The findings, with the place of each."""
        return tuple(PlacedFinding(finding, self.place(finding.sample)) for finding in self.findings)

    @property
    def notes(self) -> tuple[str, ...]:
        """What was guessed of the G-code."""
        found = self.toolpath.layers_by == BY_HEIGHT and isinstance(self.job.path, Path)
        return ("layers are found by height: the file has no layer markers",) if found else ()

    @property
    def refusal(self) -> str:
        """Why the answer is no."""
        return "" if self.feasible else self.verdict

    def place(self, sample: int) -> Place:
        """Where a sample is: position, layer and line of the G-code file."""
        x, y, z = (float(each) for each in self.samples.positions[sample])
        return Place((x, y, z), int(self.samples.layer[sample]), int(self.samples.line[sample]))


def check(
    robot: Robot | Model,
    job: Job | str | Path,
    *,
    tension_limits: tuple[float, float] | None = None,
    progress: Progress | None = None,
) -> Check:
    """Check *job*, or its file, on *robot* under the full model: lengths, errors, and limits that are exceeded.

    *tension_limits* (N) replace those of every line. The job's path is the nozzle's; a rigid platform is unrotated or
    has the rotation of the job's schedule. Raises `InputError` for a model under another law, a robot with fewer lines
    than freedoms, a schedule that it cannot follow or a G-code file that cannot be used; an infeasible job raises
    nothing.
    """
    report = progress or silent
    full = Model.full(robot, tension_limits=tension_limits)
    robot = full.robot if full.tension_limits is None else full.robot.limited(full.tension_limits)
    job = job if isinstance(job, Job) else load_job(job)
    toolpath = job.toolpath(report)
    samples = job.samples(toolpath)
    law = job.time_law(samples)
    poses, retraction = along(robot, job, samples)
    solved = _solve(full, poses, retraction, report)
    speed = _cable_speed(solved.lengths, samples, law)
    lines = replace(solved.lines, winch_speed=speed, cable_length=solved.lengths)
    findings = judge(robot, poses[:, :3], solved.codes, solved.violations, lines)
    found = Check(
        robot=robot,
        job=job,
        samples=samples,
        law=law,
        poses=poses,
        retraction=retraction,
        statics=replace(solved, lines=lines),
        findings=findings,
        feasible=not solved.codes.any() and all(finding.violations == 0 for finding in findings),
        verdict="",
        toolpath=toolpath,
        unknown=toolpath.unknown,
        layer_count=toolpath.layer_count,
    )
    missed = ~(found.error_compensated + found.turn_compensated <= MET) & (found.codes == 0)
    found = replace(found, feasible=found.feasible and not missed.any())
    return replace(found, verdict=_verdict(found, np.flatnonzero(missed)))


def _solve(full: Model, poses: Array, retraction: Array | None, report: Progress) -> PathStatics:
    """Solve the inverse and forward problems of the path, block by block."""
    rows, blocks = len(poses), []
    for first in range(0, rows, BLOCK):
        report("solving", first, rows)
        block = slice(first, first + BLOCK)
        blocks.append(PathStatics.of(full, poses[block], None if retraction is None else retraction[block]))
    report("solving", rows, rows)
    solved: PathStatics = _joined(blocks)
    return solved


def _joined(blocks: Sequence[Any]) -> Any:
    """Concatenate the values of blocks: arrays, or dataclasses of arrays."""
    first = blocks[0]
    if isinstance(first, np.ndarray):
        return np.concatenate(blocks)
    return type(first)(*(_joined([getattr(block, each.name) for block in blocks]) for each in fields(first)))


def _cable_speed(lengths: Array, samples: Samples, law: TimeLaw) -> Array:
    """Speed of each cable (k, m), m/s: its change of length per length of path, times the speed along the path."""
    distance = np.diff(samples.distance)
    duration = np.diff(law.time) - samples.dwell[:-1]
    fastest = np.maximum(np.maximum(law.speed[1:], law.speed[:-1]), distance / duration)
    speed = np.zeros_like(lengths)
    speed[1:] = np.abs(np.diff(lengths, axis=0)) * (fastest / distance)[:, None]
    return speed


def _verdict(found: Check, failed: Indices) -> str:
    """The verdict in one sentence; *failed*: samples at which the compensated path is not met."""
    machine, part = found.robot.name, found.job.name
    if found.feasible:
        off = extreme(np.fmax, found.error_uncompensated)
        return (
            f"{machine} can print {part}: every sample is within all limits; without compensation it prints up to "
            f"{off * 1e3:.0f} mm off, with it the model meets the path to within {MET * 1e6:g} um."
        )
    if len(failed):
        return (
            f"{machine} cannot be shown to print {part}: the compensated path is not met at {len(failed)} samples, "
            f"first {_where(found, int(failed[0]))}."
        )
    worst = found.findings[0]
    if worst.is_status:
        return (
            f"{machine} cannot print {part}: at {worst.violations} of {len(found.samples)} samples {worst.limit}, "
            f"worst {_where(found, worst.sample)}."
        )
    line = f" of line {worst.line}" if worst.line else ""
    return (
        f"{machine} cannot print {part}: {worst.limit}{line} is out of bounds at {worst.violations} of "
        f"{len(found.samples)} samples, worst {worst.value:.4g} {worst.unit} where {worst.bounds()} is allowed, "
        f"{_where(found, worst.sample)}."
    )


def _where(found: Check, sample: int) -> str:
    return f"in layer {found.samples.layer[sample]}, {found.job.move_name} {found.samples.line[sample]}"
