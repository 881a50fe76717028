"""Laws of a body in motion: energy, momentum, order, rest, symmetry, free flight, MuJoCo, and the drum as a case."""

from __future__ import annotations

import math
from itertools import pairwise

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from cablewright.analyses.modes import modes
from cablewright.kernels.layout import EXIT_Z, FREE, FREE_COMPLIANCE, MASS_X, MASS_Z, PHI, POINT_X, TAU, WEIGHT
from cablewright.kernels.plant import dynamics
from cablewright.kernels.plant.dynamics import CENTRE, INERTIA, MASS, MOMENTUM, PART, RATE, THRUST, TURN, VELOCITY
from cablewright.kernels.rotation import matrix
from cablewright.kernels.statics.line.upright import settle
from cablewright.models.statics import Model
from cablewright.robot import Robot, load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from oracles.mujoco_model import xml

Array = NDArray[np.float64]
G = 9.81
SHOVE = [0.05, -0.03, 0.02, 0.3, 0.2, -0.25]  # m/s and rad/s


class Moving:
    """A robot's body on lines of fixed lengths."""

    def __init__(self, robot: Robot, pose: list[float], slack: float = 0.0, **entries: float) -> None:
        self.model = Model(robot)
        held = solve_inverse(self.model, pose).checked()
        self.lengths = held.lengths + slack
        self.rest = solve_forward(self.model, held.lengths, guess=held.pose).checked()
        self.states = self.rest.states.copy()
        platform = robot.platform
        self.body = np.zeros(dynamics.BODY)
        centre = np.array(platform.centre_of_mass)
        (xx, yy, zz), (xy, xz, yz) = platform.inertia, platform.inertia_products
        about = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        about += platform.mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
        self.body[MASS], self.body[CENTRE : CENTRE + 3] = platform.mass, centre
        self.body[INERTIA : INERTIA + 9] = about.ravel()
        for name, value in entries.items():
            self.body[getattr(dynamics, name)] = value
        self.motion = np.zeros(dynamics.MOTION)
        self.motion[[0, 1, 2, 6, 7, 8]] = self.rest.pose
        self.work, self.swing = dynamics.moving_workspace(self.model.packed)

    def shove(self, by: list[float]) -> None:
        self.motion[VELOCITY : VELOCITY + 3], self.motion[RATE : RATE + 3] = by[:3], by[3:]

    def step(self, dt: float) -> None:
        both = (self.lengths, self.lengths)
        arrays = (self.model.packed, self.body, self.motion, *both, dt, self.states, self.work, self.swing)
        assert dynamics.midpoint_step(*arrays) == 0

    def run(self, dt: float, duration: float) -> Array:
        """The motion after each step, (k, MOTION)."""
        moved = []
        for _ in range(round(duration / dt)):
            self.step(dt)
            moved.append(self.motion.copy())
        return np.array(moved)

    @property
    def rotation(self) -> Array:
        found = np.eye(3)
        matrix(self.motion[TURN : TURN + 3], found)
        return found

    def momenta(self) -> tuple[Array, Array]:
        """Linear momentum, kg m/s, and angular momentum about the centre of mass, kg m^2/s."""
        R, mass = self.rotation, self.body[MASS]
        arm, rate = R @ self.body[CENTRE : CENTRE + 3], self.motion[RATE : RATE + 3]
        linear = mass * (self.motion[VELOCITY : VELOCITY + 3] + np.cross(rate, arm))
        about = R @ self.body[INERTIA : INERTIA + 9].reshape(3, 3) @ R.T
        return linear, about @ rate + mass * np.cross(arm, self.motion[VELOCITY : VELOCITY + 3]) - np.cross(arm, linear)

    def energy(self) -> float:
        """Of body and lines, J: the lines' by quadrature of their shape in statics."""
        linear, angular = self.momenta()
        rate, velocity = self.motion[RATE : RATE + 3], self.motion[VELOCITY : VELOCITY + 3]
        arm = self.rotation @ self.body[CENTRE : CENTRE + 3]
        moving = 0.5 * linear @ velocity + 0.5 * rate @ (angular + np.cross(arm, linear))
        total = float(moving + self.body[MASS] * G * (self.motion[2] + arm[2]))
        nodes, weights = np.polynomial.legendre.leggauss(40)
        for row, y, length in zip(self.model.packed.lines, self.states.copy(), self.lengths, strict=True):
            end = self.motion[:3] + self.rotation @ row[POINT_X : POINT_X + 3]
            x, z = math.hypot(end[0] - row[0], end[1] - row[1]), end[2] - row[EXIT_Z]
            assert settle(row, x, z, length, y, np.zeros((6, 6)), np.zeros((6, 3)))
            h, v = math.exp(y[TAU]) * math.cos(y[PHI]), math.exp(y[TAU]) * math.sin(y[PHI])
            s, ds = 0.5 * y[FREE] * (nodes + 1.0), 0.5 * y[FREE] * weights
            up = v + row[WEIGHT] * s
            tension = np.hypot(h, up)
            total += float(ds @ (0.5 * row[FREE_COMPLIANCE] * tension**2))
            total += float(ds @ (row[WEIGHT] * (y[FREE] - s) * up * (row[FREE_COMPLIANCE] + 1.0 / tension)))
        return total


def lighter(robot: Robot, density: float) -> Robot:
    """With cables of that weight, kg/m."""
    cables = [line.cable.model_copy(update={"linear_density": density}) for line in robot.lines]
    lines = [line.model_copy(update={"cable": cable}) for line, cable in zip(robot.lines, cables, strict=True)]
    return robot.model_copy(update={"lines": tuple(lines)})


def ipanema() -> Moving:
    return Moving(load("ipanema"), [0.3, -0.2, 0.8, 0.02, -0.03, 0.1])


def test_energy_is_kept_to_the_square_of_the_step() -> None:
    drift = []
    for dt in (1e-3, 0.5e-3):
        moving = ipanema()
        moving.shove(SHOVE)
        begin, kept = moving.energy(), []
        for _ in range(round(0.4 / dt / 4)):
            for _ in range(4):
                moving.step(dt)
            kept.append(moving.energy())
        drift.append(np.abs(np.array(kept) - begin).max())
    swung = 0.5 * 12.0 * 0.06**2 + 0.5 * 0.2 * 0.4**2  # J that move
    assert drift[0] < 0.1 * swung
    assert drift[1] < 0.35 * drift[0]


@pytest.mark.parametrize("name", ["SWING_DAMPING", "DRAG", "RELAXATION"])
def test_energy_only_falls_with_damping(name: str) -> None:
    moving = ipanema()
    moving.body[getattr(dynamics, name)] = 1e-3 if name == "RELAXATION" else 60.0
    moving.shove([5.0 * each for each in SHOVE])
    energies = [moving.energy()]
    for _ in range(30):
        moving.run(0.25e-3, 0.01)
        energies.append(moving.energy())
    assert (np.diff(energies) < 2e-3).all()  # J: what the order of the integrator leaves
    assert energies[-1] < energies[0] - 0.01


def test_the_motion_converges_with_the_square_of_the_step() -> None:
    ends = []
    for dt in (1e-3, 0.5e-3, 0.25e-3, 0.125e-3):
        moving = ipanema()
        moving.shove(SHOVE)
        ends.append(moving.run(dt, 0.1)[-1])
    off = [np.abs(one - other).max() for one, other in pairwise(ends)]
    assert off[1] < 0.3 * off[0]
    assert off[2] < 0.3 * off[1]


def test_a_damped_body_comes_to_rest_where_the_solver_says() -> None:
    for robot, pose in (
        (load("cogiro"), [1.0, -0.5, 1.2, 0.0, 0.0, 0.1]),
        (load("ipanema"), [0.3, -0.2, 0.8, 0, 0, 0]),
    ):
        moving = Moving(robot, pose, DRAG=600.0, SWING_DAMPING=200.0, YAW_DAMPING=200.0, RELAXATION=5e-3)
        moving.shove(SHOVE)
        moving.run(10e-3, 30.0)
        np.testing.assert_allclose(moving.motion[[0, 1, 2, 6, 7, 8]], moving.rest.pose, atol=2e-8)
        np.testing.assert_allclose(moving.motion[VELOCITY : VELOCITY + 3], 0.0, atol=1e-8)


def test_what_is_symmetric_stays_so() -> None:
    """ipanema is so about x = 0 and y = 0, and its centre of mass is between them: lifted, it moves up and down."""
    moving = Moving(load("ipanema"), [0.0, 0.0, 0.8, 0.0, 0.0, 0.0])
    moving.motion[2] += 2e-3
    moved = moving.run(1e-3, 2.0)
    assert np.ptp(moved[:, 2]) > 1e-3
    assert np.abs(moved[:, [0, 1, 3, 4, 6, 7, 8]]).max() < 1e-9


def flying(**entries: float) -> Moving:
    """ipanema's body on lines of almost no weight, 2 m too long: nothing holds it."""
    return Moving(lighter(load("ipanema"), 1e-7), [0.0, 0.0, 1.0, 0.0, 0.0, 0.0], 2.0, **entries)


def test_a_body_on_slack_lines_falls_and_turns_freely() -> None:
    """Its centre falls; momentum about it stays, while its rate changes as it is no ball."""
    ends = []
    for dt in (2e-3, 1e-3):
        moving = flying()
        moving.shove([0.4, 0.2, 0.1, 2.0, -1.0, 0.5])
        arm, (linear, angular) = moving.rotation @ moving.body[CENTRE : CENTRE + 3], moving.momenta()
        begin, rate = moving.motion[:3] + arm, moving.motion[RATE : RATE + 3].copy()
        moving.run(dt, 0.5)
        centre = moving.motion[:3] + moving.rotation @ moving.body[CENTRE : CENTRE + 3]
        fallen = begin + linear / moving.body[MASS] * 0.5 + [0.0, 0.0, -0.5 * G * 0.5**2]
        after, about = moving.momenta()
        assert np.abs(moving.motion[RATE : RATE + 3] - rate).max() > 0.1
        off = [centre - fallen, after - linear - [0.0, 0.0, -G * 0.5 * moving.body[MASS]], about - angular]
        ends.append([np.abs(each).max() for each in off])
    assert (np.array(ends[0]) < [2e-5, 0.02, 2e-3]).all()  # m, kg m/s, kg m^2/s
    assert (np.array(ends[1]) < 0.35 * np.array(ends[0]) + [2e-6, 2e-4, 2e-4]).all()


def test_a_part_that_moves_pushes_the_rest_of_the_body() -> None:
    """In free flight a part that is driven up and aside of the centre: linear and angular momentum of both stay."""
    moving, part, pushed, dt, steps = flying(), 3.0, 2.0, 1e-3, 250
    first, whole = np.array([0.1, 0.05, 0.0]), moving.body.copy()
    mass = whole[MASS]

    def shift(s: float) -> None:
        """Move the part to *s*, m, over where it was."""
        at = first + np.array([0.0, 0.0, s])
        spread = [part * (p @ p * np.eye(3) - np.outer(p, p)) for p in (at, first)]
        moving.body[INERTIA : INERTIA + 9] = whole[INERTIA : INERTIA + 9] + (spread[0] - spread[1]).ravel()
        moving.body[CENTRE + 2] = whole[CENTRE + 2] + part / mass * s
        moving.body[PART : PART + 3] = at
        moving.model.packed.platform[MASS_Z] = moving.body[CENTRE + 2]

    moving.shove([0.0, 0.0, 0.0, 1.0, -2.0, 0.5])
    begin = moving.momenta()
    moving.body[THRUST + 2] = part * pushed
    for k in range(steps):
        t = (k + 0.5) * dt
        moving.body[MOMENTUM + 2] = part * pushed * t
        shift(0.5 * pushed * t * t)
        moving.step(dt)
    t = steps * dt
    shift(0.5 * pushed * t * t)
    linear, angular = moving.momenta()
    driven = part * pushed * t * moving.rotation[:, 2]
    arm = moving.rotation @ (moving.body[PART : PART + 3] - moving.body[CENTRE : CENTRE + 3])
    assert np.linalg.norm(driven) > 1.0
    np.testing.assert_allclose(linear + driven, begin[0] + [0.0, 0.0, -mass * G * t], atol=2e-3)
    np.testing.assert_allclose(angular + np.cross(arm, driven), begin[1], atol=2e-4)


def test_a_drum_is_a_body_that_hangs_from_one_point() -> None:
    """The same robot with three rows in its lines' balance, and with six whose arms are zero."""
    robot = load("merlet2023")
    platform = robot.platform.model_copy(update={"mass": 60.0})
    model = Model(robot.model_copy(update={"platform": platform}))
    held = solve_inverse(model, [0.3, -1.0, 1.5]).checked()
    body = np.zeros(dynamics.BODY)
    body[MASS], body[CENTRE + 2], body[dynamics.RELAXATION] = 60.0, -0.5, 1e-3
    body[INERTIA : INERTIA + 9] = np.diag([18.0, 17.0, 1.5]).ravel()
    ends = []
    for n in (3, 6):
        numbers = model.packed.platform.copy()
        numbers[MASS_X : MASS_Z + 1] = [0.0, 0.0, -0.5]
        packed = model.packed._replace(freedoms=n, platform=numbers)
        motion, states = np.zeros(dynamics.MOTION), held.states.copy()
        motion[:3], motion[RATE : RATE + 3] = held.pose, [0.4, -0.3, 0.6]
        work, swing = dynamics.moving_workspace(packed)
        for k in range(500):
            after = held.lengths + 1e-3 * math.sin(0.01 * k) * np.array([1, -1, 1, 0])
            assert dynamics.midpoint_step(packed, body, motion, after, after, 2e-3, states, work, swing) == 0
        ends.append(motion)
    np.testing.assert_allclose(ends[0], ends[1], atol=3e-7)  # m, rad and their rates: 500 times what Newton leaves


@pytest.mark.parametrize(
    ("robot", "pose", "dt", "duration"),
    [
        (load("grab-four-lines"), [1.1, 0.0, 0.0, math.nan, math.nan, 0.0], 0.5e-3, 10.0),
        (load("ipanema"), [0.2, 0.1, 0.8, 0.0, 0.0, 0.05], 0.1e-3, 1.0),
    ],
    ids=["four lines swing", "eight lines hold"],
)
def test_mujoco_finds_the_same_motion_of_a_body(robot: Robot, pose: list[float], dt: float, duration: float) -> None:
    """A free swing of 10 s, and springs of 20 Hz and more for one; MuJoCo's tendons weigh nothing."""
    moving = Moving(lighter(robot, 1e-6), pose)
    soft = modes(moving.rest).shapes
    shove = (0.3 * soft[:, 0] + 0.2 * soft[:, 1]).tolist()  # m/s, rad/s: of the softest modes
    moving.shove(shove)
    ours = moving.run(dt, duration)
    text, step = xml(moving.model.robot, moving.lengths), 0.2e-3
    model = mujoco.MjModel.from_xml_string(text.replace("<option ", f'<option timestep="{step}" integrator="RK4" ', 1))
    data = mujoco.MjData(model)
    at = moving.rest.pose
    angle = float(np.linalg.norm(at[3:]))
    data.qpos[:3] = at[:3]
    mujoco.mju_axisAngle2Quat(data.qpos[3:7], at[3:] / (angle or 1.0), angle)
    rotation = np.eye(3)
    matrix(at[3:].copy(), rotation)
    data.qvel[:3], data.qvel[3:6] = shove[:3], rotation.T @ shove[3:]  # its rates are in the body's frame
    theirs, every = [], 10e-3
    for _ in range(round(duration / every)):
        mujoco.mj_step(model, data, round(every / step))
        vector = np.zeros(3)
        mujoco.mju_quat2Vel(vector, data.qpos[3:7], 1.0)
        theirs.append(np.concatenate([data.qpos[:3], vector]))
    many = round(every / dt)
    off = np.abs(ours[many - 1 :: many, [0, 1, 2, 6, 7, 8]] - theirs)
    moved = np.ptp(np.array(theirs), axis=0)
    assert moved.max() > 0.01
    assert off[:, :3].max() < 1e-5  # m
    assert off[:, 3:].max() < 5e-5  # rad
