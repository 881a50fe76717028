"""Random slack robots by many starts: no second equilibrium where a theorem says that one is the only one.

``python -m tools.uniqueness_search --count 100000 --seed 0``. Point loads on one to four heavy, slack lines from
eyelets and swivels, with dead spans that can hang in loops. Each set of lengths is solved from a guess, from random
poses and with loops in every choice of its dead spans; only certified solutions count. The
tensions and the position of a solution decide whether a sentence applies to it, not the code that wrote the sentence.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np

from cablewright.foundation.arrays import Array, Mask
from cablewright.models.packed_views import LineStates
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot
from cablewright.solvers.certify import certify
from cablewright.solvers.equilibria import FOUND
from cablewright.solvers.forward import solve_forward, solve_from
from cablewright.solvers.uniqueness import unique_among

Random = np.random.Generator
GRAVITY = 9.81
BATCH = 100  # robots that are solved together
RANDOM_STARTS = 4  # poses for each robot
SAME_POSE, SAME_DEAD = 1e-8, 1e-6  # m: two solutions whose pose and dead spans differ by less are one


def slack_robot(rng: Random, m: int) -> Model:
    """Return a robot of *m* heavy lines, each from an eyelet or a swivel, most of them with a dead span."""
    size, density = float(10.0 ** rng.uniform(-0.5, 1.5)), float(10.0 ** rng.uniform(-2.0, 0.5))
    around = 2.0 * np.pi * (np.arange(m) + rng.uniform(-0.4, 0.4, m)) / m
    away, heights = size * rng.uniform(0.3, 1.2, m), size * rng.uniform(0.6, 1.4, m)
    carried = density * GRAVITY * size
    cable = {
        "axial_stiffness": carried * float(10.0 ** rng.uniform(0.5, 5.0)),
        "linear_density": density,
        "breaking_load": 1e6 * carried,
    }
    lines = []
    for i in range(m):
        x, y, z = away[i] * np.cos(around[i]), away[i] * np.sin(around[i]), heights[i]
        line: dict[str, Any] = {"name": f"l{i}", "exit_point": (x, y, z), "cable": cable, "sheave": {"kind": "eyelet"}}
        line["tension_limits"] = (0.0, 1e5 * carried)
        if rng.random() < 0.4:
            radius = float(size * 10.0 ** rng.uniform(-3.0, -1.0))
            line["sheave"] = {"kind": "swivel", "radius": radius}
        if rng.random() < 0.85:
            line["winch_exit"] = (x, y, float(z - size * rng.uniform(0.1, 1.2)))
            line["dead_elastic"] = bool(rng.random() < 0.5)
        if line["sheave"]["kind"] == "eyelet" and rng.random() < 0.1:
            line["advantage"] = 2
        lines.append(line)
    mass = float(density * size * 10.0 ** rng.uniform(-2.0, 1.5))
    scene = {"gravity": GRAVITY, "frame_min": (-2.0 * size,) * 3, "frame_max": (2.0 * size,) * 3}
    robot = {"name": "slack", "scene": scene, "platform": {"mass": mass}, "lines": lines}
    return Model(Robot.model_validate(robot))


def slack_lengths(rng: Random, model: Model) -> tuple[Array, Array]:
    """Return lengths (m,) by which most lines are slack somewhere in the frame, and the depths of the winches, m."""
    lines = model.lines
    size = model.robot.scene.frame_max[0] / 2.0
    point = size * np.array([*rng.uniform(-0.6, 0.6, 2), rng.uniform(-0.3, 1.2)])
    depth = np.where(lines.has_dead_span, -lines.winch_height, 0.0)
    chords = np.linalg.norm(point - lines.exit_point, axis=1)
    slack = size * rng.uniform(0.0, 1.0, model.m) ** 2 * rng.integers(0, 2, model.m)
    return lines.spans * chords + depth + slack + 2.0 * lines.radius, depth


def begun(rng: Random, model: Model, cold: Equilibrium, lengths: Array, depth: Array) -> tuple[Array, Array]:
    """Return starts: poses (S, 3) and states (S, m, 6), with and without loops in the dead spans."""
    m, size = model.m, model.robot.scene.frame_max[0] / 2.0
    pose, states = (cold.pose, cold.states) if cold.ok else (np.zeros(3), np.zeros((m, 6)))
    if not cold.ok:
        LineStates(states).angles = np.array([-0.5, -0.5 * np.pi, 0.0])
    patterns = np.array(list(product((False, True), repeat=m)))[:16]
    patterns = np.concatenate([patterns, rng.random((RANDOM_STARTS, m)) < 0.5])
    poses = np.repeat(pose[None], len(patterns), axis=0)
    poses[-RANDOM_STARTS:] = size * rng.uniform(-1.0, 1.2, (RANDOM_STARTS, 3))
    begin = np.repeat(states[None], len(patterns), axis=0)
    own = LineStates(begin)
    most = np.maximum(lengths - depth, 0.0)
    dead = depth + most * rng.uniform(0.0, 0.9, patterns.shape) ** 2
    looped = patterns & model.lines.has_dead_span
    own.dead_length = np.where(looped, dead, own.dead_length)
    tension = 0.5 * model.lines.weight * (dead + depth)
    own.log_tension = np.where(looped, np.log(np.maximum(tension, 1e-9)), own.log_tension)
    own.free_length = np.where(looped, (lengths - dead) / model.lines.spans, own.free_length)
    own.free_angle = own.free_angle + np.where(looped, rng.uniform(-0.6, 0.6, patterns.shape), 0.0)
    return poses, begin


def solved(rng: Random, models: Sequence[Model]) -> tuple[Equilibrium, Array]:
    """Return certified solutions of all *models*, one set of lengths each, and whose they are (K,)."""
    owners, lengths, poses, states = [], [], [], []
    for k, model in enumerate(models):
        length, depth = slack_lengths(rng, model)
        starts, begin = begun(rng, model, solve_forward(model, length), length, depth)
        owners += [k] * len(starts)
        lengths += [length] * len(starts)
        poses.append(starts)
        states.append(begin)
    owner = np.array(owners)
    packed = models[0].packed
    lines, platform = (np.stack([getattr(model.packed, key) for model in models]) for key in ("lines", "platform"))
    rows = packed._replace(lines=lines[owner], platform=platform[owner])
    again = np.zeros(len(owner), dtype=bool)
    found = solve_from(models[0], rows, np.array(lengths), np.concatenate(poses), np.concatenate(states), again)
    held = np.flatnonzero(np.isin(found.code, FOUND))
    certified = held[np.atleast_1d(certify(found[held]).certified)]
    return found[certified], owner[certified]


def distinct(found: Equilibrium, rows: Sequence[int]) -> list[int]:
    """Return one of each group of *rows* of *found* that are the same solution."""
    kept: list[int] = []
    for row in rows:
        dead, pose = found.line_states.dead_length[row], found.pose[row]
        for other in kept:
            apart = np.abs(found.line_states.dead_length[other] - dead).max()
            if apart < SAME_DEAD and np.abs(found.pose[other] - pose).max() < SAME_POSE:
                break
        else:
            kept.append(int(row))
    return kept


def in_words(found: Equilibrium) -> Mask:
    """Return which rows have taut dead spans, and are farther than two radii from the axis of each swivel."""
    lines, states = found.lines, found.line_states
    taut = states.tension > lines.weight * states.dead_length
    away = found.platform_points - lines.exit_point
    beside = np.hypot(away[..., 0], away[..., 1]) > 2.0 * lines.radius.max(axis=-1, keepdims=True)
    fits = (taut | ~lines.has_dead_span) & (beside | (lines.radius == 0.0))
    return np.asarray(fits.all(axis=-1))


def contradictions(seed: int, number: int, count: int = BATCH) -> tuple[list[str], Counter[str]]:
    """Solve *count* robots of batch *number* of a *seed*. Return sentences that are false, and what was found."""
    rng = np.random.default_rng([seed, number])
    m = 1 + number % 4
    found, owner = solved(rng, [slack_robot(rng, m) for _ in range(count)])
    member, tally, false = in_words(found), Counter[str](robots=count), []
    for k in np.unique(owner):
        rows = distinct(found, np.flatnonzero(owner == k).tolist())
        tally["solved"] += 1
        tally["with several solutions"] += len(rows) > 1
        said = {row: words for row in rows if (words := unique_among(found[row])) is not None}
        tally["with a sentence"] += bool(said)
        tally["with a sentence and several solutions"] += bool(said) and len(rows) > 1
        for row, words in said.items():
            others = [other for other in rows if other != row and member[other]]
            if others or not member[row]:
                false.append(f"seed {seed}, batch {number}, robot {k}: {1 + len(others)} of {words}")
    return false, tally


def main() -> int:
    """Count the robots of a seed with false sentences; 1 if there are any."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    started, total, false = time.monotonic(), Counter[str](), []
    for number in range(-(-given.count // BATCH)):
        new, tally = contradictions(given.seed, number)
        total += tally
        false += new
        print(*new, sep="\n", end="\n" if new else "")
        if number % 50 == 49:
            print(f"{total['robots']} robots, {len(false)} contradictions", flush=True)
    print(", ".join(f"{count} {what}" for what, count in total.items()))
    print(f"{len(false)} contradictions in {time.monotonic() - started:.0f} s")
    return 1 if false else 0


if __name__ == "__main__":
    sys.exit(main())
