"""What the lines put on their brackets, from the statics: as built, and with the joint's second rotation blocked.

With the universal joint the lever finds its angle and the head carries no moment about either axis. In the conventional
design splines hold the lever level: it turns about the vertical axis alone, and the head carries a moment about the
pin.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cablewright.arrays import Array
from cablewright.errors import InputError
from cablewright.models.fidelity import Fidelity, SheaveLaw
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot, UniversalJoint
from cablewright.solvers.inverse import solve_inverse

UNIVERSAL_JOINT, CONVENTIONAL = "universal_joint", "conventional"
DESIGNS = (UNIVERSAL_JOINT, CONVENTIONAL)

_PASSES = 20  # of the few that a platform needs whose pose gravity completes
_SETTLED = 1e-9  # m


@dataclass(frozen=True, eq=False)
class Loads:
    """The loads of N poses on the brackets of m lines, of one design.

    `held`: the equilibrium, a batch. Of each pose and line: `azimuth` of the line's plane and `lever_angle` above the
    level, rad; `centre`, `leaving` and `entering` (N, m, 3): the sheave's centre and where the free and the dead span
    touch it, m, world; `free` and `dead`, how those pull there, N, world; `weight` (m,), N, which acts at `mass_centre`
    (N, m, 3). Everything is NaN where a pose has no solution.
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
        """(N, m, 3) what both spans put on the sheave, N, world: Paty 2021, Eq. 4."""
        return self.free + self.dead

    @property
    def force(self) -> Array:
        """(N, m, 3) what lever and spans put on the joint, N, world."""
        down = np.zeros(self.free.shape)
        down[..., 2] = -self.weight
        return self.sheave_force + down

    @property
    def moment(self) -> Array:
        """(N, m, 3) about the joint, N m, world."""
        down = np.zeros(self.free.shape)
        down[..., 2] = -self.weight
        return np.cross(self.centre - self.joint, self.sheave_force) + np.cross(self.mass_centre - self.joint, down)

    @property
    def pin_moment(self) -> Array:
        """(N, m) about the pin, where the universal joint carries nothing, N m: positive lifts the sheave."""
        pin = np.stack([np.sin(self.azimuth), -np.cos(self.azimuth), np.zeros_like(self.azimuth)], axis=-1)
        return np.asarray((self.moment * pin).sum(axis=-1))

    @property
    def spindle_moment(self) -> Array:
        """(N, m) about the vertical axis, N m."""
        return self.moment[..., 2]

    def on_base(self, about: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
        """Wrench (N, m, 6) of the head on the base, N and N m, about a place (3,), all in the bracket's frame."""
        turned = np.stack([_level(each, facings(self.held.model.robot)) for each in (self.force, self.moment)])
        arm = np.broadcast_to(-np.asarray(about, dtype=np.float64), turned[0].shape)
        return np.concatenate([turned[0], turned[1] + np.cross(arm, turned[0])], axis=-1)

    def on_cheek(self) -> Array:
        """(N, m, 4) the load of each of two cheeks by `LEVER_CASES`: the axle's force and its own weight, N.

        What is heavy in lever and sheave is taken to be in the middle of the lever, or in the axle, so that the mass
        centre is where it is.
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
        """World vectors (N, m, 3) as (outward, up) of each line's plane, (N, m, 2)."""
        out = vectors[..., 0] * np.cos(self.azimuth) + vectors[..., 1] * np.sin(self.azimuth)
        return np.stack([out, vectors[..., 2]], axis=-1)


def loads_at(model: Model, poses: ArrayLike, *, retraction: ArrayLike | None = None) -> tuple[Loads, Loads]:
    """The loads at *poses* (N, n) of both designs, as in `DESIGNS`, each with its own tensions.

    Raises `InputError` for sheaves that are not on universal joints.
    """
    joints(model.robot)
    built = Model(model.robot, Fidelity(model.fidelity.cable), model.tension_limits)
    held = solve_inverse(built, poses, retraction=retraction)
    blocked = Model(model.robot, Fidelity(model.fidelity.cable, SheaveLaw.SWIVEL), model.tension_limits)
    return _loads(UNIVERSAL_JOINT, held), _loads(CONVENTIONAL, _blocked(blocked, held, poses, retraction))


def joints(robot: Robot) -> tuple[UniversalJoint, ...]:
    """The sheaves of all lines. Raises `InputError` where one is not on a universal joint."""
    for line in robot.lines:
        if not isinstance(line.sheave, UniversalJoint):
            kind = line.sheave.kind
            raise InputError(f"line {line.name!r}: sheave.kind = {kind!r}: a bracket has a lever: 'universal-joint'")
    return tuple(line.sheave for line in robot.lines if isinstance(line.sheave, UniversalJoint))


def facings(robot: Robot) -> Array:
    """(m,) azimuth that each bracket faces, rad: the sheave's `facing`, or the middle of the frame."""
    middle = 0.5 * (np.array(robot.scene.frame_min) + np.array(robot.scene.frame_max))
    found = []
    for line, joint in zip(robot.lines, joints(robot), strict=True):
        away = middle - np.array(line.exit_point)
        found.append(np.arctan2(away[1], away[0]) if joint.facing is None else joint.facing)
    return np.array(found)


def _blocked(model: Model, built: Equilibrium, poses: ArrayLike, retraction: ArrayLike | None) -> Equilibrium:
    """The equilibrium with level levers: swivels whose axes are so far out that the sheaves are at the levers' ends.

    A swivel's centre is one radius from its axis, towards the platform. The dead span hangs plumb from its sheave.
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
    """(N, m) of the vertical plane from exit point to platform point, rad."""
    away = held.platform_points[..., :2] - exits[:, :2]
    return np.arctan2(away[..., 1], away[..., 0])


def _loads(design: str, held: Equilibrium) -> Loads:
    """Contact points and forces in each line's vertical plane, by the conventions of `kernels/statics/sheave.py`."""
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


def _level(vectors: Array, azimuths: Array) -> Array:
    """World *vectors* (N, m, 3) in frames that are turned by *azimuths* (m,) about z."""
    c, s = np.cos(azimuths), np.sin(azimuths)
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.stack([c * x + s * y, c * y - s * x, z], axis=-1)
