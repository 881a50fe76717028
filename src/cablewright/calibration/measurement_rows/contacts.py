"""Calibration equations of nozzle contacts: planes that it touched, and distances from known points."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from cablewright.calibration.measurement_rows.measurement_kinds import SensorRows
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.kernels.fitting import calibration_residuals
from cablewright.robot import RigidPlatform, Robot


def contact_rows(robot: Robot, measured: Measured, plan: CalibrationPlan) -> Iterator[SensorRows]:
    """Yield the equations of each plane and each range of a plan, with weight 0 at the poses that it does not name."""
    nozzle = robot.platform.nozzle if isinstance(robot.platform, RigidPlatform) else robot.lines[0].platform_point
    for index, plane in enumerate(plan.planes):
        weights = _at_poses(measured, plane.poses, f"planes[{index}]") / plane.deviation
        normal = np.asarray(plane.normal) / math.hypot(*plane.normal)
        values = np.full(weights.shape, float(normal @ plane.point))
        yield SensorRows(calibration_residuals.PLANE, values, weights, extra=np.append(normal, nozzle))
    for index, reach in enumerate(plan.ranges):
        weights = _at_poses(measured, reach.poses, f"ranges[{index}]") / reach.deviation
        values = np.zeros(weights.shape)
        values[np.asarray(reach.poses) - 1, 0] = reach.values
        yield SensorRows(calibration_residuals.REACH, values, weights, extra=np.append(reach.point, nozzle))


def _at_poses(measured: Measured, poses: Sequence[int], where: str) -> Array:
    """Return 1 at each of the poses (counted from 1), 0 at the others, (N, 1)."""
    if max(poses) > len(measured.counted):
        raise InputError(f"{where}.poses: there is no pose {max(poses)}; the data have {len(measured.counted)}")
    at = np.zeros((len(measured.counted), 1))
    at[np.asarray(poses) - 1] = 1.0
    return at
