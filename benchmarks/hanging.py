"""Calibration of lines that stretch and sag, from encoders and tensions: exactness, bound, speed, gross errors.

Also the result of straight, stiff lines on the same data: the cost of neglecting sag.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from benchmarks.timing import Row
from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.plan import CalibrationPlan, Sigmas
from cablewright.calibration.poses.elastic import ElasticProblem
from cablewright.calibration.poses.fit import NEAR, fit
from cablewright.calibration.poses.simulation import SensorNoise, SimulatedCalibration, aligned, measure, random_poses
from cablewright.calibration.unknowns import unknowns_of, with_values
from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import Robot, load
from cablewright.solvers.inverse import solve_inverse

Array = NDArray[np.float64]
ALL = ("exit_point", "length_offset", "modulus")
OFF, ROUGH = 0.05, 0.5  # m: of exit points in the file, and of poses the first
SOFT = 0.8  # the true modulus over the file's
ENCODER, CELL = 1e-4, 5.0  # m, N
GROSS, GROSS_CELL = 0.05, 200.0


@dataclass(frozen=True)
class Size:
    """How often it is calibrated."""

    exact: int = 30
    noisy: int = 60
    spoiled: int = 20
    poses: int = 40  # of the fit beside SciPy's


FULL, QUICK = Size(), Size(1, 2, 1, 8)


def rows(size: Size) -> Iterator[Row]:
    """All rows of this file."""
    for name, count, off in (("paty2021", 30, OFF), ("merlet2023", 30, OFF), ("cogiro", 20, OFF)):
        yield from exact_rows(name, count, off, size.exact)
    for name, count in (("paty2021", 30), ("cogiro", 20)):
        yield from exact_rows(name, count, ROUGH, size.exact)
    yield from straight_rows()
    yield from bound_rows(size.noisy)
    yield speed_row(size.poses)
    yield gross_row(size.spoiled)


def machine(name: str) -> Robot:
    """The robot that is measured: its cables are softer than its file says."""
    robot = load(name)
    return with_values(robot, unknowns_of(robot, ("modulus",), ("modulus",), elastic=True), np.array([SOFT]))


def file_of(name: str, rng: np.random.Generator, off: float) -> Robot:
    """The robot as it is described: exit points up to *off* (m) wrong in each coordinate, winches with them."""
    robot = load(name)
    exits = np.array([line.exit_point for line in robot.lines])
    wrong = exits + rng.uniform(-off, off, exits.shape)
    return with_values(robot, unknowns_of(robot, ("exit_point",)), wrong.ravel(), raised=True)


def plan(encoder: float = ENCODER, tension: float = CELL) -> CalibrationPlan:
    """Geometry, home lengths and one modulus."""
    return CalibrationPlan(unknowns=ALL, shared=("modulus",), sigma=Sigmas(encoder=encoder, tension=tension))


def errors(found: Calibration, made: SimulatedCalibration, robot: Robot) -> tuple[float, float]:
    """Largest errors of exit points and of poses, m, after aligning translation and yaw."""
    truth = np.array([line.exit_point for line in robot.lines])
    exits, poses = aligned(found.values[: truth.size].reshape(-1, 3), truth, found.poses[:, :3])
    return float(np.abs(exits - truth).max()), float(np.abs(poses - made.poses[:, :3]).max())


def exact_rows(name: str, count: int, off: float, runs: int) -> Iterator[Row]:
    """The worst error of any run without noise, and the time of a calibration."""
    truth, worst, spent = machine(name), 0.0, 0.0
    for seed in range(runs):
        rng = np.random.default_rng(seed)
        poses = random_poses(truth, count, rng, "catenary")
        made = measure(truth, poses, 0.0, rng, OFF, "catenary", SensorNoise(tension=0.0))
        begin = time.perf_counter()
        found = calibrate(file_of(name, rng, off), made.measured, plan(), cable="catenary", rough=off, outliers=False)
        spent += time.perf_counter() - begin
        worst = max(worst, *errors(found, made, truth)) if found.status == "ok" else np.inf
    told = f"{name}, lines sag, {count} poses, {off:g} m off, worst of {runs}"
    yield Row(told, 1e9 * worst, "nm", "< 1000", 1e9 * worst < 1000.0)
    yield Row(f"{name}, lines sag, {count} poses, {off:g} m off: a run", 1e3 * spent / runs, "ms")


def straight_rows() -> Iterator[Row]:
    """What straight, stiff lines make of data without noise: the shape, aligned by any rotation, and the poses."""
    for name, with_cells in (("paty2021", False), ("merlet2023", False), ("cogiro", False), ("paty2021", True)):
        truth, rng = load(name), np.random.default_rng(1)
        exits = np.array([line.exit_point for line in truth.lines])
        beside = SensorNoise(tension=0.0 if with_cells else None)
        made = measure(truth, random_poses(truth, 30, rng, "catenary"), 0.0, rng, OFF, "catenary", beside)
        found = calibrate(truth, made.measured, rough=0.0, outliers=False)
        shape, places = aligned(found.values[: exits.size].reshape(-1, 3), exits, found.poses[:, :3], tilt=True)
        told = f"{name}, straight lines" + (", tensions" if with_cells else "")
        yield Row(f"{told}: lengths fit to, rms", 1e3 * found.rms, "mm")
        yield Row(f"{told}: exit points off", 1e3 * float(np.abs(shape - exits).max()), "mm")
        off = np.linalg.norm(places - made.poses[:, :3], axis=1)
        yield Row(f"{told}: poses off, median", 1e3 * float(np.median(off)), "mm")


def bound_rows(runs: int) -> Iterator[Row]:
    """Errors against the Cramer-Rao bound in the same frame, and how often sigma covers them."""
    robot, rng = load("paty2021"), np.random.default_rng(7)
    truth = np.array([line.exit_point for line in robot.lines])
    poses, beside = random_poses(robot, 40, rng, "catenary"), SensorNoise(tension=CELL)
    square, bound, shares = [], [], []
    for _ in range(runs):
        made = measure(robot, poses, ENCODER, rng, 0.02, "catenary", beside)
        asked = plan().model_copy(update={"unknowns": ALL[:2], "shared": ()})
        found = calibrate(robot, made.measured, asked, cable="catenary", rough=0.0, outliers=False)
        exits, _ = aligned(found.values[:12].reshape(-1, 3), truth)
        off = np.append((exits - truth).ravel(), found.values[12:] - made.home_lengths)
        square.append(off**2)
        bound.append(found.noise_sigma**2)
        shares.append(np.abs(off) / found.noise_sigma)
    ratio = float(np.sqrt(np.mean(square) / np.mean(bound)))
    yield Row("paty2021, 40 poses, 0.1 mm, 5 N: rms over the bound", ratio, "", "0.85..1.15", 0.85 <= ratio <= 1.15)
    for times, share in ((1.0, 68.3), (1.96, 95.0)):
        inside = 100.0 * float(np.mean(np.array(shares) < times))
        yield Row(
            f"lines sag: errors within {times:g} sigma", inside, "%", f"{share:g} +- 5", abs(inside - share) < 5.0
        )


def speed_row(count: int) -> Row:
    """One fit of paty2021 from near, beside SciPy with the same rows and derivatives."""
    robot, rng = load("paty2021"), np.random.default_rng(2)
    poses = random_poses(robot, count, rng, "catenary")
    made = measure(robot, poses, ENCODER, rng, OFF, "catenary", SensorNoise(tension=CELL))
    problem = ElasticProblem.of(Model(robot, Fidelity.of("catenary")), made.measured, plan(), hold=False)
    own = problem.states_of(solve_inverse(problem.model, made.poses))
    theta = problem.free.copy()
    theta[[each.name == "length_offset" for each in problem.unknowns]] = made.home_lengths
    theta += rng.uniform(-2e-3, 2e-3, len(theta))
    k, m = len(theta), robot.m

    def at(x: Array) -> Array:
        moved = own.copy()
        moved[:, :m] = x[k:].reshape(-1, m)
        return moved

    def jacobian(x: Array) -> Array:
        found = problem.derivatives(x[:k], at(x))
        count, e, _ = found.by_pose.shape
        out = np.zeros((count * e, len(x)))
        out[:, :k] = found.by_unknown.reshape(-1, k)
        for j in range(count):
            out[j * e : (j + 1) * e, k + m * j : k + m * (j + 1)] = found.by_pose[j]
        return out

    def residual(x: Array) -> Array:
        return problem.derivatives(x[:k], at(x)).residual.ravel()

    start = np.append(theta, own[:, :m].ravel())
    times = []
    for solve in (lambda: fit(problem, theta, own, settings=NEAR), lambda: least_squares(residual, start, jacobian)):
        solve()
        begin = time.perf_counter()
        solve()
        times.append(time.perf_counter() - begin)
    return Row(
        f"lines sag: a fit of {count} poses", 1e3 * times[0], "ms", "", None, "SciPy, same rows", times[1] / times[0]
    )


def gross_row(runs: int) -> Row:
    """2 of 40 poses with an encoder 50 mm off, 2 with a load cell 200 N off: exactly those left out."""
    robot, good = load("paty2021"), 0
    for seed in range(runs):
        rng = np.random.default_rng(seed)
        poses = random_poses(robot, 40, rng, "catenary")
        made = measure(robot, poses, ENCODER, rng, 0.02, "catenary", SensorNoise(tension=CELL))
        assert made.measured.tensions is not None
        counted, tensions = made.measured.counted.copy(), made.measured.tensions.copy()
        bad = rng.choice(40, 4, replace=False)
        counted[bad[:2], rng.integers(0, 4, 2)] += GROSS
        tensions[bad[2:], rng.integers(0, 4, 2)] += GROSS_CELL
        measured = replace(made.measured, counted=counted, tensions=tensions)
        found = calibrate(robot, measured, plan(), cable="catenary", rough=0.02)
        good += {each.pose for each in found.rejected} == set(bad.tolist())
    share = 100.0 * good / runs
    return Row("lines sag, 4 of 40 poses spoiled: exactly those out", share, "% of runs", ">= 95", share >= 95.0)
