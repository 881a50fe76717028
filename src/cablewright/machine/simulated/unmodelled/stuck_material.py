"""Material that sticks to the nozzle: the platform becomes heavier than known, and less is laid than is fed.

A share of the released material sticks, less and less as the crust nears the most that stays on: dm = s (1 - m / M) df
with f the released mass, so that m = M (1 - exp(-s f / M)), exact for any step. None of it falls off.
"""

from __future__ import annotations

import math

from cablewright.machine.simulated.unmodelled.effect_sizes import StickingMaterial


class StuckMaterial:
    """Material that sticks to a nozzle."""

    SAVED = ("mass",)

    def __init__(self, law: StickingMaterial) -> None:
        """Begin with a clean one."""
        self._law = law
        self.mass = 0.0  # kg

    def passed(self, released: float) -> float:
        """Return how much of the *released* material, kg, falls; the rest sticks."""
        share, most = self._law.share, self._law.most
        sticks = share * released
        if most is not None:
            sticks = (self.mass - most) * math.expm1(-share * released / most)
        self.mass += sticks
        return released - sticks
