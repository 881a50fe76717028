"""Score tests of numbers of a single line that count as known: whether the data ask for others, and by how much.

A number is tested beside all unknowns, to first order about the answer, so nothing is fitted again: the residuals'
derivative by it, of which the unknowns explain a part, against the residuals (Lagrange multiplier test; Rao 1948).
Beside the number by the data alone is its sigma by the data alone: errors far below that are invisible to any test.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy import special

from cablewright.calibration.judgement.model_doubt import Alternative, with_more
from cablewright.calibration.measurement_rows.given_numbers import known_deviation
from cablewright.calibration.poses.fit import PoseFit
from cablewright.calibration.poses.observability import Information, projected
from cablewright.calibration.poses.problem import CalibrationProblem
from cablewright.robot import Eyelet

_NULL: Final = 1e-9  # relative size of a singular value that counts as zero
_INVISIBLE: Final = 1e-3  # part of a column beside the unknowns, under which rounding may be all of it
_FEW: Final = 10  # redundant measurements with which residuals test a number
_MORE: Final = float(special.ndtri(0.8))  # sigmas beyond the level, at which four of five are noticed
LEVEL: Final = 0.01
"""Probability by chance, of any of the tested numbers, under which one counts as wrong."""


@dataclass(frozen=True)
class Score:
    """A number of one line that counts as known: its error by the data alone, all others being right.

    ``shift`` (k,): change of the free unknowns by that error. ``probability``: of so large an error by chance, in any
    of the tested numbers (Bonferroni), which are ``among``.
    """

    name: str  # of the unknown: ``platform_point``
    kind: str  # in the registry: ``platform_point.x``
    words: str
    unit: str
    value: float
    sigma: float
    shift: tuple[float, ...]
    probability: float
    among: int

    @property
    def shows(self) -> float:
        """The error from which on the test notices it at a level of `LEVEL`, in four of five cases."""
        return self.sigma * float(_MORE - special.ndtri(0.5 * LEVEL / self.among))


def scores(
    problem: CalibrationProblem,
    found: PoseFit,
    posterior: Information,
    scale: float,
    effects: Sequence[Alternative] = (),
) -> tuple[Score, ...]:
    """Return a test for each known sheave radius, length scale and platform point of a line, by rising probability.

    *scale*: sigma of a row over that of its weight. *effects* that are in the model count as unknowns. Returns none if
    the fit has no solution, or too little redundancy.
    """
    names, plan = _names(problem), problem.plan
    if found.code != 0 or not names or not 0.0 < scale < np.inf or posterior.redundancy < _FEW:
        return ()
    _, rows, more = with_more(problem, found, names, ())
    if not rows.whole.all():
        return ()
    k, fitted = len(found.theta), [each.column for each in effects if each.fitted]
    columns = rows.by_unknown[..., :k], *(each[..., None] for each in fitted), rows.by_unknown[..., k:]
    by_all = np.concatenate(columns, axis=2)
    off, reduced, _ = projected(replace(rows, by_unknown=by_all))
    others = np.concatenate([rows.others_by_unknown[:, :k], np.zeros((len(rows.others), by_all.shape[2] - k))], axis=1)
    flat = np.concatenate([reduced.reshape(-1, by_all.shape[2]), others]) / scale
    rest = np.append(off.ravel(), rows.others) / scale
    known, tested = flat[:, : k + len(fitted)], flat[:, k + len(fitted) :]
    size = np.maximum(np.linalg.norm(known, axis=0), 1e-300)
    left, values, right = np.linalg.svd(known / size, full_matrices=False)
    kept = values > _NULL * values.max(initial=1e-300)
    inner = left[:, kept].T @ tested
    beside = tested - left[:, kept] @ inner
    motion = -(right[kept].T @ (inner / values[kept, None])) / size[:, None]
    seen = np.linalg.norm(beside, axis=0)
    visible = seen > _INVISIBLE * np.linalg.norm(tested, axis=0)
    unsure = [known_deviation(plan, each.name, each.line, 1.0) > 0.0 for each in more]
    chosen = np.flatnonzero(visible & unsure)
    made = []
    for at in chosen.tolist():
        each, value = more[at], -float(beside[:, at] @ rest) / seen[at] ** 2
        chance = _chance(abs(value) * seen[at], posterior.redundancy, plan.sigma.encoder is None) * len(chosen)
        shift = tuple((motion[:k, at] * value).tolist())
        value, sigma = value * each.size, each.size / seen[at]
        told = each.name, each.kind, each.label, each.unit, value, sigma, shift
        made.append(Score(*told, min(chance, 1.0), len(chosen)))
    return tuple(sorted(made, key=lambda each: each.probability))


def _chance(size: float, redundancy: int, by_residuals: bool) -> float:
    """Return the probability of a score of this *size*, in sigmas, or a larger one by chance.

    Where the sigma is *by_residuals* it contains the score itself, whose square is at most their *redundancy*: then the
    residuals without the score give Student's t. Else the score is normal.
    """
    if not by_residuals:
        return 2.0 * float(special.ndtr(-size))
    left = redundancy - size**2
    if left <= 0.0:
        return 0.0
    return 2.0 * float(special.stdtr(redundancy - 1, -size * math.sqrt((redundancy - 1) / left)))


def _names(problem: CalibrationProblem) -> list[str]:
    """Return the names of the numbers to test: not unknowns, nor of parts that no line has."""
    unknowns, robot = problem.plan.unknowns, problem.robot
    names = ["sheave_radius"] * any(not isinstance(line.sheave, Eyelet) for line in robot.lines)
    names += ["length_scale"] * ("drum_radius" not in unknowns)
    names += ["platform_point"] * (robot.freedoms > 3)
    return [name for name in names if name not in unknowns]
