"""Errors of the nozzle from a job's path, and of the platform's rotation, under each compensation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.memory_mapped import MEMORY, Room, blocks, let_go
from cablewright.models.rotation import angle_between
from cablewright.models.statics import Model
from cablewright.printing.path import Samples
from cablewright.robot import Robot
from cablewright.studies.checks.path_statics import PathStatics


@dataclass(frozen=True, eq=False)
class SampleErrors:
    """Errors of position and rotation at k samples; NaN where the equilibrium is not known."""

    uncompensated: Array  # (k,) m, of the nozzle
    elastic_only: Array  # (k,) m
    compensated: Array  # (k,) m
    turn_uncompensated: Array  # (k,) rad, rotation of the platform from the intended one; 0 for a point
    turn_compensated: Array  # (k,) rad

    @classmethod
    def of(cls, robot: Robot, samples: Samples, poses: Array, statics: PathStatics, room: Room = MEMORY) -> Self:
        """Return the errors of solved samples against intended *poses* (k, n), m and rad.

        *room*: folder for the arrays.
        """
        model, rows = Model(robot), len(samples)
        found = cls(*(room.empty((rows,)) for _ in range(5)))
        for at in blocks(rows):
            wanted = samples.positions[at]
            found.uncompensated[at] = _distance(model, statics.uncompensated[at], wanted)
            found.elastic_only[at] = _distance(model, statics.elastic_only[at], wanted)
            found.compensated[at] = _distance(model, statics.compensated[at], wanted)
            found.turn_uncompensated[at] = _turn(statics.uncompensated[at], poses[at])
            found.turn_compensated[at] = _turn(statics.compensated[at], poses[at])
            let_go((samples, poses, statics, found))
        return found


def _distance(model: Model, poses: Array, wanted: Array) -> Array:
    """Distance (b,), m, of the nozzle at *poses* (b, n) from where it should be, (b, 3)."""
    return np.asarray(np.linalg.norm(model.nozzle(poses) - wanted, axis=1))


def _turn(poses: Array, intended: Array) -> Array:
    """Angle (b,), rad, of the rotations of *poses* (b, n) from the *intended*."""
    if poses.shape[1] == 3:
        return np.where(np.isnan(poses[:, 0]), np.nan, 0.0)
    return angle_between(poses[:, 3:], intended[:, 3:])
