"""The verdict: good where all is well, over seeds; doubtful and bad for what is wrong, by name."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.judgement.consistency import predicted_halves
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan, MeasuredDistance, Point, Prior, Sigmas
from cablewright.calibration.poses.fit import fit
from cablewright.calibration.poses.problem import StraightProblem
from cablewright.calibration.poses.simulation import SimulatedCalibration, measure, random_poses, simulate_calibration
from cablewright.calibration.unknowns import unknowns_of, with_values
from cablewright.foundation.errors import InputError
from cablewright.robot import Robot, load
from cases import some

WANG = load("wang2021")
TRUE = np.array([line.exit_point for line in WANG.lines])
SURVEYED = CalibrationPlan(
    points=tuple(Point(line=line.name, at=line.exit_point, deviation=5e-4) for line in WANG.lines[:3])
)


def with_exits(robot: Robot, exits: np.ndarray) -> Robot:
    pairs = zip(robot.lines, exits.tolist(), strict=True)
    return robot.model_copy(
        update={"lines": tuple(line.model_copy(update={"exit_point": tuple(p)}) for line, p in pairs)}
    )


def slipped(seed: int, by: float) -> Measured:
    """Half the poses after a line slipped on its drum."""
    made = simulate_calibration(WANG, 40, 1e-4, seed=seed)
    counted = made.measured.counted.copy()
    counted[20:, 1] += by
    return replace(made.measured, counted=counted)


def ordered(order: list[int], signs: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0), seed: int = 2) -> Measured:
    made = simulate_calibration(WANG, 40, 1e-4, seed=seed)
    return replace(made.measured, counted=made.measured.counted[:, order] * np.array(signs))


@pytest.mark.parametrize("seed", some(range(10)))
def test_well_measured_data_are_good(seed: int) -> None:
    made = simulate_calibration(WANG, 40, 1e-4, seed=seed)
    found = calibrate(WANG, made.measured, SURVEYED, need=5e-3)
    assert (found.verdict, found.reasons, found.refusal, found.ok) == ("good", (), "", True)
    assert np.abs(found.values[:12] - TRUE.ravel()).max() < 4.0 * 5e-3  # what good means, at 4 sigmas


@pytest.mark.parametrize("seed", some(range(10)))
def test_encoders_alone_are_doubtful_for_one_reason(seed: int) -> None:
    found = calibrate(WANG, simulate_calibration(WANG, 40, 1e-4, seed=seed).measured)
    (reason,) = found.reasons
    assert found.verdict == "doubtful"
    told = re.match(r"(exit point \w of [\w-]+) is known to ([\d.]+) mm \(one sigma\), where 2 mm is needed", reason)
    assert told is not None
    assert float(told[2]) == pytest.approx(1e3 * found.exit_sigma, rel=5e-3)
    assert found.robot != WANG  # a person may look at it
    assert calibrate(WANG, simulate_calibration(WANG, 40, 1e-4, seed=seed).measured, need=0.1).verdict == "good"


def test_a_sigma_that_is_unknown_is_doubtful() -> None:
    found = calibrate(WANG, simulate_calibration(WANG, 12, 1e-4, seed=1).measured)
    assert found.verdict == "doubtful"
    assert "no measurement is left over" in found.reasons[0]


@pytest.mark.parametrize("seed", some(range(3)))
@pytest.mark.parametrize("guessed", some([True, False]))
def test_data_of_another_machine_are_bad(seed: int, guessed: bool) -> None:
    rng = np.random.default_rng(seed)
    other = with_exits(WANG, TRUE * 1.8 + rng.uniform(-0.5, 0.5, (4, 3)))
    made = measure(other, rng.uniform([-1.4, -1.2, 0.4], [1.4, 1.2, 2.4], (40, 3)), 1e-4, rng)
    found = calibrate(WANG, made.measured if guessed else Measured(made.measured.counted))
    assert (found.verdict, found.robot) == ("bad", WANG)
    assert any("(--rough)" in each or "range" in each or "fit to" in each for each in found.reasons)


@pytest.mark.parametrize(
    ("order", "signs", "told"),
    some(
        [
            ([1, 2, 3, 0], (1, 1, 1, 1), "columns of lines in the order 4, 1, 2, 3"),
            ([0, 1, 2, 3], (1, 1, 1, -1), "dl_4 with the other sign"),
            ([1, 0, 2, 3], (1, 1, 1, 1), "columns 1 and 2 (dl, and others of lines) exchanged"),
            ([0, 3, 2, 1], (1, 1, 1, 1), "columns 2 and 4 (dl, and others of lines) exchanged"),
            ([0, 1, 2, 3], (-1, -1, -1, -1), "all dl with the other sign"),
        ],
        fast=2,
    ),
)
@pytest.mark.parametrize("seed", some([2, 3]))
def test_lines_in_another_order_are_named(order: list[int], signs: tuple[float, ...], told: str, seed: int) -> None:
    found = calibrate(WANG, ordered(order, signs, seed))
    assert (found.verdict, found.robot) == ("bad", WANG)
    assert found.reasons[0].startswith(f"{told} would explain the data far better")


def test_positions_in_a_mirrored_frame_are_named() -> None:
    made = simulate_calibration(WANG, 40, 1e-4, seed=4)
    guess = made.poses * np.array([-1.0, 1.0, 1.0])
    measured = replace(made.measured, guess=guess, pose_sigma=np.full((40, 3), 1e-3))
    found = calibrate(WANG, measured)
    assert found.verdict == "bad"
    assert found.reasons[0].startswith(("x of the poses mirrored", "columns of lines in the order", "columns "))


@pytest.mark.parametrize(("spoiled", "verdict"), some([(3, None), (6, "doubtful"), (10, "bad")], fast=2))
def test_many_poses_left_out_are_a_reason(spoiled: int, verdict: str | None) -> None:
    rng = np.random.default_rng(7)
    made = simulate_calibration(WANG, 40, 1e-4, seed=7)
    counted = made.measured.counted.copy()
    bad = rng.choice(40, spoiled, replace=False)
    counted[bad] += rng.normal(0.0, 0.05, (spoiled, 4))
    found = calibrate(WANG, replace(made.measured, counted=counted), need=1.0)
    assert len(found.rejected) == spoiled
    told = [each for each in found.reasons if "do not fit the others" in each]
    assert bool(told) == (verdict is not None)
    assert verdict is None or found.verdict == verdict
    assert not told or told[0].startswith(f"{spoiled} of 40 poses do not fit the others")


def test_values_that_no_robot_has_are_named() -> None:
    """The fit may move an exit point below its winch; no file can describe that."""
    robot = load("merlet2023")
    (height,) = [each for each in unknowns_of(robot, ("exit_point",)) if each.label == "exit point z of south-east"]
    with pytest.raises(InputError, match=r"merlet2023, as calibrated: lines\[1\].winch_exit = .*below exit_point"):
        with_values(robot, [height], np.array([-0.5]))


@pytest.mark.parametrize(("by", "verdict"), [(0.0, "good"), (0.01, "bad")])
def test_a_slip_between_the_halves_is_reported(by: float, verdict: str) -> None:
    found = calibrate(WANG, slipped(1, by), need=1.0, outliers=False)
    assert found.verdict == verdict
    assert any("did something slip" in each for each in found.reasons) == (by > 0.0)


def test_halves_predict_each_other_as_noise_explains() -> None:
    """Over seeds the ratio's square is that of the F distribution: 1 or so, and small probabilities are rare."""
    ratios, probabilities = [], []
    for seed in range(60):
        made = simulate_calibration(WANG, 40, 1e-4, seed=seed)
        problem = StraightProblem.of(WANG, made.measured, hold=False)
        found = fit(problem, problem.free + np.append(np.zeros(12), made.home_lengths), made.poses)
        halves = predicted_halves(problem, found)
        assert [each.poses for each in halves] == [(20, 39), (0, 19)]
        ratios += [each.ratio**2 for each in halves]
        probabilities += [each.probability for each in halves]
    assert np.median(ratios) == pytest.approx(1.0, abs=0.3)
    assert np.mean(np.array(probabilities) < 0.5) == pytest.approx(0.5, abs=0.15)
    assert np.mean(np.array(probabilities) < 0.05) < 0.12


def test_a_prediction_is_that_of_a_fit_to_one_half() -> None:
    """To first order: the second half's residuals, fitted again at the unknowns of the first alone."""
    made = simulate_calibration(WANG, 60, 1e-5, seed=3)
    measured = replace(made.measured, counted=made.measured.counted.copy())
    measured.counted[30:, 1] += 1e-3
    plan = CalibrationPlan(unknowns=("length_offset",), sigma=Sigmas(encoder=1e-5))
    problem = StraightProblem.of(WANG, measured, plan, hold=False)
    whole = fit(problem, made.home_lengths.copy(), made.poses)
    told = predicted_halves(problem, whole)[0]
    first = StraightProblem.of(WANG, Measured(measured.counted[:30]), plan, hold=False)
    own = fit(first, made.home_lengths.copy(), made.poses[:30])
    last = StraightProblem.of(WANG, Measured(measured.counted[30:]), plan, hold=False).for_poses_only(own.theta)
    other = fit(last, np.zeros(0), made.poses[30:])
    # 30 redundant numbers each, of which 4 are used up in the first half; its unknowns are known far better than 1 mm
    wanted = np.sqrt((2 * other.cost / 30) / (2 * own.cost / 26))
    assert told.ratio < wanted * 1.02  # less: the prediction's own sigma counts too
    assert told.ratio > 0.3 * wanted


@pytest.mark.parametrize(("off", "verdict"), [(2e-3, "good"), (1e-2, "doubtful"), (3e-2, "bad")])
def test_a_prior_that_the_data_deny(off: float, verdict: str) -> None:
    made = simulate_calibration(WANG, 40, 1e-5, seed=5)
    factor = 1.0 + off
    measured = replace(made.measured, counted=made.measured.counted / factor)
    plan = CalibrationPlan(
        unknowns=("exit_point", "length_offset", "length_scale"),
        shared=("length_scale",),
        points=tuple(Point(line=line.name, at=line.exit_point, deviation=1e-4) for line in WANG.lines),
        priors=(Prior(name="length_scale", deviation=2e-3),),
    )
    found = calibrate(WANG, measured, plan, need=1.0)
    assert found.verdict == verdict
    assert any("of its prior, limit 4" in each for each in found.reasons) == (verdict != "good")


def test_kinds_that_contradict_each_other_are_reported() -> None:
    """Positions given to 1 mm that are good to 4: doubtful, with kind, value and limit."""
    rng = np.random.default_rng(3)
    made: SimulatedCalibration = measure(WANG, random_poses(WANG, 30, rng), 1e-4, rng)
    guess = made.poses + rng.normal(0.0, 4e-3, (30, 3))
    measured = replace(made.measured, guess=guess, pose_sigma=np.full((30, 3), 1e-3))
    found: Calibration = calibrate(WANG, measured, CalibrationPlan(sigma=Sigmas(encoder=1e-4)), need=1.0)
    assert found.verdict == "doubtful"
    (told,) = [each for each in found.reasons if "residuals of the positions" in each]
    value = float(re.search(r"are ([\d.]+) times", told)[1])
    assert value == pytest.approx(4.0, rel=0.3)
    assert "limit 1.5" in told


def test_lengths_that_scatter_more_than_is_needed() -> None:
    found = calibrate(WANG, simulate_calibration(WANG, 30, 5e-3, seed=2).measured)
    assert found.verdict in ("doubtful", "bad")
    assert any("lengths scatter by" in each and "2 mm" in each for each in found.reasons)


@pytest.mark.parametrize("need", [0.0, -1.0, float("nan"), float("inf")])
def test_a_need_that_is_none(need: float) -> None:
    with pytest.raises(InputError, match="need"):
        calibrate(WANG, simulate_calibration(WANG, 20, 1e-4, seed=1).measured, need=need)


def surveyed(off: float, rng: np.random.Generator, lines: int = 4) -> CalibrationPlan:
    """A plan with exit points surveyed to 0.5 mm, the first of them wrong by *off*, m."""
    at = TRUE[:lines] + rng.normal(0.0, 5e-4, (lines, 3))
    at[0, 0] += off
    pairs = zip(WANG.lines, at.tolist(), strict=False)
    return CalibrationPlan(points=tuple(Point(line=line.name, at=tuple(p), deviation=5e-4) for line, p in pairs))


@pytest.mark.parametrize("seed", some(range(3)))
@pytest.mark.parametrize(("off", "verdict"), [(0.0, "good"), (0.03, "bad")])
def test_a_surveyed_point_that_lengths_deny(off: float, verdict: str, seed: int) -> None:
    made = simulate_calibration(WANG, 40, 1e-4, seed=seed)
    found = calibrate(WANG, made.measured, surveyed(off, np.random.default_rng(seed)))
    assert found.verdict == verdict
    told = [each for each in found.reasons if each.startswith("lengths alone fit to 0.")]
    assert bool(told) == (verdict != "good")
    assert all("together with the surveyed points to" in each for each in told)


@pytest.mark.parametrize("seed", some(range(2)))
def test_a_distance_and_counts_that_contradict_surveyed_points(seed: int) -> None:
    made = simulate_calibration(WANG, 40, 1e-4, seed=seed)
    plan = surveyed(0.0, np.random.default_rng(seed), 3)
    apart = float(np.linalg.norm(TRUE[0] - TRUE[3])) + 0.05
    names = (WANG.lines[0].name, WANG.lines[3].name)
    distance = MeasuredDistance(between=names, value=apart, deviation=5e-4)
    longer = replace(made.measured, counted=made.measured.counted * 1.002)
    for measured, used in (
        (made.measured, plan.model_copy(update={"distances": (distance,)})),
        (longer, surveyed(0.0, np.random.default_rng(seed))),
    ):
        found = calibrate(WANG, measured, used)
        assert found.verdict != "good"
        said = ("lengths alone fit to", "residuals of the surveyed points")
        assert any(each.startswith(said) for each in found.reasons)


def test_what_is_too_few_to_test_the_encoders() -> None:
    made = simulate_calibration(WANG, 14, 1e-4, seed=1)
    found = calibrate(WANG, made.measured, surveyed(0.0, np.random.default_rng(1)))
    assert found.verdict == "doubtful"
    assert any("too few lengths are left over to test it: give sigma.encoder" in each for each in found.reasons)


def test_surveyed_points_are_tested_where_the_encoders_are_known() -> None:
    made = simulate_calibration(WANG, 40, 1e-4, seed=1)
    plan = surveyed(0.03, np.random.default_rng(1)).model_copy(update={"sigma": Sigmas(encoder=1e-4)})
    found = calibrate(WANG, made.measured, plan)
    assert found.verdict != "good"
    assert any("surveyed points and distances are" in each for each in found.reasons)


def positioned(poses: int, seed: int, sigma: float = 1e-3) -> Measured:
    made = simulate_calibration(WANG, poses, 1e-4, seed=seed)
    guess = made.poses + np.random.default_rng(seed).normal(0.0, sigma, (poses, 3))
    return replace(made.measured, guess=guess, pose_sigma=np.full((poses, 3), sigma))


def test_no_redundancy_is_doubtful_whatever_is_known() -> None:
    """Encoders' sigma is given, so every sigma is a number; still nothing tests the answer."""
    made = simulate_calibration(WANG, 12, 1e-4, seed=1)
    found = calibrate(WANG, made.measured, CalibrationPlan(sigma=Sigmas(encoder=1e-4)), need=100.0)
    assert found.posterior.redundancy == 0
    assert found.verdict == "doubtful"
    assert "no measurement is left over" in found.reasons[0]


@pytest.mark.parametrize(("need", "verdict"), [(2e-3, "good"), (1e-6, "doubtful")])
def test_home_lengths_are_judged_where_exit_points_are_known(need: float, verdict: str) -> None:
    made = simulate_calibration(WANG, 30, 1e-4, seed=1)
    plan = CalibrationPlan(unknowns=("length_offset",), sigma=Sigmas(encoder=1e-4))
    found = calibrate(WANG, made.measured, plan, need=need)
    assert found.verdict == verdict
    assert verdict == "good" or "home length of" in found.reasons[0]


@pytest.mark.parametrize("seed", some(range(6)))
def test_few_clean_rows_are_not_left_out(seed: int) -> None:
    """Positions at 5 poses, or encoders alone at 13: noise of so few looks like gross errors."""
    for measured in (positioned(5, seed), simulate_calibration(WANG, 13, 1e-4, seed=seed).measured):
        found = calibrate(WANG, measured)
        assert found.rejected == ()
        assert found.verdict == "doubtful"


def test_an_assumed_sigma_of_the_encoders_is_a_reason() -> None:
    found = calibrate(WANG, positioned(5, 0), need=1.0)
    assert found.verdict == "doubtful"
    (reason,) = found.reasons
    assert "0.1 mm is assumed" in reason


@pytest.mark.parametrize("seed", some(range(3)))
def test_no_order_is_claimed_that_fits_worse(seed: int) -> None:
    """Noise of centimetres: the residuals of all arrangements are noise."""
    found = calibrate(WANG, simulate_calibration(WANG, 20, 0.02, seed=seed).measured)
    assert not any("would explain the data far better" in each for each in found.reasons)


@pytest.mark.parametrize("seed", some(range(2)))
def test_an_order_is_named_without_start_values_of_the_poses(seed: int) -> None:
    """Counts of lines in another order fit as well, but with large errors of exit points: this alone is examined."""
    measured = Measured(ordered([1, 2, 3, 0], seed=seed).counted)
    found = calibrate(WANG, measured, rough=5.0, need=10.0)
    right = calibrate(WANG, Measured(ordered([0, 1, 2, 3], seed=seed).counted), rough=0.5, need=10.0)
    assert found.verdict == "bad"
    assert "would explain the data far better" in found.reasons[0]
    assert right.verdict == "good"


@pytest.mark.parametrize("seed", some(range(3)))
def test_positions_whose_sigma_is_much_too_large_are_reported(seed: int) -> None:
    measured = positioned(40, seed, 0.02)
    measured = replace(measured, pose_sigma=np.full((40, 3), 0.3))
    found = calibrate(WANG, measured, need=10.0)
    assert found.verdict == "doubtful"
    assert any("residuals of the positions are 0.0" in each and "it is too large" in each for each in found.reasons)
    right = calibrate(WANG, positioned(40, seed, 0.02), need=10.0)
    assert not any("it is too large" in each for each in right.reasons)


def test_an_error_of_the_model_along_one_axis_is_named() -> None:
    """Heights with errors above their sigma where x and y have none: all positions together would hide it."""
    rng = np.random.default_rng(11)
    made = measure(WANG, random_poses(WANG, 27, rng), 1e-4, rng)
    off = np.column_stack([rng.normal(0.0, 5e-3, (27, 2)), 0.045 * np.sign(rng.normal(0.0, 1.0, 27))])
    plan = CalibrationPlan(sigma=Sigmas(encoder=1e-4))
    measured = replace(made.measured, guess=made.poses + off, pose_sigma=np.full((27, 3), 0.02))
    found = calibrate(WANG, measured, plan, need=1.0, rough=0.1, outliers=False)
    assert any("along z are" in each for each in found.reasons)
    assert not any("off along x" in each or "off along y" in each for each in found.reasons)
    every = replace(measured, guess=made.poses + 9.0 * np.roll(off, 1, axis=0)[:, [0, 1, 0]])
    found_off = calibrate(WANG, every, plan, need=1.0, rough=0.1, outliers=False)
    assert any("residuals of the positions are" in each for each in found_off.reasons)
    assert not any("the model has an error along" in each for each in found_off.reasons)
    alone = calibrate(WANG, made.measured, plan, need=1.0, rough=0.1, outliers=False)
    assert any("nothing that was measured tests heights" in each for each in alone.notes)
    assert not any("tests heights" in each for each in found.notes)
