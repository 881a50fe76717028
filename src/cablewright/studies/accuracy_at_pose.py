"""Accuracy at one place: the region of the nozzle, what each compensation leaves, the tensions that hold it best."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.analyses.accuracy.compensation import COMPENSATIONS
from cablewright.analyses.accuracy.corners import ALL_VERTICES
from cablewright.analyses.accuracy.nozzle_error import Accuracy, AccuracyOptions, AccuracyQuestion
from cablewright.analyses.accuracy.region import Region, region
from cablewright.analyses.accuracy.spread import FirstOrder, Vertices, corner_values
from cablewright.analyses.accuracy.tensions import GRID, BestTensions, best_tensions
from cablewright.errors import AnswerError, InputError, Status
from cablewright.robot import Robot
from cablewright.robot.uncertainty import Range

__all__ = ["AccuracyAtPose", "accuracy_at"]

Array = NDArray[np.float64]
INNER = 4000
"""Random points inside the box of ranges that are tried against its corners."""


@dataclass(frozen=True, eq=False)
class AccuracyAtPose:
    """What there is to say of one pose."""

    accuracy: Accuracy  # one row
    region: Region  # of the corners of the ranges
    remains: dict[str, Accuracy]  # by compensation, each one row; those whose lengths lead somewhere
    best: BestTensions | None  # None where tensions cannot be chosen, or there are too many ways to

    def summary(self) -> dict[str, object]:
        """The figures of the command line's JSON, SI."""
        found, spread, corners = self.accuracy, self.accuracy.spread, self.region
        labels = [each.parameter.label for each in found.ranges]
        values: dict[str, object] = {
            "status": Status.OK.word,
            "robot": found.robot.name,
            "compensation": found.compensation,
            "pose": found.wanted[0],
            "nominal_pose": found.nominal[0],
            "nominal_error": float(found.nominal_error[0]),
            "nominal_offset": found.nominal_offset[0],
            "nominal_turn": float(found.nominal_turn[0]),
            "max_error": float(spread.max_error[0]),
            "max_error_values": dict(zip(labels, spread.worst_values[0].tolist(), strict=True)),
            "max_turn": float(spread.max_turn[0]),
            "difference": float(found.difference[0]),
            "max_deviation": float(spread.max_deviation[0]),
            "deviation": spread.deviation[0],
            "likely_error": float(spread.likely_error[0]),
            "nonlinearity": float(spread.nonlinearity[0]),
            "unsolved": int(spread.unsolved[0]),
            "contributions": self._contributions(labels),
            "hull_volume": corners.hull.volume,
            "projections": corners.hull.projections,
            "interior": None if corners.interior is None else corners.interior.__dict__,
            "remains": [self._remains(name) for name in self.remains],
            "best_tension": None if self.best is None else self._best(self.best),
            "parameters": labels,
            "vertices": self._vertices(),
        }
        if all(each.parameter.kind == "modulus" for each in found.ranges):
            values["max_error_factors"] = spread.worst_values[0]
        return values

    def _contributions(self, labels: Sequence[str]) -> list[dict[str, object]]:
        """Each number's own effect, half its range, first order, most first."""
        effects = self.accuracy.spread.effects[0]
        sizes = np.linalg.norm(effects, axis=0)
        order = np.argsort(-sizes, kind="stable")
        return [{"parameter": labels[k], "effect": float(sizes[k]), "offset": effects[:, k]} for k in order]

    def _remains(self, name: str) -> dict[str, object]:
        found = self.remains[name]
        return {
            "compensation": name,
            "nominal_error": float(found.nominal_error[0]),
            "max_error": float(found.spread.max_error[0]),
            "max_deviation": float(found.spread.max_deviation[0]),
        }

    @staticmethod
    def _best(best: BestTensions) -> dict[str, object]:
        return {
            "tensions": best.tensions,
            "lengths": best.lengths,
            "max_deviation": best.max_deviation,
            "least_norm_max_deviation": best.least_norm_max_deviation,
            "gain": best.gain,
        }

    def _vertices(self) -> list[dict[str, object]]:
        """Every corner: its values, where the nozzle is, its error and its distance from the nominal point."""
        corners = self.region
        errors = np.linalg.norm(corners.points - corners.wanted, axis=1)
        away = np.linalg.norm(corners.points - corners.nominal, axis=1)
        rows = zip(corners.values, corners.points, errors, away, strict=True)
        return [{"values": v, "nozzle": p, "error": float(e), "deviation": float(d)} for v, p, e, d in rows]


def accuracy_at(
    robot: Robot,
    pose: ArrayLike,
    ranges: Sequence[Range] | None = None,
    *,
    seed: int = 0,
    **options: Unpack[AccuracyOptions],
) -> AccuracyAtPose:
    """All about the accuracy at one *pose* (n,), m and rad; *ranges* and *options* as of `accuracy`.

    *seed* is that of the random points that are tried against the corners of the ranges.

    Raises `InputError` for what cannot be used, `AnswerError` where the pose cannot be held.
    """
    if seed < 0:
        raise InputError(f"seed = {seed}: at least 0 is wanted")
    asked = AccuracyQuestion.of(robot, ranges, **options)
    there = asked.hold(np.ravel(np.asarray(pose, dtype=np.float64)))
    found = asked.answer(there)
    if not np.isfinite(found.spread.max_error).any():
        raise AnswerError(f"robot {robot.name}: the uncertain numbers leave no equilibrium here")
    remains = {}
    for name, other in COMPENSATIONS.items():
        with suppress(AnswerError):  # a controller may have no lengths here that lead anywhere
            remains[name] = found if other is asked.compensation else replace(asked, compensation=other).answer(there)
    corners = region(found.problem, corner_values(found.problem), inner=INNER, seed=seed)
    best = None
    if robot.m - robot.n in GRID:
        quick = Vertices() if len(asked.ranges) <= ALL_VERTICES else FirstOrder()
        best = best_tensions(there.equilibria, asked.ranges, quick)
    return AccuracyAtPose(found, corners, remains, best)
