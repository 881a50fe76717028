"""Sensors with wrong zeros: offsets and scales are found, separated from the frame, and named as reasons."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.drift.drift import check_drift
from cablewright.calibration.drift.record import compared, load_record, record_of, record_text
from cablewright.calibration.guidance.guided_calibration import guide
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.measurements import Measured, read_measured, write_measured
from cablewright.calibration.plan import Bound, CalibrationPlan, Prior, Sigmas
from cablewright.calibration.poses.simulation import SensorNoise, aligned, simulate_calibration
from cablewright.foundation.errors import InputError
from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import Robot, load
from cablewright.solvers.inverse import solve_inverse
from cases import often

WANG, PATY, COGIRO = load("wang2021"), load("paty2021"), load("cogiro")
PLAIN = ("exit_point", "length_offset")
ZEROS = np.array([0.3, -2.0, 1.0, 3.0])  # rad, of swivels
CELLS = np.array([6.0, -40.0, 20.0, 60.0])  # N
GAINS = np.array([1.05, 0.95, 1.1, 0.9])
CALIBRATED = Sigmas(encoder=1e-4, tension=5.0)


def made(robot: Robot, seed: int = 1, cable: str | None = None, poses: int = 40, **noise: float) -> Measured:
    return simulate_calibration(robot, poses, 1e-4, seed=seed, cable=cable, sensors=SensorNoise(**noise)).measured


def turned(measured: Measured, zeros: np.ndarray = ZEROS) -> Measured:
    assert measured.swivel is not None
    return replace(measured, swivel=measured.swivel - zeros)


def strained(measured: Measured, gains: np.ndarray = GAINS) -> Measured:
    """The readings of load cells with errors of zero and scale."""
    assert measured.tensions is not None
    return replace(measured, tensions=(measured.tensions - CELLS) / gains)


def found_of(found: Calibration, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Values and sigmas of an unknown."""
    which = [each.name == name for each in found.unknowns]
    return found.values[which], found.sigma[which]


def off(found: Calibration) -> float:
    """The largest error of a coordinate of an exit point over its sigma, after the best translation and yaw."""
    file = np.array([line.exit_point for line in found.problem.robot.lines])
    points, _ = aligned(found.problem.points(found.fit.theta), file)
    return float(np.abs((points - file).ravel() / found_of(found, "exit_point")[1]).max())


@pytest.mark.parametrize("guessed", [True, False], ids=["start values", "no start values"])
def test_zeros_of_swivels_anywhere_are_found(guessed: bool) -> None:
    """Some of 3 rad, with and without start values of the poses; the direction of the frame is open then."""
    measured = turned(made(WANG, swivel=1e-3))
    plan = CalibrationPlan(unknowns=(*PLAIN, "swivel_offset"))
    found = calibrate(WANG, measured if guessed else replace(measured, guess=None), plan, rough=0.05)
    values, sigma = found_of(found, "swivel_offset")
    assert found.verdict == "good"
    assert found.gauge == ("translation along x", "translation along y", "translation along z", "yaw")
    assert np.abs(values - ZEROS).max() < 4.0 * sigma.max() < 2e-3
    assert off(found) < 4.0
    assert found.robot.lines[0].name == "south-west"  # offsets are no keys of it: nothing to write


def test_swivels_zeroed_together_have_one_offset() -> None:
    plan = CalibrationPlan(unknowns=(*PLAIN, "swivel_offset"), shared=("swivel_offset",))
    found = calibrate(WANG, turned(made(WANG, swivel=1e-3), np.full(4, 0.2)), plan, rough=0.05)
    values, sigma = found_of(found, "swivel_offset")
    assert values == pytest.approx([0.2], abs=4.0 * float(sigma[0]))
    assert [each.label for each in found.unknowns][-1] == "swivel offset of all lines"


def test_a_zero_that_has_an_error_is_named_where_it_counts_as_exact() -> None:
    found = calibrate(WANG, turned(made(WANG, swivel=1e-3), 0.01 * ZEROS), rough=0.05)
    assert found.verdict == "bad"
    assert any("if their zero is not sure, add swivel_offset to the unknowns" in each for each in found.reasons)
    assert {each.name for each in found.doubt.considered} >= {"swivel_offset"}


def test_swivels_that_count_the_other_way_are_named() -> None:
    measured = turned(made(WANG, swivel=1e-3))
    assert measured.swivel is not None
    plan = CalibrationPlan(unknowns=(*PLAIN, "swivel_offset"))
    found = calibrate(WANG, replace(measured, swivel=-measured.swivel), plan, rough=0.05)
    assert found.verdict == "bad"
    assert found.reasons[0].startswith("all swivel angles with the other sign would explain the data far better")


@pytest.mark.parametrize(("robot", "cable"), [(WANG, None), (PATY, "catenary")], ids=["straight", "catenary"])
def test_load_cells_with_offsets_and_scales(robot: Robot, cable: str | None) -> None:
    plan = CalibrationPlan(unknowns=(*PLAIN, "tension_offset", "tension_scale"), sigma=CALIBRATED)
    found = calibrate(robot, strained(made(robot, cable=cable, tension=2.0)), plan, cable=cable, rough=0.05)
    assert found.status == "ok"
    for name, true in (("tension_offset", CELLS), ("tension_scale", GAINS)):
        values, sigma = found_of(found, name)
        assert np.abs((values - true) / sigma).max() < 4.0
    assert found_of(found, "tension_scale")[1].max() < 0.06
    assert off(found) < 4.0


def test_scales_of_load_cells_are_not_biased_by_noise() -> None:
    """A smaller scale makes the noise of readings small: of rows that are not over the scale all come out too small."""
    plan = CalibrationPlan(unknowns=(*PLAIN, "tension_offset", "tension_scale"), sigma=CALIBRATED)
    pulls = []
    for seed in range(often(5, 12)):
        found = calibrate(WANG, strained(made(WANG, seed, tension=4.0)), plan, rough=0.05, outliers=False)
        values, sigma = found_of(found, "tension_scale")
        pulls.append(np.mean((values - GAINS) / sigma))
    assert abs(np.mean(pulls)) < 0.5


def test_tilt_and_yaw_with_offsets() -> None:
    measured = made(COGIRO, tilt=1e-3, yaw=1e-2)
    assert measured.tilt is not None
    assert measured.yaw is not None
    wrong = replace(measured, tilt=measured.tilt - [0.02, -0.03], yaw=measured.yaw - 2.5)
    plan = CalibrationPlan(unknowns=(*PLAIN, "tilt_offset", "yaw_offset"))
    found = calibrate(COGIRO, wrong, plan, rough=0.05, outliers=False)
    assert "yaw" in found.gauge
    for name, true in (("tilt_offset", [0.02, -0.03]), ("yaw_offset", [2.5])):
        values, sigma = found_of(found, name)
        assert np.abs((values - true) / sigma).max() < 4.0
    assert [each.label for each in found.unknowns][-3:] == ["tilt offset x", "tilt offset y", "yaw offset"]


def test_an_exact_yaw_determines_the_direction_of_the_frame() -> None:
    found = calibrate(COGIRO, made(COGIRO, poses=20, yaw=1e-3), rough=0.05, outliers=False)
    assert found.gauge == ("translation along x", "translation along y", "translation along z")


def test_an_offset_and_a_tilt_of_eyelets_are_hardly_distinguished_until_they_are_levelled() -> None:
    """By the platform's rotations alone, of a tenth of a radian."""
    jung = load("jung2020")
    measured = made(jung, poses=20, tilt=1e-3)
    sigmas = []
    for level in (None, 1e-3):
        plan = CalibrationPlan(unknowns=(*PLAIN, "tilt_offset"), level=level)
        found = calibrate(jung, measured, plan, rough=0.02, outliers=False)
        values, sigma = found_of(found, "tilt_offset")
        assert np.abs(values / sigma).max() < 4.0
        sigmas.append(float(sigma.max()))
    assert sigmas[0] > 5e-3
    assert sigmas[1] < 1.5e-3


def test_the_guide_does_not_take_unknown_zeros_for_known() -> None:
    """Before there are enough poses, counts to move to come from lengths; they were wrong by 184 mm."""
    simulated = simulate_calibration(WANG, 6, 1e-5, seed=1, guess=1e-3, sensors=SensorNoise(swivel=1e-3))
    measured = turned(simulated.measured, np.array([5.5, 1.0, 3.0, 0.2]))
    advice = guide(WANG, measured, CalibrationPlan(unknowns=(*PLAIN, "swivel_offset")))
    model = Model(WANG, Fidelity.of("rigid"))
    home = solve_inverse(model, simulated.poses[:1]).lengths[0]
    assert advice.next_poses
    for each in advice.next_poses:
        lengths = solve_inverse(model, np.array([each.pose])).lengths[0]
        assert each.counts == pytest.approx(lengths - home, abs=1e-3)


def test_a_prior_holds_an_offset() -> None:
    plan = CalibrationPlan(
        unknowns=(*PLAIN, "tension_offset"),
        sigma=CALIBRATED,
        priors=(Prior(name="tension_offset", deviation=0.01),),
    )
    values, _ = found_of(calibrate(WANG, made(WANG, tension=2.0), plan, rough=0.05), "tension_offset")
    assert np.abs(values).max() < 0.03


def test_later_data_are_checked_with_the_offsets_that_were_found(tmp_path: Path) -> None:
    """And without the sensor too; a zero that moved since is found."""
    file = tmp_path / "d.csv"
    file.write_text(write_measured(turned(made(WANG, swivel=1e-3)), WANG), encoding="utf-8")
    plan = CalibrationPlan(unknowns=(*PLAIN, "swivel_offset"), sigma=Sigmas(encoder=1e-4, swivel=1e-3))
    found = calibrate(WANG, file, plan, rough=0.05)
    record = tmp_path / "r.toml"
    record.write_text(record_text(record_of(found, file, datetime.now(UTC))), encoding="utf-8")
    known = load_record(record)
    whole = made(WANG, 1, poses=40, swivel=1e-3)
    assert whole.guess is not None
    assert whole.swivel is not None
    later = Measured(whole.counted[:8], whole.guess[:8], swivel=whole.swivel[:8])
    assert check_drift(found.robot, turned(later), known).verdict == "unchanged"
    assert check_drift(found.robot, replace(later, swivel=None), known).verdict == "unchanged"
    assert check_drift(found.robot, turned(later, ZEROS + 0.05 * np.eye(4)[1]), known).verdict != "unchanged"


def test_a_zero_that_moved_between_two_calibrations_is_named_with_its_unit(tmp_path: Path) -> None:
    """The same zeros, found a turn away, are the same."""
    plan = CalibrationPlan(unknowns=(*PLAIN, "swivel_offset"), sigma=Sigmas(encoder=1e-4, swivel=1e-3))
    file, found = tmp_path / "d.csv", []
    for seed, zeros in (
        (1, [0.3, -2.0, 1.0, 3.13]),
        (2, [0.3, -2.0, 1.0, 3.13 - 2.0 * np.pi]),
        (2, [0.3, -1.9, 1.0, 3.13]),
    ):
        measured = turned(made(WANG, seed, swivel=1e-3), np.array(zeros))
        file.write_text(write_measured(measured, WANG), encoding="utf-8")
        found.append(calibrate(WANG, measured, plan, rough=0.05))
    record = record_of(found[0], file, datetime.now(UTC))
    assert not compared(found[1], record).changes
    moved = compared(found[2], record).changes
    assert [(each.what, each.line, each.unit) for each in moved] == [("swivel offset", "south-east", "rad")]
    assert moved[0].amount == pytest.approx(0.1, abs=5e-3)


def test_load_cells_set_to_zero_under_a_load_are_found() -> None:
    """Offsets larger than any reading; the line's max tension limits them."""
    measured = made(WANG, tension=2.0)
    assert measured.tensions is not None
    zeros = measured.tensions.max(axis=0)
    low = replace(measured, tensions=measured.tensions - zeros)
    plan = CalibrationPlan(unknowns=(*PLAIN, "tension_offset"), sigma=CALIBRATED)
    found = calibrate(WANG, low, plan, rough=0.05)
    values, sigma = found_of(found, "tension_offset")
    assert found.status == "ok"
    assert np.abs((values - zeros) / sigma).max() < 4.0
    assert (zeros > np.ptp(measured.tensions, axis=0)).any()


def test_bounds_of_an_azimuth_may_be_any_turn() -> None:
    """The zero of 0.3 rad is 0.3 rad and a turn within these."""
    bound = Bound(name="swivel_offset", lines=("south-west",), min=5.0, max=8.0)
    plan = CalibrationPlan(unknowns=(*PLAIN, "swivel_offset"), bounds=(bound,))
    found = calibrate(WANG, turned(made(WANG, swivel=1e-3)), plan, rough=0.05)
    assert found.verdict == "good"
    assert found_of(found, "swivel_offset")[0] - ZEROS == pytest.approx([2.0 * np.pi, 0.0, 0.0, 0.0], abs=5e-3)


def test_a_gyro_that_was_set_to_zero_at_home_is_named_and_its_own_data_pass(tmp_path: Path) -> None:
    """It turns the whole frame, so start values of the poses are of another one."""
    measured, angle = made(COGIRO, poses=20, yaw=1e-2), -2.5
    assert measured.yaw is not None
    wrong = replace(measured, yaw=measured.yaw - angle)
    found = calibrate(COGIRO, wrong, rough=0.05, outliers=False, need=0.5)
    assert found.verdict == "doubtful"
    assert len(found.reasons) == 1
    told = found.reasons[0].removeprefix("readings of yaw turn the whole frame by ").partition(" deg")[0]
    assert float(told) == pytest.approx(-np.degrees(angle), abs=1.0)
    assert "add yaw_offset to the unknowns" in found.reasons[0]
    file = tmp_path / "d.csv"
    file.write_text(write_measured(wrong, COGIRO), encoding="utf-8")
    assert check_drift(found.robot, wrong, record_of(found, file, datetime.now(UTC))).verdict == "unchanged"


def test_a_sensor_that_the_calibration_lacked_is_known_to_its_sigma(tmp_path: Path) -> None:
    file = tmp_path / "d.csv"
    whole = made(WANG, swivel=1e-3)
    file.write_text(write_measured(replace(whole, swivel=None), WANG), encoding="utf-8")
    sigma = Sigmas(encoder=1e-4, swivel=1e-2)
    found = calibrate(WANG, file, CalibrationPlan(sigma=sigma), rough=0.05)
    record = record_of(found, file, datetime.now(UTC))
    zeros = 1e-2 * np.array([1.0, -1.0, -1.0, 1.0])
    later = check_drift(found.robot, turned(whole, zeros), record)
    assert later.verdict == "unchanged"
    assert later.notes[0].startswith("the calibration did not have these sensors: swivel_offset count as known")
    assert check_drift(found.robot, turned(whole, 10.0 * zeros), record).verdict == "moved"


def test_zeros_without_data_need_no_more_poses() -> None:
    plans = [CalibrationPlan(unknowns=names) for names in (PLAIN, (*PLAIN, "swivel_offset"))]
    plain, more = (len(guide(WANG, plan=plan, rough=0.05).next_poses) for plan in plans)
    assert more == plain


def test_an_end_of_a_range_may_come_from_wrong_zeros() -> None:
    plan = CalibrationPlan(
        unknowns=(*PLAIN, "sheave_radius"), bounds=(Bound(name="sheave_radius", min=0.074, max=0.0756),)
    )
    found = calibrate(WANG, turned(made(WANG, swivel=1e-3), 0.02 * ZEROS), plan, rough=0.05)
    assert found.status == "degenerate"
    assert "the edge of its range" in found.reason
    assert found.reason.endswith("if their zero is not sure, add swivel_offset to the unknowns")


def test_files_with_yaw_are_read_as_they_were_written(tmp_path: Path) -> None:
    measured = made(COGIRO, tilt=1e-3, yaw=1e-2, poses=30)
    file = tmp_path / "d.csv"
    file.write_text(write_measured(measured, COGIRO), encoding="utf-8")
    again = read_measured(file, COGIRO)
    for name in ("counted", "guess", "tilt", "yaw"):
        assert np.array_equal(getattr(again, name), getattr(measured, name))


def test_counts_of_encoders_are_turns_of_the_drum(tmp_path: Path) -> None:
    house = load("house-printer")
    file = tmp_path / "d.csv"
    file.write_text("DL_1 (turns),dl_2 [deg],dl_3 (counts/4096),dl_4 (rad)\n1,360,4096,6.283185307179586\n")
    drum = house.lines[0].winch.drum_radius
    assert drum is not None
    assert read_measured(file, house).counted == pytest.approx(np.full((1, 4), 2.0 * np.pi * drum), rel=1e-15)


@pytest.mark.parametrize(
    ("header", "robot", "message"),
    [
        (
            "dl_1 (counts),dl_2,dl_3,dl_4",
            "house-printer",
            r"say how many a turn of the drum, as in 'dl_1 \(counts/4096\)'",
        ),
        ("dl_1 (counts/0),dl_2,dl_3,dl_4", "house-printer", "unknown unit 'counts/0'.*turns, rad, deg, counts/4096$"),
        ("dl_1 (turns),dl_2,dl_3,dl_4", "wang2021", "line 'south-west' gives no winch.drum_radius; give lengths"),
        ("dl_1,dl_2,dl_3,dl_4,yaw", "wang2021", "is a point platform, which has no yaw"),
    ],
)
def test_headers_that_cannot_be_used(header: str, robot: str, message: str, tmp_path: Path) -> None:
    file = tmp_path / "d.csv"
    row = ",".join("0" for _ in header.split(","))
    file.write_text(f"{header}\n{row}\n{row}\n", encoding="utf-8")
    with pytest.raises(InputError, match=message):
        calibrate(load(robot), file)


def test_unknowns_and_bounds_that_cannot_be_used() -> None:
    measured = made(WANG)
    for name, column in (("tension_scale", "f_1"), ("swivel_offset", "swivel_1")):
        with pytest.raises(InputError, match=f"unknowns: {name}: the data has no column {column}"):
            calibrate(WANG, measured, CalibrationPlan(unknowns=(*PLAIN, name)))
    with pytest.raises(InputError, match="is a point platform, which has no tilt_offset"):
        calibrate(WANG, measured, CalibrationPlan(unknowns=(*PLAIN, "tilt_offset")))
    with pytest.raises(ValueError, match="must be over 0"):
        Bound(name="tension_scale", min=0.0, max=2.0)
    for far in (1e-12, 1e300):
        with pytest.raises(ValueError, match="sigma"):
            CalibrationPlan(sigma={"yaw": far})
        with pytest.raises(ValueError, match="deviation"):
            Prior(name="exit_point", deviation=far)
    assert Bound(name="tension_offset", min=-5.0, max=5.0).min == -5.0
    with pytest.raises(InputError, match="tilt noise: 'wang2021' is a point platform"):
        simulate_calibration(WANG, 20, 1e-4, sensors=SensorNoise(tilt=1e-3))
