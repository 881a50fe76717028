"""Accuracy at one pose: region of the nozzle, errors left by each compensation, tensions of smallest error."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Any, ClassVar, NamedTuple

import numpy as np

from cablewright.analyses.accuracy.compensation import COMPENSATIONS
from cablewright.analyses.accuracy.corners import ALL_VERTICES
from cablewright.analyses.accuracy.error_region import Region, region
from cablewright.analyses.accuracy.least_sensitive_tensions import GRID, BestTensions, best_tensions
from cablewright.analyses.accuracy.nozzle_error import CONTRIBUTION, Accuracy, AccuracyQuestion
from cablewright.analyses.accuracy.spread import FirstOrder, Vertices, corner_values
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import AnswerError
from cablewright.foundation.results import Figure, Result
from cablewright.models.statics import Equilibrium
from cablewright.robot.uncertainty import Range
from cablewright.solvers.linearise import tension_changes
from cablewright.solvers.parameter_effects import departures, range_response, range_tension_response

INNER = 4000
"""Random points inside the box of ranges that are compared with its corners."""


def _of_row(name: str) -> Callable[[AccuracyAtPose], Any]:
    """Return a function that reads the one row of an array of the accuracy."""
    return lambda found: attrgetter(name)(found.accuracy)[0]


class Corner(NamedTuple):
    """One corner of the parameters' ranges, with the error there."""

    values: Array  # (k,)
    nozzle: Array  # (3,) m
    error: float  # m
    deviation: float  # m


class Remaining(NamedTuple):
    """The position errors that remain with a compensation of the lengths."""

    name: str
    accuracy: Accuracy  # one row

    @property
    def words(self) -> str:
        """The model by which the lengths were computed, in words."""
        return COMPENSATIONS[self.name].words


CORNER = (
    Figure("values", "", "Values of the uncertain parameters."),
    Figure("nozzle", "m", "Position of the nozzle, world."),
    Figure("error", "m", "Distance of the nozzle from its expected position."),
    Figure("deviation", "m", "Distance of the nozzle from its nominal position."),
)
REMAINING = (
    Figure("compensation", "", "Model from which the commanded lengths are.", "name"),
    Figure("words", "", "The same in words.", name="error"),
    Figure("nominal_error", "m", "Error if all parameters are nominal.", _of_row("nominal_error"), shown="mm"),
    Figure("max_error", "m", "Largest error.", _of_row("spread.max_error"), shown="mm"),
    Figure("max_deviation", "m", "Largest distance of the nozzle from its nominal position.",
           _of_row("spread.max_deviation"), shown="mm"),
)  # fmt: skip
INTERIOR = (
    Figure("samples", "1", "Number of random points within the ranges that were tried.", name="inner points"),
    Figure("climbs", "1", "Number of them from which the error was increased along its gradient."),
    Figure("max_error", "m", "Largest error of these points.", shown="mm"),
    Figure("max_deviation", "m", "Largest distance of these points from the nominal position.", shown="mm"),
    Figure("corner_is_worst", "", "Whether no such point is worse than the corners.", name="corners are worst"),
)
BEST = (
    Figure("tensions", "N", "Tension of each line at its sheave.", shown="N"),
    Figure("lengths", "m", "Unstrained length of each line.", digits=7, shown="m"),
    Figure("max_deviation", "m", "Largest distance of the nozzle from its nominal position, with full compensation.",
           name="max deviation with full compensation", shown="mm"),
    Figure("min_norm_max_deviation", "m", "The same under the tensions that `inverse` chooses, as among the errors "
           "that remain.", "least_norm_max_deviation", "the same with default tensions", shown="mm"),
    Figure("gain", "1", "Share by which the deviation falls.", digits=3, shown="%"),
)  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class AccuracyAtPose(Result):
    """Errors of the nozzle at one pose: by corner of the ranges, by parameter, by compensation, by tensions."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok: there is an answer.", lambda _: "ok"),
        Figure("robot", "", "Name of the robot.", "accuracy.robot.name"),
        Figure("compensation", "", "Model from which the commanded lengths are.", "accuracy.compensation"),
        Figure("pose", "m, rad", "Expected pose of the platform.", _of_row("wanted"), digits=7),
        Figure("nominal_pose", "m, rad", "Pose of the platform if all parameters are nominal.", _of_row("nominal"),
               detail=True),
        Figure("nominal_error", "m", "Error if all parameters are nominal (Paty's delta p_n).",
               _of_row("nominal_error"), shown="mm"),
        Figure("nominal_offset", "m", "x, y and z of the nominal error.", _of_row("nominal_offset"), detail=True),
        Figure("nominal_turn", "rad", "Angle of the platform from its expected rotation if all parameters are nominal; "
               "0 for a point platform.", _of_row("nominal_turn")),
        Figure("max_error", "m", "Largest error (Paty's delta p_max).", _of_row("spread.max_error"), shown="mm"),
        Figure("max_error_values", "", "Values of the uncertain parameters there.", "_worst_values", detail=True),
        Figure("max_turn", "rad", "Largest angle of the platform from its expected rotation; 0 for a point platform.",
               _of_row("spread.max_turn")),
        Figure("difference", "m", "Largest error less the nominal one (Paty's delta p).", _of_row("difference"),
               shown="mm"),
        Figure("max_deviation", "m", "Largest distance of the nozzle from its nominal position.",
               _of_row("spread.max_deviation"), shown="mm"),
        Figure("deviation", "m", "Standard deviation of x, y and z.", _of_row("spread.deviation"),
               "standard deviation, x, y, z", shown="mm"),
        Figure("tension_deviation", "N", "Standard deviation of each line's tension at rest, to first order and by "
               "lengths alone; a print that measures tensions holds redundant ones nearer.",
               name="standard deviation of tensions by lengths alone", shown="N"),
        Figure("likely_error", "m", "Error that 95 % of the samples stay within; null unless samples are drawn.",
               _of_row("spread.likely_error"), "error of 95 % of samples", shown="mm"),
        Figure("nonlinearity", "1", "Error of the first-order estimate, as a share of the spread.",
               _of_row("spread.nonlinearity"), digits=2, shown="%"),
        Figure("unsolved", "1", "Number of solves without a sound equilibrium, which are left out.",
               _of_row("spread.unsolved")),
        Figure("hull_volume", "m^3", "Volume of the convex hull of the corners.", "region.hull.volume",
               "region of the corners", shown="mm^3"),
        Figure("projections", "m", "Outlines of the hull on the planes xy, xz and yz.", "region.hull.projections",
               detail=True),
        Figure("contributions", "", "Effect of each uncertain parameter alone, largest first.",
               "accuracy.contributions", parts=CONTRIBUTION),
        Figure("remains", "", "Errors that each compensation leaves.",
               lambda at: tuple(Remaining(*each) for each in at.remains.items()), "errors that remain",
               parts=REMAINING),
        Figure("interior", "", "Points within the ranges, compared with the corners; null where none were tried.",
               "region.interior", "points within the ranges", parts=INTERIOR),
        Figure("best_tension", "", "Tensions under which the deviation is smallest; null where tensions cannot be "
               "chosen.", "best", "tensions of smallest deviation", parts=BEST),
        Figure("parameters", "", "Labels of the uncertain parameters.", "accuracy.labels", detail=True),
        Figure("vertices", "", "Every corner of the ranges.", "_vertices", parts=CORNER, detail=True),
        Figure("max_error_factors", "1", "Factors on the moduli at the largest error.", _of_row("spread.worst_values"),
               only=lambda at: all(each.parameter.kind == "modulus" for each in at.accuracy.ranges), detail=True),
    )  # fmt: skip
    HEADLINES: ClassVar = ("robot", "compensation", "nominal_error", "max_error", "max_deviation")

    accuracy: Accuracy  # one row
    region: Region  # of the corners of the ranges
    remains: dict[str, Accuracy]  # by compensation, each one row; those whose lengths have an equilibrium
    tension_deviation: Array  # (m,) N
    best: BestTensions | None  # None if tensions cannot be chosen, or have too many degrees of freedom

    def _worst_values(self) -> dict[str, float]:
        return dict(zip(self.accuracy.labels, self.accuracy.spread.worst_values[0].tolist(), strict=True))

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes that caution about the figures of the result."""
        inner = self.region.interior
        if inner is None or inner.corner_is_worst:
            return self.accuracy.notes
        worse = (
            f"some points within the ranges are worse than all corners: up to {1e3 * inner.max_error:.3g} mm off, "
            f"{1e3 * inner.max_deviation:.3g} mm from the nominal position; the figures of the corners are too small"
        )
        return (*self.accuracy.notes, worse)

    def _vertices(self) -> tuple[Corner, ...]:
        corners = self.region
        errors = np.linalg.norm(corners.points - corners.wanted, axis=1)
        away = np.linalg.norm(corners.points - corners.nominal, axis=1)
        return tuple(Corner(*row) for row in zip(corners.values, corners.points, errors, away, strict=True))


def at_pose(question: AccuracyQuestion, pose: Array, seed: int) -> AccuracyAtPose:
    """Compute the errors at one *pose* (1, n), m and rad. Raises `AnswerError` if it cannot be held.

    *seed*: see `accuracy`.
    """
    robot, there = question.model.robot, question.hold(pose)
    found = question.answer(there)
    if not np.isfinite(found.spread.max_error).any():
        raise AnswerError(
            f"robot {robot.name}: at this pose no set of parameter values has an equilibrium; give "
            f"smaller ranges or another pose"
        )
    remains = {}
    for name, other in COMPENSATIONS.items():
        with suppress(AnswerError):  # lengths of this compensation may have no equilibrium
            remains[name] = (
                found if other is question.compensation else replace(question, compensation=other).answer(there)
            )
    problem = question.problem(there)
    corners = region(problem, corner_values(problem), inner=INNER, seed=seed)
    best = None
    if robot.m - robot.freedoms in GRID and not robot.sharing:
        quick = Vertices() if len(question.ranges) <= ALL_VERTICES else FirstOrder()
        best = best_tensions(there.equilibria, question.ranges, question.method, quick)
    return AccuracyAtPose(found, corners, remains, _tension_deviation(there.equilibria, question.ranges), best)


def _tension_deviation(held: Equilibrium, ranges: tuple[Range, ...]) -> Array:
    """Standard deviations (m,), N, of the tensions of a batch of one, over ranges in which all values are as likely.

    NaN where its equilibrium is not regular.
    """
    parameters, nominal = [each.parameter for each in ranges], np.array([each.nominal for each in ranges])
    try:
        off = range_tension_response(held, ranges, range_response(held, ranges), tension_changes(held))[0]
    except AnswerError:
        return np.full(held.model.m, np.nan)
    ends = departures(parameters, nominal, np.array([[each.low, each.high] for each in ranges]).T)
    return np.asarray(np.sqrt(off**2 @ (np.ptp(ends, axis=0) ** 2 / 12.0)))
