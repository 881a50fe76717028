"""`check`: a sliced part on a robot: lengths, limits, distances of lines and expected error, and one verdict."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from cablewright.analyses.accuracy.expected_error import ExpectedError
from cablewright.analyses.feasibility import CLEARANCE, EXPECTED_ERROR, TENSION_LIMITS, Finding, ranked
from cablewright.analyses.interference import too_near
from cablewright.analyses.job_distances import Clearances
from cablewright.analyses.motion.lower_acceleration import slowed, slower_note, with_reserve
from cablewright.analyses.travel_moves import LedTravel, led
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.memory_mapped import Room, in_room
from cablewright.foundation.progress import Progress, silent
from cablewright.models.job_poses import along, on_plane, path_box, sampled
from cablewright.models.statics import Model
from cablewright.models.support_table import Capability, require
from cablewright.printing.beads import Bead
from cablewright.printing.job import Job, load_job
from cablewright.printing.toolpath import Toolpath
from cablewright.robot import Robot
from cablewright.robot.plausibility import LENGTHS
from cablewright.robot.uncertainty import ASSUMED, Uncertainty, assumed_uncertainty
from cablewright.running.memory import require_for_samples
from cablewright.solvers.hanging_path import hung, nozzle_on_path
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.path_speeds import fed
from cablewright.solvers.swing_free_motion import JobMotion
from cablewright.studies.checks.fastest import Fastest
from cablewright.studies.checks.figure_limits import error_finding
from cablewright.studies.checks.job_samples import JobPath, Walked, WalkSettings
from cablewright.studies.checks.not_checked import SKIPPABLE, not_checked
from cablewright.studies.checks.result import WRONG_UNIT, Check
from cablewright.studies.checks.sample_errors import SampleErrors
from cablewright.studies.checks.verdict import verdict

IN_ROOM: Final = 300.0
"""Memory, bytes, for each sample of a path whose arrays are in files."""

PLACES: Final = 7  # along each side of the frame, tried where no sample can be held
TOO_LARGE: Final = 5.0
"""A path that is so many times as large as the frame has a wrong scale."""


def bytes_each(robot: Robot, room: Path | None = None) -> float:
    """Return the bytes of memory that a check needs for each sample, whose arrays have a *room*.

    See benchmarks/path_memory.py.
    """
    return 420.0 + 270.0 * robot.m if room is None else IN_ROOM


def check(
    robot: Robot | Model,
    job: Job | str | Path,
    *,
    tension_limits: tuple[float, float] | None = None,
    uncertainty: Uncertainty | None = None,
    clearance: float = 0.0,
    skip: Collection[str] = (),
    seed: int = 0,
    bead: Bead | None = None,
    progress: Progress | None = None,
    room: Path | None = None,
) -> Check:
    """Check *job*, or its file, on *robot* under the full model: limits, distances of lines, expected error.

    *tension_limits* (N) replace those of every line. *uncertainty*: uncertainty of the robot's numbers; by default that
    of its file, or else `assumed_uncertainty`. *clearance*: distance under which a line is too near to an obstacle, m;
    0: only contact counts. *skip*: checks to leave out, of "interference" and "expected-error". *seed*: seed of the
    machines that are drawn for the expected error. *bead*: width and height of all strands, m; by default those of the
    job file, or else those of the G-code's comments, E and heights, see `Job.beads`. *room*: a folder on a disk with
    space for the results at the samples, which then stay out of memory; the arrays of the result are those of files
    without a name.

    The job's path is the nozzle's; a rigid platform is unrotated or has the rotation of the job's schedule. Limits are
    compared with the statics and, to first order, with the motion of the platform by the time law. Raises `InputError`
    for a model under another law, a schedule that it cannot follow, a path many times as large as the frame or a G-code
    file that cannot be used; `EnvironmentFault` for too little free memory; an infeasible job raises nothing.
    """
    if unknown := [name for name in skip if name not in SKIPPABLE]:
        raise UnknownName("skip", unknown[0], SKIPPABLE)
    if not (np.isfinite(clearance) and clearance >= 0.0):
        raise InputError(f"clearance = {clearance:g}: must be at least 0 m")
    full = Model.full(robot, tension_limits=tension_limits)
    robot = full.robot if full.tension_limits is None else full.robot.limited(full.tension_limits)
    require(robot, Capability.CHECK)
    job = on_plane(robot, job if isinstance(job, Job) else load_job(job))
    kept = Room(room)
    toolpath = in_room(job.toolpath(report := progress or silent), kept)
    _require_scale(robot, job, toolpath)
    beads = in_room(job.beads(toolpath, bead), kept)
    job = job.with_corners(beads)
    samples, step = sampled(robot, job, toolpath, kept, beads)
    require_for_samples(len(samples), bytes_each(robot, room), "a check")
    travels: tuple[LedTravel, ...] = ()
    samples = fed(robot, job, samples, kept)
    if job.motion.travel == "safe":
        samples, travels = led(full, job, samples, beads, clearance, room=kept, progress=report)
    source, uncertain = _uncertainty(robot, uncertainty)
    asked, job = job, slowed(robot, job, samples, beads, kept)
    motion = JobMotion.of(robot, job, samples, kept)
    samples = motion.samples
    require_for_samples(len(samples), bytes_each(robot, room), "a check")
    poses, drawn = along(robot, job, samples, kept)
    poses = nozzle_on_path(Model.full(robot), poses, samples.positions, drawn)
    path = JobPath(job, samples, motion.law, poses, drawn, beads, kept)
    walked, chosen = _walked(path, robot, (uncertain.of(robot), uncertain.zeroed_at, skip, seed, report))
    expected = None if walked.search is None else walked.search.result()
    extra = (*_clearance(walked.distances, clearance), *_errors(expected, walked.statics.displacement, path))
    findings = ranked((*path.judged(robot, walked), *path.bounded(chosen, walked), *extra))
    found = Check(
        robot=robot,
        job=job,
        samples=samples,
        law=path.law,
        poses=walked.poses,
        retraction=path.retraction,
        statics=walked.statics,
        errors=SampleErrors.of(robot, samples, walked.poses, walked.statics, kept),
        findings=findings,
        verdict="",
        toolpath=toolpath,
        beads=beads,
        expected=expected,
        uncertainty=source,
        distances=walked.distances,
        not_checked=tuple(not_checked(robot, path, uncertain, walked.statics, skip)),
        step=step,
        chosen=chosen,
        shaping=motion,
        travels=travels,
        slower=slower_note(asked, job),
        fastest=Fastest.of(robot, job, toolpath, beads, samples, walked.statics.lengths, kept),
    )
    return replace(found, verdict=verdict(found, _nowhere(full) if found.codes.all() else 0))


def _walked(path: JobPath, robot: Robot, settings: WalkSettings) -> tuple[Walked, Model]:
    """What was found along the path, and the model whose tensions were taken at rest.

    They are those that a print holds. Of a point in space a machine decides that, which may keep a line slack: the
    least tensions are taken. Where motion breaks tension limits with them, and with a reserve at rest does not, it is
    with a reserve.
    """
    full = Model.full(robot)
    margin = path.with_margin(full)
    chosen = full if robot.n == 3 and robot.platform.plane is None else margin
    walked = path.walk(chosen, *settings)
    findings = path.judged(robot, walked)
    if walked.statics.codes.any() or not _breaks_tensions(findings):
        return walked, chosen
    reserve = with_reserve(robot, walked.tension_drop, walked.tension_rise)
    for careful in (margin, None if reserve is None else replace(full, robot=reserve)):
        if careful in (None, chosen) or not path.holds(careful, [each.sample for each in findings]):
            continue
        reserved = path.walk(careful, *settings)
        if not _breaks_tensions(path.judged(robot, reserved)):
            return reserved, careful
    return walked, chosen


def _uncertainty(robot: Robot, given: Uncertainty | None) -> tuple[str, Uncertainty]:
    """The uncertainty to use, and where it is from."""
    if given is not None:
        return given.name or "given", given
    if robot.uncertainty is not None:
        name = "robot file" if robot.uncertainty.parameters else ASSUMED
        return robot.uncertainty.name or name, robot.uncertainty
    return ASSUMED, assumed_uncertainty(robot)


def _breaks_tensions(findings: tuple[Finding, ...]) -> bool:
    """Whether a pose cannot be held, or a tension is beyond its limits."""
    return any(each.violations for each in findings if each.is_status or each.limit in TENSION_LIMITS)


def _errors(expected: ExpectedError | None, displacement: Array, path: JobPath) -> Iterator[Finding]:
    """Yield the expected error, and its sum with the *displacement* (k,) by motion, as limits.

    Each counts at the sample where it is nearest to the tolerance of its bead. Samples have their root mean square
    error, scaled to the expected error. Those that lay nothing have no limit, unless nothing is laid.
    """
    laid = path.samples.extruding
    displacement = np.where(laid | ~laid.any(), displacement, np.nan)
    allowed = path.allowed_errors()
    if expected is None or expected.sample is None:
        yield from error_finding(displacement, np.zeros(len(allowed)), allowed)
        return
    value = expected.value if np.isfinite(expected.value) else np.inf
    largest = float(np.nanmax(expected.rms))
    shares = expected.rms / largest if largest > 0.0 else np.where(np.isnan(expected.rms), np.nan, 0.0)
    error = np.where(shares > 0.0, value * shares, shares)
    margin = allowed - error
    worst = int(np.nanargmin(margin))
    shown = value if worst == expected.sample else float(error[worst])
    bound = float(allowed[worst])
    yield Finding(EXPECTED_ERROR, "m", bound - shown, shown, (-np.inf, bound), None, worst, int((margin < 0.0).sum()))
    if shown <= bound:  # of the machines whose error anywhere is the expected error: it counts at each sample
        yield from error_finding(displacement, np.full(len(allowed), value), allowed)


def _clearance(distances: Clearances | None, clearance: float) -> Iterator[Finding]:
    """Yield the smallest distance of a line from anything as a limit."""
    nearest = None if distances is None else distances.nearest
    if distances is None or nearest is None:
        return
    near = int(too_near(distances.smallest, clearance).sum())
    bounds, margin = (clearance, np.inf), nearest.margin - clearance
    yield Finding(CLEARANCE, "m", margin, nearest.margin, bounds, nearest.line, nearest.row, near)


def _nowhere(full: Model) -> int:
    """Number of places in the frame that were tried if none of them can be held, else 0."""
    scene = full.robot.scene
    ends = zip(scene.frame_min, scene.frame_max, strict=True)
    axes = (np.linspace(low, high, PLACES + 2)[1:-1] for low, high in ends)
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    return 0 if solve_inverse(full, hung(full, full.unrotated_at(places))).holds.any() else len(places)


def _require_scale(robot: Robot, job: Job, toolpath: Toolpath) -> None:
    """Raise `InputError` for a path so large against the frame that its scale must be wrong."""
    low, high = path_box(job, toolpath)
    ratio = float(((high - low) / np.subtract(robot.scene.frame_max, robot.scene.frame_min)).max())
    if ratio < TOO_LARGE:
        return
    units = [unit for unit, size in LENGTHS.items() if 0.1 < ratio * size < 1.5] if ratio <= WRONG_UNIT else ["mm"]
    hint = f", or is a unit wrong, {' or '.join(units)} taken for m" if units else ""
    raise InputError(
        f"job {job.name}: the path is {ratio:.3g} times as large as the frame of {robot.name}: is scale = "
        f"{job.scale:g} meant to be {job.scale / ratio:.2g} or less{hint}?"
    )
