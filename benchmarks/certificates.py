"""Following an equilibrium with a certificate at each step, the certificate alone, and boxes for inexact lengths."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from benchmarks.timing import Row, best
from cablewright.foundation.errors import Status
from cablewright.kernels import batches
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import load
from cablewright.solvers.continuation import Tracker
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.pose_hull import enclose_poses

Array = NDArray[np.float64]
PACE = 3e-4  # m: a step of 10 ms at 3 cm/s
SIDES = {"merlet2023": (2.3, 4.7, 2.0), "paty2021": (3.5, 3.5, 4.0)}  # half sides and height of 28 m, m
LIMITS = (20.0, 5150.0)
EXCESS = 0.3  # m: largest excess length of one line along the path
SAME = 1e-9  # m
ERROR = 1e-3  # m: of each length
LETS_OUT = {"taut": (0.0, 0.0), "slack": (0.02, 0.3), "transition": (1e-4, 1e-2)}  # m: by how much one line
SAMPLES, SEED = 300, 3


@dataclass(frozen=True)
class Size:
    """How much is measured."""

    share: float = 1.0  # of the paths' sides, and of how much longer a line gets on them
    boxes: int = 5


FULL, QUICK = Size(), Size(0.01, 1)


def rows(size: Size) -> Iterator[Row]:
    """All rows of this file."""
    for name in SIDES:
        yield from path_rows(name, size.share)
    yield from body_rows(size.share)
    for name in SIDES:
        for kind in LETS_OUT:
            yield from box_rows(name, kind, size.boxes)


def path_rows(name: str, part: float) -> Iterator[Row]:
    """A closed path of 28 m, or *part* of it, on which one line is let out until it is slack, and pulled tight."""
    model = Model(load(name), tension_limits=LIMITS)
    x, y, z = SIDES[name]
    lengths = slackened(solve_inverse(model, round_trip(part * x, part * y, z)).checked().lengths, part * EXCESS)
    times, found, wrong = followed(model, lengths)
    mean, late = 1e6 * float(times.mean()), 1e6 * float(np.percentile(times, 99))
    share = 100 * float(np.mean(found))
    yield Row(f"{name}: a step, certified, mean", mean, "us", "<= 40", mean <= 40)
    yield Row(f"{name}: a step, certified, 99 % of them within", late, "us", "<= 100", late <= 100)
    yield Row(f"{name}: certified share of {len(found)} steps", share, "%", ">= 99.9", share >= 99.9)
    yield Row(f"{name}: steps on a wrong branch", wrong, "of 100ths", "= 0", wrong == 0)
    alone = 1e6 * in_batch(solve_forward(model, lengths[::40]))
    yield Row(f"{name}: the certificate alone, in a batch", alone, "us")


def body_rows(part: float) -> Iterator[Row]:
    """Eight lines and a body: there and back on *part* of a straight way inside a small frame."""
    model = Model(load("jung2020"))
    ends = np.array([[-0.1, 0.0, 0.1, 0.0, 0.0, 0.0], [0.1, 0.05, 0.15, 0.02, -0.02, 0.02]])
    share = np.arange(0.0, part, PACE / np.linalg.norm(ends[1, :3] - ends[0, :3]))
    poses = ends[0] + np.concatenate([share, share[::-1]])[:, None] * (ends[1] - ends[0])
    lengths = solve_inverse(model, poses).checked().lengths
    times, found, _ = followed(model, np.tile(lengths, (3, 1)), compare=False)
    mean, sure = 1e6 * float(times.mean()), 100 * float(np.mean(found))
    yield Row("jung2020: a step, certified, mean", mean, "us", "<= 150", mean <= 150)
    yield Row("jung2020: certified share", sure, "%")
    alone = 1e6 * in_batch(solve_forward(model, lengths, guess=poses, path=True))
    yield Row("jung2020: the certificate alone, in a batch", alone, "us")


def box_rows(name: str, kind: str, boxes: int) -> Iterator[Row]:
    """Boxes of poses for lengths known to ERROR, of *boxes* random poses with one line *kind*."""
    rng = np.random.default_rng(SEED)
    model = Model(load(name), tension_limits=LIMITS)
    wider, times, leaves = [], [], []
    while len(times) < boxes:
        place = rng.uniform(model.robot.scene.frame_min, model.robot.scene.frame_max)
        held = solve_inverse(model, place)
        if not held.ok:
            continue
        low, high = LETS_OUT[kind]
        longer = 10.0 ** rng.uniform(np.log10(low), np.log10(high)) if high else 0.0
        found = solve_forward(model, held.lengths + longer * np.eye(model.m)[rng.integers(model.m)]).checked()
        enclose_poses(found, ERROR, budget=1)  # loads kernels
        begin = time.perf_counter()
        box = enclose_poses(found, ERROR)
        times.append(time.perf_counter() - begin)
        leaves.append(box.leaves)
        poses = solve_forward(model, lengths_within(found.lengths, rng), guess=found.pose).checked().pose
        if box.complete and not ((box.low <= poses).all() and (poses <= box.high).all()):
            raise AssertionError(f"{name}: a pose is not in its box")
        wider.append(100 * float(((box.high - box.low) / np.ptp(poses, axis=0)).max() - 1) if box.complete else np.inf)
    label = f"{name}, {kind}: box for lengths +-1 mm"
    yield Row(f"{label}, wider by", max(wider), "%", "<= 3", max(wider) <= 3)
    yield Row(f"{label}, time", 1e3 * max(times), "ms")
    yield Row(f"{label}, leaves", max(leaves), "")


def lengths_within(lengths: Array, rng: np.random.Generator) -> Array:
    """Corners of the box of lengths and random ones in it."""
    corners = np.array(list(product((-1.0, 1.0), repeat=len(lengths))))
    return lengths + ERROR * np.concatenate([corners, rng.uniform(-1.0, 1.0, (SAMPLES, len(lengths)))])


def round_trip(x: float, y: float, z: float) -> Array:
    """Poses (N, 3) round a rectangle of half sides *x* and *y*, a step apart."""
    corners = np.array([(-x, -y, z), (x, -y, z), (x, y, z), (-x, y, z), (-x, -y, z)])
    ends = np.concatenate([[0.0], np.linalg.norm(np.diff(corners, axis=0), axis=1).cumsum()])
    along = np.arange(0.0, ends[-1] + 0.5 * PACE, PACE)
    return np.column_stack([np.interp(along, ends, each) for each in corners.T])


def slackened(lengths: Array, excess: float) -> Array:
    """The first line goes from taut to slack, *excess* (m) too long, and back in the middle of the way."""
    along = np.linspace(0.0, 1.0, len(lengths))
    longer = lengths.copy()
    longer[:, 0] += excess * np.sin(np.pi * np.clip((along - 0.3) / 0.4, 0.0, 1.0)) ** 2
    return longer


def followed(model: Model, lengths: Array, *, compare: bool = True) -> tuple[Array, list[bool], int]:
    """Time of each step, s, whether it was certified, and how many of each 100th are not where a cold solve is."""
    tracker = Tracker(model, lengths[0])
    for warm in lengths[:200]:
        tracker.step(warm)
    tracker = Tracker(model, lengths[0])
    times, found, held = np.empty(len(lengths)), [], np.empty((len(lengths), model.n))
    for row, given in enumerate(lengths):
        begin = time.perf_counter()
        status = tracker.step(given)
        times[row] = time.perf_counter() - begin
        found.append(status is Status.OK)
        held[row] = tracker.pose
    if not compare:
        return times, found, 0
    cold = solve_forward(model, lengths[::100]).pose
    away = np.linalg.norm(held[::100] - cold, axis=1)
    return times, found, int((away > SAME).sum())


def in_batch(found: Equilibrium) -> float:
    """Time of one certificate in a batch on one thread, s."""
    rows, n = found.pose.shape
    marks = (np.zeros(rows, np.int64), np.zeros((rows, n)), np.zeros((rows, n)), np.zeros(rows, np.int64))
    arrays = (found.lengths, found.pose, found.states, SAME, *marks)
    return float(best(lambda: batches.certify_rows(found.packed, *arrays, 0, rows)) / rows)
