"""Self-calibration of `wang2021`: how fast, how exact, against the bound, with gross errors, from rough dimensions."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from benchmarks.timing import Row, best
from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.measurements import Measured
from cablewright.calibration.poses.fit import NEAR, fits
from cablewright.calibration.poses.observability import information
from cablewright.calibration.poses.problem import CalibrationProblem, StraightProblem
from cablewright.calibration.poses.simulation import SimulatedCalibration, aligned, measure, random_poses
from cablewright.robot import Robot, load

Array = NDArray[np.float64]
WANG = load("wang2021")
TRUE = np.array([line.exit_point for line in WANG.lines])
OFF = 0.05  # m: of starts, in each coordinate
NOISE = 1e-4  # m
GROSS = 0.05  # m


@dataclass(frozen=True)
class Size:
    """How often it is calibrated."""

    runs: int = 500  # without noise
    few: int = 10  # of them by SciPy too ...
    poses: int = 40  # ... of so many poses
    drawn: int = 200  # with noise, with gross errors, and from rough dimensions


FULL, QUICK = Size(), Size(5, 1, 16, 2)


def rows(size: Size) -> Iterator[Row]:
    """All rows of this file."""
    yield from speed_rows(size)
    yield from exact_rows(size.runs)
    yield from bound_rows(size.drawn)
    yield gross_row(size.drawn)
    yield rough_row(size.drawn)


def made(count: int, noise: float, seed: int = 0) -> tuple[CalibrationProblem, SimulatedCalibration, Array]:
    """A problem, what is true of it, and its true unknowns."""
    rng = np.random.default_rng(seed)
    simulated = measure(WANG, random_poses(WANG, count, rng), noise, rng)
    problem = StraightProblem.of(WANG, simulated.measured)
    return problem, simulated, np.append(TRUE.ravel(), simulated.home_lengths)


def starts(truth: Array, simulated: SimulatedCalibration, runs: int) -> tuple[Array, Array]:
    """Unknowns (B, k) and poses (B, N, 3) about the true ones."""
    rng = np.random.default_rng(1)
    poses = simulated.poses + rng.uniform(-OFF, OFF, (runs, *simulated.poses.shape))
    return truth + rng.uniform(-OFF, OFF, (runs, len(truth))), poses


def speed_rows(size: Size) -> Iterator[Row]:
    """Many runs of some poses; one of 1000; and SciPy with the same Jacobian from the same starts."""
    problem, simulated, truth = made(size.poses, 0.0)
    theta, poses = starts(truth, simulated, size.runs)
    ours = best(lambda: fits(problem, theta, poses, settings=NEAR), 3)
    few = theta[: size.few], poses[: size.few]
    ratio = min(scipy_time(problem, *few, method) for method in ("trf", "lm")) / (ours / size.runs)
    name = f"calibrate {size.poses} poses, {size.runs} runs on one core"
    yield Row(name, ours, "s", "<= 1", ours <= 1.0, "SciPy, same Jacobian, the faster of trf and lm", ratio)
    yield Row("the same: SciPy's time over ours", ratio, "", ">= 20", ratio >= 20.0)
    problem, simulated, truth = made(1000, 0.0)
    theta, poses = starts(truth, simulated, 1)
    one = 1e3 * best(lambda: fits(problem, theta, poses, settings=NEAR))
    yield Row("calibrate 1000 poses", one, "ms", "<= 50", one <= 50.0)


def scipy_time(problem: CalibrationProblem, theta: Array, poses: Array, method: str) -> float:
    """Mean time of a run, s."""
    scipy_fit(problem, theta[0], poses[0], method)
    begin = time.perf_counter()
    for run in range(len(theta)):
        scipy_fit(problem, theta[run], poses[run], method)
    return (time.perf_counter() - begin) / len(theta)


def scipy_fit(problem: CalibrationProblem, theta: Array, poses: Array, method: str) -> object:
    """The same equations by dense least squares, without a gauge, to SciPy's usual tolerances."""
    k, (count, e) = len(theta), (problem.poses, problem.per_pose)

    def residual(x: Array) -> Array:
        return problem.derivatives(x[:k], x[k:].reshape(-1, 3)).residual.ravel()

    def jacobian(x: Array) -> Array:
        found = problem.derivatives(x[:k], x[k:].reshape(-1, 3))
        out = np.zeros((count * e, len(x)))
        out[:, :k] = found.by_unknown.reshape(-1, k)
        for j in range(count):
            out[j * e : (j + 1) * e, k + 3 * j : k + 3 * j + 3] = found.by_pose[j]
        return out

    return least_squares(residual, np.append(theta, poses.ravel()), jacobian, method=method)


def exact_rows(runs: int) -> Iterator[Row]:
    """The worst error of any of the runs without noise, aligned."""
    for count in (12, 13, 16, 20, 30, 40):
        problem, simulated, truth = made(count, 0.0, count)
        worst = 0.0
        for found in fits(problem, *starts(truth, simulated, runs), settings=NEAR):
            exits, poses = aligned(found.theta[:12].reshape(4, 3), TRUE, found.poses)
            off = (exits - TRUE, found.theta[12:] - truth[12:], poses - simulated.poses)
            worst = max(worst, *(float(np.abs(part).max()) for part in off))
        nanometres = 1e9 * worst
        name = f"{count} poses without noise, worst of {runs} runs, aligned"
        yield Row(name, nanometres, "nm", "< 1", nanometres < 1.0)


def bound_rows(runs: int) -> Iterator[Row]:
    """Runs with noise: against the Cramer-Rao bound in the same frame, and how often sigma covers the error."""
    problem, simulated, truth = made(40, NOISE, 7)
    rng = np.random.default_rng(8)
    errors, shares = [], []
    for _ in range(runs):
        again = measure(WANG, simulated.poses, NOISE, rng)
        found = calibrate(WANG, again.measured)
        exits, _ = aligned(found.values[:12].reshape(4, 3), TRUE)
        errors.append(np.append((exits - TRUE).ravel(), found.values[12:] - truth[12:]))
        shares.append(np.abs(errors[-1]) / found.noise_sigma)
    bound = np.diag(information(problem, truth, simulated.poses, problem.weights).covariance)
    square = np.array(errors) ** 2
    for name, part in (("exit points", slice(0, 12)), ("home lengths", slice(12, 16))):
        ratio = float(np.sqrt(np.mean(square[:, part]) / np.mean(bound[part])))
        yield Row(f"40 poses, 0.1 mm: rms of {name} over the bound", ratio, "", "0.85..1.15", 0.85 <= ratio <= 1.15)
    inside = np.array(shares)
    for times, share in ((1.0, 68.3), (1.96, 95.0)):
        found_share = 100.0 * float(np.mean(inside < times))
        met = abs(found_share - share) < 5.0
        yield Row(f"errors within {times:g} sigma", found_share, "%", f"{share:g} +- 5", met)


def gross_row(runs: int) -> Row:
    """5 % of 100 poses with a gross error in one line: exactly those found."""
    good = 0
    for seed in range(runs):
        rng = np.random.default_rng(seed)
        simulated = measure(WANG, random_poses(WANG, 100, rng), NOISE, rng)
        counted, bad = simulated.measured.counted.copy(), rng.choice(100, 5, replace=False)
        counted[bad, rng.integers(0, 4, 5)] += GROSS * rng.choice([-1.0, 1.0], 5)
        found = calibrate(WANG, Measured(counted, simulated.measured.guess))
        good += {each.pose for each in found.rejected} == set(bad.tolist())
    share = 100.0 * good / runs
    return Row("5 of 100 poses off by 50 mm: exactly those left out", share, "% of runs", ">= 95", share >= 95.0)


def rough_row(runs: int) -> Row:
    """Random layouts, known to half a metre, no guesses of poses: the true shape found."""
    good = sum(found_from_rough(seed) for seed in range(runs))
    share = 100.0 * good / runs
    return Row(f"{runs} layouts known to 0.5 m: right", share, "%", ">= 95", share >= 95.0)


def found_from_rough(seed: int) -> bool:
    """Whether one of them is found."""
    rng = np.random.default_rng(seed)
    corners = TRUE[:, :2] + rng.uniform(-0.5, 0.5, (4, 2))
    truth = np.column_stack([corners, rng.uniform(0.2, 3.0, 4)])
    poses = rng.uniform([-1.4, -1.2, 0.4], [1.4, 1.2, 2.4], (40, 3))
    simulated = measure(with_exits(truth), poses, 0.0, rng)
    file = with_exits(truth + rng.uniform(-0.5, 0.5, (4, 3)))
    found = calibrate(file, Measured(simulated.measured.counted), seed=seed, outliers=False)
    exits, _ = aligned(found.values[:12].reshape(4, 3), truth)
    return bool(np.abs(exits - truth).max() < 1e-6)


def with_exits(exits: Array) -> Robot:
    """`wang2021` with other exit points."""
    places = zip(WANG.lines, exits.tolist(), strict=True)
    lines = tuple(line.model_copy(update={"exit_point": tuple(place)}) for line, place in places)
    return WANG.model_copy(update={"lines": lines})
