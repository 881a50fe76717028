"""Which poses to measure: better than random ones, within the limits, and what is promised is kept."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.calibration.guidance.pose_selection import calibration_poses
from cablewright.calibration.measurements import Measured
from cablewright.calibration.poses.observability import information
from cablewright.calibration.poses.problem import StraightProblem
from cablewright.foundation.errors import InputError
from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.inverse import solve_inverse

WANG = load("wang2021")


@pytest.mark.parametrize("criterion", ["d-optimal", "worst-sigma"])
def test_chosen_poses_determine_more_than_random_ones(criterion: str) -> None:
    found = calibration_poses(WANG, 20, criterion=criterion, candidates=300, seed=1)
    assert len(found.poses) == 20
    assert found.sigma_worst < 0.6 * found.random_worst
    assert found.travel < found.travel_unordered
    assert solve_inverse(Model(WANG, Fidelity.of("rigid")), found.poses).ok.all()


def test_each_criterion_is_best_at_its_own() -> None:
    one, other = (
        calibration_poses(WANG, 20, criterion=each, candidates=300, seed=1) for each in ("d-optimal", "worst-sigma")
    )
    assert other.sigma_worst <= one.sigma_worst


def test_promised_sigmas_are_those_of_a_calibration() -> None:
    found = calibration_poses(WANG, 20, candidates=300, seed=1)
    problem = StraightProblem.of(WANG, Measured(found.counted, found.poses))
    theta = problem.start.copy()
    theta[12:] = problem.lengths(problem.start, found.poses[:1])[0]
    covariance = information(problem, theta, found.poses, problem.weights).covariance
    sigma = np.sqrt(np.diag(covariance)[:12])
    assert float(np.sqrt(np.mean(sigma**2))) == pytest.approx(found.sigma_rms, rel=1e-5)
    assert sigma.max() == pytest.approx(found.sigma_worst, rel=1e-5)


def test_too_few() -> None:
    with pytest.raises(InputError, match="11 poses: must be from 12"):
        calibration_poses(WANG, 11, candidates=50)


def test_cli(cli_poses) -> None:
    code, out = cli_poses("poses", "wang2021", "--count", "14", "--candidates", "100", "--seed", "2")
    assert code == 0
    assert "sigma of random poses, rms" in out


@pytest.fixture
def cli_poses(capsys: pytest.CaptureFixture[str]):
    from cablewright.apps.cli import main

    def call(*arguments: str) -> tuple[int, str]:
        return main.run(list(arguments)), capsys.readouterr().out

    return call
