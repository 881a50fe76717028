"""Tensions with which the nozzle is least sensitive to errors, on robots with more lines than degrees of freedom.

Tension stiffens a line and reduces its sag, so the redundant tension decides how far uncertain parameters move the
platform.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from cablewright.analyses.accuracy.spread import Method, SpreadProblem
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.models.statics import Equilibrium
from cablewright.models.support_table import Capability, require
from cablewright.robot.uncertainty import Range
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.tension import self_stresses
from cablewright.solvers.winched_tensions import drum_stresses

GRID = {1: 33, 2: 9, 3: 5}
"""Number of tensions tried along each free direction in a round, by the number of free directions."""

ROUNDS = 12
SHRINK = 0.35  # ratio of the search widths of successive rounds


@dataclass(frozen=True, eq=False)
class BestTensions:
    """The tensions at one pose for which the nozzle deviates least, compared with the least-norm tensions."""

    tensions: Array  # (m,) N, at the sheaves
    lengths: Array  # (m,) m
    max_deviation: float  # m, largest distance of the nozzle from its nominal position
    least_norm_max_deviation: float  # m, the same under least-norm tensions
    tried: int  # number of tension distributions evaluated

    @property
    def gain(self) -> float:
        """Relative reduction of the deviation: 0 is none, 1 is all."""
        reference = self.least_norm_max_deviation
        return 1.0 - self.max_deviation / reference if reference > 0.0 else 0.0


def best_tensions(
    held: Equilibrium, ranges: tuple[Range, ...], method: Method, search: Method | None = None
) -> BestTensions:
    """Find the tensions within the limits, at the one pose of the batch *held*, whose largest deviation is smallest.

    A grid search over the distributions that balance the load, refined around the best one, so a better distribution
    elsewhere is not excluded. Counterweights keep their tension. *method* finds the deviation under *ranges* for
    lengths commanded by the full model; *search*, by default the same, compares distributions. Raises `InputError`
    unless 1 to 3 lines with a winch are redundant, `AnswerError` where the pose cannot be held.
    """
    model = held.model
    require(model, Capability.TENSION_CHOICE)
    redundant = model.winches - model.freedoms
    if redundant not in GRID:
        raise InputError(
            f"robot {model.robot.name}: {redundant} redundant lines; the best tensions can be found for 1 to 3"
        )
    start = held.checked()
    directions = self_stresses(start[0])
    if model.robot.sharing:
        directions = drum_stresses(start, directions)
    grid = np.array(list(product(np.linspace(-1.0, 1.0, GRID[redundant]), repeat=redundant)))
    search = search or method
    best, chosen = float(search(_problem(start, ranges)).max_deviation[0]), start
    centre, tried = np.zeros(redundant), 1
    width = float(np.linalg.norm(model.lines.tension_max - model.lines.tension_min))  # of the tensions within limits
    for number in range(ROUNDS):
        wanted = start.tensions + (centre + width * grid) @ directions
        found = solve_inverse(model, np.repeat(start.pose, len(grid), axis=0), preferred=wanted)
        found = found[found.ok]
        if not len(found):
            break
        tried += len(found)
        deviations = search(_problem(found, ranges)).max_deviation
        at = int(np.nanargmin(deviations))
        if deviations[at] < best:
            best, chosen = float(deviations[at]), found[at : at + 1]
        reached = (found.tensions - start.tensions) @ directions.T  # the limits may have clipped the wanted tensions
        centre = (chosen.tensions[0] - start.tensions[0]) @ directions.T
        width = float(np.abs(reached - centre).max()) if number == 0 else SHRINK * width
    reference, best = (float(method(_problem(each, ranges)).max_deviation[0]) for each in (start, chosen))
    if not best < reference:
        best, chosen = reference, start
    return BestTensions(chosen.tensions[0], chosen.lengths[0], best, reference, tried)


def _problem(held: Equilibrium, ranges: tuple[Range, ...]) -> SpreadProblem:
    """The problem of poses that the full model holds with its own lengths."""
    return SpreadProblem(held, held.lengths, held.pose, ranges)
