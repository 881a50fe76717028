"""Forces of acceleration: the equilibrium under the same force, with the same lengths, is the oracle."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.analyses.inertia_forces import inertia_effects
from cablewright.models.rotation import matrices
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot, load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.linearise import linearise

POSES = {
    "house-printer": [[3.0, 2.0, 1.0], [-4.0, 1.0, 5.0]],
    "merlet2023": [[0.5, 1.0, 1.0]],
    "cogiro": [[0.5, -1.0, 1.5, 0.02, -0.05, 0.1]],
    "wang2021": [[0.1, 0.05, 1.0]],
    "jung2020": [[0.1, 0.05, 0.9, 0.01, 0.02, -0.03]],
}
ACCELERATIONS = np.array([[0.02, 0.0, 0.0], [-0.01, 0.015, 0.02], [0.0, 0.0, 0.0]])


def pushed(robot: Robot, held: Equilibrium, row: int, acceleration: np.ndarray) -> Equilibrium:
    """The equilibrium with the lengths of a row under the force of inertia."""
    force = -robot.platform.mass * acceleration
    moment = np.zeros(3)
    if robot.n == 6:
        moment = np.cross(matrices(held.pose[row, 3:]) @ np.asarray(robot.platform.centre_of_mass), force)
    return solve_forward(Model.full(robot.under_wrench(force, moment)), held.lengths[row], guess=held.pose[row])


@pytest.mark.parametrize("name", POSES)
def test_tensions_and_places_are_those_of_the_equilibrium_under_that_force(name: str) -> None:
    robot = load(name)
    held = solve_inverse(Model.full(robot), np.array(POSES[name]))
    assert held.ok.all()
    found = inertia_effects(held, linearise(held), np.tile(ACCELERATIONS, (len(held), 1, 1)))
    for row in range(len(held)):
        there = [pushed(robot, held, row, each) for each in ACCELERATIONS]
        changes = np.array([each.tensions for each in there]) - held.tensions[row]
        largest = np.abs(changes).max()
        assert found.tension_rise[row] == pytest.approx(changes.max(axis=0).clip(min=0.0), abs=0.03 * largest)
        assert found.tension_drop[row] == pytest.approx(changes.min(axis=0).clip(max=0.0), abs=0.03 * largest)
        moved = max(float(np.linalg.norm(each.nozzle - held.nozzle[row])) for each in there)
        assert found.displacement[row] == pytest.approx(moved, rel=0.03)


def test_what_does_not_accelerate_is_at_rest() -> None:
    held = solve_inverse(Model.full(load("merlet2023")), np.array([[0.5, 1.0, 1.0], [0.0, 0.0, 1.0]]))
    found = inertia_effects(held, linearise(held), np.zeros((2, 5, 3)))
    for values in (found.tension_drop, found.tension_rise, found.displacement):
        assert not values.any()
