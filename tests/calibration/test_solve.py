"""Self-calibration: required figures, reports on undetermined parameters, and rejected input."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import (
    CalibrationPlan,
    MeasuredDistance,
    MeasuredRange,
    Point,
    Prior,
    Sigmas,
    TouchedPlane,
)
from cablewright.calibration.poses.fit import NEAR, fits
from cablewright.calibration.poses.observability import information
from cablewright.calibration.poses.problem import StraightProblem
from cablewright.calibration.poses.simulation import (
    SimulatedCalibration,
    aligned,
    measure,
    random_poses,
    simulate_calibration,
)
from cablewright.foundation.errors import InputError
from cablewright.models.drum import WinchDrum
from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import Eyelet, Robot, load
from cablewright.robot.cable import Creep
from cablewright.solvers.inverse import solve_inverse
from cases import often, some

WANG = load("wang2021")
TRUE = np.array([line.exit_point for line in WANG.lines])
GAUGE = ("translation along x", "translation along y", "translation along z", "yaw")


def with_exits(robot: Robot, exits: np.ndarray) -> Robot:
    lines = zip(robot.lines, exits.tolist(), strict=True)
    return robot.model_copy(
        update={"lines": tuple(line.model_copy(update={"exit_point": tuple(place)}) for line, place in lines)}
    )


def errors(
    values: np.ndarray, poses: np.ndarray, made: SimulatedCalibration
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of exit points (4, 3), home lengths (4,) and poses (N, 3), m, after aligning translation and yaw."""
    exits, places = aligned(values[:12].reshape(4, 3), TRUE, poses)
    return exits - TRUE, values[12:] - made.home_lengths, places - made.poses


def test_creep_that_is_described_is_said_not_to_count() -> None:
    rng = np.random.default_rng(3)
    made = measure(WANG, random_poses(WANG, 16, rng), 0.0, rng)
    law = Creep(logarithmic=1e-7)
    lines = (line.model_copy(update={"cable": line.cable.model_copy(update={"creep": law})}) for line in WANG.lines)
    for robot, said in ((WANG, False), (WANG.model_copy(update={"lines": tuple(lines)}), True)):
        notes = calibrate(robot, made.measured).notes
        assert any("cable.creep of the robot file is not counted" in note for note in notes) == said


@pytest.mark.parametrize("count", [12, 16, 24, 40])
def test_every_run_without_noise_is_exact(count: int) -> None:
    """Starts up to 50 mm off; 500 runs of each count are in the benchmark and the slow test."""
    exact_runs(count, 60)


@pytest.mark.slow
@pytest.mark.parametrize("count", [12, 13, 20, 40])
def test_every_one_of_500_runs_without_noise_is_exact(count: int) -> None:
    exact_runs(count, 500)


def exact_runs(count: int, runs: int) -> None:
    rng = np.random.default_rng(count)
    made = measure(WANG, random_poses(WANG, count, rng), 0.0, rng)
    problem = StraightProblem.of(WANG, made.measured)
    truth = np.append(TRUE.ravel(), made.home_lengths)
    theta = truth + rng.uniform(-0.05, 0.05, (runs, 16))
    poses = made.poses + rng.uniform(-0.05, 0.05, (runs, count, 3))
    for found in fits(problem, theta, poses, settings=NEAR):
        assert found.code == 0
        assert max(np.abs(part).max() for part in errors(found.theta, found.poses, made)) < 1e-9


@pytest.mark.parametrize("runs", some([60, 200]))
def test_errors_are_at_the_bound_and_sigmas_cover_them(runs: int) -> None:
    """Runs at 0.1 mm: rms against the Cramer-Rao bound in the same frame, and how often sigma covers the error."""
    rng = np.random.default_rng(7)
    poses = random_poses(WANG, 40, rng)
    exits, offsets, shares = [], [], []
    for _ in range(runs):
        made = measure(WANG, poses, 1e-4, rng)
        found = calibrate(WANG, made.measured, outliers=False)
        off, lengths, _ = errors(found.values, found.poses, made)
        exits.append(off.ravel())
        offsets.append(lengths)
        shares.append(np.abs(np.append(off.ravel(), lengths)) / found.noise_sigma)
    problem = StraightProblem.of(WANG, made.measured)
    truth = np.append(TRUE.ravel(), made.home_lengths)
    bound = np.sqrt(np.diag(information(problem, truth, made.poses, problem.weights).covariance))
    for found_rms, least in ((np.array(exits), bound[:12]), (np.array(offsets), bound[12:])):
        assert np.sqrt(np.mean(found_rms**2)) == pytest.approx(np.sqrt(np.mean(least**2)), rel=0.15)
    inside = np.array(shares)
    assert np.mean(inside < 1.0) == pytest.approx(0.683, abs=0.06)
    assert np.mean(inside < 1.96) == pytest.approx(0.95, abs=0.03)


def test_undetermined_parameters_of_encoders_are_reported() -> None:
    made = simulate_calibration(WANG, 40, 1e-4, seed=1)
    found = calibrate(WANG, made.measured)
    assert found.status == "ok"
    assert (found.alone.total, found.alone.rank) == (136, 132)
    assert found.gauge == GAUGE
    assert [each.words.startswith("tilt about the horizontal axis") for each in found.weakest] == [True, True, False]
    assert found.weakest[0].sigma > 2e-3
    best = found.suggestions[0]
    assert best.words.startswith("three exit points surveyed")
    assert best.open_after == 0
    assert best.after < 0.2 * best.before


def test_a_suggestion_keeps_its_promise() -> None:
    """The predicted effect of one more distance is that of a calibration with it."""
    made = simulate_calibration(WANG, 40, 1e-4, seed=1)
    plan = CalibrationPlan(sigma=Sigmas(encoder=1e-4))
    found = calibrate(WANG, made.measured, plan)
    told = next(each for each in found.suggestions if "north-east to north-west" in each.words)
    truth = float(np.linalg.norm(TRUE[2] - TRUE[3]))
    distance = MeasuredDistance(between=("north-east", "north-west"), value=truth, deviation=1e-3)
    again = calibrate(WANG, made.measured, plan.model_copy(update={"distances": (distance,)}))
    before, after = (float(np.sqrt(np.mean(each.noise_sigma[:12] ** 2))) for each in (found, again))
    assert before == pytest.approx(told.before, rel=1e-6)
    assert after == pytest.approx(told.after, rel=0.02)


def test_sheaves_without_size_leave_tilt_open_too() -> None:
    lines = tuple(line.model_copy(update={"sheave": Eyelet()}) for line in WANG.lines)
    eyelets = WANG.model_copy(update={"lines": lines})
    made = simulate_calibration(eyelets, 30, 1e-4, seed=1)
    found = calibrate(eyelets, made.measured)
    assert found.gauge == (*GAUGE, "tilt about x", "tilt about y")
    assert found.alone.total - found.alone.rank == 6


def test_a_datum_holds_what_it_names() -> None:
    made = simulate_calibration(WANG, 40, 1e-4, seed=2)
    moved = with_exits(WANG, TRUE + np.random.default_rng(0).uniform(-0.05, 0.05, (4, 3)))
    found = calibrate(moved, made.measured, CalibrationPlan(datum=("south-west", "south-east.y")))
    held = [each.line == "south-west" or (each.line, each.axis) == ("south-east", 1) for each in found.unknowns[:12]]
    start = np.array([line.exit_point for line in moved.lines]).ravel()
    assert found.values[:12][held] == pytest.approx(start[held], abs=1e-15)
    assert (found.sigma[:12][held] == 0.0).all()
    assert (found.sigma[:12][np.logical_not(held)] > 1e-4).all()
    off, _, _ = errors(found.values, found.poses, made)
    assert np.abs(off).max() < 0.05
    assert found.gauge == GAUGE


def test_without_a_datum_exit_points_keep_their_mean_place_and_direction() -> None:
    made = simulate_calibration(WANG, 40, 0.0, seed=2)
    off = np.random.default_rng(0).uniform(-0.05, 0.05, (4, 3))
    moved = with_exits(WANG, TRUE + off)
    found = calibrate(moved, made.measured)
    change = found.values[:12].reshape(4, 3) - np.array([line.exit_point for line in moved.lines])
    arms = found.values[:12].reshape(4, 3)
    assert change.sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-9)
    assert np.cross(arms - arms.mean(axis=0), change)[:, 2].sum() == pytest.approx(0.0, abs=1e-9)


def test_priors_and_surveyed_points_shrink_sigmas() -> None:
    made = simulate_calibration(WANG, 40, 1e-4, seed=3)
    plain = calibrate(WANG, made.measured, CalibrationPlan(sigma=Sigmas(encoder=1e-4)))
    prior = CalibrationPlan(sigma=Sigmas(encoder=1e-4), priors=(Prior(name="exit_point", deviation=2e-3),))
    known = calibrate(WANG, made.measured, prior)
    assert (known.noise_sigma[:12] < 2.0e-3).all()
    assert np.sqrt(np.mean(plain.noise_sigma[:12] ** 2)) > 2.0 * np.sqrt(np.mean(known.noise_sigma[:12] ** 2))
    assert known.gauge == GAUGE  # before datum and priors
    points = tuple(Point(line=line.name, at=line.exit_point, deviation=1e-3) for line in WANG.lines[:3])
    surveyed = calibrate(WANG, made.measured, CalibrationPlan(sigma=Sigmas(encoder=1e-4), points=points))
    assert surveyed.gauge == ()
    assert surveyed.alone.rank == surveyed.alone.total
    assert np.abs(surveyed.values[:9].reshape(3, 3) - TRUE[:3]).max() < 5e-3


@pytest.mark.parametrize("sensor", ["known", "swivel", "tensions"])
def test_other_sensors_make_it_better(sensor: str) -> None:
    rng = np.random.default_rng(5)
    made = simulate_calibration(WANG, 40, 1e-4, seed=5)
    measured = made.measured
    if sensor == "known":
        sigma = np.full((40, 3), 1e-3)
        measured = Measured(measured.counted, made.poses + rng.normal(0.0, 1e-3, (40, 3)), sigma)
    elif sensor == "swivel":
        away = made.poses[:, None] - TRUE
        azimuth = np.arctan2(away[..., 1], away[..., 0]) + rng.normal(0.0, 1e-3, (40, 4))
        measured = Measured(measured.counted, measured.guess, swivel=azimuth)
    else:
        measured = Measured(
            measured.counted, measured.guess, tensions=tensions_at(made.poses) + rng.normal(0, 1, (40, 4))
        )
    plan = CalibrationPlan(sigma=Sigmas(encoder=1e-4, tension=1.0))
    alone, found = calibrate(WANG, made.measured, plan), calibrate(WANG, measured, plan)
    assert found.status == "ok"
    rms = [np.sqrt(np.mean(errors(each.values, each.poses, made)[0] ** 2)) for each in (alone, found)]
    assert found.weakest[0].sigma < 0.5 * alone.weakest[0].sigma
    assert rms[1] < rms[0]
    assert found.gauge == {"known": (), "swivel": GAUGE[:3], "tensions": GAUGE}[sensor]


def tensions_at(poses: np.ndarray) -> np.ndarray:
    return solve_inverse(Model(WANG, Fidelity.of("rigid")), poses).checked().tensions


@pytest.mark.parametrize("unknown", ["sheave_radius", "length_scale", "build_up", "drum_radius"])
def test_other_numbers_are_found(unknown: str) -> None:
    """Without noise, each that the data distinguish, exactly."""
    robot = WANG
    if unknown == "drum_radius":
        lines = tuple(
            line.model_copy(update={"winch": line.winch.model_copy(update={"drum_radius": 0.06})})
            for line in robot.lines
        )
        robot = robot.model_copy(update={"lines": lines})
    made = simulate_calibration(robot, 60, 0.0, seed=4)
    counted, truth = made.measured.counted, {"sheave_radius": 0.075, "build_up": 0.01}.get(unknown, 1.002)
    if unknown == "build_up":
        counted = WinchDrum(1.0, build_up=0.01).angles(counted)
    elif unknown in ("length_scale", "drum_radius"):
        counted = counted / 1.002
    if unknown == "sheave_radius":
        lines = tuple(
            line.model_copy(update={"sheave": line.sheave.model_copy(update={"radius": 0.07})}) for line in robot.lines
        )
        robot = robot.model_copy(update={"lines": lines})
    shared = CalibrationPlan(unknowns=("exit_point", "length_offset", unknown), shared=(unknown,))
    found = calibrate(robot, Measured(counted, made.measured.guess), shared)
    assert found.status == "ok"
    assert found.rms < 1e-10
    wanted = 0.06 * truth if unknown == "drum_radius" else truth
    assert found.values[-1] == pytest.approx(wanted, abs=1e-6)
    if unknown == "drum_radius":
        assert found.robot.lines[0].winch.drum_radius == pytest.approx(wanted, abs=1e-6)
    if unknown == "sheave_radius":
        assert found.robot.lines[3].sheave.radius == pytest.approx(truth, abs=1e-6)


@pytest.mark.parametrize("name", ["cogiro", "jung2020"])
def test_a_rigid_platform(name: str) -> None:
    """Six degrees of freedom on eight lines; exit points and home lengths unknown, platform points known."""
    robot = load(name)
    made = simulate_calibration(robot, 30, 0.0, seed=3, guess=0.02)
    found = calibrate(robot, made.measured, rough=0.0)
    assert found.status == "ok"
    assert found.alone.total - found.alone.rank in (4, 6)
    assert set(GAUGE) <= set(found.gauge)
    truth = np.array([line.exit_point for line in robot.lines])
    tilt = len(found.gauge) == 6
    exits, _ = aligned(found.values[:24].reshape(8, 3), truth, tilt=tilt)
    assert np.abs(exits - truth).max() < 1e-7


def test_the_platforms_frame_is_open_where_its_points_are_unknown() -> None:
    robot = load("cogiro")
    made = simulate_calibration(robot, 25, 1e-4, seed=3, guess=0.02)
    plan = CalibrationPlan(unknowns=("exit_point", "platform_point", "length_offset"))
    found = calibrate(robot, made.measured, plan, rough=0.0, outliers=False)
    assert found.alone.total - found.alone.rank in (10, 12)


def outliers(robot: Robot, count: int, seed: int) -> tuple[list[int], list[str], object]:
    """A calibration of data in which 5 % of the poses have one line 50 mm off; which, and the answer."""
    rng = np.random.default_rng(seed)
    made = measure(robot, random_poses(robot, count, rng), 1e-4, rng)
    counted = made.measured.counted.copy()
    bad = rng.choice(count, count // 20, replace=False)
    which = rng.integers(0, robot.m, len(bad))
    counted[bad, which] += 0.05 * rng.choice([-1.0, 1.0], len(bad))
    found = calibrate(robot, Measured(counted, made.measured.guess))
    order = np.argsort(bad)
    return bad[order].tolist(), [robot.lines[i].name for i in which[order]], found


def test_poses_with_gross_errors_are_found() -> None:
    good, files = 0, often(1, 5)
    for seed in range(files):
        bad, _, found = outliers(WANG, 100, seed)
        good += [each.pose for each in found.rejected] == bad
        assert all(each.line is None for each in found.rejected)  # nothing shows which line it is
    assert good >= files - files // 5


@pytest.mark.slow
def test_poses_with_gross_errors_are_found_in_95_of_100_runs() -> None:
    good = sum(
        [each.pose for each in found.rejected] == bad for bad, _, found in (outliers(WANG, 100, s) for s in range(200))
    )
    assert good >= 190


def six_lines() -> Robot:
    """A point on six lines: the four of `wang2021`, and two more at mid-sides."""
    more = [(-2.0, 0.0, 2.9), (2.0, 0.1, 0.3)]
    first = WANG.lines[0]
    extra = tuple(first.model_copy(update={"name": f"extra-{k}", "exit_point": at}) for k, at in enumerate(more))
    return WANG.model_copy(update={"lines": (*WANG.lines, *extra)})


def test_with_six_lines_the_line_is_named() -> None:
    named = right = 0
    for seed in range(often(1, 2)):
        bad, lines, found = outliers(six_lines(), 100, seed)
        assert [each.pose for each in found.rejected] == bad
        named += len(bad)
        right += sum(each.line == line for each, line in zip(found.rejected, lines, strict=True))
    assert right >= 0.9 * named


def rough(seed: int) -> bool:
    """Whether a random layout, known to half a metre and without any guess of a pose, is found."""
    rng = np.random.default_rng(seed)
    corners = np.array([[-2.0, -1.75], [2.0, -1.75], [2.0, 1.75], [-2.0, 1.75]]) + rng.uniform(-0.5, 0.5, (4, 2))
    truth = np.column_stack([corners, rng.uniform(0.2, 3.0, 4)])
    made = measure(with_exits(WANG, truth), rng.uniform([-1.4, -1.2, 0.4], [1.4, 1.2, 2.4], (40, 3)), 0.0, rng)
    file = with_exits(WANG, truth + rng.uniform(-0.5, 0.5, (4, 3)))
    found = calibrate(file, Measured(made.measured.counted), seed=seed, outliers=False)
    exits, _ = aligned(found.values[:12].reshape(4, 3), truth)
    return bool(np.abs(exits - truth).max() < 1e-6)


def test_rough_dimensions_are_enough() -> None:
    assert all(rough(seed) for seed in range(often(1, 2)))


@pytest.mark.slow
def test_rough_dimensions_are_enough_in_95_of_100_layouts() -> None:
    assert sum(rough(seed) for seed in range(200)) >= 190


def test_too_few_poses_are_rejected() -> None:
    made = simulate_calibration(WANG, 11, 1e-4, seed=1)
    with pytest.raises(InputError, match="11 poses; at least 12 are required"):
        calibrate(WANG, made.measured)
    assert calibrate(WANG, simulate_calibration(WANG, 12, 1e-4, seed=1).measured).alone.rank == 48


def test_twelve_poses_leave_no_sigma() -> None:
    found = calibrate(WANG, simulate_calibration(WANG, 12, 1e-4, seed=1).measured)
    assert np.isnan(found.sigma).all()
    assert any("no measurement is left over" in note for note in found.notes)


def test_identical_poses_are_rejected() -> None:
    made = simulate_calibration(WANG, 20, 1e-4, seed=1)
    same = Measured(np.tile(made.measured.counted[3], (40, 1)))
    with pytest.raises(InputError, match="pose 2: repeats all measurements of pose 1"):
        calibrate(WANG, same)


def test_as_many_lines_as_degrees_of_freedom_calibrate_nothing() -> None:
    three = WANG.model_copy(update={"lines": WANG.lines[:3]})
    with pytest.raises(InputError, match="there are no redundant measurements"):
        calibrate(three, Measured(np.random.default_rng(0).uniform(-1, 1, (40, 3))))


def test_a_plan_without_unknowns_is_rejected() -> None:
    made = simulate_calibration(WANG, 12, 1e-4, seed=2)
    with pytest.raises(InputError, match="unknowns: must name at least one number"):
        calibrate(WANG, made.measured, CalibrationPlan(unknowns=()))


def test_a_datum_that_the_data_deny_is_rejected() -> None:
    made = simulate_calibration(WANG, 40, 1e-4, seed=2)
    moved = with_exits(WANG, TRUE + np.random.default_rng(0).uniform(-0.05, 0.05, (4, 3)))
    with pytest.raises(InputError, match="datum contradicts the data"):
        calibrate(moved, made.measured, CalibrationPlan(datum=("south-west", "south-east", "north-east")))


def test_lines_in_the_wrong_order_change_nothing() -> None:
    made = simulate_calibration(WANG, 40, 1e-4, seed=2)
    found = calibrate(WANG, Measured(made.measured.counted[:, [1, 0, 2, 3]] * [1, 1, 1, -1], made.measured.guess))
    assert found.status != "ok"
    assert found.reason
    assert found.robot == WANG


def test_contacts_with_a_plane_and_distances_from_a_point_count() -> None:
    """A floor fixes height and tilt; distances from a known point fix the place."""
    rng = np.random.default_rng(8)
    poses = random_poses(WANG, 40, rng)
    touching = (3, 9, 14, 20, 27, 33)
    for at in touching:
        poses[at - 1, 2] = 0.8
    made = measure(WANG, poses, 1e-4, rng)
    plane = TouchedPlane(poses=touching, point=(0.0, 0.0, 0.8), normal=(0.0, 0.0, 2.0), deviation=1e-4)
    corner = np.array([0.5, -1.7, 0.1])
    seen = tuple(range(1, 13))
    values = np.linalg.norm(made.poses[:12] - corner, axis=1) + rng.normal(0.0, 1e-3, 12)
    reach = MeasuredRange(point=tuple(corner), poses=seen, values=tuple(values), deviation=1e-3)
    sigma = Sigmas(encoder=1e-4)
    alone = calibrate(WANG, made.measured, CalibrationPlan(sigma=sigma))
    floor = calibrate(WANG, made.measured, CalibrationPlan(sigma=sigma, planes=(plane,)))
    both = calibrate(WANG, made.measured, CalibrationPlan(sigma=sigma, planes=(plane,), ranges=(reach,)))
    assert floor.gauge == (GAUGE[0], GAUGE[1], GAUGE[3])
    assert len(both.gauge) == 1  # a turn about the vertical through the point
    assert floor.sigma[2] < 0.5 * alone.sigma[2]
    off, _, _ = errors(floor.values, floor.poses, made)
    assert np.abs(off).max() < 6.0 * floor.sigma[:12].max()
