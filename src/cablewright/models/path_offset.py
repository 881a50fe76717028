"""Offset of points from a path in plan view.

A path crosses itself and lies above itself, so that the nearest point of the whole path may be on the wrong branch: the
search is limited to a range about the expected distance. Offsets are positive to the left of the path.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array
from cablewright.kernels import Direct
from cablewright.kernels.control import path_target as kernel
from cablewright.kernels.control.path_target import TrackArrays
from cablewright.printing.arc_length_path import Track

WITHIN: Final = 0.5
"""Half the range along the path in which the nearest point is searched, m."""

_Kind = TypeVar("_Kind", bound=np.generic)
_NEAREST: Final = Direct(kernel.nearest)


class Nearest(NamedTuple):
    """The nearest point of the path in plan view: its distance along the path, and the offset from the path."""

    distance: float  # m from the path's beginning
    offset: float  # m; positive is left of the path


def arrays_of(track: Track) -> TrackArrays:
    """Return a path (track) as arrays for kernels."""
    along = read_only(track.along_x), read_only(track.along_y)
    layer, laying = read_only(track.layer), read_only(track.laying)
    return TrackArrays(
        read_only(track.positions), read_only(track.distance), layer, laying, *along, read_only(track.level)
    )


def read_only(values: NDArray[_Kind]) -> NDArray[_Kind]:
    """Return a read-only view of an array: kernels are compiled for one kind."""
    view = values.view()
    view.flags.writeable = False
    return view


def nearest(track: Track, point: Sequence[float] | Array, around: float, within: float = WITHIN) -> Nearest:
    """Return the point of the path nearest to *point* (2 or more), m, in plan view, see `path_target.nearest`."""
    return nearest_in(arrays_of(track), point, around, within)


def nearest_in(track: TrackArrays, point: Sequence[float] | Array, around: float, within: float = WITHIN) -> Nearest:
    """Return the nearest point as `nearest`, from the arrays of a track."""
    return Nearest(*_NEAREST.call(track, float(point[0]), float(point[1]), float(around), float(within)))


def nearest_of_each(track: Track, points: Array, around: Array, within: float = WITHIN) -> tuple[Array, Array]:
    """Return distances (k,) and offsets (k,), m, as `nearest`, for *points* (k, 2 or more) and *around* (k,)."""
    distances, offsets = np.empty((2, len(points)))
    columns = np.array(points[:, :2], dtype=np.float64), np.array(around, dtype=np.float64)
    kernel.nearest_rows(arrays_of(track), *columns, float(within), distances, offsets)
    return distances, offsets
