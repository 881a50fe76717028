"""Forces of acceleration: the equilibrium under the same force, with the same lengths, is the oracle."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.analyses.motion.path_swing import PathSwing
from cablewright.analyses.steady_acceleration import tensions_by_acceleration
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
    model = Model.full(robot)
    held = solve_inverse(model, np.array(POSES[name]))
    assert held.ok.all()
    linear = linearise(held)
    steps = 0.01 * np.eye(3)
    there = [[pushed(robot, held, row, each) for each in steps] for row in range(len(held))]
    changes = np.array([[each.tensions for each in rows] for rows in there]) - held.tensions[:, None]
    found = tensions_by_acceleration(held, linear)
    assert found == pytest.approx(np.linalg.norm(changes, axis=1) / 0.01, rel=0.03, abs=0.03 * found.max())
    for step, moved in zip(steps, np.swapaxes(there, 0, 1), strict=True):
        ahead = np.tile(step, (len(held), 1))
        rest = PathSwing(model).take(held, held.ok, linear, np.zeros(len(held)), np.zeros(len(held)), ahead)
        nozzles = np.array([each.nozzle for each in moved])
        off = np.linalg.norm(nozzles - held.nozzle, axis=1)
        assert rest.displacement[0] == pytest.approx(off[0], rel=0.03)
