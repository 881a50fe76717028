"""What the forces of acceleration do: tensions and displacement while lengths are those that hold the platform at rest.

To first order: the platform gives way to the force as a spring does, and the lines take it up. Counterweights move
with their cables as if these did not stretch. Cables, sheaves and winches are massless here, and nothing swings.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.models.inertia import counterweight_root
from cablewright.models.rotation import matrices
from cablewright.models.statics import Equilibrium
from cablewright.models.stiffness import stiffness
from cablewright.robot import RigidPlatform
from cablewright.solvers.linearise import Linearisation, tension_changes
from cablewright.solvers.parameters import at_nozzle


@dataclass(frozen=True, eq=False)
class InertiaEffects:
    """The largest effects at N poses with m lines."""

    tension_drop: Array  # (N, m) N, at most 0: the largest fall of the tension at the sheave
    tension_rise: Array  # (N, m) N, at least 0: the largest rise
    displacement: Array  # (N,) m, the largest of the nozzle
    plane_rise: Array  # (N,) N, at least 0: what these changes together add at most to the force along a plane's normal


def inertia_effects(held: Equilibrium, linear: Linearisation, accelerations: Array) -> InertiaEffects:
    """Return the effects of *accelerations* (N, a, 3), m/s^2, world, at N solved poses with their linearisation.

    Rows without acceleration cost nothing. The platform translates: it turns at no angular acceleration.
    """
    rows, m = held.lengths.shape
    found = InertiaEffects(np.zeros((rows, m)), np.zeros((rows, m)), np.zeros(rows), np.zeros(rows))
    moving = np.flatnonzero(accelerations.any(axis=(1, 2)))
    if len(moving) == 0:
        return found
    there = held[moving]
    motion, changes = _effects(there, linear[moving], accelerations[moving])
    found.tension_drop[moving] = np.minimum(changes.min(axis=2), 0.0)
    found.tension_rise[moving] = np.maximum(changes.max(axis=2), 0.0)
    found.displacement[moving] = np.linalg.norm(at_nozzle(there, motion), axis=1).max(axis=1)
    plane = held.model.robot.platform.plane
    if plane is not None:
        chords = there.lines.exit_point - there.platform_points
        across = there.lines.pulls * (chords @ np.array(plane.across)) / np.linalg.norm(chords, axis=2)
        rise = np.maximum(across * found.tension_drop[moving], across * found.tension_rise[moving])
        found.plane_rise[moving] = rise.sum(axis=1)
    return found


def tensions_by_acceleration(held: Equilibrium, linear: Linearisation) -> Array:
    """Return by how much tensions (N, m) change with an acceleration in the worst direction, N per m/s^2."""
    unit = np.broadcast_to(np.eye(3), (len(linear.stiffness), 3, 3))
    return np.asarray(np.linalg.norm(_effects(held, linear, unit)[1], axis=2))


def _effects(held: Equilibrium, linear: Linearisation, accelerations: Array) -> tuple[Array, Array]:
    """Return the motion (N, n, a) of the platform and the changes of tensions (N, m, a), N, by *accelerations*."""
    robot, wrenches = held.model.robot, _wrenches(held, accelerations)
    hung = list(robot.hung)
    if not hung:
        motion = linear.motion_under(wrenches)
        return motion, tension_changes(held).following(motion)
    root = counterweight_root(robot, stiffness(held))  # (N, c, n)
    rising = root[..., :3] @ np.swapaxes(accelerations, 1, 2)  # (N, c, a), times the root of the mass
    motion = linear.motion_under(wrenches - np.swapaxes(root, 1, 2) @ rising)
    changes = tension_changes(held).following(motion)
    masses, cables = np.array([[robot.lines[i].counterweight, robot.lines[i].cables] for i in hung], np.float64).T
    changes[:, hung] += (np.sqrt(masses) / cables)[:, None] * rising
    return motion, changes


def _wrenches(held: Equilibrium, accelerations: Array) -> Array:
    """Wrenches of inertia (N, n, a) on the platform: -m a at its centre of mass, which is taken about its origin."""
    platform = held.model.robot.platform
    force = -platform.mass * np.swapaxes(accelerations, 1, 2)
    if not isinstance(platform, RigidPlatform):
        return np.asarray(force)
    arm = matrices(held.pose[:, 3:]) @ np.asarray(platform.centre_of_mass)
    return np.concatenate([force, np.cross(arm[:, :, None], force, axis=1)], axis=1)
