"""Laws of the moving drum: energy, order, rest, a pendulum, and MuJoCo on the same robot."""

from __future__ import annotations

import math
from itertools import pairwise

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from cablewright.kernels.layout import FREE, FREE_COMPLIANCE, PHI, TAU, WEIGHT
from cablewright.kernels.plant import dynamics
from cablewright.kernels.plant.dynamics import CENTRE, INERTIA, MASS, PLACE, RATE, TURN, VELOCITY
from cablewright.kernels.statics.line.upright import settle
from cablewright.models.statics import Model
from cablewright.robot import Eyelet, Robot, load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from oracles.mujoco_model import xml

Array = NDArray[np.float64]
GRAVITY = 9.81
PLACED = [0.3, -1.0, 1.5]


class Moving:
    """A drum on lines of fixed lengths."""

    def __init__(self, robot: Robot, pose: list[float], slack: float = 0.0, **entries: float) -> None:
        platform = robot.platform.model_copy(update={"mass": 60.0})
        self.model = Model(robot.model_copy(update={"platform": platform}))
        held = solve_inverse(self.model, pose).checked()
        self.lengths = held.lengths.copy()
        self.lengths[3] += slack
        self.rest = solve_forward(self.model, self.lengths).checked()
        self.states = self.rest.states.copy()
        self.drum = np.zeros(dynamics.BODY)
        self.drum[[MASS, CENTRE + 2]] = 60.0, -0.5
        self.drum[INERTIA : INERTIA + 9] = np.diag([18.0, 17.0, 1.5]).ravel()
        for name, value in entries.items():
            self.drum[getattr(dynamics, name)] = value
        self.motion = np.zeros(dynamics.MOTION)
        self.motion[:3] = self.rest.pose
        self.work, self.swing = dynamics.moving_workspace(self.model.packed)

    def step(self, dt: float, after: Array | None = None) -> None:
        after = self.lengths if after is None else after
        packed = self.model.packed
        arrays = (packed, self.drum, self.motion, self.lengths, after, dt, self.states, self.work, self.swing)
        assert dynamics.midpoint_step(*arrays) == 0
        self.lengths = after

    def run(self, dt: float, duration: float) -> Array:
        """The motion after each step, (k, MOTION)."""
        moved = []
        for _ in range(round(duration / dt)):
            self.step(dt)
            moved.append(self.motion.copy())
        return np.array(moved)

    def energy(self) -> float:
        """Of drum and lines, J: the lines' by quadrature of their shape in statics."""
        rotation = matrix_of(self.motion[TURN : TURN + 3])
        centre = rotation @ self.drum[CENTRE : CENTRE + 3]
        velocity, rate = self.motion[VELOCITY : VELOCITY + 3], self.motion[RATE : RATE + 3]
        inertia = rotation @ self.drum[INERTIA : INERTIA + 9].reshape(3, 3) @ rotation.T
        mass = self.drum[MASS]
        moving = (
            0.5 * mass * velocity @ velocity + mass * velocity @ np.cross(rate, centre) + 0.5 * rate @ inertia @ rate
        )
        return float(moving + mass * GRAVITY * (self.motion[2] + centre[2]) + self.line_energy())

    def line_energy(self) -> float:
        settled = solve_forward(self.model, self.lengths, guess=self.rest.pose)
        packed, total = self.model.packed, 0.0
        nodes, weights = np.polynomial.legendre.leggauss(40)
        for row, line_states in zip(packed.lines, self.at_place(settled.states), strict=True):
            h = math.exp(line_states[TAU]) * math.cos(line_states[PHI])
            v = math.exp(line_states[TAU]) * math.sin(line_states[PHI])
            s = 0.5 * line_states[FREE] * (nodes + 1.0)
            ds = 0.5 * line_states[FREE] * weights
            up = v + row[WEIGHT] * s
            tension = np.hypot(h, up)
            # potential energy of weight: the integral of w z ds, by parts with dz = (c T + 1) up / T ds
            rises = up * (row[FREE_COMPLIANCE] + 1.0 / tension)
            total += float(ds @ (0.5 * row[FREE_COMPLIANCE] * tension**2))
            total += float(ds @ (row[WEIGHT] * (line_states[FREE] - s) * rises))
        return total

    def at_place(self, states: Array) -> Array:
        """The lines' states where the drum is, settled with the platform held there."""
        found = states.copy()
        for row, y, length in zip(self.model.packed.lines, found, self.lengths, strict=True):
            x = math.hypot(self.motion[0] - row[0], self.motion[1] - row[1])
            assert settle(row, x, self.motion[2] - row[2], length, y, np.zeros((6, 6)), np.zeros((6, 3)))
        return found


def matrix_of(vector: Array) -> Array:
    angle = float(np.linalg.norm(vector))
    K = np.array([[0, -vector[2], vector[1]], [vector[2], 0, -vector[0]], [-vector[1], vector[0], 0]])
    if angle < 1e-12:
        return np.eye(3) + K
    return np.eye(3) + math.sin(angle) / angle * K + (1 - math.cos(angle)) / angle**2 * K @ K


def without_sheaves(density: float | None = None) -> Robot:
    """merlet2023 through eyelets, whose energy is that of free spans alone."""
    robot = load("merlet2023")
    changes: dict[str, object] = {"sheave": Eyelet(), "winch_exit": None, "dead_length": 0.0}
    lines = []
    for line in robot.lines:
        cable = line.cable if density is None else line.cable.model_copy(update={"linear_density": density})
        lines.append(line.model_copy(update={**changes, "cable": cable}))
    return robot.model_copy(update={"lines": tuple(lines)})


@pytest.mark.parametrize("slack", [0.0, 0.03])
def test_energy_is_kept_to_the_square_of_the_step(slack: float) -> None:
    drift = []
    for dt in (2e-3, 1e-3):
        moving = Moving(without_sheaves(), PLACED, slack)
        moving.motion[2] += 0.004
        moving.motion[RATE : RATE + 3] = 0.4, 0.2, 0.5
        begin, kept = moving.energy(), []
        for _ in range(round(0.4 / dt / 4)):
            for _ in range(4):
                moving.step(dt)
            kept.append(moving.energy())
        drift.append(np.abs(np.array(kept) - begin).max())
    swung = 0.5 * 18.0 * 0.4**2  # J that move
    assert drift[0] < 0.01 * swung
    assert drift[1] < 0.35 * drift[0]


@pytest.mark.parametrize("name", ["SWING_DAMPING", "DRAG", "RELAXATION", "YAW_DAMPING"])
def test_energy_only_falls_with_damping(name: str) -> None:
    moving = Moving(without_sheaves(), PLACED, **{name: 1e-3 if name == "RELAXATION" else 20.0})
    moving.motion[2] += 0.004
    moving.motion[RATE : RATE + 3] = 0.4, 0.2, 0.5
    energies = [moving.energy()]
    for _ in range(30):
        moving.run(1e-3, 0.01)
        energies.append(moving.energy())
    assert (np.diff(energies) < 2e-4).all()  # J: what the order of the integrator leaves
    assert energies[-1] < energies[0] - 0.01


def test_a_damped_drum_comes_to_rest_where_the_solver_says() -> None:
    moving = Moving(load("merlet2023"), PLACED, 0.02, DRAG=400.0, SWING_DAMPING=150.0, YAW_DAMPING=5.0, RELAXATION=5e-3)
    moving.motion[:3] += [0.0, 0.0, 0.003]
    moving.motion[TURN] = 0.1
    moving.run(10e-3, 30.0)
    np.testing.assert_allclose(moving.motion[:3], moving.rest.pose, atol=1e-9)
    np.testing.assert_allclose(moving.motion[TURN : TURN + 2], 0.0, atol=1e-6)
    np.testing.assert_allclose(moving.motion[VELOCITY : VELOCITY + 3], 0.0, atol=1e-8)


def test_the_motion_converges_with_the_square_of_the_step() -> None:
    ends = []
    for dt in (2e-3, 1e-3, 0.5e-3, 0.25e-3):
        moving = Moving(load("merlet2023"), PLACED)
        moving.motion[2] += 0.0005
        moving.motion[RATE : RATE + 3] = 0.3, 0.2, 0.5
        ends.append(moving.run(dt, 0.2)[-1])
    off = [np.abs(one - other).max() for one, other in pairwise(ends)]
    assert off[1] < 0.3 * off[0]
    assert off[2] < 0.3 * off[1]


def test_a_drum_swings_as_a_pendulum() -> None:
    moving = Moving(load("merlet2023"), PLACED)
    moving.motion[TURN] = 0.02
    swung = moving.run(2e-3, 6.0)[:, TURN]
    ups = np.flatnonzero((swung[:-1] < 0) & (swung[1:] >= 0))
    times = 2e-3 * (ups + 1 + swung[ups] / (swung[ups] - swung[ups + 1]))
    # about B held still; the lines yield by a thousandth
    period = 2 * math.pi * math.sqrt(18.0 / (60.0 * GRAVITY * 0.5))
    assert np.diff(times).mean() == pytest.approx(period, rel=5e-3)


def test_lengths_paid_out_evenly_carry_the_drum_along() -> None:
    """A platform that is let down steadily moves through successive equilibria, but for the time of its springs."""
    moving = Moving(load("merlet2023"), PLACED, RELAXATION=2e-3, DRAG=0.0)
    target = solve_inverse(moving.model, [0.3, -1.0, 1.4]).checked()
    begin, way = moving.lengths.copy(), target.lengths - moving.lengths
    for k in range(1500):
        share = 0.5 - 0.5 * math.cos(math.pi * (k + 1) / 1500)
        moving.step(2e-3, begin + share * way)
    rest = solve_forward(moving.model, moving.lengths, guess=[0.3, -1.0, 1.4]).checked()
    np.testing.assert_allclose(moving.motion[:3], rest.pose, atol=3e-4)


def over_sheaves(density: float) -> Robot:
    """merlet2023 as it is, but for cable that stretches on its sheaves too and weighs almost nothing."""
    robot = load("merlet2023")
    lines = []
    for line in robot.lines:
        cable = line.cable.model_copy(update={"linear_density": density})
        lines.append(line.model_copy(update={"cable": cable, "arc_elastic": True}))
    return robot.model_copy(update={"lines": tuple(lines)})


@pytest.mark.parametrize("robot", [without_sheaves(1e-6), over_sheaves(1e-6)], ids=["eyelets", "swivels"])
def test_mujoco_finds_the_same_motion_of_a_drum(robot: Robot) -> None:
    """MuJoCo's tendons weigh nothing, and its drum hangs by a ball joint. Swivels are turned to B before each step."""
    moving = Moving(robot, PLACED)
    moving.motion[2] += 0.0005
    moving.motion[RATE : RATE + 3] = 0.5, -0.3, 0.8
    dt, duration = 0.5e-3, 1.0
    ours = moving.run(dt, duration)
    model = mujoco.MjModel.from_xml_string(hanging(moving))
    data = mujoco.MjData(model)
    data.qpos[:3] = moving.rest.pose
    data.qpos[2] += 0.0005
    data.qvel[3:6] = 0.5, -0.3, 0.8
    swivels = [i for i, line in enumerate(robot.lines) if not isinstance(line.sheave, Eyelet)]
    joints = [(model.joint(f"V{i}"), robot.lines[i].exit_point) for i in swivels]
    theirs, turned = [], []
    for _ in range(round(duration / dt)):
        for _ in range(round(dt / model.opt.timestep)):
            for joint, (x, y, _) in joints:
                data.qpos[joint.qposadr[0]] = math.atan2(data.qpos[1] - y, data.qpos[0] - x)
                data.qvel[joint.dofadr[0]] = 0.0
            mujoco.mj_step(model, data)
        theirs.append(data.qpos[:3].copy())
        vector = np.zeros(3)
        mujoco.mju_quat2Vel(vector, data.qpos[3:7], 1.0)
        turned.append(vector)
    moved = np.ptp(np.array(theirs), axis=0)
    assert moved.min() > 3e-4  # it does move
    assert np.abs(ours[:, PLACE : PLACE + 3] - theirs).max() < 2e-5
    assert np.abs(ours[:, TURN : TURN + 3] - turned).max() < 2e-4


def hanging(moving: Moving) -> str:
    """The machine in MuJoCo's format, with the drum on a ball joint under a point of a gram."""
    robot = moving.model.robot
    light = robot.platform.model_copy(update={"mass": 1e-3})
    text = xml(robot.model_copy(update={"platform": light}), moving.rest.lengths)
    about = moving.drum[[INERTIA, INERTIA + 4, INERTIA + 8]] - 60.0 * 0.5**2 * np.array([1, 1, 0])
    inertial = f'<inertial pos="0 0 -0.5" mass="60" diaginertia="{" ".join(map(str, about))}"/>'
    drum = f'<body name="drum"><joint name="ball" type="ball"/>{inertial}</body>'
    text = text.replace("</body>", f"{drum}</body>", 1)
    return text.replace("<option ", '<option timestep="2.5e-4" integrator="RK4" ', 1)
