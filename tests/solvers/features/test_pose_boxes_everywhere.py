"""Boxes of poses in planes, with tackles and with cables side by side, hold every pose, or there are none."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

import cablewright as cw
import cases
import out_of_plane
import planar_robots
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot, load
from cablewright.solvers.pose_hull import enclose_poses
from solvers.test_certify import Exact, on_board
from solvers.test_pose_hull import SecondOrder, excess_width, held_by, lengths_within, poses_at

BOARDS = list(product(planar_robots.PLANES, (False, True)))


def several(name: str) -> Robot:
    """A robot of the library on tackles of two spans, and on pairs of cables, in turn."""
    robot = load(name)
    lines = []
    for i, line in enumerate(robot.lines):
        most = 2.0 * line.tension_limits[1]
        own = {"advantage": 2, "sheave": cw.robot.Eyelet(), "winch_exit": None} if i % 2 else {"cables": 2}
        lines.append(line.model_copy(update=own | {"tension_limits": (line.tension_limits[0], most)}))
    return out_of_plane.checked(robot.model_copy(update={"lines": tuple(lines)}))


def solved(name: str) -> Equilibrium:
    """A pose of a robot by its name."""
    return cases.poses(Model(several(name.removeprefix("several "))), 1)[0]


@pytest.mark.parametrize(("plane", "body"), BOARDS)
def test_a_box_in_a_plane_holds_all_poses_and_little_more(plane: str, body: bool) -> None:
    _, held = on_board(plane, body, 1, 3)
    found = held[0]
    error = 1e-6 if body else 1e-5
    box = enclose_poses(found, error)
    assert box.complete
    poses = poses_at(found, lengths_within(found, error, 100, 5))
    assert held_by(box, poses)
    moved = np.ptp(poses, axis=0)
    wide = (box.high - box.low - moved) / np.repeat([moved[k : k + 3].max() for k in range(0, len(moved), 3)], 3)
    assert wide.max() < 0.03


@pytest.mark.parametrize(("plane", "body"), [("tilted", False), ("tilted", True)])
def test_exact_poses_of_corners_are_in_the_box(plane: str, body: bool) -> None:
    _, held = on_board(plane, body, 1, 4)
    box = enclose_poses(held[0], 1e-6)
    solved_ones = cw.forward(held.model, held[0].lengths + 1e-6 * np.array([(1, -1, 1, -1), (1, 1, -1, 1)]),
                             guess=np.repeat(held.pose[:1], 2, axis=0)).checked()  # fmt: skip
    for row in range(2):
        assert held_by(box, solved_ones.pose[row] + Exact(solved_ones[row]).polished())


@pytest.mark.parametrize(
    ("name", "error"),
    [
        ("several merlet2023", 1e-4),
        ("several cogiro", 1e-5),
    ],
)
def test_a_box_holds_all_poses(name: str, error: float) -> None:
    found = solved(name)
    box = enclose_poses(found, error)
    assert box.complete, box.reason
    poses = poses_at(found, lengths_within(found, error, 100, 5))
    assert held_by(box, poses)
    assert excess_width(box, poses) < 0.05


@pytest.mark.slow  # compiles what it alone calls; a bound that is too narrow shows above as a box without its poses
@pytest.mark.parametrize("name", ["several merlet2023", "several cogiro", *(f"{a} {b}" for a, b in BOARDS)])
def test_jacobians_differ_by_no_more_than_the_second_derivatives(name: str) -> None:
    """As of plain lines: forces of several spans and cables, and the rows of a plane."""
    if name.startswith("several"):
        found = solved(name)
    else:
        plane, body = name.split()
        found = on_board(plane, body == "True", 1, 3)[1][0]
    checked = SecondOrder(found, 1e-6)
    rng = np.random.default_rng(4)
    shares = [checked.share(rng) for _ in range(60)]
    assert max(shares) <= 1.0
    assert max(shares) > 1e-3  # a bound, not a wall
