"""Calibration of lines over all guides, on shared drums, with counterweights: derivatives, the bound, verdicts."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from benchmarks.campaigns import calibrated_features as campaign

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.drift.drift import check_drift
from cablewright.calibration.drift.record import record_of
from cablewright.calibration.measurements import Measured, read_measured, write_measured
from cablewright.calibration.plan import CalibrationPlan, Sigmas
from cablewright.calibration.poses.elastic import problem_of
from cablewright.calibration.poses.problem import CalibrationProblem, StraightProblem
from cablewright.calibration.poses.simulation import SensorNoise, random_poses, simulate_calibration
from cablewright.calibration.unknowns import unknowns_of, with_values
from cablewright.foundation.errors import InputError
from cablewright.models.fidelity import Fidelity
from cablewright.models.free_coordinates import as_held
from cablewright.models.statics import Model
from cablewright.robot import Robot, load
from cablewright.solvers.inverse import solve_inverse
from cases import some
from models.support_examples import example
from out_of_plane import body, point
from physics.test_shared_winches import parallelograms

HUNG = campaign.hung_point()
PAIRS = campaign.pairs_of_lines()


def of(feature: str, is_body: bool) -> Robot:
    """The example of a feature in the table of support."""
    robot = example(feature, is_body)
    assert robot is not None
    return robot


CASES = {
    "pulleys, elastic": lambda: (body("pulleys"), "elastic"),
    "aside, catenary": lambda: (point("aside"), "catenary"),
    "platform sheaves, catenary": lambda: (point("platform sheaves"), "catenary"),
    "guides, elastic": lambda: (point("guides"), "elastic"),
    "wheels, catenary": lambda: (point("wheels"), "catenary"),
    "pairs, elastic": lambda: (PAIRS, "elastic"),
    "pairs, rigid": lambda: (PAIRS, "rigid"),
    "hung, elastic": lambda: (HUNG, "elastic"),
    "hung, rigid": lambda: (HUNG, "rigid"),
    "hung body, catenary": lambda: (of("counterweight", True), "catenary"),
    "two lines in a plane, elastic": lambda: (of("few-lines-in-plane", True), "elastic"),
}


def everything(robot: Robot, cable: str) -> tuple[CalibrationProblem, np.ndarray]:
    """A problem with counts, tensions and positions, none of which fits, and the states of its poses."""
    rng, model = np.random.default_rng(5), Model(robot, Fidelity.of(cable))
    held = solve_inverse(model, as_held(robot, random_poses(robot, 3, rng, cable))).checked()
    names: tuple[str, ...] = ("exit_point", "length_offset", "length_scale", "build_up", "tension_offset")
    names += ("modulus",) * (cable != "rigid") + ("platform_point",) * (robot.n == 6)
    names += ("centre_of_mass",) * (cable != "rigid" and robot.n == 6)
    names += ("sheave_radius",) * any(line.sheave.kind != "eyelet" for line in robot.lines)
    shared = ("modulus",) * (cable != "rigid")
    measured = Measured(
        rng.uniform(-0.1, 0.1, held.lengths.shape),
        held.pose,
        np.full(held.pose.shape, 1e-2),
        held.tensions * rng.uniform(0.9, 1.1, held.lengths.shape),
    )
    problem = problem_of(model, measured, CalibrationPlan(unknowns=names, shared=shared, sigma=Sigmas(tension=1.0)))
    return problem, problem.states_of(held) if problem.elastic else held.pose  # type: ignore[attr-defined]


@pytest.mark.parametrize("case", CASES)
def test_derivatives_are_those_of_differences(case: str) -> None:
    problem, states = everything(*CASES[case]())
    theta, step = problem.free, 1e-5
    found = problem.derivatives(theta, states)
    assert found.whole.all()
    for k in range(len(theta)):
        move = step * np.eye(len(theta))[k]
        ahead, behind = (problem.derivatives(theta + by, states).residual for by in (move, -move))
        size = max(1.0, float(np.abs(found.by_unknown[..., k]).max()))
        assert (ahead - behind) / (2 * step) == pytest.approx(found.by_unknown[..., k], abs=2e-5 * size)
    for i in range(problem.robot.m if problem.elastic else 3):  # rotations: see test_straight_paths
        move = step * np.eye(states.shape[1])[i]
        ahead, behind = (problem.derivatives(theta, states + by).residual for by in (move, -move))
        size = max(1.0, float(np.abs(found.by_pose[..., i]).max()))
        assert (ahead - behind) / (2 * step) == pytest.approx(found.by_pose[..., i], abs=2e-5 * size)


FAST = ("pulleys", "ends_body", "pairs", "hung")


@pytest.mark.parametrize("kind", some([*FAST, *(kind for kind in campaign.MORE if kind not in FAST)], fast=len(FAST)))
def test_errors_are_at_the_bound_and_sigmas_cover_them(kind: str) -> None:
    """In the directions of the bound's covariance: some 80 to 200 numbers of sigma 1."""
    found = campaign.figures(kind, range(4))
    assert not found.failures
    deviation = 1.0 / np.sqrt(2.0 * found.errors.size)
    assert found.rms == pytest.approx(1.0, abs=3.0 * deviation + 0.15)
    assert found.inside.mean() > 0.85
    assert found.joint.sum() >= 3
    assert {*found.verdicts} <= ({"doubtful"} if kind.startswith("hung") else {"good", "doubtful"})


@pytest.mark.parametrize(
    ("robot", "cable"),
    [(point("pulleys"), "rigid"), (point("platform sheaves"), "rigid"), (PAIRS, "rigid"), (PAIRS, "elastic"),
     (HUNG, "elastic")],
    ids=["pulleys", "platform sheaves", "pairs", "pairs that stretch", "hung that stretches"],
)  # fmt: skip
def test_data_without_noise_give_the_machine_back(robot: Robot, cable: str) -> None:
    sensors = SensorNoise(pose=0.0, tension=None if cable == "rigid" else 0.0)
    made = simulate_calibration(robot, 30, 0.0, seed=2, cable=cable, sensors=sensors)
    rng = np.random.default_rng(4)
    file = robot.with_(exit_points=robot.exit_points + rng.uniform(-5e-3, 5e-3, (robot.m, 3)))
    plan = CalibrationPlan(sigma=Sigmas(encoder=1e-6, tension=1e-3))
    found = calibrate(file, made.measured, plan, cable=cable, rough=0.02, outliers=False)
    assert found.status == "ok"
    assert np.abs(found.robot.exit_points - robot.exit_points).max() < 2e-5
    assert found.rms < 1e-7


def test_lines_on_one_drum_are_counted_once() -> None:
    """As its first line moves, or against it; the file has no column for the others."""
    made = simulate_calibration(PAIRS, 20, 1e-4, seed=1)
    counted = made.measured.counted
    assert np.array_equal(counted[:, ::2], counted[:, 1::2])
    text = write_measured(made.measured, PAIRS)
    assert text.splitlines()[0].startswith("dl_1,dl_3,dl_5,x,y,z")


def test_a_drum_that_pays_in_and_out_is_read_with_its_signs(tmp_path: Path) -> None:
    first, second = PAIRS.lines[:2]
    against = second.shared_winch.model_copy(update={"winds": "against", "offset": 4.0})  # type: ignore[union-attr]
    lines = (first, second.model_copy(update={"shared_winch": against}), *PAIRS.lines[2:])
    robot = PAIRS.model_copy(update={"lines": lines})
    file = tmp_path / "d.csv"
    file.write_text("dl_1,dl_3,dl_5\n0,0,0\n0.1,0.2,0.3\n")
    assert read_measured(file, robot).counted[1] == pytest.approx([0.1, -0.1, 0.2, 0.2, 0.3, 0.3])


@pytest.mark.parametrize(
    ("robot", "header", "why"),
    [
        (PAIRS, "dl_1,dl_2,dl_3,dl_5", "line '0b' is on the drum of '0a', which is counted once: leave it out"),
        (HUNG, "dl_1,dl_2,dl_3,dl_4,dl_5", "line 'weight' has a counterweight, and no encoder: leave the column out"),
        (PAIRS, "dl_1,dl_3,dl_5,dl_7", "'pairs' has 6 lines"),
    ],
)
def test_a_count_of_no_winch_is_rejected(robot: Robot, header: str, why: str, tmp_path: Path) -> None:
    file = tmp_path / "d.csv"
    file.write_text(f"{header}\n{','.join(['0'] * len(header.split(',')))}\n")
    with pytest.raises(InputError, match=why):
        read_measured(file, robot)


def test_a_drum_of_several_lines_has_one_radius() -> None:
    lines = tuple(line.model_copy(update={"winch": line.winch.model_copy(update={"drum_radius": 0.05})})
                  for line in PAIRS.lines)  # fmt: skip
    robot = PAIRS.model_copy(update={"lines": lines})
    unknowns = unknowns_of(robot, ("drum_radius",))
    assert [each.line for each in unknowns] == ["0a", "1a", "2a"]
    changed = with_values(robot, unknowns, np.array([0.051, 0.052, 0.053]))
    assert [line.winch.drum_radius for line in changed.lines] == [0.051, 0.051, 0.052, 0.052, 0.053, 0.053]


@cache
def blind() -> tuple[Robot, Measured]:
    return HUNG, simulate_calibration(HUNG, 40, 1e-4, seed=3, sensors=SensorNoise(pose=1e-3)).measured


def test_an_exit_point_that_no_measurement_depends_on_is_named() -> None:
    """A counterweight has no encoder: its exit point stays that of the file, and the verdict says so."""
    robot, measured = blind()
    found = calibrate(robot, measured, rough=0.05)
    assert found.verdict == "doubtful"
    assert found.reasons[0].startswith("nothing measured depends on the exit point of weight")
    assert "weight" not in {each.line for each in found.unknowns}
    assert found.robot.lines[-1] == robot.lines[-1]


def test_data_of_another_robot_are_named_beside_a_counterweight() -> None:
    robot, measured = blind()
    off = robot.exit_points
    off[1] += [0.3, -0.2, 0.1]
    found = calibrate(robot.with_(exit_points=off), measured, rough=0.05)
    assert found.verdict == "bad"
    assert any("are the data of this robot?" in each for each in found.reasons)


def test_a_machine_with_a_counterweight_is_compared_later(tmp_path: Path) -> None:
    """A line that slips on its drum is found; the counterweight has no length that could."""
    robot, measured = blind()
    first, data = np.arange(40) < 30, tmp_path / "d.csv"
    data.write_text(write_measured(measured.only(first), robot))
    found = calibrate(robot, data, CalibrationPlan(sigma=Sigmas(encoder=1e-4)), rough=0.05)
    record, later = record_of(found, data, datetime(2026, 11, 30, tzinfo=UTC)), measured.only(~first)
    assert check_drift(found.robot, later, record).verdict == "unchanged"
    slipped = later.counted + 3e-3 * np.eye(5)[1]
    moved = check_drift(found.robot, replace(later, counted=slipped), record)
    assert moved.verdict == "moved"
    assert [each.line for each in moved.lines] == [line.name for line in robot.lines[:4]]


def test_absolute_lengths_need_a_winch_on_each_line() -> None:
    measured = simulate_calibration(PAIRS, 12, 1e-4, seed=1).measured
    with pytest.raises(InputError, match="lengths: absolute ones are for a winch on each line"):
        StraightProblem.of(PAIRS, measured, CalibrationPlan(lengths="absolute", unknowns=("exit_point",)))


def test_tensions_show_the_exit_point_of_a_counterweight() -> None:
    """By the balance of the platform, in which its tension is its weight."""
    measured = simulate_calibration(HUNG, 40, 1e-4, seed=3, sensors=SensorNoise(pose=1e-4, tension=0.01)).measured
    assert np.isnan(measured.tensions[:, -1]).all()
    off = HUNG.exit_points
    off[-1] += [0.03, -0.02, 0.02]
    plan = CalibrationPlan(sigma=Sigmas(encoder=1e-4, tension=0.01))
    found = calibrate(HUNG.with_(exit_points=off), measured, plan, rough=0.05)
    own = [at for at, each in enumerate(found.unknowns) if (each.name, each.line) == ("exit_point", "weight")]
    error = found.robot.exit_points[-1] - HUNG.exit_points[-1]
    assert len(own) == 3
    assert (np.abs(error) < 4.0 * found.sigma[own]).all()
    assert found.sigma[own].max() < 5e-3


def test_what_aside_winches_cannot_have_is_rejected() -> None:
    robot = point("aside")
    poses = random_poses(robot, 3, np.random.default_rng(1))
    measured = Measured(np.zeros((3, robot.m)), poses, tensions=np.full((3, robot.m), 50.0))
    with pytest.raises(InputError, match=r"exit_compliance: the cable of line .* comes from aside"):
        StraightProblem.of(robot, measured, CalibrationPlan(unknowns=("exit_point", "exit_compliance")))
    with pytest.raises(InputError, match=r"swivel_1: line .* has a winch aside of its swivel's axis, which turns"):
        StraightProblem.of(robot, replace(measured, swivel=np.zeros((3, robot.m))))


def test_the_angle_of_a_cable_over_a_pulley_is_its_azimuth() -> None:
    """By the cable's own direction, since the pulley leads it off the exit point."""
    robot = point("pulleys")
    poses = random_poses(robot, 5, np.random.default_rng(2))
    problem = StraightProblem.of(robot, Measured(np.zeros((5, robot.m)), poses, swivel=np.zeros((5, robot.m))))
    angles = problem.derivatives(problem.start, poses, np.ones(len(problem.values))).residual[:, robot.m :]
    held = solve_inverse(Model(robot, Fidelity.of("rigid")), poses)
    turn = np.angle(np.exp(1j * (angles - held.line_states.azimuth)))
    assert turn == pytest.approx(np.zeros_like(turn), abs=1e-9)


def test_where_no_straight_cable_runs_neither_its_length_nor_its_angle_is_a_number() -> None:
    robot = point("pulleys")
    poses = np.array([robot.exit_points[0] + [0.0, 0.0, 1e-3], [0.1, 0.2, 1.0]])
    problem = StraightProblem.of(robot, Measured(np.zeros((2, robot.m)), poses, swivel=np.zeros((2, robot.m))))
    found = problem.derivatives(problem.start, poses, np.ones(len(problem.values))).residual
    assert np.isnan(found[0, [0, robot.m]]).all()
    assert np.isfinite(found[1]).all()


def test_a_body_on_four_pairs_is_drawn_and_calibrated() -> None:
    robot = parallelograms(4)
    made = simulate_calibration(robot, 20, 1e-4, seed=1, sensors=SensorNoise(pose=1e-3))
    assert calibrate(robot, made.measured, rough=0.02).status == "ok"


def test_plain_lines_have_no_guided_path() -> None:
    for name in ("wang2021", "cogiro"):
        made = simulate_calibration(load(name), 4, 0.0, seed=1)
        assert StraightProblem.of(load(name), made.measured).rows.guided is None
