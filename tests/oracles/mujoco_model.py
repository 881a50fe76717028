"""Oracle: a robot with a point platform as a MuJoCo model of elastic tendons over sheaves, and where it comes to rest.

The tendons weigh nothing and stretch along their whole length, so a line must have ``arc_elastic``; a dead span that
does not stretch is allowed where its length is constant.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from cablewright.robot import Eyelet, Line, Robot, UniversalJoint

FEED = 1.0
"""How far from the exit point, on the swivel axis, a tendon begins that has no winch exit, m."""


@dataclass(frozen=True)
class Rest:
    """Where MuJoCo's platform rests: pose (3) m, tensions (m) N and the largest force or torque left over (N, N m)."""

    pose: np.ndarray
    tensions: np.ndarray
    left_over: float


def rest(robot: Robot, lengths: Sequence[float], start: Sequence[float]) -> Rest:
    """Return where the robot rests with lines of those unstrained lengths (m): downhill in energy from pose ``start``.

    The sheaves are turned to the platform at every step; that no torque is left to turn them is part of the result.
    Raises `ArithmeticError` if forces are left over.
    """
    model = mujoco.MjModel.from_xml_string(xml(robot, lengths))
    data = mujoco.MjData(model)
    free = _free(robot)
    q = _turned(robot, np.array(start), _first_levers(robot, start))
    force = _force(model, data, q)
    for _ in range(500):
        energy = data.energy[0]
        values, vectors = np.linalg.eigh(_stiffness(model, data, robot, q, free))
        step = vectors @ (vectors.T @ force[free] / np.maximum(np.abs(values), 1e-9 * np.abs(values).max()))
        step *= min(1.0, 0.3 / np.abs(step).max(initial=1e-300))
        while True:
            trial = _turned(robot, q[:3] + step[:3], q[free][3:] + step[3:])
            trial_force = _force(model, data, trial)
            if data.energy[0] <= energy - 1e-4 * step @ force[free] + 1e-13 * (1 + abs(energy)):
                break
            step /= 3
        q, force = trial, trial_force
        if np.abs(step).max() < 1e-13:
            break
    tensions = model.tendon_stiffness * np.maximum(0.0, data.ten_length - model.tendon_lengthspring[:, 1])
    if np.abs(force).max() > 1e-6:
        raise ArithmeticError(f"MuJoCo's robot does not come to rest: {np.abs(force).max():.3g} N or N m are left")
    return Rest(q[:3].copy(), tensions, float(np.abs(force).max()))


def xml(robot: Robot, lengths: Sequence[float]) -> str:
    """Return the robot in MuJoCo's format (MJCF)."""
    slides = "".join(f'<joint type="slide" axis="{axis}"/>' for axis in ("1 0 0", "0 1 0", "0 0 1"))
    items = list(enumerate(zip(robot.lines, lengths, strict=True)))
    sites = "".join(f'<site name="B{i}" pos="{_text(line.platform_point)}"/>' for i, (line, _) in items)
    return f"""<mujoco>
  <compiler angle="radian"/>
  <option gravity="0 0 {-robot.scene.gravity!r}"><flag energy="enable"/></option>
  <worldbody>
    <body>{slides}<inertial pos="0 0 0" mass="{robot.platform.mass!r}" diaginertia="1 1 1"/>{sites}</body>
    {"".join(_mounting(i, line, robot.scene.gravity) for i, (line, _) in items)}
  </worldbody>
  <tendon>{"".join(_tendon(i, *item) for i, item in items)}</tendon>
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
        joint, inertia = '<joint type="hinge" axis="0 -1 0"/>', _inertial(arm, mass)
        centre, beyond = (sheave.lever, 0, 0), (sheave.lever - 3 * r, 0, 0)
    else:
        joint, inertia = "", _inertial(0, 1e-3)
        centre, beyond = (r, 0, 0), (r, 0, side * 2 * r)
    parts = f"""{joint}{inertia}<site name="S{i}" pos="{_text(beyond)}"/>
      <geom name="W{i}" type="cylinder" pos="{_text(centre)}" zaxis="0 1 0" size="{r!r} {r / 10!r}"
        contype="0" conaffinity="0"/>"""
    if joint:
        parts = f"{_inertial(0, 1e-9)}<body>{parts}</body>"
    swivel = '<joint type="hinge" axis="0 0 1"/>'
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


def _free(robot: Robot) -> np.ndarray:
    """Return which coordinates are not the turn of a sheave about the vertical: the pose, and the levers."""
    free = [True] * 3
    for line in robot.lines:
        free += [] if isinstance(line.sheave, Eyelet) else [False]
        free += [True] if isinstance(line.sheave, UniversalJoint) else []
    return np.array(free)


def _turned(robot: Robot, pose: np.ndarray, levers: Sequence[float]) -> np.ndarray:
    """Return all coordinates with the sheaves turned to a platform at ``pose``."""
    q, rest_of_levers = list(pose), list(levers)
    for line in robot.lines:
        x, y, _ = np.array(pose) + line.platform_point - line.exit_point
        q += [] if isinstance(line.sheave, Eyelet) else [math.atan2(y, x)]
        q += [rest_of_levers.pop(0)] if isinstance(line.sheave, UniversalJoint) else []
    return np.array(q)


def _first_levers(robot: Robot, pose: Sequence[float]) -> list[float]:
    """Return levers that halve the angle between their two spans."""
    levers = []
    for line in robot.lines:
        if isinstance(line.sheave, UniversalJoint):
            x, y, z = np.array(pose) + line.platform_point - line.exit_point
            down = -math.pi / 2 if line.sheave.wrap == "over" else math.pi / 2
            levers.append((math.atan2(z, math.hypot(x, y)) + down) / 2)
    return levers


def _force(model: mujoco.MjModel, data: mujoco.MjData, q: np.ndarray) -> np.ndarray:
    """Return the generalized force on the robot held still at ``q``."""
    data.qpos[:] = q
    data.qvel[:] = 0
    mujoco.mj_forward(model, data)
    return data.qfrc_passive - data.qfrc_bias


def _stiffness(model: mujoco.MjModel, data: mujoco.MjData, robot: Robot, q: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Return minus the derivative of `_force` wrt the free coordinates, by central differences."""
    columns = []
    for unit in np.eye(free.sum()) * 1e-6:
        near = [_turned(robot, q[:3] + s * unit[:3], q[free][3:] + s * unit[3:]) for s in (-1, 1)]
        columns.append((_force(model, data, near[0]) - _force(model, data, near[1]))[free] / 2e-6)
    return (np.array(columns) + np.array(columns).T) / 2


def _inertial(x: float, mass: float) -> str:
    return f'<inertial pos="{x!r} 0 0" mass="{mass!r}" diaginertia="1e-3 1e-3 1e-3"/>'


def _text(vector: Sequence[float]) -> str:
    return " ".join(repr(float(value)) for value in vector)
