"""How far a steady acceleration changes tensions, while lengths are those that hold the platform at rest.

To first order: the platform gives way to the force as a spring does, and the lines take it up. Counterweights move
with their cables as if these did not stretch. Cables, sheaves and winches are massless here, and nothing swings: for
that see `motion/path_swing.py`.
"""

from __future__ import annotations

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.models.inertia import moving_masses, with_inertia
from cablewright.models.statics import Equilibrium
from cablewright.solvers.linearise import Linearisation, tension_changes


def tensions_by_acceleration(held: Equilibrium, linear: Linearisation) -> Array:
    """Return by how much tensions (N, m) change with an acceleration in the worst direction, N per m/s^2."""
    mass, pulled = moving_masses(with_inertia(held.model.robot), held)
    changes = tension_changes(held).following(linear.motion_under(-mass[..., :3])) + pulled[..., :3]
    return np.asarray(np.linalg.norm(changes, axis=2))
