"""What the tests share: robots, fidelities, poses. A law runs on the product of these."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba.core.types import unliteral
from scipy.spatial.transform import Rotation

from cablewright import kernels
from cablewright.analyses.accuracy.nozzle_error import Accuracy, AccuracyQuestion
from cablewright.analyses.accuracy.spread import SpreadProblem
from cablewright.kernels.compiler import KernelDispatcher
from cablewright.models.fidelity import CableLaw, Fidelity, SheaveLaw
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Eyelet, Robot, Swivel, UniversalJoint, load
from cablewright.solvers.inverse import solve_inverse
from oracles.line import LineState

SEED = 20210603


def some(values: Iterable[Any], fast: int = 1) -> list[Any]:
    """Values of a test's parameter, of which all but the first *fast* are slow: one law, on more of the same."""
    slow = pytest.mark.slow
    return [
        each if k < fast else pytest.param(*(each if isinstance(each, tuple) else (each,)), marks=slow)
        for k, each in enumerate(values)
    ]


def often(brief: int, unhurried: int) -> int:
    """How many examples of a law a test draws: more where the slow tests run too."""
    return brief if os.environ.get("CABLEWRIGHT_TESTS") == "brief" else unhurried


TURNED = 0.05
"""How far random poses of a rigid body are turned about each axis, rad."""


LIBRARY = (
    "cogiro",
    "grab-four-lines",
    "house-printer",
    "jung2020",
    "jung2020-table1",
    "merlet2023",
    "paty2021",
    "wang2021",
)
"""Robots of the library that have all that lines and platforms of it have but planes and mechanical advantage."""


@cache
def robots() -> tuple[Robot, ...]:
    """Those, and relatives that they do not cover: wrap under, six lines, a dead span off its axis."""
    return (*map(load, LIBRARY), under(), six_lines(), off_axis(), jointed_body())


def models(*laws: CableLaw) -> Iterator[Model]:
    """Every robot under every fidelity that it can have, with cables of these laws."""
    for robot in robots():
        order = list(SheaveLaw)
        built = min(order.index(SheaveLaw(line.sheave.kind)) for line in robot.lines)
        for sheave in order[: built + 1]:
            for law in laws:
                yield Model(robot, Fidelity(law, sheave))


def name(model: Model) -> str:
    """For a test's id."""
    sheave = model.fidelity.sheave
    return f"{model.robot.name}-{model.fidelity.cable.value}-{'built' if sheave is None else sheave.value}"


def poses(model: Model, count: int, seed: int = SEED) -> Equilibrium:
    """*count* random poses inside the frame that the model can hold within its tension limits, solved."""
    tried = random_poses(model, (100 if model.n == 6 else 20) * count, seed)
    good = np.empty((0, model.n))
    for first in range(0, len(tried), 4 * count):
        chunk = tried[first : first + 4 * count]
        good = np.concatenate([good, chunk[solve_inverse(model, chunk).ok]])
        if len(good) >= count:
            return solve_inverse(model, good[:count])
    raise AssertionError(f"only {len(good)} of {len(tried)} poses are feasible, {count} wanted")


def random_poses(model: Model, count: int, seed: int = SEED) -> np.ndarray:
    """Random poses inside the frame; rigid bodies a little turned, degrees of freedom that gravity decides left to
    it."""
    rng = np.random.default_rng(seed)
    low, high = np.array(model.robot.scene.frame_min), np.array(model.robot.scene.frame_max)
    places = rng.uniform(low, high, (count, 3))
    if model.n == 3:
        return places
    turns = rng.normal(0.0, TURNED, (count, 3))
    turns[:, : max(0, model.n - model.m)] = np.nan
    return np.column_stack([places, turns])


def turned(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Angle (rad) between the rotations of poses; 0 for a point."""
    if first.shape[-1] == 3:
        return np.zeros(first.shape[:-1])
    return (Rotation.from_rotvec(first[..., 3:]).inv() * Rotation.from_rotvec(second[..., 3:])).magnitude()


def line_states(row: Equilibrium) -> list[LineState]:
    """The states of a single equilibrium as the oracle takes them."""
    return [
        LineState(tension, phi, free, psi, dead, beta)
        for tension, (phi, _, free, dead, psi, beta) in zip(row.tensions, row.states, strict=True)
    ]


def replaced(robot: Robot, name: str, **line_changes: object) -> Robot:
    """*robot* under another name with all its lines changed."""
    lines = tuple(line.model_copy(update=line_changes) for line in robot.lines)
    return robot.model_copy(update={"name": name, "lines": lines})


def under() -> Robot:
    """merlet2023 fed from above: its cables pass under their sheaves."""
    robot = load("merlet2023")
    lines = tuple(
        line.model_copy(
            update={
                "sheave": Swivel(radius=0.0375, wrap="under"),
                "winch_exit": (*line.exit_point[:2], line.exit_point[2] + 1.0),
            }
        )
        for line in robot.lines
    )
    return robot.model_copy(update={"name": "under", "lines": lines})


def six_lines() -> Robot:
    """Six lines to one point, from exit points at different heights: two redundant."""
    robot = load("merlet2023")
    corners = [
        (2.5, 5.0, 4.0),
        (-2.5, 5.0, 4.3),
        (-2.5, -5.0, 4.1),
        (2.5, -5.0, 3.9),
        (2.6, 0.3, 4.2),
        (-2.7, -0.4, 4.0),
    ]
    lines = tuple(
        robot.lines[0].model_copy(update={"name": f"line {i}", "exit_point": corner, "winch_exit": (*corner[:2], 0.0)})
        for i, corner in enumerate(corners)
    )
    return robot.model_copy(update={"name": "six-lines", "lines": lines})


def off_axis() -> Robot:
    """merlet2023 through rings, its winches two metres away from below them."""
    robot = load("merlet2023")
    lines = tuple(
        line.model_copy(
            update={"sheave": Eyelet(), "winch_exit": (0.5 * line.exit_point[0], 0.8 * line.exit_point[1], 0.0)}
        )
        for line in robot.lines
    )
    return robot.model_copy(update={"name": "off-axis", "lines": lines})


def jointed_body() -> Robot:
    """cogiro on universal joints fed from the ground, under a side wind, off its centre of mass."""
    robot = load("cogiro")
    joint = UniversalJoint(radius=0.05, lever=0.104, lever_weight=6.85, lever_mass_centre=0.0706)
    lines = tuple(
        line.model_copy(update={"sheave": joint, "winch_exit": (*line.exit_point[:2], 0.0)}) for line in robot.lines
    )
    platform = robot.platform.model_copy(update={"force": (40.0, -25.0, 10.0), "centre_of_mass": (0.1, 0.05, 0.4)})
    return robot.model_copy(update={"name": "jointed-body", "lines": lines, "platform": platform})


def assert_one_signature_per_kernel() -> None:
    """Of the kernels compiled in this process until now, for plain robots and for others: see `layout.Packed`.

    Arguments known at compile time count as their types.
    """
    tree = Path(kernels.__file__).parent
    for path in tree.rglob("[!_]*.py"):
        module = import_module(".".join(("cablewright.kernels", *path.relative_to(tree).with_suffix("").parts)))
        for each in vars(module).values():
            if isinstance(each, KernelDispatcher):
                kinds = {tuple(map(unliteral, signature)) for signature in each.signatures}
                plain = {kind for kind in kinds if "none" in str(kind)}
                assert len(plain) <= 1, f"{each.__name__}: {plain}"
                assert len(kinds - plain) <= 1, f"{each.__name__}: {kinds - plain}"


def nozzle_errors(robot: Robot | Model, poses: Any, *args: Any, retraction: Any = None, **options: Any) -> Accuracy:
    """Errors at *poses*, (n,) or (N, n); other arguments as for `AccuracyQuestion.of`."""
    asked = AccuracyQuestion.of(robot, *args, **options)
    return asked.answer(asked.hold(poses, retraction))


def spread_problem(robot: Robot | Model, poses: Any, *args: Any) -> SpreadProblem:
    """The problem whose spread is part of `nozzle_errors`."""
    asked = AccuracyQuestion.of(robot, *args)
    return asked.problem(asked.hold(poses))
