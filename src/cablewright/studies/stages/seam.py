"""The seam of two stages: distance between their prints at the last layer of the lower one.

The nozzle of each stage is displaced by the errors of its own numbers: exit points and home lengths, which each move of
the exit points changes, and those that a calibration of the stage estimates. Other uncertain numbers are the same in
both stages. Machines are drawn, and each is solved in both stages with the lengths of an exact one. Of each machine the
largest distance of its two prints along the layer counts, and of all machines the 95th percentile. A machine without an
equilibrium is beyond any distance.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np

from cablewright.analyses.accuracy.spread import SpreadProblem, drawn, sampled
from cablewright.calibration.drift.record import CalibrationRecord
from cablewright.calibration.poses.observability import world_motions
from cablewright.calibration.unknowns import line_index
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.foundation.results import Figure
from cablewright.models.job_poses import poses_at
from cablewright.models.job_poses import sampled as sampled_path
from cablewright.models.job_stages import JobStage
from cablewright.models.plane import directions, turning_axes
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot
from cablewright.robot.parameters import KINDS, Parameter, nominal
from cablewright.robot.uncertainty import Range, Uncertainty
from cablewright.solvers.inverse import solve_inverse

DRAWS: Final = 2000
PLACES: Final = 9
"""Places along the layer at which machines are solved."""

LEVEL: Final = 0.95
NEW: Final = ("exit_point", "length_offset")
"""Numbers that are others in each stage: exit points are moved, and lines are homed again."""

_MEASURED: Final = 1e-7  # m: with a smaller standard deviation exit points are held, not measured
_NEAR: Final = 0.2  # m: farther from the exit points of a stage a record is that of another
_ROLES: Final = ("hardware", "command", "load")


@dataclass(frozen=True)
class Seam:
    """The distance of the prints of two stages at the layer where the lower one ends."""

    FIGURES: ClassVar = (
        Figure("stage", "", "Number of the stage that begins there."),
        Figure("height", "m", "Height of the nozzle at the last layer of the stage below."),
        Figure("seam", "m", "Distance of both prints that 95 of 100 machines stay below along that layer.", "value",
               digits=3, shown="mm"),
        Figure("allowed", "m", "Distance that is allowed: max_seam of the job, or its allowed expected error.",
               digits=3, shown="mm"),
        Figure("by", "", "Where the errors of both stages are from: uncertainties, or records of calibrations."),
    )  # fmt: skip

    stage: int
    height: float
    value: float
    allowed: float
    by: str

    @property
    def holds(self) -> bool:
        """Whether the distance is within that allowed by the job."""
        return self.value <= self.allowed


def seam_of(
    below: JobStage,
    above: JobStage,
    uncertain: Uncertainty,
    records: Sequence[CalibrationRecord | None] = (None, None),
    *,
    allowed: float,
    seed: int = 0,
) -> Seam:
    """Return the seam between the stage *below* and that *above*.

    *uncertain*: the uncertainty of the robot. *records*: of the calibrations of both stages; None: its exit points and
    home lengths are as uncertain as the robot's. Raises `AnswerError` where one of both robots cannot hold the nozzle
    at that layer, `InputError` for a record of another robot, or one that does not measure where the robot stands.
    """
    samples, _ = sampled_path(below.robot, below.job, below.job.toolpath())
    laid = np.flatnonzero(samples.extruding)
    laid = laid[samples.layer[laid] == samples.layer[laid[-1]]]
    places = samples.positions[laid[np.linspace(0, len(laid) - 1, min(PLACES, len(laid))).round().astype(int)]]
    known = [_Numbers.of(*each, uncertain) for each in zip((below, above), records, strict=True)]
    names = {each.parameter: each for one in known for each in one.common}
    common = dict(zip(names, drawn(tuple(names.values()), DRAWS, seed).T, strict=True))
    moved = [one.displaced(places, common, uncertain, np.random.default_rng([seed, k])) for k, one in enumerate(known)]
    apart = np.linalg.norm(moved[0] - moved[1], axis=2).max(axis=0)
    largest = np.sort(np.where(np.isfinite(apart), apart, np.inf))
    words = ["uncertainties" if record is None else f"a {record.verdict} calibration" for record in records]
    by = words[0] if words[0] == words[1] else " and ".join(words)
    return Seam(above.number, float(places[:, 2].max()), float(largest[int(np.ceil(LEVEL * DRAWS)) - 1]), allowed, by)


@dataclass(frozen=True, eq=False)
class _Numbers:
    """Uncertain numbers of a stage: its own, with their covariance (p, p) where it is known, and those in common."""

    stage: JobStage
    own: tuple[Range, ...]
    covariance: Array | None
    common: tuple[Range, ...]

    @classmethod
    def of(cls, stage: JobStage, record: CalibrationRecord | None, uncertain: Uncertainty) -> _Numbers:
        """Return a *stage*'s uncertain numbers, from the *record* of its calibration, if any, or the robot's."""
        ranges = uncertain.of(stage.robot)
        if record is None:
            own = tuple(each for each in ranges if each.parameter.entry.base in NEW)
            return cls(stage, own, None, tuple(each for each in ranges if each not in own))
        own, covariance = _recorded(stage.robot, record, f"stage {stage.number}")
        estimated = {*NEW, *(each.parameter.entry.base for each in own)}
        common = tuple(each for each in ranges if each.parameter.entry.base not in estimated)
        return cls(stage, own, covariance, common)

    def drawn(self, rng: np.random.Generator) -> Array:
        """Return random values (S, p) of the stage's own uncertain numbers."""
        if self.covariance is None:
            return drawn(self.own, DRAWS, int(rng.integers(2**31)))
        values, vectors = np.linalg.eigh(self.covariance)
        away = (rng.standard_normal((DRAWS, len(values))) * np.sqrt(values.clip(min=0.0))) @ vectors.T
        return np.asarray(np.array([each.nominal for each in self.own]) + away)

    def displaced(
        self, places: Array, common: Mapping[Parameter, Array], uncertain: Uncertainty, rng: np.random.Generator
    ) -> Array:
        """Return the nozzle's displacement of each drawn machine from *places* (N, 3), m: (N, S, 3), NaN where unknown.

        *common*: values (S,) of each number that both stages have.
        """
        model = Model.full(self.stage.robot)
        poses, drawn_to = poses_at(self.stage.robot, self.stage.job, places)
        held = solve_inverse(model, poses, retraction=drawn_to)
        if not (good := held.holds).all():
            bad = int(np.argmin(good))
            raise AnswerError(
                f"stage {self.stage.number} cannot hold the nozzle at the seam, at {places[bad, 2]:.3f} m: "
                f"{held[bad].sentence()}; begin it at another height"
            )
        ranges = (*self.own, *self.common)
        values = np.column_stack([self.drawn(rng), *(common[each.parameter] for each in self.common)])
        found = _moved(held, ranges, values)
        if uncertain.zeroed_at is None:
            return found
        zero = solve_inverse(model, model.unrotated_at(np.array([uncertain.zeroed_at]))).checked()
        return found - _moved(zero, ranges, values)


def _moved(held: Equilibrium, ranges: tuple[Range, ...], values: Array) -> Array:
    """Return displacements (N, S, 3), m, of the nozzle of machines with *values* (S, p) from the solved rows *held*."""
    points, _, ok = sampled(SpreadProblem(held, held.lengths, held.pose, ranges), values)
    return np.where(ok[..., None], points - held.nozzle[:, None], np.nan)


def _recorded(robot: Robot, record: CalibrationRecord, where: str) -> tuple[tuple[Range, ...], Array]:
    """Return the numbers of a record that move the nozzle, and their covariance (p, p), SI.

    Raises `InputError` for a record of another robot or stage, and one that says nothing of where the robot stands.
    """
    if record.robot != robot.name:
        raise InputError(f"{where}: the calibration is of {record.robot!r}, and the robot is {robot.name!r}")
    every = (*record.values, *record.considered)
    kept = [at for at, each in enumerate(every) if each.name in KINDS and KINDS[each.name].role in _ROLES]
    parameters, coordinates = [], {}
    for at in kept:
        each = Parameter(every[at].name, every[at].line)
        if each.line is not None:
            line = line_index(robot, each.line, f"{where}: values")
            if each.entry.base == "exit_point":
                coordinates[at] = 3 * line + (each.entry.axis or 0)
        parameters.append(each)
    covariance = record.spread[np.ix_(kept, kept)]
    exits, (which, to) = np.zeros((3 * robot.m, 3 * robot.m)), (list(coordinates), list(coordinates.values()))
    exits[np.ix_(to, to)] = record.spread[np.ix_(which, which)]
    _require_measured(robot, exits, to, where)
    away = np.zeros((robot.m, 3))
    away.flat[to] = [every[at].value - nominal(robot, Parameter(every[at].name, every[at].line)) for at in which]
    far = np.linalg.norm(away, axis=1)
    if far.max() > _NEAR:
        name = robot.lines[int(far.argmax())].name
        raise InputError(
            f"{where}: the calibration has the exit point of {name!r} {far.max():.3g} m from that of the stage, where "
            f"{_NEAR:g} m is allowed: give the record of this stage; records are in the order of the stages"
        )
    sigmas = np.sqrt(np.diag(covariance)).tolist()
    values = [nominal(robot, each) for each in parameters]
    ranges = (Range(each, v, v - s, v + s, s) for each, v, s in zip(parameters, values, sigmas, strict=True))
    return tuple(ranges), covariance


def _require_measured(robot: Robot, covariance: Array, known: Sequence[int], where: str) -> None:
    """Raise `InputError` where the record of a calibration holds the frame by definition.

    *covariance*: (3 m, 3 m) of the coordinates of the exit points, m^2; *known*: those that the record has. Of a robot
    in a plane, what is across does not count.
    """
    ways, plane = directions(robot.platform.plane, 3), robot.platform.plane
    held = [k for k in known if ways[k % 3].any() and covariance[k, k] < _MEASURED**2]
    points = np.array([line.exit_point for line in robot.lines])
    turns = turning_axes(plane)
    arms = points - points.mean(axis=0)
    motions = [np.tile(way, robot.m) for way in ways.T] + [np.cross(axis, arms).ravel() for axis in turns]
    left, sizes, _ = np.linalg.svd(np.array(motions).T, full_matrices=False)
    left = left[:, sizes > 1e-9 * sizes[0]]  # a turn about a row of exit points moves none
    values, vectors = np.linalg.eigh(left.T @ covariance @ left)
    if held:
        what = f"the exit point of {robot.lines[held[0] // 3].name!r} along {'xyz'[held[0] % 3]}"
    elif values[0] < _MEASURED**2:
        along = np.abs(np.array(motions) @ left @ vectors[:, 0]) / np.linalg.norm(motions, axis=1).clip(min=1e-12)
        what = f"the {world_motions(robot)[int(np.argmax(along))]} of the exit points"
    else:
        return
    raise InputError(
        f"{where}: the calibration holds {what} (datum): it does not measure where the robot stands, and the seam "
        "is unknown; calibrate with measured positions or points, or priors, and no datum"
    )
