"""A platform in a plane rests where its energy in that plane is least; the plane bears the rest of the load."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import root

import cablewright as cw
import planar_robots
from cablewright.robot import Robot
from oracles import irvine

FORCE = (3.0, -2.0, 4.0)  # N
KINDS = [(plane, body) for plane in planar_robots.PLANES for body in (False, True)]


def pose_at(robot: Robot, q: Any) -> Any:
    """The pose, complex where the coordinates *q* in the plane are: two of the position, and of a body its turn."""
    a, b, n = planar_robots.frame(robot)
    position = q[0] * a + q[1] * b + planar_robots.DISTANCE * n
    return position if robot.n == 3 else np.concatenate([position, q[2] * n])


def coordinates(robot: Robot, pose: np.ndarray) -> np.ndarray:
    a, b, n = planar_robots.frame(robot)
    return np.array([pose[:3] @ a, pose[:3] @ b, *([pose[3:] @ n] if robot.n == 6 else [])])


def turned(robot: Robot, pose: Any, point: Any) -> Any:
    """Where a point of the platform frame is: Rodrigues, for complex angles too."""
    if robot.n == 3:
        return pose[:3] + point
    _, _, n = planar_robots.frame(robot)
    angle, along = pose[3:] @ n, (n @ point) * n
    return pose[:3] + along + np.cos(angle) * (point - along) + np.sin(angle) * np.cross(n, point)


def energy(robot: Robot, lengths: np.ndarray, pose: Any) -> Any:
    """Of elastic lines, weight and force."""
    total = -pose[:3] @ np.array(robot.platform.force)
    centre = np.array(getattr(robot.platform, "centre_of_mass", (0.0, 0.0, 0.0)))
    total = total + robot.platform.mass * robot.scene.gravity * turned(robot, pose, centre)[2]
    for line, own in zip(robot.lines, lengths, strict=True):
        away = turned(robot, pose, np.array(line.platform_point)) - line.exit_point
        stretch = np.sqrt(away @ away) - own
        if stretch.real > 0.0:
            total = total + 0.5 * planar_robots.STIFFNESS * stretch**2 / own
    return total


def hung(plane: str, body: bool, cable: str, count: int, more: float) -> tuple[Robot, cw.Equilibrium]:
    """Platforms on lengths that differ by up to *more* (m) from those that hold them at random places."""
    own = {"force": FORCE} | ({"centre_of_mass": (0.03, 0.02, -0.04)} if body else {})
    robot = planar_robots.board(plane, body, **own)
    held = cw.inverse(robot, planar_robots.places(robot, 3 * count), cable=cable)
    held = held[held.ok][:count]
    assert len(held) == count
    lengths = held.lengths + np.random.default_rng(2).uniform(-more, more, held.lengths.shape)
    return robot, cw.forward(robot, lengths, cable=cable).checked()


@pytest.mark.parametrize("more", [2e-4, 2e-2])  # the longer ones leave lines slack
@pytest.mark.parametrize(("plane", "body"), KINDS)
def test_elastic_lines_rest_where_the_energy_in_the_plane_is_least(plane: str, body: bool, more: float) -> None:
    robot, found = hung(plane, body, "elastic", 6, more)
    if more > 1e-2:
        assert (found.tensions == 0.0).any()
    for lengths, pose in zip(found.lengths, found.pose, strict=True):

        def slope(q: np.ndarray, lengths: np.ndarray = lengths) -> np.ndarray:
            steps = 1e-30j * np.eye(len(q))
            return np.array([energy(robot, lengths, pose_at(robot, q + step)).imag / 1e-30 for step in steps])

        rest = root(slope, coordinates(robot, pose) + 1e-4, tol=1e-14)
        np.testing.assert_allclose(pose, pose_at(robot, rest.x), atol=1e-8)
        assert np.abs(slope(rest.x)).max() < 1e-6


@pytest.mark.parametrize(("plane", "body"), KINDS)
def test_sagging_lines_balance_in_the_plane_and_the_plane_bears_the_rest(plane: str, body: bool) -> None:
    """The spans are Irvine's."""
    robot, found = hung(plane, body, "catenary", 1, 2e-4)
    lengths, n = found.lengths[0], planar_robots.frame(robot)[2]

    def wrench(pose: np.ndarray) -> np.ndarray:
        weight = np.array([0.0, 0.0, -robot.platform.mass * robot.scene.gravity])
        centre = np.array(getattr(robot.platform, "centre_of_mass", (0.0, 0.0, 0.0)))
        total = np.concatenate(
            [weight + robot.platform.force, np.cross(turned(robot, pose, centre) - pose[:3], weight)]
        )
        for i, line in enumerate(robot.lines):
            point = turned(robot, pose, np.array(line.platform_point))
            x, y, z = point - line.exit_point
            w, reach = line.cable.linear_density * robot.scene.gravity, float(np.hypot(x, y))
            tension, phi = float(found.tensions[0, i]), float(found.states[0, i, 0])
            H, V = irvine.start_tension(
                reach, z, lengths[i], w, planar_robots.STIFFNESS, (tension * np.cos(phi), tension * np.sin(phi))
            )
            H, V = float(H), float(V + w * lengths[i])
            force = -np.array([H * x / reach, H * y / reach, V])
            total += np.concatenate([force, np.cross(point - pose[:3], force)])
        return total

    def slope(q: np.ndarray) -> np.ndarray:
        total = wrench(pose_at(robot, q))
        a, b, _ = planar_robots.frame(robot)
        return np.array([total[:3] @ a, total[:3] @ b, *([total[3:] @ n] if body else [])])

    pose = found.pose[0]
    rest = root(slope, coordinates(robot, pose) + 1e-5, tol=1e-12)
    np.testing.assert_allclose(pose, pose_at(robot, rest.x), atol=1e-8)
    carried = wrench(pose)
    assert found.plane_force[0] == pytest.approx(carried[:3] @ n, abs=1e-7)
    if body:
        np.testing.assert_allclose(found.plane_moments[0], carried[3:] - (carried[3:] @ n) * n, atol=1e-7)
    else:
        assert found.plane_moments is None


@pytest.mark.parametrize("cable", ["rigid", "elastic", "catenary"])
@pytest.mark.parametrize(("plane", "body"), KINDS)
def test_without_the_plane_its_reaction_is_a_load(plane: str, body: bool, cable: str) -> None:
    """The least norm in the plane is also that among fewer distributions: those that need no plane."""
    held, loose = (planar_robots.board(plane, body, 8, held=kept) for kept in (True, False))
    found = cw.inverse(held, planar_robots.places(held, 20, 0.4), cable=cable)
    found = found[found.ok]
    assert len(found) > 4
    n = planar_robots.frame(held)[2]
    for row in found:
        moment = (0.0, 0.0, 0.0) if row.plane_moments is None else -row.plane_moments
        free = loose.under_wrench(-row.plane_force * n, moment)
        same = cw.inverse(free, row.pose, cable=cable).checked()
        np.testing.assert_allclose(same.tensions, row.tensions, rtol=1e-7)
        np.testing.assert_allclose(same.lengths, row.lengths, rtol=1e-9)


@pytest.mark.parametrize("cable", ["rigid", "elastic"])
def test_belts_in_the_plane_need_none(cable: str) -> None:
    held, loose = (planar_robots.board("vertical", off=0.0, held=kept) for kept in (True, False))
    poses = planar_robots.places(held, 30)
    found, same = (cw.inverse(robot, poses, cable=cable) for robot in (held, loose))
    np.testing.assert_array_equal(found.code, same.code)
    assert found.ok.sum() > 10
    np.testing.assert_allclose(found.tensions[found.ok], same.tensions[found.ok], rtol=1e-9)
    np.testing.assert_allclose(found.plane_force[found.ok], 0.0, atol=1e-9)
    assert same.plane_force is None


@pytest.mark.parametrize("body", [False, True])
def test_on_a_table_weight_is_the_tables(body: bool) -> None:
    robot = planar_robots.board("horizontal", body)
    light = robot.model_copy(update={"platform": robot.platform.model_copy(update={"mass": 1e-6})})
    poses = planar_robots.places(robot, 20)
    found, same = (cw.inverse(each, poses, cable="elastic").checked() for each in (robot, light))
    np.testing.assert_allclose(found.tensions, same.tensions, rtol=1e-9)
    pressed = (planar_robots.MASS - 1e-6) * 9.81
    np.testing.assert_allclose(found.plane_force - same.plane_force, pressed, rtol=1e-9)  # its normal points down


def test_the_slope_of_the_energy_is_that_of_differences() -> None:
    robot = planar_robots.board("tilted", True)
    lengths, q = np.full(4, 1.2), np.array([0.1, -0.2, 0.05])
    slopes = [energy(robot, lengths, pose_at(robot, q + 1e-30j * unit)).imag / 1e-30 for unit in np.eye(3)]
    for unit, slope in zip(np.eye(3), slopes, strict=True):
        ends = [energy(robot, lengths, pose_at(robot, q + by * unit)) for by in (-1e-6, 1e-6)]
        assert (ends[1] - ends[0]) / 2e-6 == pytest.approx(slope, rel=1e-6)
