"""Largest speeds of the nozzle along a path, by its winches and by the job's own limits."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.memory_mapped import MEMORY, Room, blocks, let_go
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.job_poses import poses_at
from cablewright.models.statics import Model
from cablewright.printing.job import Job
from cablewright.printing.path import Samples
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse

WINCH_SHARE: Final = 0.95
"""Share of a winch's speed that straight lines may take: the rest is for what stretch and sag add."""

FASTEST: Final = 1e3
"""Speed, m/s, that means no limit."""


def fed(robot: Robot, job: Job, samples: Samples, room: Room = MEMORY) -> Samples:
    """Return *samples* of a *job* with the speeds that winches allow, if the job requests the fastest; else unchanged.

    Lines are straight and do not stretch. *room*: folder for the array of speeds. Raises `InputError` where nothing
    limits a speed.
    """
    if job.motion.speed == "gcode":
        return samples
    _require_limits(robot, job, samples)
    rigid, limit = Model(robot, Fidelity(CableLaw.RIGID)), room.empty((len(samples),))
    for at in blocks(len(samples) - 1):
        ends = slice(at.start, at.stop + 1)
        poses, retraction = poses_at(robot, job, samples.positions[ends])
        lengths = solve_inverse(rigid, poses, path=True, retraction=retraction).lengths
        allowed = winch_speeds(robot, lengths, samples.distance[ends])
        limit[ends][1:] = np.minimum(samples.speed_limit[ends][1:], WINCH_SHARE * allowed)
        let_go((samples, limit))
    limit[0] = limit[1]
    return replace(samples, speed_limit=limit)


def with_speeds(job: Job, samples: Samples) -> Job:
    """Return a *job* whose print and travel speeds are the largest of its *samples*, m/s, which are those of `fed`.

    Unchanged unless the job requests the fastest.
    """
    if job.motion.speed == "gcode":
        return job
    limit, laid = np.minimum(samples.speed_limit[1:], FASTEST), samples.extruding[1:]
    speeds = {"print_speed": limit[laid], "travel_speed": limit[~laid]}
    found = {key: float(each.max()) for key, each in speeds.items() if len(each)}
    return job.model_copy(update={"motion": job.motion.model_copy(update=found)})


def winch_speeds(robot: Robot, lengths: Array, distance: Array) -> Array:
    """Return the largest speed (k - 1,), m/s, between places of a path at which no winch is too fast.

    *lengths* (k, m), m, paid out; *distance* (k,), m, along the path. inf where no limit is given, or no length known.
    """
    most = np.array([line.winch.max_speed or np.inf for line in robot.lines])
    with np.errstate(divide="ignore"):
        allowed = most * np.diff(distance)[:, None] / np.abs(np.diff(lengths, axis=0))
    return np.asarray(np.fmin.reduce(allowed, axis=1, initial=np.inf))


def _require_limits(robot: Robot, job: Job, samples: Samples) -> None:
    """Raise `InputError` where nothing limits a speed."""
    free = np.isinf(samples.speed_limit)
    if not free.any() or any(line.winch.max_speed is not None for line in robot.lines):
        return
    laid = samples.extruding[int(np.argmax(free))]
    key, also = ("print_speed", ", motion.flow_limit") if laid else ("travel_speed", "")
    raise InputError(
        f"job {job.name}: motion.speed = fastest: nothing limits it: give motion.{key}{also}, or winch.max_speed in "
        f"the robot file of {robot.name}"
    )
