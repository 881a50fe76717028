"""Laws without numbers: symmetry, scaling, limits at their rates, and reciprocity of work."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import cases
from cablewright.models.fidelity import CableLaw, Fidelity, SheaveLaw
from cablewright.models.statics import Model
from cablewright.robot import Robot, UniversalJoint, load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse

BUILT = [Model(robot) for robot in cases.robots()]


def transformed(robot: Robot, matrix: np.ndarray) -> Robot:
    """*robot* in a world turned or mirrored by *matrix* (3, 3); swing limits, which have a facing, left out.

    A turned body is the same in its own frame; a mirrored one is mirrored in it.
    """
    mirrored = np.linalg.det(matrix) < 0
    within = matrix if mirrored else np.eye(3)  # of the platform's frame
    lines = []
    for line in robot.lines:
        update: dict[str, object] = {
            "exit_point": tuple(matrix @ line.exit_point),
            "platform_point": tuple(within @ line.platform_point),
        }
        if line.winch_exit is not None:
            update["winch_exit"] = tuple(matrix @ line.winch_exit)
        if line.sheave.kind != "eyelet":
            update["sheave"] = line.sheave.model_copy(update={"facing": None, "swing": None})
        lines.append(line.model_copy(update=update))
    old = robot.platform
    update = {"force": tuple(matrix @ old.force)}
    if robot.n == 6:
        update["centre_of_mass"] = tuple(within @ old.centre_of_mass)
        update["moment"] = tuple((-matrix if mirrored else matrix) @ old.moment)
        update["retraction"] = None
    return robot.model_copy(update={"lines": tuple(lines), "platform": old.model_copy(update=update)})


def transformed_poses(poses: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """*poses* (N, n) in that world: R becomes S R, and mirrored S R S, as the body then is too."""
    places = poses[:, :3] @ matrix.T
    if poses.shape[1] == 3:
        return places
    turns = matrix @ Rotation.from_rotvec(poses[:, 3:]).as_matrix()
    if np.linalg.det(matrix) < 0:
        turns = turns @ matrix
    return np.column_stack([places, Rotation.from_matrix(turns).as_rotvec()])


def left_to_gravity(model: Model, poses: np.ndarray) -> np.ndarray:
    """*poses* with the degrees of freedom that gravity decides left to it, as `cases.random_poses` does."""
    asked = poses.copy()
    if model.n == 6:
        asked[:, 3 : 3 + max(0, model.n - model.m)] = np.nan
    return asked


def assert_same_poses(found: np.ndarray, wanted: np.ndarray, tolerance: float) -> None:
    """Positions to *tolerance* m and rotations to as many rad."""
    np.testing.assert_allclose(found[:, :3], wanted[:, :3], atol=tolerance)
    assert cases.turned(found, wanted).max() < tolerance


@pytest.mark.parametrize("model", BUILT, ids=cases.name)
@pytest.mark.parametrize("kind", ["turned", "mirrored", "permuted"])
def test_a_moved_world_moves_the_solution(model: Model, kind: str) -> None:
    held = cases.poses(model, 20)
    order = np.arange(model.m)
    matrix = np.eye(3)
    if kind == "turned":
        c, s = np.cos(0.7), np.sin(0.7)
        matrix = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    elif kind == "mirrored":
        matrix = np.diag([-1.0, 1.0, 1.0])
    else:
        order = np.roll(order, 1)
    robot = transformed(model.robot, matrix)
    robot = robot.model_copy(update={"lines": tuple(robot.lines[i] for i in order)})
    moved = solve_forward(Model(robot), held.lengths[:, order]).checked()
    wanted = transformed_poses(held.pose, matrix)
    assert_same_poses(moved.pose, wanted, 1e-10)
    np.testing.assert_allclose(moved.tensions, held.tensions[:, order], rtol=1e-7)
    again = solve_inverse(Model(robot), left_to_gravity(model, wanted)).checked()
    assert_same_poses(again.pose, wanted, 1e-9)
    np.testing.assert_allclose(again.lengths, held.lengths[:, order], atol=1e-9)


@pytest.mark.parametrize("model", BUILT, ids=cases.name)
def test_the_same_shape_at_another_size_and_force(model: Model) -> None:
    k, f = 2.5, 7.0
    held = cases.poses(model, 20)
    scaled = Model(rescaled(model.robot, k, f))
    found = solve_forward(scaled, held.lengths * k).checked()
    wanted = held.pose * np.array([k, k, k, 1, 1, 1])[: model.n]
    assert_same_poses(found.pose, wanted, 1e-9)
    np.testing.assert_allclose(found.tensions, held.tensions * f, rtol=1e-7)


def rescaled(robot: Robot, k: float, f: float) -> Robot:
    lines = []
    for line in robot.lines:
        cable = line.cable.model_copy(
            update={
                "young_modulus": None,
                "section": None,
                "axial_stiffness": line.cable.stiffness * f,
                "linear_density": line.cable.linear_density * f / k,
                "breaking_load": line.cable.breaking_load * f,
            }
        )
        sheave = line.sheave
        if sheave.kind != "eyelet":
            sheave = sheave.model_copy(update={"radius": sheave.radius * k})
        if isinstance(sheave, UniversalJoint):
            sheave = sheave.model_copy(
                update={
                    "lever": sheave.lever * k,
                    "lever_mass_centre": sheave.lever_mass_centre * k,
                    "lever_weight": sheave.lever_weight * f,
                }
            )
        update = {
            "exit_point": tuple(k * x for x in line.exit_point),
            "platform_point": tuple(k * x for x in line.platform_point),
            "winch_exit": None if line.winch_exit is None else tuple(k * x for x in line.winch_exit),
            "dead_length": line.dead_length * k,
            "cable": cable,
            "sheave": sheave,
            "tension_limits": tuple(f * t for t in line.tension_limits),
        }
        lines.append(line.model_copy(update=update))
    old = robot.platform
    update = {"mass": old.mass * f, "force": tuple(f * x for x in old.force)}
    if robot.n == 6:
        update["centre_of_mass"] = tuple(k * x for x in old.centre_of_mass)
        update["nozzle"] = tuple(k * x for x in old.nozzle)
        update["moment"] = tuple(f * k * x for x in old.moment)
        update["retraction"] = None
    return robot.model_copy(update={"lines": tuple(lines), "platform": old.model_copy(update=update)})


def with_cables(robot: Robot, weight: float = 1.0, stiffness: float = 1.0) -> Robot:
    lines = tuple(
        line.model_copy(
            update={
                "cable": line.cable.model_copy(
                    update={
                        "linear_density": line.cable.linear_density * weight,
                        "young_modulus": None,
                        "section": None,
                        "axial_stiffness": line.cable.stiffness * stiffness,
                    }
                )
            }
        )
        for line in robot.lines
    )
    return robot.model_copy(update={"lines": lines})


@pytest.mark.parametrize("name", ["merlet2023", "paty2021", "wang2021"])
def test_without_weight_the_catenary_is_the_spring(name: str) -> None:
    robot = load(name)
    elastic = Model(robot, Fidelity(CableLaw.ELASTIC))
    held = cases.poses(elastic, 5)
    gaps = []
    for weight in (1e-4, 1e-5, 1e-6):
        found = solve_forward(Model(with_cables(robot, weight=weight)), held.lengths).checked()
        gaps.append(np.abs(found.pose - held.pose).max())
    assert gaps[0] / gaps[1] == pytest.approx(10, rel=0.05)
    assert gaps[1] / gaps[2] == pytest.approx(10, rel=0.05)


@pytest.mark.parametrize("name", ["merlet2023", "paty2021", "wang2021"])
def test_without_stretch_elastic_lengths_are_the_rigid_ones(name: str) -> None:
    robot = load(name)
    held = cases.poses(Model(robot, Fidelity(CableLaw.RIGID)), 5)
    gaps = []
    for stiffness in (10.0, 100.0, 1000.0):
        stiff = Model(with_cables(robot, stiffness=stiffness), Fidelity(CableLaw.ELASTIC))
        gaps.append(np.abs(solve_inverse(stiff, held.pose).checked().lengths - held.lengths).max())
    assert gaps[0] / gaps[1] == pytest.approx(10, rel=0.02)
    assert gaps[1] / gaps[2] == pytest.approx(10, rel=0.02)


def test_a_small_sheave_is_an_eyelet() -> None:
    robot = load("paty2021")
    eyelet = Model(robot, Fidelity(sheave=SheaveLaw.EYELET))
    held = cases.poses(eyelet, 5)
    gaps = []
    for size in (1e-2, 1e-3, 1e-4):
        sheave = robot.lines[0].sheave.model_copy(
            update={
                "radius": 0.05 * size,
                "lever": 0.104 * size,
                "lever_weight": 6.85 * size,
                "facing": None,
                "swing": None,
            }
        )
        small = Model(cases.replaced(robot, "small", sheave=sheave))
        gaps.append(np.abs(solve_inverse(small, held.pose).checked().lengths - held.lengths).max())
    assert gaps[0] / gaps[1] == pytest.approx(10, rel=0.05)
    assert gaps[1] / gaps[2] == pytest.approx(10, rel=0.05)


def test_a_light_lever_points_along_the_bisector() -> None:
    robot = load("paty2021")
    held = cases.poses(Model(robot, Fidelity(CableLaw.RIGID)), 5)
    gaps = []
    for weight in (1.0, 0.1, 0.01):
        sheave = robot.lines[0].sheave.model_copy(update={"lever_weight": weight, "facing": None, "swing": None})
        light = Model(cases.replaced(robot, "light", sheave=sheave), Fidelity(CableLaw.RIGID))
        phi, psi, beta = solve_inverse(light, held.pose).checked().states[..., [0, 4, 5]].transpose(2, 0, 1)
        gaps.append(np.abs(beta - 0.5 * (phi + psi)).max())
    assert gaps[0] / gaps[1] == pytest.approx(10, rel=0.05)
    assert gaps[1] / gaps[2] == pytest.approx(10, rel=0.05)


@pytest.mark.parametrize("name", ["merlet2023", "off-axis"])
@pytest.mark.parametrize("law", [CableLaw.ELASTIC, CableLaw.CATENARY])
def test_winches_work_reciprocally(name: str, law: CableLaw) -> None:
    """dV/dL = -T (1 + T / 2EA) + w z at the winch exit is a gradient: its derivatives by the lengths are symmetric."""
    robot = next(robot for robot in cases.robots() if robot.name == name)
    model = Model(robot, Fidelity(law, SheaveLaw.EYELET))
    held = cases.poses(model, 3)
    for row in range(3):
        slopes = np.empty((model.m, model.m))
        for i in range(model.m):
            step = np.eye(model.m)[i] * 1e-6
            ends = [solve_forward(model, held.lengths[row] + sign * step).checked() for sign in (-1, 1)]
            force = [-t.winch_tensions * (1 + t.winch_tensions / (2 * robot.lines[0].cable.stiffness)) for t in ends]
            slopes[:, i] = (force[1] - force[0]) / 2e-6
        assert np.abs(slopes - slopes.T).max() < 1e-6 * np.abs(slopes).max()
