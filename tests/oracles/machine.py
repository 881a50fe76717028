"""Oracle: the balance of a whole robot, and its solution with 50 digits by a plain Newton.

Poses, wrenches and motions are those of `oracles.platform`, for point platforms (n = 3) and rigid ones (n = 6). A line
state of None is a line that hangs slack without weight and carries nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from mpmath import mp, mpf

from cablewright.robot import Line, Robot, UniversalJoint
from oracles.irvine import DIGITS, Real
from oracles.line import LineCheck, LineState, Model, check
from oracles.platform import Place, load, turned_by, wrench
from oracles.tangent import length as tangent_length
from oracles.tangent import straight

States = Sequence[LineState | None]

STEP = mpf(10) ** -25
NEAR, SHRINKS = mpf("0.001"), mpf("0.01")
"""Below what step derivatives may be those of the last one, and by how much steps with them have to shrink."""
NEXT_TO_NOTHING = 1e-9
"""The tension, N, at which a slack line would just begin to pull."""


@dataclass(frozen=True)
class Balance:
    """What remains: the largest geometric miss (m), the unbalanced force (N), the largest moment / (tension lever).

    ``moment`` is that of the lines' levers. ``turning`` is the unbalanced moment about the platform's origin (N m), 0
    for a point.
    """

    geometry: float
    force: float
    moment: float
    turning: float = 0.0


@dataclass(frozen=True)
class Solution:
    """A pose (n,) m and rad, the states of the lines there, and what remains of their equations."""

    pose: tuple[mpf, ...]
    states: tuple[LineState | None, ...]
    balance: Balance


def balance(
    robot: Robot, lengths: Sequence[Real], pose: Sequence[Real], states: States, model: Model = "catenary"
) -> Balance:
    """Return how far a claimed pose and the claimed states of all lines are from equilibrium.

    ``lengths``: (m,) unstrained, m. ``pose``: (n,) m and rad.
    """
    with mp.workdps(DIGITS):
        at = Place.of(pose)
        found = checks(robot, lengths, at, states, model)
        left = mp.matrix(total(robot, at, found))
        geometry = [mpf(0), *(item.geometry for item in found if item is not None)]
        slack = [_tightness(*item, at) for item in zip(robot.lines, lengths, states, strict=True)]
        moment = [mpf(0), *(abs(value) for item in found if item is not None for value in item.moment)]
        turning = mp.norm(left[3:]) if robot.n == 6 else 0
        return Balance(float(max(*geometry, *slack)), float(mp.norm(left[:3])), float(max(moment)), float(turning))


def checks(
    robot: Robot, lengths: Sequence[Real], at: Place, states: States, model: Model = "catenary"
) -> list[LineCheck | None]:
    """Return the checks of all lines with the platform at a place; None for a slack line without weight."""
    gravity, items = robot.scene.gravity, zip(robot.lines, lengths, states, strict=True)
    return [
        None if state is None else check(line, gravity, at.point(line.platform_point), L, state, model)
        for line, L, state in items
    ]


def total(robot: Robot, at: Place, found: Sequence[LineCheck | None]) -> list[mpf]:
    """Return the wrench (n,) of the lines, the weight and the external load on a platform at a place."""
    wrenches = [load(robot, at)]
    for line, item in zip(robot.lines, found, strict=True):
        if item is not None:
            wrenches.append(wrench(robot.n, at.arm(line.platform_point), item.force))
    return [mp.fsum(values) for values in zip(*wrenches, strict=True)]


def solve(
    robot: Robot,
    lengths: Sequence[Real],
    start_pose: Sequence[Real],
    start_states: States,
    model: Model = "catenary",
    tolerance: float = 1e-20,
) -> Solution:
    """Return the equilibrium near a start, polished until its Newton step is below ``tolerance`` (m, rad, 1).

    Near the end derivatives are those of an earlier step, and steps, of which each shrinks by the same factor, go on
    to the square of ``tolerance``. Where steps do not shrink, all derivatives are new ones.

    Raises `ArithmeticError` if it is not found within 60 steps.
    """
    n, factors, before, near = robot.n, None, mp.inf, NEAR
    with mp.workdps(DIGITS):
        pose, states = [mpf(value) for value in start_pose], list(start_states)
        for _ in range(60):
            rows, J = system(robot, lengths, pose, states, model, slopes=factors is None)
            factors = mp.LU_decomp(J) if factors is None else factors
            step = mp.U_solve(factors[0], mp.L_solve(factors[0], -rows, factors[1]))
            size = mp.norm(step, mp.inf)
            if size > SHRINKS * before:
                factors, before, near = None, mp.inf, 0
                continue
            damping = min(mpf(1), *(mpf("0.3") / abs(value) for value in step if value))
            at = n
            pose = [value + damping * change for value, change in zip(pose, step[:n], strict=True)]
            for i, (line, state) in enumerate(zip(robot.lines, states, strict=True)):
                if state is not None:
                    values = unknowns(line, state)
                    values = [values[k] + damping * step[at + k] for k in range(len(values))]
                    states[i], at = state_of(line, values), at + len(values)
            if size < (tolerance if before == mp.inf else tolerance**2):
                return Solution(tuple(pose), tuple(states), balance(robot, lengths, pose, states, model))
            factors, before = (factors, size) if size < near else (None, mp.inf)
    raise ArithmeticError(f"no equilibrium within 60 steps; the last one was {float(size):.3g}")


def start(robot: Robot, pose: Sequence[float], tensions: Sequence[float]) -> tuple[list[LineState], list[float]]:
    """Return the states of straight lines under those tensions (N) and their lengths (m): somewhere to start from."""
    with mp.workdps(DIGITS):
        at = Place.of(pose)
        points = [_floats(at, line) for line in robot.lines]
    states = [straight(*item) for item in zip(robot.lines, points, tensions, strict=True)]
    return states, [tangent_length(line, state) for line, state in zip(robot.lines, states, strict=True)]


def _floats(at: Place, line: Line) -> list[float]:
    return [float(value) for value in at.point(line.platform_point)]


def _tightness(line: Line, length: Real, state: LineState | None, at: Place) -> mpf:
    """Return by how much a line marked as slack is too short for it, m; its lever hangs by its weight."""
    if state is not None:
        return mpf(0)
    hanging = straight(line, _floats(at, line), NEXT_TO_NOTHING)
    return max(mpf(0), mpf(tangent_length(line, hanging)) - mpf(length))


def unknowns(line: Line, state: LineState) -> list[mpf]:
    """Return a line state as the k numbers that Newton varies; the tension by its logarithm."""
    values = [state.phi, mp.log(state.tension), state.free_length]
    values += [state.psi, state.dead_length] if line.winch_exit is not None else []
    values += [state.beta] if isinstance(line.sheave, UniversalJoint) else []
    return [mpf(value) for value in values]


def state_of(line: Line, values: Sequence[mpf]) -> LineState:
    """Return the line state that k `unknowns` mean."""
    rest = list(values[3:])
    psi, dead = (rest.pop(0), rest.pop(0)) if line.winch_exit is not None else (0.0, 0.0)
    return LineState(mp.exp(values[1]), values[0], values[2], psi, dead, *rest)


def system(
    robot: Robot, lengths: Sequence[Real], pose: Sequence[mpf], states: States, model: Model, slopes: bool = True
) -> tuple[mp.matrix, mp.matrix]:
    """Return all equations and their derivatives by forward differences, wrt the pose and the lines' unknowns.

    Without ``slopes`` the derivatives are left at zero.

    First the wrench (n,) over the weight, N; then line by line its own equations, its length (m) last.
    """
    n = robot.n
    size = n + sum(len(unknowns(line, state)) for line, state in zip(robot.lines, states, strict=True) if state)
    rows, J = mp.matrix(size, 1), mp.matrix(size, size)

    def add(function: Callable[[Sequence[mpf]], list[mpf]], here: Sequence[mpf], own: range) -> None:
        """Add what depends on the pose and a line's own unknowns."""
        base = function(here)
        for i, value in zip((*range(n), *own), base, strict=True):
            rows[i] += value
        for k, column in enumerate((*range(n), *own) if slopes else ()):
            moved = function([value + STEP if j == k else value for j, value in enumerate(here)])
            for i, old, new in zip((*range(n), *own), base, moved, strict=True):
                J[i, column] += (new - old) / STEP

    add(lambda values: _over_weight(robot, load(robot, Place.of(values))), pose, range(0))
    at = n
    for line, L, state in zip(robot.lines, lengths, states, strict=True):
        if state is not None:
            own = unknowns(line, state)
            equations = partial(_equations, robot, line, L, model)
            add(equations, [*pose, *own], range(at, at + len(own)))
            at += len(own)
    return rows, J


def _equations(robot: Robot, line: Line, L: Real, model: Model, values: Sequence[mpf]) -> list[mpf]:
    """Return a line's wrench on the platform, over the weight, and its own equations at a pose and its unknowns."""
    at, state = Place.of(values[: robot.n]), state_of(line, values[robot.n :])
    result = check(line, robot.scene.gravity, at.point(line.platform_point), L, state, model)
    pull = wrench(robot.n, at.arm(line.platform_point), result.force)
    return [*_over_weight(robot, pull), *result.vector]


def _over_weight(robot: Robot, values: Sequence[mpf]) -> list[mpf]:
    weight = mpf(robot.platform.mass) * mpf(robot.scene.gravity)
    return [value / weight for value in values]


def distance(first: Sequence[Real], second: Sequence[Real]) -> float:
    """Return how far apart two points, or the origins of two poses, are, m."""
    return math.dist([float(value) for value in first[:3]], [float(value) for value in second[:3]])


def angle(first: Sequence[Real], second: Sequence[Real]) -> float:
    """Return the angle by which a platform rotates from one pose (n,) to another, rad: 0 for points."""
    with mp.workdps(DIGITS):
        return float(mp.norm(turned_by(Place.of(first).rotation, Place.of(second).rotation)))
