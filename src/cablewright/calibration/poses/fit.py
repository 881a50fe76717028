"""Fits of a calibration's equations: from given starts, from rough dimensions, and moved to the file's frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain, islice, repeat
from typing import Final

import numpy as np

from cablewright.arrays import Array, Mask
from cablewright.calibration.poses.observability import (
    Information,
    azimuth_offsets,
    beyond_frames,
    frame_rows,
    information,
    open_freedoms,
    without,
    world_motions,
)
from cablewright.calibration.poses.problem import CalibrationProblem
from cablewright.calibration.sensors.positions import free_directions, on_file_side, upwards
from cablewright.calibration.unknowns import coordinates_of
from cablewright.kernels.fitting import calibration_residuals
from cablewright.kernels.fitting.calibration_residuals import MeasurementRows
from cablewright.kernels.fitting.pose_schur import StopRule
from cablewright.models.parameters import lines_of
from cablewright.models.rotation import matrices, wrap_angle, yawed
from cablewright.progress import Progress, silent

NEAR: Final = StopRule(1e-12, 0.0, 3000, 1e-6)
QUICK: Final = StopRule(1e-6, 1e-6, 60, 1e-4)
_FAR: Final = StopRule(1e-10, 1e-6, 300, 1e-3)
_STAGE: Final = StopRule(1e-4, 1e-3, 60, 1e-3)
_ROUGHLY: Final = StopRule(1e-4, 1e-4, 40, 1e-2)
_FLIPS: Final = 4
_TRUST: Final = (0.1, 0.01, 0.001)
"""Sigmas of the encoders, m, in the stages in which exit points are pulled towards their start values."""

_BATCH: Final = 8  # starts tried at a time
_BATCHES: Final = 12
_UNGUESSED: Final = 4  # min batches without start values of the poses
_AGAIN: Final = 3  # times that the lowest cost must be found before the search ends
_SAME: Final = 1e-8  # m: rounding
_FINE: Final = 5e-4  # m: without start values of the poses, a worse fit may be wrong though found several times
_ALIKE: Final = 1.01  # costs within this ratio are of one solution, or of its mirror image
_ROUNDS: Final = 8
_SETTLED: Final = 1e-11  # m: nearer to the datum it does not move
_FRAME: Final = 0.1  # weight of the datum over that of an encoder
_YAW: Final = 1e-3  # rad: a smaller yaw moves points along straight lines
_YAWS: Final = {*(f"translation along {axis}" for axis in "xyz"), "yaw"}


@dataclass(frozen=True, eq=False)
class PoseFit:
    """The result of a fit."""

    theta: Array  # (k,) the free unknowns
    poses: Array  # (N, n), or the states (N, ..) of the poses of an `ElasticProblem`
    weights: Array  # (R,)
    cost: float  # half the sum of squares
    code: int  # of the kernel, 0 if it converged
    steps: int  # accepted
    starts: int = 1  # number of starts tried
    alike: int = 1  # number of starts that ended at this cost


def fits(
    problem: CalibrationProblem,
    theta: Array,
    poses: Array,
    weights: Array | None = None,
    settings: StopRule = NEAR,
    rows: MeasurementRows | None = None,
) -> list[PoseFit]:
    """Fit from each of B starts: free unknowns *theta* (B, k), and *poses* (B, N, n) or states (B, N, ..).

    Starts out of the range of an unknown begin at its edge, those off the platform's plane in it.
    """
    theta, poses = np.array(np.clip(theta, *problem.limits), order="C"), np.array(problem.in_plane(poses), order="C")
    used = problem.weights if weights is None else weights
    codes, steps, costs = problem.adjust(theta, poses, used, settings, rows)
    return [PoseFit(theta[b], poses[b], used, float(costs[b]), int(codes[b]), int(steps[b])) for b in range(len(theta))]


def fit(
    problem: CalibrationProblem, theta: Array, poses: Array, weights: Array | None = None, settings: StopRule = NEAR
) -> PoseFit:
    """Fit from one start near the solution."""
    return fits(problem, theta[None], poses[None], weights, settings)[0]


def refit(problem: CalibrationProblem, found: PoseFit, weights: Array | None = None) -> PoseFit:
    """Fit again from a fit, with its weights or others (R,); its starts and steps stay told."""
    again = fit(problem, found.theta, found.poses, found.weights if weights is None else weights)
    return replace(found, theta=again.theta, poses=again.poses, weights=again.weights, cost=again.cost, code=again.code)


def quick_fit(problem: CalibrationProblem, rough: float) -> PoseFit:
    """Fit from the file's numbers and the start values of the poses only."""
    start = first_start(problem)
    return _from_far(framed(problem, start.theta, start.poses), start.theta, start.poses, rough)


def first_start(problem: CalibrationProblem) -> PoseFit:
    """Return the file's numbers and the start values of the poses, without a fit."""
    theta, poses = next(_starts(problem, np.random.default_rng(0), 0.0))
    return PoseFit(theta, poses, problem.weights, np.inf, 0, 0)


def best_fit(problem: CalibrationProblem, seed: int, rough: float, progress: Progress = silent) -> PoseFit:
    """Return the fit with the lowest cost from the file's numbers and random ones up to *rough* (m) from them.

    The search ends when the lowest cost was found several times. Lengths over sheaves are the same in a mirror: of
    solutions that fit alike, the one with exit points nearest to the file's is returned.
    """
    first = first_start(problem)
    problem = framed(problem, first.theta, first.poses)
    rounding, fine = (0.5 * float(np.sum((off * problem.weights) ** 2)) for off in (_SAME, _FINE))
    found: list[PoseFit] = []
    guessed = problem.measured.guess is not None
    size = _AGAIN if guessed else _BATCH
    starts = _starts(problem, np.random.default_rng(seed), rough)
    for batch in range(_BATCHES):
        for at, start in enumerate(islice(starts, size)):
            progress("starts, max", batch * size + at, _BATCHES * size)
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
        return fit(problem, first.theta, first.poses)
    nearest = min(alike, key=lambda each: float(np.linalg.norm(_exits_off(problem, each))))
    polished = to_file_frame(problem, nearest)
    return replace(polished, steps=nearest.steps + polished.steps, starts=len(found), alike=len(alike))


def _from_far(problem: CalibrationProblem, theta: Array, poses: Array, rough: float) -> PoseFit:
    """Fit from a far start, in stages that pull exit points less and less towards their start values.

    Without these stages many robots end in a local minimum of another shape that fits to millimetres.
    """
    exits = problem.named("exit_point")
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
                theta, poses = stage.theta, unmirrored(problem, stage.theta, stage.poses)
    found = fit(problem, theta, poses, settings=_FAR)
    for _ in range(_FLIPS):
        poses = unmirrored(problem, found.theta, found.poses)
        if np.array_equal(poses, found.poses):
            break
        again = fit(problem, found.theta, poses, settings=_FAR)
        if not again.cost < found.cost:
            break
        found = again
    return found


def _mirrored(problem: CalibrationProblem, found: PoseFit) -> list[PoseFit]:
    """Return the fit from the upside-down image of another: only the sheaves make them differ, by millimetres.

    In a plane that lies it is that along one of its axes.
    """
    if problem.robot.n == 6 or problem.measured.guess is not None or not found.cost < np.inf:
        return []
    theta, poses = found.theta.copy(), found.poses.copy()
    exits, up = problem.exit_points(theta), upwards(problem.robot)
    middle = exits.mean(axis=0)
    theta = _with_exits(problem, theta, exits - 2.0 * ((exits - middle) @ up)[:, None] * up)
    poses -= 2.0 * ((poses - middle) @ up)[:, None] * up
    image = fit(problem, theta, poses, settings=_FAR)
    return [image] if np.isfinite(image.cost) else []


def unmirrored(problem: CalibrationProblem, theta: Array, poses: Array) -> Array:
    """Return *poses*, each mirrored at the plane through the exit points if it fits better there.

    If exit points are nearly in one plane, lengths hardly depend on the side of it on which the platform is. Of a
    platform in a plane it is the line of that plane along which they are.
    """
    if not problem.is_finite(theta, poses):
        return poses
    exits = problem.exit_points(theta)
    middle = exits.mean(axis=0)
    inside = free_directions(problem.robot)[:3, :3]
    inside = inside if problem.robot.platform.plane is None else inside[:, :2]
    normal = inside @ np.linalg.svd((exits - middle) @ inside)[2][-1]
    mirrored = poses.copy()
    mirrored[:, :3] -= 2.0 * ((poses[:, :3] - middle) @ normal)[:, None] * normal
    mirrored = fitted_poses(problem, theta, mirrored)
    here, there = (np.sum(problem.derivatives(theta, each).residual ** 2, axis=1) for each in (poses, mirrored))
    return np.asarray(np.where((there < 0.5 * here)[:, None], mirrored, poses))


def _exits_off(problem: CalibrationProblem, found: PoseFit) -> Array:
    """Return the distances of exit points from the file's, m, less a common translation unless a datum holds some."""
    off = (found.theta - problem.free)[problem.named("exit_point")]
    if not len(off) or len(off) % 3:
        return np.asarray(off)
    return np.asarray((off.reshape(-1, 3) - off.reshape(-1, 3).mean(axis=0)).ravel())


def _starts(problem: CalibrationProblem, rng: np.random.Generator, rough: float) -> Iterator[tuple[Array, Array]]:
    """Yield starts (k,), (N, n) without end: first that of the file, then random ones up to *rough* (m) from it."""
    scene = problem.robot.scene
    low, high = np.array(scene.frame_min), np.array(scene.frame_max)
    exits = problem.named("exit_point")
    for away in chain([0.0], repeat(rough)):
        theta = problem.free + _within_plane(problem, exits * rng.uniform(-away, away, len(exits)))
        if problem.measured.guess is not None:
            known = np.asarray(np.isfinite(problem.measured.guess).all(axis=1))
            poses = np.where(known[:, None], problem.measured.guess, problem.measured.guess[known].mean(axis=0))
            poses[:, :3] += rng.uniform(-0.5 * away, 0.5 * away, (len(poses), 3))
            poses = problem.in_plane(poses)
            lengths = (problem.lengths(theta, poses) - problem.measured.counted)[known]
            theta = _with_home(problem, theta, np.nanmedian(lengths, axis=0))
            theta = _with_azimuths(problem, theta, poses, known)
            if not known.all():
                poses = np.where(known[:, None], poses, fitted_poses(problem, theta, poses))
            yield theta, poses
            continue
        share = 0.5 if away == 0.0 else rng.uniform(0.2, 0.8, 3)
        poses = np.zeros((problem.poses, problem.robot.n))
        poses[:, :3] = low + share * (high - low)
        poses = problem.in_plane(poses)
        at_home = np.argmin(np.abs(problem.measured.counted).max(axis=1))
        lengths = problem.lengths(theta, poses[:1])[0] - problem.measured.counted[at_home]
        theta = _with_home(problem, theta, lengths)
        poses = fitted_poses(problem, theta, poses, without=_of_open_zero(problem))
        yield _with_azimuths(problem, theta, poses, np.ones(len(poses), dtype=bool)), poses


def _within_plane(problem: CalibrationProblem, change: Array) -> Array:
    """Return a *change* (k,) of the unknowns without what moves exit points across the platform's plane, if any.

    It would bring some to the other side, from which lengths are the same.
    """
    plane = problem.robot.platform.plane
    if plane is None:
        return change
    moves, normal = np.zeros((problem.robot.m, 3)), np.array(plane.across)
    moves.flat[coordinates_of(problem.robot, problem.free_unknowns)[1]] = change[problem.named("exit_point")]
    return _with_exits(problem, change, moves - np.outer(moves @ normal, normal))


def _with_exits(problem: CalibrationProblem, theta: Array, exits: Array) -> Array:
    """Return the free unknowns *theta* (k,) with those of exit points from *exits* (m, 3)."""
    changed = theta.copy()
    which, coordinates = coordinates_of(problem.robot, problem.free_unknowns)
    changed[which] = exits.ravel()[coordinates]
    return changed


def fitted_poses(problem: CalibrationProblem, theta: Array, poses: Array, without: Mask | None = None) -> Array:
    """Return the poses (N, n) or states (N, ..) that fit best with the unknowns *theta*, from start values *poses*.

    *without*: rows (e,) of each pose that do not count.
    """
    weights = problem.weights.copy()
    if without is not None:
        problem.of_poses(weights)[:, without] = 0.0
    return fits(problem.for_poses_only(theta), np.zeros((1, 0)), poses[None], weights, settings=_ROUGHLY)[0].poses


def _of_open_zero(problem: CalibrationProblem) -> Mask:
    """Return which rows (e,) of a pose are azimuths by a sensor of unknown zero."""
    kinds, names = problem.rows.kind[: problem.per_pose], {each.name for each in problem.free_unknowns}
    swivel, yaw = (kinds == kind for kind in (calibration_residuals.SWIVEL, calibration_residuals.YAW))
    return np.asarray((swivel & ("swivel_offset" in names)) | (yaw & ("yaw_offset" in names)))


def _with_azimuths(problem: CalibrationProblem, theta: Array, poses: Array, known: Mask) -> Array:
    """Return the unknowns (k,) with the zeros of sensors of azimuths that fit on average where *poses* are *known*.

    Of the values that are whole turns apart, each is the nearest to the middle of its range.
    """
    rows_of = np.flatnonzero(_of_open_zero(problem))
    if not len(rows_of):
        return theta
    rows, changed = problem.derivatives(theta, poses, np.ones(len(problem.values))), theta.copy()
    middle = problem.limits.mean(axis=0)
    for at in np.flatnonzero(azimuth_offsets(problem.free_unknowns)):
        own = rows_of[rows.by_unknown[0, rows_of, at] != 0.0]
        changed[at] += float(np.angle(np.nanmean(np.exp(1j * rows.residual[np.ix_(known, own)]))))
        changed[at] = middle[at] + wrap_angle(changed[at] - middle[at])
    return changed


def _with_home(problem: CalibrationProblem, theta: Array, lengths: Array) -> Array:
    """Return the unknowns (k,) with these home lengths (m,)."""
    changed = theta.copy()
    for at, each in enumerate(problem.free_unknowns):
        if each.name == "length_offset":
            changed[at] = lengths[lines_of(problem.robot, each)[0]]
    return changed


def to_file_frame(problem: CalibrationProblem, found: PoseFit) -> PoseFit:
    """Return the fit at which the unknowns are as near to the file's as the open freedoms allow.

    This is the inner constraint: translation and yaw of the exit points, as a whole, are those of the file. Home
    lengths and offsets of sensors, which the file does not have, do not count. It holds within the fit: what the data
    leave open cannot creep.
    """
    found = _turned_back(problem, _on_file_side(problem, found))
    for turn in range(_ROUNDS):
        framed = _framed(problem, information(problem, found.theta, found.poses, found.weights, priors=True))
        rows, wanted = framed.frame
        off = np.linalg.norm(rows @ found.theta - wanted) / _frame_weight(problem) if len(rows) else 0.0
        if turn and off < _SETTLED:
            break
        found = refit(framed, found)
    return found


def framed(problem: CalibrationProblem, theta: Array, poses: Array) -> CalibrationProblem:
    """Return the problem with the motions of frames that are open at *theta*, *poses* (N, n) held in its fits."""
    if not problem.is_finite(theta, poses):
        return problem
    found = information(problem, theta, poses, problem.weights, priors=True)
    beyond = beyond_frames(found)
    return _framed(problem, replace(found, null=without(found.null, beyond)))


def _framed(problem: CalibrationProblem, found: Information) -> CalibrationProblem:
    return replace(problem, frame=frame_rows(found, problem.free, _frame_weight(problem)))


def _frame_weight(problem: CalibrationProblem) -> float:
    """Return the weight of the rows of a frame: any gives the same answer; this one keeps the equations regular."""
    return _FRAME / problem.encoder_sigma


def yaw_between(points: Array, others: Array, axis: Array | None = None) -> float:
    """Return the yaw, rad, about the origin that moves *points* (m, 3) as near as possible to *others* (m, 3).

    Or the turn about another *axis*, a unit vector.
    """
    cross = points.T @ others
    if axis is not None:
        sines = np.array([cross[1, 2] - cross[2, 1], cross[2, 0] - cross[0, 2], cross[0, 1] - cross[1, 0]])
        return float(np.arctan2(sines @ axis, np.trace(cross) - axis @ cross @ axis))
    return float(np.arctan2(cross[0, 1] - cross[1, 0], cross[0, 0] + cross[1, 1]))


def _on_file_side(problem: CalibrationProblem, found: PoseFit) -> PoseFit:
    """Return the fit with exit points on the file's side of the platform's plane, unless it is a worse one."""
    if problem.robot.platform.plane is None or found.code != 0:
        return found
    exits = problem.exit_points(found.theta)
    wanted = on_file_side(problem.robot, exits, problem.points(found.theta, "platform_point"))
    if np.array_equal(exits, wanted):
        return found
    here = refit(problem, found)
    there = refit(problem, replace(here, theta=_with_exits(problem, here.theta, wanted)))
    rounding = 0.5 * float(np.sum((_SAME * problem.weights) ** 2))
    return there if there.code == 0 and there.cost <= _ALIKE * here.cost + rounding else found


def _turned_back(problem: CalibrationProblem, found: PoseFit) -> PoseFit:
    """Return the fit turned about the vertical towards the file, a path that is not straight, if yaw is open.

    Of a platform in a plane it is the turn about the normal.
    """
    exits = problem.named("exit_point")
    if problem.held.any() or exits.sum() < 3 * problem.robot.m:
        return found
    points = problem.exit_points(found.theta)
    arms, file = points - points.mean(axis=0), problem.exit_points(problem.free)
    plane = problem.robot.platform.plane
    axis = np.array([0.0, 0.0, 1.0] if plane is None else plane.across)
    angle = yaw_between(arms, file - file.mean(axis=0), None if plane is None else axis)
    if abs(angle) < _YAW:
        return found
    names = set(open_freedoms(information(problem, found.theta, found.poses, found.weights, priors=True)))
    if not names >= (_YAWS if plane is None else set(world_motions(problem.robot))):
        return found
    turn, theta = matrices(angle * axis), found.theta.copy()
    theta[exits] = (arms @ turn.T + points.mean(axis=0)).ravel()
    theta += angle * axis[2] * azimuth_offsets(problem.free_unknowns)  # a turn about another axis is not open with them
    poses = yawed(problem.poses_of(found.poses), angle, points.mean(axis=0), axis)
    return replace(found, theta=theta, poses=problem.with_poses(found.poses, poses))
