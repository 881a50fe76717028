"""Data of the machine as built that its simulated sensors need."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import SOURCES
from cablewright.machine.settings import WinchSettings
from cablewright.machine.simulated.as_built_parts import OCCLUSIONS, angle_zeros, mounting, tension_gains
from cablewright.machine.simulated.random_spells import Spells
from cablewright.machine.simulated.settings import Tolerances
from cablewright.robot import Robot


@dataclass(frozen=True, eq=False)
class Mounted:
    """Data of the machine for its simulated sensors. A step takes *period*, s."""

    robot: Robot  # as built
    nozzle: Array  # (3,) m, drum
    winch: WinchSettings
    tolerances: Tolerances
    period: float
    seed: int

    def random(self, source: str) -> np.random.Generator:
        """Return a sensor's own random generator: leaving out one sensor changes no other."""
        return np.random.default_rng([self.seed, 5, SOURCES[source].stream])

    def mounting(self, source: str) -> Array:
        """Return the true rotation (3, 3) of a sensor on the platform from its nominal one."""
        return mounting(source, self.tolerances, self.seed)

    def angle_zeros(self) -> Array:
        """Return the zero errors of the lines' accelerometers, (m,) rad."""
        return angle_zeros(self.tolerances, self.seed, self.robot.m)

    def tension_gains(self, source: str) -> Array:
        """Return the relative error of the scale of each load cell or torque of a source, (m,)."""
        return tension_gains(source, self.tolerances, self.seed, self.robot.m)

    def occlusions(self, pause: float, lengths: tuple[float, float]) -> Spells:
        """Return when something hides the platform from a camera, after *pause*, s, on average, for *lengths*, s."""
        return Spells(pause, lengths, self.seed, OCCLUSIONS, begun=True)
