"""Stages of a job: the robot with the exit points of each, and the job with its layers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.units import Vec3
from cablewright.foundation.validation import validated
from cablewright.models.job_poses import on_plane
from cablewright.printing.beads import Beads
from cablewright.printing.growing_part import Deposit, deposit
from cablewright.printing.job import Job
from cablewright.printing.modal import MAX_COORDINATE
from cablewright.printing.schedule import Stage
from cablewright.printing.toolpath import Toolpath
from cablewright.robot import Robot
from cablewright.robot.parameter_values import with_exit_point

_GRAIN: Final = 1e-6  # m, of heights


@dataclass(frozen=True)
class JobStage:
    """One stage of a job: its number from 1, the robot with its exit points, and the job with its layers."""

    number: int
    robot: Robot
    job: Job

    @property
    def begin(self) -> float:
        """Nozzle height at which the stage begins, m; -inf: with the first layer."""
        low = (self.job.heights or (-MAX_COORDINATE, 0.0))[0]
        return -np.inf if low == -MAX_COORDINATE else low

    @property
    def exit_points(self) -> Array:
        """Exit points (m, 3), m, world, of the stage."""
        return np.array([line.exit_point for line in self.robot.lines])

    @property
    def exit_height(self) -> float:
        """Height of the highest exit point, m."""
        return highest_exit(self.robot)


def highest_exit(robot: Robot) -> float:
    """Return the height of the highest exit point of a *robot*, m."""
    return max(line.exit_point[2] for line in robot.lines)


def raised(robot: Robot, height: float) -> Robot:
    """Return the *robot* with all exit points raised by *height*, m, and the top of its frame's box with them.

    A modelled winch exit stays. Raises `InputError` for a robot where that is impossible.
    """
    return with_exit_points(robot, [(x, y, z + height) for x, y, z in (line.exit_point for line in robot.lines)])


def with_exit_points(robot: Robot, points: Sequence[Vec3]) -> Robot:
    """Return the *robot* with other exit points; the top of its frame's box moves with the highest one.

    Raises `InputError` for a robot where that is impossible.
    """
    rise = max(point[2] for point in points) - highest_exit(robot)
    low, (x, y, top) = robot.scene.frame_min, robot.scene.frame_max
    if top + rise <= low[2]:
        raise InputError(
            f"exit points {-rise:g} m lower than in the robot file leave no height between scene.frame_min and "
            "frame_max of the frame's box"
        )
    scene = robot.scene.model_copy(update={"frame_max": (x, y, top + rise)})
    lines = [with_exit_point(line, point) for line, point in zip(robot.lines, points, strict=True)]
    changed = {"scene": scene.model_dump(), "lines": [line.model_dump() for line in lines]}
    return validated(Robot, robot.model_dump() | changed, f"robot {robot.name!r} with them")


def robot_at(robot: Robot, stage: Stage) -> Robot:
    """Return the *robot* with the exit points of a *stage*. Raises `InputError`, which begins with the stage's key."""
    if stage.exit_points is not None and len(stage.exit_points) != robot.m:
        raise InputError(
            f"exit_points: {len(stage.exit_points)} are given; {robot.name!r} has {robot.m} lines, one for each"
        )
    key = "raised" if stage.exit_points is None else "exit_points"
    try:
        points = stage.exit_points
        return raised(robot, stage.raised or 0.0) if points is None else with_exit_points(robot, points)
    except InputError as error:
        raise InputError(f"{key}: {error}") from None


def stages_of(robot: Robot, job: Job) -> tuple[JobStage, ...]:
    """Return the stages of a *job* on a *robot*, in the order of printing; one of a job without stages.

    The first has the exit points of the robot file, unless a stage begins at or below the first layer. Raises
    `InputError` for stages whose exit points do not fit the robot, are within the part, or that print nothing.
    """
    if not job.stages:
        return (JobStage(1, robot, job),)
    plain = on_plane(robot, job.model_copy(update={"stages": ()}))
    toolpath = plain.toolpath()
    heights = toolpath.end[toolpath.extruding, 2] * plain.scale + plain.origin[2]
    begins = [-MAX_COORDINATE, *(each.z for each in job.stages)]
    robots = [robot]
    for number, stage in enumerate(job.stages):
        where = f"job {job.name}: stages[{number}]"
        if stage.z > heights.max() + _GRAIN:
            raise InputError(f"{where}.z = {stage.z:g} m: nothing is laid there; the part ends at {heights.max():g} m")
        try:
            robots.append(robot_at(robot, stage))
        except InputError as error:
            raise InputError(f"{where}.{error}") from None
    first = int(begins[1] <= float(heights.min()) + _GRAIN)  # the robot file's exit points print nothing
    begins[first] = -MAX_COORDINATE
    ends = pairwise([*begins[first:], MAX_COORDINATE])
    jobs = [plain.model_copy(update={"heights": each}) for each in ends]
    found = tuple(JobStage(n, *each) for n, each in enumerate(zip(robots[first:], jobs, strict=True), 1))
    beads = plain.beads(toolpath)
    for each in found:
        _require_clear(each, toolpath, beads)
    return found


def _require_clear(stage: JobStage, toolpath: Toolpath, beads: Beads) -> None:
    """Raise `InputError` for an exit point that is within what is laid by the end of a *stage*."""
    high = (stage.job.heights or (0.0, MAX_COORDINATE))[1]
    last = toolpath.first_at((high - stage.job.origin[2]) / stage.job.scale)
    laid = deposit(stage.job.samples(toolpath.part(0, last)), beads, up=stage.robot.platform.lays_along)
    for line in stage.robot.lines:
        piece = _piece_at(laid, np.array(line.exit_point))
        if piece is not None:
            place = ", ".join(f"{each:.3g}" for each in line.exit_point)
            raise InputError(
                f"job {stage.job.name}: stage {stage.number}: the exit point of {line.name!r}, {place} m, is within "
                f"layer {laid.layer[piece]} of the part: move it away, or end the stage below"
            )


def _piece_at(laid: Deposit, point: Array) -> int | None:
    """Return the piece of a deposit that contains a *point* (3,), m; None: none does."""
    away = point - laid.centre
    axes = np.stack([laid.along, laid.across, np.cross(laid.along, laid.across)], axis=1)  # (B, 3, 3)
    inside = (np.abs(np.einsum("bij,bj->bi", axes, away)) <= laid.half).all(axis=1)
    return int(np.argmax(inside)) if inside.any() else None
