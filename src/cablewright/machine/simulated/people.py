"""People in the room: when somebody walks there, and where."""

from __future__ import annotations

import bisect
import math
from typing import Final

import numpy as np

from cablewright.arrays import Array
from cablewright.machine.simulated.as_built_parts import VISITS, drawn

WIDTH: Final = 0.4
"""Width of a person, m."""

_CLEAR: Final = 0.6  # m that stay free between a person and the drum
_FROM_WALLS: Final = 0.3  # m
_VISIT: Final = (10.0, 40.0)  # s
_SPEED: Final = (0.5, 1.5)  # m/s
_STAND: Final = 0.5  # s, the least time of a leg
_TRIES: Final = np.radians([0.0, *(side * angle for angle in range(15, 181, 15) for side in (1, -1))])


class Visits:
    """One person after another, who walk straight legs through the room and around the drum.

    What happens follows from the seed and the time alone, so that there is no state to keep.
    """

    def __init__(self, share: float, low: Array, high: Array, radius: float, seed: int) -> None:
        """*share*: of the time in which somebody is there; *low* and *high* (2,): m, the room's corners.

        *radius*: m, of the drum.
        """
        middle = 0.5 * (low + high)
        self._low, self._high = np.minimum(low + _FROM_WALLS, middle), np.maximum(high - _FROM_WALLS, middle)
        self._share, self._seed, self._distance = share, seed, radius + _CLEAR + 0.5 * WIDTH
        self._random = drawn(seed, VISITS)  # of the times of visits
        self._begins, self._ends = list[float](), list[float]()  # s, as far as they are known
        self._walk: tuple[int, Array, Array] | None = None  # of a visit: times (k,), s, and places (k, 2), m

    def place(self, time: float, drum: Array) -> Array | None:
        """Return where the middle of a person is, (2,) m, at *time*, s, with the drum at (2,) m; None: nobody is there.

        Who would come too near the drum walks around it; in a room that is too small for that nobody is.
        """
        number = self._visit(time)
        if number is None:
            return None
        times, places = self._walk_of(number)
        here = np.array([np.interp(time, times, places[:, axis]) for axis in (0, 1)])
        away = here - drum
        if math.hypot(*away) >= self._distance:
            return here
        angles = math.atan2(away[1], away[0]) + _TRIES
        tried = drum + self._distance * np.column_stack([np.cos(angles), np.sin(angles)])
        inside = ((tried >= self._low) & (tried <= self._high)).all(axis=1)
        return tried[int(np.argmax(inside))] if inside.any() else None

    def _visit(self, time: float) -> int | None:
        """The number of the visit at *time*, s."""
        if self._share == 0.0:
            return None
        random, mean = self._random, 0.5 * sum(_VISIT)
        pause = mean * (1.0 - self._share) / self._share
        if not self._ends and random.random() < self._share:  # somebody is there already, more likely for a long visit
            length = math.sqrt(random.uniform(_VISIT[0] ** 2, _VISIT[1] ** 2))
            self._begins.append(-length * random.random())
            self._ends.append(self._begins[0] + length)
        while not self._ends or self._ends[-1] <= time:
            begin = (self._ends[-1] if self._ends else 0.0) + pause * random.exponential()
            self._begins.append(begin)
            self._ends.append(begin + random.uniform(*_VISIT))
        at = bisect.bisect_right(self._begins, time) - 1
        return at if at >= 0 and time < self._ends[at] else None

    def _walk_of(self, number: int) -> tuple[Array, Array]:
        """Times and places of the legs of a visit."""
        if self._walk is None or self._walk[0] != number:
            random, end = drawn(self._seed, VISITS, 1 + number), self._ends[number]
            times, places = [self._begins[number]], [random.uniform(self._low, self._high)]
            while times[-1] < end:
                there, speed = random.uniform(self._low, self._high), random.uniform(*_SPEED)
                times.append(times[-1] + max(_STAND, math.dist(there, places[-1]) / speed))
                places.append(there)
            self._walk = number, np.array(times), np.array(places)
        return self._walk[1:]
