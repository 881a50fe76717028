"""Rows of a calibration: derivatives against differences, lengths against statics, steps against dense algebra."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from numba.core.types import unliteral
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan, MeasuredDistance, Point, Prior, Sigmas, TouchedPlane
from cablewright.calibration.poses.fit import fit
from cablewright.calibration.poses.problem import CalibrationProblem, StraightProblem
from cablewright.calibration.poses.simulation import random_poses, simulate_calibration
from cablewright.kernels.fitting import calibration_residuals, pose_schur
from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import Robot, load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.linearise import linearise

ALL = (
    *("exit_point", "length_offset", "sheave_radius", "length_scale", "build_up"),
    *("exit_compliance", "tension_offset", "tension_scale", "swivel_offset"),
)


def full(robot: Robot, rng: np.random.Generator, count: int = 4) -> CalibrationProblem:
    """A problem with rows of every sensor that the robot can have, none of which fits."""
    poses = random_poses(robot, count, rng)
    names = [line.name for line in robot.lines]
    body = robot.n == 6
    unknowns = (*(name for name in ALL if name != "sheave_radius" or robot.lines[0].sheave.kind != "eyelet"),)
    if body:
        unknowns = (*unknowns, "platform_point", "tilt_offset", "yaw_offset")
    plan = CalibrationPlan(
        unknowns=unknowns,
        level=1e-3,
        distances=(MeasuredDistance(between=(names[0], names[1]), value=4.0),),
        points=(Point(line=names[0], at=(0.1, 0.2, 0.3)),),
        planes=(TouchedPlane(poses=(2, 3), point=(0.0, 0.0, 0.5), normal=(0.1, 0.2, 1.0)),),
        priors=(Prior(name="length_scale", deviation=1e-3),),
    )
    measured = Measured(
        rng.uniform(-1.0, 1.0, (count, robot.m)),
        poses,
        np.full(poses.shape, 1e-2),
        rng.uniform(50.0, 200.0, (count, robot.m)),
        rng.uniform(-3.0, 3.0, (count, robot.m)),
        rng.uniform(-0.1, 0.1, (count, 2)) if body else None,
        rng.uniform(-0.1, 0.1, (count, 1)) if body else None,
    )
    return StraightProblem.of(robot, measured, plan)


@pytest.mark.parametrize("name", ["wang2021", "cogiro", "jung2020"])
def test_derivatives_are_those_of_differences(name: str) -> None:
    rng = np.random.default_rng(3)
    problem = full(load(name), rng)
    theta = problem.free + 0.02 * rng.standard_normal(len(problem.free))
    assert problem.measured.guess is not None
    poses = problem.measured.guess.copy()
    found = problem.derivatives(theta, poses)
    step = 1e-6
    for k in range(len(theta)):
        move = step * np.eye(len(theta))[k]
        ahead, behind = problem.derivatives(theta + move, poses), problem.derivatives(theta - move, poses)
        scale = 1e-9 / step * max(1.0, float(np.abs(found.by_unknown).max()))
        assert (ahead.residual - behind.residual) / (2 * step) == pytest.approx(found.by_unknown[:, :, k], abs=scale)
        other = (ahead.others - behind.others) / (2 * step)
        assert other == pytest.approx(found.others_by_unknown[:, k], abs=scale)
    for c in range(3):
        move = step * np.eye(poses.shape[1])[c]
        ahead, behind = problem.derivatives(theta, poses + move), problem.derivatives(theta, poses - move)
        scale = 1e-9 / step * max(1.0, float(np.abs(found.by_pose).max()))
        assert (ahead.residual - behind.residual) / (2 * step) == pytest.approx(found.by_pose[:, :, c], abs=scale)


def test_a_turn_of_a_body_is_a_turn_in_space() -> None:
    """The columns of rotation against small turns that are made with another library's rotations."""
    from scipy.spatial.transform import Rotation

    rng = np.random.default_rng(4)
    problem = full(load("cogiro"), rng)
    assert problem.measured.guess is not None
    poses, theta, step = problem.measured.guess, problem.free, 1e-6
    found = problem.derivatives(theta, poses)

    def turned(by: np.ndarray) -> np.ndarray:
        turn = Rotation.from_rotvec(by) * Rotation.from_rotvec(poses[:, 3:])
        return problem.derivatives(theta, np.column_stack([poses[:, :3], turn.as_rotvec()])).residual

    for c in range(3):
        move = step * np.eye(3)[c]
        slope = (turned(move) - turned(-move)) / (2 * step)
        scale = 1e-9 / step * float(np.abs(found.by_pose).max())
        assert slope == pytest.approx(found.by_pose[:, :, 3 + c], abs=scale)


@pytest.mark.parametrize("name", ["wang2021", "merlet2023", "cogiro", "jung2020"])
def test_lengths_are_those_of_rigid_statics(name: str) -> None:
    """Up to the dead span, which is constant."""
    robot = load(name)
    poses = random_poses(robot, 20, np.random.default_rng(1))
    problem = StraightProblem.of(robot, Measured(np.zeros((20, robot.m))))
    ours = problem.lengths(problem.start, poses)
    theirs = solve_inverse(Model(robot, Fidelity.of("rigid")), poses).checked().lengths
    assert np.ptp(theirs - ours, axis=0) == pytest.approx(np.zeros(robot.m), abs=1e-12)


def test_the_one_linearisation_says_the_same_of_stiff_cables() -> None:
    """Three lines hold a point: what moves it per exit point, radius and length follows from the rigid rows too."""
    robot = load("wang2021")
    three = robot.model_copy(
        update={
            "lines": tuple(
                line.model_copy(
                    update={
                        "cable": line.cable.model_copy(update={"young_modulus": 1e14}),
                        "exit_point": (*line.exit_point[:2], 3.0),
                    }
                )
                for line in robot.lines[:3]
            )
        }
    )
    place = np.array([0.3, -0.4, 1.0])
    model = Model(three, Fidelity.of("elastic"))
    held = solve_inverse(model, place).lengths
    found = linearise(solve_forward(model, held, guess=place).checked())
    plan = CalibrationPlan(unknowns=("exit_point", "length_offset", "sheave_radius"))
    problem = StraightProblem.of(three, Measured(np.zeros((1, 3))), plan)
    rows = problem.derivatives(problem.free, place[None])
    motion = -np.linalg.solve(rows.by_pose[0], rows.by_unknown[0])
    for k, unknown in enumerate(problem.unknowns):
        i = [line.name for line in three.lines].index(unknown.line or "")
        if unknown.axis is not None:
            theirs = found.per_exit_point[:, i, unknown.axis]
        else:
            theirs = (found.per_length if unknown.name == "length_offset" else found.per_sheave_radius)[:, i]
        assert motion[:, k] == pytest.approx(theirs, abs=1e-6)


def test_a_fit_is_that_of_dense_least_squares() -> None:
    """All sensors together, with noise: SciPy with the same Jacobian ends at the same cost and place."""
    rng = np.random.default_rng(6)
    robot = load("wang2021")
    problem = full(robot, rng, 12)
    assert problem.measured.guess is not None
    lengths = problem.lengths(problem.free, problem.measured.guess)
    away = problem.measured.guess[:, None, :2] - np.array([line.exit_point[:2] for line in robot.lines])
    measured = Measured(
        lengths - lengths[0] + rng.normal(0.0, 1e-4, lengths.shape),
        problem.measured.guess,
        problem.measured.pose_sigma,
        None,
        np.arctan2(away[..., 1], away[..., 0]),
    )
    plan = CalibrationPlan(unknowns=("exit_point", "length_offset", "length_scale"), level=1e-2)
    problem = StraightProblem.of(robot, measured, plan)
    offsets = lengths[0]
    start = problem.free.copy()
    start[12:16] = offsets
    found = fit(problem, start, measured.guess)
    k = len(start)

    def residual(x: np.ndarray) -> np.ndarray:
        rows = problem.derivatives(x[:k], x[k:].reshape(-1, 3))
        return np.append(rows.residual.ravel(), rows.others)

    def jacobian(x: np.ndarray) -> np.ndarray:
        rows = problem.derivatives(x[:k], x[k:].reshape(-1, 3))
        n, e = rows.residual.shape
        out = np.zeros((n * e + len(rows.others), len(x)))
        out[: n * e, :k] = rows.by_unknown.reshape(n * e, k)
        out[n * e :, :k] = rows.others_by_unknown
        for j in range(n):
            out[j * e : (j + 1) * e, k + 3 * j : k + 3 * j + 3] = rows.by_pose[j]
        return out

    dense = least_squares(residual, np.append(start, measured.guess.ravel()), jacobian, method="lm", xtol=1e-15)
    assert found.code == 0
    assert found.cost == pytest.approx(dense.cost, rel=1e-9)
    assert found.theta == pytest.approx(dense.x[:k], abs=1e-7)


def test_a_spool_builds_up() -> None:
    """Counts of a drum the square of whose radius falls with the length paid out, integrated, against the closed form.

    The scale is of the radius at home: what is paid out is in true metres.
    """
    rng = np.random.default_rng(2)
    robot = load("wang2021")
    plan = CalibrationPlan(unknowns=("length_offset", "length_scale", "build_up"))
    poses = np.array([[0.0, 0.0, 1.0]])
    counted = rng.uniform(-1.0, 1.0, (1, 4))
    problem = StraightProblem.of(robot, Measured(counted), plan)
    theta = np.array([2.0, 2.1, 2.2, 2.3, 1.01, 1.02, 0.99, 1.0, 0.05, 0.03, 1e-7, 0.0])
    rest = problem.derivatives(theta, poses).residual[0] * problem.encoder_sigma
    lengths = problem.lengths(theta, poses)[0]
    for i in range(4):
        radius = partial(lambda scale, rate, _, out: scale * np.sqrt(1.0 - 2.0 * rate * out), *theta[[4 + i, 8 + i]])
        paid_out = float(solve_ivp(radius, (0.0, counted[0, i]), [0.0], rtol=1e-12, atol=1e-13).y[0, -1])
        assert lengths[i] - theta[i] - paid_out == pytest.approx(rest[i], abs=1e-10)
    read = problem.counts_at(theta, poses)
    again = StraightProblem.of(robot, Measured(read), plan).derivatives(theta, poses)
    assert again.residual * problem.encoder_sigma == pytest.approx(np.zeros((1, 4)), abs=1e-12)


def test_kernels_have_one_compiled_signature() -> None:
    for robot in (load("wang2021"), load("cogiro")):
        made = simulate_calibration(robot, 20, 1e-4, seed=1, guess=0.01)
        calibrate(robot, made.measured, rough=0.0, outliers=False)
        calibrate(robot, made.measured, CalibrationPlan(datum=(robot.lines[0].name,)), rough=0.0)
    for module in (calibration_residuals, pose_schur):
        for each in vars(module).values():
            if hasattr(each, "signatures"):
                plain = {tuple(map(unliteral, one)) for one in each.signatures if "none" in str(one)}
                all_of = {tuple(map(unliteral, signature)) for signature in each.signatures}
                assert len(plain) <= 1, each.__name__
                assert len(all_of - plain) <= 1, each.__name__  # of robots with guided lines, or not of rows


@pytest.mark.parametrize("name", ["wang2021", "cogiro", "jung2020"])
def test_tensions_that_hold_a_platform_leave_no_force_and_no_moment(name: str) -> None:
    """Tensions of rigid statics, of a body under a moment and with its mass aside too."""
    robot = load(name)
    if robot.n == 6:
        platform = robot.platform.model_copy(update={"moment": (1.0, -2.0, 0.5), "centre_of_mass": (0.02, -0.03, 0.05)})
        robot = robot.model_copy(update={"platform": platform})
    held = solve_inverse(Model(robot, Fidelity.of("rigid")), random_poses(robot, 6, np.random.default_rng(2)))
    measured = Measured(np.zeros(held.lengths.shape), held.pose, tensions=held.tensions)
    problem = StraightProblem.of(robot, measured, CalibrationPlan(sigma=Sigmas(tension=1.0)))
    left = problem.derivatives(problem.start, held.pose).residual[:, robot.m :]
    assert left.shape[1] == robot.n
    assert left == pytest.approx(np.zeros_like(left), abs=1e-8 * held.tensions.max())
    spoiled = StraightProblem.of(
        robot, replace(measured, tensions=held.tensions * 1.01), CalibrationPlan(sigma=Sigmas(tension=1.0))
    )
    mended = spoiled.balanced(spoiled.start, held.pose).derivatives(spoiled.start, held.pose).residual[:, robot.m :]
    assert mended == pytest.approx(np.zeros_like(mended), abs=1e-8 * held.tensions.max())
