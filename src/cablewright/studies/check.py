"""The main job: a sliced part on a robot. Lengths, errors and limits of every sample, and one verdict."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cablewright.analyses.feasibility import Finding, LineQuantities, judge
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.rotation import angle_between
from cablewright.models.statics import Equilibrium, Model
from cablewright.printing.job import Job
from cablewright.printing.path import Samples
from cablewright.printing.timing import TimeLaw
from cablewright.progress import Progress, silent
from cablewright.robot import Robot
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.limits import lever_angles, sheave_clearances, swing_angles, winch_torques
from cablewright.studies.job_poses import along

__all__ = ["Check", "check"]

Array = NDArray[np.float64]

BLOCK = 128 * 64  # samples solved between two reports of progress; a multiple of the kernels' chunk
MET = 1e-6
"""Error (m, and rad) to which the compensated path must be met by the full model."""


@dataclass(frozen=True, eq=False)
class Check:
    """What `check` found. Arrays have one row per sample; k samples, m lines; SI."""

    robot: Robot
    job: Job
    samples: Samples  # positions (k, 3) of the nozzle, layer, line (of the G-code file), extruding, distance
    law: TimeLaw
    poses: Array  # (k, n) wanted of the platform's origin
    retraction: Array | None  # (k,) m, None where the job does not set it
    rigid_lengths: Array  # (k, m) what a machine without compensation would pay out
    uncompensated: Array  # (k, 3) where the nozzle then is
    turned_uncompensated: Array  # (k,) rad, how far the platform then is turned from what is wanted; 0 for a point
    lengths: Array  # (k, m) compensated lengths: what the winches should pay out
    compensated: Array  # (k, 3) where the nozzle then is
    turned_compensated: Array  # (k,) rad
    elastic_only: Array  # (k, 3) where it would be if only elasticity, not sag, were compensated
    tensions: Array  # (k, m) N, at the sheave
    lowest_tension: Array  # (k, m) N, along each line
    highest_tension: Array  # (k, m) N, along each line
    swing: Array  # (k, m) rad, azimuth of the sheave from where its mounting faces; NaN where it has no limit
    lever: Array  # (k, m) rad, lever angle; NaN where there is no lever
    cable_speed: Array  # (k, m) m/s
    torque: Array  # (k, m) N m at the drum; NaN where the drum is not known
    codes: NDArray[np.int64]  # (k,) status of the inverse problem
    findings: tuple[Finding, ...]
    feasible: bool
    verdict: str  # one sentence
    unknown: dict[str, int]  # words of the G-code for which nothing was done
    layer_count: int

    @property
    def time(self) -> Array:
        """(k,) s, when each sample is reached."""
        return self.law.time

    @property
    def speed(self) -> Array:
        """(k,) m/s, of the platform."""
        return self.law.speed

    @property
    def error_uncompensated(self) -> Array:
        """(k,) m."""
        return self._distance(self.uncompensated)

    @property
    def error_compensated(self) -> Array:
        """(k,) m."""
        return self._distance(self.compensated)

    @property
    def error_elastic_only(self) -> Array:
        """(k,) m."""
        return self._distance(self.elastic_only)

    def _distance(self, reached: Array) -> Array:
        return np.asarray(np.linalg.norm(reached - self.samples.positions, axis=1))

    def summary(self) -> dict[str, object]:
        """The figures of the command line's JSON."""
        return {
            "feasible": self.feasible,
            "verdict": self.verdict,
            "layers": self.layer_count,
            "samples": len(self.samples),
            "extruded_length": self.samples.extruded_length,
            "travel_length": self.samples.travel_length,
            "duration": self.law.duration,
            "min_tension": _extreme(np.nanmin, self.lowest_tension),
            "max_tension": _extreme(np.nanmax, self.highest_tension),
            "max_error_uncompensated": _extreme(np.nanmax, self.error_uncompensated),
            "max_error_elastic_only": _extreme(np.nanmax, self.error_elastic_only),
            "max_error_compensated": _extreme(np.nanmax, self.error_compensated),
            "max_turn_uncompensated": _extreme(np.nanmax, self.turned_uncompensated),
            "max_turn_compensated": _extreme(np.nanmax, self.turned_compensated),
            "max_winch_speed": _extreme(np.nanmax, self.cable_speed),
            "max_winch_torque": _extreme(np.nanmax, self.torque),
            "findings": [finding.__dict__ | {"place": self.place(finding.sample)} for finding in self.findings],
            "ignored_words": self.unknown,
        }

    def place(self, sample: int) -> dict[str, object]:
        """Where a sample is: position, layer and line of the G-code file."""
        return {
            "position": [float(x) for x in self.samples.positions[sample]],
            "layer": int(self.samples.layer[sample]),
            "gcode_line": int(self.samples.line[sample]),
        }


def _extreme(choose: Callable[[Array], float], values: Array) -> float:
    return float("nan") if np.isnan(values).all() else float(choose(values))


def check(
    robot: Robot,
    job: Job,
    *,
    tension_limits: tuple[float, float] | None = None,
    progress: Progress | None = None,
) -> Check:
    """Check *job* on *robot* under all physics: what lengths it takes, how far off it prints, what stands in its way.

    *tension_limits* (N) replace those of every line. The job's path is the nozzle's; a rigid platform is held unrotated
    or as the job's schedule has it. Raises `InputError` for a robot with fewer lines than freedoms, a schedule that it
    cannot follow or a G-code file that cannot be used; an infeasible job is an answer, not an error.
    """
    report = progress or silent
    toolpath = job.toolpath(report)
    samples = job.samples(toolpath)
    law = job.time_law(samples)
    if tension_limits is not None:
        Model(robot, Fidelity(), tension_limits)  # refuses limits that do not rise
        lines = tuple(line.model_copy(update={"tension_limits": tension_limits}) for line in robot.lines)
        robot = robot.model_copy(update={"lines": lines})
    solved = _solve(robot, *along(robot, job, samples), report)
    return _judged(robot, job, samples, law, solved, toolpath.unknown, toolpath.layer_count)


def _solve(robot: Robot, poses: Array, retraction: Array | None, report: Progress) -> dict[str, Any]:
    """All inverse and forward problems of the path, block by block."""
    models = {law: Model(robot, Fidelity(law)) for law in CableLaw}
    rows = len(poses)
    blocks = []
    for first in range(0, rows, BLOCK):
        report("solving", first, rows)
        block = slice(first, first + BLOCK)
        blocks.append(_solve_block(models, poses[block], None if retraction is None else retraction[block]))
    report("solving", rows, rows)
    return {name: np.concatenate([block[name] for block in blocks]) for name in blocks[0]} | {
        "poses": poses,
        "retraction": retraction,
    }


def _solve_block(models: dict[CableLaw, Model], poses: Array, retraction: Array | None) -> dict[str, NDArray[Any]]:
    """One block: rows that the straight-line geometry refuses stay NaN."""
    full = models[CableLaw.CATENARY]
    inverse, rigid, elastic = (
        solve_inverse(models[law], poses, path=True, retraction=retraction)
        for law in (CableLaw.CATENARY, CableLaw.RIGID, CableLaw.ELASTIC)
    )
    lowest, highest = inverse.extremes()
    uncompensated = _reached(full, rigid, poses, retraction)
    start = np.where(np.isnan(uncompensated), poses, uncompensated)
    compensated = _reached(full, inverse, start, retraction)
    return {
        "rigid_lengths": rigid.lengths,
        "uncompensated": full.nozzle(uncompensated),
        "turned_uncompensated": _turned(uncompensated, poses),
        "lengths": inverse.lengths,
        "compensated": full.nozzle(compensated),
        "turned_compensated": _turned(compensated, poses),
        "elastic_only": full.nozzle(_reached(full, elastic, poses, retraction)),
        "tensions": inverse.tensions,
        "lowest_tension": lowest,
        "highest_tension": highest,
        "swing": swing_angles(inverse),
        "lever": lever_angles(inverse),
        "torque": winch_torques(inverse),
        "clearance": sheave_clearances(inverse),
        "codes": inverse.code,
        "violations": inverse.violation,
    }


def _turned(poses: Array, wanted: Array) -> Array:
    """Angle (k,) between the rotations of two lots of poses; 0 for a point."""
    if poses.shape[1] == 3:
        return np.where(np.isnan(poses[:, 0]), np.nan, 0.0)
    return angle_between(poses[:, 3:], wanted[:, 3:])


def _reached(full: Model, paid_out: Equilibrium, near: Array, retraction: Array | None) -> Array:
    """The pose to which the full model says that the lengths paid out take the platform, (k, n); NaN where none."""
    usable = np.isfinite(paid_out.lengths).all(axis=1) & (paid_out.lengths > 0.0).all(axis=1)
    reached = np.full(near.shape, np.nan)
    if usable.any():
        retracted = None if retraction is None else retraction[usable]
        solved = solve_forward(full, paid_out.lengths[usable], guess=near[usable], path=True, retraction=retracted)
        reached[usable] = np.where(solved.ok[:, None], solved.pose, np.nan)
    return reached


def _judged(
    robot: Robot,
    job: Job,
    samples: Samples,
    law: TimeLaw,
    solved: dict[str, Any],
    unknown: dict[str, int],
    layer_count: int,
) -> Check:
    """Limits and verdict of the solved path."""
    speed = _cable_speed(solved["lengths"], samples, law)
    quantities = LineQuantities(
        solved["lowest_tension"],
        solved["highest_tension"],
        solved["lengths"],
        solved["swing"],
        solved["lever"],
        speed,
        solved["torque"],
        solved.pop("clearance"),
    )
    codes, violations = solved.pop("codes"), solved.pop("violations")
    findings = judge(robot, solved["poses"][:, :3], codes, violations, quantities)
    missed = np.linalg.norm(solved["compensated"] - samples.positions, axis=1) + solved["turned_compensated"]
    failed = np.flatnonzero(~(missed <= MET) & (codes == 0))
    feasible = not len(failed) and not codes.any() and all(finding.violations == 0 for finding in findings)
    found = Check(
        robot=robot,
        job=job,
        samples=samples,
        law=law,
        cable_speed=speed,
        codes=codes,
        findings=findings,
        feasible=feasible,
        verdict="",
        unknown=unknown,
        layer_count=layer_count,
        **solved,
    )
    return replace(found, verdict=_verdict(found, failed))


def _cable_speed(lengths: Array, samples: Samples, law: TimeLaw) -> Array:
    """Speed of each cable, m/s: its length per path length, times the speed there."""
    travelled = np.diff(samples.distance)
    spent = np.diff(law.time) - samples.dwell[:-1]
    fastest = np.maximum(np.maximum(law.speed[1:], law.speed[:-1]), travelled / spent)
    speed = np.zeros_like(lengths)
    speed[1:] = np.abs(np.diff(lengths, axis=0)) * (fastest / travelled)[:, None]
    return speed


def _verdict(found: Check, failed: NDArray[np.intp]) -> str:
    """One sentence; *failed* are the samples that compensation does not meet."""
    machine, part = found.robot.name, found.job.name
    if found.feasible:
        off = _extreme(np.nanmax, found.error_uncompensated)
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
    who = f" of line {worst.line}" if worst.line else ""
    return (
        f"{machine} cannot print {part}: {worst.limit}{who} is out of bounds at {worst.violations} of "
        f"{len(found.samples)} samples, worst {worst.value:.4g} {worst.unit} where {worst.bounds()} is allowed, "
        f"{_where(found, worst.sample)}."
    )


def _where(found: Check, sample: int) -> str:
    return f"in layer {found.samples.layer[sample]}, {found.job.move_name} {found.samples.line[sample]}"
