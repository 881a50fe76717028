"""Whether data can calibrate a robot at all, said before any work and in one line."""

from __future__ import annotations

import math

import numpy as np

from cablewright.arrays import Array
from cablewright.calibration.problem import CalibrationProblem, Measured
from cablewright.errors import InputError
from cablewright.robot import Eyelet, Robot

_APART = 1e-3  # m: poses whose lengths all differ by less are one pose
_FAR = 3.0  # diagonals of the frame: no line changes by more, and no pose is further away


def check_lengths(robot: Robot, measured: Measured) -> None:
    """Raise `InputError` where lengths or poses are of a size that speaks of another unit."""
    scene = robot.scene
    diagonal = math.dist(scene.frame_min, scene.frame_max)
    _check_size(measured, measured.counted, [f"dl_{i + 1}" for i in range(robot.m)], diagonal)
    if measured.guess is not None:
        middle = 0.5 * (np.array(scene.frame_min) + np.array(scene.frame_max))
        _check_size(measured, measured.guess[:, :3] - middle, ["x", "y", "z"], diagonal, middle)


def _check_size(
    measured: Measured, values: Array, names: list[str], diagonal: float, middle: Array | None = None
) -> None:
    large = np.argwhere(np.abs(values) > _FAR * diagonal)
    if not len(large):
        return
    pose, column = (int(at) for at in large[0])
    value = float(values[pose, column] + (0.0 if middle is None else middle[column]))
    columns = sorted({int(at) for at in large[:, 1]})
    others = [names[at] for at in range(len(names)) if at not in columns]
    hint = f"are these mm? then name the column '{names[column]} (mm)'"
    if others:
        hint += f"; {', '.join(others)} look like m: are units mixed?"
    where = f"{measured.origin}, {measured.place(pose)}"
    raise InputError(f"{where}: {names[column]} = {value:g} m, but the frame's diagonal is {diagonal:.3g} m: {hint}")


def gauge_size(problem: CalibrationProblem) -> int:
    """How many freedoms the machine's own sensors leave open: those of the world's frame, and of the platform's."""
    names = {each.name for each in problem.unknowns}
    if "exit_point" not in names or problem.measured.pose_sigma is not None:
        return 0
    weighed = problem.measured.tensions is not None or problem.hangs  # gravity tells what is level
    tiltable = all(isinstance(line.sheave, Eyelet) for line in problem.robot.lines) and not weighed
    return (6 if tiltable else 4) + (6 if "platform_point" in names else 0)


def spare(problem: CalibrationProblem) -> int:
    """How many numbers every pose tells beyond those that it asks for."""
    return _told_by_each(problem) - problem.own


def min_poses(problem: CalibrationProblem) -> int:
    """How many different poses are needed, with open freedoms counted: those are not what data have to decide.

    Raises `InputError` where no number of poses is enough.
    """
    surplus = spare(problem)
    if surplus < 1:
        raise InputError(f"{problem.measured.origin}: {_nothing_over(problem)}")
    given = len(problem.rows.linear) + len(problem.values) - problem.poses * problem.per_pose
    return max(1, -(-(len(problem.unknowns) - gauge_size(problem) - given) // surplus))


def _nothing_over(problem: CalibrationProblem) -> str:
    """Why poses tell nothing of the unknowns, and what would."""
    m, n = problem.robot.m, problem.robot.n
    if not problem.hangs:
        told = f"{m} lines tell {m} lengths of a pose that has {n} freedoms"
        return f"{told}: nothing is left over to calibrate with; measure more"
    told = f"of lines that stretch {m} lengths decide pose and tensions, and encoders tell those {m} lengths"
    more = "measure tensions (f_1 .., even roughly, with their sigma.tension) or poses (x .. with sigma_x ..)"
    return f"{told}: nothing is left over to calibrate with; {more}"


def _told_by_each(problem: CalibrationProblem) -> int:
    """How many numbers every pose tells."""
    return int((problem.of_poses(problem.weights) > 0.0).sum(axis=1).min())


def check(problem: CalibrationProblem) -> None:
    """Raise `InputError` where there are too few poses, or too few that differ."""
    measured, needed, count = problem.measured, min_poses(problem), problem.poses
    why = (
        f"each pose tells {_told_by_each(problem)} numbers and asks for {problem.own}, and {len(problem.unknowns)} "
        f"unknowns less {gauge_size(problem)} that stay open in any case are to be found"
    )
    if count < needed:
        raise InputError(f"{measured.origin}: {count} poses; at least {needed} are needed: {why}")
    different = _different(problem, needed)
    if different < needed:
        told = f"only {different} of {count} poses differ by over {_APART * 1e3:g} mm in any line"
        raise InputError(f"{measured.origin}: {told}; at least {needed} different ones are needed: {why}")


def _different(problem: CalibrationProblem, enough: int) -> int:
    """How many poses differ, counted up to *enough*."""
    left = problem.measured.counted
    for count in range(enough):
        if not len(left):
            return count
        left = left[np.abs(left - left[0]).max(axis=1) > _APART]
    return enough
