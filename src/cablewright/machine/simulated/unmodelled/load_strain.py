"""Immediate effects of load on a cable: strands that settle for good, and a stiffness that rises with the load.

Settling follows the largest load so far, in proportion to it. With the stiffness EA (1 + s (T / R - 1)), which is that
of the robot file at the reference load R, a line stretches less above R and more below it. Neither depends on time.
"""

from __future__ import annotations

import numpy as np

from cablewright.foundation.arrays import Array


class LoadStrain:
    """Immediate inelastic strain of m lines by load, relative to that at the start."""

    SAVED = ("_begin", "most", "_curved")

    def __init__(self, settling: float, stiffening: float, reference: float, loads: Array, elastic: Array) -> None:
        """*settling*: strain when first under the *reference*, N; *stiffening*: s. *loads* (m,), N, at the start.

        *elastic* (m,), 1/N, the lines' own compliance. What the loads at the start settle has settled.
        """
        self._settling, self._stiffening, self._reference = settling, stiffening, reference
        self._elastic, self._begin = elastic, loads.copy()
        self.most = loads.copy()  # N
        self._curved = np.zeros(len(loads))  # strain (m,) by the stiffening

    @property
    def strain(self) -> Array:
        """Strain (m,) of the lines by the history of their loads."""
        return np.asarray(self._settling * (self.most - self._begin) / self._reference + self._curved)

    def follow(self, loads: Array) -> None:
        """Follow the *loads* (m,), N: in each step less far than between fixed points.

        What settles is for good, so that it must not go too far.
        """
        share = self._stiffness(loads)
        settles = share * self._settling / self._reference / self._elastic
        self.most += 0.5 * np.maximum(loads - self.most, 0.0) / (1.0 + settles)
        self._curved += share * (self.curve(loads) - self._curved)

    def curve(self, loads: Array) -> Array:
        """Return the strain (m,) due to stiffening that lines reach if *loads* (m,), N, stay as they are.

        It is that from the loads at the start to these, less the elastic one.
        """
        if self._stiffening == 0.0:
            return np.zeros(len(loads))
        ratio = self._stiffness(loads) / self._stiffness(self._begin)
        curved = self._reference / self._stiffening * np.log(ratio)
        return np.asarray(self._elastic * (curved - (loads - self._begin)))

    def _stiffness(self, loads: Array) -> Array:
        """Stiffness (m,) under *loads* (m,), N, over that of the robot file."""
        return np.asarray(1.0 + self._stiffening * (loads / self._reference - 1.0))
