"""Shared drums and counterweights in calibration: further sensors, load cells, effects, surveys, messages, drift."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from benchmarks.campaigns import calibrated_features as campaign

from cablewright.apps.serve.camera_folder import robot_text
from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.drift.drift import _Eliminated, _readings, _through, check_drift
from cablewright.calibration.drift.record import load_record, record_of, record_text
from cablewright.calibration.judgement.consistency import together
from cablewright.calibration.judgement.gross_errors import _rejected
from cablewright.calibration.judgement.model_doubt import stretch_of
from cablewright.calibration.judgement.unmodelled_effects import OF_A_LINE, corrections
from cablewright.calibration.measurement_rows.measurement_kinds import ON_ONE_DRUM
from cablewright.calibration.measurements import Measured, read_measured
from cablewright.calibration.plan import CalibrationPlan, Known, Point, Sigmas
from cablewright.calibration.poses.fit import PoseFit, fit
from cablewright.calibration.poses.problem import StraightProblem
from cablewright.calibration.poses.simulation import SensorNoise, simulate_calibration
from cablewright.calibration.poses.sufficient_data import check_lengths
from cablewright.foundation.errors import InputError
from cablewright.robot import Robot, loads, update
from physics.test_shared_winches import parallelograms

HUNG = campaign.hung_point()
PAIRS = campaign.pairs_of_lines()


def test_further_sensors_on_shared_drums_are_simulated_at_the_poses() -> None:
    made = simulate_calibration(PAIRS, 5, 0.0, seed=1, sensors=SensorNoise(swivel=0.0, tilt=0.0)).measured
    problem = StraightProblem.of(PAIRS, made)
    assert made.swivel is not None
    assert made.tilt is not None
    assert np.abs(made.swivel).min() > 0.1
    poses = simulate_calibration(PAIRS, 5, 0.0, seed=1).poses
    assert problem.derivatives(problem.start, poses).residual[:, -8:] == pytest.approx(np.zeros((5, 8)), abs=1e-9)


def weighed(plan: CalibrationPlan, count: int = 12) -> tuple[Measured, StraightProblem]:
    made = simulate_calibration(HUNG, count, 1e-4, seed=3, sensors=SensorNoise(pose=1e-4, tension=0.01))
    return made.measured, StraightProblem.of(HUNG, made.measured, plan)


@pytest.mark.parametrize(
    "plan",
    [
        CalibrationPlan(unknowns=("exit_point", "tension_scale", "tension_offset"),
                        shared=("tension_scale", "tension_offset")),
        CalibrationPlan(unknowns=("exit_point", "tension_scale"),
                        groups=({"name": "tension_scale", "lines": (HUNG.lines[0].name, "weight")},)),
        CalibrationPlan(known=(Known(name="tension_scale", value=1.1), Known(name="tension_offset", value=2.0))),
    ],
    ids=["shared", "group", "known"],
)  # fmt: skip
def test_the_weight_of_a_counterweight_passes_no_load_cell(plan: CalibrationPlan) -> None:
    _, problem = weighed(plan)
    theta = problem.free + 0.05 * np.array([each.name.startswith("tension_") for each in problem.free_unknowns])
    found = problem.tensions(theta)
    weight = (HUNG.lines[-1].counterweight or 0.0) * HUNG.scene.gravity
    assert found[:, -1] == pytest.approx(np.full(12, weight))
    assert not np.allclose(found[:, 0], problem.rows.tensions[:, 0])


def test_lengths_alone_are_fitted_from_the_numbers_that_all_rows_gave(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without tensions the exit point of the counterweight is none of their unknowns."""
    starts = []

    def noted(problem: StraightProblem, theta: np.ndarray, poses: np.ndarray) -> PoseFit:
        starts.append(dict(zip(problem.unknowns, theta.tolist(), strict=True)))
        assert (problem.limits[0] <= theta).all()
        assert (theta <= problem.limits[1]).all()
        return fit(problem, theta, poses)

    measured, problem = weighed(CalibrationPlan())
    found = fit(problem, problem.free, measured.guess)
    monkeypatch.setattr("cablewright.calibration.judgement.consistency.fit", noted)
    together(problem, found)
    whole = dict(zip(problem.unknowns, problem.whole(found.theta).tolist(), strict=True))
    assert starts[0] == {each: whole[each] for each in starts[0]}
    assert len(starts[0]) == len(whole) - 3


def test_the_drum_of_a_pair_is_one_effect_on_both_lines() -> None:
    made = simulate_calibration(PAIRS, 12, 1e-4, seed=1, sensors=SensorNoise(pose=1e-3))
    problem = StraightProblem.of(PAIRS, made.measured)
    found = corrections(problem, fit(problem, problem.free, made.poses))
    of_drums = {name: each for name, each in found.items() if name.startswith(OF_A_LINE)}
    assert [*of_drums] == [f"{OF_A_LINE}{name}" for name in ("0a", "1a", "2a")]
    for at, each in enumerate(of_drums.values()):
        own = slice(2 * at, 2 * at + 2)
        assert np.array_equal(each[:, own], made.measured.counted[:, own])
        assert np.abs(problem.in_lengths(each)[:, PAIRS.m :]).max() < 1e-12  # they stay tied


def test_a_surveyed_exit_point_of_a_counterweight_is_found() -> None:
    measured = simulate_calibration(HUNG, 30, 1e-4, seed=3, sensors=SensorNoise(pose=1e-4)).measured
    off = HUNG.exit_points
    off[-1] += [0.03, -0.02, 0.02]
    plan = CalibrationPlan(points=(Point(line="weight", at=tuple(HUNG.exit_points[-1].tolist())),))
    found = calibrate(HUNG.with_(exit_points=off), measured, plan, rough=0.05)
    assert found.robot.exit_points[-1] == pytest.approx(HUNG.exit_points[-1], abs=1e-4)
    assert not any("counterweight" in each for each in found.reasons)


@pytest.mark.parametrize("sensor", ["tensions", "frequencies"])
def test_tensions_measured_at_a_rigid_counterweight_are_rejected(sensor: str) -> None:
    measured, _ = weighed(CalibrationPlan())
    read = np.full((12, 5), np.nan)
    read[3, -1] = 50.0
    name = {"tensions": "f_5", "frequencies": "hz_5"}[sensor]
    with pytest.raises(InputError, match=f"{name}: line 'weight' has a counterweight, whose weight is its tension"):
        calibrate(HUNG, replace(measured, **{sensor: read}))


def test_mixed_units_name_the_columns_that_there_are() -> None:
    counted = np.tile([0.0, 0.0, 900.0, 900.0, 0.0, 0.0], (3, 1))
    with pytest.raises(InputError, match=r"dl_3 = 900 m.*\(mm\)'; dl_1, dl_5 look like m"):
        check_lengths(PAIRS, Measured(counted))


@pytest.mark.parametrize(
    ("robot", "text", "why"),
    [
        (PAIRS, "dl_1,dl_2 (mm),dl_3,dl_5\n", "line '0b' is on the drum of '0a'"),
        (PAIRS, "dl_1,dl_5\n", "no column 'dl_3'; expected dl_1, dl_3 and dl_5, one for each winch"),
        (HUNG, "dl_1,dl_2,dl_3\n", "no column 'dl_4'; expected dl_1 to dl_4, one for each winch"),
        (PAIRS, "", "columns dl_1, dl_3 and dl_5, then rows"),
    ],
)
def test_messages_name_the_columns_of_winches(robot: Robot, text: str, why: str, tmp_path: Path) -> None:
    file = tmp_path / "d.csv"
    file.write_text(text)
    with pytest.raises(InputError, match=why):
        read_measured(file, robot)


@pytest.mark.parametrize(("robot", "winches"), [(PAIRS, (0, 2, 4)), (HUNG, (0, 1, 2, 3))])
def test_a_pose_left_out_shows_what_its_winches_counted(robot: Robot, winches: tuple[int, ...]) -> None:
    made = simulate_calibration(robot, 12, 1e-4, seed=1, sensors=SensorNoise(pose=1e-3))
    problem = StraightProblem.of(robot, made.measured)
    rows = np.zeros((12, problem.per_pose), dtype=bool)
    rows[4] = True
    (found,) = _rejected(problem, fit(problem, problem.free, made.poses), rows)
    assert found.measured == tuple(made.measured.counted[4, list(winches)])
    assert len(found.expected) == len(winches)


def test_tensions_after_a_calibration_without_them_are_rejected(tmp_path: Path) -> None:
    made = simulate_calibration(HUNG, 30, 1e-4, seed=3, sensors=SensorNoise(pose=1e-3, tension=0.1)).measured
    file = tmp_path / "d.csv"
    file.touch()
    found = calibrate(HUNG, replace(made, tensions=None), CalibrationPlan(sigma=Sigmas(encoder=1e-4)), rough=0.05)
    record = record_of(found, file, datetime(2026, 11, 30, tzinfo=UTC))
    with pytest.raises(InputError, match="the record knows nothing of line 'weight', whose counterweight"):
        check_drift(found.robot, made, record)


def with_dead_spans(error: np.ndarray, more: float, raised: bool = False) -> Robot:
    """The pairs, with cable before the exit points of two: *error* (m, 3) of these, *more* on the offsets, m.

    *raised*: the height of the winch exit is as wrong as that of the exit point.
    """
    offsets = {"0b": 0.3, "1b": -0.9, "2b": 0.0}
    lines = []
    for line, (x, y, z) in zip(PAIRS.lines, PAIRS.exit_points + error, strict=True):
        update: dict[str, object] = {"exit_point": (x, y, z)}
        if line.name == "1a":
            update["winch_exit"] = (x, y, (z if raised else line.exit_point[2]) - 0.9)
        if line.shared_winch is not None:
            offset = offsets[line.name] + more
            update["shared_winch"] = line.shared_winch.model_copy(update={"offset": offset})
        update["dead_length"] = 0.3 if line.name == "0b" else 0.0
        lines.append(line.model_copy(update=update))
    return Robot.model_validate(PAIRS.model_copy(update={"lines": tuple(lines)}).model_dump())


@pytest.mark.parametrize("cable", ["rigid", "elastic"])
def test_the_calibrated_robot_has_the_offsets_of_its_drums(cable: str) -> None:
    """Whole lengths, with the cable before the exit points; those of the file are 20 mm off."""
    robot = with_dead_spans(np.zeros((6, 3)), 0.0)
    sensors = SensorNoise(pose=0.0, tension=None if cable == "rigid" else 0.0)
    made = simulate_calibration(robot, 20, 0.0, seed=2, cable=cable, sensors=sensors)
    file = with_dead_spans(np.random.default_rng(4).uniform(-5e-3, 5e-3, (6, 3)), 0.02, cable == "elastic")
    plan = CalibrationPlan(sigma=Sigmas(encoder=1e-6, tension=1e-3))
    found = calibrate(file, made.measured, plan, cable=cable, rough=0.02, outliers=False)
    assert found.status == "ok"
    of = [[line.shared_winch.offset for line in each.sharing if line.shared_winch] for each in (found.robot, robot)]
    assert of[0] == pytest.approx(of[1], abs=1e-4)
    assert loads(update(robot_text(file), found.robot)).sharing == found.robot.sharing


def test_lines_stay_tied_to_a_tenth_of_the_encoders_sigma_that_is_found() -> None:
    robot = parallelograms(4)
    measured = simulate_calibration(robot, 40, 1e-3, seed=1, guess=1e-3, sensors=SensorNoise(pose=1e-3)).measured
    problem = calibrate(robot, measured, rough=0.02, outliers=False).problem
    assert problem.found_encoder == pytest.approx(1e-3, rel=0.3)
    tied = problem.of_poses(problem.weights)[:, robot.m : problem.lengths_per_pose]
    wanted = problem.factors[ON_ONE_DRUM] * 0.1 * problem.encoder_sigma
    assert 1.0 / tied == pytest.approx(np.full(tied.shape, wanted))


def test_a_record_has_the_sigma_of_lines_on_one_drum(tmp_path: Path) -> None:
    """By which later measurements are weighed; such rows are no readings that may be wrong."""
    measured = simulate_calibration(PAIRS, 30, 1e-4, seed=1, sensors=SensorNoise(pose=1e-3)).measured
    found = calibrate(PAIRS, measured, CalibrationPlan(sigma=Sigmas(encoder=1e-4)), rough=0.02, outliers=False)
    found = replace(found, problem=replace(found.problem, factors={ON_ONE_DRUM: 5.0}))
    file = tmp_path / "d.toml"
    file.touch()
    file.write_text(record_text(record_of(found, file, datetime(2026, 11, 30, tzinfo=UTC))))
    problem = StraightProblem.of(found.robot, measured)
    again = load_record(file).weighed(problem)
    ratio = problem.of_poses(problem.weights)[:, PAIRS.m :] / again.of_poses(again.weights)[:, PAIRS.m :]
    assert (ratio == np.repeat([5.0, 1.0], [3, problem.per_pose - PAIRS.m - 3])).all()
    eliminated = _Eliminated.of(again, again.derivatives(again.free, found.poses), False)
    assert not any(ON_ONE_DRUM in each.what for each in _readings(again, eliminated))


def test_a_stretch_changes_a_drift_check_as_counts_longer_by_it_do() -> None:
    """Counts that are longer by it change the numbers as much, the other way; also between lines on one drum."""
    made = simulate_calibration(PAIRS, 8, 1e-4, seed=1, sensors=SensorNoise(pose=1e-3))
    problem = StraightProblem.of(PAIRS, made.measured)
    stretch = stretch_of(problem, problem.free, made.poses)
    assert stretch is not None
    more = StraightProblem.of(PAIRS, replace(made.measured, counted=made.measured.counted + stretch))
    rows, longer = (each.derivatives(problem.free, made.poses) for each in (problem, more))
    eliminated = _Eliminated.of(problem, rows, False)
    by_counts = eliminated.turned @ (rows.residual - longer.residual).ravel()
    assert np.abs(by_counts).max() > 1.0
    assert _through(problem, problem.free, made.poses, eliminated)[:, -1] == pytest.approx(by_counts)
