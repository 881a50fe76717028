"""Sensors with wrong zeros, found by a calibration: errors over sigma, machine by machine.

    python -m benchmarks.campaigns.sensor_zeros 40 0    # so many of each kind, from this seed on

Swivels and yaw are zeroed anywhere, accelerometers 20 mrad and load cells 20 N off, their scales 5 %. Printed are, over
all offsets and scales: the mean and the root mean square of the error over the sigma by noise, and over the sigma that
is reported; and the share of coordinates of exit points within 1.96 sigma, after the best translation and yaw.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan, Sigmas
from cablewright.calibration.poses.simulation import SensorNoise, aligned, simulate_calibration
from cablewright.models.rotation import wrap_angle
from cablewright.robot import load

Array = NDArray[np.float64]

ENCODER: Final = 1e-4  # m
ROUGH: Final = 0.05  # m
CELL, TILT, SCALE = 20.0, 0.02, 0.05  # N, rad, 1


@dataclass(frozen=True)
class Setup:
    """A robot with sensors: what is unknown of them."""

    robot: str
    cable: str
    noise: SensorNoise
    unknowns: tuple[str, ...]


SETUPS: Final = (
    Setup("wang2021", "rigid", SensorNoise(swivel=1e-3), ("swivel_offset",)),
    Setup("wang2021", "rigid", SensorNoise(tension=2.0), ("tension_offset", "tension_scale")),
    Setup("cogiro", "rigid", SensorNoise(tilt=1e-3, yaw=1e-2), ("tilt_offset", "yaw_offset")),
    Setup("paty2021", "catenary", SensorNoise(tension=5.0), ("tension_offset", "tension_scale")),
)


def spoiled(measured: Measured, rng: np.random.Generator) -> tuple[Measured, dict[str, Array]]:
    """The readings of sensors with errors of zero and scale, and these errors by the name of the unknown."""
    true: dict[str, Array] = {}
    if measured.tensions is not None:
        m = measured.tensions.shape[1]
        true |= {"tension_offset": rng.normal(0.0, CELL, m), "tension_scale": rng.normal(1.0, SCALE, m)}
        measured = replace(measured, tensions=(measured.tensions - true["tension_offset"]) / true["tension_scale"])
    if measured.swivel is not None:
        true["swivel_offset"] = rng.uniform(-3.0, 3.0, measured.swivel.shape[1])
        measured = replace(measured, swivel=measured.swivel - true["swivel_offset"])
    if measured.tilt is not None:
        true["tilt_offset"] = rng.normal(0.0, TILT, 2)
        measured = replace(measured, tilt=measured.tilt - true["tilt_offset"])
    if measured.yaw is not None:
        true["yaw_offset"] = rng.uniform(-3.0, 3.0, 1)
        measured = replace(measured, yaw=measured.yaw - true["yaw_offset"])
    return measured, true


def errors(found: Calibration, true: dict[str, Array]) -> Iterator[tuple[float, float]]:
    """Yield the error of each offset and scale over its sigma by noise, and over the reported one."""
    left = {name: list(values) for name, values in true.items()}
    for each, value, sigma, noise in zip(found.unknowns, found.values, found.sigma, found.noise_sigma, strict=True):
        if each.name not in left:
            continue
        off = float(value) - left[each.name].pop(0)
        if each.unit == "rad":
            off = wrap_angle(off)
        yield off / float(noise), off / float(sigma)


def main(count: int, first: int) -> None:
    """Print a row for each setup."""
    print(
        "| robot, lines, unknown | verdicts | over sigma by noise: mean, rms | over sigma: rms | exit points within |"
    )
    print("| --- | --- | --- | --- | --- |")
    for setup in SETUPS:
        robot, pulls, inside, verdicts = load(setup.robot), [], [], []
        file = np.array([line.exit_point for line in robot.lines])
        plan = CalibrationPlan(
            unknowns=("exit_point", "length_offset", *setup.unknowns),
            sigma=Sigmas(encoder=ENCODER, tension=setup.noise.tension or 5.0),
        )
        for seed in range(first, first + count):
            made = simulate_calibration(robot, 40, ENCODER, seed=seed, cable=setup.cable, sensors=setup.noise).measured
            measured, true = spoiled(made, np.random.default_rng((seed, 1)))
            found = calibrate(robot, measured, plan, cable=setup.cable, rough=ROUGH)
            verdicts.append(found.verdict if found.status == "ok" else found.status)
            if found.status != "ok":
                continue
            pulls += list(errors(found, true))
            points, _ = aligned(found.problem.points(found.fit.theta), file)
            exits = np.array([each.name == "exit_point" for each in found.unknowns])
            inside.append(np.abs(points - file).ravel() < 1.96 * found.sigma[exits])
        by_noise, told = np.array(pulls).T
        print(
            f"| {setup.robot}, {setup.cable}, {', '.join(setup.unknowns)} | "
            f"{', '.join(f'{verdicts.count(each)} {each}' for each in sorted(set(verdicts)))} | "
            f"{by_noise.mean():.2f}, {np.sqrt(np.mean(by_noise**2)):.2f} | {np.sqrt(np.mean(told**2)):.2f} | "
            f"{100.0 * np.mean(inside):.1f} % |",
            flush=True,
        )


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
