"""Oracle: the balance of a whole robot with a point platform, and its solution with 50 digits by a plain Newton.

A line state of None is a line that hangs slack without weight and carries nothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from mpmath import mp, mpf

from cablewright.robot import Line, Robot, UniversalJoint
from oracles.irvine import DIGITS, Real
from oracles.line import LineCheck, LineState, Model, check
from oracles.tangent import length as tangent_length
from oracles.tangent import straight

States = Sequence[LineState | None]

STEP = mpf(10) ** -25
NEXT_TO_NOTHING = 1e-9
"""The tension, N, at which a slack line would just begin to pull."""


@dataclass(frozen=True)
class Balance:
    """What remains: the largest geometric miss (m), the unbalanced force (N), the largest moment / (tension lever)."""

    geometry: float
    force: float
    moment: float


@dataclass(frozen=True)
class Solution:
    """A pose (3) m, the states of the lines there, and what remains of their equations."""

    pose: tuple[mpf, mpf, mpf]
    states: tuple[LineState | None, ...]
    balance: Balance


def balance(
    robot: Robot, lengths: Sequence[Real], pose: Sequence[Real], states: States, model: Model = "catenary"
) -> Balance:
    """Return how far a claimed pose and the claimed states of all lines are from equilibrium.

    ``lengths``: (m,) unstrained, m. ``pose``: (3,) m.
    """
    with mp.workdps(DIGITS):
        checks = _checks(robot, lengths, pose, states, model)
        force = _force(robot, checks)
        geometry = [mpf(0), *(item.geometry for item in checks)]
        slack = [_tightness(*item, pose) for item in zip(robot.lines, lengths, states, strict=True)]
        moment = [mpf(0), *(abs(value) for item in checks for value in item.moment)]
        return Balance(float(max(*geometry, *slack)), float(mp.norm(force)), float(max(moment)))


def solve(
    robot: Robot,
    lengths: Sequence[Real],
    start_pose: Sequence[Real],
    start_states: States,
    model: Model = "catenary",
    tolerance: float = 1e-20,
) -> Solution:
    """Return the equilibrium near a start, polished until its Newton step is below ``tolerance`` (m, rad, 1).

    Raises `ArithmeticError` if it is not found within 60 steps.
    """
    with mp.workdps(DIGITS):
        pose, states = [mpf(value) for value in start_pose], list(start_states)
        for _ in range(60):
            rows, J = _system(robot, lengths, pose, states, model)
            step = mp.lu_solve(J, -rows)
            damping = min(mpf(1), *(mpf("0.3") / abs(value) for value in step if value))
            at = 3
            pose = [value + damping * change for value, change in zip(pose, step[:3], strict=True)]
            for i, (line, state) in enumerate(zip(robot.lines, states, strict=True)):
                if state is not None:
                    unknowns = _unknowns(line, state)
                    values = [unknowns[k] + damping * step[at + k] for k in range(len(unknowns))]
                    states[i], at = _state(line, values), at + len(values)
            if mp.norm(step, mp.inf) < tolerance:
                return Solution(tuple(pose), tuple(states), balance(robot, lengths, pose, states, model))
    raise ArithmeticError(f"no equilibrium within 60 steps; the last one was {float(mp.norm(step, mp.inf)):.3g}")


def start(robot: Robot, pose: Sequence[float], tensions: Sequence[float]) -> tuple[list[LineState], list[float]]:
    """Return the states of straight lines under those tensions (N) and their lengths (m): somewhere to start from."""
    states = [straight(line, _point(line, pose), T) for line, T in zip(robot.lines, tensions, strict=True)]
    return states, [tangent_length(line, state) for line, state in zip(robot.lines, states, strict=True)]


def _point(line: Line, pose: Sequence[Real]) -> list[Real]:
    return [p + b for p, b in zip(pose, line.platform_point, strict=True)]


def _tightness(line: Line, length: Real, state: LineState | None, pose: Sequence[Real]) -> mpf:
    """Return by how much a line that is said to be slack is too short for it, m; its lever hangs by its weight."""
    if state is not None:
        return mpf(0)
    at = straight(line, [float(value) for value in _point(line, pose)], NEXT_TO_NOTHING)
    return max(mpf(0), mpf(tangent_length(line, at)) - mpf(length))


def _checks(
    robot: Robot, lengths: Sequence[Real], pose: Sequence[Real], states: States, model: Model
) -> list[LineCheck]:
    items = zip(robot.lines, lengths, states, strict=True)
    gravity, pose = robot.scene.gravity, [mpf(value) for value in pose]
    return [check(line, gravity, _point(line, pose), L, state, model) for line, L, state in items if state is not None]


def _force(robot: Robot, checks: Sequence[LineCheck]) -> list[mpf]:
    weight = mpf(robot.platform.mass) * mpf(robot.scene.gravity)
    return [mp.fsum(item.force[k] for item in checks) - (weight if k == 2 else 0) for k in range(3)]


def _unknowns(line: Line, state: LineState) -> list[mpf]:
    values = [state.phi, mp.log(state.tension), state.free_length]
    values += [state.psi, state.dead_length] if line.winch_exit is not None else []
    values += [state.beta] if isinstance(line.sheave, UniversalJoint) else []
    return [mpf(value) for value in values]


def _state(line: Line, unknowns: Sequence[mpf]) -> LineState:
    rest = list(unknowns[3:])
    psi, dead = (rest.pop(0), rest.pop(0)) if line.winch_exit is not None else (0.0, 0.0)
    return LineState(mp.exp(unknowns[1]), unknowns[0], unknowns[2], psi, dead, *rest)


def _system(
    robot: Robot, lengths: Sequence[Real], pose: Sequence[mpf], states: States, model: Model
) -> tuple[mp.matrix, mp.matrix]:
    """Return all equations and their derivatives by forward differences, wrt the pose and the lines' unknowns."""
    size = 3 + sum(len(_unknowns(line, state)) for line, state in zip(robot.lines, states, strict=True) if state)
    rows, J = mp.matrix(size, 1), mp.matrix(size, size)
    load, at = mpf(robot.platform.mass) * mpf(robot.scene.gravity), 3
    rows[2] = -1
    for line, L, state in zip(robot.lines, lengths, states, strict=True):
        if state is None:
            continue
        here = [*pose, *_unknowns(line, state)]
        base = _equations(robot, line, L, here, model)
        own = range(at, at + len(base) - 3)
        for i, value in zip((0, 1, 2, *own), base, strict=True):
            rows[i] += value / load if i < 3 else value
        for k, column in enumerate((0, 1, 2, *own)):
            near = [value + STEP if j == k else value for j, value in enumerate(here)]
            moved = _equations(robot, line, L, near, model)
            for i, old, new in zip((0, 1, 2, *own), base, moved, strict=True):
                J[i, column] += (new - old) / STEP / (load if i < 3 else 1)
        at = own.stop
    return rows, J


def _equations(robot: Robot, line: Line, L: Real, values: Sequence[mpf], model: Model) -> list[mpf]:
    """Return a line's force on the platform and its own equations at a pose and its unknowns."""
    state = _state(line, values[3:])
    result = check(line, robot.scene.gravity, _point(line, values[:3]), L, state, model)
    return [*result.force, *result.vector]


def distance(first: Sequence[Real], second: Sequence[Real]) -> float:
    """Return how far apart two points are, m."""
    return math.dist([float(value) for value in first], [float(value) for value in second])
