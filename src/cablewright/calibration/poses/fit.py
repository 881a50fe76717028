"""Fits of a calibration's equations: from given starts, from rough dimensions, and expressed in the file's frame."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

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
from cablewright.calibration.unknowns import coordinates_of, of_unknown_exits
from cablewright.foundation.arrays import Array, Mask
from cablewright.kernels.fitting.pose_schur import StopRule
from cablewright.models.plane import turning_axis
from cablewright.models.rotation import matrices, yawed
from cablewright.robot import Robot

NEAR: Final = StopRule(1e-12, 0.0, 3000, 1e-6)
QUICK: Final = StopRule(1e-6, 1e-6, 20, 1e-4)
_ROUGHLY: Final = StopRule(1e-4, 1e-4, 40, 1e-2)

SAME: Final = 1e-8  # m: rounding
ALIKE: Final = 1.01  # costs within this ratio are of one solution, or of its mirror image
_ROUNDS: Final = 8
_SETTLED: Final = 1e-11  # m: nearer to the datum it does not move
_FRAME: Final = 0.1  # weight of the datum over that of an encoder
_YAW: Final = 1e-3  # rad: a smaller yaw moves points along straight lines
_ON: Final = 1e-6  # m: a line whose ends are as near across the plane runs in it, on no side
_YAWS: Final = {*(f"translation along {axis}" for axis in "xyz"), "yaw"}


@dataclass(frozen=True, eq=False)
class PoseFit:
    """The result of a calibration fit: values, poses, weights and residuals."""

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
) -> list[PoseFit]:
    """Fit a calibration from B starts: free unknowns *theta* (B, k), and *poses* (B, N, n) or states (B, N, ..).

    Starts out of the range of an unknown begin at its edge, those off the platform's plane in it.
    """
    theta, poses = np.array(np.clip(theta, *problem.limits), order="C"), np.array(poses, order="C")
    used = problem.weights if weights is None else weights
    codes, steps, costs = problem.in_frame().adjust(theta, poses, used, settings)
    return [PoseFit(theta[b], poses[b], used, float(costs[b]), int(codes[b]), int(steps[b])) for b in range(len(theta))]


def fit(
    problem: CalibrationProblem, theta: Array, poses: Array, weights: Array | None = None, settings: StopRule = NEAR
) -> PoseFit:
    """Fit a calibration from one start near the solution."""
    return fits(problem, theta[None], poses[None], weights, settings)[0]


def refit(problem: CalibrationProblem, found: PoseFit, weights: Array | None = None) -> PoseFit:
    """Fit again from the solution of a fit, with its weights or others (R,); the reported starts and steps stay."""
    again = fit(problem, found.theta, found.poses, found.weights if weights is None else weights)
    return replace(found, theta=again.theta, poses=again.poses, weights=again.weights, cost=again.cost, code=again.code)


def with_exits(problem: CalibrationProblem, theta: Array, exits: Array) -> Array:
    """Return the free unknowns *theta* (k,) with exit points replaced by *exits* (m, 3), m."""
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


def to_file_frame(problem: CalibrationProblem, found: PoseFit) -> PoseFit:
    """Return the fit whose unknowns are nearest to the robot file in the directions that the data leave open.

    This is the inner constraint: translation and yaw of the exit points, as a whole, are those of the file. Home
    lengths and offsets of sensors, which the file does not have, do not count. It holds within the fit: undetermined
    combinations cannot creep.
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
    """Return the problem with rigid motions of a frame that the data leave open held in its fits.

    They are those at *theta*, *poses* (N, n).
    """
    if not problem.is_finite(theta, poses):
        return problem
    found = information(problem, theta, poses, problem.weights, priors=True)
    return _framed(problem, replace(found, null=without(found.null, beyond_frames(found))))


def _framed(problem: CalibrationProblem, found: Information) -> CalibrationProblem:
    return replace(problem, frame=frame_rows(found, problem.free, _frame_weight(problem)))


def _frame_weight(problem: CalibrationProblem) -> float:
    """Return the weight of the rows of a frame: any gives the same answer; this one keeps the equations regular."""
    return _FRAME / problem.encoder_sigma


def yaw_between(points: Array, others: Array, axis: ArrayLike = (0.0, 0.0, 1.0)) -> float:
    """Return the rotation, rad, about an *axis* through the origin that best moves *points* onto *others* (m, 3).

    By default it is the yaw. The axis is a unit vector.
    """
    cross, axis = points.T @ others, np.asarray(axis)
    sines = np.array([cross[1, 2] - cross[2, 1], cross[2, 0] - cross[0, 2], cross[0, 1] - cross[1, 0]])
    return float(np.arctan2(sines @ axis, np.trace(cross) - axis @ cross @ axis))


def on_file_side(robot: Robot, exits: Array, points: Array) -> Array:
    """Return *exits* (m, 3), m, each on the side of the plane through the line's platform point where the file's is.

    Straight lines to a platform in a plane are as long from the mirror image of their exit point. *points*: platform
    points (m, 3), m. Exit points of a robot without a plane stay as they are.
    """
    plane = robot.platform.plane
    if plane is None:
        return exits
    normal = np.array(plane.across)
    file = np.array([np.subtract(line.exit_point, line.platform_point) for line in robot.lines]) @ normal
    wanted, found = file - plane.distance, (exits - points) @ normal - plane.distance
    other = (np.abs(wanted) > _ON) & (np.sign(found) == -np.sign(wanted))
    return np.asarray(np.where(other[:, None], exits - 2.0 * found[:, None] * normal, exits))


def _on_file_side(problem: CalibrationProblem, found: PoseFit) -> PoseFit:
    """Return the fit with exit points on the file's side of the platform's plane, unless it is a worse one."""
    if found.code != 0:
        return found
    exits = problem.points(found.theta)
    wanted = on_file_side(problem.robot, exits, problem.points(found.theta, "platform_point"))
    if np.array_equal(exits, wanted):
        return found
    here = refit(problem, found)
    there = refit(problem, replace(here, theta=with_exits(problem, here.theta, wanted)))
    rounding = 0.5 * float(np.sum((SAME * problem.weights) ** 2))
    return there if there.code == 0 and there.cost <= ALIKE * here.cost + rounding else found


def _turned_back(problem: CalibrationProblem, found: PoseFit) -> PoseFit:
    """Return the fit turned about the vertical towards the file, a path that is not straight, if yaw is open.

    Of a platform in a plane it is the turn about the normal.
    """
    exits, seen = problem.named("exit_point"), of_unknown_exits(problem.robot, problem.unknowns)
    if problem.held.any() or not exits.any() or exits.sum() < 3 * seen.sum():
        return found
    points, file = (problem.points(each)[seen] for each in (found.theta, problem.free))
    arms = points - points.mean(axis=0)
    plane = problem.robot.platform.plane
    axis = turning_axis(plane)
    angle = yaw_between(arms, file - file.mean(axis=0), axis)
    if abs(angle) < _YAW:
        return found
    names = set(open_freedoms(information(problem, found.theta, found.poses, found.weights, priors=True)))
    turns = _YAWS if plane is None else set(world_motions(problem.robot))
    if not names >= turns:
        return found
    turn, theta = matrices(angle * axis), found.theta.copy()
    theta[exits] = (arms @ turn.T + points.mean(axis=0)).ravel()
    theta += angle * axis[2] * azimuth_offsets(problem.free_unknowns)  # a turn about another axis is not open with them
    poses = yawed(problem.poses_of(found.poses), angle, points.mean(axis=0), axis)
    return replace(found, theta=theta, poses=problem.with_poses(found.poses, poses))
