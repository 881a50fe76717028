"""Lines that stretch and sag in the one problem: derivatives, invariance, recovery, sigmas, gross errors,
rejections."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import Bound, CalibrationPlan, MeasuredRange, Point, Prior, Sigmas, TouchedPlane
from cablewright.calibration.poses.elastic import ElasticProblem
from cablewright.calibration.poses.observability import information, open_freedoms
from cablewright.calibration.poses.simulation import (
    SensorNoise,
    SimulatedCalibration,
    aligned,
    measure,
    random_poses,
    simulate_calibration,
)
from cablewright.calibration.unknowns import unknowns_of, with_values
from cablewright.foundation.errors import InputError
from cablewright.models.fidelity import Fidelity
from cablewright.models.rotation import matrices, turn_between
from cablewright.models.statics import Model
from cablewright.robot import Robot, load
from cablewright.solvers.inverse import solve_inverse
from cases import some

GAUGE = ("translation along x", "translation along y", "translation along z", "yaw")
EXACT = SensorNoise(tension=0.0)


def exits_of(robot: Robot) -> np.ndarray:
    return np.array([line.exit_point for line in robot.lines])


def moved(robot: Robot, rng: np.random.Generator, off: float) -> Robot:
    """The robot's file with exit points up to *off* (m) wrong in each coordinate, winches with them."""
    exits = exits_of(robot)
    wrong = exits + rng.uniform(-off, off, exits.shape)
    return with_values(robot, unknowns_of(robot, ("exit_point",)), wrong.ravel(), raised=True)


def error(found: Calibration, made: SimulatedCalibration, truth: Robot) -> tuple[float, float, float]:
    """Largest error of exit points, home lengths and poses, m, after aligning translation and yaw."""
    m = truth.m
    exits, poses = aligned(found.values[: 3 * m].reshape(-1, 3), exits_of(truth), found.poses[:, :3])
    home = found.values[3 * m : 4 * m] - made.home_lengths
    return tuple(float(np.abs(off).max()) for off in (exits - exits_of(truth), home, poses - made.poses[:, :3]))


def softened(robot: Robot, factor: float) -> Robot:
    """The robot with cables *factor* times as stiff."""
    return with_values(robot, unknowns_of(robot, ("modulus",), ("modulus",), elastic=True), np.array([factor]))


def everything(name: str, cable: str) -> tuple[ElasticProblem, np.ndarray, np.ndarray]:
    """A problem with rows of every sensor, none of which fits, its unknowns and what is kept of each pose."""
    robot, rng = load(name), np.random.default_rng(5)
    lines = tuple(line.model_copy(update={"exit_compliance": 3e-6}) for line in robot.lines)
    robot = robot.model_copy(update={"lines": lines})
    model, body = Model(robot, Fidelity.of(cable)), robot.n == 6
    held = solve_inverse(model, random_poses(robot, 4, rng, cable)).checked()
    names = ("exit_point", "length_offset", "length_scale", "build_up", "modulus", "exit_compliance")
    names += ("sheave_radius",) * (robot.lines[0].sheave.kind != "eyelet") + ("platform_point",) * body
    plan = CalibrationPlan(
        unknowns=names,
        shared=("modulus",),
        planes=(TouchedPlane(poses=(2, 3), point=(0.0, 0.0, 0.5), normal=(0.1, 0.2, 1.0)),),
        ranges=(MeasuredRange(point=(0.1, 0.2, 0.3), poses=(1, 4), values=(2.0, 3.0)),),
        points=(Point(line=robot.lines[0].name, at=(0.1, 0.2, 0.3)),),
        priors=(Prior(name="modulus", deviation=0.05),),
    )
    measured = Measured(
        rng.uniform(-0.1, 0.1, held.lengths.shape),
        held.pose + np.array([0.01, 0.01, 0.01, 0.0, 0.0, 0.0])[: robot.n],  # no turn: see _coordinate
        np.full(held.pose.shape, 1e-2),
        held.tensions * rng.uniform(0.9, 1.1, held.lengths.shape),
        rng.uniform(-3.0, 3.0, held.lengths.shape),
        rng.uniform(-0.1, 0.1, (4, 2)) if body else None,
    )
    problem = ElasticProblem.of(model, measured, plan)
    return problem, problem.free, problem.states_of(held)


@pytest.mark.parametrize(
    ("name", "cable"),
    [("wang2021", "elastic"), ("paty2021", "catenary"), ("merlet2023", "catenary"), ("cogiro", "catenary")],
)
def test_derivatives_are_those_of_differences(name: str, cable: str) -> None:
    problem, theta, own = everything(name, cable)
    found, step = problem.derivatives(theta, own), 5e-6
    for k in range(len(theta)):
        move = step * np.eye(len(theta))[k]
        ahead, behind = (problem.derivatives(theta + by, own).residual for by in (move, -move))
        size = max(1.0, float(np.abs(found.by_unknown[..., k]).max()))
        assert (ahead - behind) / (2 * step) == pytest.approx(found.by_unknown[..., k], abs=2e-5 * size)
    for i in range(problem.robot.m):
        move = step * np.eye(own.shape[1])[i]
        ahead, behind = (problem.derivatives(theta, own + by).residual for by in (move, -move))
        size = float(np.abs(found.by_pose[..., i]).max())
        assert (ahead - behind) / (2 * step) == pytest.approx(found.by_pose[..., i], abs=2e-5 * size)


@pytest.mark.parametrize(("name", "cable"), [("paty2021", "catenary"), ("cogiro", "catenary"), ("jung2020", "elastic")])
def test_lengths_and_tensions_say_nothing_of_place_and_direction(name: str, cable: str) -> None:
    """Everything moved and turned about the vertical: no reading changes, by a little or by a lot."""
    robot, angle, by = load(name), 0.7, np.array([0.3, -0.2, 0.4])
    made = simulate_calibration(robot, 6, 0.0, seed=3, cable=cable, sensors=EXACT)
    problem = ElasticProblem.of(Model(robot, Fidelity.of(cable)), made.measured, CalibrationPlan(), hold=False)
    held = solve_inverse(problem.model, made.poses).checked()
    theta, own = problem.free, problem.states_of(held)
    turn = matrices([0.0, 0.0, angle])
    exits = np.array([each.name == "exit_point" for each in problem.unknowns])
    other, poses = theta.copy(), held.pose.copy()
    other[exits] = (theta[exits].reshape(-1, 3) @ turn.T + by).ravel()
    poses[:, :3] = poses[:, :3] @ turn.T + by
    if robot.n == 6:
        poses[:, 3:] = turn_between(-poses[:, 3:], np.tile([0.0, 0.0, angle], (len(poses), 1)))
    here, there = problem.derivatives(theta, own), problem.derivatives(other, problem.with_poses(own, poses))
    assert there.residual == pytest.approx(here.residual, abs=1e-6)
    assert open_freedoms(information(problem, theta, own, problem.weights)) == GAUGE


@pytest.mark.parametrize(
    ("name", "cable", "count"),
    [
        ("paty2021", "catenary", 30),
        ("merlet2023", "catenary", 30),
        ("wang2021", "elastic", 30),
        ("cogiro", "catenary", 20),
        ("jung2020", "elastic", 20),
        ("grab-four-lines", "catenary", 20),
    ],
)
@pytest.mark.parametrize("seed", some([0, 1]))
def test_without_noise_geometry_and_modulus_are_exact(name: str, cable: str, count: int, seed: int) -> None:
    """From encoders and tensions alone, poses unknown, exit points 30 mm and the modulus 20 % off."""
    robot, rng = load(name), np.random.default_rng(seed)
    off = 5e-3 if robot.m < robot.n else 0.03
    truth = softened(robot, 0.8)
    made = measure(truth, random_poses(truth, count, rng, cable), 0.0, rng, off, cable, EXACT)
    plan = CalibrationPlan(
        unknowns=("exit_point", "length_offset", "modulus"), shared=("modulus",), sigma=Sigmas(encoder=1e-4)
    )
    found = calibrate(moved(robot, rng, off), made.measured, plan, cable=cable, rough=off, outliers=False)
    assert (found.status, found.gauge) == ("ok", GAUGE)
    assert max(error(found, made, truth)) < 1e-9
    assert found.values[-1] == pytest.approx(0.8, abs=1e-8)
    assert found.alone.total - found.alone.rank == 4


def test_the_robot_is_written_with_its_modulus_and_winches() -> None:
    truth, rng = softened(load("paty2021"), 0.8), np.random.default_rng(2)
    made = measure(
        truth, random_poses(truth, 30, rng, "catenary"), 0.0, rng, 0.02, "catenary", SensorNoise(tension=0.0)
    )
    plan = CalibrationPlan(unknowns=("exit_point", "length_offset", "modulus"), shared=("modulus",))
    found = calibrate(load("paty2021"), made.measured, plan, cable="catenary", rough=0.0, outliers=False)
    for line, true in zip(found.robot.lines, truth.lines, strict=True):
        assert line.exit_point == pytest.approx(true.exit_point, abs=1e-9)
        assert line.winch_exit == pytest.approx(true.winch_exit, abs=1e-9)
        assert line.cable.young_modulus == pytest.approx(true.cable.young_modulus, rel=1e-8)


def test_measured_poses_leave_nothing_open() -> None:
    robot, rng = load("cogiro"), np.random.default_rng(3)
    truth = softened(robot, 0.8)
    made = measure(truth, random_poses(truth, 20, rng, "catenary"), 0.0, rng, 0.0, "catenary", SensorNoise(pose=0.0))
    plan = CalibrationPlan(unknowns=("exit_point", "length_offset", "modulus"), shared=("modulus",))
    found = calibrate(moved(robot, rng, 5e-3), made.measured, plan, cable="catenary", rough=0.01, outliers=False)
    assert (found.status, found.gauge, found.suggestions[0].open_before) == ("ok", (), 0)
    assert np.abs(found.values[:24].reshape(-1, 3) - exits_of(truth)).max() < 1e-7
    assert found.values[-1] == pytest.approx(0.8, abs=1e-5)


@pytest.mark.slow  # as the kind `hung` of features/test_calibrated_features.py
def test_errors_are_at_the_bound_and_sigmas_cover_them() -> None:
    robot, rng = load("paty2021"), np.random.default_rng(4)
    poses, beside = random_poses(robot, 25, rng, "catenary"), SensorNoise(tension=10.0)
    plan = CalibrationPlan(sigma=Sigmas(encoder=5e-4, tension=10.0))
    shares, square, bound = [], [], []
    for _ in range(30):
        made = measure(robot, poses, 5e-4, rng, 0.02, "catenary", beside)
        found = calibrate(robot, made.measured, plan, cable="catenary", rough=0.0, outliers=False)
        exits, _ = aligned(found.values[:12].reshape(-1, 3), exits_of(robot))
        off = np.append((exits - exits_of(robot)).ravel(), found.values[12:] - made.home_lengths)
        shares.append(np.abs(off) / found.noise_sigma)
        square.append(off**2)
        bound.append(found.noise_sigma**2)
    assert np.sqrt(np.mean(square) / np.mean(bound)) == pytest.approx(1.0, abs=0.2)
    assert np.mean(np.array(shares) < 1.0) == pytest.approx(0.683, abs=0.08)
    assert np.mean(np.array(shares) < 1.96) == pytest.approx(0.95, abs=0.05)


def test_bad_encoders_and_load_cells_are_left_out() -> None:
    """A line is named where the others identify it; a load cell's error explains no encoder's."""
    robot = load("paty2021")
    made = simulate_calibration(robot, 30, 1e-4, seed=1, guess=0.02, cable="catenary", sensors=SensorNoise(tension=2.0))
    assert made.measured.tensions is not None
    counted, tensions = made.measured.counted.copy(), made.measured.tensions.copy()
    counted[7, 2] += 0.05
    tensions[11, 1] += 200.0
    measured = replace(made.measured, counted=counted, tensions=tensions)
    plan = CalibrationPlan(sigma=Sigmas(encoder=1e-4, tension=2.0))
    found = calibrate(robot, measured, plan, cable="catenary", rough=0.02)
    assert found.status == "ok"
    encoder, cell = found.rejected
    assert (encoder.pose, encoder.sensor, encoder.unit) in ((7, "encoder", "m"), (7, None, "m"))
    assert (cell.pose, cell.sensor, cell.line, cell.unit) == (11, "tension", robot.lines[1].name, "N")
    assert cell.size == pytest.approx(200.0, abs=10.0)
    clean = calibrate(robot, made.measured, plan, cable="catenary", rough=0.02)
    assert clean.rejected == ()
    assert np.abs(found.values - clean.values).max() < 3.0 * clean.sigma.max()


def test_a_datum_and_a_yaw_far_from_the_file() -> None:
    """Without a datum the answer stands as the file does; with one its points stay."""
    robot = load("paty2021")
    made = simulate_calibration(robot, 25, 0.0, seed=6, guess=0.02, cable="catenary", sensors=EXACT)
    wrong = moved(robot, np.random.default_rng(7), 0.02)
    plan = CalibrationPlan(sigma=Sigmas(encoder=1e-4), datum=("south-west", "south-east.y"))
    found = calibrate(wrong, made.measured, plan, cable="catenary", rough=0.02, outliers=False)
    assert found.robot.lines[0].exit_point == pytest.approx(wrong.lines[0].exit_point, abs=1e-11)
    assert found.robot.lines[1].exit_point[1] == pytest.approx(wrong.lines[1].exit_point[1], abs=1e-11)
    assert (found.sigma[:3] == 0.0).all()
    assert found.gauge == GAUGE
    assert max(error(found, made, robot)[:2]) < 1e-9


def test_the_range_of_the_modulus_is_that_of_the_plan() -> None:
    robot = load("paty2021")
    made = simulate_calibration(robot, 24, 1e-4, seed=1, cable="elastic", sensors=SensorNoise(tension=5.0))
    plan = CalibrationPlan(
        unknowns=("exit_point", "length_offset", "modulus"),
        shared=("modulus",),
        bounds=(Bound(name="modulus", min=0.8, max=1.25),),
        sigma=Sigmas(encoder=1e-4, tension=5.0),
    )
    found = calibrate(robot, made.measured, plan, cable="elastic", rough=0.05)
    assert found.status == "ok"
    assert 0.8 < found.values[-1] < 1.25


def test_stiff_lines_with_rough_tensions_say_what_straight_ones_do() -> None:
    """Tensions that are known roughly, lines ten times as stiff: straight lines are that limit."""
    robot = load("wang2021")
    stiff, made = softened(robot, 10.0), simulate_calibration(robot, 40, 1e-4, seed=1)
    tensions = solve_inverse(Model(robot, Fidelity.of("rigid")), made.poses).tensions
    plan = CalibrationPlan(sigma=Sigmas(encoder=1e-4, tension=20.0))
    measured = replace(made.measured, tensions=tensions)
    given = calibrate(stiff, measured, plan, cable="elastic", rough=0.05, outliers=False)
    straight = calibrate(robot, made.measured, plan, rough=0.05, outliers=False)
    assert given.status == "ok"
    found = [each.values[:12].reshape(-1, 3) for each in (given, straight)]
    shape, same = (aligned(exits, exits_of(robot), tilt=True)[0] for exits in found)
    assert shape == pytest.approx(same, abs=1e-3)  # exit points are known to 8 mm


@pytest.mark.parametrize("name", ["wang2021", "cogiro"])
def test_encoders_alone_are_rejected_with_the_sensors_that_would_help(name: str) -> None:
    made = simulate_calibration(load(name), 40, 0.0, seed=1, cable="elastic")
    with pytest.raises(InputError, match="there are no redundant measurements for the calibration; measure tensions"):
        calibrate(load(name), made.measured, cable="elastic")


def test_too_few_poses_are_reported() -> None:
    made = simulate_calibration(load("paty2021"), 2, 0.0, seed=1, cable="catenary", sensors=EXACT)
    with pytest.raises(
        InputError, match="2 poses; at least 3 are required: each pose gives 8 numbers and has 4 unknowns"
    ):
        calibrate(load("paty2021"), made.measured, cable="catenary")


def test_few_lines_need_guesses() -> None:
    made = simulate_calibration(load("grab-four-lines"), 20, 0.0, seed=1, cable="catenary", sensors=EXACT)
    with pytest.raises(InputError, match="start values of the poses"):
        calibrate(load("grab-four-lines"), replace(made.measured, guess=None), cable="catenary")


def test_a_datum_that_the_data_deny_is_rejected() -> None:
    robot = load("paty2021")
    made = simulate_calibration(robot, 25, 1e-4, seed=6, guess=0.02, cable="catenary", sensors=SensorNoise(tension=2.0))
    wrong = moved(robot, np.random.default_rng(7), 0.05)
    plan = CalibrationPlan(sigma=Sigmas(encoder=1e-4, tension=2.0), datum=("south-west", "south-east", "north-east"))
    with pytest.raises(InputError, match="datum contradicts the data"):
        calibrate(wrong, made.measured, plan, cable="catenary", rough=0.05, outliers=False)
