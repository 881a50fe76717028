"""The oracles on rigid platforms, against each other and against what can be worked out by hand."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
import pytest
from mpmath import mp, mpf
from scipy.spatial.transform import Rotation

from cablewright.robot import Robot, load
from cases import some
from oracles import linear, machine, mujoco_model, platform
from oracles.line import LineState

Point = Sequence[float]

MASS, EA = 12.0, 8e4
SWIVEL = {"kind": "swivel", "radius": 0.05, "wrap": "over"}
JOINT = {"kind": "universal-joint", "radius": 0.05, "lever": 0.1, "lever_weight": 6.0, "lever_mass_centre": 0.07}
PUSHED = {"force": (7.0, -4.0, 12.0), "moment": (0.9, -1.3, 0.6)}
CENTRE = (0.03, -0.02, -0.15)

CORNERS = np.array([[x, y, z] for z in (3.0, 0.2) for x in (-2.0, 2.0) for y in (-1.5, 1.5)])
CROSSED = np.array([[-0.2 * np.sign(x), 0.15 * np.sign(y), 0.3 if z < 1 else -0.25] for x, y, z in CORNERS])
"""Platform points on the far side in x, and low where their exit point is high: pairs of lines cross."""


def _robot(exits: Sequence[Point], points: Sequence[Point], density: float = 0.0, **changes: object) -> Robot:
    """Return a rigid platform on lines from ``exits`` (m, 3), world, to ``points`` (m, 3), platform frame.

    ``changes`` go to the platform or else to every line.
    """
    cable = {"axial_stiffness": EA, "linear_density": density, "breaking_load": 1e5}
    body = {key: changes.pop(key) for key in ("centre_of_mass", "force", "moment") if key in changes}
    line = {"sheave": {"kind": "eyelet"}, "cable": cable, "tension_limits": (0, 1e4)} | changes
    lines = [
        line | {"name": str(i), "exit_point": tuple(A), "platform_point": tuple(B)}
        for i, (A, B) in enumerate(zip(exits, points, strict=True))
    ]
    scene = {"frame_min": (-9, -9, -9), "frame_max": (9, 9, 9)}
    given = {"name": "rigid", "scene": scene, "platform": {"kind": "rigid", "mass": MASS} | body, "lines": lines}
    return Robot.model_validate(given)


def _eight(**changes: object) -> Robot:
    return _robot(CORNERS, CROSSED, **{"centre_of_mass": CENTRE} | changes)


def _four(**changes: object) -> Robot:
    """Four crossing lines from above to a plate: two of its six degrees of freedom are held by gravity."""
    points = np.column_stack([0.2 * np.sign(CORNERS[:4, :2]) * (-1, 1), [0.05, 0.1, 0.08, 0.06]])
    return _robot(CORNERS[:4], points, **{"centre_of_mass": CENTRE} | changes)


def _pulled(robot: Robot, pose: Point, tensions: Sequence[float]) -> tuple[list[LineState], list[float]]:
    """Return straight lines at a pose and lengths that would give about those tensions, N."""
    states, lengths = machine.start(robot, pose, tensions)
    return states, [length * (1 - T / EA) for length, T in zip(lengths, tensions, strict=True)]


def _held(robot: Robot, pose: Point, pull: float) -> tuple[list[LineState], list[float]]:
    """Return straight lines at a pose and lengths that would balance there without weight, at about ``pull``, N."""
    wrenches = _springs(robot, machine.start(robot, pose, [1] * robot.m)[1], pose)[2]
    at = platform.Place.of(pose)
    load = [float(value) for value in platform.load(robot, at)]
    pulls = np.full(robot.m, float(pull))
    pulls -= np.linalg.pinv(wrenches) @ (load + wrenches @ pulls)
    assert pulls.min() > 0
    return _pulled(robot, pose, pulls)


def _springs(robot: Robot, lengths: Sequence[float], pose: Point) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return stiffness (6, 6), tensions (m,) and wrenches per tension (6, m), for massless lines from eyelets."""
    R, origin = Rotation.from_rotvec(pose[3:]).as_matrix(), np.array(pose[:3])
    K, tensions, wrenches = np.zeros((6, 6)), [], []
    for line, length in zip(robot.lines, lengths, strict=True):
        arm = R @ line.platform_point
        vector = origin + arm - line.exit_point
        reach = np.linalg.norm(vector)
        u, T = vector / reach, EA * (reach / length - 1)
        along = np.outer(u, u)
        K += _seen_from_origin(arm, EA / length * along + T / reach * (np.eye(3) - along), -T * u)
        tensions.append(T)
        wrenches.append(-np.concatenate([u, np.cross(arm, u)]))
    weight = np.array([0.0, 0.0, -robot.platform.mass * robot.scene.gravity])
    K += _seen_from_origin(R @ robot.platform.centre_of_mass, np.zeros((3, 3)), weight)
    return K, np.array(tensions), np.array(wrenches).T


def _seen_from_origin(arm: np.ndarray, block: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Return the stiffness (6, 6) of a point at ``arm`` that has the stiffness ``block`` (3, 3) and bears ``force``."""
    J = np.hstack([np.eye(3), np.cross(np.eye(3), arm).T])
    K = J.T @ block @ J
    K[3:, 3:] += arm @ force * np.eye(3) - np.outer(arm, force)
    return K


def _with_winches(robot: Robot) -> Robot:
    """Return the robot with its winches 2.5 m below its exit points."""
    exits = [(*line.exit_point[:2], line.exit_point[2] - 2.5) for line in robot.lines]
    lines = [line.model_copy(update={"winch_exit": C}) for line, C in zip(robot.lines, exits, strict=True)]
    return robot.model_copy(update={"lines": tuple(lines)})


class TestPlatform:
    @pytest.mark.parametrize("vector", [(0.0, 0.0, 0.0), (1e-9, 0.0, -2e-9), (0.3, -0.5, 0.2), (2.0, -1.0, 1.5)])
    def test_a_rotation_vector_is_scipys(self, vector: Point) -> None:
        R = platform.exponential(vector)
        np.testing.assert_allclose(np.array(R.tolist(), float), Rotation.from_rotvec(vector).as_matrix(), atol=1e-15)
        with mp.workdps(50):
            back = platform.turned_by(mp.eye(3), platform.exponential([mpf(value) for value in vector]))
        np.testing.assert_allclose([float(value) for value in back], vector, rtol=1e-15)

    def test_it_turns_in_space(self) -> None:
        """A quarter turn about z, then one about the world's x: the platform's x goes to y, then to z."""
        at = platform.Place.of((1, 2, 3, 0, 0, math.pi / 2)).moved((0, 0, 1, math.pi / 2, 0, 0))
        assert [float(value) for value in at.point((1, 0, 0))] == pytest.approx([1, 2, 5])

    def test_weight_and_push_act_where_they_should(self) -> None:
        robot = _robot([(0, 0, 0), (1, 0, 0)], [(0, 0, 0), (1, 0, 0)], centre_of_mass=(0.5, 0, 0), **PUSHED)
        got = platform.load(robot, platform.Place.of((1, 2, 3, 0, 0, math.pi / 2)))  # the centre of mass is at y = 0.5
        weight = MASS * 9.81
        want = [7, -4, 12 - weight, 0.9 - 0.5 * weight, -1.3, 0.6]
        assert [float(value) for value in got] == pytest.approx(want, abs=1e-13)


class TestMachine:
    def test_four_upright_lines_share_the_weight(self) -> None:
        """Half round a sheave and straight down, 0.1 m in from the exit point: weight, stretch and all by hand."""
        inward, w, free = 2 * SWIVEL["radius"], 0.04 * 9.81, 2.5
        points = [(x, y, 0.1) for x, y in itertools.product((-0.6, 0.6), (-0.8, 0.8))]  # 1 m from the middle
        exits = [(x * (1 + inward), y * (1 + inward), 3.0) for x, y, _ in points]
        robot = _robot(exits, points, density=0.04, sheave=SWIVEL, dead_length=1.5)
        P = MASS * 9.81 / 4
        falls = free * (1 + (P + w * free / 2) / EA)
        length = 1.5 + math.pi * SWIVEL["radius"] + free
        states = [LineState(P + w * free, -math.pi / 2, free)] * 4
        pose = (0, 0, 3 - 0.1 - falls, 0, 0, 0)
        left = machine.balance(robot, [length] * 4, pose, states)
        assert left.geometry < 1e-14
        assert max(left.force, left.turning) < 1e-12
        near = (0.01, 0.02, pose[2] - 0.01, 0.01, -0.01, 0.02)
        states, _ = machine.start(robot, near, [P] * 4)
        found = machine.solve(robot, [length] * 4, near, states)
        assert machine.distance(found.pose, pose) < 1e-14
        assert machine.angle(found.pose, pose) < 1e-14

    def test_a_bar_on_two_lines_hangs_below_where_they_meet(self) -> None:
        """Three forces balance if their lines meet: a four-bar linkage whose coupler's centre is there."""
        exits = np.array([(-2.0, 0.0, 3.0), (2.5, 0.0, 3.4)])
        points, turn = np.array([(-0.6, 0.0, 0.0), (0.7, 0.0, 0.1)]), 0.23
        R, origin = Rotation.from_rotvec((0, turn, 0)).as_matrix(), np.array([0.2, 0.0, 1.0])
        ends = origin + points @ R.T
        ways = (ends - exits) / np.linalg.norm(ends - exits, axis=1)[:, None]
        along = np.linalg.solve(np.column_stack([ways[0], -ways[1]])[[0, 2]], (exits[1] - exits[0])[[0, 2]])
        meet = exits[0] + along[0] * ways[0]
        centre = R.T @ (meet[0] - origin[0], 0.0, -0.3)
        robot = _robot(exits, points, centre_of_mass=tuple(centre))
        T = np.linalg.solve(-ways[:, [0, 2]].T, (0, MASS * 9.81))
        states, lengths = machine.start(robot, (*origin, 0, turn, 0), T)
        left = machine.balance(robot, lengths, (*origin, 0, turn, 0), states, "rigid")
        assert left.geometry < 1e-14
        assert max(left.force, left.turning) < 1e-12
        near = (*(origin + 0.01), 0.02, turn - 0.02, 0.02)
        states, _ = machine.start(robot, near, [60] * 2)
        found = machine.solve(robot, lengths, near, states, "rigid")
        assert machine.distance(found.pose, origin) < 1e-14
        assert machine.angle(found.pose, (*origin, 0, turn, 0)) < 1e-14

    def test_the_size_of_an_unbalanced_moment_is_reported(self) -> None:
        robot, pose = _eight(**PUSHED), (0.1, -0.2, 1.5, 0.1, -0.05, 0.2)
        states, lengths = _held(robot, pose, 250)
        found = machine.solve(robot, lengths, pose, states, "elastic")
        assert max(found.balance.force, found.balance.turning, found.balance.geometry) < 1e-20
        twisted = robot.platform.model_copy(update={"moment": (0.9, -1.3 + 3, 0.6 + 4)})
        left = machine.balance(
            robot.model_copy(update={"platform": twisted}), lengths, found.pose, found.states, "elastic"
        )
        assert left.turning == pytest.approx(5, rel=1e-14)
        assert left.force < 1e-20

    def test_it_finds_the_same_from_elsewhere(self) -> None:
        robot = _eight(density=0.05)
        states, lengths = _pulled(robot, (0.1, -0.2, 1.5, 0.1, -0.05, 0.2), [150] * 8)
        first = machine.solve(robot, lengths, (0.1, -0.2, 1.5, 0.1, -0.05, 0.2), states)
        elsewhere = (0.0, -0.1, 1.6, -0.1, 0.1, 0.0)
        second = machine.solve(robot, lengths, elsewhere, machine.start(robot, elsewhere, [150] * 8)[0])
        assert machine.distance(first.pose, second.pose) < 1e-20
        assert machine.angle(first.pose, second.pose) < 1e-20

    def test_the_platforms_frame_is_anyones_choice(self) -> None:
        """Drawn in a frame turned by 2.5 rad the same body hangs the same: its rotation is that much more."""
        frame, pose = Rotation.from_rotvec((1.5, -1.2, 1.6)), (0.1, -0.2, 1.5, 0.1, -0.05, 0.2)
        points, centre = frame.inv().apply(CROSSED), frame.inv().apply(CENTRE)
        robot, redrawn = _eight(**PUSHED), _robot(CORNERS, points, centre_of_mass=tuple(centre), **PUSHED)
        states, lengths = _held(robot, pose, 250)
        turned = (*pose[:3], *(Rotation.from_rotvec(pose[3:]) * frame).as_rotvec())
        assert np.linalg.norm(turned[3:]) > 2.4
        first = machine.solve(robot, lengths, pose, states, "elastic")
        second = machine.solve(redrawn, lengths, turned, states, "elastic")
        assert machine.distance(first.pose, second.pose) < 1e-14
        want = Rotation.from_rotvec([float(value) for value in first.pose[3:]]) * frame
        assert machine.angle((0, 0, 0, *want.as_rotvec()), second.pose) < 1e-14
        rest = mujoco_model.rest(redrawn, lengths, turned)
        assert machine.distance(rest.pose, second.pose) < 1e-13
        assert machine.angle(rest.pose, second.pose) < 1e-13
        one = linear.stiffness(robot, lengths, first.pose, first.states, "elastic")
        other = linear.stiffness(redrawn, lengths, second.pose, second.states, "elastic")
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-12 * one.max())  # in space, so the frame is no matter
        one = linear.motion(robot, lengths, first.pose, first.states, "elastic")
        other = linear.motion(redrawn, lengths, second.pose, second.states, "elastic")
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-11)


class TestLinear:
    POSE = (0.1, -0.2, 1.5, 0.3, -0.2, 0.4)

    def test_massless_lines_from_eyelets_are_springs(self) -> None:
        robot = _eight()
        states, lengths = _pulled(robot, self.POSE, range(60, 220, 20))
        got = linear.stiffness(robot, lengths, self.POSE, states, "elastic")  # no equilibrium, and none is needed
        np.testing.assert_allclose(got, _springs(robot, lengths, self.POSE)[0], rtol=0, atol=1e-12 * got.max())

    def test_four_upright_lines_are_a_pendulum(self) -> None:
        """The platform points are free to swing round their sheaves and hang from them inwards."""
        r, free = SWIVEL["radius"], 2.5
        points = [(x, y, 0.1) for x, y in itertools.product((-0.6, 0.6), (-0.8, 0.8))]
        exits = [(x * (1 + 2 * r), y * (1 + 2 * r), 3.0) for x, y, _ in points]
        robot = _robot(exits, points, sheave=SWIVEL, arc_elastic=True, centre_of_mass=CENTRE)
        T = MASS * 9.81 / 4
        length = free + math.pi * r / (1 + T / EA)
        falls = free * (1 + T / EA)
        pose, states = (0, 0, 3 - 0.1 - falls, 0, 0, 0), [LineState(T, -math.pi / 2, free)] * 4
        want = _seen_from_origin(np.array(CENTRE), np.zeros((3, 3)), np.array([0, 0, -4 * T]))
        for B in np.array(points):
            block = np.diag([0, 0, EA / length])
            block[:2, :2] = T / falls * np.outer(B[:2], B[:2])
            want += _seen_from_origin(B, block, np.array([0, 0, T]))
        got = linear.stiffness(robot, [length] * 4, pose, states, "elastic")
        np.testing.assert_allclose(got, want, rtol=0, atol=1e-12 * want.max())

    @pytest.mark.parametrize(
        ("changes", "model"),
        [
            ({"density": 0.05}, "catenary"),
            ({"density": 0.05, "force": (7.0, -4.0, 12.0)}, "catenary"),
            ({"sheave": SWIVEL, "arc_elastic": True}, "elastic"),
        ],
        ids=["sagging", "pushed", "swivels"],
    )
    def test_where_energy_is_kept_it_is_symmetric(self, changes: dict[str, object], model: str) -> None:
        robot = _eight(**changes)
        states, lengths = _held(robot, self.POSE, 250)
        found = machine.solve(robot, lengths, self.POSE, states, model)
        K = linear.stiffness(robot, lengths, found.pose, found.states, model)
        assert np.abs(K - K.T).max() < 1e-15 * K.max()
        assert np.linalg.eigvalsh(K).min() > 0

    def test_a_moment_that_does_not_turn_with_the_platform_keeps_no_energy(self) -> None:
        robot = _eight(density=0.05, **PUSHED)
        states, lengths = _held(robot, self.POSE, 250)
        found = machine.solve(robot, lengths, self.POSE, states)
        K = linear.stiffness(robot, lengths, found.pose, found.states)
        want = np.zeros((6, 6))
        x, y, z = PUSHED["moment"]
        want[3:, 3:] = [[0, z, -y], [-z, 0, x], [y, -x, 0]]
        np.testing.assert_allclose(K - K.T, want, rtol=0, atol=1e-14 * K.max())

    def test_a_symmetric_robot_is_held_in_yaw_by_its_tension_alone(self) -> None:
        """No line turns it: the structure matrix has rank 5. A pull turned aside still brings it back."""
        points = np.column_stack([0.1 * CORNERS[:, :2], CROSSED[:, 2]])  # every line's plane holds the middle axis
        robot = _robot(CORNERS, points, centre_of_mass=(0, 0, -0.1))
        pose, T = (0, 0, 1.6, 0, 0, 0), 90.0
        states, lengths = machine.start(robot, pose, [T] * 8)
        lengths = [length / (1 + T / EA) for length in lengths]
        assert np.linalg.matrix_rank(_springs(robot, lengths, pose)[2]) == 5
        K = linear.stiffness(robot, lengths, pose, states, "elastic")
        out, arm = np.hypot(*CORNERS[:, :2].T), np.hypot(*points[:, :2].T)
        spans = np.linalg.norm(np.array(pose[:3]) + points - CORNERS, axis=1)
        assert K[5, 5] == pytest.approx((T * out * arm / spans).sum(), rel=1e-12)
        assert np.abs(K[5, :5]).max() < 1e-9

    def test_motions_are_those_of_springs(self) -> None:
        robot = _eight()
        states, lengths = _held(robot, self.POSE, 250)
        found = machine.solve(robot, lengths, self.POSE, states, "elastic")
        K, tensions, wrenches = _springs(robot, lengths, [float(value) for value in found.pose])
        change = -(tensions + EA) / lengths * wrenches  # dT/dL = -(T + EA)/L
        got = linear.motion(robot, lengths, found.pose, found.states, "elastic")
        np.testing.assert_allclose(got, np.linalg.solve(K, change), rtol=0, atol=1e-10 * np.abs(got).max())

    @pytest.mark.parametrize("sheave", [SWIVEL, JOINT], ids=["swivels", "levers"])
    def test_motions_are_differences_of_solutions(self, sheave: dict[str, object]) -> None:
        robot = _with_winches(_four(density=0.05, sheave=sheave))
        pose = (0.1, -0.2, 1.2, 0.05, -0.02, 0.1)
        states, lengths = _pulled(robot, pose, [50] * 4)
        found = machine.solve(robot, lengths, pose, states)
        got, step = linear.motion(robot, lengths, found.pose, found.states), mpf(10) ** -18
        assert np.linalg.matrix_rank(got) == 4
        with mp.workdps(50):
            longer = [mpf(lengths[0]), mpf(lengths[1]) + step, *lengths[2:]]
            moved = machine.solve(robot, longer, found.pose, found.states)
            turn = platform.turned_by(platform.Place.of(found.pose).rotation, platform.Place.of(moved.pose).rotation)
            want = [(b - a) / step for a, b in zip(found.pose[:3], moved.pose[:3], strict=True)]
            want += [value / step for value in turn]
        np.testing.assert_allclose(got[:, 1], [float(value) for value in want], rtol=1e-12)

    def test_four_lines_hold_four_degrees_of_freedom_and_gravity_two(self) -> None:
        robot, pose = _four(), (0.1, -0.2, 1.2, 0.05, -0.02, 0.1)
        states, lengths = _pulled(robot, pose, [50] * 4)
        found = machine.solve(robot, lengths, pose, states, "elastic")
        wrenches = _springs(robot, lengths, [float(value) for value in found.pose])[2]
        ways = np.linalg.svd(wrenches)[0]
        K = ways.T @ linear.stiffness(robot, lengths, found.pose, found.states, "elastic") @ ways
        assert 1 < np.linalg.eigvalsh(K[4:, 4:]).min() < np.linalg.eigvalsh(K[4:, 4:]).max() < MASS * 9.81
        assert np.linalg.eigvalsh(K[:4, :4]).min() > 3000
        got = linear.motion(robot, lengths, found.pose, found.states, "elastic")
        np.testing.assert_allclose(-wrenches.T @ got, np.eye(4), atol=2e-3)  # each lets its own point go, and no other


EVEN = {"arc_elastic": True}
CASES = {
    "eyelets": _eight(**EVEN),
    "eyelets, pushed": _eight(**EVEN, **PUSHED),
    "swivels": _eight(sheave=SWIVEL, **EVEN),
    "swivels, pushed": _eight(sheave=SWIVEL, **EVEN, **PUSHED),
    "suspended": _four(**EVEN),
    "suspended over swivels": _four(sheave=SWIVEL, **EVEN),
    "suspended over levers": _with_winches(_four(sheave=JOINT, **EVEN)),
    "bar": _robot(CORNERS[[0, 2]], CROSSED[[2, 0]], centre_of_mass=(0.05, 0.02, -0.4), **EVEN),
}


class TestMujoco:
    @pytest.mark.parametrize("name", CASES)
    @pytest.mark.parametrize("seed", some(range(3)))
    def test_it_rests_where_massless_elastic_lines_balance(self, name: str, seed: int) -> None:
        robot, rng = CASES[name], np.random.default_rng(seed)
        pose = rng.uniform([-0.4, -0.3, 1.2, -0.3, -0.3, -0.3], [0.4, 0.3, 1.7, 0.3, 0.3, 0.3])
        _, lengths = _pulled(robot, pose, rng.uniform(50, 250, robot.m))
        start = pose + rng.uniform(-0.05, 0.05, 6)
        self._compare(robot, lengths, mujoco_model.rest(robot, lengths, start))

    def test_lines_let_out_hang_slack(self) -> None:
        robot, pose = CASES["swivels, pushed"], (0.1, -0.2, 1.5, 0.1, -0.05, 0.2)
        _, lengths = _pulled(robot, pose, [150] * 8)
        lengths = [length + (0.2 if i in (4, 7) else 0.0) for i, length in enumerate(lengths)]
        rest = mujoco_model.rest(robot, lengths, pose)
        assert 0 < (rest.tensions == 0).sum() < 6
        self._compare(robot, lengths, rest)

    @pytest.mark.parametrize("name", ["jung2020", "cogiro"])
    def test_it_holds_a_library_robot(self, name: str) -> None:
        robot = load(name)
        robot = robot.model_copy(update={"lines": tuple(line.model_copy(update=EVEN) for line in robot.lines)})
        pose = (0.1, -0.2, 0.4, 0.02, 0.05, -0.1)
        _, lengths = machine.start(robot, pose, [1] * 8)
        lengths = [length * (1 - 100 / line.cable.stiffness) for length, line in zip(lengths, robot.lines, strict=True)]
        self._compare(robot, lengths, mujoco_model.rest(robot, lengths, pose))

    @staticmethod
    def _compare(robot: Robot, lengths: list[float], rest: mujoco_model.Rest) -> None:
        states, _ = machine.start(robot, rest.pose, np.maximum(rest.tensions, 1))
        states = [state if T > 0 else None for state, T in zip(states, rest.tensions, strict=True)]
        found = machine.solve(robot, lengths, rest.pose, states, "elastic")
        tensions = [0.0 if state is None else float(state.tension) for state in found.states]
        assert rest.left_over < 1e-8
        assert machine.distance(found.pose, rest.pose) < 1e-10
        assert machine.angle(found.pose, rest.pose) < 1e-10
        assert found.balance.geometry < 1e-14  # also, lines marked as slack are slack
        assert list(rest.tensions) == pytest.approx(tensions, rel=1e-8, abs=1e-8)
