"""The order in which unknowns on a grid are eliminated: nested dissection, which keeps the factors of solids small.

A plane of the grid parts the unknowns into two that do not speak to each other; the plane's own come last. So again on
both sides (George 1973).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Mask

Index = NDArray[np.int64]

_MIN_UNKNOWNS = 200  # unknowns that are not parted any more
_MAX_SHARE = 0.8  # of the unknowns on one side, at most


def dissected(places: Index, corners: Mask) -> Index:
    """An order (n,) of unknowns at *places* (3, n) of a grid, counted in whole steps.

    Planes through *corners* of elements part them: no element reaches across.
    """
    parts: list[Index] = []
    _part(np.arange(places.shape[1]), places, corners, parts)
    return np.concatenate(parts) if parts else np.empty(0, dtype=np.int64)


def _part(some: Index, places: Index, corners: Mask, parts: list[Index]) -> None:
    """Append *some* unknowns in their order."""
    found = _best_plane(some, places, corners) if len(some) > _MIN_UNKNOWNS else None
    if found is None:
        parts.append(some)
        return
    axis, plane = found
    own = places[axis, some]
    _part(some[own < plane], places, corners, parts)
    _part(some[own > plane], places, corners, parts)
    parts.append(some[own == plane])


def _best_plane(some: Index, places: Index, corners: Mask) -> tuple[int, int] | None:
    """The axis and place of the plane with the fewest unknowns, rather in the middle; None if there is none."""
    best: tuple[float, int, int] | None = None
    for axis in range(3):
        own = places[axis, some]
        planes = np.unique(own[corners[some]])[1:-1]
        ordered = np.sort(own)
        below, upto = np.searchsorted(ordered, planes, "left"), np.searchsorted(ordered, planes, "right")
        larger = np.maximum(below, len(some) - upto) / len(some)
        cost = np.where(larger < _MAX_SHARE, (upto - below) * (1.0 + 2.0 * np.maximum(larger - 0.5, 0.0)), np.inf)
        if len(planes) and np.isfinite(cost.min()) and (best is None or cost.min() < best[0]):
            best = (float(cost.min()), axis, int(planes[cost.argmin()]))
    return None if best is None else best[1:]
