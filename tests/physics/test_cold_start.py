"""Forward without a guess: the right pose from nothing, taut and slack, and through levers."""

from __future__ import annotations

import numpy as np
import pytest

import cases
from cablewright.models.fidelity import Fidelity, SheaveLaw
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.forward import solve_forward


@pytest.mark.parametrize("name", ["paty2021", "house-printer", "merlet2023"])
def test_3000_poses_over_the_frame_are_found_from_nothing(name: str) -> None:
    robot = load(name)
    model = Model(robot, tension_limits=(10.0, robot.lines[0].tension_limits[1]))
    held = cases.poses(model, 3000)
    found = solve_forward(model, held.lengths)
    assert found.ok.all()
    assert np.linalg.norm(found.pose - held.pose, axis=1).max() < 1e-9


@pytest.mark.parametrize("excess", [0.01, 0.1, 0.5, 1.0, 2.0])
@pytest.mark.parametrize("name", ["house-printer", "merlet2023"])
def test_a_line_let_out_still_solves(name: str, excess: float) -> None:
    model = Model(load(name))
    held = cases.poses(model, 500)
    lengths = held.lengths.copy()
    lengths[np.arange(500), np.arange(500) % 4] += excess
    found = solve_forward(model, lengths)
    assert found.ok.mean() >= 0.99  # the rest: at a fold, where the excess begins to slide into the dead span
    assert found[found.ok].is_valid()


@pytest.mark.parametrize("sheave", [SheaveLaw.EYELET, SheaveLaw.SWIVEL])
def test_the_pose_does_not_depend_on_where_the_solve_starts(sheave: SheaveLaw) -> None:
    """A point load on eyelet lines has one equilibrium (convexity): every guess leads to it, slack or not."""
    model = Model(load("merlet2023"), Fidelity(sheave=sheave))
    rng = np.random.default_rng(5)
    held = cases.poses(model, 4)
    for row in range(4):
        lengths = held.lengths[row].copy()
        lengths[row] += 0.2 * row
        cold = solve_forward(model, lengths).checked().pose
        guesses = rng.uniform([-2.4, -4.8, 0.0], [2.4, 4.8, 3.8], (200, 3))
        found = solve_forward(model, np.tile(lengths, (200, 1)), guess=guesses)
        assert found.ok.all()
        assert np.linalg.norm(found.pose - cold, axis=1).max() < 1e-9


def test_levers_hang_the_stable_way() -> None:
    model = Model(load("house-printer"))
    found = solve_forward(model, cases.poses(model, 200).lengths)
    beta = found.states[..., 5]
    assert ((beta > -np.pi / 2) & (beta < 0)).all()


def test_too_short_a_cable_is_overstretched_and_says_which() -> None:
    model = Model(load("house-printer"))
    found = solve_forward(model, np.full(4, 25.0))  # shorter than from the winches to the middle between the tops
    assert found.status.name == "OVERSTRETCHED"
    assert "N over its 10290 N" in found.sentence()
