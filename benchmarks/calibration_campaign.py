"""Calibrations of machines with effects that the model does not have: how often a good verdict is right.

`python -m benchmarks.calibration_campaign [MACHINES] [SEED]` draws machines SEED, SEED + 1, .. and the effects on each:
lines that stretch, spools that build up, sheaves of another radius, surveyed points with errors of 3 mm, 10 % of the
rows with a gross error, columns of two lines exchanged. Each is calibrated with straight lines, as if there were none.

It prints what share of the good verdicts are right: the true exit points are in the joint ellipsoid of 99.7 %, and
within three times the need. Shares come with their 95 % interval (Clopper and Pearson); that of the coverage, which
counts all coordinates of a machine, is for as many numbers as there are machines.
"""

from __future__ import annotations

import sys
from collections import Counter
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from benchmarks.calibration import WANG
from benchmarks.timing import interval
from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan, Point
from cablewright.calibration.poses.simulation import measure, random_poses
from cablewright.calibration.unknowns import unknowns_of, with_values
from cablewright.robot import Robot, load

Array = NDArray[np.float64]
NEED = 5e-3  # m
WRONG = 3e-3  # m: of a surveyed point
GROSS = (5e-3, 0.1)  # m
RATES = {"flex": 0.35, "build-up": 0.25, "radius": 0.25, "wrong points": 0.25, "gross": 0.5, "exchanged": 0.1}
"""How probable each effect is."""


@dataclass(frozen=True, eq=False)
class Machine:
    """A machine, its file, what was measured of it, and what is the matter with it."""

    robot: Robot  # as it is
    file: Robot
    measured: Measured
    plan: CalibrationPlan
    effects: frozenset[str]

    @property
    def exits(self) -> Array:
        """The true exit points (m, 3), m."""
        return np.array([line.exit_point for line in self.robot.lines])


def drawn(seed: int) -> Machine:
    """A random machine and its data."""
    rng = np.random.default_rng(seed)
    effects = frozenset(name for name, rate in RATES.items() if rng.random() < rate)
    robot = _moved(load("cogiro") if rng.random() < 0.25 else WANG, 0.2, rng)
    if "flex" in effects:
        robot = _stretching(robot, 10.0 ** rng.uniform(-1.0, 0.5))
    cable = "elastic" if "flex" in effects else "rigid"
    poses = random_poses(robot, int(rng.integers(25, 70)), rng, cable)
    made = measure(robot, poses, 10.0 ** rng.uniform(-4.3, -3.5), rng, cable=cable)
    counted = made.measured.counted.copy()
    if "build-up" in effects:
        rate = 10.0 ** rng.uniform(-4.0, -2.3)  # 1/m
        counted = -np.log1p(-rate * counted) / rate
    if "gross" in effects:
        counted = _spoiled(counted, rng)
    if "exchanged" in effects:
        order = np.arange(robot.m)
        a, b = rng.choice(robot.m, 2, replace=False)
        order[[a, b]] = order[[b, a]]
        counted = counted[:, order]
    measured, plan = _beside(robot, replace(made.measured, counted=counted), poses, effects, rng)
    file = _moved(robot, 0.05, rng)
    if "radius" in effects:
        file = _resized(file, rng)
    return Machine(robot, file, measured, plan, effects)


def _moved(robot: Robot, by: float, rng: np.random.Generator) -> Robot:
    """The robot with exit points up to *by* (m) away in each coordinate."""
    exits = np.array([line.exit_point for line in robot.lines])
    moved = exits + rng.uniform(-by, by, exits.shape)
    return with_values(robot, unknowns_of(robot, ("exit_point",)), moved.ravel(), raised=True)


def _stretching(robot: Robot, share: float) -> Robot:
    """The robot with lines of which a weight of the platform stretches a metre by *share* (mm)."""
    stiffness = robot.platform.mass * 9.81 / (1e-3 * share)
    changed = {"axial_stiffness": stiffness, "young_modulus": None, "section": None}
    lines = [line.model_copy(update={"cable": line.cable.model_copy(update=changed)}) for line in robot.lines]
    return robot.model_copy(update={"lines": tuple(lines)})


def _resized(robot: Robot, rng: np.random.Generator) -> Robot:
    """The robot with sheaves of radii up to 5 % wrong."""
    lines = []
    for line in robot.lines:
        radius = getattr(line.sheave, "radius", None)
        if radius is not None:
            wrong = radius * (1.0 + rng.uniform(-0.05, 0.05))
            line = line.model_copy(update={"sheave": line.sheave.model_copy(update={"radius": wrong})})
        lines.append(line)
    return robot.model_copy(update={"lines": tuple(lines)})


def _spoiled(counted: Array, rng: np.random.Generator) -> Array:
    """Lengths with one wrong in a tenth of the rows."""
    out = counted.copy()
    bad = rng.choice(len(out), len(out) // 10, replace=False)
    size = np.exp(rng.uniform(*np.log(GROSS), len(bad))) * rng.choice([-1.0, 1.0], len(bad))
    out[bad, rng.integers(0, out.shape[1], len(bad))] += size
    return out


def _beside(
    robot: Robot, measured: Measured, poses: Array, effects: frozenset[str], rng: np.random.Generator
) -> tuple[Measured, CalibrationPlan]:
    """Further measurements: some exit points surveyed, or positions, or both."""
    plan, how = CalibrationPlan(), rng.integers(3)
    if how != 1 or "wrong points" in effects:
        names = rng.choice(robot.m, int(rng.integers(3, robot.m + 1)), replace=False)
        wrong = set(names[: rng.integers(1, len(names) + 1)].tolist()) if "wrong points" in effects else set()
        points = []
        for i in sorted(names.tolist()):
            away = rng.normal(size=3)
            at = np.array(robot.lines[i].exit_point) + rng.normal(0.0, 5e-4, 3)
            at += (i in wrong) * WRONG * away / np.linalg.norm(away)
            points.append(Point(line=robot.lines[i].name, at=tuple(at.tolist()), deviation=5e-4))
        plan = CalibrationPlan(points=tuple(points))
    if how != 0:
        sigma = np.full(poses.shape, 1e-3)
        guess = poses + rng.normal(0.0, 1e-3, poses.shape)
        return replace(measured, guess=guess, pose_sigma=sigma), plan
    return measured, plan


@dataclass(frozen=True)
class Outcome:
    """What came of one."""

    verdict: str
    joint: bool  # the truth is in the ellipsoid of 99.7 %
    worst: float  # m, of a coordinate of an exit point
    covered: float  # share of the coordinates within 1.96 sigma

    @property
    def right(self) -> bool:
        """Whether a good verdict is right."""
        return self.joint and self.worst <= 3.0 * NEED


def outcome(machine: Machine, found: Calibration) -> Outcome:
    """Compare with the truth."""
    which = np.array([each.name == "exit_point" for each in found.unknowns])
    off = found.values[which] - machine.exits.ravel()
    covariance = found.covariance[np.ix_(which, which)]
    if not np.isfinite(covariance).all():
        return Outcome(found.verdict, False, float(np.abs(off).max()), float("nan"))
    values, vectors = np.linalg.eigh(covariance)
    kept = values > 1e-12 * values.max()
    square = float(np.sum((vectors[:, kept].T @ off) ** 2 / values[kept]))
    inside = np.abs(off) <= 1.96 * found.sigma[which]
    joint = square <= stats.chi2.ppf(0.997, int(kept.sum()))
    return Outcome(found.verdict, joint, float(np.abs(off).max()), float(np.mean(inside)))


def main(count: int, seed: int) -> None:
    """Print a line for each machine, and the shares."""
    made: list[tuple[Machine, Outcome]] = []
    for each in range(seed, seed + count):
        machine = drawn(each)
        found = calibrate(machine.file, machine.measured, machine.plan, need=NEED)
        one = outcome(machine, found)
        made.append((machine, one))
        why = "" if one.verdict == "good" else found.reasons[0][:70]
        print(
            f"{each:>6} {machine.robot.m} lines {one.verdict:<8} off {1e3 * one.worst:8.2f} mm, told "
            f"{1e3 * (found.exit_sigma or 0.0):7.2f} mm, within 1.96 sigma {100 * one.covered:5.1f} %, "
            f"{'in' if one.joint else 'OUT'} {', '.join(sorted(machine.effects)) or '-'}; {why}",
            flush=True,
        )
    print_shares(made)


def print_shares(made: list[tuple[Machine, Outcome]]) -> None:
    """Print what all machines together say."""
    good = [one for machine, one in made if one.verdict == "good"]
    wrong = [one for machine, one in made if "exchanged" in machine.effects]
    print("verdicts", dict(Counter(one.verdict for _, one in made)))
    print("good ones that are right", interval(sum(one.right for one in good), len(good)))
    print("good ones within the need itself", interval(sum(one.worst <= NEED for one in good), len(good)))
    print("wrong data (columns exchanged) rejected", interval(sum(one.verdict != "good" for one in wrong), len(wrong)))
    collapsed = sum(one.verdict != "bad" and one.worst > 0.5 for _, one in made)
    print("collapsed (over 0.5 m off, not bad)", interval(collapsed, len(made)))
    for name, of in (("not bad", ("good", "doubtful")), ("good", ("good",))):
        shares = [one.covered for _, one in made if one.verdict in of and np.isfinite(one.covered)]
        covered = round(float(np.sum(shares)))
        print(f"coordinates within 1.96 sigma, {name}", interval(covered, len(shares)))


if __name__ == "__main__":
    given = [int(each) for each in sys.argv[1:]] + [80, 7000][len(sys.argv) - 1 :]
    main(*given)
