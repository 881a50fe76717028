"""Fits of a calibration's equations: from given starts, from rough dimensions, and moved to the frame that is wanted."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.calibration.observability import information
from cablewright.calibration.problem import Problem
from cablewright.kernels import pose_schur
from cablewright.kernels.pose_schur import Settings

__all__ = ["FAR", "NEAR", "Fit", "best_fit", "fit", "fits", "to_file_frame"]

Array = NDArray[np.float64]

NEAR: Final = Settings(1e-12, 0.0, 3000, 1e-6)
FAR: Final = Settings(1e-12, 0.0, 3000, 1e-3)

_BATCH: Final = 8  # starts tried at a time
_BATCHES: Final = 12
_AGAIN: Final = 3  # times the least cost must be found before it counts as the least
_SAME: Final = 1e-8  # m: rounding
_ALIKE: Final = 1.01  # costs that differ by less are of one solution, or of its mirror image
_ROUNDS: Final = 8


@dataclass(frozen=True, eq=False)
class Fit:
    """Where a fit ended: unknowns that are not held, poses (N, n), half the sum of squares, a code and steps taken."""

    theta: Array
    poses: Array
    weights: Array  # (R,)
    cost: float
    code: int
    steps: int
    starts: int = 1  # how many were tried


def fits(
    problem: Problem, theta: Array, poses: Array, weights: Array | None = None, settings: Settings = NEAR
) -> list[Fit]:
    """Fit from each of B starts: *theta* (B, k) of the unknowns that are not held, *poses* (B, N, n)."""
    theta, poses = np.array(theta, order="C"), np.array(poses, order="C")
    used = problem.weights if weights is None else weights
    runs = len(theta)
    codes, steps, costs = np.zeros(runs, dtype=np.int64), np.zeros(runs, dtype=np.int64), np.zeros(runs)
    values, rows = problem.values[None], np.ascontiguousarray(used)[None]
    pose_schur.adjust_runs(problem.rows, theta, poses, values, rows, settings, codes, steps, costs)
    return [
        Fit(theta[b], poses[b], used, float(costs[b]), int(codes[b]), int(steps[b])) for b in range(runs)
    ]


def fit(problem: Problem, theta: Array, poses: Array, weights: Array | None = None) -> Fit:
    """Fit from one start near the solution."""
    return fits(problem, theta[None], poses[None], weights)[0]


def best_fit(problem: Problem, seed: int, rough: float) -> Fit:
    """The least cost found from the file's numbers and others up to *rough* (m) off, of equal ones the nearest to it.

    Ends where the least cost was found several times. Lengths over sheaves are the same in a mirror: of solutions that
    fit alike, the one whose exit points are nearest to the file's counts.
    """
    rng = np.random.default_rng(seed)
    rounding = 0.5 * float(np.sum((_SAME * problem.weights) ** 2))
    found: list[Fit] = []
    for batch in range(_BATCHES):
        starts = list(_starts(problem, rng, rough, _BATCH, first=batch == 0))
        theta, poses = np.array([start[0] for start in starts]), np.array([start[1] for start in starts])
        found += [each for each in fits(problem, theta, poses, settings=FAR) if np.isfinite(each.cost)]
        if not found:
            continue
        least = min(each.cost for each in found)
        alike = [each for each in found if each.cost <= _ALIKE * least + rounding]
        if len(alike) >= _AGAIN:
            break
    if not found:
        start = next(_starts(problem, rng, 0.0, 1, first=True))
        return fits(problem, start[0][None], start[1][None])[0]
    nearest = min(alike, key=lambda each: float(np.linalg.norm(_off(problem, each))))
    return Fit(*(getattr(nearest, name) for name in ("theta", "poses", "weights", "cost", "code", "steps")), len(found))


def _off(problem: Problem, found: Fit) -> Array:
    """How far the exit points among the unknowns are from the file's, m, but for a common translation."""
    exits = np.array([each.name == "exit_point" for each in problem.unknowns])[~problem.held]
    off = (found.theta - problem.free)[exits]
    return off - off.mean() if len(off) % 3 else (off.reshape(-1, 3) - off.reshape(-1, 3).mean(axis=0)).ravel()


def _starts(
    problem: Problem, rng: np.random.Generator, rough: float, count: int, first: bool
) -> Iterator[tuple[Array, Array]]:
    """Yield starts; the *first* of all is that of the file."""
    scene, n = problem.robot.scene, problem.robot.n
    low, high = np.array(scene.frame_min), np.array(scene.frame_max)
    exits = np.array([each.name == "exit_point" for each in problem.unknowns])[~problem.held]
    for k in range(count):
        away = 0.0 if first and k == 0 else rough
        theta = problem.free + exits * rng.uniform(-away, away, len(exits))
        if problem.measured.guess is not None:
            poses = problem.measured.guess.copy()
            poses[:, :3] += rng.uniform(-0.5 * away, 0.5 * away, (len(poses), 3))
            yield _with_offsets(problem, theta, poses), poses
            continue
        share = 0.5 if away == 0.0 else rng.uniform(0.2, 0.8, 3)
        home = np.zeros(n)
        home[:3] = low + share * (high - low)
        yield _from_home(problem, theta, home)


def _with_offsets(problem: Problem, theta: Array, poses: Array) -> Array:
    """The unknowns with home lengths that suit *poses* best."""
    whole = problem.whole(theta)
    lengths = problem.lengths(theta, poses) - problem.measured.counted
    means = np.nanmedian(np.where(np.isfinite(lengths), lengths, np.nan), axis=0)
    names = [line.name for line in problem.robot.lines]
    for at, each in enumerate(problem.unknowns):
        if each.name == "length_offset" and each.line is not None:
            whole[at] = means[names.index(each.line)]
    return whole[~problem.held]


def _from_home(problem: Problem, theta: Array, home: Array) -> tuple[Array, Array]:
    """A start from a home pose alone: home lengths, then each pose by itself."""
    robot, count = problem.robot, problem.poses
    at_home = np.argmin(np.abs(problem.measured.counted).max(axis=1))
    poses = np.tile(home, (count, 1))
    theta = _with_home(problem, theta, problem.lengths(theta, poses[:1])[0] - problem.measured.counted[at_home])
    lines = problem.rows.lines.copy()
    for i in range(robot.m):
        for c in range(lines.shape[1]):
            if problem.rows.target[i, c] >= 0:
                lines[i, c] = theta[problem.rows.target[i, c]]
    alone = problem.rows._replace(
        lines=lines, target=np.full_like(problem.rows.target, -1), linear=np.zeros((0, 0)), wanted=np.zeros(0)
    )
    moved = poses[None].copy()
    codes, steps, costs = np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.int64), np.zeros(1)
    values, weights = problem.values[None], problem.weights[None]
    settings = Settings(1e-4, 1e-4, 40, 1e-2)
    pose_schur.adjust_runs(alone, np.zeros((1, 0)), moved, values, weights, settings, codes, steps, costs)
    return theta, moved[0]


def _with_home(problem: Problem, theta: Array, lengths: Array) -> Array:
    whole = problem.whole(theta)
    names = [line.name for line in problem.robot.lines]
    for at, each in enumerate(problem.unknowns):
        if each.name == "length_offset" and each.line is not None:
            whole[at] = lengths[names.index(each.line)]
    return whole[~problem.held]


def to_file_frame(problem: Problem, found: Fit) -> Fit:
    """Move a fit along what the data leave open, until the unknowns are as near to the file's as they can be.

    That is the inner constraint: translation and yaw of the exit points, as a whole, are those of the file.
    """
    for _ in range(_ROUNDS):
        null = information(problem, found.theta, found.poses, found.weights, priors=True).null
        moved = -null @ (null.T @ _known(problem, found.theta))
        if np.linalg.norm(moved) < 1e-13:
            break
        derivatives = problem.derivatives(found.theta, found.poses, found.weights)
        change = np.einsum("nek,k->ne", derivatives.by_unknown, moved)
        follow = -np.einsum("nce,ne->nc", np.linalg.pinv(derivatives.by_pose), change)
        again = fit(problem, found.theta + moved, found.poses + follow, found.weights)
        found = Fit(again.theta, again.poses, found.weights, again.cost, found.code, found.steps, found.starts)
    return found


def _known(problem: Problem, theta: Array) -> Array:
    """How far unknowns are from the file's; home lengths, of which the file knows nothing, count as known."""
    known = np.array([each.name != "length_offset" for each in problem.unknowns])[~problem.held]
    return np.where(known, theta - problem.free, 0.0)
