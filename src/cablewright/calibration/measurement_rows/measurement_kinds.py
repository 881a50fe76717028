"""The kinds of calibration measurement at poses: their names in messages and plans, and their possible errors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cablewright.foundation.arrays import Array
from cablewright.kernels.fitting import calibration_residuals as rows


class SensorRows(NamedTuple):
    """Equations of one sensor, r at each of N poses; scalars are the same in all rows, see `MeasurementRows`."""

    kind: int
    values: Array  # (N, r)
    weights: Array | float
    line: ArrayLike = 0
    other: ArrayLike = 0
    extra: ArrayLike = 0


def present(values: Array, sigma: Array | float) -> tuple[Array, Array]:
    """Return measured *values* and their weights by *sigma*, both 0 where a value is NaN: such a row does not count."""
    return np.nan_to_num(values), np.where(np.isnan(values), 0.0, 1.0 / sigma)


@dataclass(frozen=True)
class MeasurementKind:
    """A kind of measurement.

    ``words``: its name in messages. ``sigma``: the key of the plan's sigma, where that has a default. ``reading``: the
    part of a pose's readings that may be wrong alone. ``resists``: whether the weight of rows with large residuals is
    reduced.
    """

    words: str
    sigma: str = ""
    reading: str = ""
    resists: bool = False


ON_ONE_DRUM: Final = "lines on one drum"
"""The kind of rows that tie lines on one drum, whose sigma is a share of the encoders': no reading of a sensor."""

KINDS: Final = {
    rows.ENCODER: MeasurementKind("lengths", reading="encoder"),
    rows.PAID_OUT: MeasurementKind("lengths", reading="encoder"),
    rows.TIED: MeasurementKind(ON_ONE_DRUM),
    rows.TENSION: MeasurementKind("tensions", "tension", "tension"),
    rows.BALANCE: MeasurementKind("tensions", "tension"),
    rows.COORDINATE: MeasurementKind("positions", reading="position", resists=True),
    rows.ALONG: MeasurementKind("positions", reading="position", resists=True),
    rows.SWIVEL: MeasurementKind("swivel angles", "swivel"),
    rows.TILT: MeasurementKind("tilts", "tilt"),
    rows.YAW: MeasurementKind("yaw angles", "yaw"),
    rows.PLANE: MeasurementKind("planes", reading="plane", resists=True),
    rows.REACH: MeasurementKind("ranges", reading="range", resists=True),
    rows.SIGHTING: MeasurementKind("sightings", reading="sighting"),
}
"""The kind of each row that belongs to a pose."""

SIGMA_OF: Final = {each.words: each.sigma for each in KINDS.values() if each.sigma}
"""The key of the plan's sigma of a kind, where that has a default."""
