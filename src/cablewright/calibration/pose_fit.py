"""Fits of a calibration's equations: from given starts, from rough dimensions, and moved to the wanted frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from cablewright.arrays import Array
from cablewright.calibration.observability import information, open_freedoms
from cablewright.calibration.problem import CalibrationProblem
from cablewright.kernels.fitting.calibration_residuals import MeasurementRows
from cablewright.kernels.fitting.pose_schur import StopRule
from cablewright.models.rotation import matrices, turn_between
from cablewright.progress import Progress, silent

NEAR: Final = StopRule(1e-12, 0.0, 3000, 1e-6)
QUICK: Final = StopRule(1e-6, 1e-6, 60, 1e-4)
_FAR: Final = StopRule(1e-10, 1e-6, 300, 1e-3)
_STAGE: Final = StopRule(1e-4, 1e-3, 60, 1e-3)
_ROUGHLY: Final = StopRule(1e-4, 1e-4, 40, 1e-2)
_FLIPS: Final = 4
_TRUST: Final = (0.1, 0.01, 0.001)
"""As how exact encoders are taken, m, while exit points are still drawn to where they started."""


_BATCH: Final = 8  # starts tried at a time
_BATCHES: Final = 12
_UNGUESSED: Final = 4  # batches at least, where nobody guesses poses
_AGAIN: Final = 3  # times the least cost must be found before it counts as the least
_SAME: Final = 1e-8  # m: rounding
_FINE: Final = 5e-4  # m: from here on a fit without guesses of poses may be a wrong one found several times
_ALIKE: Final = 1.01  # costs that differ by less are of one solution, or of its mirror image
_ROUNDS: Final = 8
_YAW: Final = 1e-3  # rad: up to here a yaw moves points along straight lines
_YAWS: Final = {*(f"translation along {axis}" for axis in "xyz"), "yaw"}


@dataclass(frozen=True, eq=False)
class PoseFit:
    """Where a fit ended: unknowns that are not held, poses, half the sum of squares, a code and steps taken.

    `poses` are (N, n), or what is kept of each pose where lines hang: see `hanging.Hanging`.
    """

    theta: Array
    poses: Array
    weights: Array  # (R,)
    cost: float
    code: int
    steps: int
    starts: int = 1  # how many were tried
    alike: int = 1  # and how many of them ended at this cost


def fits(
    problem: CalibrationProblem,
    theta: Array,
    poses: Array,
    weights: Array | None = None,
    settings: StopRule = NEAR,
    rows: MeasurementRows | None = None,
) -> list[PoseFit]:
    """Fit from each of B starts: *theta* (B, k) of the unknowns that are not held, *poses* (B, N, n)."""
    theta, poses = np.array(theta, order="C"), np.array(poses, order="C")
    used = problem.weights if weights is None else weights
    codes, steps, costs = problem.adjust(theta, poses, used, settings, rows)
    return [PoseFit(theta[b], poses[b], used, float(costs[b]), int(codes[b]), int(steps[b])) for b in range(len(theta))]


def fit(
    problem: CalibrationProblem, theta: Array, poses: Array, weights: Array | None = None, settings: StopRule = NEAR
) -> PoseFit:
    """Fit from one start near the solution."""
    return fits(problem, theta[None], poses[None], weights, settings)[0]


def quick_fit(problem: CalibrationProblem, rough: float) -> PoseFit:
    """The fit from the file and the guesses alone, as near as a start for other equations has to be."""
    start = first_start(problem)
    return _from_far(problem, start.theta, start.poses, rough)


def first_start(problem: CalibrationProblem) -> PoseFit:
    """Where the file's numbers and the guesses of the poses are, before any step."""
    theta, poses = next(_starts(problem, np.random.default_rng(0), 0.0, 1, first=True))
    return PoseFit(theta, poses, problem.weights, np.inf, 0, 0)


def best_fit(problem: CalibrationProblem, seed: int, rough: float, progress: Progress = silent) -> PoseFit:
    """The least cost found from the file's numbers and others up to *rough* (m) off, of equal ones the nearest to it.

    Ends where the least cost was found several times. Lengths over sheaves are the same in a mirror: of solutions that
    fit alike, the one whose exit points are nearest to the file's counts.
    """
    rng = np.random.default_rng(seed)
    rounding, fine = (0.5 * float(np.sum((off * problem.weights) ** 2)) for off in (_SAME, _FINE))
    found: list[PoseFit] = []
    guessed = problem.measured.guess is not None
    for batch in range(_BATCHES):
        tried = _AGAIN if guessed else _BATCH
        starts = list(_starts(problem, rng, rough, tried, first=batch == 0))
        for at, start in enumerate(starts):
            progress("starts, at most", batch * tried + at, _BATCHES * tried)
            each = _from_far(problem, *start, rough)
            found += [each] if np.isfinite(each.cost) else []
        if not found:
            continue
        found += _mirrored(problem, min(found, key=lambda each: each.cost))
        smallest = min(each.cost for each in found)
        alike = [each for each in found if each.cost <= _ALIKE * smallest + rounding]
        if len(alike) >= _AGAIN and (guessed or (smallest <= fine and batch + 1 >= _UNGUESSED)):
            break
    if not found:
        start = next(_starts(problem, rng, 0.0, 1, first=True))
        return fits(problem, start[0][None], start[1][None])[0]
    nearest = min(alike, key=lambda each: float(np.linalg.norm(_off(problem, each))))
    polished = fit(problem, nearest.theta, nearest.poses)
    return replace(polished, steps=nearest.steps + polished.steps, starts=len(found), alike=len(alike))


def _from_far(problem: CalibrationProblem, theta: Array, poses: Array, rough: float) -> PoseFit:
    """A fit from a far start: exit points are drawn to where they started, less and less.

    From there alone, many a machine ends in a valley that fits to millimetres and has another shape.
    """
    exits = np.array([each.name == "exit_point" for each in problem.unknowns])[~problem.held]
    drawn = np.eye(len(theta))[exits]
    if rough > 0.0 and len(drawn):
        for trust in _TRUST:
            weight = trust / (problem.encoder_sigma * rough)
            rows = problem.rows._replace(
                linear=np.concatenate([problem.rows.linear, weight * drawn]),
                wanted=np.append(problem.rows.wanted, weight * problem.free[exits]),
            )
            stage = fits(problem, theta[None], poses[None], settings=_STAGE, rows=rows)[0]
            if np.isfinite(stage.cost):
                theta, poses = stage.theta, _unmirrored(problem, stage.theta, stage.poses)
    found = fits(problem, theta[None], poses[None], settings=_FAR)[0]
    for _ in range(_FLIPS):
        poses = _unmirrored(problem, found.theta, found.poses)
        if np.array_equal(poses, found.poses):
            break
        again = fits(problem, found.theta[None], poses[None], settings=_FAR)[0]
        if not again.cost < found.cost:
            break
        found = again
    return found


def _mirrored(problem: CalibrationProblem, found: PoseFit) -> list[PoseFit]:
    """The fit from the upside-down image of another: sheaves alone tell the two apart, by millimetres."""
    if problem.robot.n == 6 or problem.measured.guess is not None or not found.cost < np.inf:
        return []
    theta, poses = found.theta.copy(), found.poses.copy()
    middle = float(problem.exit_points(theta)[:, 2].mean())
    heights = np.array([(each.name, each.axis) == ("exit_point", 2) for each in problem.unknowns])[~problem.held]
    theta[heights] = 2.0 * middle - theta[heights]
    poses[:, 2] = 2.0 * middle - poses[:, 2]
    image = fits(problem, theta[None], poses[None], settings=_FAR)[0]
    return [image] if np.isfinite(image.cost) else []


def _unmirrored(problem: CalibrationProblem, theta: Array, poses: Array) -> Array:
    """*poses* with those on the other side of the exit points' plane that fit better there.

    Where exit points are all but in one plane, lengths hardly tell on which side of it the platform is.
    """
    if not np.isfinite(problem.lengths(theta, poses)).all():
        return poses
    exits = problem.exit_points(theta)
    middle = exits.mean(axis=0)
    normal = np.linalg.svd(exits - middle)[2][2]
    mirrored = poses.copy()
    mirrored[:, :3] -= 2.0 * ((poses[:, :3] - middle) @ normal)[:, None] * normal
    mirrored = poses_alone(problem, theta, mirrored)
    here, there = (np.sum(problem.derivatives(theta, each).residual ** 2, axis=1) for each in (poses, mirrored))
    return np.asarray(np.where((there < 0.5 * here)[:, None], mirrored, poses))


def _off(problem: CalibrationProblem, found: PoseFit) -> Array:
    """How far the exit points among the unknowns are from the file's, m, but for a common translation."""
    exits = np.array([each.name == "exit_point" for each in problem.unknowns])[~problem.held]
    off = (found.theta - problem.free)[exits]
    if len(off) % 3:  # a datum holds some
        return np.asarray(off)
    return np.asarray((off.reshape(-1, 3) - off.reshape(-1, 3).mean(axis=0)).ravel())


def _starts(
    problem: CalibrationProblem, rng: np.random.Generator, rough: float, count: int, first: bool
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


def _with_offsets(problem: CalibrationProblem, theta: Array, poses: Array) -> Array:
    """The unknowns with home lengths that suit *poses* best."""
    lengths = problem.lengths(theta, poses) - problem.measured.counted
    return _with_home(problem, theta, np.nanmedian(lengths, axis=0))


def _from_home(problem: CalibrationProblem, theta: Array, home: Array) -> tuple[Array, Array]:
    """A start from a home pose alone: home lengths, then each pose by itself."""
    at_home = np.argmin(np.abs(problem.measured.counted).max(axis=1))
    poses = np.tile(home, (problem.poses, 1))
    theta = _with_home(problem, theta, problem.lengths(theta, poses[:1])[0] - problem.measured.counted[at_home])
    return theta, poses_alone(problem, theta, poses)


def poses_alone(problem: CalibrationProblem, theta: Array, poses: Array) -> Array:
    """The poses (N, n) that fit best with the unknowns as they are, from *poses* on."""
    return fits(problem.alone(theta), np.zeros((1, 0)), poses[None], settings=_ROUGHLY)[0].poses


def _with_home(problem: CalibrationProblem, theta: Array, lengths: Array) -> Array:
    """The unknowns with these home lengths (m,)."""
    whole = problem.whole(theta)
    names = [line.name for line in problem.robot.lines]
    for at, each in enumerate(problem.unknowns):
        if each.name == "length_offset" and each.line is not None:
            whole[at] = lengths[names.index(each.line)]
    return np.asarray(whole[~problem.held])


def to_file_frame(problem: CalibrationProblem, found: PoseFit) -> PoseFit:
    """Move a fit along what the data leave open, until the unknowns are as near to the file's as they can be.

    That is the inner constraint: translation and yaw of the exit points, as a whole, are those of the file.
    """
    found = _turned_back(problem, found)
    for _ in range(_ROUNDS):
        null = information(problem, found.theta, found.poses, found.weights, priors=True).null
        moved = -null @ (null.T @ _known(problem, found.theta))
        if np.linalg.norm(moved) < 1e-13:
            break
        derivatives = problem.derivatives(found.theta, found.poses, found.weights)
        change = np.einsum("nek,k->ne", derivatives.by_unknown, moved)
        follow = -np.einsum("nce,ne->nc", np.linalg.pinv(derivatives.by_pose), change)
        poses = problem.followed(found.theta, found.poses, moved, follow)
        again = fit(problem, found.theta + moved, poses, found.weights)
        found = replace(found, theta=again.theta, poses=again.poses, cost=again.cost)
    return found


def _turned_back(problem: CalibrationProblem, found: PoseFit) -> PoseFit:
    """The fit turned about the vertical towards the file, where nothing tells a yaw: that path is not straight."""
    exits = np.array([each.name == "exit_point" for each in problem.unknowns])
    if problem.held.any() or exits.sum() < 3 * problem.robot.m:
        return found
    points = problem.exit_points(found.theta)
    arms, wanted = points - points.mean(axis=0), problem.exit_points(problem.free)
    cross = arms.T @ (wanted - wanted.mean(axis=0))
    angle = float(np.arctan2(cross[0, 1] - cross[1, 0], cross[0, 0] + cross[1, 1]))
    if abs(angle) < _YAW:
        return found
    if not set(open_freedoms(information(problem, found.theta, found.poses, found.weights, priors=True))) >= _YAWS:
        return found
    turn, theta = matrices([0.0, 0.0, angle]), found.theta.copy()
    theta[exits] = (arms @ turn.T + points.mean(axis=0)).ravel()
    poses = problem.poses_of(found.poses).copy()
    poses[:, :3] = (poses[:, :3] - points.mean(axis=0)) @ turn.T + points.mean(axis=0)
    if problem.robot.n == 6:  # what takes the inverse of a rotation to a turn is the turn of that rotation
        poses[:, 3:] = turn_between(-poses[:, 3:], np.tile([0.0, 0.0, angle], (len(poses), 1)))
    return replace(found, theta=theta, poses=problem.with_poses(found.poses, poses))


def _known(problem: CalibrationProblem, theta: Array) -> Array:
    """How far unknowns are from the file's; home lengths, of which the file knows nothing, count as known."""
    known = np.array([each.name != "length_offset" for each in problem.unknowns])[~problem.held]
    return np.where(known, theta - problem.free, 0.0)
