"""Hysteresis of cables: springs, each with a slider beside it, in series with the line's own elasticity.

A spring beside a Coulomb slider of threshold r stretches by w p, where p follows the load T within p - r <= T <= p + r
(a play operator; taken as a force by a strain the same is Maxwell slip: Al-Bender, Lampaert and Swevers 2005, IEEE
Trans. Automatic Control 50). It follows no rate: a load that returns to where it turned closes its loop. Over a cycle
it takes r w times the way that p goes, never less than 0. Thresholds are assumed.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array

THRESHOLDS: Final = np.array([0.2, 0.4, 0.6])  # assumed: of the reference load; each makes the same part of the loop


class CableHysteresis:
    """Inelastic strain of m lines by hysteresis, relative to that at the start."""

    SAVED = ("_begin", "places", "strain")

    def __init__(self, width: float, reference: float, loads: Array, elastic: Array) -> None:
        """*width*: strain between the ways up and down of a large cycle; *reference*: N, that the thresholds are of.

        *loads* (m,), N, at the start, where the sliders have no force; *elastic* (m,), 1/N, the lines' own compliance.
        """
        self._thresholds = reference * THRESHOLDS
        self._softness = 0.5 * width / len(THRESHOLDS) / self._thresholds  # (k,) 1/N
        self._begin = loads.copy()
        self.places = np.repeat(loads[:, None], len(THRESHOLDS), axis=1)  # N, p of each
        # load and stretch follow each other: in each step as far as between fixed points
        self._follow = 1.0 / (1.0 + self._softness.sum() / elastic)
        self.strain = np.zeros(len(loads))

    def follow(self, loads: Array) -> None:
        """Follow the *loads* (m,), N, which changed monotonously since the last call."""
        held = loads[:, None]
        np.maximum(self.places, held - self._thresholds, out=self.places)
        np.minimum(self.places, held + self._thresholds, out=self.places)
        self.strain += self._follow * (self.settled - self.strain)

    @property
    def settled(self) -> Array:
        """Return the strain (m,) that lines reach if their loads stay as they are."""
        return np.asarray((self.places - self._begin[:, None]) @ self._softness)
