"""Material laid along a path onto a height field: powder at its angle of repose, or an extruded bead.

Both follow one rule: material along a straight piece fills the lowest cells first, where a cell at the distance d from
the piece counts as higher by profile(d). profile(d) = d tan(repose) gives a heap whose flanks have the angle of repose;
a profile of 0 within half a bead's width and infinity beyond gives a strand that the nozzle presses flat, and that
fills grooves between its neighbours. A surface no steeper than the repose stays so. Volume is conserved to rounding.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError, require_positive
from cablewright.kernels.plant.laid_material import lay
from cablewright.printing.heightfield import HeightField


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
    _lay(field, start, end, volumes, steep, 0.0, highest / steep)


def extrude(field: HeightField, start: Array, end: Array, volumes: Array, width: float) -> None:
    """Lay *volumes* (k,), m^3, in strands of *width* (m) along pieces from *start* to *end*, (k, 2 or more) each, m.

    Raises `InputError` where a piece leaves the field or a volume is negative; the field is then as it was.
    """
    half = 0.5 * max(width, 2.0 * field.cell)  # a strand finer than the grid is as wide as two cells
    _lay(field, start, end, np.asarray(volumes, dtype=float), 0.0, half, np.full(len(volumes), half))


def _lay(field: HeightField, start: Array, end: Array, volumes: Array, steep: float, half: float, reach: Array) -> None:
    """Lay piece after piece, with a flank of slope *steep*, or at most *half*, m, aside; see `laid_material.lay`."""
    start, end = (np.array(places, dtype=np.float64)[:, :2].copy() for places in (start, end))
    for places in (start, end):
        outside = np.flatnonzero(~field.holds(places))
        if len(outside):
            x, y = places[outside[0]]
            raise InputError(f"piece {outside[0]} of the path leaves the field at ({x:.3f}, {y:.3f}) m")
    wrong = np.flatnonzero(~((volumes >= 0.0) & np.isfinite(volumes)))
    if len(wrong):
        raise InputError(f"piece {wrong[0]} of the path has {volumes[wrong[0]]:g} m^3: must be 0 or more")
    slide = 1.0 / steep if steep else 0.0
    lay(field.heights, np.array(field.low), field.cell, start, end, volumes, float(steep), half, reach, slide)
