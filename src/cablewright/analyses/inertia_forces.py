"""How far a steady acceleration changes tensions, while lengths are those that hold the platform at rest.

To first order: the platform gives way to the force as a spring does, and the lines take it up. Counterweights move
with their cables as if these did not stretch. Cables, sheaves and winches are massless here, and nothing swings: for
that see `motion/path_swing.py`.
"""

from __future__ import annotations

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.models.inertia import counterweight_root
from cablewright.models.rotation import matrices, rotations
from cablewright.models.statics import Equilibrium
from cablewright.models.stiffness import stiffness
from cablewright.solvers.linearise import Linearisation, tension_changes


def tensions_by_acceleration(held: Equilibrium, linear: Linearisation) -> Array:
    """Return by how much tensions (N, m) change with an acceleration in the worst direction, N per m/s^2."""
    robot, wrenches = held.model.robot, _wrenches(held)
    hung = list(robot.hung)
    if not hung:
        return _sizes(tension_changes(held).following(linear.motion_under(wrenches)))
    root = counterweight_root(robot, stiffness(held))  # (N, c, n)
    rising = root[..., :3]  # (N, c, 3), times the root of the mass
    changes = tension_changes(held).following(linear.motion_under(wrenches - np.swapaxes(root, 1, 2) @ rising))
    masses, cables = np.array([[robot.lines[i].counterweight, robot.lines[i].cables] for i in hung], np.float64).T
    changes[:, hung] += (np.sqrt(masses) / cables)[:, None] * rising
    return _sizes(changes)


def _sizes(changes: Array) -> Array:
    return np.asarray(np.linalg.norm(changes, axis=2))


def _wrenches(held: Equilibrium) -> Array:
    """Wrenches of inertia (N, n, 3) on the platform by unit accelerations: at its centre of mass, about its origin."""
    platform = held.model.robot.platform
    force = np.broadcast_to(-platform.mass * np.eye(3), (len(held.pose), 3, 3))
    arm = matrices(rotations(held.pose)) @ np.asarray(platform.centre_of_mass)
    return np.concatenate([force, np.cross(arm[:, :, None], force, axis=1)], axis=1)[:, : held.model.n]
