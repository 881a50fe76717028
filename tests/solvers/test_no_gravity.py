"""Robots that no weight loads: lines pull against one another, and rigid lengths are geometry."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from scipy.optimize import linprog, minimize

from cablewright.foundation.errors import InputError, Status
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Model
from cablewright.robot import Robot, load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.linearise import linearise
from oracles import tangent

STIFFNESS = 1e5  # N
LEAST, MOST = 5.0, 200.0  # N
CORNERS = np.array(list(product((-2.0, 2.0), (-2.0, 2.0), (0.0, 3.0))))


def floating(gravity: float = 0.0, least: float = LEAST, force: tuple[float, ...] = (0, 0, 0), lines: int = 8) -> Robot:
    """A point between lines from the corners of a box."""
    return Robot.model_validate(
        {
            "name": "floating",
            "scene": {"frame_min": (-9,) * 3, "frame_max": (9,) * 3, "gravity": gravity},
            "platform": {"mass": 5, "force": force},
            "lines": [
                {
                    "name": f"line {i}",
                    "exit_point": tuple(corner),
                    "cable": {"axial_stiffness": STIFFNESS, "linear_density": 0.01, "breaking_load": 1e5},
                    "sheave": {"kind": "eyelet"},
                    "tension_limits": (least, MOST),
                }
                for i, corner in enumerate(CORNERS[:lines])
            ],
        }
    )


def places(reach: float, count: int = 60) -> np.ndarray:
    return np.random.default_rng(1).uniform([-reach, -reach, 1.5 - reach], [reach, reach, 1.5 + reach], (count, 3))


@pytest.mark.parametrize("force", [(0, 0, 0), (30, -5, 10)])
def test_yes_and_no_are_those_of_a_linear_program(force: tuple[float, ...]) -> None:
    poses = places(2.4, 200)
    found = solve_inverse(Model(floating(force=force), Fidelity(CableLaw.RIGID)), poses)
    possible = []
    for pose in poses:
        pulls = (CORNERS - pose) / np.linalg.norm(CORNERS - pose, axis=1)[:, None]
        program = linprog(np.ones(8), A_eq=pulls.T, b_eq=-np.array(force, float), bounds=[(LEAST, MOST)] * 8)
        possible.append(program.status == 0)
    assert 20 < sum(possible) < 180
    np.testing.assert_array_equal(found.ok, possible)
    assert {status for status in found.status if status is not Status.OK} == {Status.INFEASIBLE}
    assert found[found.ok].is_valid()


@pytest.mark.parametrize("cable", [CableLaw.ELASTIC, CableLaw.CATENARY])
def test_the_platform_rests_where_the_energy_is_least(cable: CableLaw) -> None:
    model = Model(floating(force=(3, 0, 1)), Fidelity(cable))
    held = solve_inverse(model, places(1.2, 20)).checked()
    lengths = held.lengths + np.random.default_rng(2).uniform(-2e-4, 2e-4, held.lengths.shape)
    found = solve_forward(model, lengths).checked()
    for own, pose in zip(lengths, found.pose, strict=True):

        def energy(x: np.ndarray, own: np.ndarray = own) -> float:
            stretch = np.maximum(np.linalg.norm(CORNERS - x, axis=1) - own, 0.0)
            return float((0.5 * STIFFNESS * stretch**2 / own).sum() - 3.0 * x[0] - x[2])

        rest = minimize(energy, pose + 1e-3, method="Nelder-Mead", options={"xatol": 1e-11, "fatol": 1e-16})
        np.testing.assert_allclose(pose, rest.x, atol=1e-8)


def test_it_is_the_limit_of_little_gravity() -> None:
    poses = places(1.2)
    none, little = (solve_inverse(Model(floating(gravity)), poses).checked() for gravity in (0.0, 1e-9))
    np.testing.assert_allclose(none.lengths, little.lengths, atol=1e-9)
    np.testing.assert_allclose(none.tensions, little.tensions, rtol=1e-8)
    np.testing.assert_allclose(linearise(none).stiffness, linearise(little).stiffness, rtol=1e-6, atol=1e-3)


@pytest.mark.parametrize("more", [1e-3, 0.1, 1.0])
def test_lines_that_are_all_slack_hold_nothing(more: float) -> None:
    model = Model(floating())
    held = solve_inverse(model, [0.3, 0.2, 1.1]).checked()
    for guess in (None, held.pose):
        assert not solve_forward(model, held.lengths + more, guess=guess).ok


def test_what_nothing_decides_is_rejected() -> None:
    with pytest.raises(InputError, match="gravity = 0, no external force: a line's tension_limits must begin above 0"):
        solve_inverse(Model(floating(least=0.0)), [0.0, 0.0, 1.5])
    with pytest.raises(
        InputError, match="gravity = 0, no external force: 2 lines leave degrees of freedom undetermined"
    ):
        solve_inverse(Model(floating(lines=2)), [np.nan, 0.0, 1.5])
    assert solve_inverse(Model(floating(least=0.0, force=(1, 0, 0))), [0.0, 0.0, 1.5]).ok


@pytest.mark.parametrize("name", ["merlet2023", "house-printer", "wang2021", "cogiro", "jung2020"])
def test_rigid_lengths_are_geometry_at_any_pose(name: str) -> None:
    """Tensions hold the platform at few of these places; the oracle knows nothing of tensions."""
    robot = load(name)
    low, high = np.array(robot.scene.frame_min), np.array(robot.scene.frame_max)
    poses = np.random.default_rng(3).uniform(low - 0.3 * (high - low), high + 0.5 * (high - low), (60, 3))
    found = solve_inverse(Model(robot, Fidelity(CableLaw.RIGID)), poses)
    assert (~found.ok).sum() > 10
    for i, line in enumerate(robot.lines):
        if line.sheave.kind == "universal-joint":
            continue
        for pose, length in zip(poses, found.lengths[:, i], strict=True):
            point = pose + np.array(line.platform_point)
            assert length == pytest.approx(tangent.length(line, tangent.straight(line, point)), abs=1e-9)


def test_below_a_swivel_rigid_lengths_are_known_too() -> None:
    """Whichever way the sheave faces, the length is the same."""
    robot = load("merlet2023")
    line = robot.lines[0]
    model = Model(robot, Fidelity(CableLaw.RIGID))
    under = np.array(line.exit_point) - [0.0, 0.0, 1.0]
    found, beside = solve_inverse(model, under), solve_inverse(model, under + 1e-9)
    assert found.status is beside.status is Status.INFEASIBLE
    assert found.lengths[0] == pytest.approx(beside.lengths[0], abs=1e-8)


def test_lengths_that_tensions_decide_are_not_given() -> None:
    robot = load("paty2021")
    assert {line.sheave.kind for line in robot.lines} == {"universal-joint"}
    far = solve_inverse(Model(robot, Fidelity(CableLaw.RIGID)), np.array(robot.scene.frame_max) * [3, 3, 1])
    assert not far.ok
    assert np.isnan(far.lengths).all()
    hung = solve_inverse(Model(load("merlet2023")), [0.0, 0.0, 9.0])  # cables that stretch
    assert not hung.ok
    assert np.isnan(hung.states).any() == np.isnan(hung.lengths).any()
