"""Loads of the lines on their brackets, from the statics, for two designs.

With the universal joint the lever finds its angle, and the head carries no moment about either axis. In the
conventional design splines hold the lever level: it rotates about the vertical axis only, and the head carries a moment
about the pin.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from cablewright.foundation.arrays import Array
from cablewright.models.fidelity import Fidelity, SheaveLaw
from cablewright.models.statics import Equilibrium, Model
from cablewright.models.support_table import Capability, require
from cablewright.robot import Robot, UniversalJoint
from cablewright.solvers.inverse import solve_inverse

UNIVERSAL_JOINT, CONVENTIONAL = "universal_joint", "conventional"
DESIGNS = (UNIVERSAL_JOINT, CONVENTIONAL)

_PASSES = 20  # iterations at most where gravity completes the pose; few are needed
_SETTLED = 1e-9  # m; motion of the exit points at which the iteration ends


@dataclass(frozen=True, eq=False)
class Loads:
    """Loads on the brackets of m lines at N poses, for one design; NaN where a pose has no solution.

    `held`: the equilibria, a batch. For each pose and line: `azimuth` of the line's plane and `lever_angle` above the
    horizontal, rad; `centre`, `leaving` and `entering` (N, m, 3): the sheave's centre and the points where the free and
    the dead span touch it, m, world; `free` and `dead`: the spans' forces there, N, world; `weight` (m,) of the lever,
    N, which acts at `mass_centre` (N, m, 3).
    """

    design: str
    held: Equilibrium
    joint: Array
    azimuth: Array
    lever_angle: Array
    centre: Array
    leaving: Array
    entering: Array
    mass_centre: Array
    free: Array
    dead: Array
    weight: Array

    @property
    def sheave_force(self) -> Array:
        """Force (N, m, 3) of both spans on the sheave, N, world: Paty 2021, Eq. 4."""
        return self.free + self.dead

    @property
    def force(self) -> Array:
        """Force (N, m, 3) of lever and spans on the joint, N, world."""
        return self.sheave_force + self._lever_weight

    @property
    def moment(self) -> Array:
        """Moment (N, m, 3) about the joint, N m, world."""
        weight_moment = np.cross(self.mass_centre - self.joint, self._lever_weight)
        return np.cross(self.centre - self.joint, self.sheave_force) + weight_moment

    @property
    def _lever_weight(self) -> Array:
        """(m, 3) N, world."""
        return np.asarray(self.weight[:, None] * [0.0, 0.0, -1.0])

    @property
    def pin_moment(self) -> Array:
        """(N, m) moment about the pin, 0 with the universal joint, N m; positive lifts the sheave."""
        pin = np.stack([np.sin(self.azimuth), -np.cos(self.azimuth), np.zeros_like(self.azimuth)], axis=-1)
        return np.asarray((self.moment * pin).sum(axis=-1))

    @property
    def spindle_moment(self) -> Array:
        """(N, m) moment about the vertical axis, N m."""
        return self.moment[..., 2]

    def on_base(self, about: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
        """Return the wrench (N, m, 6) on the base, N and N m, about a point (3,), both in the bracket's frame."""
        rotations = frames(self.held.model.robot)
        force, moment = (np.einsum("mij,nmj->nmi", rotations, each) for each in (self.force, self.moment))
        return np.concatenate([force, moment - np.cross(np.asarray(about, dtype=np.float64), force)], axis=-1)

    def on_cheek(self) -> Array:
        """Return the load (N, m, 4) on each of two cheeks by `LEVER_CASES`: the axle's force and its own weight, N.

        The mass of lever and sheave is divided between the middle of the lever and the axle so that its centre is kept.
        """
        robot = self.held.model.robot
        levers, arms = (np.array([getattr(j, key) for j in joints(robot)]) for key in ("lever", "lever_mass_centre"))
        in_middle = self.weight * np.where(arms > 0.5 * levers, 2.0 - 2.0 * arms / levers, 2.0 * arms / levers)
        at_axle = self.weight * np.where(arms > 0.5 * levers, 2.0 * arms / levers - 1.0, 0.0)
        along, across = np.cos(self.lever_angle), np.sin(self.lever_angle)
        level, up = np.moveaxis(self.in_plane(self.sheave_force), -1, 0)
        up = up - at_axle
        axle = np.stack([level * along + up * across, up * along - level * across], axis=-1)
        own = np.stack([-in_middle * across, -in_middle * along], axis=-1)
        return 0.5 * np.concatenate([axle, own], axis=-1)

    def in_plane(self, vectors: Array) -> Array:
        """Return world vectors (N, m, 3) as (outward, up) in each line's plane, (N, m, 2)."""
        out = vectors[..., 0] * np.cos(self.azimuth) + vectors[..., 1] * np.sin(self.azimuth)
        return np.stack([out, vectors[..., 2]], axis=-1)


def loads_at(model: Model, poses: ArrayLike, *, retraction: ArrayLike | None = None) -> tuple[Loads, Loads]:
    """Return the loads at *poses* (N, n) for both `DESIGNS`, each with its own tensions; *retraction*, m.

    Raises `InputError` for sheaves without universal joints.
    """
    joints(model.robot)
    built = Model(model.robot, Fidelity(model.fidelity.cable), model.tension_limits)
    held = solve_inverse(built, poses, retraction=retraction)
    blocked = Model(model.robot, Fidelity(model.fidelity.cable, SheaveLaw.SWIVEL), model.tension_limits)
    return _loads(UNIVERSAL_JOINT, held), _loads(CONVENTIONAL, _blocked(blocked, held, poses, retraction))


def joints(robot: Robot) -> tuple[UniversalJoint, ...]:
    """Return the sheaves of all lines. Raises `InputError` if a sheave is not on a universal joint."""
    require(robot, Capability.BRACKET)
    return tuple(line.sheave for line in robot.lines if isinstance(line.sheave, UniversalJoint))


def facings(robot: Robot) -> Array:
    """Return the azimuth (m,) that each bracket faces, rad: the sheave's `facing`, or towards the frame's middle."""
    given = np.array([joint.facing for joint in joints(robot)], dtype=np.float64)  # None becomes NaN
    middle = 0.5 * (np.array(robot.scene.frame_min) + np.array(robot.scene.frame_max))
    away = middle - np.array([line.exit_point for line in robot.lines])
    return np.where(np.isnan(given), np.arctan2(away[:, 1], away[:, 0]), given)


def frames(robot: Robot) -> Array:
    """Return the rotations (m, 3, 3) from the world's axes to those of each bracket."""
    return np.asarray(Rotation.from_euler("z", -facings(robot)[:, None]).as_matrix())


def _blocked(model: Model, built: Equilibrium, poses: ArrayLike, retraction: ArrayLike | None) -> Equilibrium:
    """The equilibrium with level levers, modelled as swivels with their axes moved outwards.

    A swivel's centre is one radius from its axis, towards the platform; the axes are moved so that the sheaves are at
    the ends of the levers. The dead span hangs vertically from its sheave.
    """
    out = np.array([joint.lever - joint.radius for joint in joints(model.robot)])
    exits = np.array([line.exit_point for line in model.robot.lines])
    held, moved = built, np.full((len(built.pose), *exits.shape), np.inf)
    for _ in range(_PASSES):
        azimuth = _azimuth(held, exits)
        aside = out[:, None] * np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
        before, moved = moved, np.broadcast_to(exits, (len(azimuth), *exits.shape)).copy()
        moved[..., :2] += aside
        held = solve_inverse(model, poses, retraction=retraction, exit_points=moved)
        if model.m >= model.n or not np.nanmax(np.abs(moved - before), initial=0.0) > _SETTLED:
            break
    return held


def _azimuth(held: Equilibrium, exits: Array) -> Array:
    """Azimuth (N, m) of the vertical plane through exit point and platform point, rad."""
    away = held.platform_points[..., :2] - exits[:, :2]
    return np.arctan2(away[..., 1], away[..., 0])


def _loads(design: str, held: Equilibrium) -> Loads:
    """Contact points and forces in each line's vertical plane, as in `kernels/statics/line/sheave.py`."""
    robot = held.model.robot
    exits = np.array([line.exit_point for line in robot.lines])
    levers, radii, weights, arms = (
        np.array([getattr(joint, key) for joint in joints(robot)])
        for key in ("lever", "radius", "lever_weight", "lever_mass_centre")
    )
    azimuth = np.where(held.ok[:, None], _azimuth(held, exits), np.nan)
    phi, psi = held.line_states.free_angle, held.line_states.dead_angle
    beta = np.where(held.ok[:, None], held.line_states.lever_angle, np.nan)
    turn = held.lines.side * radii

    def world(out: Array, up: Array) -> Array:
        return np.stack([out * np.cos(azimuth), out * np.sin(azimuth), up], axis=-1)

    lever = world(np.cos(beta), np.sin(beta))
    centre = exits + levers[:, None] * lever
    tensions = held.tensions
    return Loads(
        design,
        held,
        np.broadcast_to(exits, centre.shape),
        azimuth,
        beta,
        centre,
        centre + world(-turn * np.sin(phi), turn * np.cos(phi)),
        centre + world(turn * np.sin(psi), -turn * np.cos(psi)),
        exits + arms[:, None] * lever,
        world(tensions * np.cos(phi), tensions * np.sin(phi)),
        world(tensions * np.cos(psi), tensions * np.sin(psi)),
        weights,
    )
