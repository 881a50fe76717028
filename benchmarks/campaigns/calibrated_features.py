"""Calibration of robots with features beside plain lines, against the Cramer-Rao bound.

``python -m benchmarks.campaigns.calibrated_features 100 0 [KINDS]``, KINDS with commas: machines a kind, first seed.
The model and all given sigmas are right, exit points of the file are within 10 mm, poses are measured to 1 mm (1 mrad):

* advantage: the Hangprinter, two spans a line; stretching: the same with lines that stretch and load cells;
* swivels: a point on four swivels with tilted axes, whose angle sensors have unknown zeros;
* guides: the same point with eyelets behind two guides each;
* body: eight lines of `cogiro` with an accelerometer, whose mounting is unknown;
* suspended: the body on four lines of `benchmarks.campaigns.twins`, without measured positions.

Columns: errors of all unknowns of known truth over the bound, rms, in the directions of its covariance; share of exit
points' coordinates within 1.96 of the printed sigma; whether they are in the joint 95 % ellipsoid; good verdicts.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.campaigns import twins
from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan, Known, Sigmas
from cablewright.calibration.poses.simulation import SensorNoise, measure, random_poses
from cablewright.robot import Eyelet, Robot, Swivel, load

Array = NDArray[np.float64]
POSES, NOISE, POSITION, ANGLE, CELL = 40, 1e-4, 1e-3, 1e-3, 0.2  # m, m, rad, N
ROUGH = 0.01  # m
EXACT = ("build_up", "sheave_radius", "stretch", "tension_scale", "modulus")


class Case(NamedTuple):
    """A machine's file and data, the plan, and what is true of each unknown; NaN: not known."""

    file: Robot
    measured: Measured
    plan: CalibrationPlan
    truth: Array  # (k,)
    cable: str = "rigid"


def made(robot: Robot, seed: int, cable: str = "rigid", zeros: dict[str, float] | None = None, **noise: float) -> Case:
    """Return data of a *robot*, with *zeros* of sensors drawn to these standard deviations."""
    rng, zeros = np.random.default_rng(seed), zeros or {}
    sensors = SensorNoise(pose=POSITION, **noise)
    found = measure(robot, random_poses(robot, POSES, rng, cable), NOISE, rng, cable=cable, sensors=sensors)
    measured, offsets = found.measured, []
    for name, spread in zeros.items():
        read = getattr(measured, name)
        offsets.append(rng.normal(0.0, spread, read.shape[1]))
        measured = replace(measured, **{name: read - offsets[-1]})
    exits = np.array([line.exit_point for line in robot.lines])
    lines = zip(robot.lines, exits + rng.uniform(-ROUGH, ROUGH, exits.shape), strict=True)
    file = robot.model_copy(
        update={"lines": tuple(line.model_copy(update={"exit_point": tuple(to.tolist())}) for line, to in lines)}
    )
    names = [*noise, "encoder"]
    exact = [name for name in EXACT if _may_be_known(name, robot, cable, noise)]
    plan = CalibrationPlan(
        unknowns=("exit_point", "length_offset", *(f"{name}_offset" for name in zeros)),
        sigma=Sigmas(**({"encoder": NOISE} | {name: noise[name] for name in names[:-1]})),
        known=tuple(Known(name=name, deviation=0.0) for name in exact),
    )
    return Case(file, measured, plan, np.concatenate([exits.ravel(), found.home_lengths, *offsets]), cable)


def _may_be_known(name: str, robot: Robot, cable: str, noise: dict[str, float]) -> bool:
    """Whether a plan of this robot can say that a number is exact."""
    if name == "sheave_radius":
        return not isinstance(robot.lines[0].sheave, Eyelet)
    if name == "tension_scale":
        return "tension" in noise
    return (name == "modulus") == (cable != "rigid") if name in ("modulus", "stretch") else True


def over(robot: Robot, **parts: Callable[[Array, int], Any]) -> Robot:
    """Return the robot with other *parts* of its lines, by their exit point (3,) and index."""
    lines = [
        line.model_copy(update={name: of(np.array(line.exit_point), i) for name, of in parts.items()})
        for i, line in enumerate(robot.lines)
    ]
    return Robot.model_validate(robot.model_copy(update={"lines": tuple(lines)}).model_dump())


def advantage(seed: int) -> Case:
    """A Hangprinter."""
    return made(load("hangprinter-v4"), seed)


def stretching(seed: int) -> Case:
    """A Hangprinter whose lines stretch."""
    return made(load("hangprinter-v4"), seed, "elastic", tension=CELL)


def swivels(seed: int) -> Case:
    """Swivels out of the vertical."""
    axes = np.random.default_rng(seed + 10**6).normal(0.0, 0.3, (4, 2))
    robot = over(load("wang2021"), sheave=lambda _, i: Swivel(radius=0.075, axis=(*axes[i].tolist(), 1.0)))
    return made(robot, seed, zeros={"swivel": 0.1}, swivel=ANGLE)


def guides(seed: int) -> Case:
    """Eyelets behind guides."""
    ways = np.array([(0.5, 0.2, -2.0), (0.3, 0.1, 0.2)])
    robot = over(
        load("wang2021"),
        sheave=lambda _, __: Eyelet(),
        winch_exit=lambda at, _: tuple((at - [0.0, 0.0, 3.0]).tolist()),
        guides=lambda at, _: tuple(tuple((at + way).tolist()) for way in ways),
    )
    return made(robot, seed)


def body(seed: int) -> Case:
    """Eight lines."""
    return made(load("cogiro"), seed, zeros={"tilt": 0.01}, tilt=ANGLE)


def suspended(seed: int) -> Case:
    """A body on four lines."""
    twin = twins.suspended(seed)
    return Case(twin.file, twin.measured, twin.plan, twin.exits, twin.law)


KINDS = {each.__name__: each for each in (advantage, stretching, swivels, guides, body, suspended)}


def main(count: int, seed: int, kinds: str) -> None:
    """Print a line a kind."""
    for name in kinds.split(","):
        white, inside, joint, good, failed = [], [], [], [], 0
        for each in range(seed, seed + count):
            case = KINDS[name](each)
            found = calibrate(case.file, case.measured, case.plan, rough=0.05, need=5e-3, cable=case.cable)
            if found.status != "ok":
                failed += 1
                print(f"{name} {each}: {found.reason}", flush=True)
                continue
            k, e = len(case.truth), 3 * case.file.m
            off, sizes = found.values[:k] - case.truth, np.array([one.size for one in found.unknowns[:k]])
            bound = found.posterior.covariance[:k, :k] * np.outer(sizes, sizes) * found.scale**2
            unit = np.sqrt(np.diag(bound))
            values, ways = np.linalg.eigh(bound / np.outer(unit, unit))
            white.append((ways.T @ (off / unit)) / np.sqrt(values))
            inside.append(np.abs(off[:e]) < 1.96 * found.sigma[:e])
            own = found.covariance[:e, :e]
            joint.append(float(off[:e] @ np.linalg.solve(own, off[:e])) < found.joint_limit(e))
            good.append(found.verdict == "good")
        print(
            f"{name}, {len(white)} of {count}: over the bound, rms {np.sqrt(np.mean(np.square(white))):.3f}; within "
            f"1.96 sigma {100 * np.mean(inside):.1f} %; joint {100 * np.mean(joint):.1f} %; "
            f"good {100 * np.mean(good):.0f} %",
            flush=True,
        )


if __name__ == "__main__":
    given = [*sys.argv[1:], *["20", "0", ",".join(KINDS)][len(sys.argv) - 1 :]]
    main(int(given[0]), int(given[1]), given[2])
