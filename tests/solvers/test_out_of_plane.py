"""What takes lines out of the plane, and what rejects them by name."""

from __future__ import annotations

import numpy as np
import pytest

import cablewright as cw
import out_of_plane
from cablewright.analyses.interference import distances
from cablewright.foundation.errors import InputError, Status
from cablewright.live.logged_line_shapes import hanging_lines
from cablewright.robot import Robot
from cablewright.solvers.hardware_limits import sheave_clearances
from cablewright.solvers.line_cover import refuse_unfit
from cablewright.solvers.tension import structures
from cablewright.solvers.uniqueness import unique_among

TILTED = out_of_plane.point("tilted")
BODY = out_of_plane.body("mixed")
LIMITS = (10.0, 8000.0)
PLACE = [0.2, 0.1, 1.0]
POSE = [0.3, 0.2, 1.4, 0.02, 0.03, -0.05]


def test_none_is_called_the_only_one() -> None:
    held = cw.inverse(TILTED, PLACE)
    assert cw.certify(held).certified
    assert unique_among(held) is None


def test_what_does_not_cover_them_says_so() -> None:
    with pytest.raises(
        InputError, match=r"exhaustive: line '.*' has a swivel whose axis is not vertical; not supported"
    ):
        refuse_unfit(cw.Model(TILTED), np.full(4, 5.0))


@pytest.mark.parametrize("robot", [TILTED, BODY, out_of_plane.body("mounts")], ids=lambda robot: robot.name)
def test_lines_hang_by_their_lengths_alone(robot: Robot) -> None:
    held = cw.inverse(robot, [POSE[: robot.n]]).checked()
    found = hanging_lines(held.model, held.pose, held.lengths)
    np.testing.assert_allclose(found, held.states, rtol=1e-9, atol=1e-9)
    unknown = hanging_lines(held.model, held.pose, np.where(np.arange(robot.m) == 0, np.nan, held.lengths))
    assert (unknown[0, 1:] == found[0, 1:]).all()
    assert np.isfinite(unknown).all()


def test_a_slack_line_takes_its_place_in_the_balance() -> None:
    held = cw.inverse(BODY, POSE, tension_limits=LIMITS).checked()
    excess = cw.excess_lengths(held)
    assert (np.abs(excess) < 0.1).all()
    slack = cw.solve_with_slack(BODY, POSE, {0: 0.05}, tension_limits=LIMITS).checked()
    np.testing.assert_allclose(cw.excess_lengths(slack)[0], 0.05, atol=1e-12)
    assert slack.is_valid()
    again = cw.forward(slack.model, slack.lengths, guess=POSE).checked()
    np.testing.assert_allclose(again.pose, POSE, atol=1e-9)
    np.testing.assert_allclose(again.tensions, slack.tensions, rtol=1e-6)


def test_a_search_lists_them_certified() -> None:
    held = cw.inverse(TILTED, PLACE)
    found = cw.equilibria(TILTED, held.lengths)
    assert len(found.solutions) == 1
    np.testing.assert_allclose(found.solutions.pose[0], held.pose, atol=1e-8)
    assert found.certificates.certified.all()


def test_structures_are_those_of_the_geometry() -> None:
    """The columns of the structure matrix."""
    rng = np.random.default_rng(3)
    poses = rng.uniform([-2, -1.5, 1, -0.1, -0.1, -0.1], [2, 1.5, 3, 0.1, 0.1, 0.1], (10, 6))
    for pose, A in zip(poses, structures(cw.Model.of(BODY, cable="elastic"), poses)[0], strict=True):
        R = out_of_plane.Rotation.from_rotvec(pose[3:]).as_matrix()
        for i, line in enumerate(BODY.lines):
            u, arm = out_of_plane.straight(line, pose[:3] + R @ np.array(line.platform_point), R, pose[:3])
            np.testing.assert_allclose(A[:, i], -np.concatenate([u, np.cross(arm, u)]), atol=1e-12)


def test_distances_are_between_the_lines_where_they_are() -> None:
    """The drawn line begins where it leaves its sheave at the frame and ends on the one at the platform."""
    held = cw.inverse(BODY, POSE, cable="elastic", tension_limits=LIMITS).checked()
    curves = distances(held).curves()
    R = out_of_plane.Rotation.from_rotvec(held.pose[3:]).as_matrix()
    for i, (line, curve) in enumerate(zip(BODY.lines, curves, strict=True)):
        point = held.pose[:3] + R @ np.array(line.platform_point)
        u, arm = out_of_plane.straight(line, point, R, held.pose[:3])
        left, _ = out_of_plane.touched(line, u, point - line.exit_point)
        assert np.abs(curve[0] - left).max() < 1e-9, i
        assert np.abs(curve[-1] - held.pose[:3] - arm).max() < 1e-9, i
        assert np.abs(np.diff(curve, axis=0)).max() > 0.0


def test_the_eyelet_law_leaves_all_sheaves_out() -> None:
    plain = out_of_plane.body("guides")
    for kind in ("both", "pulleys"):
        robot = out_of_plane.body(kind)
        lines = tuple(line.model_copy(update={"winch_exit": None}) for line in plain.lines)
        bare = plain.model_copy(update={"lines": tuple(line.model_copy(update={"guides": ()}) for line in lines)})
        one = cw.inverse(robot, POSE, sheave="eyelet", cable="elastic", tension_limits=LIMITS)
        two = cw.inverse(bare, POSE, cable="elastic", tension_limits=LIMITS)
        np.testing.assert_allclose(one.tensions, two.tensions, rtol=1e-9)
    with pytest.raises(InputError, match=r"sheave = swivel: line '.' has a pulley, which does not turn"):
        cw.inverse(out_of_plane.body("pulleys"), POSE, sheave="swivel")


def test_a_point_in_a_sheave_or_on_an_axis_is_said() -> None:
    line = TILTED.lines[0]
    at = np.array(line.exit_point)
    assert cw.inverse(TILTED, at + np.array([1e-3, 0, 0])).status is Status.INSIDE_SHEAVE
    assert cw.inverse(TILTED, at - 0.5 * out_of_plane.unit(line.sheave.axis)).status is Status.UNDER_EXIT
    ends = out_of_plane.body("platform sheaves")  # a platform point on the axis of its own sheave
    axis = out_of_plane.unit(ends.lines[0].platform_sheave.axis)
    pose = np.concatenate([np.array(ends.lines[0].exit_point) - 3.0 * axis - ends.lines[0].platform_point, np.zeros(3)])
    assert cw.inverse(ends, pose).status is Status.UNDER_EXIT
    assert np.isfinite(sheave_clearances(cw.inverse(TILTED, PLACE))).all()


def test_the_cable_of_a_pulley_that_it_would_not_touch_is_no_answer() -> None:
    robot = out_of_plane.point("pulleys")
    below = np.array(robot.lines[0].winch_exit) * [1.02, 1.02, 1.0]  # behind the wheel, over the winch
    assert cw.inverse(robot, [*below[:2], robot.lines[0].exit_point[2] + 1.0]).status is not Status.OK


def test_a_workspace_is_of_their_geometry() -> None:
    """Guides before the exit points leave the workspace of rings as it is; tilted sheaves change it a little."""
    guides, tilted = (cw.workspace(out_of_plane.point(kind), tolerance=0.02) for kind in ("guides", "tilted"))
    plain = cw.workspace(cw.load("merlet2023"), sheave="eyelet", tolerance=0.02)
    assert guides.volume == pytest.approx(plain.volume, rel=0.02)
    assert tilted.volume == pytest.approx(plain.volume, rel=0.1)
