"""Shortest duration of a job's path within its limits and those of the winches."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.memory_mapped import Room, blocks, let_go
from cablewright.printing.beads import Beads
from cablewright.printing.job import Job
from cablewright.printing.path import Samples
from cablewright.printing.toolpath import Toolpath
from cablewright.robot import Robot
from cablewright.solvers.path_speeds import winch_speeds


@dataclass(frozen=True)
class Fastest:
    """Durations of a path without the feed rates of its file."""

    duration: float  # s, of its time law
    bound: float  # s: no motion within the limits of speed is faster

    @classmethod
    def of(
        cls, robot: Robot, job: Job, toolpath: Toolpath, beads: Beads, samples: Samples, lengths: Array, room: Room
    ) -> Self | None:
        """Return the durations of a path along *samples* (k,); None where nothing limits a speed.

        *lengths* (k, m): m, of the lines at the samples, by which winches limit the speed.
        """
        limits, speed = job.speed_limits(toolpath, beads, fastest=True, room=room), room.empty((len(samples),))
        bound = float(samples.dwell.sum())
        for at in blocks(len(samples) - 1):
            ends = slice(at.start, at.stop + 1)
            allowed = winch_speeds(robot, lengths[ends], samples.distance[ends])
            speed[ends][1:] = np.minimum(limits[samples.move[ends][1:]], allowed)
            bound += float((np.diff(samples.distance[ends]) / speed[ends][1:]).sum())
            if np.isinf(speed[ends][1:]).any():
                return None
            let_go((samples, lengths, speed))
        speed[0] = speed[1]
        return cls(job.time_law(replace(samples, speed_limit=speed), room).duration, bound)
