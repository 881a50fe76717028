"""Calibration data with camera pictures: start values of the poses, and a rigid body in place of a point platform."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from cablewright.calibration.measurements import Measured
from cablewright.calibration.sightings.placing import started
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.models.fidelity import CableLaw
from cablewright.models.statics import Model
from cablewright.robot import RigidPlatform, Robot

_UNKNOWN: Final = 1e6  # rad: sigma of a rotation that was not measured


def as_body(robot: Robot) -> Robot:
    """Return the robot with a rigid platform: pictures determine its rotation where all lines meet in a point."""
    platform = robot.platform
    if platform.own_nozzle is not None:
        return robot
    body = RigidPlatform(mass=platform.mass, force=platform.force, plane=platform.plane)
    return robot.model_copy(update={"platform": body})


def with_pictures(model: Model, measured: Measured) -> tuple[Model, Measured]:
    """Return the model and the data with start values of all poses by their pictures; unchanged without any.

    Pictures that do not agree with the others are left out. Raises `InputError` for a point platform on elastic lines,
    and for a pose without a picture where its lines do not determine it.
    """
    seen = measured.sightings
    if seen is None:
        return model, measured
    robot = as_body(model.robot)
    if robot is not model.robot and model.fidelity.cable is not CableLaw.RIGID:
        raise InputError("pictures of a point platform require rigid lines: leave --cable out")
    seen, poses, _ = started(seen, robot, measured.counted, measured.guess, measured.origin)
    lost = np.flatnonzero(seen.counts == 0)
    if len(lost) and robot.m <= robot.freedoms:
        place = f"{measured.origin}, {measured.place(int(lost[0]))}"
        raise InputError(f"{place}: no picture shows a tag at this pose; leave the row out, or take a picture again")
    guess, sigma = poses, measured.pose_sigma
    if sigma is not None and measured.guess is not None:  # positions that are measurements stay
        sigma = _widened(sigma, robot.n)
        guess = np.where(np.isfinite(sigma), _widened(measured.guess, robot.n, poses), poses)
    point = None if robot is model.robot else model.robot.platform
    data = replace(measured, guess=guess, pose_sigma=sigma, sightings=replace(seen, platform=point))
    return replace(model, robot=robot), data


def _widened(values: Array, n: int, others: Array | None = None) -> Array:
    """Return *values* (N, 3) or (N, n) with *n* columns: the further ones of *others* (N, n), or of no weight."""
    found = np.where(np.isfinite(values[:, :1]), _UNKNOWN, np.nan) * np.ones((1, n))
    found = found if others is None else others.copy()
    found[:, : values.shape[1]] = values
    return found
