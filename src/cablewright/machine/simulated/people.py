"""Simulated people in the room: times and paths of their visits."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.machine.simulated.as_built_parts import VISITS, WALKS, drawn
from cablewright.machine.simulated.random_spells import Spell, Spells

WIDTH: Final = 0.4
"""Width of a person, m."""

_CLEAR: Final = 0.6  # m that stay free between a person and the drum
_FROM_WALLS: Final = 0.3  # m
_VISIT: Final = (10.0, 40.0)  # s
_SPEED: Final = (0.5, 1.5)  # m/s
_STAND: Final = 0.5  # s, the least time of a leg
_TRIES: Final = np.radians([0.0, *(side * angle for angle in range(15, 181, 15) for side in (1, -1))])


class Visits:
    """Visits of people, one after another, who walk straight legs through the room and around the platform.

    They follow from the seed and the time alone, so that there is no state to keep.
    """

    def __init__(self, share: float, low: Array, high: Array, radius: float, seed: int) -> None:
        """*share*: fraction of the time in which a person is in the room.

        *low* and *high* (2,): corners of the room, m. *radius*: m, of the drum.
        """
        middle = 0.5 * (low + high)
        self._low, self._high = np.minimum(low + _FROM_WALLS, middle), np.maximum(high - _FROM_WALLS, middle)
        self._seed, self._distance = seed, radius + _CLEAR + 0.5 * WIDTH
        pause = 0.5 * sum(_VISIT) * (1.0 / share - 1.0) if share else 0.0
        self.visits = Spells(pause, _VISIT, seed, VISITS, begun=True) if share else None
        self._walk: tuple[int, Array, Array] | None = None  # of a visit: times (k,), s, and places (k, 2), m

    def place(self, time: float, drum: Array) -> Array | None:
        """Return the position (2,), m, of a person at *time*, s, with the platform at (2,) m; None: the room is empty.

        A person who would come too near walks around the platform; a room that is too small for that is empty.
        """
        visit = None if self.visits is None else self.visits.at(time)
        if visit is None:
            return None
        times, places = self._walk_of(visit)
        here = np.array([np.interp(time, times, places[:, axis]) for axis in (0, 1)])
        away = here - drum
        if math.hypot(*away) >= self._distance:
            return here
        angles = math.atan2(away[1], away[0]) + _TRIES
        tried = drum + self._distance * np.column_stack([np.cos(angles), np.sin(angles)])
        inside = ((tried >= self._low) & (tried <= self._high)).all(axis=1)
        return tried[int(np.argmax(inside))] if inside.any() else None

    def _walk_of(self, visit: Spell) -> tuple[Array, Array]:
        """Times and places of the legs of a visit."""
        if self._walk is None or self._walk[0] != visit.number:
            random = drawn(self._seed, WALKS, visit.number)
            times, places = [visit.begin], [random.uniform(self._low, self._high)]
            while times[-1] < visit.end:
                there, speed = random.uniform(self._low, self._high), random.uniform(*_SPEED)
                times.append(times[-1] + max(_STAND, math.dist(there, places[-1]) / speed))
                places.append(there)
            self._walk = visit.number, np.array(times), np.array(places)
        return self._walk[1:]
