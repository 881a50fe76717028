"""Random robots from 1 mm to 1 km, EA over nine decades; every OK is held to residuals in extended precision.

    python -m tools.random_robots --count 100000 --seed 0
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from cablewright.arrays import Array
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from tools.long_double import Claims, judge

Random = np.random.Generator
GRAVITY = 9.81


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
    """Return *count* poses below most exits; with fewer lines than freedoms NaN for those that gravity decides."""
    places = size * rng.uniform([-0.4, -0.4, 0.05], [0.4, 0.4, 0.8], (count, 3))
    poses = places if n == 3 else np.column_stack([places, rng.normal(0.0, 0.1, (count, 3))])
    free = {3: [0, 1, 2], 6: [3, 4, 5, 1, 0, 2]}[n][: max(0, n - m)]
    poses[:, free] = np.nan
    return poses


def answers(cases: Iterator[Case], counts: Counter[str]) -> Iterator[tuple[Case, str, Equilibrium]]:
    """Yield every OK answer with its question, `inverse` or `forward`; *counts* is told of all statuses."""
    for case in cases:
        held = solve_inverse(case.model, case.poses)
        counts.update(f"inverse {case.kind}: {status.word}" for status in held.status)
        yield from ((case, "inverse", held[i]) for i in np.flatnonzero(held.ok))
        if case.model.fidelity.cable is CableLaw.RIGID or not held.ok.any():
            continue
        found = solve_forward(case.model, held.lengths[np.flatnonzero(held.ok)[:1]])
        counts.update(f"forward {case.kind}: {status.word}" for status in found.status)
        yield from ((case, "forward", found[i]) for i in np.flatnonzero(found.ok))
