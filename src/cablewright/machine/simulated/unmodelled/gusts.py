"""Wind gusts: a random horizontal force on the platform, a first-order Gauss-Markov process, exact for any step."""

from __future__ import annotations

import math

import numpy as np

from cablewright.foundation.arrays import Array


class Gusts:
    """Wind gusts: the present random force on the platform."""

    SAVED = ("force", "_random")

    def __init__(self, force: float, correlation: float, random: np.random.Generator) -> None:
        """*force*: root mean square, N; *correlation*: s; what blows at first is drawn from all that may."""
        self._axis, self._correlation, self._random = force / math.sqrt(2.0), correlation, random
        self.force = self._axis * random.standard_normal(2)  # N, along x and y

    def blow(self, period: float) -> Array:
        """Return the force (2,), N, after a *period*, s."""
        keep = math.exp(-period / self._correlation)
        self.force = keep * self.force + self._axis * math.sqrt(1.0 - keep * keep) * self._random.standard_normal(2)
        return self.force
