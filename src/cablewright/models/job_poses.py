"""Poses of the platform that bring the nozzle along a job's path."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.memory_mapped import MEMORY, Room, blocks, let_go
from cablewright.models.free_coordinates import free_coordinates, with_free
from cablewright.models.statics import Model
from cablewright.models.support_table import Capability, require
from cablewright.printing.beads import Beads
from cablewright.printing.job import DEFAULT_STEP, Job
from cablewright.printing.path import Samples
from cablewright.printing.schedule import Schedule
from cablewright.printing.toolpath import Toolpath
from cablewright.robot import Robot
from cablewright.robot.plane import OFF_PLANE

INTERPOLATED: Final = 2e-5
"""Error, m, of a length that is interpolated linearly between two samples, for which the step is chosen."""

SHORTEST_STEP: Final = 5e-3  # m
_UNITS: Final = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)  # m, of whole mm and their decimals
_ON_GRID: Final = 1e-4  # of a unit


def on_plane(robot: Robot, job: Job) -> Job:
    """Return a *job* of G-code with its axes and its origin in the robot's plane, where that has a ``gcode_zero``.

    Coordinates that the job specifies stay.
    """
    plane = robot.platform.plane
    if plane is None or plane.gcode_zero is None or job.gcode is None or job.axes is not None:
        return job
    origin = {} if "origin" in job.model_fields_set else {"origin": plane.gcode_zero}
    return job.model_copy(update={"axes": plane.directions, **origin})


def sampled(
    robot: Robot, job: Job, toolpath: Toolpath, room: Room = MEMORY, beads: Beads | None = None
) -> tuple[Samples, float]:
    """Return the samples of *job*, and the maximum distance between them, m. *room* and *beads*: as `Job.samples`.

    Where the job does not give it, it follows from the shortest lines that the path allows: a length of s spans of l,
    interpolated over a step h, has an error of at most s h^2 / (8 l), here `INTERPOLATED`. Raises `InputError` for a
    path that cannot be sampled.
    """
    step = job.sampling.step or _step(robot, job, toolpath)
    return unrounded(robot, job, toolpath, job.samples(toolpath, step, room, beads)), step


def unrounded(robot: Robot, job: Job, toolpath: Toolpath, samples: Samples) -> Samples:
    """Return *samples* of a *job* moved into the platform's plane if only rounding of the file separates them from it.

    Half a unit of the last decimal that the file's coordinates have is allowed for each of them, `OFF_PLANE` at least;
    samples that are farther off stay where they are.
    """
    plane = robot.platform.plane
    if plane is None:
        return samples
    normal = np.array(plane.across)
    off = samples.positions @ normal - plane.distance - float(normal @ robot.platform.nozzle)
    allowed = max(OFF_PLANE, job.scale * rounding(toolpath.end) * float(np.abs(normal).sum()))
    if float(np.abs(off).max()) > allowed:
        return samples
    return replace(samples, positions=samples.positions - off[:, None] * normal)


def rounding(places: Array) -> float:
    """Return half a unit, m, of the last decimal of *places* (k, 3), m, written in mm; 0 where they have none, or 6."""
    for unit in _UNITS:
        if np.abs(places / unit - np.round(places / unit)).max() < _ON_GRID:
            return 0.0 if unit == _UNITS[0] else 0.5 * unit
    return 0.0


def path_box(job: Job, toolpath: Toolpath) -> tuple[Array, Array]:
    """Return the lowest and the highest corner (3,) of a job's path, m, machine coordinates."""
    low = np.minimum(toolpath.start[0], toolpath.end.min(axis=0)) * job.scale + job.origin
    return low, np.maximum(toolpath.start[0], toolpath.end.max(axis=0)) * job.scale + job.origin


def _step(robot: Robot, job: Job, toolpath: Toolpath) -> float:
    low, high = path_box(job, toolpath)
    exits = np.array([line.exit_point for line in robot.lines])
    apart = np.linalg.norm(np.maximum(np.maximum(low - exits, exits - high), 0.0), axis=1)
    reach = np.linalg.norm([line.platform_point for line in robot.lines], axis=1)
    shortest = max(float(((apart - reach) / [line.advantage for line in robot.lines]).min()), 0.0)
    return float(np.clip(np.sqrt(8.0 * shortest * INTERPOLATED), SHORTEST_STEP, DEFAULT_STEP))


def along(robot: Robot, job: Job, samples: Samples, room: Room = MEMORY) -> tuple[Array, Array | None]:
    """Return poses (k, n), m and rad, that bring the nozzle to the k samples of a job.

    Also retraction lengths (k,), m, or None. *room*: folder for the array of poses. Raises as `poses_at`.
    """
    _, drawn = poses_at(robot, job, samples.positions[:1])
    if robot.n == 3 and drawn is None and not free_coordinates(robot):
        return samples.positions, None
    poses, retraction = room.empty((len(samples), robot.n)), None if drawn is None else room.empty((len(samples),))
    for at in blocks(len(samples)):
        poses[at], drawn = poses_at(robot, job, samples.positions[at])
        if retraction is not None and drawn is not None:
            retraction[at] = drawn
        let_go((samples.positions, poses))
    return poses, retraction


def require_retractions(robot: Robot, job: Job) -> None:
    """Raise `InputError` for a retraction length of the job's schedule that is beyond the robot's range."""
    for step in job.schedule:
        if step.retraction is not None:
            try:
                robot.retraction_to(step.retraction)
            except InputError as reason:
                raise InputError(f"job {job.name}: schedule at {step.z:g} m: {reason}") from None


def poses_at(robot: Robot, job: Job, positions: Array) -> tuple[Array, Array | None]:
    """Return poses (k, n) that bring the nozzle to *positions* (k, 3), m, and retraction lengths (k,), m, or None.

    Rotations and retraction lengths are those of the job's schedule. With fewer winches than degrees of freedom, what
    equilibrium decides is NaN, and the nozzle is there unrotated. Raises `InputError` for a schedule that the robot
    cannot follow.
    """
    schedule = Schedule(job.schedule)
    require(robot, Capability.PATH)
    require_retractions(robot, job)
    heights = positions[:, 2]
    retraction = schedule.retractions(heights)
    if robot.n == 3:
        if schedule.turns:
            raise InputError(f"job {job.name}: schedule sets a rotation; the platform of {robot.name} is a point")
        return with_free(robot, positions), retraction
    rotations = np.where(np.isin([3, 4, 5], free_coordinates(robot)), 0.0, schedule.rotations(heights))
    poses = np.concatenate([positions, rotations], axis=1)
    return with_free(robot, Model(robot).at_nozzle(poses)), retraction
