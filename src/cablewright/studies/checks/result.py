"""The result of `check`: samples, statics, limits, distances of lines, expected error, and the verdict."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from operator import attrgetter
from pathlib import Path
from typing import Any, ClassVar, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.analyses.accuracy.compensation import COMPENSATIONS
from cablewright.analyses.accuracy.expected_error import ErrorCause, ExpectedError
from cablewright.analyses.feasibility import EXPECTED_ERROR, INTERPOLATION, Finding
from cablewright.analyses.interference import Contact
from cablewright.analyses.job_distances import Clearances
from cablewright.analyses.travel_moves import LedTravel
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.memory_mapped import blocks, let_go
from cablewright.foundation.results import Figure, Result
from cablewright.foundation.units import spell_length
from cablewright.models.free_coordinates import free_coordinates
from cablewright.models.rotation import matrices
from cablewright.models.statics import Model
from cablewright.printing.beads import Beads
from cablewright.printing.job import Job
from cablewright.printing.path import Samples
from cablewright.printing.timing import TimeLaw
from cablewright.printing.toolpath import BY_HEIGHT, Toolpath
from cablewright.robot import Robot
from cablewright.robot.plausibility import overstretched, units_inside
from cablewright.robot.uncertainty import ASSUMED
from cablewright.solvers.preferred_tensions import preferred_note, preferred_tensions
from cablewright.solvers.swing_free_motion import JobMotion
from cablewright.studies.checks.fastest import Fastest
from cablewright.studies.checks.motion_error import MotionError
from cablewright.studies.checks.path_statics import PathStatics, extreme, extremes, median
from cablewright.studies.checks.sample_errors import SampleErrors

SMALLEST: Final = partial(extremes, np.fmin)
LARGEST: Final = partial(extremes, np.fmax)

MET: Final = 1e-6
"""Largest error (m, and rad) of the full model on the compensated path that counts as none."""

WRONG_UNIT: Final = 200.0
"""A size that is so many times as large as another may have a wrong unit: mm taken for m."""


@dataclass(frozen=True)
class Place:
    """A sample of a job: position, layer and line of the G-code."""

    position: tuple[float, float, float]  # m
    layer: int
    gcode_line: int


class PlacedFinding(NamedTuple):
    """A checked limit with the position of its worst sample."""

    finding: Finding
    place: Place


PLACE = (
    Figure("position", "m", "Position of the nozzle."),
    Figure("layer", "", "Layer, counted from 1; 0 before the first."),
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
    key: str, unit: str, meaning: str, name: str, array: str, choose: Callable[[Array], Array] = LARGEST
) -> Figure:
    """One value of each line, of an array (k, m) of the check."""
    return Figure(key, unit, meaning, lambda found: choose(attrgetter(array)(found)), name, along="line")


def _errors() -> tuple[Figure, ...]:
    """The largest errors, by compensation."""
    named = (("none", "uncompensated"), ("elastic", "elastic_only"), ("full", "compensated"))
    return tuple(
        _extreme_of(f"max_error_{key}", "m", f"Largest error of the nozzle {words}, if all numbers are exact.", np.fmax,
                    f"error_{key}", name=f"max error {words}", digits=3, shown="mm", detail=name == "full")
        for name, words, key in ((name, COMPENSATIONS[name].words, key) for name, key in named)
    )  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class Check(Result):
    """Result of a check of a job with k samples on a robot with m lines; SI."""

    FIGURES: ClassVar = (
        Figure("feasible", "", "Whether all that was checked is within its limits."),
        Figure("verdict", "", "The answer in words."),
        Figure("not_checked", "", "Effects that the answer does not cover: skipped checks, missing data of the "
        "files, effects outside the model."),
        Figure("expected_error", "m", "Error that 95 of 100 machines within the uncertainties stay below along all of "
               "the path, with full compensation; null where it was not checked.", "expected.value", digits=3,
               shown="mm"),
        Figure("expected_error_by", "", "Share of each cause.", "expected.causes", "expected error by cause",
               parts=ErrorCause.FIGURES),
        Figure("max_expected_error", "m", "Expected error that the job allows.", "allowed_error",
               "allowed expected error", digits=3, shown="mm"),
        Figure("bead_width", "m", "Median width of the strands.", "beads.typical.width", digits=3,
               shown="mm"),
        Figure("bead_height", "m", "Its height.", "beads.typical.height", digits=3, shown="mm"),
        Figure("bead_by", "", "Where widths and heights of beads are from.", "beads.source", "bead"),
        Figure("uncertainty", "", "Where the uncertainties are from: a file, the robot file, or assumed.",
               name="uncertainties"),
        Figure("motion_error", "m", "Largest error of the nozzle by the motion of the platform where material is laid, "
               "beside the expected error; null where it is not known.", "motion.largest", "error by motion", 3,
               shown="mm"),
        Figure("motion_error_95", "m", "Error by motion that is not exceeded along 95 % of the laid length.",
               "motion.usual", "95th percentile of it", 3, shown="mm"),
        Figure("motion_error_frequency", "Hz", "Frequency of the mode with most of the largest error by motion.",
               "motion.frequency", "frequency of it", 3),
        Figure("motion_error_place", "", "Place of the largest error by motion.", "motion_place", parts=PLACE,
               detail=True),
        Figure("damping", "1", "Share of critical damping of every mode.", "robot.damping.ratio", digits=3, shown="%"),
        Figure("damping_assumed", "", "Whether the robot file gives no damping.", "robot.damping.is_assumed",
               detail=True),
        Figure("acceleration_displacement", "m", "The same as `motion_error`: its name before the platform swung.",
               "motion.largest", digits=3, shown="mm", detail=True),
        Figure("clearance", "m", "Smallest distance of a line from another, the platform, the frame and the part as "
               "printed by then; null where it was not checked or there is nothing.", "nearest.margin",
               "clearance of lines", shown="mm"),
        Figure("clearance_between", "", "Names of that line and of the nearest obstacle.", "nearest.pair"),
        Figure("clearance_place", "", "Place of the sample at that distance.", "nearest_place", parts=PLACE,
               detail=True),
        Figure("layers", "1", "Number of layers of the part.", "toolpath.layer_count"),
        Figure("layers_by", "", "Layer marker of the file; height where it has none.", "toolpath.layers_by",
               "layers by"),
        Figure("material_by", "", "What lays material: an axis, a switch, or every G1.", "toolpath.material_by",
               "material by"),
        Figure("slicer", "", "Program and version that the G-code names; empty if none.", "toolpath.slicer",
               detail=True),
        Figure("objects", "", "Names of the objects that the G-code labels.", "toolpath.objects", detail=True),
        Figure("samples", "1", "Number of samples of the path.", lambda found: len(found.samples)),
        Figure("interpolation_error", "m", "Largest error of a length that is interpolated linearly between two "
               "samples, measured half-way between those where it is largest; null where nothing is held.", digits=2,
               shown="mm", name="interpolation of lengths"),
        Figure("extruded_length", "m", "Length of path on which material is laid.", "samples.extruded_length"),
        Figure("travel_length", "m", "Length of path on which none is laid.", "samples.travel_length"),
        Figure("duration", "s", "Duration of the job.", "law.duration"),
        Figure("duration_unshaped", "s", "Duration without shaping: see motion.shaping of jobs.", "shaping.unshaped",
               "duration without shaping", only=lambda found: found.shaping.shaper is not None),
        Figure("shaped_from", "Hz", "Frequency of the slowest mode that the motion is shaped for.", "shaping.slowest",
               "shaped for modes from", 3, only=lambda found: found.shaping.shaper is not None),
        Figure("not_shaped", "", "Why the motion is not shaped; empty where it is.", "shaping.why", detail=True),
        Figure("changed_travels", "", "Travel moves with a lift or a detour around obstacles, and those without a "
        "safe path.", "travels", "travel moves changed",
               only=lambda found: found.job.motion.travel == "safe", parts=LedTravel.FIGURES, detail=True),
        Figure("corner_deviation", "m", "Largest distance of a rounded corner from the path: of the job, or by the "
               "width of its strands.", "job.motion.corner", "corners rounded by", 3, shown="mm"),
        Figure("acceleration", "m/s^2", "Acceleration of the job, lowered where its fastest motion would break limits.",
               "job.motion.acceleration", detail=True),
        Figure("fastest_duration", "s", "Duration without the feeds of the file, within limits of winch speed, flow, "
               "acceleration and corners, and the speeds that the job gives; null where nothing limits a speed.",
               "fastest.duration", only=lambda found: found.fastest is not None, name="fastest within limits"),
        Figure("shortest_duration", "s", "The same without limits of acceleration and corners: nothing is faster.",
               "fastest.bound", only=lambda found: found.fastest is not None, name="lower bound of the limits"),
        _extreme_of("min_tension", "N", "Smallest tension, anywhere along a line, with the motion of the platform.",
                    np.fmin, "statics.lines.lowest_tension", shown="N"),
        _extreme_of("max_tension", "N", "Largest tension, anywhere along a line, with the motion of the platform.",
                    np.fmax, "statics.lines.highest_tension", shown="N"),
        Figure("expected_tensions", "N", "Tensions at rest between which 95 of 100 machines within the uncertainties "
               "are at a sample, by lengths alone: the smallest and the largest; null where not checked.",
               lambda found: [found.expected.tensions[:, 0].min(), found.expected.tensions[:, 1].max()],
               "expected tensions by lengths alone", only=lambda found: found.expected is not None, shown="N"),
        _extreme_of("max_plane_force", "N", "Largest force on the plane along its normal, with the motion of "
                    "the platform; positive lifts off a plane that only pushes.", np.fmax, "statics.plane_force",
                    only=lambda found: found.robot.platform.plane is not None, shown="N"),
        *_errors(),
        Figure("median_error_uncompensated", "m", "Median error of the nozzle without compensation.",
               lambda found: float(median(found.error_uncompensated)), "median error without compensation", 3,
               shown="mm"),
        Figure("max_tilt", "rad", "Largest angle of the platform's z axis from the vertical, which equilibrium decides "
               "with fewer winches than degrees of freedom.", name="max tilt at rest", digits=3,
               only=lambda found: found.robot.n == 6 and bool(free_coordinates(found.robot))),
        _extreme_of("max_turn_uncompensated", "rad", "Largest angle of the platform from its expected rotation without "
                    "compensation; 0 for a point platform.", np.fmax, "turn_uncompensated",
                    name="max turn without compensation", digits=3),
        _extreme_of("max_turn_compensated", "rad", "Largest angle of the platform from its expected rotation with full "
                    "compensation; 0 for a point platform.", np.fmax, "turn_compensated",
                    name="max turn with full compensation", digits=3, detail=True),
        _extreme_of("max_winch_speed", "m/s", "Largest speed of a cable at its winch.", np.fmax,
                    "statics.lines.winch_speed", digits=3),
        _extreme_of("max_winch_torque", "N m", "Largest torque at a drum; null where no drum radius is given.", np.fmax,
                    "statics.lines.winch_torque"),
        Figure("lines", "", "Names of the lines.", lambda found: [line.name for line in found.robot.lines], "line",
               along="line"),
        _of_lines("line_min_tension", "N", "Smallest tension of each line.", "min tension",
                  "statics.lines.lowest_tension", SMALLEST),
        _of_lines("line_median_tension", "N", "Median tension of each line at its sheave.", "median tension",
                  "statics.tensions", median),
        _of_lines("line_max_tension", "N", "Largest tension of each line.", "max tension",
                  "statics.lines.highest_tension"),
        Figure("line_held_limits", "N", "Narrower limits of the tension of each line at rest.",
               lambda found: [line.tension_limits for line in found.chosen.robot.lines], "held limits",
               only=lambda found: found.reserved, shown="N", along="line"),
        Figure("line_preferred_tension", "N", "Tension of each line to which those at rest are nearest, where a print "
               "prefers one or the limits let redundant lines hang slack.", lambda found: found.preferred_tensions[0],
               "preferred tension", only=lambda found: found.preferred_tensions is not None, shown="N", along="line"),
        Figure("line_tension_limits", "N", "Min and max tension that is allowed, of each line.",
               lambda found: [line.tension_limits for line in found.robot.lines], "limits", shown="N", along="line"),
        Figure("line_expected_tensions", "N", "The same of each line.",
               lambda found: np.broadcast_to(found.expected.tensions, (found.robot.m, 2)),
               "expected by lengths alone", only=lambda found: found.expected is not None, shown="N", along="line"),
        _of_lines("line_max_length", "m", "Largest unstrained length of each line.", "max length", "lengths"),
        _of_lines("line_max_winch_speed", "m/s", "Largest speed of each cable at its winch.", "max speed",
                  "statics.lines.winch_speed"),
        _of_lines("line_max_winch_torque", "N m", "Largest torque of each drum; null where not known.", "max torque",
                  "statics.lines.winch_torque"),
        _of_lines("line_min_swing", "rad", "Min azimuth of each sheave from where its mounting faces.", "min swing",
                  "statics.lines.swing", SMALLEST),
        _of_lines("line_max_swing", "rad", "Max azimuth of each sheave from where its mounting faces.", "max swing",
                  "statics.lines.swing"),
        _of_lines("line_min_lever", "rad", "Min angle of each lever above the horizontal.", "min lever",
                  "statics.lines.lever", SMALLEST),
        _of_lines("line_max_lever", "rad", "Max angle of each lever above the horizontal.", "max lever",
                  "statics.lines.lever"),
        Figure("findings", "", "Every limit, those that are broken first.", "placed_findings", "limits of the robot",
               parts=FINDING),
        Figure("ignored_words", "1", "Words of the G-code without effect, by how often they are there.",
               "toolpath.unknown"),
    )  # fmt: skip
    HEADLINES: ClassVar = ("feasible", "layers", "samples", "expected_error", "clearance")

    robot: Robot
    job: Job
    samples: Samples  # positions (k, 3) of the nozzle, layer, line (of the G-code file), extruding, distance
    law: TimeLaw
    shaping: JobMotion  # of which samples and law are
    poses: Array  # (k, n) of the platform's origin: intended, and what equilibrium decides of them
    retraction: Array | None  # (k,) m, None where the job does not set it
    statics: PathStatics
    errors: SampleErrors
    findings: tuple[Finding, ...]
    verdict: str
    travels: tuple[LedTravel, ...]  # that were changed, or that no way was found for
    slower: tuple[str, ...]  # a note, where motion had to be slower than the job asks for
    fastest: Fastest | None  # None where nothing limits a speed
    expected: ExpectedError | None  # None where it was not requested
    uncertainty: str  # where the uncertainties are from
    distances: Clearances | None  # of lines; None where they were not requested
    not_checked: tuple[str, ...]
    step: float  # m, max distance of samples
    chosen: Model  # whose tensions are taken at rest
    toolpath: Toolpath
    beads: Beads

    @property
    def feasible(self) -> bool:
        """Whether all that was checked is within its limits, and the compensated path is met."""
        return not (self.codes.any() or self.missed.any() or any(finding.violations for finding in self.findings))

    @cached_property
    def missed(self) -> Mask:
        """Mask (k,) of samples that lines can hold, but the full model with compensated lengths misses."""
        missed = np.empty(len(self.samples), dtype=np.bool_)
        for at in blocks(len(missed)):
            met = self.error_compensated[at] + self.turn_compensated[at] <= MET
            missed[at] = ~met & (self.codes[at] == 0)
            let_go((self.errors, self.codes))
        return missed

    @property
    def interpolation_error(self) -> float | None:
        """Largest error of a length half-way between two samples, m; None if no sample has an equilibrium."""
        return next((each.value for each in self.findings if each.limit == INTERPOLATION), None)

    @property
    def nearest(self) -> Contact | None:
        """The nearest contact of a line; its row is the sample. None without one, or where it was not requested."""
        return None if self.distances is None else self.distances.nearest

    @property
    def codes(self) -> NDArray[np.int64]:
        """Status (k,) of each sample's inverse problem."""
        return self.statics.codes

    @property
    def lengths(self) -> Array:
        """Compensated lengths (k, m), m, of cable that winches should pay out to hold the platform at rest."""
        return self.statics.lengths

    @property
    def commanded(self) -> Array:
        """Commanded lengths (k, m), m, for the moving platform; lengths at rest if motion is not compensated."""
        return self.statics.commanded

    @property
    def error_uncompensated(self) -> Array:
        """Nozzle error (k,), m, without compensation."""
        return self.errors.uncompensated

    @property
    def error_compensated(self) -> Array:
        """Nozzle error (k,), m, with compensation."""
        return self.errors.compensated

    @property
    def error_elastic_only(self) -> Array:
        """Nozzle error (k,), m, with compensation of elasticity alone."""
        return self.errors.elastic_only

    @property
    def turn_uncompensated(self) -> Array:
        """Error of rotation (k,), rad, of the platform without compensation; 0 for a point."""
        return self.errors.turn_uncompensated

    @property
    def turn_compensated(self) -> Array:
        """Error of rotation (k,), rad, with compensation."""
        return self.errors.turn_compensated

    @cached_property
    def max_tilt(self) -> float:
        """The largest angle of the platform's z axis from the vertical, rad; NaN where nothing is held."""
        most = np.nan
        for at in blocks(len(self.samples)):
            upright = np.clip(matrices(self.poses[at, 3:])[:, 2, 2], -1.0, 1.0)
            most = np.fmax(most, np.fmax.reduce(np.arccos(upright[self.codes[at] == 0]), initial=np.nan))
            let_go((self.poses, self.codes))
        return float(most)

    def nozzle(self, poses: Array) -> Array:
        """Positions of the nozzle, (k, 3) m, at *poses* (k, n) of the platform, m and rad."""
        return Model(self.robot).nozzle(poses)

    @property
    def allowed_error(self) -> float:
        """Return the allowed expected error, m, at the sample whose error is nearest to it.

        If the expected error was not checked, it is the allowed error of the median bead.
        """
        bounds = next((each.allowed[1] for each in self.findings if each.limit == EXPECTED_ERROR), None)
        return self.job.allowed_error(self.beads.typical.width) if bounds is None else bounds

    @property
    def placed_findings(self) -> tuple[PlacedFinding, ...]:
        """The violated limits, with layer and line of the G-code of each."""
        return tuple(PlacedFinding(finding, self.place(finding.sample)) for finding in self.findings)

    @property
    def notes(self) -> tuple[str, ...]:
        """Guesses on the G-code, doubtful values, and cautions on the expected error."""
        found = self.toolpath.layers_by == BY_HEIGHT and isinstance(self.job.path, Path)
        notes = ["layers are found by height: the file has no layer markers"] if found else []
        ends = SMALLEST(self.samples.positions), LARGEST(self.samples.positions)
        part = float((ends[1] - ends[0]).max())
        frame = float(np.subtract(self.robot.scene.frame_max, self.robot.scene.frame_min).max())
        if frame > WRONG_UNIT * part:
            notes.append(
                f"the path is {spell_length(part)} large, the frame {spell_length(frame)}: is scale = "
                f"{self.job.scale:g}, or a unit of the robot file, wrong?"
            )
        if self.reserved:
            notes.append(
                "tensions at rest keep so far from their limits that lines are within them while the platform swings: "
                "they are within the held limits, as a print takes them"
            )
        if self.chosen.preferred is None and (note := preferred_note(self.preferred_tensions)):
            notes.append(note)
        if units := units_inside([end.tolist() for end in ends], self.robot):
            corners = " to ".join(f"({', '.join(f'{each:.4g}' for each in end)})" for end in ends)
            notes.append(f"the path, {corners} m, is not in the robot: is it, or its origin, in {' or '.join(units)}?")
        near = self.nearest
        if near is not None and near.margin < 0.0 and self.robot.meets_in_nozzle:
            notes.append(
                "lines meet in the nozzle in this robot file: where they meet above it, lines.platform_point says by "
                "how much (of an import: --nozzle-below)"
            )
        notes += overstretched(self.robot, LARGEST(self.statics.lines.highest_tension))
        notes += (*self.slower, *self.shaping.notes)
        own = self.robot.uncertainty
        if self.expected is not None and self.uncertainty == ASSUMED and own is not None and own.zeroed_at is not None:
            notes.append("expected error counts from the nozzle at uncertainty.zeroed_at, where lines are zeroed")
        return (*notes, *self.beads.notes, *(() if self.expected is None else self.expected.notes))

    @property
    def reserved(self) -> bool:
        """Whether tensions at rest keep a reserve from the limits of the robot file."""
        return self.chosen.robot != self.robot

    @property
    def preferred_tensions(self) -> Array | None:
        """Tensions (1, m), N, to which the solution is nearest; None where it has the least norm."""
        return preferred_tensions(self.chosen)

    @property
    def nearest_place(self) -> Place | None:
        """Position of the smallest distance of a line."""
        return None if self.nearest is None else self.place(self.nearest.row)

    @cached_property
    def motion(self) -> MotionError | None:
        """The error caused by the motion of the platform; None if this error is not known."""
        return MotionError.of(self.samples, self.statics)

    @property
    def motion_place(self) -> Place | None:
        """Position of the largest error caused by motion."""
        return None if self.motion is None else self.place(self.motion.sample)

    @property
    def refusal(self) -> str:
        """Reason why the robot cannot print the job, in a sentence."""
        return "" if self.feasible else self.verdict

    def where(self, sample: int) -> str:
        """Return layer and move of a sample, in words."""
        return f"{self.samples.where(sample)}, {self.job.move_name} {self.samples.line[sample]}"

    def place(self, sample: int) -> Place:
        """Return the location of a sample: position, layer and line of the G-code file."""
        x, y, z = (float(each) for each in self.samples.positions[sample])
        return Place((x, y, z), int(self.samples.layer[sample]), int(self.samples.line[sample]))
