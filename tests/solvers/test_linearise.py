"""The linearisation as a call: shapes, batches, and only of solved equilibria."""

from __future__ import annotations

import numpy as np
import pytest

import cases
from cablewright.foundation.errors import AnswerError
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import inverse
from cablewright.solvers.linearise import linearise

HOUSE = Model(load("house-printer"))


@pytest.fixture(scope="module")
def held() -> Equilibrium:
    """100 poses that the house-printer holds."""
    return cases.poses(HOUSE, 100)


def test_one_few_and_many_rows_agree(held: Equilibrium) -> None:
    many, few, one = linearise(held), linearise(held[:10]), linearise(held[7])
    assert many.stiffness.shape == (100, 3, 3)
    assert many.motion.shape == (100, 3, 4, 10)
    assert (one.per_length.shape, one.per_modulus.shape, one.per_exit_point.shape) == ((3, 4), (3, 4), (3, 4, 3))
    np.testing.assert_array_equal(few.motion, many.motion[:10])
    np.testing.assert_array_equal(one.motion, many.motion[7])
    np.testing.assert_array_equal(one.stiffness, many.stiffness[7])
    np.testing.assert_array_equal([each.per_length for each in many], many.per_length)
    assert (len(many), len(many[::10]), many[7].single, many[3:4].single) == (100, 10, True, False)
    assert repr(many) == "Linearisation(stiffness (100, 3, 3), motion (100, 3, 4, 10))"


def test_its_arguments_stay_unchanged(held: Equilibrium) -> None:
    before = [a.copy() for a in (held.pose, held.lengths, held.states)]
    linearise(held)
    for now, was in zip((held.pose, held.lengths, held.states), before, strict=True):
        np.testing.assert_array_equal(now, was)


def test_only_what_was_solved_is_linearised() -> None:
    with pytest.raises(AnswerError, match="no tensions within the limits"):
        linearise(inverse(HOUSE.robot, [0, 0, 14.9]))
    with pytest.raises(AnswerError, match="1 of 2 rows failed; row 1: no tensions within the limits"):
        linearise(inverse(HOUSE.robot, [[0, 0, 1], [0, 0, 14.9]]))


def test_modulus_factors_are_part_of_the_solution(held: Equilibrium) -> None:
    """Paying out 1 mm more moves the platform of the softened robot as its linearisation says."""
    lengths, factors, step = held.lengths[3], np.array([0.5, 1.0, 1.5, 1.0]), 1e-4
    soft = solve_forward(HOUSE, lengths, modulus_factors=factors)
    per_length = linearise(soft).per_length
    for i in range(4):
        ends = [
            solve_forward(HOUSE, lengths + by * np.eye(4)[i], guess=soft.pose, modulus_factors=factors).pose
            for by in (step, -step)
        ]
        np.testing.assert_allclose(per_length[:, i], (ends[0] - ends[1]) / (2 * step), rtol=1e-4, atol=1e-5)
