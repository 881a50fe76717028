"""Made-up measurements of a robot, and honest errors of what a calibration makes of them: in one run, in one frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.calibration.elastic_lines import FREED, Hanging
from cablewright.calibration.plan import CalibrationPlan
from cablewright.calibration.problem import CalibrationProblem, Measured
from cablewright.errors import InputError
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse

__all__ = ["Beside", "Simulated", "aligned", "measure", "random_poses", "simulate"]

Array = NDArray[np.float64]

_TRIES: Final = 200  # batches of places before a frame counts as one in which nothing hangs
_INSET: Final = 0.1  # of the frame's sides: how near to them no pose is
_TURN: Final = 0.1  # rad: of a rigid platform about each axis
_EXACT: Final = 1e-6  # m, rad: sigma of poses that are measured without noise
GUESS: Final = 0.05
"""How far starting guesses are from the poses, m."""


@dataclass(frozen=True)
class Beside:
    """Standard deviations of what is measured beside the encoders; None: it is not."""

    tension: float | None = None  # N
    swivel: float | None = None  # rad
    tilt: float | None = None  # rad
    pose: float | None = None  # m, and rad


@dataclass(frozen=True, eq=False)
class Simulated:
    """Measurements with what is true: poses (N, n), home lengths (m,)."""

    measured: Measured
    poses: Array
    home_lengths: Array


def simulate(
    robot: Robot,
    poses: int,
    noise: float,
    seed: int,
    *,
    guess: float = GUESS,
    cable: str = "rigid",
    beside: Beside | None = None,
) -> Simulated:
    """Measure *robot*, taken as true, with encoders of standard deviation *noise* (m) at random poses in its workspace.

    The first pose is home. Guesses are uniform within *guess* (m, and rad) of the poses. Lines are "rigid", "elastic"
    or "catenary".
    """
    if poses < 1:
        raise InputError(f"poses = {poses}: at least 1 is wanted")
    if not (0.0 <= noise < np.inf and 0.0 <= guess < np.inf):
        raise InputError(f"noise = {noise:g}, guess = {guess:g}: numbers of metres from 0 are wanted")
    rng = np.random.default_rng(seed)
    return measure(robot, random_poses(robot, poses, rng, cable), noise, rng, guess, cable, beside)


def measure(
    robot: Robot,
    poses: Array,
    noise: float,
    rng: np.random.Generator,
    guess: float = GUESS,
    cable: str = "rigid",
    beside: Beside | None = None,
) -> Simulated:
    """Measure *robot* at *poses* (N, n), the first of which is home. Tensions are the least that hold it there."""
    beside, model, count = beside or Beside(), Model(robot, Fidelity.of(cable)), len(poses)
    _check(robot, beside)
    problem, kept = _nothing_measured(model, poses, beside)
    told = problem.derivatives(problem.start, kept, np.ones(len(problem.values))).residual  # what sensors read
    if not np.isfinite(told).all():
        raise InputError(f"{robot.name}: pose {int(np.argmax(~np.isfinite(told).all(axis=1))) + 1} is in a sheave")
    lengths, told = told[:, : robot.m], told[:, robot.m :]
    counted = lengths - lengths[0] + rng.normal(0.0, noise, lengths.shape)
    guesses = poses + rng.uniform(-guess, guess, poses.shape)
    tensions = swivel = tilt = sigma = None
    if beside.tension is not None:
        held = solve_inverse(model, poses).checked().tensions if problem.measured.tensions is None else told
        tensions = held[:, : robot.m] + rng.normal(0.0, beside.tension, lengths.shape)
        told = told if problem.measured.tensions is None else told[:, robot.m :]
    if beside.swivel is not None:
        swivel = told[:, : robot.m] + rng.normal(0.0, beside.swivel, lengths.shape)
    if beside.tilt is not None:
        tilt = told[:, -2:] + rng.normal(0.0, beside.tilt, (count, 2))
    if beside.pose is not None:
        guesses = poses + rng.normal(0.0, beside.pose, poses.shape)
        sigma = np.full(poses.shape, max(beside.pose, _EXACT))
    return Simulated(Measured(counted, guesses, sigma, tensions, swivel, tilt), poses, lengths[0])


def _check(robot: Robot, beside: Beside) -> None:
    for name, value in vars(beside).items():
        if value is not None and not 0.0 <= value < np.inf:
            raise InputError(f"{name} noise = {value:g}: a number from 0 is wanted")
    if beside.tilt is not None and robot.n == 3:
        raise InputError(f"tilt noise = {beside.tilt:g}: {robot.name!r} is a point platform, which has no tilt")


def _nothing_measured(model: Model, poses: Array, beside: Beside) -> tuple[CalibrationProblem, Array]:
    """The equations with zeros for what sensors read, and what is kept of each pose where the robot really is."""
    robot, count = model.robot, len(poses)
    nothing = np.zeros((count, robot.m))
    swivel = None if beside.swivel is None else nothing
    tilt = None if beside.tilt is None else np.zeros((count, 2))
    if model.fidelity.cable is CableLaw.RIGID:
        return CalibrationProblem.of(robot, Measured(nothing, poses, None, None, swivel, tilt), hold=False), poses
    held = solve_inverse(model, _given(robot, poses)).checked()
    measured = Measured(nothing, poses, None, None if beside.tension is None else nothing, swivel, tilt)
    problem = Hanging.under(model, measured, CalibrationPlan(), hold=False)
    return problem, problem.kept(held)


def _given(robot: Robot, poses: Array) -> Array:
    """Poses with as many freedoms given as there are lines: gravity decides the others."""
    given = poses.copy()
    given[:, FREED[robot.m : robot.n]] = np.nan
    return given


def random_poses(robot: Robot, count: int, rng: np.random.Generator, cable: str = "rigid") -> Array:
    """Poses (count, n), uniform among those in the frame that lines hold within their tension limits."""
    model = Model(robot, Fidelity.of(cable))
    low, high = np.array(robot.scene.frame_min), np.array(robot.scene.frame_max)
    inset = _INSET * (high - low)
    found: list[Array] = []
    for _ in range(_TRIES):
        poses = np.zeros((2 * count, robot.n))
        poses[:, :3] = rng.uniform(low + inset, high - inset, (len(poses), 3))
        poses[:, 3:] = rng.uniform(-_TURN, _TURN, (len(poses), robot.n - 3))
        if robot.m >= robot.n or model.fidelity.cable is not CableLaw.RIGID:
            held = solve_inverse(model, _given(robot, poses))
            poses = held.pose[held.ok]
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
