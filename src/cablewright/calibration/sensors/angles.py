"""Rows of angles: swivels of sheaves, tilt and yaw of the platform."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import Sigmas
from cablewright.calibration.sensors.measurement_kinds import SensorRows, present
from cablewright.foundation.errors import InputError
from cablewright.kernels.fitting import calibration_residuals
from cablewright.robot import Robot


def angle_rows(robot: Robot, measured: Measured, sigma: Sigmas) -> Iterator[SensorRows]:
    """Yield the rows of swivels, then of tilt and yaw. Raises `InputError` for what this robot cannot have measured."""
    if measured.swivel is not None:
        _require_azimuths(robot, measured)
        yield SensorRows(calibration_residuals.SWIVEL, *present(measured.swivel, sigma.swivel), np.arange(robot.m))
    for name, columns, kind in (
        ("tilt", "tilt_x, tilt_y", calibration_residuals.TILT),
        ("yaw", "yaw", calibration_residuals.YAW),
    ):
        values = getattr(measured, name)
        if values is None:
            continue
        if robot.n == 3:
            raise InputError(f"{measured.origin}: {columns}: {robot.name!r} is a point platform, which has no {name}")
        yield SensorRows(kind, *present(values, getattr(sigma, name)), other=np.arange(values.shape[1]))


def _require_azimuths(robot: Robot, measured: Measured) -> None:
    """Raise `InputError` for a swivel whose angle is no azimuth, or not that from where its exit is without load."""
    assert measured.swivel is not None
    for index, line in enumerate(robot.lines):
        why = ""
        if np.isnan(measured.swivel[:, index]).all():
            continue
        if abs(line.swivel_axis[2]) < 1.0:
            why = "an axis that is not vertical, so the angle is no azimuth"
        elif line.mount_out_of_plane_by:
            why = f"{line.mount_out_of_plane_by}, which turns its azimuth by as much as it goes aside"
        if why:
            raise InputError(
                f"{measured.origin}: swivel_{index + 1}: line {line.name!r} has {why}; leave these cells blank"
            )
