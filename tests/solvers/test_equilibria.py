"""Every equilibrium: found, reported as stable or not, certified, and none twice."""

from __future__ import annotations

import json

import numpy as np
import pytest

import cases
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.models.fidelity import CableLaw, Fidelity, SheaveLaw
from cablewright.models.rotation import angle_between
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.equilibria import Equilibria, equilibria
from cablewright.solvers.slack import excess_lengths

PATY = Model(load("paty2021"))
COGIRO = Model(load("cogiro"))


def lengths_of(model: Model, count: int, seed: int, slack: float = 0.3) -> np.ndarray:
    """Lengths of random poses, one line of each up to *slack* (m) too long."""
    lengths = cases.poses(model, count, seed).lengths.copy()
    rng = np.random.default_rng(seed)
    lengths[np.arange(count), rng.integers(0, model.m, count)] += rng.uniform(0.0, slack, count)
    return lengths


def check(found: Equilibria) -> None:
    """They balance, differ, and are certified."""
    solutions = found.solutions
    weight = solutions.packed.platform[:, 3]
    assert (solutions.residual_norm() < 1e-9).all()
    assert (solutions.unbalanced_force() < 1e-9 * weight).all()
    assert found.certificates.certified.all()
    for row in range(len(found.stable)):
        others = np.delete(np.arange(len(found.stable)), row)
        apart = np.linalg.norm(solutions.pose[others, :3] - solutions.pose[row, :3], axis=1)
        if solutions.model.n == 6:
            apart += angle_between(solutions.pose[others, 3:], solutions.pose[row, 3:])
        shape = np.abs(np.sin(0.5 * (solutions.states[others] - solutions.states[row]))).max(axis=(1, 2))
        assert (apart + shape > 1e-6).all()


def test_levers_give_sixteen_of_which_one_is_stable() -> None:
    for lengths in lengths_of(PATY, 20, 1, slack=0.0):
        found = equilibria(PATY, lengths)
        check(found)
        assert (len(found.stable), found.stable.sum()) == (16, 1)
        assert found.certificates.levers.tolist() == [1] + [-1] * 15
        assert found.complete_for is None
        assert repr(found) == "Equilibria('paty2021', 16 found, 1 stable, not proved complete)"


def test_they_have_a_length_rows_and_figures() -> None:
    found = equilibria(PATY, lengths_of(PATY, 1, 1, slack=0.0)[0])
    assert len(found) == len(list(found)) == 16
    assert found[0].status.word == "ok"
    told = found.to_dict()
    json.dumps(told, allow_nan=False)
    for row, one in zip(told["solutions"], found, strict=True):
        assert (row["status"], row["pose"], row["stable"]) == (one.status.word, one.pose.tolist(), one.ok)
        assert row["certified"]


@pytest.mark.parametrize("sheave", [SheaveLaw.EYELET, SheaveLaw.SWIVEL])
def test_a_point_without_levers_has_one(sheave: SheaveLaw) -> None:
    model = Model(load("merlet2023"), Fidelity(CableLaw.CATENARY, sheave))
    for lengths in lengths_of(model, 25, 2):
        found = equilibria(model, lengths, starts=40)
        check(found)
        assert (len(found.stable), found.stable.sum()) == (1, 1)


def test_constant_dead_lengths_through_eyelets_are_complete_by_the_theorem() -> None:
    robot = cases.replaced(load("merlet2023"), "plain", winch_exit=None, dead_length=2.0)
    model = Model(robot, Fidelity(sheave=SheaveLaw.EYELET))
    found = equilibria(model, lengths_of(model, 1, 3)[0])
    assert found.complete_for == "all equilibria"
    assert "no more than one" in found.why


def test_a_body_has_several_and_the_one_wanted_is_among_them() -> None:
    held = cases.poses(COGIRO, 5, 4)
    for row in range(5):
        found = equilibria(COGIRO, held.lengths[row])
        check(found)
        near = np.linalg.norm(found.solutions.pose[:, :3] - held.pose[row, :3], axis=1) < 1e-6
        assert found.stable[near].tolist() == [True]
        assert len(found.stable) > 5


def test_slack_lines_are_reported() -> None:
    model = Model(load("house-printer"))
    for lengths in lengths_of(model, 5, 5):
        found = equilibria(model, lengths)
        stable = found.solutions[found.stable]
        clear = np.abs(excess_lengths(stable)) > 1e-3  # the arcs differ a little
        np.testing.assert_array_equal(found.slack[found.stable][clear], (excess_lengths(stable) > 0.0)[clear])


def test_a_box_bounds_what_is_reported() -> None:
    lengths = lengths_of(PATY, 1, 6, slack=0.0)[0]
    everything = equilibria(PATY, lengths)
    top = everything.solutions.pose[:, 2].max() - 1e-3
    found = equilibria(PATY, lengths, box=[-9.0, 9.0, -9.0, 9.0, -1.0, top])
    assert 0 < len(found.stable) < len(everything.stable)
    assert (found.solutions.pose[:, 2] <= top).all()


def test_a_seed_gives_the_same_bytes() -> None:
    lengths = lengths_of(COGIRO, 1, 7)[0]
    first, again = (equilibria(COGIRO, lengths, seed=3, starts=50) for _ in range(2))
    assert first.solutions.pose.tobytes() == again.solutions.pose.tobytes()


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        ({"lengths": [33.0] * 3}, "4 numbers are expected"),
        ({"lengths": [33.0, 0.0, 33.0, 33.0]}, "numbers over zero"),
        ({"lengths": [33.0] * 4, "box": [0, 0, 1, 2, 3, 4]}, "X0 < X1"),
        ({"lengths": [33.0] * 4, "box": [0, 1]}, "6 numbers are expected"),
        ({"lengths": [33.0] * 4, "starts": 0}, "starts = 0"),
    ],
)
def test_bad_input(arguments: dict, why: str) -> None:
    with pytest.raises(InputError, match=why):
        equilibria(PATY, **arguments)


def test_nothing_found_is_said() -> None:
    with pytest.raises(AnswerError, match="no equilibrium was found"):
        equilibria(PATY, [33.0] * 4, box=[0, 1, 0, 1, 100, 101])
