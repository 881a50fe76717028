"""How tensions at the sheaves follow every number of a robot: against differences of solves described otherwise."""

from __future__ import annotations

import numpy as np
import pytest

import cases
from cablewright.foundation.errors import InputError
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.parameters import varied
from cablewright.models.statics import Model
from cablewright.robot.parameters import nominal
from cablewright.solvers.forward import solve_again
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.linearise import linearise, tension_changes
from cablewright.solvers.parameter_effects import response, tension_response
from models.test_parameters import all_of
from solvers.test_parameters import taut

NAMES = ("paty2021", "merlet2023", "cogiro", "six-lines", "off-axis", "jointed-body")
MODELS = [
    Model(robot, Fidelity(law))
    for robot in cases.robots()
    if robot.name in NAMES
    for law in (CableLaw.CATENARY, CableLaw.ELASTIC)
]


@pytest.mark.parametrize("model", MODELS, ids=lambda model: f"{model.robot.name}-{model.fidelity.cable}")
def test_tensions_follow_numbers_and_lengths_as_differences_do(model: Model) -> None:
    held = taut(model, 2)
    parameters = all_of(model.robot)
    changes = tension_changes(held)
    motion = response(held, parameters)
    found = tension_response(held, parameters, motion, changes)
    base = np.array([nominal(model.robot, one) for one in parameters])
    largest = np.abs(found).max(axis=(0, 1))
    step = np.minimum(1e-3 * held.tensions.max() / np.maximum(largest, 1e-300), 1e-3 * np.maximum(np.abs(base), 0.1))
    offsets = np.concatenate([by * np.diag(step) for by in (-2.0, -1.0, 1.0, 2.0)])
    values = np.tile(base + offsets, (len(held.pose), 1))
    lengths = np.repeat(held.lengths, len(offsets), axis=0)
    solved = solve_again(held, *varied(model.robot, held.packed, parameters, values, lengths), len(offsets)).checked()
    far, near, ahead, beyond = solved.tensions.reshape(len(held.pose), 4, len(parameters), -1).swapaxes(0, 1)
    slope = np.swapaxes((far - 8.0 * near + 8.0 * ahead - beyond) / (12.0 * step[:, None]), 1, 2)
    assert (np.abs(slope - found).max(axis=(0, 1)) <= 1e-3 * largest + 1e-9 * held.tensions.max() / step).all()


def test_lengths_of_all_lines_and_what_has_no_tension() -> None:
    """Per length: the line's own, and the platform's motion; stiff lines are rejected."""
    robot = next(robot for robot in cases.robots() if robot.name == "cogiro")
    held = taut(Model(robot, Fidelity(CableLaw.CATENARY)), 1)
    changes, linear = tension_changes(held), linearise(held)
    found = changes.following(linear.per_length)
    found[:, range(robot.m), range(robot.m)] += changes.per_length
    step = 1e-6 * np.eye(robot.m)
    lengths = np.concatenate([held.lengths + step, held.lengths - step])
    solved = solve_again(held, held.packed, lengths, 2 * robot.m).checked().tensions
    slope = (solved[: robot.m] - solved[robot.m :]).T / 2e-6
    assert slope == pytest.approx(found[0], abs=1e-5 * np.abs(found).max())
    rigid = solve_inverse(Model(robot, Fidelity(CableLaw.RIGID)), held.pose)
    with pytest.raises(InputError, match="rigid"):
        tension_changes(rigid)
