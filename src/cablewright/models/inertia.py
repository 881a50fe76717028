"""The mass matrix of the platform at a pose."""

from __future__ import annotations

from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.kernels.motion.inertia import push
from cablewright.models.rotation import matrices
from cablewright.models.statics import Equilibrium
from cablewright.models.stiffness import Stiffness, along_chords, stiffness
from cablewright.robot import RigidPlatform, Robot

LEAST_ARM: Final = 0.01
"""Least distance of a platform's mass from its centre, m, where its inertia is assumed."""


def mass_matrix(robot: Robot, poses: Array) -> Array:
    """Return the mass matrix M (..., n, n) of the platform at *poses* (..., n): kg, kg m and kg m^2 by blocks.

    With v the velocity of the platform's origin and the angular velocity, world, v^T M v / 2 is the kinetic energy.
    Cables, sheaves, winches and counterweights are massless here. Raises `InputError` for a body of unknown inertia.
    """
    root = mass_root(robot, poses)
    return np.asarray(np.swapaxes(root, -1, -2) @ root)


def mass_root(robot: Robot, poses: Array) -> Array:
    """Return S (..., n, n) with M = S^T S, M the mass matrix, at *poses* (..., n).

    The first three rows give the square root of the mass times the velocity of the centre of mass, the last three the
    symmetric root of the inertia tensor, world, times the angular velocity. Raises `InputError` as `mass_matrix`.
    """
    platform, n = robot.platform, robot.n
    root = np.zeros((*poses.shape[:-1], n, n))
    root[..., range(3), range(3)] = np.sqrt(platform.mass)
    if isinstance(platform, RigidPlatform):
        turn = matrices(poses[..., 3:])
        centre = turn @ np.asarray(platform.centre_of_mass)  # from the origin, world
        root[..., :3, 3:] = -np.sqrt(platform.mass) * _crossed(centre)
        root[..., 3:, 3:] = turn @ _inertia_root(robot.name, platform) @ np.swapaxes(turn, -1, -2)
    return root


def compensates(robot: Robot) -> bool:
    """Return whether lengths can hold the platform of a *robot* on its path while it accelerates.

    They cannot with fewer winches than degrees of freedom, whose platform moves as it swings; nor, to the model here,
    with counterweights, which accelerate too.
    """
    return robot.winches >= robot.freedoms and not robot.hung


def inertia_wrenches(robot: Robot, poses: Array, accelerations: Array, rates: Array | None = None) -> Array:
    """Return the inertial wrenches (k, 6) on the platform at *poses* (k, n): N and N m, world.

    *accelerations* (k, 3): m/s^2, of the platform, which does not turn; or (k, 6), of its origin and angular, rad/s^2,
    with its angular velocities *rates* (k, 3), rad/s (Newton and Euler). Moments are about the platform's origin.
    Raises `InputError` as `mass_matrix` for a body that turns.
    """
    platform, found = robot.platform, np.zeros((len(poses), 6))
    if rates is not None and isinstance(platform, RigidPlatform):
        mass = mass_matrix(robot, poses)
        centre = matrices(poses[:, 3:]) @ np.asarray(platform.centre_of_mass)
        pull = platform.mass * np.cross(rates, np.cross(rates, centre))
        about_centre = mass[:, 3:, 3:] + platform.mass * _crossed(centre) @ _crossed(centre)
        spin = np.cross(rates, (about_centre @ rates[..., None])[..., 0])
        found[:] = -(mass @ accelerations[..., None])[..., 0]
        found -= np.concatenate([pull, np.cross(centre, pull) + spin], axis=1)
        return found
    if isinstance(platform, RigidPlatform):
        moved, centre = np.array(accelerations[:, :3], order="C"), np.array(platform.centre_of_mass)
        push(np.array(poses, order="C"), moved, platform.mass, centre, found)
    else:
        found[:, :3] = -platform.mass * accelerations[:, :3]
    return found


def _crossed(vectors: Array) -> Array:
    """Return the matrices (..., 3, 3) of the cross products of *vectors* (..., 3)."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(*x.shape, 3, 3)


def counterweight_root(robot: Robot, parts: Stiffness) -> Array:
    """Return R (..., c, n): c counterweights add R^T R to the mass matrix of the platform.

    *parts*: parts of the stiffness at those poses. Each rises by the length that its line gains between its ends, as if
    the cable did not stretch.
    """
    hung = list(robot.hung)
    masses = np.array([robot.lines[i].counterweight for i in hung], dtype=np.float64)
    spans = np.array([robot.lines[i].advantage for i in hung], dtype=np.float64)
    directions = along_chords(robot.n, parts.chords[..., hung, :], parts.arms[..., hung, :])
    return np.asarray((np.sqrt(masses) * spans)[:, None] * directions)


def moving_masses(robot: Robot, held: Equilibrium) -> tuple[Array, Array]:
    """Return the mass matrix (k, n, n) with counterweights at k solved poses, and the pull of their acceleration.

    The second (k, m, n) is the change of tensions at the sheaves, N, per acceleration of the platform, m/s^2 and
    rad/s^2, with its pose held. Raises `InputError` as `mass_matrix`.
    """
    mass = mass_matrix(robot, held.pose)
    pulled = np.zeros((len(mass), robot.m, robot.n))
    if hung := list(robot.hung):
        root = counterweight_root(robot, stiffness(held))
        weights = np.array([robot.lines[i].counterweight for i in hung], np.float64)
        cables = np.array([robot.lines[i].cables for i in hung], np.float64)
        mass = mass + np.swapaxes(root, 1, 2) @ root
        pulled[:, hung] = (np.sqrt(weights) / cables)[:, None] * root
    return mass, pulled


def with_inertia(robot: Robot) -> Robot:
    """Return the robot with an assumed inertia where it has a body of unknown inertia, else itself.

    Its mass counts in equal parts at its platform points, and the mean of the three moments about the centre of mass
    for each axis.
    """
    platform = robot.platform
    if not isinstance(platform, RigidPlatform) or platform.inertia is not None:
        return robot
    arms = np.array([line.platform_point for line in robot.lines]) - np.asarray(platform.centre_of_mass)
    moment = 2.0 / 3.0 * platform.mass * max(float((arms * arms).sum(axis=1).mean()), LEAST_ARM**2)
    return robot.with_platform(inertia=(moment, moment, moment))


def _inertia_root(name: str, platform: RigidPlatform) -> Array:
    """Return the symmetric root (3, 3) of the inertia tensor about the centre of mass, platform frame."""
    if platform.inertia is None:
        raise InputError(f"robot {name!r}: platform.inertia is required for modes: [Ixx, Iyy, Izz], kg m^2")
    (xx, yy, zz), (xy, xz, yz) = platform.inertia, platform.inertia_products
    values, vectors = np.linalg.eigh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return np.asarray((vectors * np.sqrt(values)) @ vectors.T)
