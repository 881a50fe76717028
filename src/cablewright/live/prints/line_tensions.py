"""Tensions of the taut lines at the estimated position, and their first natural frequencies."""

from __future__ import annotations

from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Estimate
from cablewright.live.estimator_settings import with_drum_mass
from cablewright.live.prints.steps_table import Rows
from cablewright.machine.settings import MachineSettings
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.solvers.taut import Taut, taut_at

_ROUNDING: Final = 1e-6  # a tension above minus this share of the drum's weight counts as zero


class LineTensions:
    """Angles, tensions and frequencies of the lines of a point platform, modelled as straight."""

    def __init__(self, robot: Robot, settings: MachineSettings) -> None:
        """Use the described robot and machine. For a rigid platform every result is NaN."""
        self.robot, self._settings = robot, settings
        self._model = Model(with_drum_mass(robot, settings)) if robot.platform.kind == "point" else None
        weight = None if self._model is None else self._model.lines.weight.copy()
        self._weight = weight if weight is not None and (weight > 0.0).all() else None

    def at(self, position: Array) -> Taut | None:
        """Return the taut lines at *position* (3,), m; None for a rigid platform or an unknown position."""
        return taut_at(self._model, position) if self._model is not None and np.isfinite(position).all() else None

    def tensions(self, taut: Taut | None, slack: Array, mass: float) -> Array:
        """Tensions (m,), N, at the platform, if exactly three lines are not *slack* (m,); 0 for slack lines.

        NaN where these cannot hold a drum of that *mass* (kg), or where more lines share its weight.
        """
        unknown = np.full(self.robot.m, np.nan)
        tight = np.flatnonzero(slack == 0.0)
        if taut is None or len(tight) != self.robot.n:
            return unknown
        weight = mass * self.robot.scene.gravity
        try:
            cables = np.array([float(line.cables) for line in self.robot.lines])
            found = np.linalg.solve(-(cables[:, None] * taut.toward)[tight].T, [0.0, 0.0, weight])
        except np.linalg.LinAlgError:
            return unknown
        if not (found >= -_ROUNDING * weight).all():
            return unknown
        tensions = np.zeros(self.robot.m)
        tensions[tight] = np.maximum(found, 0.0)
        return tensions

    def frequencies(self, estimate: Estimate, mass: float) -> Array:
        """First natural frequencies (m,), Hz, of the lines whose tension is known and not 0; NaN for the others."""
        taut = self.at(estimate.position)
        if taut is None or self._weight is None:
            return np.full(self.robot.m, np.nan)
        tensions = self.tensions(taut, estimate.slack.astype(np.float64), mass)
        speed = np.sqrt(np.maximum(tensions, 0.0) * self.robot.scene.gravity / self._weight)
        return np.where(tensions > 0.0, speed / (2.0 * taut.free), np.nan)

    def series(self, rows: Rows, masses: Array) -> tuple[Array, Array]:
        """Angles of the lines if taut, rad, and tensions, N, both (k, m), of *rows* with drum *masses* (k,), kg."""
        angles, pulls = np.full((2, len(rows), self.robot.m), np.nan)
        for k, (place, slack, mass) in enumerate(zip(rows["position"], rows["slack"], masses.tolist(), strict=True)):
            taut = self.at(place)
            if taut is not None:
                angles[k], pulls[k] = taut.angles, self.tensions(taut, slack, mass)
        return angles, pulls
