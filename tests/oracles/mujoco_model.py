"""Oracle: a robot as a MuJoCo model of elastic tendons over sheaves, and where it comes to rest.

A point platform slides along three axes, a rigid one is a free body. The tendons weigh nothing and stretch along their
whole length, so a line must have ``arc_elastic``; a dead span that does not stretch is allowed where its length is
constant.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.linalg import eigh

from cablewright.robot import Eyelet, Line, Robot, UniversalJoint

FEED = 1.0
"""How far from the exit point, on the swivel axis, a tendon begins that has no winch exit, m."""


LEFT_OVER = 1e-8
"""The largest force or torque that may be left over, N or N m."""


@dataclass(frozen=True)
class Rest:
    """Where MuJoCo's platform rests: pose (n,) m and rad, tensions (m) N, largest force or torque left (N, N m)."""

    pose: np.ndarray
    tensions: np.ndarray
    left_over: float


def rest(robot: Robot, lengths: Sequence[float], start: Sequence[float]) -> Rest:
    """Return where the robot rests with lines of those unstrained lengths (m): downhill in energy from pose ``start``.

    ``start``: (n,) m and rotation vector, rad; a rigid platform may have several places to rest. The sheaves are turned
    to the platform at every step; that no torque is left to turn them is part of the result. Raises `ArithmeticError`
    if forces are left over.
    """
    body = _Body(robot, lengths)
    q = body.turned(body.at(start), np.zeros(body.model.nv))
    force, pushed, energy = body.force(q)
    for _ in range(500):
        step = body.downhill(q, force)
        while True:
            trial = body.turned(q, step)
            trial_force, trial_pushed, trial_energy = body.force(trial)
            gained = trial_energy - energy - pushed @ step  # a moment held in space turns with the step: pushed @ step
            if gained <= -1e-4 * step @ force + 1e-13 * (1 + abs(energy)):
                break
            step /= 3
        q, force, pushed, energy = trial, trial_force, trial_pushed, trial_energy
        if np.abs(step).max() < 1e-13:
            break
    left = float(np.abs(force).max())
    if left > LEFT_OVER:
        raise ArithmeticError(f"MuJoCo's robot does not come to rest: {left:.3g} N or N m are left")
    return Rest(body.pose(q), body.tensions(), left)


def frequencies(robot: Robot, lengths: Sequence[float], start: Sequence[float]) -> np.ndarray:
    """Return the natural frequencies (n,), Hz, ascending, at rest: MuJoCo's masses, its forces by differences.

    Through eyelets alone: sheaves have masses of their own here.
    """
    body = _Body(robot, lengths)
    q = body.turned(body.at(rest(robot, lengths, start).pose), np.zeros(body.model.nv))
    body.force(q)
    M, K = np.zeros((body.model.nv,) * 2), body.stiffness(q)
    for column, unit in zip(M, np.eye(body.model.nv), strict=True):
        mujoco.mj_mulM(body.model, body.data, column, unit)
    squares = eigh((K + K.T) / 2, M, eigvals_only=True)
    return np.asarray(np.sign(squares) * np.sqrt(np.abs(squares)) / (2 * math.pi))


class _Body:
    """The robot in MuJoCo. Coordinates q (nq,), their changes and the forces on them (nv,) are MuJoCo's own.

    A free body has a quaternion in q, and the change of its rotation is in its own frame.
    """

    def __init__(self, robot: Robot, lengths: Sequence[float]) -> None:
        self.robot = robot
        self.model = mujoco.MjModel.from_xml_string(xml(robot, lengths))
        self.data = mujoco.MjData(self.model)
        swivels = [i for i, line in enumerate(robot.lines) if not isinstance(line.sheave, Eyelet)]
        self.swivels = [(i, self.model.joint(f"V{i}").qposadr[0]) for i in swivels]
        self.free = np.ones(self.model.nv, bool)  # the pose and the levers, not the turn of a sheave about the vertical
        self.free[[self.model.joint(f"V{i}").dofadr[0] for i in swivels]] = False

    def at(self, pose: Sequence[float]) -> np.ndarray:
        """Return coordinates of the platform at a pose (n,) and of levers that halve the angle of their two spans."""
        q = np.zeros(self.model.nq)
        q[:3] = pose[:3]
        if self.robot.n == 6:
            angle = float(np.linalg.norm(pose[3:]))
            mujoco.mju_axisAngle2Quat(q[3:7], np.array(pose[3:]) / (angle or 1.0), angle)
        self._place(q)
        for i, line in enumerate(self.robot.lines):
            if isinstance(line.sheave, UniversalJoint):
                x, y, z = self._reach(i, line)
                down = -math.pi / 2 if line.sheave.wrap == "over" else math.pi / 2
                q[self.model.joint(f"L{i}").qposadr[0]] = (math.atan2(z, math.hypot(x, y)) + down) / 2
        return q

    def turned(self, q: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Return coordinates after a change (nv,), with the sheaves turned to the platform."""
        moved = q.copy()
        mujoco.mj_integratePos(self.model, moved, step, 1.0)
        self._place(moved)
        for i, address in self.swivels:
            x, y, _ = self._reach(i, self.robot.lines[i])
            moved[address] = math.atan2(y, x)
        return moved

    def force(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        """Return the force (nv,) on the robot held still at q, what external loads have in it, and the energy, J."""
        self._place(q)
        self.data.qvel[:] = 0
        mujoco.mj_forward(self.model, self.data)
        platform, pushed = self.robot.platform, np.zeros(self.model.nv)
        moment = platform.moment if self.robot.n == 6 else (0.0, 0.0, 0.0)
        origin, body = self.data.body("platform").xpos, self.model.body("platform").id
        loads = np.array(platform.force), np.array(moment)
        mujoco.mj_applyFT(self.model, self.data, *loads, origin, body, pushed)
        return self.data.qfrc_passive - self.data.qfrc_bias + pushed, pushed, float(self.data.energy[0])

    def downhill(self, q: np.ndarray, force: np.ndarray) -> np.ndarray:
        """Return Newton's step (nv,), turned round in directions in which the robot is not stable."""
        J, step = self.stiffness(q), np.zeros(self.model.nv)
        values, vectors = np.linalg.eigh((J + J.T) / 2)
        if values[0] > 1e-9 * values[-1]:
            step[self.free] = np.linalg.solve(J, force[self.free])
        else:
            sizes = np.maximum(np.abs(values), 1e-9 * np.abs(values).max())
            step[self.free] = vectors @ (vectors.T @ force[self.free] / sizes)
        return step * min(1.0, 0.3 / np.abs(step).max(initial=1e-300))

    def pose(self, q: np.ndarray) -> np.ndarray:
        """Return the platform's pose (n,), m and rotation vector, rad."""
        if self.robot.n == 3:
            return q[:3].copy()
        vector = np.zeros(3)
        mujoco.mju_quat2Vel(vector, q[3:7], 1.0)
        return np.concatenate([q[:3], vector])

    def tensions(self) -> np.ndarray:
        """Return the tensions (m,) N where forces were last taken."""
        stretch = self.data.ten_length - self.model.tendon_lengthspring[:, 1]
        return self.model.tendon_stiffness * np.maximum(0.0, stretch)

    def _place(self, q: np.ndarray) -> None:
        self.data.qpos[:] = q
        mujoco.mj_kinematics(self.model, self.data)

    def _reach(self, i: int, line: Line) -> np.ndarray:
        """Return where line i's platform point is from its exit point (3), m, world, as last placed."""
        return self.data.site(f"B{i}").xpos - line.exit_point

    def stiffness(self, q: np.ndarray) -> np.ndarray:
        """Return minus the derivative of `force` wrt the free coordinates, by central differences."""
        columns = []
        for unit in np.eye(self.model.nv)[self.free] * 1e-6:
            back, on = (self.force(self.turned(q, sign * unit))[0] for sign in (-1, 1))
            columns.append((back - on)[self.free] / 2e-6)
        return np.array(columns).T


def xml(robot: Robot, lengths: Sequence[float]) -> str:
    """Return the robot in MuJoCo's format (MJCF)."""
    rigid = robot.n == 6
    slides = "".join(f'<joint type="slide" axis="{axis}"/>' for axis in ("1 0 0", "0 1 0", "0 0 1"))
    centre = _text(robot.platform.centre_of_mass) if rigid else "0 0 0"
    inertia = 'diaginertia="1 1 1"'
    if rigid and robot.platform.inertia is not None:
        inertia = f'fullinertia="{_text((*robot.platform.inertia, *robot.platform.inertia_products))}"'
    inertial = f'<inertial pos="{centre}" mass="{robot.platform.mass!r}" {inertia}/>'
    items = list(enumerate(zip(robot.lines, lengths, strict=True)))
    sites = "".join(f'<site name="B{i}" pos="{_text(line.platform_point)}"/>' for i, (line, _) in items)
    return f"""<mujoco>
  <compiler angle="radian"/>
  <option gravity="0 0 {-robot.scene.gravity!r}"><flag energy="enable"/></option>
  <worldbody>
    <body name="platform">{"<freejoint/>" if rigid else slides}{inertial}{sites}</body>
    {"".join(_mounting(i, line, robot.scene.gravity) for i, (line, _) in items)}
  </worldbody>
  <tendon>{"".join(_tendon(i, line, float(length)) for i, (line, length) in items)}</tendon>
</mujoco>"""


def _mounting(i: int, line: Line, gravity: float) -> str:
    """Return where the tendon begins and what it runs over: a site, or a sheave that turns about the vertical."""
    A, sheave = np.array(line.exit_point), line.sheave
    if isinstance(sheave, Eyelet):
        begin = "" if line.winch_exit is None else f'<site name="C{i}" pos="{_text(line.winch_exit)}"/>'
        return f'{begin}<site name="A{i}" pos="{_text(A)}"/>'
    side = 1 if sheave.wrap == "over" else -1
    C = A - [0, 0, side * FEED] if line.winch_exit is None else line.winch_exit
    r = sheave.radius
    if isinstance(sheave, UniversalJoint):
        if line.winch_exit is None:
            raise ValueError(f"line {line.name!r}: a sheave that moves needs to know where its winch is")
        mass, arm = sheave.lever_weight / gravity + 1e-9, sheave.lever_mass_centre
        joint, inertia = f'<joint name="L{i}" type="hinge" axis="0 -1 0"/>', _inertial(arm, mass)
        centre, beyond = (sheave.lever, 0, 0), (sheave.lever - 3 * r, 0, 0)
    else:
        joint, inertia = "", _inertial(0, 1e-3)
        centre, beyond = (r, 0, 0), (r, 0, side * 2 * r)
    parts = f"""{joint}{inertia}<site name="S{i}" pos="{_text(beyond)}"/>
      <geom name="W{i}" type="cylinder" pos="{_text(centre)}" zaxis="0 1 0" size="{r!r} {r / 10!r}"
        contype="0" conaffinity="0"/>"""
    if joint:
        parts = f"{_inertial(0, 1e-9)}<body>{parts}</body>"
    swivel = f'<joint name="V{i}" type="hinge" axis="0 0 1"/>'
    return f'<site name="C{i}" pos="{_text(C)}"/><body pos="{_text(A)}">{swivel}{parts}</body>'


def _tendon(i: int, line: Line, length: float) -> str:
    """Return the elastic tendon, which hangs slack below its length and pulls beyond it."""
    if isinstance(line.sheave, Eyelet):
        bend = f'<site site="A{i}"/>'
        begins = line.winch_exit is not None
    else:
        if not line.arc_elastic:
            raise ValueError(f"line {line.name!r}: a tendon stretches on its sheave too")
        bend, begins = f'<geom geom="W{i}" sidesite="S{i}"/>', True
    path = (f'<site site="C{i}"/>' if begins else "") + bend + f'<site site="B{i}"/>'
    dead = _stiff_part(line)
    rest_length = length - line.dead_length + (FEED if begins and line.winch_exit is None else 0.0)
    stiffness = line.cable.stiffness / (length - line.dead_length - dead)
    return f'<spatial stiffness="{stiffness!r}" springlength="0 {rest_length!r}">{path}</spatial>'


def _stiff_part(line: Line) -> float:
    """Return the length of a dead span that does not stretch, m."""
    if line.dead_elastic or line.winch_exit is None:
        return 0.0
    if isinstance(line.sheave, UniversalJoint):
        raise ValueError(f"line {line.name!r}: a dead span that moves has to stretch here")
    return math.dist(line.exit_point, line.winch_exit)


def _inertial(x: float, mass: float) -> str:
    return f'<inertial pos="{x!r} 0 0" mass="{mass!r}" diaginertia="1e-3 1e-3 1e-3"/>'


def _text(vector: Sequence[float]) -> str:
    return " ".join(repr(float(value)) for value in vector)
