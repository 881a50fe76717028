"""Calibration of simulated machines with the defects of makers' machines, against an oracle that knows these.

``python -m benchmarks.campaigns.twins 200 0``. Two kinds of machines, each calibrated from 44 poses, of which 9 are
measured, by `calibrate(models="auto")` and by an oracle with the true build-up, counts without stretch and deflection,
and good positions:

* spools: a printer with 4 lines of two spans. Friction of its eyelets changes tensions by 3 % either way, EA is 20 %
  less than in the file, the build-up of its spools is known to 10 %, 3 of the 9 positions are wrong by 3 mm, anchors
  give 2 um/N.
* belts: 4 toothed belts to a point, which stretch by 0.2 % at their mean tension, 20 % less by the file, on a frame
  that bends by 2 mm at the mean force.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.judgement.effects import corrections
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan, Known, Prior, Sigmas
from cablewright.calibration.poses.fit import fitted_poses
from cablewright.calibration.poses.problem import StraightProblem
from cablewright.calibration.poses.simulation import measure, random_poses
from cablewright.models.drum import WinchDrum
from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import Robot, load
from cablewright.solvers.inverse import solve_inverse

Array = NDArray[np.float64]
POSES, KNOWN, HELD_OUT = 44, 9, 40
ROUGH = 0.01  # m: of the file's exit points
NOISE, POSITION = 2e-4, 1e-3  # m
BUILD_UP = 5e-3  # 1/m
FRICTION, SOFTER, OFF, WRONG, GIVES = 0.03, 0.8, 0.1, 3e-3, 2e-6
STRETCH, BENDING = 2e-3, 2e-3


@dataclass(frozen=True)
class Twin:
    """A machine's file and data, what an oracle would have instead, and what is true."""

    file: Robot
    measured: Measured
    plan: CalibrationPlan
    oracle: Measured
    oracle_plan: CalibrationPlan
    exits: Array  # (3 m,)
    poses: Array  # (HELD_OUT, 3)
    counts: Array  # (HELD_OUT, m)
    oracle_counts: Array


def spools(seed: int) -> Twin:
    """A spool printer."""
    robot, rng = load("hangprinter-v4"), np.random.default_rng(seed)
    poses = random_poses(robot, POSES + HELD_OUT, rng)
    tensions = solve_inverse(Model(robot, Fidelity.of("rigid")), poses).tensions
    tensions = tensions * (1.0 + FRICTION * rng.choice([-1.0, 1.0], tensions.shape))
    lines = []
    for line in robot.lines:
        length = line.advantage * math.dist(line.exit_point, line.platform_point)
        winch = line.winch.model_copy(update={"build_up": BUILD_UP, "drum_length": length})
        lines.append(line.model_copy(update={"winch": winch}))
    robot = robot.model_copy(update={"lines": tuple(lines)})
    made = measure(robot, poses, 0.0, rng)
    lengths = made.measured.counted + made.home_lengths
    ea = SOFTER * np.array([line.cable.stiffness for line in robot.lines])
    spans = np.array([float(line.advantage) for line in robot.lines])
    less = tensions * (lengths / ea + spans**2 * GIVES)
    true = BUILD_UP * (1.0 + OFF * rng.normal())
    by_drum = [True] * robot.m
    plan = CalibrationPlan(
        unknowns=("exit_point", "length_offset", "build_up"),
        priors=(
            Prior(name="build_up", deviation=OFF * BUILD_UP),
            Prior(name="build_up", deviation=1e-5, alike=True),
        ),
    )
    right = tuple(
        line.model_copy(update={"winch": line.winch.model_copy(update={"build_up": true})}) for line in robot.lines
    )
    counted = _wound(robot.model_copy(update={"lines": right}), lengths - less)
    without = _wound(robot, lengths)
    return _twin(robot, rng, poses, counted, without, plan, by_drum, wrong=3)


def belts(seed: int) -> Twin:
    """A belt frame."""
    robot, rng = load("wang2021"), np.random.default_rng(seed)
    poses = random_poses(robot, POSES + HELD_OUT, rng)
    tensions = solve_inverse(Model(robot, Fidelity.of("rigid")), poses).tensions
    stiffness = {"axial_stiffness": tensions.mean() / STRETCH / SOFTER, "young_modulus": None, "section": None}
    lines = [line.model_copy(update={"cable": line.cable.model_copy(update=stiffness)}) for line in robot.lines]
    robot = robot.model_copy(update={"lines": tuple(lines)})
    made = measure(robot, poses, 0.0, rng)
    lengths = made.measured.counted + made.home_lengths
    share = tensions / tensions.mean()
    less = STRETCH * share * lengths + BENDING * share
    plan = CalibrationPlan(known=(Known(name="build_up", deviation=0.0),))
    return _twin(robot, rng, poses, lengths - less, lengths, plan, (), wrong=0)


def _wound(robot: Robot, lengths: Array) -> Array:
    """Return what the drums of a robot count, m by the radius in its file, as lines have *lengths* (N, m)."""
    found = np.zeros_like(lengths)
    for at, line in enumerate(robot.lines):
        radius, build_up = line.winch.drum_radius or 1.0, line.winch.build_up or 0.0
        drum = WinchDrum(radius, build_up=build_up, at=line.winch.drum_length or 0.0)
        found[:, at] = radius * drum.angles(lengths[:, at])
    return found


def _twin(
    robot: Robot,
    rng: np.random.Generator,
    poses: Array,
    counted: Array,
    without: Array,
    plan: CalibrationPlan,
    by_drum: list[bool] | tuple[()],
    wrong: int,
) -> Twin:
    noise = rng.normal(0.0, NOISE, counted.shape)
    counted, without = (each - each[0] + noise for each in (counted, without))
    exits = np.array([line.exit_point for line in robot.lines])
    file = robot.model_copy(
        update={
            "lines": tuple(
                line.model_copy(update={"exit_point": tuple((at + rng.uniform(-ROUGH, ROUGH, 3)).tolist())})
                for line, at in zip(robot.lines, exits, strict=True)
            )
        }
    )
    own = poses[:POSES]
    known = np.arange(POSES)[:, None] < KNOWN
    guess = np.where(known, own + rng.normal(0.0, POSITION, own.shape), own + rng.uniform(-0.05, 0.05, own.shape))
    ways = rng.normal(size=own.shape)
    bad = (np.arange(POSES)[:, None] < wrong) * WRONG * ways / np.linalg.norm(ways, axis=1, keepdims=True)
    sigma = np.where(known, POSITION, np.nan)
    sigma_of_good = np.where(np.arange(POSES)[:, None] < wrong, np.nan, sigma)
    oracle_plan = CalibrationPlan(known=(Known(name="build_up", deviation=0.0), Known(name="stretch", deviation=0.0)))
    return Twin(
        file,
        Measured(counted[:POSES], guess + bad, sigma, by_drum=by_drum),
        plan.model_copy(update={"sigma": Sigmas()}),
        Measured(without[:POSES], guess, sigma_of_good, by_drum=by_drum),
        oracle_plan,
        exits.ravel(),
        poses[POSES:],
        counted[POSES:],
        without[POSES:],
    )


def errors(twin: Twin, found: Calibration, counts: Array) -> Array:
    """Return the errors (HELD_OUT,) of positions, m, that the calibrated robot finds from *counts* (HELD_OUT, m)."""
    by_drum = found.problem.measured.by_drum
    chosen = {each.name: each.value for each in found.effects if each.chosen}
    poses = twin.poses + 0.01
    for _ in range(3):
        data = Measured(counts, poses, by_drum=by_drum)
        problem = StraightProblem.of(found.problem.robot, data, found.problem.plan.model_copy(update={"datum": ()}))
        fit = replace(found.fit, poses=poses, weights=problem.weights)
        more = corrections(problem, fit)
        longer = sum((value * more[name] for name, value in chosen.items() if name in more), np.zeros_like(counts))
        problem = StraightProblem.of(problem.robot, replace(data, counted=counts + longer), problem.plan)
        poses = fitted_poses(problem, found.fit.theta, poses)
    return np.asarray(np.linalg.norm(poses - twin.poses, axis=1))


def main(count: int, seed: int) -> None:
    """Print a line for each machine, and what all say."""
    for make in (spools, belts):
        rows = []
        for each in range(seed, seed + count):
            twin = make(each)
            found = calibrate(twin.file, twin.measured, twin.plan, rough=0.05, need=5e-3, models="auto")
            oracle = calibrate(twin.file, twin.oracle, twin.oracle_plan, rough=0.05, need=5e-3)
            own, best = (
                float(np.sqrt(np.mean(errors(twin, one, counts) ** 2)))
                for one, counts in ((found, twin.counts), (oracle, twin.oracle_counts))
            )
            off = found.values[: len(twin.exits)] - twin.exits
            spread = found.covariance[: len(off), : len(off)]
            square = float(off @ np.linalg.pinv(spread, hermitian=True) @ off)
            ratio = float(np.sqrt(np.mean((off / found.sigma[: len(off)]) ** 2)))
            chosen = ", ".join(one.name for one in found.effects if one.chosen)
            rows.append((own, best, square < _QUANTILE[len(off)], ratio, found.verdict))
            print(
                f"{make.__name__} {each}: held out {1e3 * own:.2f} mm, oracle {1e3 * best:.2f} mm, seen over printed "
                f"{ratio:.2f}, {'in' if rows[-1][2] else 'OUT'}, {found.verdict}, {chosen or '-'}",
                flush=True,
            )
        own, best, inside, ratio = (np.array(each, dtype=float) for each in list(zip(*rows, strict=True))[:4])
        print(
            f"{make.__name__}: held out over oracle, rms {np.sqrt(np.mean(own**2) / np.mean(best**2)):.2f}, median "
            f"{np.median(own / best):.2f}; joint coverage of 95 % {100 * inside.mean():.1f} %; seen over printed, rms "
            f"{np.sqrt(np.mean(ratio**2)):.2f}"
        )


_QUANTILE = {12: 21.026}  # chi-square, 95 %

if __name__ == "__main__":
    given = [int(each) for each in sys.argv[1:]] + [20, 0][len(sys.argv) - 1 :]
    main(*given)
