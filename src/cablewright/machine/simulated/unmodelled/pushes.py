"""Simulated people who push the platform now and then: a horizontal force that lasts for some seconds."""

from __future__ import annotations

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.machine.simulated.as_built_parts import PUSHES, drawn
from cablewright.machine.simulated.random_spells import Spells

_LENGTHS = (0.5, 1.5)  # shortest and longest, of the mean


class Pushes:
    """Push forces by time; they follow from the seed, so that there is no state to keep."""

    def __init__(self, force: float, pause: float, length: float, seed: int) -> None:
        """*force*: N, in a direction that each push has for itself; *pause* and *length*: s, their means."""
        self._force, self._seed = force, seed
        self._spells = Spells(pause, (_LENGTHS[0] * length, _LENGTHS[1] * length), seed, PUSHES)

    def at(self, time: float) -> Array:
        """Return the push force (2,), N, at *time*, s."""
        spell = self._spells.at(time)
        if spell is None:
            return np.zeros(2)
        way = drawn(self._seed, PUSHES, spell.number, 1).uniform(0.0, 2.0 * np.pi)
        return self._force * np.array([np.cos(way), np.sin(way)])
