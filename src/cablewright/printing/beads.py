"""Beads (strand width and height) of a part, move by move: given, from the slicer's comments, from E, or assumed."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Annotated, Final

import numpy as np
from annotated_types import Ge, Le
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array
from cablewright.foundation.units import Length, spell_length
from cablewright.foundation.validation import Description
from cablewright.printing.line_types import LineType
from cablewright.printing.path import Samples
from cablewright.printing.toolpath import BY_HEIGHT, Toolpath

MAX_SIZE: Final = 1e3  # m
MIN_SIZE: Final = 1e-6  # m
FLATNESS: Final = 3.0
"""Width of a strand over its height, where nothing else gives the width."""

_CORNERS: Final = 1.0 - 0.25 * math.pi  # what round sides lack of a square
_OUTLIER: Final = 4.0  # E of a move that lays so many times more or less than the middle one is no section
_APART: Final = 1.5  # ratio of the values of two sources, above which they contradict each other
_INCH: Final = 25.4  # mm
_SHARE: Final = 0.01  # of the length that may lack a comment without a note
_FLAT: Final = 3e-5  # m: no strand is lower
_GRAIN: Final = 1e-6  # m, of heights


class Bead(Description):
    """Cross-section of a laid strand of material, m."""

    width: Annotated[Length, Ge(MIN_SIZE), Le(MAX_SIZE)] = 0.06
    height: Annotated[Length, Ge(MIN_SIZE), Le(MAX_SIZE)] = 0.02

    @property
    def section(self) -> float:
        """Area of the cross-section, m^2: a rectangle with round sides."""
        return float(section(np.array(self.width), np.array(self.height)))

    def sizes(self, move: NDArray[np.int64]) -> tuple[Array, Array]:
        """Return width and height (b,), m, of some moves."""
        return np.full(len(move), self.width), np.full(len(move), self.height)


@dataclass(frozen=True, eq=False)
class Beads:
    """Beads of the k moves of a toolpath, m, machine; those of moves that lay nothing have no meaning."""

    width: Array  # (k,)
    height: Array  # (k,)
    width_by: str  # where the widths are from
    height_by: str
    typical: Bead  # of the middle of the length that is laid
    notes: tuple[str, ...] = ()
    below: tuple[Samples, Beads] | None = None  # what was laid before the first of these moves

    def part(self, first: int, last: int, below: Samples | None) -> Beads:
        """Return the beads of moves *first* to before *last*, laid on the samples of those *below*."""
        laid = None if below is None else (below, self)
        return replace(self, width=self.width[first:last], height=self.height[first:last], below=laid)

    def sizes(self, move: NDArray[np.int64]) -> tuple[Array, Array]:
        """Return width and height (b,), m, of some moves."""
        return self.width[move], self.height[move]

    @property
    def differing(self) -> tuple[str, ...]:
        """Note for programs that lay all beads with the typical width and height; empty if all have these."""
        ends = [(np.nanmin(each), np.nanmax(each)) for each in (self.width, self.height)]
        if all(low == high for low, high in ends):
            return ()
        wide, high = (" to ".join(map(spell_length, pair)) for pair in ends)
        typical = f"{spell_length(self.typical.width)} and {spell_length(self.typical.height)}"
        return (
            f"beads are {wide} wide and {high} high in the file; the machine lays all with the middle ones, {typical}",
        )

    @property
    def source(self) -> str:
        """Source of the strands' widths and heights, in words."""
        return self.width_by if self.width_by == self.height_by else f"width {self.width_by}, height {self.height_by}"


def section(width: Array, height: Array) -> Array:
    """Return areas of rectangles with round sides, m^2, by their width and height, m."""
    return width * height - _CORNERS * np.minimum(width, height) ** 2


def width_of(area: Array, height: Array) -> Array:
    """Return the widths of rectangles with round sides, m, by their areas, m^2, and heights, m: of `section`."""
    wide = area / height + _CORNERS * height
    root = np.sqrt(np.maximum(height**2 - 4.0 * _CORNERS * area, 0.0))
    return np.where(wide >= height, wide, 2.0 * area / (height + root))  # w (h - c w) = A, without cancellation


def beads_of(toolpath: Toolpath, scale: float, given: Bead | None, by: str) -> Beads:
    """Return the beads of a *toolpath* of a file, on the machine.

    *given*: values that the job or an option sets; *by*: which of them. Open values come, in this order: from the
    slicer's comments; from E and the diameter of the filament, and the heights of layers; from the slicer's settings;
    assumed.
    """
    k, fixed = len(toolpath.start), {} if given is None else given.model_dump(include=given.model_fields_set)
    if given is not None and len(fixed) == 2:
        wide, high = (np.broadcast_to(np.float64(fixed[name]), k) for name in ("width", "height"))
        return Beads(wide, high, by, by, given, tuple(_odd(toolpath, scale, given)))
    found = _FromFile(toolpath, scale)
    height, height_by = found.height()
    if "height" in fixed:
        height, height_by = np.full(len(found.laid), fixed["height"] / scale), by
    width, width_by = found.width(height)
    if width is None:
        if height_by == LAYERS:  # never larger than where nothing is known
            height = np.minimum(height, Bead().height / scale)
        width, width_by = FLATNESS * height, f"assumed: {FLATNESS:g} times the height"
    if "width" in fixed:
        width, width_by = np.full(len(found.laid), fixed["width"] / scale), by
    sizes = [np.clip(each * scale, MIN_SIZE, MAX_SIZE) for each in (width, height)]
    typical = Bead(**dict(zip(("width", "height"), (found.middle(each) for each in sizes), strict=True)))
    columns = [_spread(each, found.laid, k) for each in sizes]
    notes = (*found.notes, *found.contradictions(*sizes), *_odd(toolpath, scale, typical))
    return Beads(columns[0], columns[1], width_by, height_by, typical, notes)


COMMENTS: Final = "by the file's comments"
LAYERS: Final = "by the heights of layers"
SETTINGS: Final = "by the slicer's settings"
ASSUMED: Final = "assumed"


class _FromFile:
    """Beads of the *laid* moves according to the file, m, at its scale, and notes on odd values."""

    def __init__(self, toolpath: Toolpath, scale: float) -> None:
        self.scale, self.settings, self.notes = scale, toolpath.settings, list[str]()
        self.laid = np.flatnonzero(toolpath.extruding)
        self.length = toolpath.length[self.laid]
        self.rise = _rises(toolpath, self.laid)
        self.wide, self.high = (self._said(column) for column in (toolpath.bead_width, toolpath.bead_height))
        self._require_millimetres()
        self.area: Array | None = None
        filament = self.settings.get("filament_diameter", math.nan)
        per_metre = 1e-6 if self.settings.get("volumetric") else 0.25 * math.pi * filament**2
        if toolpath.material_by in ("E", "A") and per_metre > 0.0:
            area = per_metre * toolpath.extrusion[self.laid] / self.length
            middle = self.middle(area)
            self.area = np.where((area * _OUTLIER < middle) | (area > _OUTLIER * middle), middle, area)
        self._by_e = "by E in mm^3" if per_metre == 1e-6 else f"by E and {1e3 * filament:g} mm filament"

    def _said(self, column: Array) -> Array | None:
        """Return what comments say of each laid move (l,), NaN where nothing; None where they never do."""
        said = column[self.laid]
        zero = np.count_nonzero(said <= 0.0)
        if zero:
            self.notes.append(f"{zero} moves have a width or height of 0 or less in the file's comments: not used")
        return np.where(said > 0.0, said, np.nan) if (said > 0.0).any() else None

    def _require_millimetres(self) -> None:
        """Take comments for inches, with a note, where only so they agree with the layers."""
        known, rise = self.wide if self.high is None else self.high, self.middle(self.rise)
        if known is None or not rise > 0.0:
            return
        ratio = rise / self.middle(known)
        if not (_INCH / _APART < ratio < _INCH * _APART if self.high is not None else 2.0 < ratio < _INCH * _APART):
            return
        self.wide, self.high = (None if each is None else each * _INCH for each in (self.wide, self.high))
        self.notes.append(
            f"widths and heights of the file's comments are taken for inches: its layers rise by {spell_length(rise)}"
        )

    def middle(self, values: Array) -> float:
        """Return the median of the known values (l,), by length; NaN where none is known."""
        known = np.flatnonzero(np.isfinite(values))
        if len(known) and np.ptp(values[known]) == 0.0:
            return float(values[known[0]])
        order = known[np.argsort(values[known], kind="stable")]
        if not len(order):
            return math.nan
        grown = np.cumsum(self.length[order])
        return float(values[order[np.searchsorted(grown, 0.5 * grown[-1])]])

    def height(self) -> tuple[Array, str]:
        """Return the bead heights (l,), and their source."""
        if self.high is not None:
            return self._filled(self.high, self.rise), COMMENTS
        if np.isfinite(self.rise).any():
            return self._filled(self.rise), LAYERS
        nominal = self.settings.get("layer_height", 0.0)
        found = nominal or Bead().height / self.scale
        return np.full(len(self.laid), found), SETTINGS if nominal else ASSUMED

    def width(self, height: Array) -> tuple[Array | None, str]:
        """Return the bead widths (l,), by the *height* (l,) where E gives the section, and their source."""
        by_e = None if self.area is None else width_of(self.area, height)
        if self.wide is not None:
            missing = float(self.length[np.isnan(self.wide)].sum() / self.length.sum())
            if missing > _SHARE:
                how = "the middle one" if by_e is None else self._by_e
                self.notes.append(
                    f"{100.0 * missing:.0f} % of the material has no width in the comments: {how} is used"
                )
            return self._filled(self.wide, by_e), COMMENTS
        if by_e is not None:
            return by_e, self._by_e
        nominal = self.settings.get("line_width", 0.0)
        return (np.full(len(self.laid), nominal), SETTINGS) if nominal else (None, ASSUMED)

    def _filled(self, said: Array, other: Array | None = None) -> Array:
        """Return *said* (l,), or else the *other*, or else the median of the given values."""
        found = said if other is None else np.where(np.isnan(said), other, said)
        return np.where(np.isnan(found), self.middle(said), found)

    def contradictions(self, width: Array, height: Array) -> Iterator[str]:
        """Yield a sentence where comments, layer heights and E contradict each other; sizes (l,) on the machine, m."""
        high, rise = math.nan if self.high is None else self.middle(self.high), self.middle(self.rise)
        if not 1.0 / _APART < high / rise < _APART and math.isfinite(high / rise):
            said = f"beads are {spell_length(high)} high by the file's comments, which are used"
            yield f"{said}, but its layers rise by {spell_length(rise)}"
        if self.area is not None and self.wide is not None:
            laid = (section(width, height) * self.length).sum() / self.scale**2
            ratio = float((self.area * self.length).sum() / laid)
            if not 1.0 / _APART < ratio < _APART:
                yield (
                    f"the file's comments contradict its E: {self._by_e} the volume is {ratio:.3g} times that of the "
                    "beads in the comments, which are used; --bead or a job file sets others"
                )


def _rises(toolpath: Toolpath, laid: NDArray[np.int64]) -> Array:
    """Return the height (l,) by which the layer of each laid move is above the one before; NaN where it is not known.

    Without layer markers a path that rises all along, as a vase, has no layers.
    """
    layer, z = toolpath.layer[laid], toolpath.end[laid, 2]
    slopes = np.abs(z - toolpath.start[laid, 2]) > _GRAIN
    if toolpath.layers_by == BY_HEIGHT and 2 * np.count_nonzero(slopes) > len(laid):
        return np.full(len(laid), np.nan)
    first = np.concatenate([[0], np.flatnonzero(np.diff(layer)) + 1])
    tops = np.maximum.reduceat(z, first)
    rise = np.diff(tops, prepend=0.0)
    above = rise[1:][rise[1:] > _GRAIN]
    middle = float(np.median(above)) if len(above) else float(min(tops[0], Bead().height))
    rise[(rise <= _GRAIN) | (rise * _OUTLIER < middle) | (rise > _OUTLIER * middle)] = middle
    rise[~(rise > _GRAIN)] = np.nan
    return np.repeat(rise, np.diff(np.append(first, len(laid))))


def _spread(values: Array, laid: NDArray[np.int64], count: int) -> Array:
    """Return *values* (l,) of the laid moves as a column of all moves (count,), without memory where they are one."""
    if values.min() == values.max():
        return np.broadcast_to(values[0], count)
    column = np.full(count, np.nan)
    column[laid] = values
    column.setflags(write=False)
    return column


def _odd(toolpath: Toolpath, scale: float, bead: Bead) -> Iterator[str]:
    """Yield a note where the bead is wider than the part, and where there is no part."""
    if (toolpath.kind[toolpath.extruding] == LineType.PRIME).all():
        yield "all that is laid is a purge or prime line, or precedes the first layer: is this the file of the part?"
    if bead.height < _FLAT:
        yield f"beads are {1e6 * bead.height:.3g} um high: is the file in inches, without G20, or the scale wrong?"
    ends = toolpath.end[toolpath.extruding & (toolpath.layer > 0), :2]
    size = scale * float(np.ptp(ends, axis=0).max()) if len(ends) else math.inf
    if bead.width > size:
        yield (
            f"the bead is {spell_length(bead.width)} wide, the part {spell_length(size)}: is the bead, the scale or a "
            "unit wrong?"
        )
