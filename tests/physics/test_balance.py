"""Balance against an independent evaluation with 50 digits, taut and slack, and against MuJoCo."""

from __future__ import annotations

import numpy as np
import pytest

import cases
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Model
from cablewright.robot import Robot, Swivel, load
from cablewright.solvers.forward import solve_forward
from oracles import machine, mujoco_model

BUILT = [Model(robot) for robot in cases.robots()]
SLACK = [0.0, 0.001, 0.05, 0.3]
RESTING = ["merlet2023", "paty2021", "wang2021", "house-printer", "cogiro", "jung2020", "grab-four-lines"]


@pytest.mark.parametrize("excess", [SLACK[0], SLACK[-1], *cases.some(SLACK[1:-1], 0)])
@pytest.mark.parametrize("model", BUILT, ids=cases.name)
def test_a_cold_solution_is_the_oracles(model: Model, excess: float) -> None:
    held = cases.poses(model, 3)
    for i, row in enumerate(held):
        lengths = row.lengths.copy()
        lengths[i] += excess
        found = solve_forward(model, lengths)
        assert found.ok, found.sentence()
        states = cases.line_states(found)
        left = machine.balance(model.robot, lengths, found.pose, states)
        weight = model.robot.platform.mass * model.robot.scene.gravity
        assert left.geometry < 1e-9
        assert left.force < 1e-9 * weight
        assert left.turning < 1e-9 * weight  # times a metre
        if i == SLACK.index(excess) % 3:  # of a balance, the pose that solves it is near: a pose of three is enough
            exact = machine.solve(model.robot, lengths, found.pose, states)
            assert machine.distance(found.pose, exact.pose) < 1e-9
            assert machine.angle(found.pose, exact.pose) < 1e-9


def evenly_elastic(name: str) -> Robot:
    """All of each cable stretches, and none of it weighs: what MuJoCo's tendons can be."""
    robot = load(name)
    lines = tuple(
        line.model_copy(update={"arc_elastic": True, "cable": line.cable.model_copy(update={"linear_density": 0.0})})
        for line in robot.lines
    )
    return robot.model_copy(update={"lines": lines})


@pytest.mark.parametrize("name", RESTING)
@pytest.mark.parametrize("excess", [0.0, 0.2])
def test_massless_elastic_lines_rest_where_mujoco_rests(name: str, excess: float) -> None:
    robot = evenly_elastic(name)
    model = Model(robot, Fidelity(CableLaw.ELASTIC))
    row = cases.poses(model, 3)[1]
    lengths = row.lengths.copy()
    lengths[0] += excess
    found = solve_forward(model, lengths)
    assert found.ok
    start = found.pose + np.array([0.01, -0.02, 0.01, 0.01, 0.02, -0.01])[: model.n]
    rest = mujoco_model.rest(robot, lengths.tolist(), start.tolist())
    assert machine.distance(rest.pose, found.pose) < 20e-6
    assert machine.angle(rest.pose, found.pose) < 20e-6


def test_a_slack_massless_line_carries_nothing() -> None:
    model = Model(load("merlet2023"), Fidelity(CableLaw.ELASTIC))
    row = cases.poses(model, 1)[0]
    found = solve_forward(model, row.lengths + np.array([0.5, 0.0, 0.0, 0.0]))
    assert found.ok
    assert found.tensions[0] == 0.0
    assert (found.tensions[1:] >= 0.0).all()
    assert found.is_valid()


def test_merlet_with_one_line_30_cm_too_long() -> None:
    model = Model(load("merlet2023"))
    row = cases.poses(model, 20)
    for i in range(20):
        lengths = row.lengths[i].copy()
        lengths[i % 4] += 0.3
        found = solve_forward(model, lengths)
        assert found.ok
        assert found.platform_tensions.min() < 3.0  # a few newtons or less in the line that hangs slack


def test_the_swivel_is_the_lever_locked_at_the_horizontal() -> None:
    """A universal joint whose lever is held level by its own geometry gives the swivel's line."""
    model = Model(cases.replaced(load("merlet2023"), "swivel", sheave=Swivel(radius=0.0375)))
    built = Model(load("merlet2023"))
    held = cases.poses(built, 5)
    np.testing.assert_allclose(solve_forward(model, held.lengths).pose, held.pose, atol=1e-12)
