"""The equations of all sensors of a calibration, in their order."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from cablewright.calibration.measurement_rows.angles import angle_rows
from cablewright.calibration.measurement_rows.contacts import contact_rows
from cablewright.calibration.measurement_rows.load_cells import balance_rows, tension_rows
from cablewright.calibration.measurement_rows.measurement_kinds import SensorRows
from cablewright.calibration.measurement_rows.positions import position_rows
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan
from cablewright.kernels.fitting import calibration_residuals
from cablewright.robot import Robot

ENCODER_SIGMA: Final = 1e-4
"""Default standard deviation of the encoders, m, which weighs them against other sensors."""


def sensor_rows(robot: Robot, measured: Measured, plan: CalibrationPlan, elastic: bool) -> Iterator[SensorRows]:
    """Yield the equations of each sensor in the data: encoders first, then tensions if each is a row of its own."""
    encoder = calibration_residuals.PAID_OUT if elastic else calibration_residuals.ENCODER
    yield SensorRows(encoder, measured.counted, 1.0 / (plan.sigma.encoder or ENCODER_SIGMA), np.arange(robot.m))
    if elastic:
        yield from tension_rows(robot, measured, plan.sigma)
    yield from position_rows(robot, measured)
    yield from angle_rows(robot, measured, plan.sigma)
    if not elastic:
        yield from balance_rows(robot, measured, plan.sigma)
    yield from contact_rows(robot, measured, plan)
    for index, values, weights, extras in measured.sightings.rows() if measured.sightings else ():
        yield SensorRows(calibration_residuals.SIGHTING, values, weights, 0, index + 1, extras)
