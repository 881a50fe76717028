"""The one linearisation: symmetric as far as statics allows, and the derivative that differences see."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import cases
from cablewright.models.fidelity import CableLaw, Fidelity, SheaveLaw
from cablewright.models.statics import Model
from cablewright.robot import Robot, load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.linearise import linearise
from oracles import linear

MODELS = list(cases.models(CableLaw.ELASTIC, CableLaw.CATENARY))
STEP = 2e-6  # m: less than the step that slackens a line at its lowest tension


def relative_asymmetry(model: Model) -> float:
    stiffness = linearise(cases.poses(model, 50)).stiffness
    skew = np.abs(stiffness - stiffness.transpose(0, 2, 1)).max(axis=(1, 2))
    return float((skew / np.abs(stiffness).max(axis=(1, 2))).max())


def with_elastic_arcs(model: Model) -> Model:
    return Model(cases.replaced(model.robot, model.robot.name, arc_elastic=True), model.fidelity)


@pytest.mark.parametrize("model", MODELS, ids=cases.name)
def test_stiffness_is_symmetric_where_statics_is_conservative(model: Model) -> None:
    if model.fidelity.sheave == "eyelet":
        assert relative_asymmetry(model) < 1e-9
    elif model.fidelity.cable is CableLaw.ELASTIC:
        assert relative_asymmetry(with_elastic_arcs(model)) < 1e-9
    else:  # the cable on the sheave has no weight, though its ends differ in height
        assert relative_asymmetry(with_elastic_arcs(model)) < 1e-7
        # the papers' rigid arc turns strained cable into unstrained: reported, not hidden
        assert relative_asymmetry(model) < 1e-3


@pytest.mark.parametrize("model", MODELS, ids=cases.name)
def test_stiffness_is_positive_and_motions_are_differences(model: Model) -> None:
    held = cases.poses(model, 3)
    linear = linearise(held)
    assert (np.linalg.eigvalsh(0.5 * (linear.stiffness + linear.stiffness.transpose(0, 2, 1))) > 0).all()
    for row in range(3):
        pose, lengths = held.pose[row], held.lengths[row]
        for i in range(model.m):
            unit = np.eye(model.m)[i]

            def moved(by: float) -> np.ndarray:
                found = solve_forward(model, lengths + by * unit, guess=pose)  # noqa: B023
                return motion_between(pose, found.checked().pose)  # noqa: B023

            def softened(by: float) -> np.ndarray:
                factors = 1 + 500 * by * unit  # noqa: B023
                found = solve_forward(model, lengths, guess=pose, modulus_factors=factors)  # noqa: B023
                return motion_between(pose, found.checked().pose)  # noqa: B023

            assert_derivative(moved, linear.per_length[row, :, i])
            assert_derivative(softened, 500 * linear.per_modulus[row, :, i])
    for axis in range(3):

        def shifted(by: float) -> np.ndarray:
            robot = with_exit_moved(model.robot, 1, axis, by)  # noqa: B023
            found = solve_forward(Model(robot, model.fidelity), held.lengths[0], guess=held.pose[0])
            return motion_between(held.pose[0], found.checked().pose)

        assert_derivative(shifted, linear.per_exit_point[0, :, 1, axis])


def motion_between(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Motion (n,) from one pose to another: m, and for a body the rotation vector in space, rad."""
    way = end[:3] - start[:3]
    if len(start) == 3:
        return way
    turn = Rotation.from_rotvec(end[3:]) * Rotation.from_rotvec(start[3:]).inv()
    return np.concatenate([way, turn.as_rotvec()])


def with_exit_moved(robot: Robot, line: int, axis: int, by: float) -> Robot:
    """One exit point moved; its winch exit follows sideways, not in height."""
    step = np.eye(3)[axis] * by
    old = robot.lines[line]
    update: dict[str, object] = {"exit_point": tuple(np.array(old.exit_point) + step)}
    if old.winch_exit is not None and axis < 2:
        update["winch_exit"] = tuple(np.array(old.winch_exit) + step)
    lines = list(robot.lines)
    lines[line] = old.model_copy(update=update)
    return robot.model_copy(update={"lines": tuple(lines)})


def assert_derivative(function, wanted: np.ndarray) -> None:
    """Fourth-order central difference; rounding leaves about 1e-8."""
    far, near = function(2 * STEP) - function(-2 * STEP), function(STEP) - function(-STEP)
    difference = (8 * near - far) / (12 * STEP)
    np.testing.assert_allclose(wanted, difference, rtol=2e-6, atol=2e-7)


def test_motion_per_length_is_against_the_line() -> None:
    """Paying out a line lets the point that it is tied to go away from its exit point."""
    for model in cases.models(CableLaw.CATENARY):
        held = cases.poses(model, 10)
        motion = linearise(held).per_length
        points = held.platform_points
        for i, line in enumerate(model.robot.lines):
            gone = motion[:, :3, i]
            if model.n == 6:
                gone = gone + np.cross(motion[:, 3:, i], points[:, i] - held.pose[:, :3])
            away = points[:, i] - np.asarray(line.exit_point)
            assert (np.einsum("rk,rk->r", gone, away) > 0).all(), (cases.name(model), line.name)


@pytest.mark.parametrize("name", ["cogiro", "jung2020"])
def test_a_moment_held_in_space_is_all_that_unbalances_the_stiffness(name: str) -> None:
    """A moment M that does not turn with the body keeps no energy: K - K^T = -[M]x between rotations."""
    x, y, z = moment = (0.9, -1.3, 0.6)
    model = Model(load(name).under_wrench((5.0, -3.0, 2.0), moment), Fidelity(sheave=SheaveLaw.EYELET))
    stiffness = linearise(cases.poses(model, 20)).stiffness
    wanted = np.zeros((6, 6))
    wanted[3:, 3:] = [[0, z, -y], [-z, 0, x], [y, -x, 0]]
    skew = stiffness - stiffness.transpose(0, 2, 1)
    np.testing.assert_allclose(skew, np.broadcast_to(wanted, skew.shape), atol=1e-9 * np.abs(stiffness).max())


BODIES = [model for model in map(Model, cases.robots()) if model.n == 6]


@pytest.mark.parametrize("model", BODIES, ids=cases.name)
def test_stiffness_and_motion_are_the_oracles(model: Model) -> None:
    """With 50 digits, by differences of the independent equations: they share nothing but the description."""
    row = cases.poses(model, 1)[0]
    answer, states = linearise(row), cases.line_states(row)
    exact = linear.stiffness(model.robot, row.lengths, row.pose, states)
    np.testing.assert_allclose(answer.stiffness, exact, rtol=0, atol=1e-10 * np.abs(exact).max())
    exact = linear.motion(model.robot, row.lengths, row.pose, states)
    np.testing.assert_allclose(answer.per_length, exact, rtol=0, atol=1e-10 * np.abs(exact).max())
