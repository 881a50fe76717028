"""Material laid along a path onto a height field: powder at its angle of repose, or an extruded bead.

Both follow one rule: material along a straight piece fills the lowest cells first, where a cell at the distance d from
the piece counts as higher by profile(d). profile(d) = d tan(repose) gives a heap whose flanks have the angle of repose;
a profile of 0 within half a bead's width and infinity beyond gives a strand that the nozzle presses flat, and that
fills grooves between its neighbours. A surface no steeper than the repose stays so. Volume is conserved to rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError, require_positive
from cablewright.printing.heightfield import HeightField

Profile = Callable[[Array], Array]

_WIDER: Final = 1.5  # growth factor of a window that is too small


@dataclass(frozen=True)
class Powder:
    """Poured powder: density and angle of repose, from Merlet and Papegay (2023, sections I and IV).

    They state that a heap with flanks at 22 degrees is 2.5 times as wide as high, which is true of half its width, and
    report one 9 cm high and 22 cm wide: 39 degrees. Neither is adjusted here.
    """

    density: float = 1500.0  # kg/m^3, loose
    repose: float = np.deg2rad(22.0)  # rad, between a flank and the horizontal

    def __post_init__(self) -> None:
        """Raise `InputError` for values out of range."""
        require_positive(density=self.density)
        if not 0.0 < self.repose < 0.5 * np.pi:
            raise InputError(f"repose = {self.repose:g} rad: must be between 0 and a quarter turn")


def pour(field: HeightField, start: Array, end: Array, masses: Array, powder: Powder) -> None:
    """Pour *masses* (k,), kg, evenly along the pieces from *start* to *end*, (k, 2 or more) each, m, in their order.

    Raises `InputError` where a piece leaves the field or a mass is negative; the field is then as it was.
    """
    volumes = np.asarray(masses, dtype=float) / powder.density
    steep = np.tan(powder.repose)
    highest = np.cbrt(3.0 * volumes * steep**2 / np.pi)  # of a cone, on flat ground
    _lay(field, start, end, volumes, lambda away: steep * away, highest / steep, 1.0 / steep)


def extrude(field: HeightField, start: Array, end: Array, volumes: Array, width: float) -> None:
    """Lay *volumes* (k,), m^3, in strands of *width* (m) along pieces from *start* to *end*, (k, 2 or more) each, m.

    Raises `InputError` where a piece leaves the field or a volume is negative; the field is then as it was.
    """
    half = 0.5 * max(width, 2.0 * field.cell)  # a strand finer than the grid is as wide as two cells
    reach = np.full(len(volumes), half)
    _lay(field, start, end, volumes, lambda away: np.where(away <= half, 0.0, np.inf), reach, 0.0)


def _lay(
    field: HeightField, start: Array, end: Array, volumes: Array, profile: Profile, reach: Array, slide: float
) -> None:
    """Lay piece after piece. Each spreads over *reach* (k,), m, and farther by *slide* times the height below it."""
    start, end = np.asarray(start, dtype=float)[:, :2], np.asarray(end, dtype=float)[:, :2]
    for places in (start, end):
        outside = np.flatnonzero(~field.holds(places))
        if len(outside):
            x, y = places[outside[0]]
            raise InputError(f"piece {outside[0]} of the path leaves the field at ({x:.3f}, {y:.3f}) m")
    wrong = np.flatnonzero(~((volumes >= 0.0) & np.isfinite(volumes)))
    if len(wrong):
        raise InputError(f"piece {wrong[0]} of the path has {volumes[wrong[0]]:g} m^3: must be 0 or more")
    for k in np.flatnonzero(volumes):
        under = field.heights[tuple(field.cells_of(np.stack([start[k], end[k]])).T)].max()
        _lay_piece(field, start[k], end[k], volumes[k], profile, reach[k] + slide * max(0.0, under))


def _lay_piece(field: HeightField, start: Array, end: Array, volume: float, profile: Profile, reach: float) -> None:
    """Fill a window about the piece, and widen it until the material stays off its rim or the field ends."""
    while True:
        first = np.maximum(field.cells_of((np.minimum(start, end) - reach)[None])[0] - 1, 0)
        last = np.minimum(field.cells_of((np.maximum(start, end) + reach)[None])[0] + 2, field.shape)
        window = field.heights[first[0] : last[0], first[1] : last[1]]
        x = field.low[0] + field.cell * (np.arange(first[0], last[0]) + 0.5)
        y = field.low[1] + field.cell * (np.arange(first[1], last[1]) + 0.5)
        counts = window + profile(_distance(x[:, None], y, start, end))
        raised = np.maximum(0.0, _level(counts.ravel(), volume / field.cell**2) - counts)
        if not _touches_rim(raised, first, last, field.shape):
            window += raised
            return
        reach *= _WIDER


def _touches_rim(raised: Array, first: Array, last: Array, shape: tuple[int, int]) -> bool:
    """Whether there is material along a side of the window that is not an edge of the field."""
    return bool(
        (first[0] > 0 and raised[0].any())
        or (first[1] > 0 and raised[:, 0].any())
        or (last[0] < shape[0] and raised[-1].any())
        or (last[1] < shape[1] and raised[:, -1].any())
    )


def _distance(x: Array, y: Array, start: Array, end: Array) -> Array:
    """Return the distance (nx, ny), m, of the points at *x* (nx, 1) and *y* (ny,) from a straight piece."""
    way = end - start
    square = float(way @ way)
    share = ((x - start[0]) * way[0] + (y - start[1]) * way[1]) / square if square > 0.0 else np.zeros((len(x), len(y)))
    share = np.clip(share, 0.0, 1.0)
    return np.asarray(np.hypot(x - start[0] - share * way[0], y - start[1] - share * way[1]))


def _level(counts: Array, amount: float) -> float:
    """Return the level to which *amount* fills cells of heights *counts* (n,)."""
    rising = np.sort(counts)
    rising = rising[np.isfinite(rising)]
    filled = np.arange(1, len(rising) + 1) * rising - np.cumsum(rising)  # amount that raises all lower cells to each
    covered = int(np.searchsorted(filled, amount, side="right"))
    return float((amount + rising[:covered].sum()) / covered)
