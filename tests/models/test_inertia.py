"""The mass matrix: what a cloud of small masses would have, at any pose."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cablewright.foundation.errors import InputError
from cablewright.models.inertia import mass_matrix, mass_root
from cablewright.robot import Robot, load

MASSES = np.array([2.0, 1.0, 3.0, 1.5, 2.5])
POINTS = np.random.default_rng(20).normal(0.3, 0.4, (5, 3))  # m, platform frame
POSES = np.random.default_rng(21).normal(0.0, 0.7, (20, 6))


def cloud() -> Robot:
    """cogiro with the mass, centre and inertia of a few small masses."""
    robot = load("cogiro")
    centre = MASSES @ POINTS / MASSES.sum()
    off = POINTS - centre
    tensor = np.einsum("p,pij->ij", MASSES, np.einsum("pk,pk->p", off, off)[:, None, None] * np.eye(3))
    tensor -= np.einsum("p,pi,pj->ij", MASSES, off, off)
    body = {
        "mass": float(MASSES.sum()),
        "centre_of_mass": tuple(centre.tolist()),
        "inertia": tuple(np.diag(tensor).tolist()),
        "inertia_products": (float(tensor[0, 1]), float(tensor[0, 2]), float(tensor[1, 2])),
    }
    return robot.model_copy(update={"platform": robot.platform.model_copy(update=body)})


def test_kinetic_energy_is_that_of_its_parts() -> None:
    motions = np.random.default_rng(22).normal(size=(20, 6))
    found = 0.5 * np.einsum("pi,pij,pj->p", motions, mass_matrix(cloud(), POSES), motions)
    for pose, motion, energy in zip(POSES, motions, found, strict=True):
        arms = Rotation.from_rotvec(pose[3:]).apply(POINTS)
        speeds = motion[:3] + np.cross(motion[3:], arms)
        assert energy == pytest.approx(0.5 * MASSES @ (speeds**2).sum(axis=1), rel=1e-12)


def test_the_root_sees_the_centre_of_mass() -> None:
    """Its first rows are the velocity of the centre of mass, and do not mix with the rotation's."""
    robot, motion = cloud(), np.array([0.1, -0.2, 0.3, 0.4, 0.5, -0.6])
    for pose in POSES:
        centre = Rotation.from_rotvec(pose[3:]).apply(robot.platform.centre_of_mass)
        speed = motion[:3] + np.cross(motion[3:], centre)
        np.testing.assert_allclose((mass_root(robot, pose) @ motion)[:3], np.sqrt(10.0) * speed, rtol=1e-12)
        assert (mass_root(robot, pose)[3:, :3] == 0).all()


def test_a_point_has_mass_alone() -> None:
    np.testing.assert_allclose(mass_matrix(load("house-printer"), np.zeros((2, 3))), [200.0 * np.eye(3)] * 2)


def test_a_body_without_inertia_is_rejected() -> None:
    robot = load("cogiro")
    bare = robot.platform.model_copy(update={"inertia": None, "inertia_products": (0.0, 0.0, 0.0)})
    with pytest.raises(InputError, match=r"'cogiro': platform\.inertia is required"):
        mass_matrix(robot.model_copy(update={"platform": bare}), np.zeros(6))
