"""Calibration equations of angles: swivels of sheaves, tilt and yaw of the platform."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cablewright.calibration.measurement_rows.measurement_kinds import SensorRows, present
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import Sigmas
from cablewright.foundation.errors import InputError
from cablewright.kernels.fitting import calibration_residuals
from cablewright.robot import Robot


def angle_rows(robot: Robot, measured: Measured, sigma: Sigmas) -> Iterator[SensorRows]:
    """Yield the equations of measured swivel angles, then of tilt and yaw.

    Raises `InputError` for sensors that this robot cannot have.
    """
    if measured.swivel is not None:
        _require_fixed_exits(robot, measured)
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


def _require_fixed_exits(robot: Robot, measured: Measured) -> None:
    """Raise `InputError` for a measured angle of a line whose swivel does not turn exactly with its free cable."""
    assert measured.swivel is not None
    for index, line in enumerate(robot.lines):
        if (why := line.turned_off_by) and not np.isnan(measured.swivel[:, index]).all():
            raise InputError(
                f"{measured.origin}: swivel_{index + 1}: line {line.name!r} has {why}; leave these cells blank"
            )
