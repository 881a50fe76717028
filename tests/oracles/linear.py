"""Oracle: how a robot answers to small changes at an equilibrium, by differences with 50 digits."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from mpmath import mp, mpf

from cablewright.robot import Line, Robot
from oracles.irvine import DIGITS, Real
from oracles.line import LineState, Model, check
from oracles.machine import STEP, States, checks, solve, state_of, system, total, unknowns
from oracles.platform import Place, turned_by

SMALL = mpf(10) ** -15
"""How far the platform is moved, m or rad: its square is the relative error of central differences."""


def stiffness(
    robot: Robot, lengths: Sequence[Real], pose: Sequence[Real], states: States, model: Model = "catenary"
) -> np.ndarray:
    """Return the tangent stiffness (n, n): the restoring wrench per motion of the platform, lengths (m,) held.

    Everything that acts on the platform counts, so also the weight whose moment changes as the platform turns. The
    lines are settled again at each displaced pose; ``states`` say from where. The pose need not be an equilibrium.
    """
    with mp.workdps(DIGITS):
        here = Place.of(pose)
        settled = _settled(robot, lengths, here, states, model)
        columns = []
        for k in range(robot.n):
            ends = []
            for step in (SMALL, -SMALL):
                there = here.moved([step if j == k else mpf(0) for j in range(robot.n)])
                again = _settled(robot, lengths, there, settled, model)
                ends.append(total(robot, there, checks(robot, lengths, there, again, model)))
            columns.append([float((back - on) / (2 * SMALL)) for on, back in zip(*ends, strict=True)])
        return np.array(columns).T


def motion(
    robot: Robot, lengths: Sequence[Real], pose: Sequence[Real], states: States, model: Model = "catenary"
) -> np.ndarray:
    """Return the motion (n, m) of the platform per unstrained length of each line, m/m and rad/m.

    It is that of the equilibrium nearest to ``pose`` and ``states``, from the Jacobian of all equations, lines' and
    platform's, together. A line that is slack without weight moves nothing.
    """
    n, found = robot.n, solve(robot, lengths, pose, states, model)
    with mp.workdps(DIGITS):
        _, J = system(robot, lengths, found.pose, found.states, model)
        factors, order = mp.LU_decomp(J)
        turns = _turns(found.pose)
        columns, last = np.zeros((n, robot.m)), n - 1
        for i, (line, state) in enumerate(zip(robot.lines, found.states, strict=True)):
            if state is not None:
                last += len(unknowns(line, state))
                unit = mp.matrix(J.rows, 1)
                unit[last] = 1  # the line's last equation ends with minus its length
                change = mp.U_solve(factors, mp.L_solve(factors, unit, order))
                columns[:, i] = [float(value) for value in (*change[:3], *(turns * change[3:n] if n == 6 else ()))]
        return columns


def settle(
    line: Line, gravity: Real, point: Sequence[Real], length: Real, state: LineState, model: Model = "catenary"
) -> LineState:
    """Return the state near ``state`` in which a line of that length reaches the point (3), m, world, at rest.

    Raises `ArithmeticError` if it is not found within 60 steps.
    """

    def equations(values: Sequence[mpf]) -> mp.matrix:
        return mp.matrix(check(line, gravity, point, length, state_of(line, values), model).vector)

    with mp.workdps(DIGITS):
        here = unknowns(line, state)
        for _ in range(60):
            base = equations(here)
            J = mp.matrix(len(here))
            for k in range(len(here)):
                J[:, k] = (equations([v + STEP if j == k else v for j, v in enumerate(here)]) - base) / STEP
            step = mp.lu_solve(J, -base)
            size = mp.norm(step, mp.inf)
            damping = min(mpf(1), mpf("0.3") / size) if size else mpf(1)
            here = [value + damping * change for value, change in zip(here, step, strict=True)]
            if size < mpf(10) ** -22:  # the next one would be below 1e-44
                return state_of(line, here)
    raise ArithmeticError(f"line {line.name!r} does not settle at {[float(value) for value in point]}")


def _settled(robot: Robot, lengths: Sequence[Real], at: Place, states: States, model: Model) -> list[LineState | None]:
    gravity, items = robot.scene.gravity, zip(robot.lines, lengths, states, strict=True)
    return [
        None if state is None else settle(line, gravity, at.point(line.platform_point), L, state, model)
        for line, L, state in items
    ]


def _turns(pose: Sequence[mpf]) -> mp.matrix:
    """Return the small rotation in space (3, 3) per component of the pose's rotation vector; nothing for a point."""
    if len(pose) == 3:
        return mp.matrix(0)
    here, columns = Place.of(pose).rotation, []
    for k in range(3, 6):
        near = Place.of([value + STEP if j == k else value for j, value in enumerate(pose)]).rotation
        columns.append([value / STEP for value in turned_by(here, near)])
    return mp.matrix(columns).T
