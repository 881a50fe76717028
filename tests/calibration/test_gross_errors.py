"""The search for gross errors: clean data stay whole for any given sigmas; wrong data are found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.judgement.gross_errors import FALSE_ALARM, Unexplained
from cablewright.calibration.judgement.sigmas import evened
from cablewright.calibration.measurements import Measured
from cablewright.calibration.poses.fit import fit, refit
from cablewright.calibration.poses.problem import StraightProblem
from cablewright.calibration.poses.simulation import measure, random_poses
from cablewright.robot import load
from cases import often, some

WANG = load("wang2021")


def data(seed: int, count: int, told: float | None = None, wrong: int = 0) -> tuple[Measured, list[int]]:
    """Data, with positions good to 2 mm whose sigma is *told*; in *wrong* rows a length is 50 mm off."""
    rng = np.random.default_rng(seed)
    made = measure(WANG, random_poses(WANG, count, rng), 1e-4, rng)
    counted, bad = made.measured.counted.copy(), rng.choice(count, wrong, replace=False)
    counted[bad, rng.integers(0, 4, wrong)] += 0.05
    measured = replace(made.measured, counted=counted)
    if told is not None:
        guess = made.poses + rng.normal(0.0, 2e-3, made.poses.shape)
        measured = replace(measured, guess=guess, pose_sigma=np.full(guess.shape, told))
    return measured, sorted(bad.tolist())


@pytest.mark.parametrize(
    ("count", "told"),
    [
        (24, None),
        *(pytest.param(*each, marks=pytest.mark.slow) for each in ((40, 1.0), (40, None), (100, None), (40, 2e-3))),
    ],
)
def test_clean_data_stay_whole(count: int, told: float | None) -> None:
    """In `benchmarks/calibration_search.py` of 300 files of each kind."""
    for seed in range(often(2, 4)):
        assert calibrate(WANG, data(seed + 40, count, told)[0]).rejected == ()


@pytest.mark.parametrize("told", some([1.0, None, 2e-3]))
def test_wrong_lengths_are_found_whatever_the_sigma_of_positions(told: float | None) -> None:
    good, files = 0, often(1, 5)
    for seed in range(files):
        measured, bad = data(seed, 40, told, 3)
        good += sorted({each.pose for each in calibrate(WANG, measured).rejected}) == bad
    assert good >= files - files // 5


@pytest.mark.parametrize("told", [2e-4, 2e-3, 0.1, 1.0])
def test_kinds_are_evened_to_their_true_sigmas(told: float) -> None:
    measured, _ = data(1, 40, told)
    problem = StraightProblem.of(WANG, measured, hold=False)
    start = calibrate(WANG, measured, outliers=False).fit
    even, _ = evened(problem, fit(problem, start.theta, start.poses))
    sigma = 1.0 / even.of_poses(even.weights)[0]
    assert 0.5e-4 < sigma[:4].min() <= sigma[:4].max() < 2e-4  # a median of 40
    assert 1e-3 < sigma[4:].min() <= sigma[4:].max() < 4e-3


def test_a_pose_left_out_by_mistake_comes_back_and_a_wrong_one_does_not() -> None:
    measured, bad = data(2, 40, None, 1)
    right = next(j for j in range(40) if j not in bad)
    problem = StraightProblem.of(WANG, measured, hold=False)
    whole = calibrate(WANG, measured).fit
    out = np.zeros(40, dtype=bool)
    out[[right, *bad]] = True
    weights = problem.weights.copy()
    problem.of_poses(weights)[out] = 0.0
    even, found = evened(problem, refit(problem, whole, weights))
    tests = Unexplained.of(even, found, out)
    assert tests.mistaken().tolist() == [right]
    assert tests.rejected()[bad].all()
    assert not tests.rejected()[right]
    assert 0.0 < FALSE_ALARM <= 0.01
