"""The true room for simulated lidars: walls as they stand, some of glass or dark, and people in it."""

from __future__ import annotations

from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.machine.settings import RoomSettings
from cablewright.machine.simulated.as_built_parts import ROOM, drawn
from cablewright.machine.simulated.people import WIDTH, Visits
from cablewright.machine.simulated.settings import SimulationSettings

_BEHIND: Final = 3.0  # m from glass to the face seen through it
_BESIDE: Final = 10.0  # m, by which that is longer on both sides
_DETOUR: Final = 0.3  # m, mean of how much farther a ghost is
_CORNERS: Final = np.radians(np.arange(0.0, 361.0, 45.0))
_BODY: Final = 0.5 * WIDTH * np.column_stack([np.cos(_CORNERS), np.sin(_CORNERS)])


class FoundRoom:
    """Wall faces (j, 4) for the lidar kernel: x and y of both ends, m, world; from the floor to the ceiling."""

    def __init__(
        self, room: RoomSettings, simulation: SimulationSettings, low: Array, high: Array, radius: float, seed: int
    ) -> None:
        """*room* as it stands; people walk between *low* and *high* (2,), m, around a drum of *radius*, m."""
        self.ceiling, self.law, self._seed = room.ceiling, simulation.room, seed
        self._walls = np.array([(*wall.start, *wall.end) for wall in room.walls], dtype=np.float64).reshape(-1, 4)
        self._visits = Visits(simulation.people.share, low, high, radius, seed)
        names = [wall.name for wall in room.walls]
        self._glass = [names.index(name) for name in self.law.glass]
        self._dark = [names.index(name) for name in self.law.dark]
        self._behind = self._walls.copy()
        ends = self._walls.reshape(-1, 2)
        middle = 0.5 * (ends.min(axis=0) + ends.max(axis=0)) if len(ends) else np.zeros(2)
        for i in self._glass:
            start, end = self._walls[i].reshape(2, 2)
            across = np.array([end[1] - start[1], start[0] - end[0]]) / np.hypot(*(end - start))
            outward = across if across @ (start - middle) >= 0.0 else -across
            along = _BESIDE * (end - start) / np.hypot(*(end - start))
            self._behind[i] = np.concatenate([start - along, end + along]) + np.tile(_BEHIND * outward, 2)

    def faces(self, time: float, drum: Array) -> Array:
        """Return all faces at *time*, s, with the platform at (2,), m: those of the walls first, then of a person."""
        place = self._visits.place(time, drum)
        if place is None:
            return self._walls
        return np.vstack([self._walls, np.hstack([place + _BODY[:-1], place + _BODY[1:]])])

    def behind_glass(self, faces: Array) -> Array:
        """Return the *faces* with glass replaced by the faces seen through it."""
        return np.vstack([self._behind, faces[len(self._walls) :]])

    def without(self, kind: str, faces: Array) -> Array | None:
        """Return the *faces* without those of a *kind*, ``glass`` or ``dark``; None where there are none of it."""
        own = self._glass if kind == "glass" else self._dark
        return np.delete(faces, own, axis=0) if own else None

    def random(self, source: int, turn: int) -> np.random.Generator:
        """Return the random generator for the rays of one scan of one lidar."""
        return drawn(self._seed, ROOM, source, turn)


def detours(random: np.random.Generator, share: float, count: int) -> Array:
    """Return the excess of each of *count* ranges, m, by reflected rays; 0 except for a *share* of them."""
    return np.where(random.random(count) < share, random.exponential(_DETOUR, count), 0.0)
