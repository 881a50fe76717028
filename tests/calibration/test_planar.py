"""Platforms in a plane: exact without noise, sigmas that hold, an oracle of its own, poses in the plane, rejections."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from scipy import optimize, stats

import planar_robots
from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.drift.drift import check_drift
from cablewright.calibration.drift.record import record_of
from cablewright.calibration.guidance.guided_calibration import guide
from cablewright.calibration.guidance.pose_selection import calibration_poses
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan, Point, Sigmas
from cablewright.calibration.poses.elastic import ElasticProblem
from cablewright.calibration.poses.fit import fit, on_file_side, to_file_frame
from cablewright.calibration.poses.observability import information
from cablewright.calibration.poses.problem import StraightProblem
from cablewright.calibration.poses.simulation import (
    SensorNoise,
    SimulatedCalibration,
    measure,
    random_poses,
    simulate_calibration,
)
from cablewright.calibration.unknowns import unknowns_of, with_values
from cablewright.foundation.errors import InputError
from cablewright.models.statics import Model
from cablewright.robot import Robot, load
from cablewright.solvers.inverse import solve_inverse
from cases import often

OFF = 0.35  # m: distance of the nearest exit point from the plane
NOISE = 5e-5  # m
KINDS = [("vertical", False), ("tilted", False), ("horizontal", False), ("vertical", True), ("tilted", True)]


def robot_of(plane: str, body: bool, off: float = OFF) -> Robot:
    return planar_robots.board(plane, body, lines=6 if body else 4, off=off)


def exits_of(robot: Robot) -> np.ndarray:
    return np.array([line.exit_point for line in robot.lines])


def wrong(robot: Robot, seed: int, off: float = 0.02) -> Robot:
    """The robot's file with exit points up to *off*, m, wrong in each coordinate."""
    exits = exits_of(robot)
    moved = exits + np.random.default_rng(seed).uniform(-off, off, exits.shape)
    return with_values(robot, unknowns_of(robot, ("exit_point",)), moved.ravel())


def off_plane(robot: Robot, poses: np.ndarray) -> float:
    """Largest distance, m, of poses from the robot's plane, and rotation out of it, rad."""
    plane = robot.platform.plane
    normal = np.array(plane.normal) / np.linalg.norm(plane.normal)
    across = np.abs(poses[:, :3] @ normal - plane.distance).max()
    return float(max(across, np.abs(np.cross(poses[:, 3:], normal)).max() if robot.n == 6 else 0.0))


def errors(found: Calibration, made: SimulatedCalibration, truth: Robot) -> np.ndarray:
    """Of exit points and positions, m, after the best motion in the plane (Kabsch), and of home lengths."""
    a, b, n = planar_robots.frame(truth)
    axes = np.column_stack([a, b, n])
    m, true = truth.m, exits_of(truth) @ axes
    points = found.problem.points(found.fit.theta) @ axes
    centre, middle = points[:, :2].mean(axis=0), true[:, :2].mean(axis=0)
    left, _, right = np.linalg.svd((points[:, :2] - centre).T @ (true[:, :2] - middle))
    turn = right.T @ np.diag([1.0, np.linalg.det(right.T @ left.T)]) @ left.T

    def moved(where: np.ndarray) -> np.ndarray:
        return np.column_stack([(where[:, :2] - centre) @ turn.T + middle, where[:, 2]])

    home = found.values[[each.name == "length_offset" for each in found.unknowns]]
    assert len(home) == m
    parts = moved(points) - true, moved(found.poses[:, :3] @ axes) - made.poses[:, :3] @ axes, home - made.home_lengths
    return np.concatenate([part.ravel() for part in parts])


@pytest.mark.parametrize(("plane", "body"), KINDS)
def test_without_noise_it_is_exact(plane: str, body: bool) -> None:
    """From a file that is wrong by up to 20 mm in all directions; three degrees of freedom stay open, those of the
    plane."""
    truth = robot_of(plane, body)
    for seed in range(3):
        made = simulate_calibration(truth, 40, 0.0, seed=seed)
        found = calibrate(wrong(truth, seed), made.measured, rough=0.1)
        assert found.status == "ok"
        assert np.abs(errors(found, made, truth)).max() < 1e-9
        assert off_plane(truth, found.poses) < 1e-12
        unknowns, own = 4 * truth.m, 3 if body else 2
        assert (found.alone.total, found.alone.rank) == (unknowns + own * 40, unknowns - 3 + own * 40)
        assert len(found.gauge) == 3


@pytest.mark.parametrize(("plane", "body"), [("vertical", False), pytest.param("tilted", True, marks=pytest.mark.slow)])
def test_sigmas_and_the_redundancy_hold(plane: str, body: bool) -> None:
    """Of many runs: what no motion in the plane changes, home lengths and distances from the plane; and chi-squared."""
    truth, runs, count = robot_of(plane, body), often(25, 60), 40
    normal, m = planar_robots.frame(truth)[2], truth.m
    rows = np.zeros((2 * m, 4 * m))
    for i in range(m):
        rows[i, 3 * i : 3 * i + 3] = normal
        rows[m + i, 3 * m + i] = 1.0
    off, square, redundancy = [], 0.0, 0
    for seed in range(runs):
        made = simulate_calibration(truth, count, NOISE, seed=1000 + seed)
        plan = CalibrationPlan(sigma=Sigmas(encoder=NOISE))
        found = calibrate(wrong(truth, seed), made.measured, plan, rough=0.1, outliers=False)
        assert found.status == "ok"
        true = np.append((exits_of(truth) @ normal), made.home_lengths)
        sigma = np.sqrt(np.einsum("ak,kl,al->a", rows, found.posterior.covariance, rows))
        off.append((rows @ found.values - true) / sigma)
        grown = found.problem.factors.get("lengths", 1.0)  # where chance denies the given sigma
        square, redundancy = square + 2.0 * found.fit.cost * grown**2, found.posterior.redundancy
    assert redundancy == count * (m - (3 if body else 2)) - (4 * m - 3)
    assert abs(square / (runs * redundancy) - 1.0) < 4.0 * np.sqrt(2.0 / (runs * redundancy))
    inside = (np.abs(np.array(off)) < stats.norm.ppf(0.975)).sum(axis=0)
    low, high = stats.binom.interval(1.0 - 1e-4, runs, 0.95)
    assert low <= inside.min()
    assert inside.max() <= high
    low, high = stats.binom.interval(1.0 - 1e-3, runs, 0.95)  # of one number: those of a run are correlated
    assert low <= inside.mean() <= high


def rotation(normal: np.ndarray, angle: complex) -> np.ndarray:
    cross = np.array([[0, -normal[2], normal[1]], [normal[2], 0, -normal[0]], [-normal[1], normal[0], 0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross)


@pytest.mark.parametrize(("plane", "body"), [("vertical", False), ("tilted", False), ("vertical", True)])
def test_an_oracle_of_its_own_finds_the_same(plane: str, body: bool) -> None:
    """Two coordinates and an angle, all three coordinates of measured positions with sigmas of their own, surveys."""
    truth, count, p = robot_of(plane, body), 20, 3 if body else 2
    a, b, n = planar_robots.frame(truth)
    m, rng = truth.m, np.random.default_rng(4)
    made = simulate_calibration(truth, count, NOISE, seed=5)
    sigmas = np.array([1e-3, 4e-4, 2e-3, 1e-2, 1e-2, 1e-2])[: truth.n] * np.ones((count, truth.n))
    read = made.poses + rng.normal(size=sigmas.shape) * sigmas
    survey = exits_of(truth)[:3] + rng.normal(0.0, 1e-3, (3, 3))
    points = tuple(Point(line=f"line {i}", at=tuple(survey[i])) for i in range(3))
    plan = CalibrationPlan(sigma=Sigmas(encoder=NOISE), points=points)
    measured = Measured(made.measured.counted, read, sigmas)
    problem = StraightProblem.of(wrong(truth, 1, 0.005), measured, plan)
    start = problem.free.copy()
    start[3 * m :] = made.home_lengths
    found = fit(problem, start, made.poses)
    assert found.code == 0

    def residuals(x: np.ndarray) -> np.ndarray:
        exits, home, own = x[: 3 * m].reshape(m, 3), x[3 * m : 4 * m], x[4 * m :].reshape(count, p)
        rows = [((exits[:3] - survey) / 1e-3).ravel()]
        for at in range(count):
            place = planar_robots.DISTANCE * n + own[at, 0] * a + own[at, 1] * b
            turn = rotation(n, own[at, 2]) if body else np.eye(3)
            ties = np.array([turn @ line.platform_point for line in truth.lines])
            lengths = np.sqrt(((place + ties - exits) ** 2).sum(axis=1))
            rows += [(lengths - home - measured.counted[at]) / NOISE, (place - read[at, :3]) / sigmas[at, :3]]
            if body:
                rows.append((own[at, 2:] - read[at, 3:] @ n) / sigmas[at, 3])
        return np.concatenate(rows)

    def slopes(x: np.ndarray) -> np.ndarray:
        return np.array([residuals(x + 1e-30j * row).imag / 1e-30 for row in np.eye(len(x))]).T

    begin = np.column_stack([made.poses[:, :3] @ a, made.poses[:, :3] @ b, *([made.poses[:, 3:] @ n] if body else [])])
    x0 = np.concatenate([start, begin.ravel()])
    own = optimize.least_squares(residuals, x0, jac=slopes, method="lm", xtol=1e-15, ftol=1e-15, gtol=1e-15)
    assert np.abs(own.x[: 4 * m] - found.theta).max() < 1e-7
    place = own.x[4 * m :].reshape(count, p)
    assert np.abs(planar_robots.DISTANCE * n + place[:, :1] * a + place[:, 1:2] * b - found.poses[:, :3]).max() < 1e-7
    wanted = np.linalg.inv(slopes(own.x).T @ slopes(own.x))[: 4 * m, : 4 * m]
    told = information(problem, found.theta, found.poses, found.weights, priors=True).covariance
    size = np.sqrt(np.outer(np.diag(wanted), np.diag(wanted)))
    assert np.abs((told - wanted) / size).max() < 1e-4
    assert off_plane(truth, found.poses) < 1e-12


@pytest.mark.parametrize(
    ("plane", "body", "left"),
    [("vertical", False, 2), ("tilted", False, 2), ("vertical", True, 2), ("horizontal", False, 3)],
)
def test_load_cells_of_straight_lines_count_the_balance_in_the_plane(plane: str, body: bool, left: int) -> None:
    """In a plane that does not lie gravity determines the rotation of the frame, and nothing of the forces across."""
    truth = robot_of(plane, body)
    made = simulate_calibration(truth, 40, 0.0, seed=2, sensors=SensorNoise(tension=0.0), guess=0.0)
    found = calibrate(wrong(truth, 2), made.measured, CalibrationPlan(sigma=Sigmas(tension=0.1)), rough=0.1)
    assert found.status == "ok"
    assert np.abs(errors(found, made, truth)).max() < 1e-8
    assert len(found.gauge) == left
    p = 3 if body else 2
    assert found.alone.measurements == 40 * (truth.m + p)
    assert found.problem.per_pose == truth.m + p


@pytest.mark.parametrize(("plane", "body", "cable"), [("vertical", False, "catenary"), ("tilted", True, "elastic")])
def test_lines_that_stretch_balance_in_the_plane(plane: str, body: bool, cable: str) -> None:
    truth = robot_of(plane, body)
    made = simulate_calibration(truth, 16, 0.0, seed=3, cable=cable, sensors=SensorNoise(tension=0.0))
    found = calibrate(wrong(truth, 3, 0.01), made.measured, CalibrationPlan(sigma=Sigmas(tension=0.5)), cable=cable)
    assert found.status == "ok"
    assert np.abs(errors(found, made, truth)).max() < 1e-7
    assert off_plane(truth, found.poses) < 1e-9
    m = truth.m
    assert (found.alone.total, found.alone.rank) == (4 * m + 16 * m, 4 * m + 16 * m - 2)


@pytest.mark.parametrize(("plane", "body"), [("vertical", False), ("tilted", True), ("horizontal", True)])
def test_derivatives_of_lines_that_sag_are_those_of_differences(plane: str, body: bool) -> None:
    truth = robot_of(plane, body)
    made = simulate_calibration(truth, 5, 0.0, seed=2, cable="catenary", sensors=SensorNoise(tension=0.0))
    names = ("exit_point", "length_offset", "modulus", *(("platform_point",) if body else ()))
    model = Model.of(truth, cable="catenary")
    problem = ElasticProblem.of(model, made.measured, CalibrationPlan(unknowns=names), hold=False)
    theta, states = problem.free, problem.states_of(solve_inverse(model, made.poses).checked())
    told = problem.derivatives(theta, states)

    def difference(by: np.ndarray, of: np.ndarray) -> np.ndarray:
        sides = [problem.derivatives(theta + sign * by, states + sign * of).residual for sign in (1.0, -1.0)]
        return (sides[0] - sides[1]) / 2e-6

    for at, row in enumerate(1e-6 * np.eye(len(theta))):
        slope = told.by_unknown[..., at]
        assert np.abs(difference(row, 0.0) - slope).max() < 1e-4 * np.abs(slope).max()
    for at, row in enumerate(1e-6 * np.eye(states.shape[1])[: truth.m]):
        slope = told.by_pose[..., at]
        assert np.abs(difference(np.zeros_like(theta), row) - slope).max() < 1e-4 * np.abs(slope).max()


def test_sigmas_of_lines_that_stretch_hold() -> None:
    truth, square, runs = robot_of("vertical", False), 0.0, often(6, 12)
    plan = CalibrationPlan(sigma=Sigmas(encoder=NOISE, tension=0.5))
    for seed in range(runs):
        sensors = SensorNoise(tension=0.5)
        made = simulate_calibration(truth, 16, NOISE, seed=40 + seed, cable="elastic", sensors=sensors)
        found = calibrate(wrong(truth, seed, 0.005), made.measured, plan, cable="elastic", outliers=False)
        assert found.status == "ok"
        redundancy = found.posterior.redundancy
        square += 2.0 * found.fit.cost / runs
    assert redundancy == 16 * 4 - (16 - 2)
    assert abs(square / redundancy - 1.0) < 4.0 * np.sqrt(2.0 / (runs * redundancy))


@pytest.mark.parametrize(("plane", "body"), [("vertical", False), ("tilted", True)])
def test_poses_and_the_guide_stay_in_the_plane(plane: str, body: bool) -> None:
    truth = robot_of(plane, body)
    chosen = calibration_poses(truth, 20, candidates=150)
    assert off_plane(truth, chosen.poses) < 1e-12
    assert chosen.sigma_rms < chosen.random_rms
    plan = CalibrationPlan(across=5e-3)
    first = guide(truth, plan=plan, rough=0.05)
    assert off_plane(truth, first.to_measure.guess) < 1e-12
    made = measure(truth, first.to_measure.guess, NOISE, np.random.default_rng(1))
    then = guide(truth, made.measured, plan, rough=0.05, need=0.05)
    assert then.advice == "stop"
    assert then.sigma == then.found.exit_sigma


def test_drift_is_found_in_the_plane(tmp_path: Path) -> None:
    truth, data = robot_of("tilted", False), tmp_path / "d.csv"
    made = simulate_calibration(truth, 30, NOISE, seed=1)
    data.write_text("measured")
    found = calibrate(truth, made.measured, rough=0.05)
    record = record_of(found, data, datetime.now(UTC))
    moved = 0
    for seed in range(20):
        again = simulate_calibration(truth, 6, NOISE, seed=50 + seed)
        counted = again.measured.counted + again.home_lengths - made.home_lengths
        drift = check_drift(found.robot, replace(again.measured, counted=counted), record)
        assert drift.redundancy == 6 * 2
        moved += drift.verdict != "unchanged"
        counted[:, 2] += 2e-3
        drift = check_drift(found.robot, replace(again.measured, counted=counted), record)
        assert drift.changes[0].line == "line 2"
    assert moved <= 2


def test_a_wrong_position_and_a_wrong_count_are_named() -> None:
    truth = robot_of("tilted", False)
    a = planar_robots.frame(truth)[0]
    made = simulate_calibration(truth, 40, NOISE, seed=7, sensors=SensorNoise(pose=1e-3))
    guess, counted = made.measured.guess.copy(), made.measured.counted.copy()
    guess[5] += 0.05 * a
    counted[9, 1] += 0.01
    plan = CalibrationPlan(sigma=Sigmas(encoder=NOISE))
    found = calibrate(truth, replace(made.measured, guess=guess, counted=counted), plan, rough=0.05)
    place, count = found.rejected
    assert (place.pose, place.sensor, count.pose, count.line) == (5, "position", 9, "line 1")
    assert np.allclose(place.measured, guess[5])
    assert np.allclose(np.subtract(place.measured, place.expected), 0.05 * a, atol=4e-3)
    assert count.size == pytest.approx(0.01, abs=1e-3)


def test_exit_points_stay_on_the_files_side() -> None:
    """Lengths are the same from the mirror image of any exit point in the plane of its platform point."""
    for plane, body in KINDS:
        truth = robot_of(plane, body)
        made = simulate_calibration(truth, 30, NOISE, seed=2)
        problem = StraightProblem.of(truth, made.measured, hold=False)
        theta = problem.free.copy()
        theta[3 * truth.m :] = made.home_lengths
        found = to_file_frame(problem, fit(problem, theta, made.poses))
        n = planar_robots.frame(truth)[2]
        ties = np.array([line.platform_point for line in truth.lines])
        exits = problem.points(found.theta)
        mirrored = exits.copy()
        mirrored[[0, 2]] -= 2.0 * np.outer((exits - ties)[[0, 2]] @ n - planar_robots.DISTANCE, n)
        assert np.abs(on_file_side(truth, mirrored, ties) - exits).max() < 1e-12
        flipped = found.theta.copy()
        flipped[: 3 * truth.m] = mirrored.ravel()
        again = to_file_frame(problem, fit(problem, flipped, found.poses))
        assert again.cost == pytest.approx(found.cost, rel=1e-6)
        assert np.abs(again.theta - found.theta).max() < 1e-8


def test_exit_points_in_the_plane_need_priors_of_the_plan(tmp_path: Path) -> None:
    truth = robot_of("tilted", False, off=0.0)
    made = simulate_calibration(truth, 30, 1e-4, seed=2)
    found = calibrate(truth, made.measured, rough=0.05)
    assert (found.status, found.verdict) == ("degenerate", "bad")
    assert "hardly determine the distances of exit points from the plane with normal" in found.reason
    assert 'across = "2 mm"' in found.reason
    plan = tmp_path / "plan.toml"
    plan.write_text('schema = 1\nacross = "5 mm"\n')
    told = calibrate(truth, made.measured, plan, rough=0.05)
    assert told.status == "ok"
    assert told.verdict == "good"
    assert told.exit_sigma < 2e-3  # in the plane
    with pytest.raises(InputError, match=r"^across: robot 'wang2021' has no platform.plane$"):
        StraightProblem.of(load("wang2021"), Measured(np.zeros((20, 4))), CalibrationPlan(across=1e-3))
    few = CalibrationPlan(unknowns=("length_offset",), across=1e-3)
    with pytest.raises(
        InputError,
        match=r"^across: is for exit points beside the plane; add exit_point to the unknowns, or leave out across$",
    ):
        StraightProblem.of(truth, made.measured, few)


@pytest.mark.slow
def test_what_across_brings_on_the_board_of_the_docs() -> None:
    """Belts 6 cm off it; the medians that docs/theory/calibration.md states, and home lengths within their sigmas."""
    robot, runs = load(Path(__file__).parents[2] / "examples" / "robots" / "board.toml"), 30
    a, b, n = planar_robots.frame(robot)
    exits, m = exits_of(robot), robot.m
    inside, sigmas = [], {2e-3: [], None: []}
    for seed in range(runs):
        rng = np.random.default_rng(seed)
        u, v = rng.uniform(-0.01, 0.01, (2, m, 1))
        away = u * a + v * b + rng.normal(0.0, 2e-3, (m, 1)) * n
        truth = with_values(robot, unknowns_of(robot, ("exit_point",)), (exits + away).ravel())
        made = simulate_calibration(truth, 40, 1e-4, seed=seed)
        for across, known in sigmas.items():
            plan = CalibrationPlan(across=across, sigma=Sigmas(encoder=1e-4))
            found = calibrate(robot, made.measured, plan, rough=0.1)
            assert found.status == "ok"
            known.append(found.exit_sigma)
            off = found.values[3 * m :] - made.home_lengths
            inside.append(np.abs(off / np.sqrt(np.diag(found.posterior.covariance))[3 * m :]) < stats.norm.ppf(0.975))
    low, high = stats.binom.interval(1.0 - 1e-3, runs, 0.95)  # as if the eight numbers of a run were one
    assert low / runs <= np.mean(inside) <= high / runs
    assert np.median(sigmas[2e-3]) == pytest.approx(1.1e-3, abs=1e-4)
    assert np.median(sigmas[None]) == pytest.approx(1.6e-3, abs=2e-4)


def test_poses_off_the_plane_are_rejected_in_one_line() -> None:
    truth = robot_of("vertical", True)
    made = simulate_calibration(truth, 40, NOISE, seed=1, sensors=SensorNoise(pose=1e-3))
    assert calibrate(truth, made.measured, rough=0.05).status == "ok"  # noise across the plane is no fault
    guess = made.measured.guess
    for change, sigma, words in (
        ((0.0, 0.01, 0.0, 0.0, 0.0, 0.0), True, r"x, y, z are 0.0\d* m off .* y = 0.02 m; at most 5 times their sigma"),
        ((0.0, 0.0, 0.0, 0.02, 0.0, 0.0), True, r"rx, ry, rz turn 0.02\d* rad out of .*; at most 5 times their sigma"),
        ((0.0, 0.3, 0.0, 0.0, 0.0, 0.0), False, r"x, y, z are 0.\d* m off .*; at most 0.1 m of a start value"),
        ((0.0, 0.0, 0.0, 0.0, 0.0, 0.3), False, r"rx, ry, rz turn 0.\d* rad out of .*; at most 0.1 rad of a start"),
    ):
        data = replace(made.measured, guess=guess.copy(), pose_sigma=made.measured.pose_sigma if sigma else None)
        data.guess[6] += change
        with pytest.raises(InputError, match=rf"^the data, pose 7: {words}.*is allowed$"):
            calibrate(truth, data)


def test_a_tilted_plane_draws_poses_in_its_frame() -> None:
    truth = robot_of("tilted", True)
    poses = random_poses(truth, 50, np.random.default_rng(0))
    assert off_plane(truth, poses) < 1e-12
    assert (np.abs(poses[:, :3]) <= 1.6 + 1e-12).all()
