"""The samples of a job, processed block by block: statics, motion, distances of lines, expected error."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from cablewright.analyses.accuracy.expected_error import ExpectedErrorSearch
from cablewright.analyses.feasibility import Finding, judge
from cablewright.analyses.job_distances import Clearances, JobDistances
from cablewright.analyses.motion.path_swing import PathSwing, SwingExtremes
from cablewright.analyses.steady_acceleration import fed_forward
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import AnswerError
from cablewright.foundation.memory_mapped import Room, blocks, let_go, room_for, write_rows
from cablewright.foundation.progress import Progress
from cablewright.foundation.units import Vec3
from cablewright.models.free_coordinates import free_coordinates
from cablewright.models.inertia import compensates
from cablewright.models.statics import Model
from cablewright.printing.beads import Beads
from cablewright.printing.job import Job
from cablewright.printing.path import Samples
from cablewright.printing.timing import TimeLaw, times_on_way
from cablewright.robot import Robot
from cablewright.robot.uncertainty import Range
from cablewright.solvers.hardware_limits import drum_arms
from cablewright.solvers.held_tensions import chosen_rows, with_margin
from cablewright.solvers.inverse import BLOCK, solve_inverse
from cablewright.solvers.linearise import linearise_solved
from cablewright.studies.checks.figure_limits import line_findings, paces
from cablewright.studies.checks.interpolation_error import BetweenSamples
from cablewright.studies.checks.path_statics import PathStatics

WalkSettings = tuple[Sequence[Range], Vec3 | None, Collection[str], int, Progress]
"""Ranges of the uncertain numbers, where coordinates count from, what to leave out, the seed of the machines drawn, and
the progress."""


@dataclass(frozen=True, eq=False)
class Walked:
    """Statics, distances and errors at the samples of a path; None for results that were not requested."""

    poses: Array  # (k, n), complete: as asked, and as equilibrium decides where it does
    statics: PathStatics
    tension_drop: Array  # (m,) N, at least 0: the most that motion takes from the tension of each line
    tension_rise: Array  # (m,) N, at least 0
    distances: Clearances | None
    search: ExpectedErrorSearch | None


@dataclass(frozen=True, eq=False)
class JobPath:
    """The k samples of a job, the poses (k, n) that bring the nozzle there, and retraction lengths (k,), m, or None."""

    job: Job
    samples: Samples
    law: TimeLaw
    poses: Array
    retraction: Array | None
    beads: Beads
    room: Room = field(default_factory=Room)  # for the results

    def walk(
        self,
        full: Model,
        ranges: Sequence[Range],
        zeroed_at: Vec3 | None,
        skip: Collection[str],
        seed: int,
        report: Progress,
    ) -> Walked:
        """Solve the inverse and forward problems along the path, and all checks that are not in *skip*.

        Raises `AnswerError` where the nozzle cannot be held at *zeroed_at*.
        """
        near = "interference" not in skip
        distances = JobDistances.of(full.robot, self.beads, self.samples, room=self.room) if near else None
        search = None
        if "expected-error" not in skip:
            zero = None if zeroed_at is None else solve_inverse(full, full.unrotated_at(np.array([zeroed_at])))
            if zero is not None and not zero.ok.all():
                raise AnswerError(f"uncertainty.zeroed_at = {list(zeroed_at or ())} m: {zero[0].sentence()}")
            search = ExpectedErrorSearch(ranges, self.samples, seed, zero)
        rows, swing = len(self.poses), PathSwing(full)
        solved: PathStatics | None = None
        drop, rise = np.zeros(full.m), np.zeros(full.m)
        poses = self.room.empty(self.poses.shape) if free_coordinates(full.robot) else self.poses
        for first in range(0, rows, BLOCK):
            report("solving", first, rows)
            block = slice(first, first + BLOCK)
            retraction = None if self.retraction is None else self.retraction[block]
            held = solve_inverse(full, self.poses[block], path=True, retraction=retraction)
            regular, linear = linearise_solved(held)
            fed = None if self.law.vector is None or not compensates(full.robot) else self.law.vector[block]
            if poses is not self.poses:
                poses[block] = held.pose
            moved = swing.take(held, regular, linear, *times_on_way(self.samples, self.law, block), fed)
            found = PathStatics.of(held, self.poses[block], retraction)
            if fed is not None:
                led = fed_forward(held, retraction, fed)
                if led.moving is not None:
                    found, moved = found.fed_forward(led.moving, led.rows), moved.beside(led.added)
            found = found.moving(full.robot, moved, drum_arms(held))
            solved = room_for(found, rows, self.room) if solved is None else solved
            write_rows(found, solved, first)
            let_go((solved, self.samples, self.law, self.poses))
            drop, rise = _largest(drop, rise, moved)
            if distances is not None:
                distances.take(held, first)
            if search is not None:
                search.take(first + np.flatnonzero(regular), held[regular], linear)
        report("solving", rows, rows)
        assert solved is not None
        _add_speeds(solved.lines.winch_speed, solved.lengths, self.samples, self.law)
        lines = replace(solved.lines, cable_length=solved.lengths)
        clearances = None if distances is None else distances.clearances
        return Walked(poses, replace(solved, lines=lines), drop, rise, clearances, search)

    def with_margin(self, full: Model) -> Model:
        """Return the model with the tensions that a print holds: see `held_tensions`."""
        rows = chosen_rows(len(self.poses))
        return with_margin(full, self.poses[rows], None if self.retraction is None else self.retraction[rows])[0]

    def holds(self, model: Model, rows: Sequence[int]) -> bool:
        """Whether a model holds the platform at some samples."""
        retraction = None if self.retraction is None else self.retraction[rows]
        return bool(solve_inverse(model, self.poses[rows], retraction=retraction).ok.all())

    def allowed_errors(self) -> Array:
        """Return the expected error that is allowed at each sample (k,), m; inf for travel, if anything is laid."""
        if self.job.max_error is not None:
            return np.full(len(self.samples), self.job.max_error)
        wide = self.beads.width[self.samples.move]
        laid = self.samples.extruding
        return 0.5 * (np.where(laid, wide, np.inf) if laid.any() else wide)

    def judged(self, robot: Robot, found: Walked) -> tuple[Finding, ...]:
        """Compare the results with the limits of the robot's file."""
        of = found.statics
        return judge(robot, found.poses[:, :3], of.codes, of.violations, of.lines, of.plane_force)

    def bounded(self, model: Model, found: Walked) -> Iterator[Finding]:
        """Compare the results with the bounds of straight lines, the nozzle's speed and the sampling.

        *model*: model that gave the tensions at rest.
        """
        yield from line_findings(model.robot, self.samples, self.law, found.statics)
        between = BetweenSamples(model, self.poses, found.statics, self.retraction)
        yield from between.findings(float(self.allowed_errors().min()))


def _largest(drop: Array, rise: Array, moved: SwingExtremes) -> tuple[Array, Array]:
    """The largest changes of tension so far (m,), N."""
    most_drop = np.max(-moved.tension_drop, axis=0, initial=0.0)
    return np.maximum(drop, most_drop), np.maximum(rise, np.max(moved.tension_rise, axis=0, initial=0.0))


def _add_speeds(speeds: Array, lengths: Array, samples: Samples, law: TimeLaw) -> None:
    """Write the speed of each cable (k, m), m/s: its change of length per length of path, times that along the path."""
    speeds[0] = 0.0
    for block in blocks(len(samples) - 1):
        ends = slice(block.start, block.stop + 1)
        speeds[1:][block] = np.abs(np.diff(lengths[ends], axis=0)) * paces(samples, law, block)[:, None]
        let_go((speeds, lengths, samples, law))
