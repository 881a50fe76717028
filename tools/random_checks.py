"""Random robots and jobs: a yes of `check` is held to figures that are found again.

``python -m tools.random_checks --count 2000 --seed 0``. Straight lengths times spans, speeds of winches by finite
differences over time, lengths half-way between samples, what lifts a platform off its plane, and pieces of the path
around the largest changes: none of these comes from the code that judges.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from scipy.spatial.transform import Rotation
from tools.random_prints import random_print

from cablewright.foundation.errors import InputError
from cablewright.robot import Robot
from cablewright.solvers.inverse import inverse
from cablewright.studies.checks.check import check
from cablewright.studies.checks.result import Check

LOOSE, TIGHT = 1.05, 0.9  # a line over its straight length
QUICK = 1.12  # speed of a cable over that of the nozzle times the spans
PIECES = 32  # of a segment with a large change
JUMP = 0.02  # of the largest tension, and a tenth of a millimetre: changes from which on a jump would matter


def platform_points(robot: Robot, poses: np.ndarray) -> np.ndarray:
    """Return the platform points (k, m, 3), m, at *poses* (k, n)."""
    own = np.array([line.platform_point for line in robot.lines])
    if poses.shape[1] == 3:
        return np.asarray(poses[:, None] + own)
    turns = Rotation.from_rotvec(poses[:, 3:]).as_matrix()
    return np.asarray(poses[:, None, :3] + np.einsum("kij,mj->kmi", turns, own))


def straight_lengths(robot: Robot, poses: np.ndarray) -> np.ndarray:
    """Return spans times distances (k, m), m, of platform points from exit points, and dead lengths."""
    away = platform_points(robot, poses) - np.array([line.exit_point for line in robot.lines])
    spans, dead = np.array([(line.advantage, line.dead_length) for line in robot.lines]).T
    return np.asarray(np.linalg.norm(away, axis=2) * spans + dead)


def faults(found: Check) -> Iterator[str]:
    """Yield what is absurd beside the yes of a check."""
    robot, samples, law, poses = found.robot, found.samples, found.law, found.poses
    straight, spans = straight_lengths(robot, poses), np.array([line.advantage for line in robot.lines])
    ratio = found.lengths / straight
    if not (ratio.max() <= LOOSE and ratio.min() >= TIGHT):
        yield f"lengths are {ratio.min():.3f} to {ratio.max():.3f} of the straight ones"
    gone, way = np.diff(law.time), np.linalg.norm(np.diff(samples.positions, axis=0), axis=1)
    moving = gone > 0.0
    speeds = np.abs(np.diff(found.lengths, axis=0))[moving] / gone[moving, None]
    over = speeds / (spans * (way[moving] / gone[moving])[:, None])
    if over.max() > QUICK:
        yield f"a cable is {over.max():.3g} times as fast as the nozzle times its spans"
    if found.statics.lines.winch_speed.max() > QUICK * float(spans.max()) * law.speed.max() * 1.001:
        yield f"max winch speed {found.statics.lines.winch_speed.max():.3g} m/s"
    allowed = found.allowed_error
    total = found.to_dict()["acceleration_displacement"] + (found.to_dict()["expected_error"] or 0.0)
    if not total <= allowed:
        yield f"errors add up to {total:.3g} m of {allowed:.3g} m"
    low, high = np.array([line.tension_limits for line in robot.lines]).T
    if (found.statics.tensions < low - 1e-6 * high).any() or (found.statics.tensions > high * (1 + 1e-6)).any():
        yield "a tension is out of its limits"
    yield from _lifted(found)
    yield from _between(found, straight)


def _lifted(found: Check) -> Iterator[str]:
    """Yield whether lines, straight and without weight, lift the platform off a plane that only pushes."""
    plane = found.robot.platform.plane
    if plane is None or plane.pulls:
        return
    away = np.array([line.exit_point for line in found.robot.lines]) - platform_points(found.robot, found.poses)
    spans = np.array([line.advantage for line in found.robot.lines])
    units = away / np.linalg.norm(away, axis=2, keepdims=True)
    pull = np.einsum("km,kmi,i->k", spans * found.statics.tensions, units, np.array(plane.across))
    weight = found.robot.platform.mass * found.robot.scene.gravity * plane.across[2]
    cables = sum(line.cable.linear_density * line.advantage for line in found.robot.lines) * found.lengths.max()
    if (pull - weight).max() > found.robot.scene.gravity * cables:
        yield f"lifted off its plane by {(pull - weight).max():.3g} N"


def _between(found: Check, straight: np.ndarray) -> Iterator[str]:
    """Yield errors and jumps between samples. Where tensions keep a reserve the pieces are the samples."""
    tensions, beyond = found.statics.tensions, found.lengths - straight
    least = {"length": 1e-4, "tension": JUMP * tensions.max()}
    for what, values in (("length", beyond), ("tension", tensions)):
        changes = np.abs(np.diff(values, axis=0))
        alone = changes[1:-1] > 10.0 * np.maximum(changes[2:], changes[:-2]) + 10.0 * least[what]
        if alone.any():
            yield f"a {what} jumps by {changes[1:-1][alone].max():.3g}"
    if found.reserved:
        return
    middle = inverse(found.robot, 0.5 * (found.poses[1:] + found.poses[:-1]))
    off = np.abs(middle.lengths - 0.5 * (found.lengths[1:] + found.lengths[:-1]))[middle.ok].max(initial=0.0)
    told = found.interpolation_error or 0.0
    if off > max(1.05 * told, 2e-5):
        yield f"the error of a length is {off:.3g} m between samples; {told:.3g} m is reported"
    for values in (beyond, tensions):
        for k in np.argsort(-np.abs(np.diff(values, axis=0)).max(axis=1))[:3]:
            yield from _pieces(found, int(k), least)


def _pieces(found: Check, k: int, least: dict[str, float]) -> Iterator[str]:
    """Yield the jumps in the segment behind sample *k*, in pieces."""
    share = np.linspace(0.0, 1.0, PIECES + 1)[:, None]
    poses = found.poses[k] + share * (found.poses[k + 1] - found.poses[k])
    fine = inverse(found.robot, poses)
    if not fine.ok.all():
        return
    for what, values in (("length", fine.lengths - straight_lengths(found.robot, poses)), ("tension", fine.tensions)):
        steps = np.abs(np.diff(values, axis=0)).max(axis=0)
        if (steps > np.maximum(0.5 * np.ptp(values, axis=0), least[what])).any():
            yield f"a {what} jumps by {steps.max():.3g} behind sample {k}"


@dataclass
class Tally:
    """Answers by kind, and each fault of a yes in a line."""

    answers: Counter[str] = field(default_factory=Counter)
    reasons: Counter[str] = field(default_factory=Counter)
    faults: list[str] = field(default_factory=list)

    def run(self, seed: int, number: int, folder: Path) -> None:
        """Check robot *number* of a *seed*, and judge a yes."""
        robot, job = random_print(seed, number, folder)
        try:
            found = check(robot, job, skip=("interference",))
        except InputError as refusal:
            self.answers["refused"] += 1
            self.reasons[f"refused: {str(refusal).split(':')[0]}"] += 1
            return
        self.answers["yes" if found.feasible else "no"] += 1
        self.answers["no minimum tension, yes"] += found.feasible and robot.lines[0].tension_limits[0] == 0.0
        if found.feasible:
            self.faults += (f"robot {number}: {fault}" for fault in faults(found))
        else:
            self.reasons.update(each.limit for each in found.findings if each.violations)

    def report(self) -> str:
        """Return all of it in lines."""
        lines = [f"{count:6d} {what}" for what, count in self.answers.most_common()]
        lines += ["reasons of a no:", *(f"{count:6d} {what}" for what, count in self.reasons.most_common())]
        return "\n".join([*lines, *self.faults, f"{len(self.faults)} faults of a yes"])


def main() -> int:
    """Run and report; 1 if a yes does not hold."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=2000, help="robots")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    tally, begun = Tally(), time.monotonic()
    with TemporaryDirectory() as folder:
        for number in range(given.first, given.first + given.count):
            tally.run(given.seed, number, Path(folder))
    print(tally.report())
    print(f"{given.count} robots and jobs in {time.monotonic() - begun:.0f} s")
    return 1 if tally.faults else 0


if __name__ == "__main__":
    sys.exit(main())
