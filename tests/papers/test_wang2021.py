"""Wang, Caro 2021: the meaning and the limits of its quality measures."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.calibration.poses.fit import fits
from cablewright.calibration.poses.problem import CalibrationProblem, StraightProblem
from cablewright.calibration.poses.simulation import aligned, measure, random_poses
from cablewright.calibration.poses.sufficient_data import min_poses
from cablewright.robot import load

ROBOT = load("wang2021")
TRUE = np.array([line.exit_point for line in ROBOT.lines])
STARTS, OFF = 500, 0.01  # its number of starts; their errors are not printed


@pytest.fixture(scope="module", params=[16, 40])
def runs(request: pytest.FixtureRequest) -> tuple[CalibrationProblem, np.ndarray, np.ndarray, np.ndarray]:
    """A problem without noise, where 500 starts begin, and the exit points (500, 4, 3) and mu (500,) they end at."""
    rng = np.random.default_rng(request.param)
    made = measure(ROBOT, random_poses(ROBOT, request.param, rng), 0.0, rng)
    problem = StraightProblem.of(ROBOT, made.measured)
    truth = np.append(TRUE.ravel(), made.home_lengths)
    theta = truth + rng.uniform(-OFF, OFF, (STARTS, 16))
    found = fits(problem, theta, made.poses + rng.uniform(-OFF, OFF, (STARTS, *made.poses.shape)))
    mu = []
    for each in found:
        squares = problem.lengths(each.theta, each.poses) ** 2 - (made.measured.counted + each.theta[12:]) ** 2
        mu.append(np.abs(squares).mean())
    return problem, np.array(mu), np.array([each.theta[:12].reshape(4, 3) for each in found]), theta


def test_mu_is_rounding(runs) -> None:
    """Its Eq. 21; the floor of its Fig. 4 is about 1e-5 mm, in an unclear unit: sqrt(mu) is 5e-5 mm here."""
    _, mu, _, _ = runs
    assert np.sqrt(mu.mean()) < 1e-7


def test_the_error_of_the_mean_is_that_of_averaged_starts(runs) -> None:
    """Its 0.1 mm (Figs. 5, 6): a single run is 2 mm off along what no encoder sees, and 2 mm / sqrt(500) is 0.1 mm."""
    _, _, exits, _ = runs
    of_mean = float(np.sqrt(np.mean((exits.mean(axis=0) - TRUE) ** 2)))
    single = float(np.sqrt(np.mean((exits - TRUE) ** 2)))
    assert of_mean == pytest.approx(0.1e-3, rel=0.6)
    assert single > 1.5e-3
    assert of_mean == pytest.approx(single / np.sqrt(STARTS), rel=0.6)


def test_aligned_every_run_is_exact(runs) -> None:
    _, _, exits, _ = runs
    assert max(np.abs(aligned(each, TRUE)[0] - TRUE).max() for each in exits) < 1e-9


def test_twelve_poses_are_enough(runs) -> None:
    """Its Eq. 15 says 16: it counts the four degrees of freedom that nothing decides."""
    assert min_poses(runs[0]) == 12
