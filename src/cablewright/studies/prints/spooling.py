"""How regularly cable lies on the winch drums: the radius at which it leaves, against the length paid out.

Merlet and Papegay 2023 look at the drums after two months (their Fig. 9) and find the least loaded line's the most
irregular. Here irregular is what a radius is off that of a drum wound turn by turn, layer by layer, once a straight
line through the difference is taken off, which a wrong nominal radius and one side being steeper make.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.errors import InputError
from cablewright.machine.simulated.settings import WinchSettings
from cablewright.models.coil import wind
from cablewright.robot import Line, Robot

__all__ = ["BIN", "SpoolRadii", "SpoolStatistics"]

Array = NDArray[np.float64]

BIN: Final = 0.05
"""m of cable over which radii are averaged."""

_MAX_BINS: Final = 5000  # bins: 250 m
_MIN_BINS: Final = 10  # bins before an irregularity is told


@dataclass(frozen=True, eq=False)
class SpoolRadii:
    """Radii by length paid out, (b,) at the middles of bins that were passed; NaN where not known."""

    lengths: Array  # (b,) m, unstrained, winch to platform
    radii: Array  # (b,) m, as estimated
    true_radii: Array  # (b,) m
    regular: Array  # (b,) m, of a drum that is wound evenly
    irregularity: float  # m, standard deviation of the estimated
    true_irregularity: float  # m


class SpoolStatistics:
    """Means of radii, bin by bin, for m lines."""

    def __init__(self, robot: Robot, settings: WinchSettings) -> None:
        """Begin with none."""
        self._robot, self._settings = robot, settings
        self._sums = np.zeros((2, 3, robot.m, _MAX_BINS))  # estimated and true; how many, lengths, radii

    def add(self, lengths: Array, radii: Array, *, true: bool = False) -> None:
        """Count in *radii* at *lengths*, both (k, m), m; NaN tells nothing."""
        known = np.isfinite(lengths) & np.isfinite(radii)
        at = np.where(known, lengths / BIN, -1.0).astype(np.int64)
        known &= (at >= 0) & (at < _MAX_BINS)
        for i in range(lengths.shape[1]):
            chosen = known[:, i]
            place = at[chosen, i]
            for sums, weights in enumerate((np.ones(len(place)), lengths[chosen, i], radii[chosen, i])):
                self._sums[int(true), sums, i] += np.bincount(place, weights, _MAX_BINS)

    def result(self) -> tuple[SpoolRadii, ...]:
        """What is known of each line's."""
        return tuple(self._coiling(i, line) for i, line in enumerate(self._robot.lines))

    def _coiling(self, i: int, line: Line) -> SpoolRadii:
        count = self._sums[:, 0, i]
        passed = np.flatnonzero(count.any(axis=0))
        count = count[:, passed]
        some = np.maximum(count, 1.0)
        radii = np.where(count > 0, self._sums[:, 2, i][:, passed] / some, np.nan)
        lengths = self._sums[:, 1, i][:, passed].sum(axis=0) / np.maximum(count.sum(axis=0), 1.0)
        regular = _regular(line, self._settings, lengths)
        return SpoolRadii(
            lengths, radii[0], radii[1], regular, *(_irregular(lengths, each - regular) for each in radii)
        )


def _regular(line: Line, settings: WinchSettings, lengths: Array) -> Array:
    """Radii (b,), m, with *lengths* (b,), m, out of a drum that is wound evenly; NaN where the drum is not known."""
    core, diameter = line.winch.drum_radius, line.cable.diameter
    if core is None or diameter is None or not len(lengths):
        return np.full(len(lengths), np.nan)
    try:
        coil = wind(settings.held, core, settings.width, diameter, settings.pitch)
    except InputError:  # such a drum takes no cable: of that machine's winches nothing is known
        return np.full(len(lengths), np.nan)
    return np.asarray(np.interp(settings.held - lengths, coil.wound, coil.radii))


def _irregular(lengths: Array, off: Array) -> float:
    """Standard deviation of *off* (b,), m, about the straight line through it."""
    known = np.isfinite(off)
    if np.count_nonzero(known) < _MIN_BINS:
        return float("nan")
    line = np.polynomial.Polynomial.fit(lengths[known], off[known], 1)
    return float(np.std(off[known] - line(lengths[known])))
