"""Kinds of measurements: leverage, sigmas from residuals, vague and wrong positions, readings left out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.judgement.sigmas import _averaged, idle, kind_fits, leverages, resisting
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan, MeasuredRange, Sigmas, TouchedPlane
from cablewright.calibration.poses.fit import fit
from cablewright.calibration.poses.problem import StraightProblem
from cablewright.calibration.poses.simulation import measure, random_poses, simulate_calibration
from cablewright.robot import Robot, load
from cases import often, some

WANG = load("wang2021")
TRUE = np.array([line.exit_point for line in WANG.lines])


def positioned(seed: int, count: int = 20, encoder: float = 1e-4, sigma: float = 1e-3, known: int | None = None):
    """Data with measured positions at the first *known* poses, and places known to a metre at the others."""
    rng = np.random.default_rng(seed)
    made = measure(WANG, random_poses(WANG, count, rng), encoder, rng)
    known = count if known is None else known
    sigmas = np.full((count, 3), 1.0)
    sigmas[:known] = sigma
    noise = np.where(sigmas < 1.0, rng.normal(0.0, sigma, (count, 3)), rng.normal(0.0, 0.1, (count, 3)))
    return made, replace(made.measured, guess=made.poses + noise, pose_sigma=sigmas)


def worst(found) -> float:
    return float(np.abs(found.values[:12].reshape(4, 3) - TRUE).max())


def test_leverages_are_the_diagonal_of_the_hat_matrix() -> None:
    made, measured = positioned(1, 8)
    problem = StraightProblem.of(WANG, measured)
    found = fit(problem, problem.free + np.append(np.zeros(12), made.home_lengths), made.poses)
    rows = problem.derivatives(found.theta, found.poses)
    count, e, k = rows.by_unknown.shape
    dense = np.zeros((count * e, k + 3 * count))
    dense[:, :k] = rows.by_unknown.reshape(-1, k)
    for j in range(count):
        dense[j * e : (j + 1) * e, k + 3 * j : k + 3 * j + 3] = rows.by_pose[j]
    q = np.linalg.qr(dense)[0]
    assert leverages(problem, found).ravel() == pytest.approx(np.sum(q * q, axis=1), abs=1e-9)


@pytest.mark.parametrize(
    ("truth", "beside"),
    [
        (5e-5, "positions"),
        (3e-3, "positions"),
        pytest.param(5e-4, "planes", marks=pytest.mark.slow),
        pytest.param(5e-5, "ranges", marks=pytest.mark.slow),
        pytest.param(3e-3, "ranges", marks=pytest.mark.slow),
    ],
)
def test_the_encoders_sigma_is_estimated_beside_other_sensors(truth: float, beside: str) -> None:
    """Its mean over seeds is the true one, from 20 times as small to 30 times as large as the sigma assumed before."""
    ratios = []
    seeds = range(often(2, 8))
    for seed in seeds:
        made, measured = positioned(seed, 30, truth)
        plan = CalibrationPlan()
        if beside == "ranges":
            corner, rows = np.array([0.5, -1.7, 0.1]), tuple(range(1, 21))
            far = np.linalg.norm(made.poses[:20] - corner, axis=1)
            values = far + np.random.default_rng(seed).normal(0.0, 1e-3, 20)
            plan = CalibrationPlan(ranges=(MeasuredRange(point=tuple(corner), poses=rows, values=tuple(values)),))
            measured = made.measured
        elif beside == "planes":
            plane = TouchedPlane(poses=(2, 3), point=tuple(made.poses[1]), normal=(0.0, 0.0, 1.0), deviation=0.5)
            plan, measured = CalibrationPlan(planes=(plane,)), made.measured
        found = calibrate(WANG, measured, plan, rough=0.05)
        assert found.status == "ok"
        ratios.append(found.encoder_sigma / truth)
    assert np.sqrt(np.mean(np.square(ratios))) == pytest.approx(1.0, abs=0.34 / np.sqrt(len(seeds)))


@pytest.mark.parametrize("seeds", some([8, 30]))
def test_sigmas_cover_the_errors_where_the_encoders_sigma_was_not_given(seeds: int) -> None:
    """Encoders ten times as bad as assumed, beside positions of 1 mm: sigmas used to be a tenth of the right ones."""
    shares = []
    for seed in range(seeds):
        made, measured = positioned(seed, 20, 1e-3)
        found = calibrate(WANG, measured, rough=0.05)
        off = np.append((found.values[:12].reshape(4, 3) - TRUE).ravel(), found.values[12:] - made.home_lengths)
        shares.append(np.abs(off) / found.noise_sigma)
        assert (found.sigma >= found.noise_sigma * (1.0 - 1e-9)).all()
    assert np.mean(np.array(shares) < 1.0) == pytest.approx(0.683, abs=0.08)
    assert np.mean(np.array(shares) < 1.96) == pytest.approx(0.95, abs=0.05)


@pytest.mark.parametrize("seed", some(range(6)))
def test_positions_that_carry_nothing_neither_count_nor_spoil(seed: int) -> None:
    """9 of 44 poses are measured, 35 known to a metre: the measured ones used to be left out, and then all was lost."""
    made, measured = positioned(seed, 44, 1e-3, known=9)
    plan = CalibrationPlan(unknowns=("exit_point", "length_offset", "length_scale"), shared=("length_scale",))
    found, kept = calibrate(WANG, measured, plan), calibrate(WANG, measured, plan, outliers=False)
    assert (found.status, found.rejected) == ("ok", ())
    assert found.values == pytest.approx(kept.values, abs=1e-6)
    assert np.abs(found.values[:12] - TRUE.ravel()).max() < 4.0 * found.sigma[:12].max() < 0.08
    problem = StraightProblem.of(WANG, measured, plan, hold=False)
    vague = idle(problem, fit(problem, kept.fit.theta, made.poses))
    assert vague[9:, 4:].all()
    assert not vague[:9].any()
    assert not vague[:, :4].any()


def test_vague_positions_stay_where_nothing_else_holds_the_frame() -> None:
    """Six known to a metre: together they hold the frame, each alone carries a sixth of it."""
    _, measured = positioned(1, 20, 1e-4, known=0)
    assert measured.pose_sigma is not None
    sigma = np.full((20, 3), 1e4)
    sigma[:6] = 1.0
    problem = StraightProblem.of(WANG, replace(measured, pose_sigma=sigma), hold=False)
    found = calibrate(WANG, replace(measured, pose_sigma=sigma))
    assert found.gauge == ()
    vague = idle(problem, found.fit)
    assert vague[6:, 4:].all()
    assert not vague[:6, 4:].all(axis=1).any()


def test_a_wrong_position_is_left_out_alone_and_the_expected_one_is_reported() -> None:
    made, measured = positioned(3, 25)
    assert measured.guess is not None
    guess = measured.guess.copy()
    guess[7, 0] += 0.04
    found = calibrate(WANG, replace(measured, guess=guess))
    (out,) = found.rejected
    assert (out.pose, out.sensor, out.line) == (7, "position", None)
    assert out.size == pytest.approx(0.04, abs=5e-3)
    assert out.measured == pytest.approx(guess[7])
    assert out.expected == pytest.approx(made.poses[7], abs=6e-3)
    assert found.used[7].all()


def test_a_wrong_length_is_left_out_and_the_expected_one_is_reported() -> None:
    made, measured = positioned(4, 25)
    counted = measured.counted.copy()
    counted[11, 2] += 0.03
    found = calibrate(WANG, replace(measured, counted=counted))
    (out,) = found.rejected
    assert (out.pose, out.sensor, out.line) == (11, "encoder", WANG.lines[2].name)
    assert out.measured == (counted[11, 2],)
    assert out.expected == pytest.approx((made.measured.counted[11, 2],), abs=2e-3)


def test_counts_at_a_pose_are_what_the_equations_expect() -> None:
    """With scale and build-up: the residuals of the expected counts vanish."""
    rng = np.random.default_rng(2)
    plan = CalibrationPlan(unknowns=("length_offset", "length_scale", "build_up"))
    poses = random_poses(WANG, 5, rng)
    blank = StraightProblem.of(WANG, Measured(np.zeros((5, 4))), plan)
    theta = np.array([2.0, 2.1, 2.2, 2.3, 1.01, 1.02, 0.99, 1.0, 0.05, 0.03, 1e-3, 0.0])
    counts = blank.counts_at(theta, poses)
    assert np.ptp(counts) > 0.1
    there = StraightProblem.of(WANG, Measured(counts), plan).derivatives(theta, poses)
    assert there.residual == pytest.approx(np.zeros((5, 4)), abs=1e-8)


def test_positions_with_too_small_sigmas_weigh_less() -> None:
    """Two of 20 points have errors of 4 sigmas, too little to be left out: over seeds the answer is nearer."""
    plain, robust = [], []
    for seed in range(30):
        made, measured = positioned(seed, 20)
        assert measured.guess is not None
        guess = measured.guess.copy()
        guess[[3, 9]] += np.random.default_rng(seed).choice([-4e-3, 4e-3], (2, 3))
        problem = StraightProblem.of(
            WANG, replace(measured, guess=guess), CalibrationPlan(sigma=Sigmas(encoder=1e-4)), hold=False
        )
        first = fit(problem, problem.free + np.append(np.zeros(12), made.home_lengths), made.poses)
        again = resisting(problem, first)
        plain.append(np.sqrt(np.mean((first.theta[:12] - TRUE.ravel()) ** 2)))
        robust.append(np.sqrt(np.mean((again.theta[:12] - TRUE.ravel()) ** 2)))
    assert np.mean(robust) < 0.9 * np.mean(plain)


def test_without_errors_the_resisting_fit_costs_a_few_percent() -> None:
    plain, robust = [], []
    for seed in range(40):
        made, measured = positioned(seed, 20)
        problem = StraightProblem.of(WANG, measured, CalibrationPlan(sigma=Sigmas(encoder=1e-4)), hold=False)
        first = fit(problem, problem.free + np.append(np.zeros(12), made.home_lengths), made.poses)
        plain.append(np.mean((first.theta[:12] - TRUE.ravel()) ** 2))
        robust.append(np.mean((resisting(problem, first).theta[:12] - TRUE.ravel()) ** 2))
    assert np.mean(robust) < 1.12 * np.mean(plain)


def test_each_kind_says_how_well_it_fits() -> None:
    """Positions given to 1 mm that are good to 5 mm: their ratio is 5, that of the lengths 1."""
    ratios = []
    for seed in range(10):
        made, measured = positioned(seed, 30, 1e-4, sigma=5e-3)
        told = replace(measured, pose_sigma=np.full((30, 3), 1e-3))
        problem = StraightProblem.of(WANG, told, CalibrationPlan(sigma=Sigmas(encoder=1e-4)), hold=False)
        found = fit(problem, problem.free + np.append(np.zeros(12), made.home_lengths), made.poses)
        ratios.append([each.ratio for each in kind_fits(problem, found)])
    lengths, positions = np.sqrt(np.mean(np.square(ratios), axis=0))
    assert lengths < 2.0
    assert positions == pytest.approx(5.0, rel=0.15)


def six_lines() -> Robot:
    """A point on six lines: the four of `wang2021`, and two more at mid-sides."""
    first = WANG.lines[0]
    extra = tuple(
        first.model_copy(update={"name": f"extra-{k}", "exit_point": at})
        for k, at in enumerate([(-2.0, 0.0, 2.9), (2.0, 0.1, 0.3)])
    )
    return WANG.model_copy(update={"lines": (*WANG.lines, *extra)})


def test_all_rows_may_be_kept() -> None:
    made = simulate_calibration(six_lines(), 40, 1e-4, seed=1)
    counted = made.measured.counted.copy()
    counted[5, 1] += 0.05
    measured = replace(made.measured, counted=counted)
    assert [each.pose for each in calibrate(six_lines(), measured).rejected] == [5]
    assert calibrate(six_lines(), measured, outliers=False).rejected == ()


def test_a_given_sigma_is_averaged_by_its_evidence() -> None:
    """Over residuals of 20 redundant numbers: right sigmas hardly grow, those 1.5 times too small by about that."""
    random = np.random.default_rng(5)
    ratios = np.sqrt(random.chisquare(20, 400) / 20)
    grown = [np.array([_averaged((times * each) ** 2, 20.0) for each in ratios]) for times in (1.0, 1.5)]
    assert np.sqrt(np.mean(grown[0] ** 2)) < 1.06
    assert 1.4 < np.sqrt(np.mean(grown[1] ** 2)) < 1.6
    assert (np.diff([_averaged(square, 20.0) for square in np.linspace(0.5, 9.0, 40)]) > 0.0).all()


def test_the_joint_region_is_wider_where_the_lengths_give_their_own_sigma() -> None:
    _, measured = positioned(3, 20)
    own, given = (
        calibrate(WANG, measured, CalibrationPlan(sigma=Sigmas(encoder=sigma)), rough=0.05) for sigma in (None, 1e-4)
    )
    chi2 = given.joint_limit(12)
    assert chi2 == pytest.approx(21.026, abs=1e-3)
    assert 1.02 * chi2 < own.joint_limit(12) < 2.0 * chi2
