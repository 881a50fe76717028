"""Platforms in a plane: what holds them, the way back, derivatives, margins, modes and areas; and what is rejected."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

import cablewright as cw
import cases
import planar_robots
from cablewright.foundation.errors import AnswerError, InputError, Status
from cablewright.models.inertia import mass_matrix
from cablewright.models.stiffness import stiffness
from cablewright.robot import Robot
from cablewright.solvers.continuation import Tracker
from cablewright.solvers.line_cover import refuse_unfit
from cablewright.solvers.linearise import tension_changes
from cablewright.solvers.tension import self_stresses, structures
from oracles import linear_program

KINDS = [(plane, body) for plane in planar_robots.PLANES for body in (False, True)]
STEP = 2e-6  # m


def free_of(robot: Robot) -> np.ndarray:
    """Orthonormal columns of the free directions."""
    a, b, n = planar_robots.frame(robot)
    if robot.n == 3:
        return np.column_stack([a, b])
    zero = np.zeros(3)
    return np.column_stack([np.r_[a, zero], np.r_[b, zero], np.r_[zero, n]])


def feasible(robot: Robot, pose: np.ndarray) -> bool:
    """Whether tensions within the limits, and any reaction of the plane, balance the load: by HiGHS."""
    A, w = linear_program.structure(robot, pose)
    held = np.linalg.svd(free_of(robot), full_matrices=True)[0][:, robot.freedoms :]
    limits = [planar_robots.LIMITS] * robot.m + [(None, None)] * held.shape[1]
    return bool(linprog(np.zeros(len(limits)), A_eq=np.hstack([A, held]), b_eq=-w, bounds=limits).status == 0)


def solved(plane: str, body: bool, cable: str, count: int, **own: Any) -> tuple[Robot, cw.Equilibrium]:
    robot = planar_robots.board(plane, body, force=(3.0, -2.0, 4.0), **own)
    held = cw.inverse(robot, planar_robots.places(robot, 3 * count), cable=cable)
    held = held[held.ok]
    assert len(held) >= count
    return robot, held[:count]


@pytest.mark.parametrize("cable", ["rigid", "elastic"])
@pytest.mark.parametrize(("plane", "body"), KINDS)
def test_yes_and_no_are_those_of_a_linear_program(plane: str, body: bool, cable: str) -> None:
    robot = planar_robots.board(plane, body, 4, 0.08, force=(5.0, 0.0, 8.0))
    poses = planar_robots.places(robot, cases.often(60, 150), 1.3, 0.3)
    possible = [feasible(robot, pose) for pose in poses]
    assert 0.1 * len(possible) < sum(possible) < 0.9 * len(possible)
    found = cw.inverse(robot, poses, cable=cable)
    if not body:
        np.testing.assert_array_equal(found.ok, possible)
        assert {status for status in found.status if status is not Status.OK} == {Status.INFEASIBLE}
    else:  # of those that balance some are not stable
        assert not (found.ok & ~np.array(possible)).any()
        lost = {status for status, could in zip(found.status, possible, strict=True) if could} - {Status.OK}
        assert lost <= {Status.UNSTABLE}
        assert found.ok.sum() > 4
    assert found[found.ok].is_valid()


@pytest.mark.parametrize("cable", ["elastic", "catenary"])
@pytest.mark.parametrize(("plane", "body"), KINDS)
def test_the_way_back(plane: str, body: bool, cable: str) -> None:
    robot, held = solved(plane, body, cable, 15)
    n = planar_robots.frame(robot)[2]
    for guess in (None, held.pose, planar_robots.places(robot, 15, seed=7)):
        found = cw.forward(robot, held.lengths, cable=cable, guess=guess).checked()
        np.testing.assert_allclose(found.pose, held.pose, atol=1e-9)
        np.testing.assert_allclose(found.pose[:, :3] @ n, planar_robots.DISTANCE, atol=1e-15)
        np.testing.assert_allclose(found.plane_force, held.plane_force, atol=1e-5)
    single = cw.forward(robot, held.lengths[0], cable=cable)
    assert isinstance(single.plane_force, float)
    assert single.to_dict()["plane_force"] == pytest.approx(held.plane_force[0], abs=1e-5)


def moved_from(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """The motion (n,) between poses, m and rad."""
    turn = Rotation.from_rotvec(end[3:]) * Rotation.from_rotvec(start[3:]).inv() if len(start) == 6 else None
    return np.r_[end[:3] - start[:3], [] if turn is None else turn.as_rotvec()]


def changed(robot: Robot, i: int, key: str, axis: int, by: float) -> Robot:
    point = list(getattr(robot.lines[i], key))
    point[axis] += by
    lines = list(robot.lines)
    lines[i] = lines[i].model_copy(update={key: tuple(point)})
    return robot.model_copy(update={"lines": tuple(lines)})


@pytest.mark.parametrize("cable", ["elastic", "catenary"])
@pytest.mark.parametrize(("plane", "body"), KINDS)
def test_derivatives_are_differences(plane: str, body: bool, cable: str) -> None:
    robot, held = solved(plane, body, cable, 2)
    linear, free = cw.linearise(held), free_of(robot)
    K = linear.stiffness
    np.testing.assert_allclose(K, np.swapaxes(K, 1, 2), atol=1e-9 * np.abs(K).max())
    np.testing.assert_allclose(K @ free @ free.T, K, atol=1e-12 * np.abs(K).max())
    assert (np.linalg.eigvalsh(free.T @ K @ free) > 0.0).all()
    np.testing.assert_allclose(stiffness(held).total, K, atol=1e-9 * np.abs(K).max())
    pose, lengths, own = held.pose[0], held.lengths[0], linear[0]
    changes = tension_changes(held[:1])

    def difference(made: Any) -> tuple[np.ndarray, np.ndarray]:
        ends = [cw.forward(*made(by), cable=cable, guess=pose).checked() for by in (-STEP, STEP)]
        motion = (moved_from(pose, ends[1].pose) - moved_from(pose, ends[0].pose)) / (2 * STEP)
        return motion, (ends[1].tensions - ends[0].tensions) / (2 * STEP)

    for i in range(robot.m):
        unit = np.eye(robot.m)[i]
        motion, tensions = difference(lambda by: (robot, lengths + by * unit))  # noqa: B023
        near(motion, own.per_length[:, i])
        by_motion = changes.following(own.per_length[None, :, i : i + 1])[0, :, 0] + changes.per_length[0] * unit
        near(tensions, by_motion)
    for axis in range(3):
        near(difference(lambda by: (changed(robot, 1, "exit_point", axis, by), lengths))[0],  # noqa: B023
             own.per_exit_point[:, 1, axis])  # fmt: skip
        if body:
            near(difference(lambda by: (changed(robot, 1, "platform_point", axis, by), lengths))[0],  # noqa: B023
                 own.per_platform_point[:, 1, axis])  # fmt: skip
        pushed = [robot.under_wrench(np.array([3.0, -2.0, 4.0]) + by * np.eye(3)[axis]) for by in (-0.01, 0.01)]
        ends = [cw.forward(each, lengths, cable=cable, guess=pose).checked().pose for each in pushed]
        near((moved_from(pose, ends[1]) - moved_from(pose, ends[0])) / 0.02, own.per_wrench[:, axis])
    across = np.r_[planar_robots.frame(robot)[2], np.zeros(robot.n - 3)]
    np.testing.assert_allclose(own.per_wrench @ across, 0.0, atol=1e-12)


def near(found: np.ndarray, expected: np.ndarray) -> None:
    np.testing.assert_allclose(found, expected, rtol=2e-5, atol=2e-6 * max(np.abs(expected).max(), 1e-3))


@pytest.mark.parametrize(("plane", "body"), KINDS)
def test_margins_are_those_of_a_linear_program(plane: str, body: bool) -> None:
    robot = planar_robots.board(plane, body, 6 if body else 4, force=(5.0, 0.0, 8.0))
    free, poses = free_of(robot), planar_robots.places(robot, 40, 1.2, 0.3)
    low, high = (np.full(robot.m, limit) for limit in planar_robots.LIMITS)
    exact = cw.tension_distribution(robot, poses, "exact")
    least = cw.tension_distribution(robot, poses, "least-norm")
    np.testing.assert_array_equal(exact.feasible, least.feasible)
    A, w = structures(cw.Model.of(robot, cable="rigid"), poses)
    for row, pose in enumerate(poses):
        B, load = linear_program.structure(robot, pose)
        margin = linear_program.margin(free.T @ B, free.T @ load, low, high)
        assert exact.margin[row] == pytest.approx(margin, abs=1e-6)
        np.testing.assert_allclose(A[row], free @ free.T @ B, atol=1e-12)
        np.testing.assert_allclose(w[row], free @ free.T @ load, atol=1e-12)
        for found in (exact, least):
            if found.feasible[row]:
                np.testing.assert_allclose(free.T @ (B @ found.tensions[row] + load), 0.0, atol=1e-7)


@pytest.mark.parametrize("plane", planar_robots.PLANES)
def test_the_capacity_margin_is_the_distance_from_a_polygon(plane: str) -> None:
    robot = planar_robots.board(plane, force=(5.0, 0.0, 8.0))
    free, poses = free_of(robot), planar_robots.places(robot, 20, 0.8)
    found = cw.capacity(robot, poses)
    for row, pose in enumerate(poses):
        A, w = (free.T @ part for part in linear_program.structure(robot, pose))
        sides = np.array([A[1], -A[0]]).T / np.linalg.norm(A, axis=0)[:, None]  # a polygon's are along its lines
        around = np.vstack([sides, -sides])
        pulls = -around @ A
        reach = np.maximum(pulls * planar_robots.LIMITS[0], pulls * planar_robots.LIMITS[1]).sum(axis=1)
        assert found.margin[row] == pytest.approx((reach - around @ w).min(), abs=1e-9)
        assert found.rank[row] == 2
    closed = cw.wrench_closure(robot, poses)
    assert closed.feasible.all()  # between four corners
    assert not cw.wrench_closure(robot, planar_robots.places(robot, 40, 1.9)).feasible.all()


def test_a_box_of_wrenches_is_along_axes() -> None:
    robot = planar_robots.board("vertical")
    pose, load = planar_robots.places(robot, 1)[0], np.array([0.0, 0.0, 5.0])
    boxed = cw.capacity(
        robot, pose, box=(load - np.array([1, 50, 2]), load + np.array([1, 50, 2]))
    )  # what is across is the plane's
    corners = [cw.capacity(robot, pose, wrench=load + np.array([x, 0.0, z])).margin for x in (-1, 1) for z in (-2, 2)]
    assert boxed.margin == pytest.approx(min(corners), abs=1e-9)
    with pytest.raises(InputError, match="along the world's axes, and the plane of the platform is tilted"):
        cw.capacity(
            planar_robots.board("tilted"), planar_robots.places(planar_robots.board("tilted"), 1), box=(-load, load)
        )


def test_self_stresses_balance_in_the_plane() -> None:
    robot, held = solved("tilted", True, "rigid", 1, lines=6)
    directions = self_stresses(held[0])
    assert directions.shape == (3, 6)
    A, _ = linear_program.structure(robot, held.pose[0])
    np.testing.assert_allclose(free_of(robot).T @ A @ directions.T, 0.0, atol=1e-12)


@pytest.mark.parametrize(("plane", "body"), KINDS)
def test_modes_are_those_of_the_free_directions(plane: str, body: bool) -> None:
    robot, held = solved(plane, body, "catenary", 3)
    found, free = cw.modes(held), free_of(robot)
    assert found.frequencies.shape == (3, robot.freedoms)
    for row in range(3):
        M = mass_matrix(robot, held.pose[row])
        K = cw.linearise(held).stiffness[row]
        squares = eigh(free.T @ (0.5 * (K + K.T)) @ free, free.T @ M @ free, eigvals_only=True)
        np.testing.assert_allclose(found.frequencies[row], np.sqrt(squares) / (2 * np.pi), rtol=1e-6)
        shapes = found.shapes[row]
        np.testing.assert_allclose(shapes.T @ M @ shapes, np.eye(robot.freedoms), atol=1e-9)
        np.testing.assert_allclose(free @ free.T @ shapes, shapes, atol=1e-12)
        np.testing.assert_allclose(found.participation[row].sum(axis=0), 1.0)
    assert found.to_dict()["frequencies"]


def test_a_point_on_one_belt_is_a_plumb_on_its_board() -> None:
    robot = planar_robots.board("vertical", lines=3)
    robot = robot.model_copy(update={"lines": robot.lines[2:]})
    held = cw.inverse(robot, [np.nan, planar_robots.DISTANCE, -0.6], cable="elastic").checked()
    assert held.pose[0] == pytest.approx(robot.lines[0].exit_point[0], abs=1e-9)
    drop = robot.lines[0].exit_point[2] - held.pose[2]
    away = robot.lines[0].exit_point[1] - planar_robots.DISTANCE
    assert held.tensions[0] == pytest.approx(planar_robots.MASS * 9.81 * np.hypot(drop, away) / drop, rel=1e-9)
    assert held.plane_force == pytest.approx(planar_robots.MASS * 9.81 * away / drop, rel=1e-9)
    assert held.is_valid()


@pytest.mark.parametrize("cable", ["elastic", "catenary"])
def test_a_sled_on_two_belts_finds_its_turn(cable: str) -> None:
    """Two belts hold the sled of a router; gravity decides how it is turned."""
    robot = planar_robots.board("vertical", True, 4, centre_of_mass=(0.02, 0.0, -0.25))
    robot = robot.model_copy(update={"lines": robot.lines[2:]})
    assert robot.lines[0].exit_point[2] > 0.5
    held = cw.inverse(robot, [0.1, planar_robots.DISTANCE, -0.2, 0.0, np.nan, 0.0], cable=cable).checked()
    assert held.is_valid()
    np.testing.assert_array_equal(held.pose[[3, 5]], 0.0)
    assert held.pose[:3] == pytest.approx([0.1, planar_robots.DISTANCE, -0.2], abs=1e-12)
    found = cw.forward(robot, held.lengths, cable=cable).checked()
    np.testing.assert_allclose(found.pose, held.pose, atol=1e-9)
    with pytest.raises(InputError, match="2 lines hold 2 of the 3 degrees of freedom; 3 are given: leave 1 free"):
        cw.inverse(robot, [0.1, planar_robots.DISTANCE, -0.2])
    with pytest.raises(InputError, match=r"what the plane y = 0\.02 m holds cannot be left free"):
        cw.inverse(robot, [0.1, np.nan, -0.2, 0.0, 0.0, np.nan])
    np.testing.assert_array_equal(cw.inverse(robot, [0.1, np.nan, -0.2, 0, np.nan, 0], cable=cable).pose, held.pose)
    tilted = planar_robots.board("tilted", True, 2)
    with pytest.raises(InputError, match="2 lines hold 3 degrees of freedom in a plane across x, y or z alone"):
        cw.inverse(tilted, [0.1, planar_robots.DISTANCE, -0.2, 0.0, np.nan, 0.0])


@pytest.mark.parametrize("body", [False, True])
def test_a_tracker_follows_in_the_plane_and_proves_each_step(body: bool) -> None:
    robot, held = solved("tilted", body, "catenary", 1)
    tracker = Tracker(cw.Model.of(robot), held.lengths[0])
    aim = held.lengths[0] + np.array([1e-3, -2e-4, -1e-3, 5e-4])
    assert tracker.step(aim) is Status.OK
    np.testing.assert_allclose(tracker.pose, cw.forward(robot, aim, guess=tracker.pose).pose, atol=1e-9)


def test_the_area_is_that_of_belts_in_the_plane() -> None:
    held, loose = (planar_robots.board("vertical", off=0.0, held=kept) for kept in (True, False))
    found, same = cw.workspace_area(held), cw.workspace_area(loose)
    assert found.status == same.status == "ok"
    assert found.area == pytest.approx(same.area, abs=found.area_error + same.area_error)
    assert found.normal == "y"
    assert found.box.low[1] == found.box.high[1] == planar_robots.DISTANCE


@pytest.mark.parametrize("criterion", ["exact", "capacity", "wrench-closure", "static"])
@pytest.mark.parametrize(("plane", "body"), [kind for kind in KINDS if kind[0] != "tilted"])
def test_areas_are_those_of_their_places(plane: str, body: bool, criterion: str) -> None:
    robot = planar_robots.board(plane, body)
    settings: dict[str, Any] = {"tolerance": 0.05} if criterion == "static" else {}
    found = cw.workspace_area(robot, criterion, **settings)
    assert found.status == "ok"
    places = np.random.default_rng(3).uniform(found.box.low, found.box.high, (4000, 3))
    inside = found.criterion.margin(places) >= 0.0
    share = inside.mean()
    assert 0.05 < share < 0.95
    assert found.fraction == pytest.approx(share, abs=4.0 * np.sqrt(share * (1 - share) / 4000) + 0.01)


def test_the_area_of_a_nozzle_beside_the_plane_is_beside_it() -> None:
    robot = planar_robots.board("vertical", True, nozzle=(0.05, 0.03, -0.1))
    found, origins = cw.workspace_area(robot), cw.workspace_area(robot, point="origin")
    assert found.box.low[1] == pytest.approx(planar_robots.DISTANCE + 0.03)
    assert origins.box.low[1] == planar_robots.DISTANCE
    places = np.random.default_rng(4).uniform(origins.box.low, origins.box.high, (50, 3))
    margins = origins.criterion.margin(places)
    np.testing.assert_allclose(found.criterion.margin(places + [0.05, 0.03, -0.1]), margins, atol=1e-9)  # noqa: RUF005


def test_places_out_of_the_plane_are_rejected() -> None:
    for plane, at in (("vertical", "y = 0.02 m"), ("horizontal", "z = -0.02 m")):
        robot = planar_robots.board(plane)
        with pytest.raises(InputError, match=f"pose 0.1, 0.3, 0.5: -?0[.]\\d+ m off the platform's plane {at}"):
            cw.inverse(robot, [0.1, 0.3, 0.5])
    body = planar_robots.board("vertical", True)
    with pytest.raises(InputError, match=r"turned by 0\.1 rad out of the platform's plane y = 0\.02 m"):
        cw.inverse(body, [0.1, planar_robots.DISTANCE, 0.2, 0.1, 0.3, 0.0])
    with pytest.raises(InputError, match=r"guess .* m off the platform's plane with normal 0\.1881, 0\.9407"):
        cw.forward(planar_robots.board("tilted"), np.ones(4), guess=[0.0, 0.0, 0.0])
    near_it = [0.1, planar_robots.DISTANCE + 5e-10, 0.3]
    assert cw.inverse(planar_robots.board("vertical"), near_it).pose[1] == planar_robots.DISTANCE
    with pytest.raises(InputError, match="none can be free"):
        cw.inverse(planar_robots.board("vertical"), [0.1, planar_robots.DISTANCE, np.nan])


@pytest.mark.parametrize("plane", planar_robots.PLANES)
def test_a_plane_decides_one_coordinate(plane: str) -> None:
    robot = planar_robots.board(plane)
    for pose in planar_robots.places(robot, 5):
        for k in np.flatnonzero(robot.platform.plane.across):
            asked = np.where(np.arange(3) == k, np.nan, pose)
            np.testing.assert_allclose(cw.inverse(robot, asked).pose, pose, atol=1e-14)
            assert cw.tension_distribution(robot, asked).feasible == cw.tension_distribution(robot, pose).feasible
    with pytest.raises(InputError):
        cw.inverse(robot, [np.nan] * 3)


def test_a_table_carries_what_no_line_has_to() -> None:
    robot = planar_robots.board("horizontal")
    with pytest.raises(
        InputError, match="the plane carries the whole load: a line's tension_limits must begin above 0"
    ):
        cw.inverse(robot.limited((0.0, 300.0)), planar_robots.places(robot, 1))
    with pytest.raises(InputError, match="the whole load: 1 lines leave degrees of freedom undetermined"):
        cw.inverse(planar_robots.board("horizontal", lines=1), [0.0, np.nan, -planar_robots.DISTANCE])


def test_what_does_not_know_planes_rejects_them() -> None:
    robot = planar_robots.board()
    held = cw.inverse(robot, planar_robots.places(robot, 1)[0]).checked()
    with pytest.raises(InputError, match=r"robot 'board' has platform\.plane; not supported"):
        refuse_unfit(cw.Model.of(robot), held.lengths)
    for box in (None, (-1, 1, 0, 0, -1, 1)):
        with pytest.raises(InputError, match=r"moves in the plane y = 0\.02 m: only an area in that plane"):
            (cw.workspace if box is None else cw.workspace_area)(robot, box=box)
    why = r"moves in the plane with normal 0\.1881, 0\.9407, 0\.2822 at 0\.02 m: only an area in that plane"
    for box in (None, (0.5, 1, 0.5, 1, 0.5, 1)):
        with pytest.raises(InputError, match=why):
            (cw.workspace if box is None else cw.workspace_area)(planar_robots.board("tilted"), box=box)


@pytest.mark.parametrize("body", [False, True])
def test_the_area_in_a_tilted_plane_is_that_of_a_linear_program(body: bool) -> None:
    robot = planar_robots.board("tilted", body, 4, 0.08, force=(5.0, 0.0, 8.0))
    found = cw.workspace_area(robot, tolerance=0.01)
    assert (found.status, found.normal) == ("ok", "0.1881, 0.9407, 0.2822")
    a, b, n = planar_robots.frame(robot)
    uv = np.random.default_rng(3).uniform(-2.2, 2.2, (600, 2))
    poses = uv @ np.array([a, b]) + planar_robots.DISTANCE * n
    framed = (np.abs(poses) <= 2.0).all(axis=1)
    if body:
        poses = np.hstack([poses, np.zeros_like(poses)])
    share = np.mean([kept and feasible(robot, pose) for kept, pose in zip(framed, poses, strict=True)])
    assert 0.1 < share < 0.9
    assert found.area == pytest.approx(4.4**2 * share, abs=4.0 * 4.4**2 * np.sqrt(share * (1.0 - share) / 600))
    (outline,) = found.outlines
    np.testing.assert_allclose(outline @ n, planar_robots.DISTANCE, atol=1e-12)
    u, v = outline @ a, outline @ b
    shoelace = 0.5 * abs(u @ np.roll(v, -1) - v @ np.roll(u, -1))
    assert shoelace == pytest.approx(found.area, rel=1e-3)


def test_a_box_cuts_a_tilted_plane() -> None:
    """All of a box can be reached where limits are wide; the diagonal plane of a cube is a hexagon."""
    table = planar_robots.board("tilted", lines=4, off=1.0).model_dump(by_alias=True)
    table["platform"]["plane"] |= {"normal": (1.0, 1.0, 1.0), "distance": 0.0}
    table["scene"]["gravity"] = 0.0
    ends = [(9.0, 0.0, 0.0), (-9.0, 1.0, 0.0), (0.0, 9.0, 0.0), (0.0, -9.0, 1.0)]
    for line, end in zip(table["lines"], ends, strict=True):
        line |= {"exit_point": end, "tension_limits": (1.0, 1e4)}
    found = cw.workspace_area(Robot.model_validate(table), tolerance=0.005, box=(-1, 1, -1, 1, -1, 1))
    assert found.area == pytest.approx(3.0 * np.sqrt(3.0), abs=found.area_error)
    assert found.fraction == pytest.approx(1.0, abs=0.01)
    assert found.perimeter == pytest.approx(6.0 * np.sqrt(2.0), rel=0.01)


def test_lines_that_cannot_hold_it_are_reported() -> None:
    found = cw.inverse(planar_robots.board("vertical", lines=2), [0.0, planar_robots.DISTANCE, 0.0])  # both from below
    assert found.status is Status.INFEASIBLE
    with pytest.raises(AnswerError, match="push"):
        found.checked()


def test_kernels_keep_one_signature() -> None:
    for body in (False, True):
        for plane in planar_robots.PLANES:
            robot, held = solved(plane, body, "catenary", 2)
            cw.forward(robot, np.repeat(held.lengths, 40, axis=0)).checked()
            cw.linearise(held)
    cases.assert_one_signature_per_kernel()
