"""Calibrations of robots on compliant mounts, by their description in the file: errors over sigma, machine by machine.

    python -m benchmarks.campaigns.compliant_mounts 100 9000    # so many of each kind, from this seed on

Mounts give by 1 to 5 um/N, which is known, unknown or ignored; every other one of `merlet2023` by a matrix, but where
they are unknown. 30 poses, lengths to 0.1 mm, tensions to 2 N, of straight lines to 0.5 N. Printed are the root mean
square of the errors of exit points after the best translation and yaw, the share of their coordinates within 1.96
sigmas by noise, and the mean square of all errors over their covariance by noise, in directions that the data do not
leave open.
"""

from __future__ import annotations

import sys
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.plan import CalibrationPlan, Sigmas
from cablewright.calibration.poses.simulation import SensorNoise, aligned, simulate_calibration
from cablewright.robot import Robot, load

Array = NDArray[np.float64]

ENCODER: Final = 1e-4  # m
ROUGH: Final = 0.02  # m
POSES: Final = 30
SETUPS: Final = (("merlet2023", "catenary", 2.0, True), ("paty2021", "catenary", 2.0, False))
STRAIGHT: Final = (("wang2021", "rigid", 0.5, False),)


def on_mounts(robot: Robot, rng: np.random.Generator, matrices: bool) -> Robot:
    """The robot on compliant mounts."""
    lines = []
    for at, line in enumerate(robot.lines):
        soft: object = float(rng.uniform(1e-6, 5e-6))
        if matrices and at % 2:
            turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
            matrix = turn @ np.diag(rng.uniform(1e-6, 5e-6, 3)) @ turn.T
            soft = tuple(map(tuple, (0.5 * (matrix + matrix.T)).tolist()))
        lines.append(line.model_dump() | {"exit_compliance": soft})
    return Robot.model_validate(robot.model_dump() | {"lines": lines})


def errors(found: Calibration, robot: Robot, home: Array) -> tuple[Array, Array, float]:
    """Errors (m, 3) of exit points, m, over sigma by noise too, and the mean square of all over their covariance."""
    file = np.array([line.exit_point for line in robot.lines])
    points, _ = aligned(found.problem.points(found.fit.theta), file)
    exits = np.array([each.name == "exit_point" for each in found.unknowns])
    known = np.array([each.name in ("exit_point", "length_offset") for each in found.unknowns])
    off = found.values[known] - np.append(file.ravel(), home)
    values, vectors = np.linalg.eigh(found.posterior.covariance[np.ix_(known, known)])
    kept = values > 1e-9 * values.max()
    square = float(np.mean((vectors[:, kept].T @ off) ** 2 / values[kept]))
    return points - file, (points - file) / found.noise_sigma[exits].reshape(-1, 3), square


def main(count: int, first: int) -> None:
    """Print a row for each setup, and for each description in the file."""
    print("| robot, lines | mounts | exit points, rms | within 1.96 sigma | square over covariance |")
    print("| --- | --- | --- | --- | --- |")
    for name, cable, noise, matrices in (*SETUPS, *STRAIGHT):
        plain, plan = load(name), CalibrationPlan(sigma=Sigmas(encoder=ENCODER, tension=noise))
        unknown = plan.model_copy(update={"unknowns": (*plan.unknowns, "exit_compliance")})
        for words, its, known in (("known", plan, True), ("unknown", unknown, False), ("ignored", plan, False)):
            rows = []
            for seed in range(first, first + count):
                soft = on_mounts(plain, np.random.default_rng(seed), matrices and words != "unknown")
                sensors = SensorNoise(tension=noise)
                made = simulate_calibration(soft, POSES, ENCODER, seed=seed, cable=cable, sensors=sensors, guess=ROUGH)
                robot = soft if known else plain
                found = calibrate(robot, made.measured, its, cable=cable, rough=ROUGH, outliers=False)
                rows.append(errors(found, plain, made.home_lengths))
            off, over, squares = (np.array(each) for each in zip(*rows, strict=True))
            print(
                f"| {name}, {cable} | {words} | {1e3 * np.sqrt(np.mean(off**2)):.2f} mm | "
                f"{100.0 * np.mean(np.abs(over) < 1.96):.1f} % | {np.mean(squares):.2f} |",
                flush=True,
            )


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
