"""Tension distribution at random poses of jung2020, beside a QP and an LP solver, and its workspace; one thread."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

from benchmarks.timing import Row, best, installed
from cablewright.analyses.workspace.workspace import workspace
from cablewright.kernels import layout
from cablewright.kernels.layout import Packed
from cablewright.kernels.wrench_feasibility import capacity_margin, distribution
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.tension import METHODS, structures

Array = NDArray[np.float64]
REPEATS = 50
AIMS = {"closed-form": 2.5e6, "improved-closed-form": 1.5e6, "exact": 1e6}  # poses/s
CAPACITY_AIM = 9e4
SURE = 1e-9  # of the limits: a margin under this is no disagreement
EQUAL = 5  # what daqp calls an equation
VOLUME_AIM = 1.0  # s


@dataclass(frozen=True)
class Size:
    """How much is measured."""

    poses: int = 5000  # a few milliseconds: some repeats run undisturbed
    compared: int = 2000  # poses
    timed: int = 20  # of them, so that here too some repeats run undisturbed
    tolerance: float = 2e-3  # of volumes
    volumes: int = 5  # repeats


FULL, QUICK = Size(), Size(50, 5, 1, 0.2, 1)


def rows(size: Size) -> Iterator[Row]:
    """All rows of this file."""
    model = Model(load("jung2020"), Fidelity(CableLaw.RIGID))
    poses = random_poses(model, size.poses)
    packed = model.rows()
    speeds = {}
    for name, method in METHODS.items():
        _, seconds = distributed(packed, poses, method)
        speed = speeds[name] = len(poses) / seconds
        aim = AIMS.get(name)
        told = "" if aim is None else f">= {aim:,.0f}"
        yield Row(f"jung2020: {name}", speed, "poses/s", told, None if aim is None else speed >= aim)
    speed = len(poses) / capacity_time(packed, poses)
    told = f">= {CAPACITY_AIM:,.0f}"
    yield Row("jung2020: capacity margin by facets", speed, "poses/s", told, speed >= CAPACITY_AIM)
    for name in ("jung2020", "jung2020-table1"):
        for criterion in AIMS:
            yield volume_row(Model(load(name), Fidelity(CableLaw.RIGID)), criterion, size)
        yield from peer_rows(Model(load(name), Fidelity(CableLaw.RIGID)), speeds["exact"], size)


def volume_row(model: Model, criterion: str, size: Size) -> Row:
    """Time of a volume whose error is within the tolerance, relative, on one thread."""
    tolerance = size.tolerance
    with patch("cablewright.solvers.row_threads.thread_count", lambda: 1):
        found = workspace(model, criterion, tolerance=tolerance)
        seconds = best(lambda: workspace(model, criterion, tolerance=tolerance), size.volumes)
    known = found.converged and found.volume_error <= tolerance * found.volume
    name = f"{model.robot.name}: volume to {100 * tolerance:g} %, {criterion}"
    return Row(name, seconds, "s", f"<= {VOLUME_AIM:g}", known and seconds <= VOLUME_AIM)


def random_poses(model: Model, count: int) -> Array:
    """Random places in the frame, unrotated: (count, 6)."""
    scene = model.robot.scene
    places = np.random.default_rng(20200824).uniform(scene.frame_min, scene.frame_max, (count, 3))
    return np.column_stack([places, np.zeros((count, 3))])


def distributed(packed: Packed, poses: Array, method: int) -> tuple[Array, float]:
    """Margins, and the time on one thread, s."""
    count, m = len(poses), packed.lines.shape[1]
    tensions, margins, codes = np.zeros((count, m)), np.zeros(count), np.zeros(count, np.int64)
    arrays = (packed, poses, method, np.ones(m), np.zeros(m), tensions, margins, codes)
    seconds = best(lambda: distribution.distribute_rows(*arrays, 0, count), REPEATS)
    return margins, seconds


def capacity_time(packed: Packed, poses: Array) -> float:
    """Time of the capacity margins on one thread, s."""
    count = len(poses)
    margins, ranks, codes = np.zeros(count), np.zeros(count, np.int64), np.zeros(count, np.int64)
    arrays = (packed, poses, np.zeros(packed.freedoms), 1.0, margins, ranks, codes)
    return best(lambda: capacity_margin.capacity_rows(*arrays, 0, count), REPEATS)


def peer_rows(model: Model, speed: float, size: Size) -> Iterator[Row]:
    """What is feasible according to daqp and HiGHS, which are given the structure matrices, and how long they take."""
    name, poses = model.robot.name, random_poses(model, size.compared)
    A, w = structures(model, poses)
    packed = model.rows()
    low, high = np.ascontiguousarray(packed.lines[0, :, [layout.TENSION_MIN, layout.TENSION_MAX]])
    margins, _ = distributed(packed, poses, METHODS["exact"])
    sure = np.abs(margins) > SURE * high.max()
    peers = {"daqp": by_daqp} if installed("daqp") else {}
    for peer, solve in (peers | {"scipy HiGHS": by_highs}).items():
        said = np.array([solve(A[row], w[row], low, high) for row in range(len(poses))])
        wrong = int(((margins >= 0.0) != said)[sure].sum())
        if name == "jung2020":
            timed = best(lambda f=solve: [f(A[row], w[row], low, high) for row in range(size.timed)], REPEATS)
            each = size.timed / timed
            yield Row(f"{name}: exact", speed, "poses/s", peer=f"{peer}, {each:,.0f}/s", ratio=speed / each)
        known = peer != "daqp"
        aim, met = ("= 0", wrong == 0) if known else ("", None)
        yield Row(f"{name}: exact and {peer} disagree", wrong, f"of {len(poses)}", aim, met)


def by_daqp(A: Array, w: Array, low: Array, high: Array) -> bool:
    """Whether daqp finds the least-norm tensions."""
    import daqp

    n, m = A.shape
    sense = np.r_[np.zeros(m, np.int32), np.full(n, EQUAL, np.int32)]
    _, _, flag, _ = daqp.solve(np.eye(m), np.zeros(m), A, np.r_[high, -w], np.r_[low, -w], sense)
    return bool(flag > 0)


def by_highs(A: Array, w: Array, low: Array, high: Array) -> bool:
    """Whether HiGHS finds any tensions."""
    found = linprog(np.zeros(A.shape[1]), A_eq=A, b_eq=-w, bounds=np.column_stack([low, high]), method="highs")
    return bool(found.status == 0)
