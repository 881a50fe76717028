"""Where the platform has to be for the nozzle to be where a job wants it."""

from __future__ import annotations

import numpy as np

from cablewright.arrays import Array
from cablewright.errors import InputError
from cablewright.models.statics import Model
from cablewright.printing.job import Job
from cablewright.printing.path import Samples
from cablewright.printing.schedule import Schedule
from cablewright.robot import Robot


def along(robot: Robot, job: Job, samples: Samples) -> tuple[Array, Array | None]:
    """Poses (k, n) of the platform's origin that bring the nozzle to the samples, and retraction lengths (k,).

    As the job's schedule has it. Raises `InputError` for a robot with fewer lines than freedoms, or a schedule that it
    cannot follow.
    """
    schedule = Schedule(job.schedule)
    if robot.m < robot.n:
        raise InputError(f"robot {robot.name}: {robot.m} lines cannot hold {robot.n} freedoms along a path")
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
