"""What was measured at the poses of a calibration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from cablewright.arrays import Array

SENSORS: Final = {"tension": ("tensions", "f_1"), "swivel": ("swivel", "swivel_1"), "tilt": ("tilt", "tilt_x"),
                  "yaw": ("yaw", "yaw")}  # fmt: skip
"""Sensors that have a zero: the field of what they measured, and the first of the columns."""


@dataclass(frozen=True, eq=False)
class Measured:
    """The measurements at N poses. `guess`: start values of the poses; with `pose_sigma`, measurements of them.

    A row of `guess` is NaN where nothing is known of the pose, one of `pose_sigma` where it was not measured.
    """

    counted: Array  # (N, m) m: length changes since home, by encoders
    guess: Array | None = None  # (N, n) m and rad
    pose_sigma: Array | None = None  # (N, n) m and rad
    tensions: Array | None = None  # (N, m) N
    swivel: Array | None = None  # (N, m) rad: azimuth of each free cable, 0 is world +x
    tilt: Array | None = None  # (N, 2) rad: of the platform against the plumb line, about x and y
    yaw: Array | None = None  # (N, 1) rad: azimuth of the platform's x axis, 0 is world +x
    places: Sequence[int] = field(default=())  # (N,) line number of each pose in the file
    origin: str = "the data"  # the name in messages

    def has(self, sensor: str) -> bool:
        """Whether there are measurements by one of `SENSORS`."""
        return getattr(self, SENSORS[sensor][0]) is not None

    def without_open_zeros(self, unknowns: Sequence[str]) -> Measured:
        """Return the same without sensors whose zero is among the *unknowns*: they tell nothing until it is found."""
        silent: dict[str, Any] = {name: None for sensor, (name, _) in SENSORS.items() if f"{sensor}_offset" in unknowns}
        return replace(self, **silent)

    def lengths_alone(self) -> Measured:
        """Return the lengths, and the start values of the poses, without what other sensors measured."""
        return Measured(self.counted, self.guess, places=self.places, origin=self.origin)

    @property
    def positioned(self) -> int:
        """The number of poses whose position is measured."""
        return 0 if self.pose_sigma is None else int(np.isfinite(self.pose_sigma).all(axis=1).sum())

    def place(self, pose: int) -> str:
        """Return where a pose (counted from 0) is: ``line 7`` of the file, or ``pose 7``."""
        return f"line {self.places[pose]}" if len(self.places) else f"pose {pose + 1}"
