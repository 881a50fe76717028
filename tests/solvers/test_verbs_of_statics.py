"""Equilibria, slack lines and tensions: of a robot as of its model, under one law, reported in one line and as JSON."""

from __future__ import annotations

import json
from functools import cache

import numpy as np
import pytest

import cablewright as cw

ROBOT, POSE = cw.load("merlet2023"), [0.0, -1.0, 1.0]


@cache
def lengths() -> np.ndarray:
    return cw.inverse(ROBOT, POSE).lengths


VERBS = {
    "equilibria": lambda robot, **laws: cw.equilibria(robot, lengths(), starts=2, **laws),
    "solve_with_slack": lambda robot, **laws: cw.solve_with_slack(robot, POSE, {3: 0.1}, **laws),
    "slack_sets": lambda robot, **laws: cw.slack_sets(robot, POSE, **laws)[0],
    "let_out": lambda robot, **laws: cw.let_out(robot, lengths(), 3, [0.0, 0.01], **laws)[1],
    "tension_distribution": lambda robot, **laws: cw.tension_distribution(robot, POSE, **laws),
    "capacity": lambda robot, **laws: cw.capacity(robot, POSE, **laws),
    "wrench_closure": lambda robot, **laws: cw.wrench_closure(robot, POSE, **laws),
}
STRAIGHT = ("tension_distribution", "capacity", "wrench_closure")


@pytest.mark.parametrize("name", VERBS)
def test_a_robot_and_its_model_give_the_same_in_one_line(name) -> None:
    law = "rigid" if name in STRAIGHT else "catenary"
    found, again = VERBS[name](ROBOT), VERBS[name](cw.Model(ROBOT, cw.Fidelity.of(law)))
    assert json.dumps(found.to_dict(), allow_nan=False) == json.dumps(again.to_dict(), allow_nan=False)
    assert len(repr(found)) < 160
    assert "\n" not in repr(found)


@pytest.mark.parametrize("name", VERBS)
def test_another_law_than_the_model_has_and_a_law_that_is_none_are_rejected(name) -> None:
    with pytest.raises(cw.InputError, match="cable = elastic: the model has"):
        VERBS[name](cw.Model(ROBOT, cw.Fidelity(cw.CableLaw.RIGID)), cable="elastic")
    with pytest.raises(cw.InputError, match="unknown cable law 'chain'"):
        VERBS[name](ROBOT, cable="chain")


@pytest.mark.parametrize("verb", [cw.tension_distribution, cw.capacity, cw.wrench_closure])
def test_rows_are_taken_and_none_is_a_batch(verb) -> None:
    found = verb(ROBOT, [POSE, [0.0, 0.0, 2.0], [0.0, 1.0, 1.0]])
    assert (len(found), len(found[1:]), len(verb(ROBOT, np.empty((0, 3))))) == (3, 2, 0)
    assert found[1].margin == verb(ROBOT, [0.0, 0.0, 2.0]).margin
    assert found[1:].feasible.tolist() == found.feasible[1:].tolist()


def test_no_poses_hang_no_slack_line() -> None:
    assert len(cw.solve_with_slack(ROBOT, np.empty((0, 3)), {3: 0.1})) == 0


def test_the_pose_for_given_lengths_is_reported_in_one_line() -> None:
    box = cw.enclose_poses(cw.inverse(ROBOT, POSE), 1e-6, budget=1)
    told = json.loads(json.dumps(box.to_dict(), allow_nan=False))
    assert (told["certified"], told["unique"] is None) == (box.complete, not box.complete)
    assert len(repr(box)) < 160
