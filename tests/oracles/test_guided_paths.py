"""The two oracles of guided paths against each other and against what can be worked out by hand."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from mpmath import mp
from scipy.spatial.transform import Rotation

from oracles.guided_paths import (
    Case,
    End,
    Eyelet,
    Frame,
    Pulley,
    Swivel,
    TautPath,
    length_gradient,
    length_hessian,
    mujoco_length,
    mujoco_path,
    random_case,
    taut_path,
)

KINDS = [(frame, end) for frame in ("eyelet", "swivel", "pulley") for end in ("point", "swivel")]
LEVEL = np.eye(3)


def _path(case: Case) -> TautPath:
    return taut_path(case.frame, case.end, case.position, case.rotation)


def _floats(values: Sequence) -> np.ndarray:
    return np.array(values, float)


def _swivels(seed: int) -> Case:
    return random_case(np.random.default_rng(seed), "swivel", "swivel")


class TestByHand:
    def test_a_quarter_turn_over_a_sheave_and_a_third_of_a_turn_on_the_platform(self) -> None:
        """Up to (0, 0, 0), over to x, 3 m level, then over and down to the anchor, which is 30 degrees off -z."""
        anchor = (math.sin(math.pi / 6), 0, -math.cos(math.pi / 6))
        leaves, second = np.array([0.5, 0, 0.5]), np.array([3.5, 0, 0.5 - 0.2])
        point = second + 0.2 * np.array([-anchor[2], 0, anchor[0]])
        end = End(tuple(point), tuple(-np.array(anchor)), 0.2)
        path = taut_path(Swivel((0, 0, 0), (0, 0, 1), 0.5, 1, 7), end, (0, 0, 0), LEVEL)
        assert _floats(path.leaves) == pytest.approx(leaves, abs=1e-15)
        assert _floats(path.arrives) == pytest.approx([3.5, 0, 0.5], abs=1e-15)
        assert float(path.frame_wrap) == pytest.approx(math.pi / 2, abs=1e-15)
        assert float(path.end_wrap) == pytest.approx(math.pi / 3, abs=1e-15)
        assert float(path.length) == pytest.approx(7 + math.pi / 4 + 3 + 0.2 * math.pi / 3, abs=1e-14)

    def test_under_is_over_on_its_head(self) -> None:
        over = taut_path(Swivel((0, 0, 0), (0, 0, 1), 0.5), End((2, 1, -3)), (0, 0, 0), LEVEL)
        under = taut_path(Swivel((0, 0, 0), (0, 0, 1), 0.5, -1), End((2, 1, 3)), (0, 0, 0), LEVEL)
        assert over.length == under.length
        assert over.frame_wrap > math.pi / 2

    def test_a_span_that_leaves_a_fixed_wheel_askew(self) -> None:
        """Along x to (0, 0, 0), a quarter turn about y to (0.5, 0, -0.5), then 4 m down and 3 m aside."""
        wheel = Pulley((0, 0, -0.5), (0, 1, 0), 0.5, (-2, 0, 0))
        path = taut_path(wheel, End((0, 3, 0)), (0.5, 0, -4.5), LEVEL)
        assert float(path.length) == pytest.approx(2 + math.pi / 4 + 5, abs=1e-14)
        assert _floats(path.leaves) == pytest.approx([0.5, 0, -0.5], abs=1e-15)
        gradient = _floats(length_gradient(wheel, End((0, 3, 0)), (0.5, 0, -4.5), LEVEL))
        wider = 1 / 4 * (0.5 - 0.5 * 4 / 5)  # 1/4 rad/m along -x, and what the longer arc gains over the shorter span
        assert gradient[:3] == pytest.approx([-wider, 0.6, -0.8], abs=1e-15)
        with pytest.raises(ValueError, match="in the wheel's plane alone"):
            mujoco_length(wheel, End((0, 3, 0)), (0.5, 0, -4.5), LEVEL)

    @pytest.mark.parametrize(
        ("point", "why"),
        [((0, 0, 3), "along the swivel's axis"), ((0.5, 0, 0.3), "inside the sheave")],
    )
    def test_it_rejects_where_no_swivel_rests(self, point: tuple[float, float, float], why: str) -> None:
        with pytest.raises(ArithmeticError, match=why):
            taut_path(Swivel((0, 0, 0), (0, 0, 1), 0.5), End(point), (0, 0, 0), LEVEL)

    def test_it_rejects_a_guess_that_ends_behind_the_sheave(self) -> None:
        frame, end = Swivel((0, 0, 0), (0, 0, 1), 0.5), End((3, 0, 1))
        found = taut_path(frame, end, (0, 0, 0), LEVEL)
        assert taut_path(frame, end, (0, 0, 0), LEVEL, found.unknowns).unknowns == pytest.approx(found.unknowns)
        with mp.workdps(30):
            turned = (found.unknowns[0] + mp.pi, 2 * mp.pi - found.unknowns[1])
        with pytest.raises(ArithmeticError):
            taut_path(frame, end, (0, 0, 0), LEVEL, turned)


class TestOfItself:
    @pytest.mark.parametrize("seed", range(6))
    def test_read_from_its_anchor_it_is_the_same(self, seed: int) -> None:
        case = _swivels(seed)
        frame, end = case.frame, case.end
        assert isinstance(frame, Swivel)
        assert end.axis is not None
        inlet = frame.side * np.array(frame.axis)
        foot = case.position + case.rotation @ end.point
        back = Swivel(foot, case.rotation @ end.axis, end.radius, 1, frame.dead)
        other = taut_path(back, End(frame.exit_point, inlet, frame.radius), (0, 0, 0), LEVEL)
        path = _path(case)
        assert float(path.length) == pytest.approx(float(other.length), rel=1e-14)
        assert float(path.frame_wrap) == pytest.approx(float(other.end_wrap), abs=1e-13)
        assert _floats(path.arrives) == pytest.approx(_floats(other.leaves), rel=1e-13, abs=1e-13)

    @pytest.mark.parametrize("seed", range(6))
    def test_it_pulls_along_its_span(self, seed: int) -> None:
        """A sheave that turns freely passes no moment about its axis: force and moment are those of the span alone."""
        case = _swivels(seed)
        path, gradient = _path(case), _floats(length_gradient(case.frame, case.end, case.position, case.rotation))
        along, arm = _floats(path.direction), _floats(path.arrives) - case.position
        assert gradient[:3] == pytest.approx(along, abs=1e-15)
        assert gradient[3:] == pytest.approx(np.cross(arm, along), abs=1e-14 * float(path.length))

    def test_wherever_the_world_is_turned_it_is_as_long(self) -> None:
        case, turn = _swivels(3), Rotation.from_rotvec([0.3, -1.2, 0.7]).as_matrix()
        assert isinstance(case.frame, Swivel)
        frame: Frame = Swivel(
            turn @ case.frame.exit_point, turn @ case.frame.axis, case.frame.radius, case.frame.side, case.frame.dead
        )
        moved = taut_path(frame, case.end, turn @ case.position, turn @ case.rotation)
        assert float(moved.length) == pytest.approx(float(_path(case).length), rel=1e-14)

    def test_its_second_derivative_is_the_derivative_of_its_gradient(self) -> None:
        frame, end = Swivel((-3, 1, 4), (0.48, 0.6, 0.64), 0.2), End((0.3, 0.2, -0.1), (0, 0.6, 0.8), 0.1)
        position, turn = np.array([1.0, 2.0, 1.0]), Rotation.from_rotvec([0.3, -0.2, 0.5])
        there = position, turn.as_matrix()
        whole = _floats(length_hessian(frame, end, *there, one_by_one=True))
        for i in (1, 3, 5):
            unit = np.eye(6)[i] * 1e-5
            poses = [
                (position + s * unit[:3], (Rotation.from_rotvec(s * unit[3:]) * turn).as_matrix()) for s in (1, -1)
            ]
            on, back = (_floats(length_gradient(frame, end, *pose)) for pose in poses)
            assert (on - back) / 2e-5 == pytest.approx(whole[:, i], abs=1e-9)
        even = _floats(length_hessian(frame, end, *there))
        assert even == pytest.approx((whole + whole.T) / 2, abs=1e-15)
        assert np.abs(whole - whole.T).max() > 0.01
        x, y, z = _floats(length_gradient(frame, end, *there))[3:] / 2
        assert (whole - even)[3:, 3:] == pytest.approx(np.array([[0, z, -y], [-z, 0, x], [y, -x, 0]]), abs=1e-15)


class TestAgainstMujoco:
    @pytest.mark.parametrize(("frame", "end"), KINDS)
    def test_length_and_its_derivatives_agree(self, frame: str, end: str) -> None:
        rng = np.random.default_rng(7)
        for _ in range(6):
            case = random_case(rng, frame, end, in_plane=frame == "pulley")
            path = _path(case)
            other = mujoco_path(case.frame, case.end, case.position, case.rotation)
            assert other.left_over < 1e-13 * max(1.0, float(path.length))
            assert other.length == pytest.approx(float(path.length), rel=1e-13)
            gradient = _floats(length_gradient(case.frame, case.end, case.position, case.rotation))
            assert other.gradient == pytest.approx(gradient, abs=1e-13 * max(1.0, float(path.length)))

    def test_an_eyelet_and_a_point_are_a_straight_line(self) -> None:
        assert mujoco_length(Eyelet((0, 0, 5)), End((1, 0, 0)), (2, 0, 1), LEVEL) == pytest.approx(5, abs=1e-15)

    @pytest.mark.parametrize("end", ["point", "swivel"])
    def test_random_cases_have_their_stated_properties(self, end: str) -> None:
        rng, askew = np.random.default_rng(1), []
        for _ in range(20):
            case = random_case(rng, "pulley", end)
            path = _path(case)
            assert isinstance(case.frame, Pulley)
            askew.append(abs(float(np.dot(_floats(path.direction), case.frame.axis))))
            assert 0.2 < path.free_length < 70
            assert 0.1 < path.frame_wrap < 3.1
        assert 0.2 < max(askew) < 0.4
