"""`forward --length-error`: the box that holds the pose, or why there is none."""

from __future__ import annotations

import re

import numpy as np
import pytest

from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.pose_hull import enclose_poses

LENGTHS = [28.0, 28.0, 28.1, 28.0]
FORWARD = ("forward", "house-printer", "--lengths", ",".join(map(str, LENGTHS)))


def test_it_prints_what_the_solver_proves(cli) -> None:
    answer = cli(*FORWARD, "--length-error", "1e-3", "--json")
    assert (answer.code, answer.err) == (0, "")
    box = answer.json["pose_box"]
    assert box.keys() == {"low", "high", "certified", "unique", "leaves", "reason"}
    found = solve_forward(Model(load("house-printer")), LENGTHS)
    proved = enclose_poses(found, 1e-3)
    assert box["certified"] is proved.complete is True
    assert (box["low"], box["high"]) == (proved.low.tolist(), proved.high.tolist())
    assert box["unique"] == "locally"
    assert box["leaves"] == proved.leaves > 0
    assert (np.array(box["low"]) < answer.json["pose"]).all()
    assert (np.array(box["high"]) > answer.json["pose"]).all()


def test_no_box_is_an_answer_too(cli) -> None:
    answer = cli(*FORWARD, "--length-error", "0.05", "--budget", "3", "--json")
    assert answer.code == 0
    box = answer.json["pose_box"]
    assert box["certified"] is False
    assert box["low"] == box["high"] == [None] * 3
    assert box["unique"] is None
    assert box["reason"].startswith("no box within the budget of 3 leaves")
    assert "no box within the budget" in cli(*FORWARD, "--length-error", "0.05", "--budget", "3").out


def test_people_get_ends_that_are_rounded_outward(cli) -> None:
    plain, answer = cli(*FORWARD), cli(*FORWARD, "--length-error", "1e-3,1e-3,2e-3,1e-3")
    assert answer.code == 0
    low, high = (line for line in answer.out.splitlines() if line not in plain.out.splitlines())
    box = enclose_poses(solve_forward(Model(load("house-printer")), LENGTHS), [1e-3, 1e-3, 2e-3, 1e-3])
    least, most = (np.array(list(map(float, re.findall(r"-?\d+\.\d+", line)))) for line in (low, high))
    assert ((least <= box.low) & (box.low < least + 1.1e-6)).all()
    assert ((most >= box.high) & (box.high > most - 1.1e-6)).all()


def test_without_the_option_there_is_no_box(cli) -> None:
    assert "pose_box" not in cli(*FORWARD, "--json").json


@pytest.mark.parametrize(
    ("given", "says"),
    [
        (("0",), "over 0 is wanted"),
        (("-1e-3",), "over 0 is wanted"),
        (("30",), "as large as the length of line"),
        (("1e-3,1e-3",), "one number is wanted, or 4"),
        (("wide",), "--length-error = 'wide'"),
        (("1e-3", "--budget", "0"), "budget = 0"),
    ],
)
def test_bad_errors_are_refused_in_one_line(cli, given: tuple[str, ...], says: str) -> None:
    answer = cli(*FORWARD, "--length-error", *given)
    assert answer.code == 2
    assert answer.out == ""
    assert says in answer.err
    assert len(answer.err.splitlines()) == 1
