"""Nested dissection of unknowns on a grid: an elimination order with little fill-in (George 1973).

A plane of the grid separates the unknowns into two independent sets, each ordered recursively; the plane's own come
last.
"""

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Mask

Index = NDArray[np.int64]

_MIN_UNKNOWNS = 200  # fewer unknowns are not separated further
_MAX_SHARE = 0.8  # of the unknowns, on one side of a plane


def dissected(places: Index, corners: Mask) -> Index:
    """Return an elimination order (n,) of unknowns at *places* (3, n), indices on the grid.

    Separating planes pass through *corners* (n,) of elements, as no element extends across them.
    """
    parts: list[Index] = []
    _part(np.arange(places.shape[1]), places, corners, parts)
    return np.concatenate(parts) if parts else np.empty(0, dtype=np.int64)


def _part(some: Index, places: Index, corners: Mask, parts: list[Index]) -> None:
    """Append the order of *some* unknowns to *parts*."""
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
    """Axis and index of the plane with the fewest unknowns, preferably in the middle; None if there is none."""
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
