"""Made-up measurements of a robot, and honest errors of what a calibration makes of them: in one run, in one frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.calibration.problem import Measured, Problem
from cablewright.errors import InputError
from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse

__all__ = ["Simulated", "aligned", "measure", "random_poses", "simulate"]

Array = NDArray[np.float64]

_TRIES: Final = 200  # batches of places before a frame counts as one in which nothing hangs
_INSET: Final = 0.1  # of the frame's sides: how near to them no pose is
_TURN: Final = 0.1  # rad: of a rigid platform about each axis
GUESS: Final = 0.05
"""How far starting guesses are from the poses, m."""


@dataclass(frozen=True, eq=False)
class Simulated:
    """Measurements with what is true: poses (N, n), home lengths (m,)."""

    measured: Measured
    poses: Array
    home_lengths: Array


def simulate(robot: Robot, poses: int, noise: float, seed: int, *, guess: float = GUESS) -> Simulated:
    """Measure *robot*, taken as true, with encoders of standard deviation *noise* (m) at random poses in its workspace.

    The first pose is home. Guesses are uniform within *guess* (m, and rad) of the poses.
    """
    if poses < 1:
        raise InputError(f"poses = {poses}: at least 1 is wanted")
    if not (0.0 <= noise < np.inf and 0.0 <= guess < np.inf):
        raise InputError(f"noise = {noise:g}, guess = {guess:g}: numbers of metres from 0 are wanted")
    rng = np.random.default_rng(seed)
    return measure(robot, random_poses(robot, poses, rng), noise, rng, guess)


def measure(robot: Robot, poses: Array, noise: float, rng: np.random.Generator, guess: float = GUESS) -> Simulated:
    """Measure *robot* at *poses* (N, n), the first of which is home."""
    nothing = Measured(np.zeros((len(poses), robot.m)))
    problem = Problem.of(robot, nothing, hold=False)
    lengths = problem.lengths(problem.start, poses)
    if not np.isfinite(lengths).all():
        raise InputError(f"{robot.name}: pose {int(np.argmax(~np.isfinite(lengths).all(axis=1))) + 1} is in a sheave")
    counted = lengths - lengths[0] + rng.normal(0.0, noise, lengths.shape)
    guesses = poses + rng.uniform(-guess, guess, poses.shape)
    return Simulated(Measured(counted, guesses), poses, lengths[0])


def random_poses(robot: Robot, count: int, rng: np.random.Generator) -> Array:
    """Poses (count, n), uniform among those in the frame that straight lines hold within their tension limits."""
    model = Model(robot, Fidelity.of("rigid"))
    low, high = np.array(robot.scene.frame_min), np.array(robot.scene.frame_max)
    inset = _INSET * (high - low)
    found: list[Array] = []
    for _ in range(_TRIES):
        poses = np.zeros((2 * count, robot.n))
        poses[:, :3] = rng.uniform(low + inset, high - inset, (len(poses), 3))
        poses[:, 3:] = rng.uniform(-_TURN, _TURN, (len(poses), robot.n - 3))
        if robot.m >= robot.n:
            poses = poses[solve_inverse(model, poses).ok]
        found += list(poses)
        if len(found) >= count:
            return np.array(found[:count])
    raise InputError(f"{robot.name}: hardly any place in its frame can be held within the tension limits")


def aligned(points: Array, truth: Array, others: Array | None = None, tilt: bool = False) -> tuple[Array, Array]:
    """*points* (m, 3) moved by translation and yaw, with *tilt* by any rotation, onto *truth* as well as can be.

    *others* (N, 3) move along. These are the freedoms that encoders do not see: an error before this says how well a
    start was chosen, not how good the calibration is.
    """
    others = np.zeros((0, 3)) if others is None else others
    centre, middle = points.mean(axis=0), truth.mean(axis=0)
    cross = (points - centre).T @ (truth - middle)
    if tilt:
        left, _, right = np.linalg.svd(cross)
        turn = right.T @ np.diag([1.0, 1.0, np.sign(np.linalg.det(right.T @ left.T))]) @ left.T
    else:
        angle = np.arctan2(cross[0, 1] - cross[1, 0], cross[0, 0] + cross[1, 1])
        turn = np.array([[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])
    return (points - centre) @ turn.T + middle, (others - centre) @ turn.T + middle
