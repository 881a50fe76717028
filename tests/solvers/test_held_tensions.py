"""The margins of tensions that control holds are those of the lines whose tensions it chooses."""

from __future__ import annotations

import numpy as np
import pytest

import driven
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.solvers import held_tensions
from cablewright.solvers.inverse import solve_inverse

EXITS = {"a": (-1.0, -1.0, 3.0), "b": (1.0, -1.0, 3.0), "c": (1.0, 1.0, 3.0), "d": (-1.0, 1.0, 3.0)}


def hoist(weight: float) -> Robot:
    """A point on four winches, and on a counterweight of *weight*, kg, above."""
    every = {"sheave": {"kind": "eyelet"}, "cable": driven.CABLE, "tension_limits": (2.0, 400.0)}
    lines = [every | {"name": name, "exit_point": place, "winch": driven.WINCH} for name, place in EXITS.items()]
    return Robot.model_validate({
        "name": "hoist",
        "scene": {"frame_min": (-0.5, -0.5, 0.0), "frame_max": (0.5, 0.5, 1.0)},
        "platform": {"kind": "point", "mass": 5.0},
        "lines": [*lines, every | {"name": "up", "exit_point": (0.0, 0.0, 3.5), "counterweight": weight}],
    })  # fmt: skip


@pytest.mark.parametrize("weight", [0.25, 2.0])
def test_a_counterweight_near_its_limit_takes_no_margin_from_the_lines_with_winches(weight: float) -> None:
    model, poses = Model(hoist(weight)), np.array([[0.0, 0.0, 0.5], [0.2, 0.1, 0.6]])
    narrow, share = held_tensions.with_margin(model, poses, None)
    assert share == 1.0
    assert [line.tension_limits[0] for line in narrow.robot.lines] == [4.0, 4.0, 4.0, 4.0, 2.0]
    assert (solve_inverse(narrow, poses).tensions[:, :4] >= 4.0).all()
