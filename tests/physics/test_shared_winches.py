"""Lines that share a winch: tensions that balance the platform and fit the drum, against energies and searches."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike
from scipy.optimize import linprog, minimize, root

import cablewright as cw
import out_of_plane
from cablewright.foundation.arrays import Array
from cablewright.robot import Robot, SharedWinch, load
from cablewright.solvers.hardware_limits import winch_torques

EA, MASS, G = 60e3, 6.0, 9.81
FREE = [np.nan] * 3


def shared(robot: Robot, *pairs: tuple[int, int, float, str]) -> Robot:
    """The *robot* with line i on the drum of line j, for (i, j, offset, winds)."""
    lines = list(robot.lines)
    for i, j, offset, winds in pairs:
        own = SharedWinch(line=lines[j].name, offset=offset, winds=winds)
        lines[i] = lines[i].model_copy(update={"shared_winch": own})
    return out_of_plane.checked(robot.model_copy(update={"lines": tuple(lines)}))


def parallelograms(count: int, *, density: float = 0.002, **line: Any) -> Robot:
    """A body on *count* pairs of parallel lines, each on one winch."""
    lines = []
    for pair in range(count):
        angle, sign = 2.0 * np.pi * pair / count + 0.3, (-1) ** pair
        out, across = np.array([np.cos(angle), np.sin(angle), 0.0]), np.array([-np.sin(angle), np.cos(angle), 0.0])
        for side, name in ((0.2, "a"), (-0.2, "b")):
            at, to = 2.0 * out + side * across + [0, 0, 2.8], 0.25 * out + side * across + [0, 0, 0.1 * sign]
            own = {"name": f"{pair}{name}", "exit_point": at.tolist(), "platform_point": to.tolist()}
            lines.append(own | ({"shared_winch": {"line": f"{pair}a"}} if name == "b" else {}) | line)
    cable = {"axial_stiffness": EA, "linear_density": density, "breaking_load": 2e3}
    common = {"cable": cable, "sheave": {"kind": "eyelet"}, "tension_limits": (0.5, 400.0)}
    return Robot.model_validate(
        {
            "name": "pairs",
            "scene": {"frame_min": (-2.0, -2.0, 0.0), "frame_max": (2.0, 2.0, 3.0), "gravity": G},
            "platform": {"kind": "rigid", "mass": MASS},
            "lines": [common | each for each in lines],
        }
    )


def turned(vector: Array) -> Array:
    """Rotation matrix of a rotation vector by Rodrigues' formula, which takes complex numbers."""
    x, y, z = vector
    cross = np.array([[0 * x, -z, y], [z, 0 * x, -x], [-y, x, 0 * x]])
    square = x * x + y * y + z * z
    if abs(square) < 1e-30:
        return np.eye(3) + cross
    angle = np.sqrt(square)
    return np.eye(3) + np.sin(angle) / angle * cross + (1.0 - np.cos(angle)) / square * cross @ cross


class Straight:
    """Elastic straight lines without weight of a body: our own model of them, for the tests."""

    def __init__(self, robot: Robot) -> None:
        self.exits = np.array([line.exit_point for line in robot.lines])
        self.points = np.array([line.platform_point for line in robot.lines])

    def lines(self, pose: Array) -> tuple[Array, Array, Array]:
        """Distances (m,), unit vectors (m, 3) from exit to platform, arms (m, 3)."""
        arms = self.points @ turned(pose[3:]).T
        chords = pose[:3] + arms - self.exits
        distances = np.sqrt((chords * chords).sum(axis=1))
        return distances, chords / distances[:, None], arms

    def tensions(self, pose: Array, lengths: Array) -> Array:
        return EA * (self.lines(pose)[0] / lengths - 1.0)

    def wrench(self, pose: Array, lengths: Array) -> Array:
        _, units, arms = self.lines(pose)
        forces = -self.tensions(pose, lengths)[:, None] * units
        return np.concatenate([forces.sum(axis=0) - [0.0, 0.0, MASS * G], np.cross(arms, forces).sum(axis=0)])

    def energy(self, pose: Array, lengths: Array) -> float:
        stretch = np.maximum(self.lines(pose)[0] - lengths, 0.0)
        return float((0.5 * EA / lengths * stretch**2).sum() + MASS * G * pose[2])


def derivative(function: Any, at: Array) -> Array:
    """Jacobian by complex steps: exact to rounding."""
    columns = [function(at + 1e-30j * unit).imag / 1e-30 for unit in np.eye(len(at))]
    return np.array(columns).T


@pytest.mark.parametrize("place", [[0.1, 0.2, 1.0], [0.05, -0.1, 1.2], [0.0, 0.0, 1.4]])
def test_the_energy_of_three_winches_is_least_at_the_pose(place: list[float]) -> None:
    robot = parallelograms(3)
    found = cw.inverse(robot, [*place, *FREE], cable="elastic").checked()
    np.testing.assert_allclose(found.lengths[1::2], found.lengths[::2], atol=1e-12)
    np.testing.assert_allclose(found.pose[:3], place, atol=0.0)
    own = Straight(robot)
    start = found.pose + np.array([0.003, -0.002, 0.004, 0.01, -0.02, 0.01])
    least = minimize(own.energy, start, args=(found.lengths,), method="BFGS", options={"gtol": 1e-6})
    there = root(own.wrench, least.x, args=(found.lengths,), tol=1e-14)
    np.testing.assert_allclose(there.x, found.pose, atol=1e-8)
    np.testing.assert_allclose(own.tensions(there.x, found.lengths), found.tensions, atol=1e-6)
    back = cw.forward(robot, found.lengths, cable="elastic")
    np.testing.assert_allclose(back.pose, found.pose, atol=1e-8)


@pytest.mark.parametrize("count", [4, 5])
def test_the_least_norm_of_hanging_pairs(count: int) -> None:
    """SLSQP over rotation and winch lengths, then Newton on the conditions of Karush, Kuhn and Tucker."""
    robot, rng, solved = parallelograms(count), np.random.default_rng(1), 0
    own = Straight(robot)
    for place in rng.uniform([-0.6, -0.6, 0.5], [0.6, 0.6, 1.6], (4, 3)):
        found = cw.inverse(robot, [*place, *FREE], cable="elastic")
        if not found.ok:
            continue
        solved += 1
        tensions = least_norm(own, place, count, (0.5, 400.0))
        np.testing.assert_allclose(found.tensions, tensions, atol=1e-6)
        np.testing.assert_allclose(found.lengths[1::2], found.lengths[::2], atol=1e-12)
    assert solved > 1


def least_norm(own: Straight, place: Array, count: int, limits: tuple[float, float]) -> Array:
    """Tensions of least norm at *place*, with any rotation and *count* winch lengths."""
    scale = np.concatenate([np.full(3, 1e-3), np.full(count, 1e-4)])
    mean = np.linalg.norm(place + own.points - own.exits, axis=1).reshape(-1, 2).mean(axis=1)
    begin = np.concatenate([np.zeros(3), mean * (1.0 - 2e-4)])

    def split(x: Array) -> tuple[Array, Array]:
        own_x = begin + scale * x
        return np.concatenate([place, own_x[:3]]), np.repeat(own_x[3:], 2)

    def tensions(x: Array) -> Array:
        return own.tensions(*split(x))

    def balance(x: Array) -> Array:
        return own.wrench(*split(x))

    limited = {"type": "ineq", "fun": lambda x: np.concatenate([tensions(x) - limits[0], limits[1] - tensions(x)])}
    rough = minimize(
        lambda x: 0.5 * (tensions(x) ** 2).sum(),
        np.zeros(3 + count),
        constraints=[{"type": "eq", "fun": balance}, limited],
        options={"maxiter": 80, "ftol": 1e-14},
    ).x
    active = np.flatnonzero(tensions(rough) < limits[0] + 1e-4)

    def held(x: Array) -> Array:
        return np.concatenate([balance(x), tensions(x)[active] - limits[0]])

    def stationary(z: Array) -> Array:
        x, multipliers = z[: 3 + count], z[3 + count :]
        slope = derivative(tensions, x).T @ tensions(x) - derivative(held, x).T @ multipliers
        return np.concatenate([slope, held(x)])

    guess = np.linalg.lstsq(derivative(held, rough).T, derivative(tensions, rough).T @ tensions(rough))[0]
    exact = root(stationary, np.concatenate([rough, guess]), tol=1e-13)
    assert np.abs(exact.fun).max() < 1e-6
    return tensions(exact.x[: 3 + count])


def test_the_least_norm_at_a_whole_pose() -> None:
    """Eight lines on seven winches: nothing beside the answer, on the surface of lengths that fit, is shorter."""
    robot = load("jung2020")
    pose = np.concatenate([0.5 * (np.array(robot.scene.frame_min) + np.array(robot.scene.frame_max)), np.zeros(3)])
    wanted = np.linspace(80.0, 110.0, 8)
    plain = cw.inverse(robot, pose, cable="elastic", preferred=wanted).checked()
    robot = shared(robot, (1, 0, float(plain.lengths[1] - plain.lengths[0]) + 2e-5, "along"))
    found = cw.inverse(robot, pose, cable="elastic", preferred=wanted).checked()
    assert found.margin() > 1.0
    assert np.abs(found.tensions - plain.tensions).max() > 0.5
    A, w = _structure(robot, pose)
    own, stiff = Straight(robot), np.array([line.cable.stiffness for line in robot.lines])
    distances, offset = own.lines(pose)[0], robot.lines[1].shared_winch.offset
    null = np.linalg.svd(A)[2][6:]

    def gap(x: Array) -> Array:
        lengths = distances / (1.0 + (found.tensions + x @ null) / stiff)
        return np.array([lengths[1] - lengths[0] - offset])

    np.testing.assert_allclose(A @ found.tensions + w, 0.0, atol=1e-9)
    assert abs(gap(np.zeros(2))[0]) < 1e-12
    normal = derivative(gap, np.zeros(2))[0]
    normal /= np.linalg.norm(normal)
    slope = null @ (found.tensions - wanted)
    np.testing.assert_allclose(slope - (slope @ normal) * normal, 0.0, atol=1e-6)


def _structure(robot: Robot, pose: ArrayLike) -> tuple[Array, Array]:
    """Structure matrix of straight lines, and the platform's own wrench about its origin."""
    at = np.asarray(pose)
    exits = np.array([line.exit_point for line in robot.lines])
    arms = np.array([line.platform_point for line in robot.lines]) @ turned(at[3:]).T
    chords = exits - at[:3] - arms
    units = chords / np.linalg.norm(chords, axis=1)[:, None]
    weight = np.array([0.0, 0.0, -robot.platform.mass * robot.scene.gravity])
    moment = np.cross(turned(at[3:]) @ np.array(robot.platform.centre_of_mass), weight)
    return np.concatenate([units, np.cross(arms, units)], axis=1).T, np.concatenate([weight, moment])


def test_infeasible_poses_of_a_body_are_infeasible() -> None:
    """With equal lengths d_i (1 + t_j c) = d_j (1 + t_i c): tensions at a whole pose are a linear program."""
    robot = shared(load("jung2020"), (1, 0, 0.0, "along"))
    own, (low, high) = Straight(robot), robot.lines[0].tension_limits
    stiffness = robot.lines[0].cable.stiffness
    middle = 0.5 * (np.array(robot.scene.frame_min) + np.array(robot.scene.frame_max))
    poses = np.random.default_rng(2).uniform(-1e-3, 1e-3, (200, 6))
    poses[:, :3] += middle
    found, feasible = cw.inverse(robot, poses, cable="elastic"), []
    for pose in poses:
        A, w = _structure(robot, pose)
        d = own.lines(pose)[0]
        fits = np.array([[d[1], -d[0], 0, 0, 0, 0, 0, 0]])
        answer = linprog(
            np.zeros(8),
            A_eq=np.vstack([A, fits]),
            b_eq=[*-w, stiffness * (d[0] - d[1])],
            bounds=(low, high),
            options={"primal_feasibility_tolerance": 1e-10},
        )
        feasible.append(answer.status == 0)
    assert set(found.code.tolist()) <= {0, 7}
    np.testing.assert_array_equal(found.ok, feasible)
    assert 20 < found.ok.sum() < 180


def test_infeasible_places_of_hanging_pairs_are_infeasible() -> None:
    """A search for the largest smallest tension, over rotation and winch lengths, finds none within the limits."""
    robot = parallelograms(4)
    own, rng, answers = Straight(robot), np.random.default_rng(3), []
    scale = np.concatenate([np.full(3, 1e-2), np.full(4, 1e-3), [1.0]])
    for place in rng.uniform([-1.2, -1.2, 0.3], [1.2, 1.2, 2.2], (25, 3)):
        mean = np.linalg.norm(place + own.points - own.exits, axis=1).reshape(-1, 2).mean(axis=1)
        best = -np.inf
        for tilt in (0.0, 0.003):
            begin = np.concatenate([rng.normal(0.0, tilt, 3), mean * (1.0 - 2e-4), [-5.0]])

            def tensions(x: Array, begin: Array = begin, place: Array = place) -> tuple[Array, Array, float]:
                x = begin + scale * x
                pose, lengths = np.concatenate([place, x[:3]]), np.repeat(x[3:7], 2)
                return own.tensions(pose, lengths), own.wrench(pose, lengths), x[7]

            limits = {"type": "ineq", "fun": lambda x, f=tensions: f(x)[0] - 0.5 - f(x)[2]}
            balance = {"type": "eq", "fun": lambda x, f=tensions: f(x)[1]}
            answer = minimize(lambda x, f=tensions: -f(x)[2], np.zeros(8), constraints=[balance, limits])
            if np.abs(tensions(answer.x)[1]).max() < 1e-4 and tensions(answer.x)[0].max() < 400.0:
                best = max(best, tensions(answer.x)[2])
        found = cw.inverse(robot, [*place, *FREE], cable="elastic")
        answers.append(bool(found.ok))
        assert found.ok == (best >= 0.0), (place, best)
        assert found.ok or found.status is cw.Status.INFEASIBLE
    assert 3 < sum(answers) < 22


BELT = """
schema = 1
name = "belts"
[scene]
frame_min = [-1.0, -0.1, 0.0]
frame_max = [1.0, 0.1, 2.0]
[platform]
mass = "2 kg"
plane = { normal = [0.0, 1.0, 0.0] }
[cable]
axial_stiffness = "20 kN"
linear_density = "0 g/m"
breaking_load = "1 kN"
[sheave]
kind = "eyelet"
[winch]
drum_radius = "20 mm"
[line]
tension_limits = ["5 N", "300 N"]
[[lines]]
name = "left"
exit_point = [-1.2, 0.0, 1.0]
[[lines]]
name = "right"
exit_point = [1.2, 0.0, 1.0]
shared_winch = { line = "left", offset = "2397 mm", winds = "against" }
[[lines]]
name = "up"
exit_point = [0.0, 0.0, 2.2]
"""


def test_a_belt_winds_one_end_and_unwinds_the_other() -> None:
    """Three tensions follow from two forces and the belt's whole length."""
    robot = cw.loads(BELT)
    poses = np.array([[x, 0.0, 0.99] for x in (-0.5, -0.1, 0.0, 0.3, 0.6)])
    found = cw.inverse(robot, poses, cable="elastic").checked()
    np.testing.assert_allclose(found.lengths[:, 0] + found.lengths[:, 1], 2.397, atol=1e-12)
    exits = np.array([line.exit_point for line in robot.lines])
    for pose, own in zip(poses, found.tensions, strict=True):
        chords = exits - pose
        distances = np.linalg.norm(chords, axis=1)

        def fits(t: Array, chords: Array = chords, d: Array = distances) -> Array:
            forces = (t / d) @ chords
            return np.array([forces[0], forces[2] - 2.0 * G, 20e3 * (2.397 - (d / (1.0 + t / 20e3))[:2].sum())])

        np.testing.assert_allclose(root(fits, [30.0, 30.0, 20.0], tol=1e-13).x, own, atol=1e-6)
    back = cw.forward(robot, found.lengths, cable="elastic", guess=poses)
    np.testing.assert_allclose(back.pose, poses, atol=1e-8)
    far = cw.inverse(robot, [0.3, 0.0, 0.7], cable="elastic")
    assert far.status is cw.Status.INFEASIBLE
    assert far.violation > 100.0
    at = np.linalg.norm(exits[:2] - [0.3, 0.0, 0.7], axis=1)
    assert 20e3 * (at.sum() / 2.397 - 1.0) > 300.0 + 100.0  # what the belt would pull


def test_torques_of_one_drum_add_up_or_cancel() -> None:
    robot = cw.loads(BELT)
    found = cw.inverse(robot, [0.3, 0.0, 0.99], cable="elastic").checked()
    torques, left, right = winch_torques(found), *(0.02 * found.tensions[:2])
    np.testing.assert_allclose(torques, [left - right, right - left, 0.02 * found.tensions[2]], rtol=1e-12)
    pairs = parallelograms(3, winch={"drum_radius": 0.03}, cables=2)
    hangs = cw.inverse(pairs, [0.1, 0.2, 1.0, *FREE]).checked()
    whole = 0.06 * hangs.tensions.reshape(-1, 2).sum(axis=1)
    np.testing.assert_allclose(winch_torques(hangs), np.repeat(whole, 2), rtol=1e-12)


def sagging(name: str) -> tuple[Robot, list[float]]:
    """Robots with weight, sheaves, levers, guides, springs and mounts, and a pose."""
    if name == "pairs":
        return parallelograms(4, density=0.02), [0.1, 0.05, 1.0, *FREE]
    if name == "sprung":
        return parallelograms(4, spring=2e4, exit_compliance=2e-6), [0.1, 0.05, 1.0, *FREE]
    robot = out_of_plane.body(name) if name in ("tilted", "mounts") else load(name)
    pose = [0.4, -0.3, 1.6, 0.0, 0.0, 0.02] if name in ("tilted", "mounts") else [0.4, -0.3, 1.2, 0.02, -0.01, 0.03]
    pose = [1.0, -0.7, 2.0] if robot.n == 3 else pose
    lengths = cw.inverse(robot, pose).checked().lengths
    return shared(robot, (1, 0, float(lengths[1] - lengths[0]) + 2e-4, "along")), pose


@pytest.mark.parametrize("name", ["pairs", "sprung", "cogiro", "house-printer", "merlet2023", "tilted", "mounts"])
@pytest.mark.parametrize("cable", ["elastic", "catenary"])
def test_sag_and_lines_out_of_the_plane(name: str, cable: str) -> None:
    """Lengths fit the drum, forward of them is the pose, and no tensions beside them have a smaller norm."""
    robot, pose = sagging(name)
    found = cw.inverse(robot, pose, cable=cable).checked()
    for line, mate in ((1, 0), *(((3, 2), (5, 4)) if name in ("pairs", "sprung") else ())):
        own = robot.lines[line].shared_winch
        assert abs(found.lengths[line] - own.offset - found.lengths[mate]) < 1e-9
    assert found.is_valid()
    back = cw.forward(robot, found.lengths, cable=cable, guess=found.pose)
    np.testing.assert_allclose(back.pose, found.pose, atol=1e-8)


def test_the_norm_is_least_with_sag() -> None:
    """Beside the answer, along the one freedom that is left, pulls have a larger norm."""
    robot, pose = sagging("pairs")
    found = cw.inverse(robot, pose).checked()
    assert found.margin() > 1e-3  # no limit holds it
    linear = cw.linearise(found)
    winches = np.kron(np.eye(4), np.ones((2, 1)))
    free = np.linalg.svd(linear.per_length[:3] @ winches)[2][3]  # no motion of the position

    def norm(step: float) -> float:
        move = step * free
        for _ in range(6):
            there = cw.forward(robot, found.lengths + winches @ move, guess=found.pose)
            move -= np.linalg.pinv(linear.per_length[:3] @ winches) @ (there.pose[:3] - found.pose[:3])
        assert np.abs(there.pose[:3] - found.pose[:3]).max() < 1e-11
        return float((pulls(robot, there) ** 2).sum())

    step = 1e-6
    before, at, after = norm(-step), norm(0.0), norm(step)
    assert before > at < after
    assert abs(after - before) < 1e-3 * (before + after - 2.0 * at)


def pulls(robot: Robot, found: cw.Equilibrium) -> Array:
    """Tension at mid-length along the chord, of lines from eyelets."""
    states = found.line_states
    chords = found.platform_points - np.array([line.exit_point for line in robot.lines])
    units = chords / np.linalg.norm(chords, axis=1)[:, None]
    across, up = np.hypot(units[:, 0], units[:, 1]), units[:, 2]
    half = 0.5 * found.lines.weight * states.free_length
    t, phi = states.tension, states.free_angle
    return t * np.cos(phi) * across + (t * np.sin(phi) + half) * up


def test_rigid_cables_fit_their_drum_or_not() -> None:
    robot, pose = parallelograms(4), [0.1, 0.05, 1.0, *FREE]
    found = cw.inverse(robot, pose, cable="rigid").checked()
    np.testing.assert_allclose(found.pose[3:], 0.0, atol=1e-9)
    np.testing.assert_allclose(found.lengths[1::2], found.lengths[::2], atol=1e-9)
    body = load("jung2020")
    middle = np.concatenate([0.5 * (np.array(body.scene.frame_min) + np.array(body.scene.frame_max)), np.zeros(3)])
    plain = cw.inverse(body, middle, cable="rigid").checked()
    for off, ok in ((0.0, True), (1e-5, False)):
        offset = float(plain.lengths[1] - plain.lengths[0]) + off
        there = cw.inverse(shared(body, (1, 0, offset, "along")), middle, cable="rigid")
        assert there.ok == ok
        np.testing.assert_allclose(there.lengths, plain.lengths, rtol=1e-12)
        if not ok:
            assert there.status is cw.Status.INFEASIBLE
            assert "does not fit the drum that it shares with" in there.sentence()


def test_neighbours_on_a_path_have_the_same_answers() -> None:
    from cablewright.solvers.inverse import solve_inverse

    robot = parallelograms(4)
    poses = np.array([[0.3 * np.cos(a), 0.3 * np.sin(a), 1.0, *FREE] for a in np.linspace(0.0, 1.0, 30)])
    alone, path = cw.inverse(robot, poses), solve_inverse(cw.Model.of(robot), poses, path=True)
    np.testing.assert_allclose(path.tensions, alone.tensions, atol=1e-7)
    np.testing.assert_allclose(path.pose, alone.pose, atol=1e-10)


def test_the_position_or_the_rotation_may_be_free() -> None:
    robot = parallelograms(3)
    found = cw.inverse(robot, [0.1, 0.2, 1.0, *FREE]).checked()
    other = np.full(6, np.nan)
    other[[0, 1, 3]] = found.pose[[0, 1, 3]]
    there = cw.inverse(robot, other)
    if there.ok:  # of poses with that rotation about x
        np.testing.assert_allclose(there.lengths[1::2], there.lengths[::2], atol=1e-9)
        assert there.is_valid()
    for pose, why in (
        ([0.1, 0.2, 1.0], "6 lines on 3 winches hold 3 of the 6 degrees of freedom; 6 are given: leave 3 free"),
        ([0.1, 0.2, *FREE, np.nan], "2 are given: leave 3 free"),
    ):
        with pytest.raises(cw.InputError, match=why):
            cw.inverse(robot, pose)
    with pytest.raises(
        cw.InputError, match="8 lines on 4 winches hold 4 of the 6 degrees of freedom; 5 are given: leave 2 to 3"
    ):
        cw.inverse(parallelograms(4), [0.1, 0.2, 1.0, 0.0, 0.0, np.nan])
