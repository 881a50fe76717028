"""Made-up measurements of a robot, and honest errors of what a calibration makes of them: in one run, in one frame."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Final

import numpy as np

from cablewright.arrays import Array
from cablewright.calibration.data import MAX_POSES
from cablewright.calibration.elastic_lines import FREED, Hanging
from cablewright.calibration.plan import CalibrationPlan
from cablewright.calibration.problem import CalibrationProblem, Measured
from cablewright.errors import InputError
from cablewright.models.fidelity import CableLaw
from cablewright.models.statics import Model
from cablewright.results import Figure, Result
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse

_TRIES: Final = 200  # batches of places before a frame counts as one in which nothing hangs
_INSET: Final = 0.1  # of the frame's sides: how near to them no pose is
_TURN: Final = 0.1  # rad: of a rigid platform about each axis
_EXACT: Final = 1e-6  # m, rad: sigma of poses that are measured without noise
GUESS: Final = 0.05
"""How far starting guesses are from the poses, m."""


@dataclass(frozen=True)
class SensorNoise:
    """Standard deviations of what is measured beside the encoders; None: it is not."""

    tension: float | None = None  # N
    swivel: float | None = None  # rad
    tilt: float | None = None  # rad
    pose: float | None = None  # m, and rad


@dataclass(frozen=True, eq=False, repr=False)
class SimulatedCalibration(Result):
    """Measurements with what is true: poses (N, n), m and rad, and home lengths (m,), m."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok.", lambda _: "ok"),
        Figure("poses", "1", "Number of poses measured.", lambda made: len(made.poses)),
        Figure("noise", "m", "Standard deviation of the encoders.", shown="mm"),
        Figure("seed", "1", "Seed of poses, noise and guesses; null where the caller drew them."),
    )
    HEADLINES: ClassVar = ("poses", "noise", "seed")

    measured: Measured
    poses: Array
    home_lengths: Array
    noise: float  # m
    seed: int | None = None


def simulate_calibration(
    robot: Robot | Model,
    poses: int,
    noise: float,
    *,
    seed: int = 0,
    guess: float = GUESS,
    cable: CableLaw | str | None = None,
    sensors: SensorNoise | None = None,
) -> SimulatedCalibration:
    """Measure *robot*, taken as true, with encoders of standard deviation *noise* (m) at random *poses* it can hold.

    The first pose is home. Guesses are uniform within *guess* (m, and rad) of the poses. *sensors*: what else is
    measured, and how exactly. Lines are rigid unless a *cable* law or a model says otherwise. Raises `InputError` for
    numbers that are none, and where hardly any place of the frame can be held.

    Examples
    --------
    >>> import cablewright as cw
    >>> cw.simulate_calibration(cw.load("wang2021"), 20, 1e-4, seed=1).measured.counted.shape
    (20, 4)
    """
    if not 1 <= poses <= MAX_POSES:
        raise InputError(f"poses = {poses}: from 1 to {MAX_POSES} are wanted")
    if not (0.0 <= noise < np.inf and 0.0 <= guess < np.inf):
        raise InputError(f"noise = {noise:g}, guess = {guess:g}: numbers of metres from 0 are wanted")
    if seed < 0:
        raise InputError(f"seed = {seed}: must not be negative")
    model = Model.of(robot, cable=cable, default=CableLaw.RIGID)
    rng = np.random.default_rng(seed)
    made = measure(model, random_poses(model, poses, rng), noise, rng, guess, sensors=sensors)
    return replace(made, seed=seed)


def measure(
    robot: Robot | Model,
    poses: Array,
    noise: float,
    rng: np.random.Generator,
    guess: float = GUESS,
    cable: CableLaw | str | None = None,
    sensors: SensorNoise | None = None,
) -> SimulatedCalibration:
    """Measure *robot* at *poses* (N, n), the first of which is home. Tensions are the least that hold it there."""
    sensors, model, count = sensors or SensorNoise(), Model.of(robot, cable=cable, default=CableLaw.RIGID), len(poses)
    robot = model.robot
    _check(robot, sensors)
    problem, kept = _nothing_measured(model, poses, sensors)
    told = problem.derivatives(problem.start, kept, np.ones(len(problem.values))).residual  # what sensors read
    if not np.isfinite(told).all():
        raise InputError(f"{robot.name}: pose {int(np.argmax(~np.isfinite(told).all(axis=1))) + 1} is in a sheave")
    lengths, told = told[:, : robot.m], told[:, robot.m :]
    counted = lengths - lengths[0] + rng.normal(0.0, noise, lengths.shape)
    guesses = poses + rng.uniform(-guess, guess, poses.shape)
    tensions = swivel = tilt = sigma = None
    if sensors.tension is not None:
        held = solve_inverse(model, poses).checked().tensions if problem.measured.tensions is None else told
        tensions = held[:, : robot.m] + rng.normal(0.0, sensors.tension, lengths.shape)
        told = told if problem.measured.tensions is None else told[:, robot.m :]
    if sensors.swivel is not None:
        swivel = told[:, : robot.m] + rng.normal(0.0, sensors.swivel, lengths.shape)
    if sensors.tilt is not None:
        tilt = told[:, -2:] + rng.normal(0.0, sensors.tilt, (count, 2))
    if sensors.pose is not None:
        guesses = poses + rng.normal(0.0, sensors.pose, poses.shape)
        sigma = np.full(poses.shape, max(sensors.pose, _EXACT))
    return SimulatedCalibration(Measured(counted, guesses, sigma, tensions, swivel, tilt), poses, lengths[0], noise)


def _check(robot: Robot, sensors: SensorNoise) -> None:
    for name, value in vars(sensors).items():
        if value is not None and not 0.0 <= value < np.inf:
            raise InputError(f"{name} noise = {value:g}: a number from 0 is wanted")
    if sensors.tilt is not None and robot.n == 3:
        raise InputError(f"tilt noise = {sensors.tilt:g}: {robot.name!r} is a point platform, which has no tilt")


def _nothing_measured(model: Model, poses: Array, sensors: SensorNoise) -> tuple[CalibrationProblem, Array]:
    """The equations with zeros for what sensors read, and what is kept of each pose where the robot really is."""
    robot, count = model.robot, len(poses)
    nothing = np.zeros((count, robot.m))
    swivel = None if sensors.swivel is None else nothing
    tilt = None if sensors.tilt is None else np.zeros((count, 2))
    if model.fidelity.cable is CableLaw.RIGID:
        return CalibrationProblem.of(robot, Measured(nothing, poses, None, None, swivel, tilt), hold=False), poses
    held = solve_inverse(model, _given(robot, poses)).checked()
    measured = Measured(nothing, poses, None, None if sensors.tension is None else nothing, swivel, tilt)
    problem = Hanging.under(model, measured, CalibrationPlan(), hold=False)
    return problem, problem.kept(held)


def _given(robot: Robot, poses: Array) -> Array:
    """Poses with as many freedoms given as there are lines: gravity decides the others."""
    given = poses.copy()
    given[:, FREED[robot.m : robot.n]] = np.nan
    return given


def random_poses(
    robot: Robot | Model, count: int, rng: np.random.Generator, cable: CableLaw | str | None = None
) -> Array:
    """Poses (count, n), uniform among those in the frame that lines hold within their tension limits."""
    model = Model.of(robot, cable=cable, default=CableLaw.RIGID)
    robot = model.robot
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
