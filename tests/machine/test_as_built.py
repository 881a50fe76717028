"""The robot that was built: off its description by the tolerances, and by nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.foundation.errors import InputError
from cablewright.machine.simulated.as_built import as_built
from cablewright.machine.simulated.settings import Tolerances
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from twins import SIMULATION

ROBOT = load("merlet2023")


def test_the_same_seed_builds_the_same_robot() -> None:
    assert as_built(ROBOT, SIMULATION.tolerances, 7) == as_built(ROBOT, SIMULATION.tolerances, 7)
    assert as_built(ROBOT, SIMULATION.tolerances, 7) != as_built(ROBOT, SIMULATION.tolerances, 8)


def test_without_tolerances_it_is_the_description() -> None:
    assert as_built(ROBOT, Tolerances(anchor=0.0, sheave_radius=0.0, modulus=0.0), 3) == ROBOT


def test_errors_have_the_laws_of_the_file() -> None:
    built = [as_built(ROBOT, SIMULATION.tolerances, seed) for seed in range(400)]
    anchors = np.array([[line.exit_point for line in robot.lines] for robot in built])
    off = anchors - [line.exit_point for line in ROBOT.lines]
    radii = np.array([[line.sheave.radius for line in robot.lines] for robot in built]) - 0.0375
    factors = np.array([[line.cable.young_modulus for line in robot.lines] for robot in built]) / 100e9
    assert off.std() == pytest.approx(1e-3, rel=0.05)
    assert abs(off.mean()) < 1e-4
    assert radii.std() == pytest.approx(2e-4, rel=0.1)
    assert 0.7 <= factors.min() < 0.71
    assert 1.29 < factors.max() <= 1.3
    assert factors.std() == pytest.approx(0.6 / np.sqrt(12), rel=0.05)


def test_a_built_robot_hangs_near_where_its_description_says() -> None:
    lengths = solve_inverse(Model(ROBOT), [0.5, 1.0, 1.2]).checked().lengths
    for seed in range(5):
        hung = solve_forward(Model(as_built(ROBOT, SIMULATION.tolerances, seed)), lengths).checked()
        assert 1e-5 < np.abs(hung.pose - [0.5, 1.0, 1.2]).max() < 0.03


def test_changing_one_tolerance_leaves_the_other_errors() -> None:
    wide = SIMULATION.tolerances.model_copy(update={"modulus": 0.0})
    one, other = as_built(ROBOT, SIMULATION.tolerances, 4), as_built(ROBOT, wide, 4)
    assert [line.exit_point for line in one.lines] == [line.exit_point for line in other.lines]


def test_what_cannot_be_built_is_rejected() -> None:
    with pytest.raises(InputError, match="seed = -1"):
        as_built(ROBOT, SIMULATION.tolerances, -1)
    with pytest.raises(InputError, match="without radius"):  # one of four sheaves shrinks by more than it has
        as_built(ROBOT, SIMULATION.tolerances.model_copy(update={"sheave_radius": 1e3}), 0)
