"""Reading of a planar lidar: one scan."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.signals.reading import Reading, Source


@dataclass(frozen=True, eq=False)
class Scan(
    Reading,
    sources=[
        Source("north", stream=0, topic="/scan/north", clock="drum"),
        Source("south", stream=1, topic="/scan/south", clock="drum"),
        Source("vertical", stream=2, topic="/scan/vertical", clock="drum"),
    ],
):
    """One revolution of a planar lidar. Ray k was measured at `times[k]`, at angle `angles[k]`."""

    source: str  # name of the lidar
    begin: float  # s, time of the first ray
    period: float  # s between rays
    first_angle: float  # rad, lidar: of the first ray, from x towards y
    angle_step: float  # rad between rays
    ranges: Array  # (k,) m; NaN: no echo in range, or masked by the drum

    @property
    def stamp(self) -> float:
        """Time of the first ray of the scan, s."""
        return self.begin

    def stamped(self, time: float, rate: float = 1.0) -> Self:
        """Return the reading with another time stamp, s; see `Reading.stamped`."""
        return replace(self, begin=time, period=rate * self.period)

    @property
    def time(self) -> float:
        """Time of the last ray of the scan, s."""
        return self.begin + self.period * (len(self.ranges) - 1)

    @property
    def times(self) -> Array:
        """Time of each ray of the scan, (k,) s."""
        return np.asarray(self.begin + self.period * np.arange(len(self.ranges), dtype=np.float64))

    @property
    def angles(self) -> Array:
        """Direction of each ray of the scan, (k,) rad, in the lidar's frame."""
        return np.asarray(self.first_angle + self.angle_step * np.arange(len(self.ranges), dtype=np.float64))

    @property
    def points(self) -> Array:
        """Points (k, 2), m, that the rays hit, in the frame of the lidar; NaN for a ray without an echo."""
        angles = self.angles
        return np.asarray(self.ranges[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1))
