"""Accuracy at one pose: region of the nozzle, remaining error of each compensation, tensions that hold it best."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Any, ClassVar

import numpy as np

from cablewright.analyses.accuracy.compensation import COMPENSATIONS
from cablewright.analyses.accuracy.corners import ALL_VERTICES
from cablewright.analyses.accuracy.nozzle_error import Accuracy, AccuracyQuestion
from cablewright.analyses.accuracy.region import Region, region
from cablewright.analyses.accuracy.spread import FirstOrder, Vertices, corner_values
from cablewright.analyses.accuracy.tensions import GRID, BestTensions, best_tensions
from cablewright.arrays import Array
from cablewright.errors import AnswerError
from cablewright.results import Figure, Result

INNER = 4000
"""Random points inside the box of ranges that are compared with its corners."""


def _only_moduli(found: AccuracyAtPose) -> bool:
    return all(each.parameter.kind == "modulus" for each in found.accuracy.ranges)


def _of_row(name: str) -> Callable[[AccuracyAtPose], Any]:
    """Return a function that reads the one row of an array of the accuracy."""
    return lambda found: attrgetter(name)(found.accuracy)[0]


@dataclass(frozen=True, eq=False, repr=False)
class AccuracyAtPose(Result):
    """Errors of the nozzle at one pose: by corner of the ranges, by parameter, by compensation, by tensions."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok: there is an answer.", lambda _: "ok"),
        Figure("robot", "", "Name of the robot.", "accuracy.robot.name"),
        Figure("compensation", "", "The model that the commanded lengths are from.", "accuracy.compensation"),
        Figure("pose", "m, rad", "The wanted pose.", _of_row("wanted")),
        Figure("nominal_pose", "m, rad", "Where nominal numbers take the platform.", _of_row("nominal")),
        Figure("nominal_error", "m", "Error if all numbers are nominal.", _of_row("nominal_error")),
        Figure("nominal_offset", "m", "Its x, y and z.", _of_row("nominal_offset")),
        Figure("nominal_turn", "rad", "Turn of the platform if all numbers are nominal.", _of_row("nominal_turn")),
        Figure("max_error", "m", "Largest error.", _of_row("spread.max_error")),
        Figure("max_error_values", "", "Values of the uncertain numbers there.", "_worst_values"),
        Figure("max_turn", "rad", "Largest turn of the platform.", _of_row("spread.max_turn")),
        Figure("difference", "m", "Largest error less the nominal one.", _of_row("difference")),
        Figure("max_deviation", "m", "Longest way from the nominal place.", _of_row("spread.max_deviation")),
        Figure("deviation", "m", "Standard deviation of x, y and z.", _of_row("spread.deviation")),
        Figure("likely_error", "m", "Error of 95 % of the samples.", _of_row("spread.likely_error")),
        Figure("nonlinearity", "1", "Share by which first order is off.", _of_row("spread.nonlinearity")),
        Figure("unsolved", "1", "Sets of values without a sound equilibrium.", _of_row("spread.unsolved")),
        Figure("contributions", "m", "Own effect of each number, half its range, most first.", "_contributions"),
        Figure("hull_volume", "m^3", "Volume of the corners' hull.", "region.hull.volume"),
        Figure("projections", "m", "Shadows of the hull.", "region.hull.projections"),
        Figure("interior", "", "Inner points of the ranges against the corners.", "region.interior.__dict__"),
        Figure("remains", "m", "What each compensation leaves.", "_remains"),
        Figure("best_tension", "", "The tensions that hold it best.", "_best"),
        Figure("parameters", "", "What is uncertain.", "accuracy.labels"),
        Figure("vertices", "", "Every corner: values, nozzle, error, deviation.", "_vertices"),
        Figure("max_error_factors", "1", "At the largest error.", _of_row("spread.worst_values"), only=_only_moduli),
    )
    HEADLINES: ClassVar = ("robot", "compensation", "nominal_error", "max_error", "max_deviation")

    accuracy: Accuracy  # one row
    region: Region  # of the corners of the ranges
    remains: dict[str, Accuracy]  # by compensation, each one row; those whose lengths have an equilibrium
    best: BestTensions | None  # None if tensions cannot be chosen, or have too many freedoms

    def _worst_values(self) -> dict[str, float]:
        return dict(zip(self.accuracy.labels, self.accuracy.spread.worst_values[0].tolist(), strict=True))

    def _contributions(self) -> list[dict[str, object]]:
        labels, effects = self.accuracy.labels, self.accuracy.spread.effects[0]
        sizes = np.linalg.norm(effects, axis=0)
        order = np.argsort(-sizes, kind="stable")
        return [{"parameter": labels[k], "effect": float(sizes[k]), "offset": effects[:, k]} for k in order]

    def _remains(self) -> list[dict[str, object]]:
        return [
            {
                "compensation": name,
                "nominal_error": left.nominal_error[0],
                "max_error": left.spread.max_error[0],
                "max_deviation": left.spread.max_deviation[0],
            }
            for name, left in self.remains.items()
        ]

    def _best(self) -> dict[str, object] | None:
        names = ("tensions", "lengths", "max_deviation", "least_norm_max_deviation", "gain")
        return None if self.best is None else {name: getattr(self.best, name) for name in names}

    def _vertices(self) -> list[dict[str, object]]:
        """Every corner: values, nozzle position, error, and distance from the nominal nozzle position."""
        corners = self.region
        errors = np.linalg.norm(corners.points - corners.wanted, axis=1)
        away = np.linalg.norm(corners.points - corners.nominal, axis=1)
        rows = zip(corners.values, corners.points, errors, away, strict=True)
        return [{"values": v, "nozzle": p, "error": float(e), "deviation": float(d)} for v, p, e, d in rows]


def at_pose(question: AccuracyQuestion, pose: Array, seed: int) -> AccuracyAtPose:
    """Errors at one *pose* (1, n), m and rad; *seed*: see `accuracy`. Raises `AnswerError` if it cannot be held."""
    robot, there = question.model.robot, question.hold(pose)
    found = question.answer(there)
    if not np.isfinite(found.spread.max_error).any():
        raise AnswerError(f"robot {robot.name}: no equilibrium here for any values of the uncertain parameters")
    remains = {}
    for name, other in COMPENSATIONS.items():
        with suppress(AnswerError):  # lengths of this compensation may have no equilibrium
            remains[name] = (
                found if other is question.compensation else replace(question, compensation=other).answer(there)
            )
    corners = region(found.problem, corner_values(found.problem), inner=INNER, seed=seed)
    best = None
    if robot.m - robot.n in GRID:
        quick = Vertices() if len(question.ranges) <= ALL_VERTICES else FirstOrder()
        best = best_tensions(there.equilibria, question.ranges, quick)
    return AccuracyAtPose(found, corners, remains, best)
