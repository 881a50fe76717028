"""Random robots from 1 mm to 1 km, EA from 1 N to 1e9 N: every OK is held to residuals in extended precision.

``python -m tools.random_robots --count 100000 --seed 0``. What is not OK is counted; where a linear program can decide,
of point platforms on massless lines from eyelets, a share of the answers is compared with it.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from scipy.optimize import linprog
from tools.long_double import Claims, judge

from cablewright.foundation.arrays import Array
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Eyelet, Robot
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse

Random = np.random.Generator
GRAVITY = 9.81
PROMISED = {
    "metres": 1e-9,  # docs/theory/statics.md
    "geometry": 1e-9,  # that would be much in a machine of a millimetre
    "force": 1e-9,  # docs/theory/statics.md
    "lever": 1e-9,
    "limits": 1e-11,  # tensions are converged so far
}
"""The largest residuals of an OK, see `long_double.Residuals`."""
BATCH = 500  # robots that are judged together
NEAR = 1e-6  # of the weight: margin from which on a linear program is not asked to agree


def log_uniform(rng: Random, low: float, high: float) -> float:
    """Return a number from 10**low to 10**high, its logarithm uniform."""
    return float(10.0 ** rng.uniform(low, high))


@dataclass(frozen=True)
class Case:
    """A random robot under a law, its size (m), and poses in it; NaN where gravity decides."""

    number: int
    model: Model
    size: float
    poses: Array

    @property
    def kind(self) -> str:
        """Its class: platform, whether gravity decides, law, sheave."""
        robot = self.model.robot
        hangs = "hanging" if robot.m < robot.n else "held"
        body = "point" if robot.n == 3 else "body"
        return f"{body} {hangs} {self.model.fidelity.cable.value} {robot.lines[0].sheave.kind}"

    @property
    def straight(self) -> bool:
        """Whether its lines are straight from eyelets, with breaking loads that their limits keep clear of."""
        line = self.model.robot.lines[0]
        light = self.model.fidelity.cable is not CableLaw.CATENARY or line.cable.linear_density == 0.0
        return light and isinstance(line.sheave, Eyelet) and line.winch_exit is None


def random_case(seed: int, number: int, poses: int) -> Case:
    """Return random robot *number* of a *seed* with some *poses*; the same whatever came before it."""
    rng = np.random.default_rng([seed, number])
    size, mass = log_uniform(rng, -3, 3), log_uniform(rng, -6, 5)
    n = 3 if rng.random() < 0.6 else 6
    m = int(rng.integers(1 if rng.random() < 0.15 else 3, 13))
    law = CableLaw(rng.choice(["rigid", "elastic", "catenary"], p=[0.2, 0.35, 0.45]))
    body = size * log_uniform(rng, -2, -0.5)
    platform: dict[str, Any] = {"kind": "point" if n == 3 else "rigid", "mass": mass}
    if rng.random() < 0.2:
        platform["force"] = tuple(GRAVITY * mass * rng.uniform(-0.3, 0.3, 3))
    if n == 6:
        platform["centre_of_mass"] = tuple(body * np.array([*rng.uniform(-0.2, 0.2, 2), -0.4]))
    points = body * rng.uniform(-1, 1, (m, 3)) if n == 6 else np.zeros((m, 3))
    robot = Robot.model_validate(
        {
            "name": f"random {number}",
            "scene": {"gravity": GRAVITY, "frame_min": (-2 * size,) * 3, "frame_max": (2 * size,) * 3},
            "platform": platform,
            "lines": _lines(rng, size, GRAVITY * mass, points),
        }
    )
    return Case(number, Model(robot, Fidelity(law)), size, _poses(rng, n, m, size, poses))


def _lines(rng: Random, size: float, weight: float, points: Array) -> list[dict[str, Any]]:
    """Return the lines to platform *points* (m, 3), in a frame with its top at the height *size*."""
    m, share = len(points), weight / len(points)
    around = 2 * np.pi * (np.arange(m) + rng.uniform(-0.3, 0.3, m)) / m + rng.uniform(0, 2 * np.pi)
    away = size * rng.uniform(0.6, 1.0, m)
    low = (rng.random() < 0.4) & (rng.random(m) < 0.5)
    heights = np.where(low, rng.uniform(0.0, 0.2, m), rng.uniform(0.9, 1.1, m)) * size
    kind = str(rng.choice(["eyelet", "swivel", "universal-joint"], p=[0.5, 0.3, 0.2]))
    cable = {
        "axial_stiffness": log_uniform(rng, 0, 9),
        "linear_density": 0.0 if rng.random() < 0.25 else weight / GRAVITY / size * log_uniform(rng, -6, 1),
    }
    unlimited = rng.random() < 0.4
    least = 0.0 if rng.random() < 0.3 else share * log_uniform(rng, -6, 0)
    most = share * (log_uniform(rng, 3, 12) if unlimited else 1.0 + log_uniform(rng, -1, 2))
    cable["breaking_load"] = most * (1.0 if unlimited else log_uniform(rng, 0, 3))
    options = {"dead_elastic": bool(rng.random() < 0.5), "arc_elastic": bool(rng.random() < 0.5)}
    lines = []
    for i in range(m):
        exit_point = (float(away[i] * np.cos(around[i])), float(away[i] * np.sin(around[i])), float(heights[i]))
        line = {
            "name": f"line {i}",
            "exit_point": exit_point,
            "platform_point": tuple(points[i]),
            "cable": cable,
            "tension_limits": (least, most),
            **options,
            **_fed(rng, kind, exit_point, size, share),
        }
        lines.append(line)
    return lines


def _fed(rng: Random, kind: str, exit_point: tuple[float, float, float], size: float, share: float) -> dict[str, Any]:
    """Return the sheave of a line, and where its cable comes from."""
    x, y, z = exit_point
    sheave: dict[str, Any] = {"kind": kind}
    under = False
    if kind != "eyelet":
        under = bool(rng.random() < 0.2)
        sheave |= {"radius": size * log_uniform(rng, -3, -1.3), "wrap": "under" if under else "over"}
    if kind == "universal-joint":
        lever = float(sheave["radius"] * rng.uniform(1, 4))
        sheave |= {"lever": lever, "lever_weight": share * log_uniform(rng, -6, -1), "lever_mass_centre": 0.7 * lever}
    elif rng.random() < 0.5:
        return {"sheave": sheave, "dead_length": float(size * rng.uniform(0, 1))}
    aside = size * rng.uniform(-0.5, 0.5, 2) if kind == "eyelet" and rng.random() < 0.5 else np.zeros(2)
    drop = float(size * rng.uniform(0.3, 1.0)) * (1 if under else -1)
    return {"sheave": sheave, "winch_exit": (float(x + aside[0]), float(y + aside[1]), z + drop)}


def _poses(rng: Random, n: int, m: int, size: float, count: int) -> Array:
    """Return *count* poses below most exit points; with fewer lines than coordinates some are NaN."""
    places = size * rng.uniform([-0.4, -0.4, 0.05], [0.4, 0.4, 0.8], (count, 3))
    poses = places if n == 3 else np.column_stack([places, rng.normal(0.0, 0.1, (count, 3))])
    free = {3: [0, 1, 2], 6: [3, 4, 5, 1, 0, 2]}[n][: max(0, n - m)]
    poses[:, free] = np.nan
    return poses


@dataclass(frozen=True)
class Answer:
    """An OK, and what was asked: ``inverse`` or ``forward``."""

    case: Case
    asked: str
    found: Equilibrium

    def __str__(self) -> str:
        """Description of the robot."""
        robot, cable = self.case.model.robot, self.case.model.robot.lines[0].cable
        return (
            f"robot {self.case.number}, {self.asked}: {self.case.kind}, {robot.m} lines, {self.case.size:.1e} m, "
            f"EA {cable.stiffness:.1e} N, {robot.platform.mass:.1e} kg, {cable.linear_density:.1e} kg/m, "
            f"limits {robot.lines[0].tension_limits}, pose {self.found.pose.tolist()}"
        )


class Tally:
    """What became of all questions: counts of statuses, the worst residuals of OKs, and each failure in a line."""

    def __init__(self) -> None:
        self.statuses: Counter[str] = Counter()
        self.classes: Counter[str] = Counter()  # of OK answers
        self.worst: dict[str, tuple[float, str]] = {}
        self.programs = 0  # poses compared with a linear program
        self.failures: list[str] = []

    def run(self, cases: Iterable[Case]) -> None:
        """Solve and judge *cases*."""
        groups: dict[tuple[int, int], list[Answer]] = defaultdict(list)
        for case in cases:
            for answer in self._answers(case):
                groups[answer.found.model.n, answer.found.model.m].append(answer)
        for group in groups.values():
            self._judge(group)

    def _answers(self, case: Case) -> Iterator[Answer]:
        """Yield the OKs of poses, and that of the lengths of the first of them."""
        held = solve_inverse(case.model, case.poses)
        self.statuses.update(f"inverse {status.word}" for status in held.status)
        yield from (Answer(case, "inverse", held[int(i)]) for i in np.flatnonzero(held.ok))
        if case.number % 4 == 0 and case.kind.startswith("point held") and case.straight:
            self._compare(case, held)
        if case.model.fidelity.cable is CableLaw.RIGID or not held.ok.any():
            return
        found = solve_forward(case.model, held.lengths[np.flatnonzero(held.ok)[0]])
        self.statuses[f"forward {found.status.word}"] += 1
        if found.ok:
            yield Answer(case, "forward", found)

    def _judge(self, answers: list[Answer]) -> None:
        """Hold answers of robots with as many lines and degrees of freedom to the promises."""
        residuals = judge(Claims.of([answer.found for answer in answers]))
        self.classes.update(f"{answer.asked} {answer.case.kind}" for answer in answers)
        for field in fields(residuals):
            values = getattr(residuals, field.name)
            for answer, value in zip(answers, values, strict=True):
                if field.name == "limits" and answer.asked == "forward":  # which enforces none
                    continue
                key = f"{answer.asked} {field.name}"
                if not value <= self.worst.get(key, (-1.0, ""))[0]:
                    self.worst[key] = float(value), str(answer)
                if not value <= PROMISED[field.name]:
                    self.failures.append(f"{field.name} {value:.2g}: {answer}")
        for answer in answers:
            if answer.asked == "inverse" and not answer.found.margin() >= 0.0:
                self.failures.append(f"margin {answer.found.margin():.2g} N: {answer}")

    def _compare(self, case: Case, held: Equilibrium) -> None:
        """Hold statuses of straight massless lines to the largest margin that a linear program finds."""
        for i, word in enumerate(status.word for status in held.status):
            margin = largest_margin(case, case.poses[i])
            if word not in ("ok", "infeasible") or abs(margin) < NEAR * GRAVITY * case.model.robot.platform.mass:
                continue
            self.programs += 1
            if (word == "ok") != (margin > 0.0):
                self.failures.append(f"{word}, but the largest margin is {margin:.3g} N: robot {case.number}, pose {i}")

    def report(self) -> str:
        """Return all of it in lines."""
        lines = [f"{count:8d} {what}" for what, count in sorted(self.statuses.items())]
        lines += ["OK answers by class:", *(f"{count:8d} {what}" for what, count in sorted(self.classes.items()))]
        lines += ["worst residuals of OKs:", *(f"{v:8.1g} {what}: {who}" for what, (v, who) in self.worst.items())]
        lines += [f"{self.programs} statuses compared with linear programs", f"{len(self.failures)} failures"]
        return "\n".join(lines)


def largest_margin(case: Case, pose: Array) -> float:
    """Return by how much all tensions of straight lines can be within their limits together, N; negative: they cannot.

    -inf where no tensions of any size balance the load. Forces are in shares of the weight.
    """
    robot = case.model.robot
    weight = GRAVITY * robot.platform.mass
    away = np.array([line.exit_point for line in robot.lines]) - pose
    directions = away / np.linalg.norm(away, axis=1)[:, None]
    load = np.array(robot.platform.force) / weight - [0.0, 0.0, 1.0]
    least, most = np.array([line.tension_limits for line in robot.lines]).T / weight
    # unknowns: tensions and the margin, which is between the limits' middle and far outside
    rows = np.block([[-np.eye(robot.m), np.ones((robot.m, 1))], [np.eye(robot.m), np.ones((robot.m, 1))]])
    found = linprog(
        [0.0] * robot.m + [-1.0],
        A_ub=rows,
        b_ub=[*-least, *most],
        A_eq=np.column_stack([directions.T, np.zeros(3)]),
        b_eq=-load,
        bounds=[(None, None)] * (robot.m + 1),
    )
    return float(-found.fun * weight) if found.status == 0 else -np.inf


def main() -> int:
    """Run and report; 1 if an OK does not hold."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100_000, help="robots")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    parser.add_argument("--poses", type=int, default=4, help="of each robot")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    tally, begun, told = Tally(), time.monotonic(), 0
    for first in range(given.first, given.first + given.count, BATCH):
        last = min(first + BATCH, given.first + given.count)
        tally.run(random_case(given.seed, number, given.poses) for number in range(first, last))
        for failure in tally.failures[told:]:
            print(failure, flush=True)
        told = len(tally.failures)
    print(tally.report())
    print(f"{given.count} robots, {given.poses} poses each, in {time.monotonic() - begun:.0f} s")
    return 1 if tally.failures else 0


if __name__ == "__main__":
    sys.exit(main())
