"""Cross-track errors of a print and its speed along the path, step by step."""

from __future__ import annotations

from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.live.prints.result import ErrorLocation, LayerErrors, PathFollowing
from cablewright.live.prints.steps_table import Rows
from cablewright.models.path_offset import nearest_of_each
from cablewright.printing.arc_length_path import Track
from cablewright.running.running_statistics import Histogram, Moments

_SEARCH: Final = 0.3  # m along the path, before and after the current distance
_MAX_ERROR: Final = 0.1  # m, range of the histogram


class PathErrors:
    """Sums of the errors of true or estimated positions from the path near the current distance."""

    def __init__(self, track: Track, print_speed: float, prefix: str) -> None:
        """*prefix* of the columns of positions and velocities: ``true_``, or empty for estimates."""
        self._track, self._prefix = track, prefix
        self._error, self._height, self._space, self._speed = Moments(), Moments(), Moments(), Moments()
        self._layers = [Moments() for _ in track.visits.begin]
        self._worst: ErrorLocation | None = None
        self._errors = Histogram(-_MAX_ERROR, _MAX_ERROR, 400)
        self._speeds = Histogram(0.0, 2.0 * print_speed, 240)

    def add(self, rows: Rows) -> tuple[Array, Array]:
        """Add *rows* of steps that print; return distances beside the path (k,), m, and speeds along it (k,), m/s."""
        places, distance = rows[f"{self._prefix}position"], rows["distance"]
        reached, error = nearest_of_each(self._track, places, distance, _SEARCH)
        known = np.isfinite(reached)
        piece = self._track.pieces(np.where(known, reached, 0.0))
        way = self._track.positions[piece + 1] - self._track.positions[piece]
        length = self._track.distance[piece + 1] - self._track.distance[piece]
        speed = (rows[f"{self._prefix}velocity"] * way).sum(axis=1) / length
        self._error.add(error)
        self._speed.add(speed)
        height = places[:, 2] - rows["target"][:, 2]
        self._height.add(height)
        self._space.add(np.hypot(error, height))
        self._errors.add(error)
        self._speeds.add(speed)
        self._update_worst(rows, reached, error)
        visit = np.clip(np.searchsorted(self._track.visits.begin, distance, side="right") - 1, 0, None)
        for each in np.unique(visit[known]):
            self._layers[each].add(error[visit == each])
        return error, speed

    def _update_worst(self, rows: Rows, reached: Array, error: Array) -> None:
        """Update the place of the largest error."""
        if not np.isfinite(error).any():
            return
        k = int(np.nanargmax(np.abs(error)))
        if self._worst is None or abs(error[k]) > abs(self._worst.value):
            x, y, _ = self._track.at(float(reached[k])).position.tolist()
            layer, time = int(rows["layer"][k]), float(rows["time"][k])
            self._worst = ErrorLocation(float(error[k]), time, layer, float(reached[k]), (x, y))

    def result(self) -> PathFollowing:
        """Return the errors beside the path over all steps of the print."""
        layers = [each.summary() for each in self._layers]
        columns = (np.array([getattr(each, name) for each in layers]) for name in ("mean", "variance", "min", "max"))
        mean, variance, lowest, highest = columns
        visits = self._track.visits
        by_layer = LayerErrors(visits.number, visits.begin, mean, np.sqrt(variance), lowest, highest)
        return PathFollowing(
            self._error.summary(),
            self._height.summary(),
            self._space.summary(),
            self._speed.summary(),
            self._worst,
            by_layer,
            self._errors,
            self._speeds,
        )
