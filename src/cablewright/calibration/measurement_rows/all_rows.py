"""The equations of all sensors of a calibration, in their order."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cablewright.calibration.measurement_rows.angles import angle_rows
from cablewright.calibration.measurement_rows.contacts import contact_rows
from cablewright.calibration.measurement_rows.load_cells import balance_rows, tension_rows
from cablewright.calibration.measurement_rows.measurement_kinds import SensorRows
from cablewright.calibration.measurement_rows.positions import position_rows
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan
from cablewright.foundation.errors import InputError
from cablewright.kernels.fitting import calibration_residuals
from cablewright.models.shared_winches import shares
from cablewright.robot import Robot

_FIELDS: Final[dict[str, tuple[type, tuple[int, ...]]]] = {
    **dict.fromkeys(("kind", "line", "other"), (np.int64, ())),
    **dict.fromkeys(("values", "weights"), (np.float64, ())),
    "extra": (np.float64, (6,)),
}

ENCODER_SIGMA: Final = 1e-4
"""Default standard deviation of the encoders, m, which weighs them against other sensors."""

ON_DRUM: Final = 0.1
"""Standard deviation of the difference of two lines on one drum, over that of an encoder, unless residuals deny it."""


def sensor_rows(robot: Robot, measured: Measured, plan: CalibrationPlan, elastic: bool) -> Iterator[SensorRows]:
    """Yield the equations of each sensor in the data: encoders first, then tensions if each is a row of its own.

    The encoder of a winch counts its first line. Further lines on its drum are tied to that, by rows after those of the
    encoders. A counterweight counts nothing.
    """
    encoder = calibration_residuals.PAID_OUT if elastic else calibration_residuals.ENCODER
    weight = 1.0 / (plan.sigma.encoder or ENCODER_SIGMA)
    weights = np.zeros(measured.counted.shape)
    weights[:, list(robot.hosts)] = weight
    yield SensorRows(encoder, measured.counted, weights, np.arange(robot.m))
    if robot.sharing:
        if plan.lengths == "absolute":
            raise InputError("lengths: absolute ones are for a winch on each line; count changes since a home pose")
        own, other, sense, _ = shares(robot).T
        own, other = own.astype(int), other.astype(int)
        extra = np.zeros((len(own), 6))
        extra[:, 0], extra[:, 1] = sense, float(elastic)
        apart = measured.counted[:, own] - sense * measured.counted[:, other]
        yield SensorRows(calibration_residuals.TIED, apart, weight / ON_DRUM, own, other, extra)
    if elastic:
        yield from tension_rows(robot, measured, plan.sigma)
    yield from position_rows(robot, measured)
    yield from angle_rows(robot, measured, plan.sigma)
    if not elastic:
        yield from balance_rows(robot, measured, plan.sigma)
    yield from contact_rows(robot, measured, plan)
    for index, values, weights, extras in measured.sightings.rows() if measured.sightings else ():
        yield SensorRows(calibration_residuals.SIGHTING, values, weights, 0, index + 1, extras)


def every_row(blocks: Sequence[SensorRows], others: SensorRows) -> dict[str, NDArray[Any]]:
    """Return each field of the sensors' *blocks* for all R rows: poses in their order, then *others* without a pose."""
    found = {}
    for name, (dtype, shape) in _FIELDS.items():
        full: list[NDArray[Any]] = [
            np.broadcast_to(np.asarray(getattr(block, name), dtype=dtype), (*block.values.shape, *shape))
            for block in (*blocks, others)
        ]
        both = np.concatenate(full[:-1], axis=1), full[-1]
        found[name] = np.concatenate([each.reshape(-1, *shape) for each in both])
    return found
