"""A small circle as the path of a machine that does not print, since a control loop needs a path."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.models.plane import directions, within
from cablewright.printing.job import Job, Motion
from cablewright.printing.numeric_path import Helix
from cablewright.printing.path import Samples
from cablewright.robot import Robot

RADIUS: Final = 0.01
"""Radius of the path, m."""


def still_path(robot: Robot, place: Array, motion: Motion) -> tuple[Job, Samples]:
    """Return a small circle of the nozzle about *place* (3,), m, within the frame: level, or in its plane."""
    scene, plane, nozzle = robot.scene, robot.platform.plane, np.array(robot.platform.nozzle)
    low, high = np.array(scene.frame_min) + 2.0 * RADIUS, np.array(scene.frame_max) - 2.0 * RADIUS
    across = directions(plane, 3)
    centre = within(plane, np.clip(place, low, high) - nozzle) + nozzle
    helix = Helix(radius=RADIUS, layers=1, layer_height=0.001, first_height=0.002)
    job = Job(name="by hand", helix=helix, motion=motion)
    samples = job.samples(job.toolpath())
    return job, replace(samples, positions=centre + samples.positions[:, :2] @ across[:, :2].T)
