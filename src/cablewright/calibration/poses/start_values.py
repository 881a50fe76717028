"""Start values of calibration fits: values of the file, random values near them, or the fit of straight lines.

Lines that stretch start from the answer of straight ones, at equilibria near its poses.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace
from itertools import chain, islice, repeat
from typing import Any, Final

import numpy as np

from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan
from cablewright.calibration.poses.elastic import ElasticProblem
from cablewright.calibration.poses.fit import (
    ALIKE,
    SAME,
    PoseFit,
    fit,
    fitted_poses,
    framed,
    to_file_frame,
    with_exits,
)
from cablewright.calibration.poses.observability import (
    azimuth_offsets,
)
from cablewright.calibration.poses.problem import CalibrationProblem, StraightProblem
from cablewright.calibration.poses.sufficient_data import surplus_per_pose
from cablewright.calibration.unknowns import coordinates_of, with_values
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.foundation.progress import Progress, silent
from cablewright.kernels.fitting import calibration_residuals
from cablewright.kernels.fitting.pose_schur import StopRule
from cablewright.kernels.shared_winches.quadratic_program import LINE
from cablewright.models.free_coordinates import as_held
from cablewright.models.parameters import lines_of
from cablewright.models.plane import directions, within
from cablewright.models.rotation import wrap_angle
from cablewright.models.shared_winches import shares
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse

_ELASTIC: Final = ("modulus", "exit_compliance", "centre_of_mass")
_OF_CELLS: Final = ("tension_offset", "tension_scale")
_SAG: Final = 5e-3  # m: min sigma of lengths of straight lines
_SAGGING: Final = 0.02  # of the platform's weight: min sigma of tensions along straight lines
_FITS: Final = 5.0  # max cost per redundant measurement of an accepted fit: 0.5 is expected
_WIDER: Final = 10.0  # factor on the range of measured tensions, the tension limits of a start
_FAR: Final = StopRule(1e-10, 1e-6, 300, 1e-3)
_STAGE: Final = StopRule(1e-4, 1e-3, 60, 1e-3)
_FLIPS: Final = 4
_TRUST: Final = (0.1, 0.01, 0.001)
"""Sigmas of the encoders, m, in the stages in which exit points are pulled towards their start values."""
_HOPELESS: Final = 10.0  # max ratio of the residuals after a stage to those that count as good
_RISING: Final = 0.01  # sine of the slope under which a plane lies
_BATCH: Final = 8  # starts tried at a time
_BATCHES: Final = 12
_UNGUESSED: Final = 4  # min batches without start values of the poses
_AGAIN: Final = 3  # times that the lowest cost must be found before the search ends
_FINE: Final = 5e-4  # m: without start values of the poses, a worse fit may be wrong though found several times


def quick_fit(problem: CalibrationProblem, rough: float, good: float = np.inf) -> PoseFit:
    """Fit a calibration from the file's numbers and the start values of the poses only, without other starts.

    *good*: m; a fit whose residuals stay far larger ends early, at an infinite cost.
    """
    start = first_start(problem)
    return _from_far(framed(problem, start.theta, start.poses), start.theta, start.poses, rough, good)


def typical_residual(problem: CalibrationProblem, found: PoseFit) -> float:
    """Return the median absolute residual of the lengths that encoders measure, m."""
    residual = problem.derivatives(found.theta, found.poses).residual[:, list(problem.robot.hosts)]
    return float(np.median(np.abs(residual * problem.encoder_sigma)))


def first_start(problem: CalibrationProblem) -> PoseFit:
    """Return the file's numbers and the start values of the poses, without a fit."""
    theta, poses = next(_starts(problem, np.random.default_rng(0), 0.0))
    return PoseFit(theta, poses, problem.weights, np.inf, 0, 0)


def best_fit(problem: CalibrationProblem, seed: int, rough: float, progress: Progress = silent) -> PoseFit:
    """Return the fit with the lowest cost from the file's numbers and random ones up to *rough* (m) from them.

    The search ends when the lowest cost was found several times. Lengths over sheaves are the same in a mirror: of
    solutions that fit equally, the one with exit points nearest to the file's is returned.
    """
    first = first_start(problem)
    problem = framed(problem, first.theta, first.poses)
    rounding, fine = (0.5 * float(np.sum((off * problem.weights) ** 2)) for off in (SAME, _FINE))
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
        alike = [each for each in found if each.cost <= ALIKE * smallest + rounding]
        if len(alike) >= _AGAIN and (guessed or (smallest <= fine and batch + 1 >= _UNGUESSED)):
            break
    if not found:
        return fit(problem, first.theta, first.poses)
    nearest = min(alike, key=lambda each: float(np.linalg.norm(_exits_off(problem, each))))
    polished = to_file_frame(problem, nearest)
    return replace(polished, steps=nearest.steps + polished.steps, starts=len(found), alike=len(alike))


def _from_far(problem: CalibrationProblem, theta: Array, poses: Array, rough: float, good: float = np.inf) -> PoseFit:
    """Fit from a far start, in stages that pull exit points less and less towards their start values.

    Without these stages many robots end in a local minimum of another shape that fits to millimetres. *good*: see
    `quick_fit`; a stage leaves residuals as large as its sigma.
    """
    exits = problem.named("exit_point")
    drawn = np.eye(len(theta))[exits]
    if rough > 0.0 and len(drawn):
        for trust in _TRUST:
            weight = trust / (problem.encoder_sigma * rough)
            pulled = problem.with_linear(weight * drawn, weight * problem.free[exits])
            stage = fit(pulled, theta, poses, settings=_STAGE)
            if np.isfinite(stage.cost):
                theta, poses = stage.theta, unmirrored(problem, stage.theta, stage.poses)
                stage = replace(stage, poses=poses)
            if good < np.inf and not _is_near(problem, stage, max(good, trust)):
                return replace(stage, cost=np.inf)
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


def _is_near(problem: CalibrationProblem, stage: PoseFit, size: float) -> bool:
    """Whether a stage of a fit leaves residuals that are not far larger than *size*, m."""
    ended = np.isfinite(stage.cost) and problem.is_finite(stage.theta, stage.poses)
    return bool(ended and typical_residual(problem, stage) <= _HOPELESS * size)


def _mirrored(problem: CalibrationProblem, found: PoseFit) -> list[PoseFit]:
    """Return the fit from the upside-down image of another: only the sheaves make them differ, by millimetres.

    In a plane that lies it is that along one of its axes.
    """
    if problem.robot.n == 6 or problem.measured.guess is not None or not found.cost < np.inf:
        return []
    theta, poses = found.theta.copy(), found.poses.copy()
    exits, up = problem.points(theta), _upwards(problem.robot)
    middle = exits.mean(axis=0)
    theta = with_exits(problem, theta, exits - 2.0 * ((exits - middle) @ up)[:, None] * up)
    poses -= 2.0 * ((poses - middle) @ up)[:, None] * up
    image = fit(problem, theta, poses, settings=_FAR)
    return [image] if np.isfinite(image.cost) else []


def _upwards(robot: Robot) -> Array:
    """Return the unit vector (3,) upwards in the platform's plane, along an axis of one that lies; without one: up."""
    inside = directions(robot.platform.plane, 3)
    rising = inside @ inside[2]
    size = float(np.linalg.norm(rising))
    return np.asarray(rising / size if size > _RISING else inside[:, 0])


def unmirrored(problem: CalibrationProblem, theta: Array, poses: Array) -> Array:
    """Return *poses*, each mirrored at the plane through the exit points if it fits better there.

    If exit points are nearly in one plane, lengths hardly depend on the side of it on which the platform is. Of a
    platform in a plane it is the line of that plane along which they are.
    """
    if not problem.is_finite(theta, poses):
        return poses
    exits = problem.points(theta)
    middle = exits.mean(axis=0)
    inside = directions(problem.robot.platform.plane, 3)
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
            poses = within(problem.robot.platform.plane, poses)
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
        poses = within(problem.robot.platform.plane, poses)
        at_home = np.argmin(np.abs(problem.measured.counted).max(axis=1))
        lengths = problem.lengths(theta, poses[:1])[0] - problem.measured.counted[at_home]
        theta = _with_home(problem, theta, lengths)
        poses = fitted_poses(problem, theta, poses, without=_of_open_zero(problem))
        yield _with_azimuths(problem, theta, poses, np.ones(len(poses), dtype=bool)), poses


def _within_plane(problem: CalibrationProblem, change: Array) -> Array:
    """Return a *change* (k,) of the unknowns without what moves exit points across the platform's plane, if any.

    It would bring some to the other side, from which lengths are the same.
    """
    moves, inside = np.zeros((problem.robot.m, 3)), directions(problem.robot.platform.plane, 3)
    moves.flat[coordinates_of(problem.robot, problem.free_unknowns)[1]] = change[problem.named("exit_point")]
    return with_exits(problem, change, moves @ inside @ inside.T)


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
    rows.residual[problem.of_poses(problem.weights) == 0.0] = np.nan  # blank cells
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


def elastic_fit(problem: ElasticProblem, seed: int, rough: float, progress: Progress = silent) -> PoseFit:
    """Fit elastic lines from the fit of straight lines; without redundancy, from the file and the poses' start values.

    Raises `InputError` if both are missing, `AnswerError` if there is no equilibrium near any pose.
    """
    straight = StraightProblem.of(problem.robot, problem.measured, straight_plan(problem), hold=False)
    guessed = problem.measured.guess is not None
    if surplus_per_pose(straight) < 1:
        if guessed:
            return _fit_from(problem, straight, first_start(straight))
        raise InputError(f"{problem.measured.origin}: columns x,y,z are required, start values of the poses")
    first = _fit_from(problem, straight, quick_fit(straight, rough)) if guessed else None
    redundancy = len(problem.values) - problem.poses * problem.unknowns_per_pose - len(problem.start)
    if first is not None and first.cost < _FITS * max(redundancy, 1):
        return first
    again = _fit_from(problem, straight, best_fit(straight, seed, rough, progress))
    return again if first is None or again.cost <= first.cost else first


def _fit_from(problem: ElasticProblem, straight: CalibrationProblem, found: PoseFit) -> PoseFit:
    theta, states = _relaxed(problem, straight, found)
    return replace(fit(problem, theta, fitted_poses(problem, theta, states)), starts=found.starts, alike=found.alike)


def straight_plan(problem: ElasticProblem) -> CalibrationPlan:
    """Return the calibration plan for straight lines: no effect of loads on lengths, and sigmas that allow for sag."""
    plan, robot = problem.plan, problem.robot
    min_tension = _SAGGING * robot.platform.mass * robot.scene.gravity
    exact = {"encoder": max(plan.sigma.encoder or 0.0, _SAG), "tension": max(plan.sigma.tension, min_tension)}
    return _without(plan, _ELASTIC).model_copy(update={"sigma": plan.sigma.model_copy(update=exact)})


def _without(plan: CalibrationPlan, names: Collection[str]) -> CalibrationPlan:
    """Return the plan without the unknowns of these *names*."""
    kept: dict[str, Any] = {
        key: tuple(each for each in getattr(plan, key) if each not in names) for key in ("unknowns", "shared")
    }
    for key in ("groups", "priors", "bounds"):
        kept[key] = tuple(each for each in getattr(plan, key) if each.name not in names)
    return plan.model_copy(update=kept)


def near_poses(
    model: Model, measured: Measured, plan: CalibrationPlan, seed: int, rough: float, progress: Progress = silent
) -> Measured:
    """Return the data with start poses from the other sensors, where tensions need start values or have blank cells.

    Straight lines have rows of tensions only near the poses, and those of blank cells are eliminated there. Where the
    others do not determine the poses, nothing changes.
    """
    guessed = measured.guess is not None and bool(np.isfinite(measured.guess).all())
    if measured.tensions is None or (guessed and not np.isnan(measured.tensions).any()):
        return measured
    others = replace(measured, tensions=None)
    alone = StraightProblem.of(model.robot, others, _without(plan, (*_ELASTIC, *_OF_CELLS)), hold=False)
    if surplus_per_pose(alone) < 1:
        return measured
    return replace(measured, near=best_fit(alone, seed, rough, progress).poses)


def _relaxed(problem: ElasticProblem, straight: CalibrationProblem, found: PoseFit) -> tuple[Array, Array]:
    """Return free unknowns (k,) and states (N, ..) in equilibrium at the poses of the straight lines."""
    values = straight.whole(found.theta)
    known = dict(zip(straight.unknowns, values, strict=True))
    theta = np.array([known.get(*each) for each in zip(problem.free_unknowns, problem.free, strict=True)])
    sizes = np.array([each.size for each in straight.unknowns])
    robot = with_values(problem.robot, straight.unknowns, values * sizes, raised=True)
    states = problem.states_of(equilibria_at(problem, Model(robot), found.poses))
    m, weights = problem.robot.m, np.maximum(problem.of_poses(problem.weights), 1e-300)
    homes = np.flatnonzero(problem.named("length_offset")).tolist()
    home_of = {int(lines_of(problem.robot, problem.free_unknowns[at])[0]): at for at in homes}
    tied = shares(problem.robot)[:, LINE].astype(int).tolist()
    # all lines, then those on the drums of others, which have rows of their own
    for first, lines in [(0, list(range(m))), (m, tied)][: 1 + bool(tied)]:
        off = problem.derivatives(theta, states).residual / weights
        for row, line in enumerate(lines, first):
            if line in home_of:
                theta[home_of[line]] += np.median(off[:, row])
    return theta, states


def equilibria_at(problem: ElasticProblem, found: Model, poses: Array) -> Equilibrium:
    """Return equilibria at *poses*, with tensions near the measured ones. Raises `AnswerError` if there are none."""
    robot, measured = problem.robot, problem.measured
    tensions, limits = None, None
    if measured.tensions is not None:
        tensions = problem.rows.tensions.clip(min=1e-3 * robot.platform.mass * robot.scene.gravity)
        limits = float(tensions.min() / _WIDER), float(tensions.max() * _WIDER)
    held = solve_inverse(Model(found.robot, problem.model.fidelity, limits), as_held(robot, poses), preferred=tensions)
    lost = ~np.isfinite(held.lengths).all(axis=1) | ~np.isfinite(held.pose).all(axis=1)
    if lost.all():
        place = ", ".join(f"{x:.3g}" for x in poses[0, :3])
        raise AnswerError(
            f"not calibrated: {measured.origin}, {measured.place(0)}: no equilibrium near ({place}): "
            f"{held[0].sentence()}"
        )
    good = np.flatnonzero(~lost)  # a pose without an equilibrium starts from the nearest one that has one
    apart = np.linalg.norm(poses[:, None, :3] - poses[good, :3], axis=2)
    return held[np.where(lost, good[np.argmin(apart, axis=1)], np.arange(len(poses)))]
