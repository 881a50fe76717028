"""Fits that may not leave reason: ranges of unknowns, what is open held within the fit, degenerate minima named."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import Bound, CalibrationPlan, MeasuredDistance, Prior, Sigmas
from cablewright.calibration.poses.fit import fit, to_file_frame
from cablewright.calibration.poses.observability import information, projected
from cablewright.calibration.poses.problem import StraightProblem
from cablewright.calibration.poses.ranges_of_unknowns import at_bound
from cablewright.calibration.poses.simulation import simulate_calibration
from cablewright.foundation.errors import InputError
from cablewright.robot import Eyelet, Robot, load
from cases import some

WANG = load("wang2021")
EYELETS = WANG.model_copy(update={"lines": tuple(line.model_copy(update={"sheave": Eyelet()}) for line in WANG.lines)})
SCALED = CalibrationPlan(unknowns=("exit_point", "length_offset", "length_scale"), shared=("length_scale",))


def scaled(robot: Robot, factor: float, seed: int, noise: float = 0.0) -> Measured:
    """Data of a machine whose counts are to be multiplied by a factor."""
    made = simulate_calibration(robot, 40, noise, seed=seed)
    return replace(made.measured, counted=made.measured.counted / factor)


@pytest.mark.parametrize("shared", [(), ("length_scale",)])
@pytest.mark.parametrize("seed", some([1, 2, 3]))
def test_a_scale_without_any_length_does_not_collapse(shared: tuple[str, ...], seed: int) -> None:
    """A smaller world has smaller residuals: an unbounded fit ends at a scale of 0 with no residuals."""
    plan = SCALED.model_copy(update={"shared": shared})
    found = calibrate(EYELETS, scaled(EYELETS, 1.0, seed, 1e-4), plan)
    scales = found.values[[each.name == "length_scale" for each in found.unknowns]]
    assert ((scales >= 0.9) & (scales <= 1.1)).all()
    assert (found.status, found.robot) == ("degenerate", EYELETS)
    assert "the edge of its range from 0.9 to 1.1" in found.reason


@pytest.mark.parametrize("seed", some([1, 2]))
def test_one_length_makes_the_scale_known(seed: int) -> None:
    names, exits = [line.name for line in EYELETS.lines], np.array([line.exit_point for line in EYELETS.lines])
    distances = tuple(
        MeasuredDistance(between=(names[a], names[b]), value=float(np.linalg.norm(exits[a] - exits[b])), deviation=1e-3)
        for a, b in ((0, 1), (1, 2), (2, 3))
    )
    plan = SCALED.model_copy(update={"distances": distances, "sigma": Sigmas(encoder=1e-4)})
    found = calibrate(EYELETS, scaled(EYELETS, 1.01, seed, 1e-4), plan)
    assert found.status == "ok"
    assert abs(found.values[-1] - 1.01) < 4.0 * found.sigma[-1] < 4e-3


def test_ranges_may_be_widened_and_narrowed() -> None:
    measured = scaled(WANG, 1.15, 4)
    assert "length scale of all lines ends at 1.1" in calibrate(WANG, measured, SCALED).reason
    wide = SCALED.model_copy(update={"bounds": (Bound(name="length_scale", min=0.5, max=1.5),)})
    found = calibrate(WANG, measured, wide)
    assert found.status == "ok"
    assert found.values[-1] == pytest.approx(1.15, abs=1e-7)
    narrow = SCALED.model_copy(update={"bounds": (Bound(name="length_scale", min=0.99, max=1.05),)})
    assert "from 0.99 to 1.05" in calibrate(WANG, measured, narrow).reason


@pytest.mark.parametrize(
    ("bound", "told"),
    [
        ({"name": "length_scale", "min": 1.1, "max": 1.2}, "is 1 in the file, out of the bounds"),
        ({"name": "build_up", "min": 0.0, "max": 0.1}, "build_up is not among the unknowns"),
        ({"name": "length_scale", "lines": ("nobody",), "min": 0.5, "max": 1.2}, "nobody"),
    ],
)
def test_bounds_that_cannot_be(bound: dict, told: str) -> None:
    with pytest.raises(InputError, match=told):
        calibrate(WANG, scaled(WANG, 1.0, 1), SCALED.model_copy(update={"bounds": (Bound(**bound),)}))


@pytest.mark.parametrize(
    "bound",
    [
        {"name": "exit_point", "min": 0.5, "max": 1.2},
        {"name": "length_scale", "min": 1.2, "max": 0.5},
        {"name": "length_scale", "min": -1.0, "max": 1.2},
    ],
)
def test_bounds_that_are_none(bound: dict) -> None:
    with pytest.raises(ValueError, match=r"bounds|over min|over 0"):
        Bound(**bound)


@pytest.mark.parametrize("seed", some(range(6)))
def test_a_bounded_fit_is_that_of_scipy(seed: int) -> None:
    """The minimum within the ranges, with some unknowns at their ends, against SciPy's trust region with bounds."""
    rng = np.random.default_rng(seed)
    made = simulate_calibration(WANG, 15, 1e-3, seed=seed)
    low, high = 1.0 - rng.uniform(1e-3, 5e-3), 1.0 + rng.uniform(1e-3, 5e-3)
    plan = CalibrationPlan(
        unknowns=("length_offset", "length_scale"),
        bounds=(Bound(name="length_scale", min=low, max=high),),
        sigma=Sigmas(encoder=1e-3),
    )
    counted = made.measured.counted / (1.0 + rng.uniform(-0.01, 0.01, 4))
    problem = StraightProblem.of(WANG, Measured(counted, made.measured.guess), plan)
    theta = np.append(made.home_lengths, np.ones(4))
    found = fit(problem, theta, made.poses)
    k = len(theta)

    def residual(x: np.ndarray) -> np.ndarray:
        return problem.derivatives(x[:k], x[k:].reshape(-1, 3)).residual.ravel()

    def jacobian(x: np.ndarray) -> np.ndarray:
        rows = problem.derivatives(x[:k], x[k:].reshape(-1, 3))
        out = np.zeros((rows.residual.size, len(x)))
        out[:, :k] = rows.by_unknown.reshape(-1, k)
        for j in range(len(made.poses)):
            out[4 * j : 4 * j + 4, k + 3 * j : k + 3 * j + 3] = rows.by_pose[j]
        return out

    free = np.full(made.poses.size, np.inf)
    limits = np.append(problem.limits[0], -free), np.append(problem.limits[1], free)
    first = np.append(theta, made.poses.ravel())
    theirs = least_squares(residual, first, jacobian, bounds=limits, xtol=1e-15, ftol=1e-15, gtol=1e-12, max_nfev=2000)
    ends = (found.theta[4:] <= low) | (found.theta[4:] >= high)
    assert found.code == 0
    assert ends.any()  # else nothing was tested
    assert found.cost <= theirs.cost * (1.0 + 1e-9)
    assert found.cost == pytest.approx(theirs.cost, rel=1e-4)  # theirs stays inside its bounds
    assert found.theta[4:] == pytest.approx(theirs.x[4:8], abs=1e-5)


@pytest.mark.parametrize("seed", range(2, 6))
def test_what_is_open_is_held_within_the_fit_at_no_cost(seed: int) -> None:
    """The rows of the datum change neither cost nor shape, and the answer is nearest to the file of all that fit."""
    made = simulate_calibration(EYELETS, 30, 1e-3, seed=seed)
    problem = StraightProblem.of(EYELETS, made.measured, hold=False)
    start = problem.free + np.append(np.zeros(12), made.home_lengths)
    plain = fit(problem, start, made.poses)
    held = to_file_frame(problem, plain)
    assert held.code == 0
    assert held.cost == pytest.approx(plain.cost, rel=1e-9)
    null = information(problem, held.theta, held.poses, held.weights).null
    assert null.shape[1] == 6
    off = np.where(problem.named("exit_point"), held.theta - problem.free, 0.0)
    assert null.T @ off == pytest.approx(np.zeros(6), abs=1e-10)


@pytest.mark.parametrize("unknowns", [("length_offset",), ("length_offset", "length_scale")])
def test_no_warnings_where_exit_points_are_known(unknowns: tuple[str, ...]) -> None:
    made = simulate_calibration(WANG, 30, 1e-3, seed=3)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = calibrate(WANG, made.measured, CalibrationPlan(unknowns=unknowns))
    assert found.status == "ok"


@pytest.mark.parametrize("seed", some(range(3)))
def test_a_build_up_that_nothing_shows_is_reported_and_no_traceback(seed: int) -> None:
    made = simulate_calibration(EYELETS, 40, 1e-3, seed=seed)
    plan = CalibrationPlan(unknowns=("exit_point", "length_offset", "length_scale", "build_up"))
    found = calibrate(EYELETS, made.measured, plan)
    assert found.status in ("degenerate", "not-converged")
    assert found.robot == EYELETS


def test_a_spool_without_build_up_may_stay_at_none() -> None:
    """Its range ends at the value of the file: that is an answer."""
    made = simulate_calibration(WANG, 40, 0.0, seed=3)
    counted = np.log1p(0.01 * made.measured.counted) / 0.01  # cable that a spool of a growing radius would not pay out
    plan = CalibrationPlan(unknowns=("length_offset", "build_up"), shared=("build_up",))
    found = calibrate(WANG, replace(made.measured, counted=counted), plan, outliers=False)
    assert (found.status, found.values[-1]) == ("ok", 0.0)


def test_indistinguishable_parameters_are_named_with_a_remedy() -> None:
    """Exact data: a larger machine with a larger scale reads the same."""
    made = simulate_calibration(EYELETS, 40, 0.0, seed=5)
    found = calibrate(EYELETS, made.measured, SCALED)
    assert found.status == "degenerate"
    assert "the data do not determine" in found.reason
    assert "distance from exit point" in found.reason
    known = SCALED.model_copy(update={"priors": (Prior(name="length_scale", deviation=1e-3),)})
    assert calibrate(EYELETS, made.measured, known).status == "ok"


def test_a_pose_inside_a_sheave_is_unexplained_and_breaks_nothing() -> None:
    made = simulate_calibration(WANG, 20, 1e-4, seed=1)
    problem = StraightProblem.of(WANG, made.measured)
    poses = made.poses.copy()
    poses[4] = np.add(WANG.lines[0].exit_point, (0.02, 0.0, 0.0))
    theta = problem.free + np.append(np.zeros(12), made.home_lengths)
    off, rows, _ = projected(problem.derivatives(theta, poses))
    assert np.isinf(off[4]).all()
    assert (rows[4] == 0.0).all()
    assert np.isfinite(np.delete(off, 4, axis=0)).all()
    weights = problem.weights.copy()
    problem.of_poses(weights)[4] = 0.0
    assert np.isfinite(projected(problem.derivatives(theta, poses, weights))[0]).all()


def test_a_start_out_of_its_bounds_begins_at_their_edge() -> None:
    """Home lengths, which no file has, start at 0: the answer is within the bounds, or reported to end there."""
    made = simulate_calibration(WANG, 20, 1e-4, seed=1)
    low, high = made.home_lengths.min() - 0.1, made.home_lengths.max() + 0.1
    plan = CalibrationPlan(bounds=(Bound(name="length_offset", min=low, max=high),))
    problem = StraightProblem.of(WANG, made.measured, plan)
    found = fit(problem, problem.free, made.poses)
    assert (found.theta >= problem.limits[0]).all()
    assert (found.theta <= problem.limits[1]).all()


def test_the_value_of_the_file_at_either_end_of_its_bounds_is_no_edge() -> None:
    limits, start = np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]]), np.array([0.0, 1.0, np.nan])
    for values in (start, np.array([0.0, 1.0, 0.5])):
        assert not np.logical_or(*at_bound(values, limits, start)).any()
    low, high = at_bound(np.array([1.0, 0.0, 1.0]), limits, start)
    assert (low.tolist(), high.tolist()) == ([False, True, False], [True, False, True])
