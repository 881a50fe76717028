"""Stops of a print to measure the platform's position: each N layers or each time interval, at several positions."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from cablewright.control.path_follower import Target
from cablewright.printing.arc_length_path import Track


@dataclass
class PlaceVisits:
    """Schedule of stops of a print at which the platform's position is measured.

    Each visit has ``stops`` positions, which divide the length of the layer where it begins evenly. ``layers``: a visit
    begins after each so many; 0: never. ``every``: s of machine time; 0: never; the first is where the path begins. A
    print that is resumed goes on with the next visit by time, and leaves out the rest of the last; a visit by layers
    goes on.
    """

    layers: int = 0
    every: float = 0.0
    stops: int = 1
    _placed: int | None = field(default=None, repr=False)  # layer in which a visit began last, or the print
    _visited: int | None = field(default=None, repr=False)  # visits by time
    _began: bool = field(default=False, repr=False)
    _left: list[tuple[float, int]] = field(default_factory=list, repr=False)  # m along the path; mm from its layer on

    def is_due(self, track: Track, target: Target, now: float) -> bool:
        """Return whether the platform must stop at its *target* on the *track*, at *now*, s."""
        if not self.layers and not self.every:
            return False
        if not self._left:
            self._begin(track, target, now)
        return bool(self._left) and target.distance >= self._left[0][0]

    def stopped(self) -> int:
        """Return the identifier of the position where the platform stopped: its distance along the layer in mm."""
        return self._left.pop(0)[1]

    def _begin(self, track: Track, target: Target, now: float) -> None:
        """Begin a visit if it is time, or go on with one by layers in which the print was interrupted."""
        resumes, self._began = not self._began and target.distance > 0.0, True
        after_layers, after_time = self._are_layers_over(track, target, resumes), self._is_time_over(now, resumes)
        if not after_layers and not after_time:
            return
        begin, length = _layer_at(track, target.distance)
        first = 0.0 if after_layers else max(target.distance - begin, 0.0)
        along = [first + length * number / self.stops for number in range(self.stops)]
        ahead = [each for each in along if target.distance < begin + each <= track.length]
        if not resumes and along[0] not in ahead:
            ahead.insert(0, along[0])  # it was passed within the last step
        self._left = [(begin + each, round(1e3 * each)) for each in ahead]

    def _are_layers_over(self, track: Track, target: Target, resumes: bool) -> bool:
        """Whether a visit by layers is to begin, or began in the layer in which the print is resumed."""
        if not self.layers:
            return False
        layer, begun = max(target.layer, 1), int(track.layer[0])  # the way to the first layer is none
        if self._placed is None:
            self._placed = layer - (layer - begun) % self.layers
            return resumes and self._placed == layer > 1
        over = layer - self._placed >= self.layers
        self._placed = layer if over else self._placed
        return over

    def _is_time_over(self, now: float, resumes: bool) -> bool:
        """Whether a visit by time is to begin."""
        if not self.every:
            return False
        due = int(now / self.every)
        before = due if resumes else self._visited
        self._visited = due
        return before is None or due > before


def _layer_at(track: Track, distance: float) -> tuple[float, float]:
    """Return where the layer at *distance* begins along the path, and its length, m; the first is after layer 0."""
    numbers, begins = track.visits.number, np.append(track.visits.begin, track.length)
    at = int(np.searchsorted(begins[:-1], distance, side="right")) - 1
    at += int(numbers[at] == 0 and at + 1 < len(numbers))
    return float(begins[at]), float(begins[at + 1] - begins[at])
