"""Boxes of poses of lines out of the plane: every pose is inside, by the solver and by 50 digits, and little more."""

from __future__ import annotations

import numpy as np
import pytest

import cases
import out_of_plane
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot
from cablewright.solvers.forward import solve_again, solve_forward
from cablewright.solvers.pose_hull import enclose_poses
from physics.test_counterweights import held as hung
from solvers.features.test_certificates_everywhere import off
from solvers.test_pose_hull import SecondOrder, as_batch, excess_width, held_by, lengths_within, poses_at

FAST = ("tilted", "guides", "mounts")
ERRORS = {3: 1e-3, 6: 1e-4}  # m, of a point and of a body
WIDER = 0.03  # of the width: how much more than sampled poses a box is to have


def robot(kind: str, body: bool) -> Robot:
    """A robot of lines of some *kind*."""
    return (out_of_plane.body if body else out_of_plane.point)(kind)


def solved(kind: str, body: bool, seed: int = 4) -> Equilibrium:
    """A pose of such a robot."""
    return cases.poses(Model(robot(kind, body)), 1, seed)[0]


def assert_enclosed(found: Equilibrium, error: float, corners: int, seed: int = 5) -> None:
    """The box is proved, holds solved poses and is little wider, and holds those of *corners* with 50 digits."""
    box = enclose_poses(found, error)
    assert box.complete, box.reason
    lengths = lengths_within(found, error, 100, seed)
    poses = poses_at(found, lengths)
    assert held_by(box, poses)
    assert excess_width(box, poses) < WIDER
    chosen = np.random.default_rng(seed).integers(0, 2**found.model.m, corners)
    exact = solve_again(as_batch(found), found.packed, lengths[chosen], corners).checked()
    for row in range(corners):
        assert held_by(box, exact.pose[row] + off(exact[row]))


@pytest.mark.parametrize("body", [False, True])
@pytest.mark.parametrize("kind", FAST)
def test_a_box_holds_all_poses_and_little_more(kind: str, body: bool) -> None:
    assert_enclosed(solved(kind, body), ERRORS[6 if body else 3], 3)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [6, 7, 8])
@pytest.mark.parametrize("kind", [kind for kind in out_of_plane.KINDS if kind != "mixed"])
def test_boxes_of_every_kind_hold_all_poses(kind: str, seed: int) -> None:
    for body in (False, True):
        assert_enclosed(solved(kind, body, seed), 3e-4 if not body else 1e-4, 8, seed)


@pytest.mark.parametrize("kind", FAST)
def test_a_slack_line_is_in_the_box_or_there_is_none(kind: str) -> None:
    found = solved(kind, False)
    longer = found.lengths + 0.2 * np.eye(4)[1]
    found = solve_forward(found.model, longer, guess=found.pose).checked()
    assert_enclosed(found, 1e-3, 3)


@pytest.mark.parametrize("name", ["guides", "tilted", "merlet2023"])
def test_a_counterweight_has_no_length_error(name: str) -> None:
    """Its tension is given, so the pose does not depend on its length; lines beside it may be upright."""
    found = hung(name)
    line = int(np.flatnonzero(found.lines.counterweight > 0.0)[0])
    box = enclose_poses(found, 1e-4)
    assert box.complete, box.reason
    poses = poses_at(found, lengths_within(found, 1e-4, 100, 5))
    assert held_by(box, poses)
    assert excess_width(box, poses) < WIDER
    errors = np.full(found.model.m, 1e-4)
    errors[line] = 1e-2
    same = enclose_poses(found, errors)
    np.testing.assert_array_equal([same.low, same.high], [box.low, box.high])


def test_a_box_a_tenth_smaller_misses_poses() -> None:
    found = solved("tilted", False)
    box = enclose_poses(found, 1e-3)
    poses, less = poses_at(found, lengths_within(found, 1e-3, 100, 8)), 0.05 * (box.high - box.low)
    assert (poses < box.low + less).any(axis=0).all()
    assert (poses > box.high - less).any(axis=0).all()


def test_a_budget_that_is_spent_gives_no_box() -> None:
    box = enclose_poses(solved("tilted", False), 0.05, budget=20)
    assert not box.complete
    assert np.isnan(box.low).all()
    assert box.reason.startswith("no box")


@pytest.mark.slow  # compiles what it alone calls; a bound that is too narrow shows as a box without its poses
@pytest.mark.parametrize("body", [False, True])
@pytest.mark.parametrize("kind", out_of_plane.KINDS)
def test_jacobians_differ_by_no_more_than_the_second_derivatives(kind: str, body: bool) -> None:
    """|Y (J(x + d) - J(x)) v| <= |Y| H[|d|, |v|] for random small d and v, in float Jacobians."""
    checked = SecondOrder(solved(kind, body), 1e-5)
    rng = np.random.default_rng(4)
    shares = [checked.share(rng) for _ in range(30)]
    assert max(shares) <= 1.0
    assert max(shares) > 1e-3  # a bound, not a wall
