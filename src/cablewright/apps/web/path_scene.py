"""A path in a scene with its quantities by level of detail, and the states of the robot along it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from cablewright.apps.web.detail_levels import LEFT_OUT, PIECE, levels, packed
from cablewright.apps.web.viewer_states import States
from cablewright.foundation.arrays import Array, Indices, Mask
from cablewright.foundation.errors import Status
from cablewright.foundation.memory_mapped import RowExtremes, blocks, let_go, taken
from cablewright.models.statics import Model
from cablewright.solvers.inverse import solve_inverse

LIFTED, LAID, TRAVEL = 0, 1, 2  # what the piece that ends at a vertex is
_UNKNOWN: Final = 255
_COLOURS: Final = 250  # steps of a colour scale
_STEPS: Final = 65_535
_ACROSS: Final = 1200.0  # tolerance when all is in view: this part of the scene's extent, which is under a pixel
_FINER: Final = 4.0  # from level to level
_COARSER: Final = 3  # levels for machines that draw slowly, while one turns the view
_LEVELS: Final = 7
_SAMPLED: Final = 1_000_000  # values from which the ends of a colour scale are found
_SEEN: Final = 0.04  # share of a scale that counts as much as the tolerance


@dataclass(frozen=True, eq=False)
class Quantity:
    """Values (k,) along a path, SI, with the ends of their colour scale. NaN: not known."""

    key: str
    label: str
    unit: str
    values: Array | RowExtremes
    low: float
    high: float
    colours: Literal["error", "signed", "tension"] = "error"
    note: str = ""

    @classmethod
    def of(cls, key: str, label: str, unit: str, values: Array | RowExtremes, **more: Any) -> Quantity:
        """Return the quantity with a scale from the smallest to the largest value.

        The scale cuts off few outliers, with a note.
        """
        low, high, known = _spread(values)
        if low > high:
            return cls(key, label, unit, values, 0.0, 1.0, **more)
        core_low, core_high = np.quantile(known, [0.002, 0.998]).tolist() if len(known) else (low, high)
        if high - low > 1.5 * (core_high - core_low) > 0.0:
            more.setdefault("note", "a few values are beyond the ends")
            low, high = core_low, core_high
        if high - low <= 1e-12 * max(abs(high), 1.0):
            high = low + max(abs(low) * 0.05, 1e-9)
        return cls(key, label, unit, values, low, high, **more)

    def steps(self, rows: Indices) -> NDArray[np.uint8]:
        """Return values at some rows as steps of the colour scale (r,); `_UNKNOWN` where there is none."""
        values = taken(self.values, rows)
        share = (values - self.low) / (self.high - self.low)
        scaled = np.clip(np.round(np.nan_to_num(share) * (_COLOURS - 1)), 0, _COLOURS - 1)
        return np.where(np.isfinite(values), scaled, _UNKNOWN).astype(np.uint8)


@dataclass(frozen=True, eq=False)
class PathScene:
    """A path of k points, m, for the viewer; ``extent``: largest side of the scene, m, by which detail is chosen."""

    positions: Array  # (k, 3)
    extruding: Mask  # (k,) whether material is laid up to each
    layer: NDArray[Any]  # (k,) number of the layer
    extent: float
    quantities: Sequence[Quantity] = ()
    time: Array | None = None  # (k,) s
    line: NDArray[Any] | None = None  # (k,) of the file
    line_name: str = "G-code line"
    bead: tuple[float, float] | None = None  # m: width and height of a strand
    worst: int | None = None  # kept in any case

    @property
    def bounds(self) -> Array:
        """Lowest and highest corner (2, 3) of the path, m."""
        low, high = np.full(3, np.inf), np.full(3, -np.inf)
        for at in blocks(len(self.positions)):
            known = self.positions[at][self.known[at]]
            low = np.minimum(low, known.min(axis=0, initial=np.inf))
            high = np.maximum(high, known.max(axis=0, initial=-np.inf))
            let_go(self.positions)
        return np.stack([low, high]) if (low <= high).all() else np.zeros((0, 3))

    @cached_property
    def known(self) -> Mask:
        """Mask (k,) of path points whose value is known."""
        known = np.empty(len(self.positions), dtype=np.bool_)
        for at in blocks(len(known)):
            known[at] = np.isfinite(self.positions[at]).all(axis=1)
            let_go(self.positions)
        return known

    @cached_property
    def tolerances(self) -> Array:
        """Largest distance (L,), m, of each level of detail from the path."""
        return np.asarray(self.extent / _ACROSS * _FINER ** (_COARSER - np.arange(_LEVELS, dtype=float)))

    @property
    def overview(self) -> Indices:
        """Points of the level of detail that is drawn when the whole path is in view."""
        return np.flatnonzero(self.level <= _COARSER)

    @cached_property
    def kind(self) -> NDArray[np.uint8]:
        """Type (k,) of the piece that ends at each point; lifted at the first, and at an unknown point."""
        known = self.known
        made = np.where(self.extruding, LAID, TRAVEL).astype(np.uint8)
        made[:1] = LIFTED
        made[~known] = LIFTED
        made[1:][~known[:-1]] = LIFTED
        return made

    @cached_property
    def level(self) -> NDArray[np.uint8]:
        """First level of detail (k,) that contains each point."""
        known = self.known
        fixed: Mask = np.asarray(~known)
        fixed[:-1] |= (self.kind[1:] != self.kind[:-1]) | (self.layer[1:] != self.layer[:-1]) | ~known[1:]
        fixed[1:] |= ~known[:-1]
        if self.worst is not None:
            fixed[max(0, self.worst - 1) : self.worst + 1] = True
        let_go((self.layer, self.extruding))
        found = np.empty(len(known), dtype=np.uint8)
        for at in blocks(len(known), PIECE):  # pieces are apart: each begins where one before ends
            ends = slice(at.start, at.stop + 1)
            found[ends] = levels(self._points(ends), fixed[ends], self.tolerances)
        return found

    def _points(self, at: slice) -> Array:
        """Points of the path (b, 3 or 4) whose distances are what one sees: in space, and by their first colour."""
        columns = [np.nan_to_num(self.positions[at])]
        for each in self.quantities[:1]:  # the one that is shown first
            share = np.nan_to_num((each.values[at] - each.low) / (each.high - each.low))
            columns.append(np.clip(share, 0.0, 1.0)[:, None] * (self.tolerances[_COARSER] / _SEEN))
            let_go(each.values)
        let_go(self.positions)
        return np.concatenate(columns, axis=1)

    @cached_property
    def kept(self) -> Indices:
        """Points of the path that belong to any level of detail."""
        return np.flatnonzero(self.level != LEFT_OUT)

    def as_dict(self) -> dict[str, Any]:
        """The path of the 3-D view as a JSON object."""
        kept = self.kept
        low, high = self.bounds if len(self.bounds) else np.zeros((2, 3))
        step = max(float((high - low).max()), 1e-9) / _STEPS
        grid = np.clip(np.round((np.nan_to_num(taken(self.positions, kept), nan=0.0) - low) / step), 0, _STEPS)
        numbers = np.unique(self.layer)
        layer = np.searchsorted(numbers, taken(self.layer, kept))
        group = -(-len(numbers) // _STEPS)  # layers that share a step of the slider
        return {
            "origin": low.tolist(),
            "step": step,
            "places": packed(grid, "u16", delta=True),
            "layer": packed(layer // group, "u16", delta=True),
            "layers": numbers[::group].tolist(),
            "kind": packed(self.kind[kept], "u8"),
            "level": packed(self.level[kept], "u8"),
            "tolerances": self.tolerances.tolist(),
            "sample": packed(kept, "u32", delta=True),
            "time": None if self.time is None else packed(np.round(1e3 * taken(self.time, kept)), "u32", delta=True),
            "line": None if self.line is None else packed(taken(self.line, kept), "u32", delta=True),
            "line_name": self.line_name,
            "quantities": [
                {
                    "key": each.key,
                    "label": each.label,
                    "unit": each.unit,
                    "low": each.low,
                    "high": each.high,
                    "colours": each.colours,
                    "note": each.note,
                    "values": packed(each.steps(kept), "u8"),
                }
                for each in self.quantities
            ],
            "bead": self.bead,
        }


def _spread(values: Array | RowExtremes) -> tuple[float, float, Array]:
    """The smallest and the largest number of *values* (k,), and a sample of all: at most `_SAMPLED`."""
    low, high, every = np.inf, -np.inf, -(-len(values) // _SAMPLED)
    found = [np.zeros(0)]
    for at in blocks(len(values)):
        known = values[at][np.isfinite(values[at])]
        low, high = known.min(initial=low), known.max(initial=high)
        found.append(known[::every])
        let_go(values)
    return float(low), float(high), np.concatenate(found)


MOST: Final = 300
"""States along a path."""


def chosen(count: int, time: Array | None = None, worst: int | None = None, most: int = MOST) -> Indices:
    """Return indices of samples, of *count*, that get a state: even in *time* or number; first, last, worst too."""
    if time is None or not np.isfinite(time).all() or count < 2 or time[-1] <= time[0]:
        at = np.linspace(0, count - 1, min(count, most)).round().astype(np.intp)
    else:
        at = np.searchsorted(time, np.linspace(time[0], time[-1], min(count, most))).clip(0, count - 1)
    extra = [] if worst is None else [worst]
    return np.unique(np.concatenate([at, [0, count - 1], extra]).astype(np.intp))


def states_along(
    model: Model,
    poses: Array,
    *,
    retraction: Array | None = None,
    tensions: Array | None = None,
    time: Array | None = None,
    worst: int | None = None,
) -> States:
    """Return states at some of *poses* (k, n), all at rest, with tensions nearest to *tensions* (k, m), N, if given.

    *retraction* (k,), m; *time* (k,), s. A pose that cannot be held has a note that says so.
    """
    at = chosen(len(poses), time, worst)
    preferred = None if tensions is None else np.where(np.isfinite(tensions[at]), tensions[at], 0.0)
    own = None if retraction is None else retraction[at]
    found = solve_inverse(model, poses[at], path=True, preferred=preferred, retraction=own)
    notes = tuple("" if code == 0 else f"Not in equilibrium here: {Status.of(int(code)).value}." for code in found.code)
    shown = int(np.searchsorted(at, worst)) if worst is not None else 0
    return States.held(
        found,
        None if tensions is None else tensions[at],
        times=None if time is None else time[at],
        samples=at,
        notes=notes if any(notes) else (),
        shown=shown,
    )
