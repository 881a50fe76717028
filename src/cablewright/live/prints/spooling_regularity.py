"""Regularity of the cable on the winch drums: radius at which it leaves, by length paid out.

Merlet and Papegay 2023 find the drum of the least loaded line the most irregular after two months (their Fig. 9). The
irregularity here is the standard deviation of the radius from that of a regularly wound drum, after subtracting a
fitted straight line, which absorbs a wrong nominal radius or a taper.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.machine.settings import WinchSettings
from cablewright.models.coil import wind
from cablewright.robot import Line, Robot

BIN: Final = 0.05
"""m of cable over which radii are averaged."""

_MAX_BINS: Final = 5000  # 250 m
_MIN_BINS: Final = 10  # for an irregularity


@dataclass(frozen=True, eq=False)
class SpoolRadii:
    """Radii of a winch drum by length paid out, of the b bins with data; NaN where unknown."""

    lengths: Array  # (b,) m, unstrained, winch to platform
    radii: Array  # (b,) m, estimated
    true_radii: Array  # (b,) m
    regular: Array  # (b,) m, of a regularly wound drum
    irregularity: float  # m, of the estimated radii
    true_irregularity: float  # m


class SpoolStatistics:
    """Mean drum radii of m lines by bins of length paid out."""

    def __init__(self, robot: Robot, settings: WinchSettings) -> None:
        """Start with no radii."""
        self._robot, self._settings = robot, settings
        self._sums = np.zeros((2, 3, robot.m, _MAX_BINS))  # estimated and true; count, lengths, radii

    def add(self, lengths: Array, radii: Array, *, true: bool = False) -> None:
        """Add *radii* at *lengths*, both (k, m), m; NaN, and the 0 of a line without a winch, is ignored."""
        known = np.isfinite(lengths) & (radii > 0.0)
        at = np.where(known, lengths / BIN, -1.0).astype(np.int64)
        known &= (at >= 0) & (at < _MAX_BINS)
        for i in range(lengths.shape[1]):
            chosen = known[:, i]
            place = at[chosen, i]
            for sums, weights in enumerate((np.ones(len(place)), lengths[chosen, i], radii[chosen, i])):
                self._sums[int(true), sums, i] += np.bincount(place, weights, _MAX_BINS)

    def result(self) -> tuple[SpoolRadii, ...]:
        """Return the radii at which each line leaves its winch drum."""
        return tuple(self._spool(i, line) for i, line in enumerate(self._robot.lines))

    def _spool(self, i: int, line: Line) -> SpoolRadii:
        count = self._sums[:, 0, i]
        passed = np.flatnonzero(count.any(axis=0))
        count = count[:, passed]
        divisor = np.maximum(count, 1.0)
        radii = np.where(count > 0, self._sums[:, 2, i][:, passed] / divisor, np.nan)
        lengths = self._sums[:, 1, i][:, passed].sum(axis=0) / np.maximum(count.sum(axis=0), 1.0)
        regular = _regular(line, self._settings, lengths)
        irregularities = (_irregularity(lengths, each - regular) for each in radii)
        return SpoolRadii(lengths, radii[0], radii[1], regular, *irregularities)


def _regular(line: Line, settings: WinchSettings, lengths: Array) -> Array:
    """Radii (b,), m, of a regularly wound drum with *lengths* (b,), m, paid out; NaN where the drum is unknown."""
    core, diameter = line.winch.drum_radius, line.cable.diameter
    if core is None or diameter is None or not len(lengths):
        return np.full(len(lengths), np.nan)
    try:
        coil = wind(settings.held, core, settings.width, diameter, settings.pitch)
    except InputError:  # no cable fits on such a drum
        return np.full(len(lengths), np.nan)
    return np.asarray(np.interp(settings.held - lengths, coil.wound, coil.radii))


def _irregularity(lengths: Array, differences: Array) -> float:
    """Standard deviation of *differences* (b,), m, about a straight line fitted to them."""
    known = np.isfinite(differences)
    if np.count_nonzero(known) < _MIN_BINS:
        return float("nan")
    line = np.polynomial.Polynomial.fit(lengths[known], differences[known], 1)
    return float(np.std(differences[known] - line(lengths[known])))
