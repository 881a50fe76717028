"""Checks of a calibrated robot by later measurements, and calibrations beside the one before."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

import cablewright as cw
from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.drift.record import (
    CalibrationRecord,
    compared,
    load_record,
    record_of,
    record_path,
    record_text,
)
from cablewright.calibration.judgement.likely_changes import Evidence, Suspect
from cablewright.calibration.measurements import Measured, write_measured
from cablewright.calibration.plan import CalibrationPlan, Point, Sigmas
from cablewright.calibration.poses.simulation import SensorNoise, measure, random_poses
from cablewright.foundation.errors import InputError
from cablewright.models.drum import WinchDrum
from cablewright.robot import load

WANG, COGIRO = load("wang2021"), load("cogiro")
DAY = datetime(2026, 3, 1, 8, 0, tzinfo=UTC)
LATER = 8


def part(measured: Measured, rows: slice) -> Measured:
    guess = None if measured.guess is None else measured.guess[rows]
    tensions = None if measured.tensions is None else measured.tensions[rows]
    return replace(measured, counted=measured.counted[rows], guess=guess, tensions=tensions)


class Machine:
    """A robot that was calibrated, and later measurements of it."""

    def __init__(self, robot: cw.Robot, folder: Path, seed: int = 1) -> None:
        rng = np.random.default_rng(seed)
        made = measure(robot, random_poses(robot, 40 + LATER, rng), 1e-4, rng).measured
        self.file = folder / "d.csv"
        self.file.write_text(write_measured(part(made, slice(40)), robot))
        self.plan = CalibrationPlan(points=tuple(Point(line=line.name, at=line.exit_point) for line in robot.lines[:3]))
        self.found = calibrate(robot, self.file, self.plan, need=0.05)
        self.record = record_of(self.found, self.file, DAY)
        self.later = part(made, slice(40, None))
        self.robot = self.found.robot

    def check(self, off: np.ndarray | float = 0.0, **options: object) -> cw.Drift:
        later = replace(self.later, counted=self.later.counted + off)
        return cw.check_drift(self.robot, later, self.record, **options)


@pytest.fixture(scope="module")
def wang(tmp_path_factory) -> Machine:
    return Machine(WANG, tmp_path_factory.mktemp("wang"))


@pytest.fixture(scope="module")
def cogiro(tmp_path_factory) -> Machine:
    return Machine(COGIRO, tmp_path_factory.mktemp("cogiro"))


def test_where_nothing_moved_nothing_is_said(wang: Machine, cogiro: Machine) -> None:
    for machine in (wang, cogiro):
        found = machine.check()
        assert (found.verdict, found.refusal, found.changes) == ("unchanged", "", ())
        assert found.redundancy == LATER * (machine.robot.m - machine.robot.n)
        for line in found.lines:
            assert abs(line.change) < 4.0 * line.sigma
            assert line.detectable > 3.0 * line.sigma


@pytest.mark.parametrize("line", range(4))
def test_a_line_that_slipped_is_named_with_its_amount(wang: Machine, line: int) -> None:
    found = wang.check(-6e-3 * np.eye(4)[line])
    (change,) = found.changes
    assert (found.verdict, change.what, change.line) == ("moved", "length", WANG.lines[line].name)
    assert change.amount == pytest.approx(6e-3, abs=4.0 * change.sigma)
    assert change.sigma < 1e-3
    assert f"moved: length of {change.line} by +" in found.refusal


@pytest.mark.parametrize("line", [0, 5])
def test_an_exit_point_that_moved_is_named_with_its_vector(cogiro: Machine, line: int) -> None:
    moved = np.array([0.02, -0.015, 0.01])
    lines = list(COGIRO.lines)
    exit_point = tuple((np.array(lines[line].exit_point) + moved).tolist())
    lines[line] = lines[line].model_copy(update={"exit_point": exit_point})
    later = COGIRO.model_copy(update={"lines": tuple(lines)})
    rng = np.random.default_rng(9)
    poses = np.concatenate([random_poses(COGIRO, 48, np.random.default_rng(1))[:1], random_poses(later, 14, rng)])
    made = measure(later, poses, 1e-4, rng)  # lengths count from where they were 0: at the first pose
    homes = {each.line: at for at, each in enumerate(cogiro.found.unknowns) if each.name == "length_offset"}
    true_home = measure(COGIRO, random_poses(COGIRO, 48, np.random.default_rng(1))[:1], 0.0, rng).home_lengths
    counted = made.measured.counted + made.home_lengths - true_home
    assert len(homes) == 8
    data = replace(made.measured, counted=counted)
    found = cw.check_drift(cogiro.robot, data, cogiro.record)
    (change,) = found.changes
    assert (found.verdict, change.line) == ("moved", COGIRO.lines[line].name)
    assert "exit point" in change.what
    assert np.array(change.vector[:3]) == pytest.approx(moved, abs=5e-3)


def test_longer_lengths_of_all_lines_are_one_change(cogiro: Machine) -> None:
    (change,) = cogiro.check(-2e-3 * cogiro.later.counted).changes  # counts are short of the length paid out
    assert (change.what, change.line, change.unit) == ("scale of all lengths", None, "1")
    assert change.amount == pytest.approx(2e-3, abs=4.0 * change.sigma)


def test_one_wrong_reading_is_no_move(cogiro: Machine, wang: Machine) -> None:
    off = np.zeros((LATER, 8))
    off[3, 2] = 0.05
    found = cogiro.check(off)
    (change,) = found.changes
    assert (found.verdict, change.pose) == ("wrong-reading", 3)
    name = COGIRO.lines[2].name  # of two numbers over, in some directions of two lines
    assert change.line == name or any(f"of {name}, pose 4" in each for each in change.instead)
    found = wang.check(off[:, :4])  # one number over each pose: its line cannot be identified
    assert (found.verdict, found.changes[0].pose, found.changes[0].line) == ("wrong-reading", 3, None)


def test_a_new_home_hides_lengths_but_no_exit_point(wang: Machine) -> None:
    anew = 0.3 + 0.1 * np.arange(4.0)
    assert wang.check(anew).verdict == "moved"
    assert "--new-home" in " ".join(wang.check(anew).notes)
    found = wang.check(anew, new_home=True)
    assert (found.verdict, found.lines) == ("unchanged", ())
    assert wang.check(-4e-3 * wang.later.counted * np.eye(4)[0], new_home=True).verdict == "moved"


def test_start_values_are_not_needed(wang: Machine) -> None:
    with_guess = wang.check(6e-3 * np.eye(4)[1])
    without = cw.check_drift(
        wang.robot,
        replace(wang.later, counted=wang.later.counted + 6e-3 * np.eye(4)[1], guess=None),
        wang.record,
    )
    assert without.changes[0].amount == pytest.approx(with_guess.changes[0].amount, abs=1e-7)


def test_lines_that_stretch_are_checked_by_their_tensions(tmp_path: Path) -> None:
    robot, rng = load("paty2021"), np.random.default_rng(4)
    made = measure(robot, random_poses(robot, 30, rng, "elastic"), 1e-4, rng, cable="elastic",
                   sensors=SensorNoise(tension=5.0)).measured  # fmt: skip
    file = tmp_path / "e.csv"
    file.write_text(write_measured(part(made, slice(22)), robot))
    plan = CalibrationPlan(sigma=Sigmas(encoder=1e-4, tension=5.0))
    found = calibrate(robot, file, plan, cable="elastic", rough=0.05, need=0.5)
    record = record_of(found, file, DAY)
    later = part(made, slice(22, None))
    assert cw.check_drift(found.robot, later, record).verdict == "unchanged"
    counted = later.counted - 0.05 * np.eye(4)[2]
    changed = cw.check_drift(found.robot, replace(later, counted=counted), record)
    assert changed.verdict == "moved"
    assert any(robot.lines[2].name in (each.line, *each.instead) or each.line is None for each in changed.changes)


def test_lines_that_stretch_are_checked_by_their_frequencies(tmp_path: Path) -> None:
    robot, file, sensors = load("merlet2023"), tmp_path / "e.csv", SensorNoise(frequency=0.02)
    whole = cw.simulate_calibration(robot, 38, 1e-4, seed=4, cable="elastic", sensors=sensors).measured
    made, later = (whole.only(each) for each in (np.arange(38) < 30, np.arange(38) >= 30))
    file.write_text(write_measured(made, robot))
    plan = CalibrationPlan(sigma=Sigmas(encoder=1e-4, frequency=0.02))
    found = calibrate(robot, file, plan, cable="elastic", rough=0.02, need=0.5)
    record = record_of(found, file, DAY)
    assert record.sigma.frequency == pytest.approx(0.02, rel=0.5)
    assert cw.check_drift(found.robot, later, record).verdict == "unchanged"
    slipped = replace(later, counted=later.counted - 0.05 * np.eye(4)[2])
    assert cw.check_drift(found.robot, slipped, record).verdict == "moved"
    with pytest.raises(InputError, match=r"hz_1 \.\. require columns x,y,z"):
        cw.check_drift(found.robot, replace(later, guess=None), record)


def test_a_spool_that_builds_up_passes_its_own_check(tmp_path: Path) -> None:
    """With a drum that is 2 % larger than in the file: later counts are of its radius, the build-up of true metres."""
    true = WinchDrum(0.0612, build_up=0.01)
    lines = tuple(
        line.model_copy(update={"winch": line.winch.model_copy(update={"drum_radius": 0.06})}) for line in WANG.lines
    )
    robot = WANG.model_copy(update={"lines": lines})
    rng = np.random.default_rng(6)
    poses = random_poses(robot, 60, rng)
    made = measure(robot, poses, 1e-4, rng).measured
    turns = true.angles(made.counted) / (2.0 * np.pi)
    file = tmp_path / "d.csv"
    header = ",".join([*(f"dl_{i + 1} (turns)" for i in range(4)), "x,y,z,sigma_x,sigma_y,sigma_z"])
    table = np.column_stack([turns, poses + rng.normal(0.0, 1e-3, poses.shape), np.full(poses.shape, 1e-3)])
    np.savetxt(file, table, "%.12g", ",", header=header, comments="")
    unknowns = ("exit_point", "length_offset", "drum_radius", "build_up")
    found = calibrate(robot, file, CalibrationPlan(unknowns=unknowns, shared=unknowns[2:]), rough=0.05)
    for at, wanted in ((-2, true.radius), (-1, true.build_up)):
        assert abs(found.values[at] - wanted) < 4.0 * found.sigma[at] < 0.1 * wanted
    record = record_of(found, file, DAY)
    assert cw.check_drift(found.robot, file, record).verdict == "unchanged"


def test_false_alarms_are_as_rare_as_was_asked() -> None:
    """Numbers with the given covariance: the share of alarms is under the level, and not far under it."""
    rng, count, level = np.random.default_rng(0), 400, 0.05
    root = rng.normal(size=(12, 12))
    suspects = [Suspect("x", str(at), rng.normal(size=(12, 1 + at % 3))) for at in range(6)]
    alarms = 0
    for _ in range(count):
        seen = Evidence(root @ rng.normal(size=12), root @ root.T, suspects, np.inf)
        alarms += seen.explained(level).probability < level
    assert stats.binomtest(alarms, count, level, alternative="greater").pvalue > 1e-3
    assert alarms > 0.2 * level * count


def test_a_record_survives_its_file(wang: Machine, tmp_path: Path) -> None:
    file = tmp_path / "r.calibration.toml"
    file.write_text(record_text(wang.record))
    again = load_record(file)
    assert again == wang.record
    assert again.sha256 == hashlib.sha256(wang.file.read_bytes()).hexdigest()
    assert np.array_equal(again.spread, again.spread.T)
    assert record_path("a/mine.toml") == Path("a/mine.calibration.toml")
    k = len(wang.found.unknowns)
    assert again.spread[:k, :k] == pytest.approx(wang.found.covariance)


def test_a_record_of_another_robot_is_rejected(wang: Machine, cogiro: Machine) -> None:
    with pytest.raises(InputError, match=r"exit point x of south-west is .* give the file that this calibration wrote"):
        cw.check_drift(WANG, wang.later, wang.record)
    with pytest.raises(InputError, match="values are not those of"):
        cw.check_drift(cogiro.robot, cogiro.later, wang.record)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (("covariance = [[", "covariance = [[1.0], ["), "covariance"),
        (('sha256 = "', 'sha256 = "z'), "sha256"),
        (("poses = 40", "poses = -4"), "poses"),
        (("poses = 40", "poses = nan"), "poses"),
        (("schema = 1", "schema = 9"), "schema"),
    ],
)
def test_damaged_records_are_rejected_in_a_line(wang: Machine, tmp_path: Path, change, told: str) -> None:
    file = tmp_path / "bad.toml"
    file.write_text(record_text(wang.record).replace(*change, 1))
    with pytest.raises(InputError, match=told) as error:
        load_record(file)
    assert "\n" not in str(error.value)
    assert str(file) in str(error.value)


def test_a_calibration_is_compared_with_the_one_before(wang: Machine) -> None:
    again = calibrate(wang.robot, measure(WANG, random_poses(WANG, 40, np.random.default_rng(5)), 1e-4,
                                          np.random.default_rng(6)).measured, wang.plan, need=0.05)  # fmt: skip
    same = compared(again, wang.record)
    assert same.changes == ()
    assert same.probability > 0.01
    lines = list(WANG.lines)
    away = tuple((np.array(lines[2].exit_point) + np.array([0.06, 0.04, -0.05])).tolist())
    lines[2] = lines[2].model_copy(update={"exit_point": away})
    moved = WANG.model_copy(update={"lines": tuple(lines)})
    rng = np.random.default_rng(7)
    plan = CalibrationPlan(points=tuple(Point(line=line.name, at=line.exit_point) for line in moved.lines[:3]))
    other = calibrate(wang.robot, measure(moved, random_poses(moved, 40, rng), 1e-4, rng).measured, plan, need=0.05)
    found = compared(other, wang.record)
    assert found.probability < 1e-6
    assert (found.changes[0].what, found.changes[0].line) == ("exit point", WANG.lines[2].name)
    assert found.changes[0].amount == pytest.approx(np.linalg.norm([0.06, 0.04, -0.05]), abs=0.01)


def test_a_record_of_the_first_format_is_read_and_checked_against() -> None:
    """Robot and record were written by ``calibrate`` when the format was new: 30 poses, tensions and swivel angles."""
    folder = Path(__file__).parent / "records"
    robot, record = cw.load(folder / "robot.toml"), load_record(folder / "robot.calibration.toml")
    head = record.robot, record.verdict, record.cable.value, record.redundancy
    assert head == ("wang2021", "doubtful", "rigid", 227)
    assert record.sigma.encoder == pytest.approx(9.604e-5, rel=1e-3)
    assert load_record(folder / "robot.calibration.toml") == CalibrationRecord.model_validate(record.model_dump())
    made = cw.simulate_calibration(robot, 8, 1e-4, seed=9, sensors=SensorNoise(tension=2.0, swivel=1e-3))
    home = [each.value for each in record.values if each.name == "length_offset"]
    later = replace(made.measured, counted=made.measured.counted + made.home_lengths - home)
    assert cw.check_drift(robot, later, record).verdict == "unchanged"
    slipped = replace(later, counted=later.counted - [0.0, 0.0, 0.01, 0.0])
    found = cw.check_drift(robot, slipped, folder / "robot.calibration.toml")
    (change,) = found.changes
    assert (found.verdict, change.what, change.line) == ("moved", "length", "north-east")
    assert (change.amount, change.sigma) == pytest.approx((0.010060281755681504, 0.00010549774127586814), rel=1e-5)
