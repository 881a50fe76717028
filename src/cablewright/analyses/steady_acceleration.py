"""Change of tensions by a steady acceleration, while lengths hold the platform at rest, or on its path.

Cables, sheaves and winches are massless here, and nothing swings: for that see `motion/path_swing.py`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array
from cablewright.models.inertia import inertia_wrenches, moving_masses, with_inertia
from cablewright.models.statics import Equilibrium
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.linearise import Linearisation, tension_changes


def tensions_by_acceleration(held: Equilibrium, linear: Linearisation) -> Array:
    """Return by how much tensions (N, m) change with an acceleration in the worst direction, N per m/s^2.

    To first order, with lengths at rest: the force displaces the platform as a spring, and the lines take it
    up. Counterweights move with their cables as if these did not stretch.
    """
    mass, pulled = moving_masses(with_inertia(held.model.robot), held)
    changes = tension_changes(held).following(linear.motion_under(-mass[..., :3])) + pulled[..., :3]
    return np.asarray(np.linalg.norm(changes, axis=2))


class FedForward(NamedTuple):
    """Samples with lengths that compensate inertial forces, and the change of their tensions from rest."""

    rows: NDArray[np.int64]  # of all samples, those that are held at rest and accelerated
    moving: Equilibrium | None  # of these rows; None: there are none
    added: Array  # (b, m) N, of all samples; 0 where it is not held under the acceleration


def fed_forward(held: Equilibrium, retraction: Array | None, accelerations: Array) -> FedForward:
    """Return how the lines hold a platform, *held* at rest at b samples, under its *accelerations* (b, 3), m/s^2.

    *retraction* (b,): lengths, m, of a platform that retracts.
    """
    rows = np.flatnonzero(accelerations.any(axis=1) & held.ok)
    added = np.zeros_like(held.tensions)
    if not len(rows):
        return FedForward(rows, None, added)
    robot, poses = held.model.robot, held.pose[rows]
    drawn = None if retraction is None else retraction[rows]
    wrenches = inertia_wrenches(robot, poses, accelerations[rows])
    moving = solve_inverse(held.model, poses, path=True, retraction=drawn, wrenches=wrenches)
    added[rows] = np.where(moving.ok[:, None], moving.tensions - held.tensions[rows], 0.0)
    return FedForward(rows, moving, added)
