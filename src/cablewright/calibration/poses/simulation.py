"""Simulated calibration measurements of a robot, and the alignment of results before their errors are measured."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar, Final

import numpy as np

from cablewright.calibration.measurement_rows.vibrations import free_spans
from cablewright.calibration.measurements import MAX_POSES, Measured
from cablewright.calibration.poses.elastic import ElasticProblem, problem_of
from cablewright.calibration.poses.fit import yaw_between
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.results import Figure, Result
from cablewright.models.fidelity import CableLaw
from cablewright.models.free_coordinates import as_held
from cablewright.models.line_vibration import string_frequency
from cablewright.models.plane import within
from cablewright.models.rotation import matrices, rotation_onto
from cablewright.models.statics import Equilibrium, Model
from cablewright.models.winch_lines import WinchLines
from cablewright.robot import Robot
from cablewright.solvers.arguments import as_rows
from cablewright.solvers.inverse import solve_inverse

_TRIES: Final = 200  # batches of random poses, max
_INSET: Final = 0.1  # of the frame's sides: min distance of a pose from them
_TURN: Final = 0.1  # rad: max rotation of a rigid platform about each axis
_EXACT: Final = 1e-6  # m, rad: sigma of poses measured without noise
GUESS: Final = 0.05
"""Default max error of the poses' start values, m and rad."""


@dataclass(frozen=True)
class SensorNoise:
    """Standard deviations of the sensors other than encoders; None: the robot does not have the sensor."""

    tension: float | None = None  # N
    swivel: float | None = None  # rad
    tilt: float | None = None  # rad
    pose: float | None = None  # m and rad
    yaw: float | None = None  # rad
    frequency: float | None = None  # Hz, of the free cables' lateral vibration


@dataclass(frozen=True, eq=False, repr=False)
class SimulatedCalibration(Result):
    """Simulated measurements with the true poses and home lengths."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok.", lambda _: "ok"),
        Figure("poses", "1", "Number of poses measured.", lambda made: len(made.poses)),
        Figure("noise", "m", "Standard deviation of the encoders.", shown="mm"),
        Figure("seed", "1", "Seed of poses, noise and guesses; null where the caller drew them."),
    )
    HEADLINES: ClassVar = ("poses", "noise", "seed")

    measured: Measured
    poses: Array  # (N, n) m and rad
    home_lengths: Array  # (m,) m
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
    """Simulate the measurement of a number of random *poses* of *robot*, by encoders of standard deviation *noise* (m).

    The first pose is home. Start values are uniform within *guess* (m and rad) of the poses. *sensors*: the noise of
    further sensors. Lines are rigid unless a *cable* law or a model says otherwise. Raises `InputError` for arguments
    out of range, and if hardly any pose in the frame is feasible.

    Examples
    --------
    >>> import cablewright as cw
    >>> cw.simulate_calibration(cw.load("wang2021"), 20, 1e-4, seed=1).measured.counted.shape
    (20, 4)
    """
    if not 1 <= poses <= MAX_POSES:
        raise InputError(f"poses = {poses}: must be from 1 to {MAX_POSES}")
    if not (0.0 <= noise < np.inf and 0.0 <= guess < np.inf):
        raise InputError(f"noise = {noise:g}, guess = {guess:g}: must be finite and at least 0 m")
    if seed < 0:
        raise InputError(f"seed = {seed}: must not be negative")
    model = Model.of(robot, cable=cable, default=CableLaw.RIGID)
    rng = np.random.default_rng(seed)
    return replace(measure(model, random_poses(model, poses, rng), noise, rng, guess, sensors=sensors), seed=seed)


def measure(
    robot: Robot | Model,
    poses: Array,
    noise: float,
    rng: np.random.Generator,
    guess: float = GUESS,
    cable: CableLaw | str | None = None,
    sensors: SensorNoise | None = None,
) -> SimulatedCalibration:
    """Simulate the measurements of *robot* at *poses* (N, n), the first of which is home, at min feasible tensions."""
    sensors, model = sensors or SensorNoise(), Model.of(robot, cable=cable, default=CableLaw.RIGID)
    robot, m = model.robot, model.m
    for name, value in vars(sensors).items():
        if value is not None and not 0.0 <= value < np.inf:
            raise InputError(f"{name} noise = {value:g}: must be finite and at least 0")
    for name in ("tilt", "yaw"):
        if getattr(sensors, name) is not None and robot.n == 3:
            raise InputError(f"{name} noise: {robot.name!r} is a point platform, which has no {name}")
    columns = {"swivel": m, "tilt": 2, "yaw": 1}
    angles: dict[str, Any] = {
        name: np.zeros((len(poses), count)) for name, count in columns.items() if getattr(sensors, name) is not None
    }
    blank = Measured(np.zeros((len(poses), m)), poses, **angles)
    problem, held = problem_of(model, blank, hold=False), None
    by_tension, tied = (sensors.tension, sensors.frequency) != (None, None), problem.elastic or bool(robot.sharing)
    if tied or problem.is_soft or by_tension:
        held = solve_inverse(model, as_held(robot, poses) if tied else poses).checked()
        poses = held.pose
        problem = replace(problem, rows=problem.rows._replace(tensions=held.tensions))
    states = problem.states_of(held) if isinstance(problem, ElasticProblem) and held is not None else poses
    readings = problem.derivatives(problem.start, states, np.ones(len(problem.values))).residual  # of zeros
    if not np.isfinite(readings).all():
        raise InputError(
            f"{robot.name}: pose {int(np.argmax(~np.isfinite(readings).all(axis=1))) + 1} has a "
            f"platform point inside a sheave; choose other poses"
        )
    lengths = readings[:, :m]
    counted = lengths - lengths[0] + rng.normal(0.0, noise, lengths.shape)
    winches = WinchLines.of(robot)
    counted = winches.sense * counted[:, np.maximum(winches.host, 0)]  # a counterweight counts nothing
    guesses = within(robot.platform.plane, poses + rng.uniform(-guess, guess, poses.shape))
    tensions = sigma = None
    if sensors.tension is not None and held is not None:
        tensions = held.tensions + rng.normal(0.0, sensors.tension, lengths.shape)
        tensions[:, robot.hung] = np.nan
    at = problem.lengths_per_pose
    for name in angles:
        true = readings[:, at : at + columns[name]]
        angles[name] = true + rng.normal(0.0, getattr(sensors, name), true.shape)
        at += columns[name]
    if sensors.frequency is not None and held is not None:
        angles["frequencies"] = _frequencies(held) + rng.normal(0.0, sensors.frequency, lengths.shape)
        angles["frequencies"][:, robot.hung] = np.nan
    if sensors.pose is not None:
        guesses = poses + rng.normal(0.0, sensors.pose, poses.shape)
        sigma = np.full(poses.shape, max(sensors.pose, _EXACT))
    measured = Measured(counted, guesses, sigma, tensions, **angles)
    return SimulatedCalibration(measured, poses, lengths[0], noise)


def _frequencies(held: Equilibrium) -> Array:
    """Return the first frequency (N, m) of each free cable, Hz. Raises `InputError` for one without weight."""
    robot = held.model.robot
    weightless = next((line.name for line in robot.lines if not line.cable.linear_density), None)
    if weightless is not None:
        raise InputError(f"frequency noise: line {weightless!r} has no cable.linear_density")
    densities = np.array([[line.cable.linear_density for line in robot.lines]])
    return string_frequency(held.tensions, free_spans(robot, held.pose), densities)


def random_poses(
    robot: Robot | Model, count: int, rng: np.random.Generator, cable: CableLaw | str | None = None
) -> Array:
    """Return poses (count, n), uniform among the feasible ones in the frame, within the lines' tension limits."""
    model = Model.of(robot, cable=cable, default=CableLaw.RIGID)
    robot = model.robot
    low, high = np.array(robot.scene.frame_min), np.array(robot.scene.frame_max)
    inset = _INSET * (high - low)
    hangs = robot.n == 6 and robot.platform.plane is None  # gravity gives the coordinates that lines leave free
    found: list[Array] = []
    for _ in range(_TRIES):
        poses = np.zeros((2 * count, robot.n))
        poses[:, :3] = rng.uniform(low + inset, high - inset, (len(poses), 3))
        poses[:, 3:] = rng.uniform(-_TURN, _TURN, (len(poses), robot.n - 3))
        poses = _in_plane(robot, poses, inset)
        if robot.m >= robot.freedoms or hangs or model.fidelity.cable is not CableLaw.RIGID:
            held = solve_inverse(model, as_held(robot, poses))
            poses = held.pose[held.ok]
        found += list(poses)
        if len(found) >= count:
            return np.array(found[:count])
    raise InputError(f"{robot.name}: hardly any pose in its frame is feasible within the tension limits")


def _in_plane(robot: Robot, poses: Array, inset: Array) -> Array:
    """Return *poses* (N, n) moved into the platform's plane, if any: of a tilted one those that stay in the frame."""
    plane = robot.platform.plane
    if plane is None:
        return poses
    poses = within(plane, poses)
    if plane.axis is not None:
        return poses
    low, high = np.array(robot.scene.frame_min) + inset, np.array(robot.scene.frame_max) - inset
    return np.asarray(poses[((poses[:, :3] >= low) & (poses[:, :3] <= high)).all(axis=1)])


def aligned(points: Array, truth: Array, others: Array | None = None, tilt: bool = False) -> tuple[Array, Array]:
    """Return *points* (m, 3) moved onto *truth* (m, 3) by the best translation and yaw, and *others* (N, 3) with them.

    *tilt*: use any rotation instead of a yaw. Encoders do not measure these degrees of freedom: errors without this
    alignment show how well a start was chosen, not how good the calibration is. Raises `InputError` for other shapes.
    """
    points, truth = as_rows(points, 3, "points", "m")[0], as_rows(truth, 3, "truth", "m")[0]
    if points.shape != truth.shape:
        raise InputError(f"aligned: {len(points)} points and {len(truth)} true ones: the two numbers must be equal")
    others = np.zeros((0, 3)) if others is None else others
    centre, middle = points.mean(axis=0), truth.mean(axis=0)
    if tilt:
        turn = rotation_onto(points, truth)
    else:
        turn = matrices([0.0, 0.0, yaw_between(points - centre, truth - middle)])
    return (points - centre) @ turn.T + middle, (others - centre) @ turn.T + middle
