"""The tensions under which a place is held best: where there are more lines than freedoms, one may choose.

Tension stiffens and sag softens, so the redundant tension decides how far uncertain numbers can take the platform.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from cablewright.analyses.accuracy.spread import Method, SpreadProblem
from cablewright.arrays import Array
from cablewright.errors import InputError
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot.uncertainty import Range
from cablewright.solvers.inverse import solve_inverse

GRID = {1: 33, 2: 9, 3: 5}
"""Tensions tried along each direction in which they can be chosen, a round, by how many directions there are."""

ROUNDS = 12
SHRINK = 0.35  # of the width looked over, from round to round


@dataclass(frozen=True, eq=False)
class BestTensions:
    """The tensions that let uncertain numbers do least at one pose, and what they gain over the least-norm ones."""

    tensions: Array  # (m,) N, at the sheaves
    lengths: Array  # (m,) m
    max_deviation: float  # m, largest offset of the nozzle from where nominal numbers take it
    least_norm_max_deviation: float  # m, the same under least-norm tensions
    tried: int  # distributions looked at

    @property
    def gain(self) -> float:
        """Share by which the deviation falls: 0 none, 1 all."""
        reference = self.least_norm_max_deviation
        return 1.0 - self.max_deviation / reference if reference > 0.0 else 0.0


def best_tensions(held: Equilibrium, ranges: tuple[Range, ...], method: Method) -> BestTensions:
    """Choose the tensions at the one pose of a batch *held* within the limits so that the largest deviation is least.

    Looked for on a grid over the distributions that balance the load, ever finer about the best: what it finds is
    held to by a solve, a better one elsewhere is not excluded. The full model's lengths are commanded. Raises
    `InputError` where no line is redundant or more than three are, `AnswerError` where the pose cannot be held.
    """
    model = held.model
    redundant = model.m - model.n
    if redundant not in GRID:
        raise InputError(f"robot {model.robot.name}: {redundant} redundant lines; tensions are chosen among 1 to 3")
    start = held.checked()
    directions = _free_directions(start)
    grid = np.array(list(product(np.linspace(-1.0, 1.0, GRID[redundant]), repeat=redundant)))
    reference = float(method(_problem(start, ranges)).max_deviation[0])
    best, chosen = reference, start
    centre, width, tried = np.zeros(redundant), _widest(model), 1
    for number in range(ROUNDS):
        wanted = start.tensions + (centre + width * grid) @ directions
        found = solve_inverse(model, np.repeat(start.pose, len(grid), axis=0), preferred=wanted)
        found = found[found.ok]
        if not len(found):
            break
        tried += len(found)
        deviations = method(_problem(found, ranges)).max_deviation
        at = int(np.nanargmin(deviations))
        if deviations[at] < best:
            best, chosen = float(deviations[at]), found[at : at + 1]
        reached = (found.tensions - start.tensions) @ directions.T  # limits may have turned back what was asked
        centre = (chosen.tensions[0] - start.tensions[0]) @ directions.T
        width = float(np.abs(reached - centre).max()) if number == 0 else SHRINK * width
    return BestTensions(chosen.tensions[0], chosen.lengths[0], best, reference, tried)


def _problem(held: Equilibrium, ranges: tuple[Range, ...]) -> SpreadProblem:
    """The problem of poses that the full model holds with its own lengths."""
    return SpreadProblem(held, held.lengths, held.pose, ranges)


def _free_directions(held: Equilibrium) -> Array:
    """Unit vectors (r, m) along which tensions can change and the load still be balanced, for straight lines."""
    away = held.platform_points[0] - np.array([line.exit_point for line in held.model.robot.lines])
    units = away / np.linalg.norm(away, axis=1, keepdims=True)
    arms = held.platform_points[0] - held.pose[0, :3]
    structure = np.concatenate([units, np.cross(arms, units)], axis=1).T[: held.model.n]
    return np.asarray(np.linalg.svd(structure)[2][held.model.n :])


def _widest(model: Model) -> float:
    """More than tensions within the limits can differ by, N."""
    return float(np.linalg.norm(model.lines.tension_max - model.lines.tension_min))
