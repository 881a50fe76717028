"""Poses of the platform that bring the nozzle along a job's path."""

from __future__ import annotations

import numpy as np

from cablewright.arrays import Array
from cablewright.errors import InputError
from cablewright.models.statics import Model
from cablewright.printing.job import Job
from cablewright.printing.path import Samples
from cablewright.printing.schedule import Schedule
from cablewright.robot import Robot


def require_lines(robot: Robot, where: str) -> None:
    """Raise `InputError` for a robot with fewer lines than freedoms, which cannot be held *where* (for the message)."""
    if robot.m < robot.n:
        raise InputError(f"robot {robot.name}: {robot.m} lines cannot hold {robot.n} freedoms {where}")


def along(robot: Robot, job: Job, samples: Samples) -> tuple[Array, Array | None]:
    """Return poses (k, n), m and rad, that bring the nozzle to the k samples, and retraction lengths (k,), m, or None.

    Rotations and retraction lengths are those of the job's schedule. Raises `InputError` for a robot with fewer lines
    than freedoms, or a schedule that it cannot follow.
    """
    schedule = Schedule(job.schedule)
    require_lines(robot, "along a path")
    for height in job.schedule:
        if height.retraction is not None:
            try:
                robot.retraction_to(height.retraction)
            except InputError as reason:
                raise InputError(f"job {job.name}: schedule at {height.z:g} m: {reason}") from None
    heights = samples.positions[:, 2]
    retraction = schedule.retractions(heights)
    if robot.n == 3:
        if schedule.turns:
            raise InputError(f"job {job.name}: schedule sets a rotation; the platform of {robot.name} is a point")
        return samples.positions, retraction
    poses = np.concatenate([samples.positions, schedule.rotations(heights)], axis=1)
    return Model(robot).at_nozzle(poses), retraction
