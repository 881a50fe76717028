"""Errors of tensions from the chosen ones where lengths alone decide them, to first order (`tension_spread`).

A machine is homed with correct tensions; from there on its lengths have errors of homing, of the size of its drums, and
of the positions of exit points. More lines than degrees of freedom turn such errors into tensions, by the equilibrium
of all lines.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.models.statics import Equilibrium
from cablewright.robot.parameters import parameters_of
from cablewright.solvers.linearise import linearise, tension_changes
from cablewright.solvers.parameter_effects import tension_response


class TensionSpread(NamedTuple):
    """Uncertain tensions at N poses: standard deviation (N, m) and loss by stretch of the cables (N, m), both in N."""

    deviation: Array
    fall: Array


def tension_spread(
    held: Equilibrium, home_length: float, drum_radius: float, exit_point: float, stretch: float
) -> TensionSpread:
    """Return the errors of tensions at the N poses of *held*, homed at the first, and their decrease as cables stretch.

    Standard deviations: *home_length*, m, of each length there; *drum_radius*: share of each drum's; *exit_point*: m,
    of each coordinate. *stretch*: strain of all cables that no encoder sees.

    Raises `AnswerError` where a pose is not held or singular, `InputError` where cables are rigid.
    """
    model, linear, changes = held.model, linearise(held), tension_changes(held)
    points = [each for axis in "xyz" for each in parameters_of(model.robot, f"exit_point.{axis}")]
    still = np.zeros((len(held.pose), model.n, len(points)))
    moved = tension_response(held, points, still, changes) / changes.per_length[..., None]
    by_length = changes.by_pose @ linear.per_length + changes.per_length[..., None] * np.eye(model.m)
    by_points = exit_point * (by_length @ (moved - moved[0]))
    wound = drum_radius * (held.lengths - held.lengths[0])
    by_lengths = by_length * np.sqrt(home_length**2 + wound**2)[:, None, :]
    deviation = np.sqrt((by_points**2).sum(axis=2) + (by_lengths**2).sum(axis=2))
    return TensionSpread(deviation, -stretch * np.einsum("nij,nj->ni", by_length, held.lengths))
