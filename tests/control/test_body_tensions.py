"""Measured tensions of a rigid platform are brought to those of the model; the pose stays, by the full model."""

from __future__ import annotations

import numpy as np
import pytest

import cablewright as cw
from cablewright.control import velocity
from cablewright.control.balance_check import cleared, weight_of
from cablewright.control.path_follower import Target
from cablewright.control.velocity import VelocitySettings
from cablewright.foundation.signals import Estimate, frozen
from cablewright.models.statics import Equilibrium, Model
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.taut import taut_at

DT = 0.1
RADIUS = 0.05  # m
PLACES = {
    "cogiro": (0.4, -0.6, 2.0, 0.05, -0.08, 0.1),
    "ipanema": (0.2, 0.1, 0.9, 0.05, -0.05, 0.08),
    "jung2020": (-0.55, -0.6, 0.3, 0.0, 0.0, 0.0),  # lengths hardly hold its turn about the vertical
}
STILL = frozen(np.zeros(3))


def model_of(name: str, mass: float = 1.0) -> Model:
    """The model of a robot whose platform is *mass* times as heavy as in its file."""
    robot = cw.load(name)
    return Model(
        robot.model_copy(update={"platform": robot.platform.model_copy(update={"mass": mass * robot.platform.mass})})
    )


def controlled(model: Model, truth: Model, start: Equilibrium, errors: np.ndarray, steps: int) -> list[Equilibrium]:
    """Equilibria of *truth* in each step, where lengths are *errors* longer than their encoders count."""
    settings = VelocitySettings(model, 25.0, law="model", manage_slack=False)
    state, lengths, known, found = velocity.start(settings), start.lengths, start.pose, []
    pose = start.pose
    for step in range(steps):
        true = solve_forward(truth, lengths + errors, guess=pose).checked()
        pose, known = true.pose, solve_forward(model, lengths, guess=known).checked().pose
        found.append(true)
        zeros, place, turn = np.zeros(model.m), frozen(known[:3]), frozen(known[3:])
        estimate = Estimate(
            step * DT, place, STILL, turn, frozen(lengths), frozen(zeros), zeros > 1.0, frozen(zeros + RADIUS)
        )
        aim = Target(start.pose[:3], STILL, 0.0, 0, 0.0, True, False, False, start.pose[3:])
        lengths = lengths + RADIUS * DT * velocity.step(settings, state, estimate, aim, DT, true.tensions)
    return found


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", PLACES)
def test_tensions_come_to_those_of_the_model_and_the_pose_stays(name: str, seed: int) -> None:
    """Lengths are wrong by 30 um; the pose that they mean is not known, that which tensions mean is kept."""
    model = model_of(name)
    start = solve_inverse(model, np.array(PLACES[name])).checked()
    errors = 3e-5 * np.random.default_rng(seed).standard_normal(model.m)
    found = controlled(model, model, start, errors, 150)
    off = [np.abs(each.tensions - start.tensions).max() for each in found]
    moved = [np.linalg.norm(each.pose[:3] - start.pose[:3]) for each in found]
    assert off[-1] < 0.15 * off[0]
    assert max(moved) < 1.2 * moved[0] + 1e-5
    assert np.abs(found[-1].pose[3:] - start.pose[3:]).max() < 1e-3


@pytest.mark.parametrize("name", PLACES)
def test_a_load_that_is_not_known_moves_no_winch(name: str) -> None:
    """It changes all tensions, but what it moves is not theirs to correct."""
    model, heavier = model_of(name), model_of(name, 1.05)
    start = solve_inverse(model, np.array(PLACES[name])).checked()
    found = controlled(model, heavier, start, np.zeros(model.m), 150)
    wound = found[-1].lengths - start.lengths
    sunk = np.linalg.norm(found[0].pose[:3] - start.pose[:3])
    assert np.linalg.norm(found[-1].pose[:3] - start.pose[:3]) < 1.1 * sunk + 1e-5
    moving = taut_at(model, start.pose).per_motion
    assert np.linalg.norm(np.linalg.pinv(moving, rcond=0.01) @ wound) < 0.1 * sunk + 1e-5


@pytest.mark.parametrize("name", PLACES)
def test_measured_tensions_clear_a_line_unless_a_cell_is_wrong(name: str) -> None:
    """A cell is wrong by 30 % of all tensions together, of which 10 % are allowed; a limit is to spare as much."""
    model = model_of(name)
    held = solve_inverse(model, np.array(PLACES[name])).checked()
    inferred, size = 3.0 * held.tensions, max(weight_of(model), float(np.linalg.norm(held.tensions)))
    far, near = held.tensions + 0.11 * size, held.tensions + 0.09 * size
    np.testing.assert_array_equal(cleared(model, held.pose, inferred, held.tensions, far), held.tensions)
    np.testing.assert_array_equal(cleared(model, held.pose, inferred, held.tensions, near), inferred)
    for i in range(model.m):
        wrong = held.tensions + 0.3 * size * np.eye(model.m)[i]
        np.testing.assert_array_equal(cleared(model, held.pose, inferred, wrong, far + size), inferred)


def test_tensions_of_a_beam_clear_a_line_at_its_length_alone() -> None:
    """Upper lines pull it over by their height above the nozzle."""
    robot = cw.load("jung2020")
    pose = np.array([0.3, 0.2, 0.4, 0.0, 0.0, 0.0])
    held = solve_inverse(Model(robot.retracted(1.3)), pose).checked()
    inferred, limits = held.tensions + 400.0, held.tensions + 200.0
    for beam, clears in ((1.3, True), (2.0, False)):
        found = cleared(Model(robot), pose, inferred, held.tensions, limits, beam=beam)
        assert (found == held.tensions).all() == clears
