"""Summary of a check for pictures and tables: errors, sections of the print, heights, extremes of lines."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array, Indices
from cablewright.foundation.memory_mapped import let_go, taken
from cablewright.models.rotation import placed
from cablewright.printing.layers import LayerTable
from cablewright.studies.checks.path_statics import largest_at, median
from cablewright.studies.checks.result import LARGEST, SMALLEST, Check

_MAX_STRETCHES: Final = 300
_FEWEST_STRETCHES: Final = 20
_MAX_HEIGHTS: Final = 400
_HEIGHT_GRAIN: Final = 1e-4  # m: heights nearer than this are one


class Band(NamedTuple):
    """Minimum, median and maximum of each group of values; NaN where a group has no number."""

    low: Array
    middle: Array
    high: Array


class Heights(NamedTuple):
    """Extruding samples grouped by height: ``order[starts[i]:starts[i + 1]]`` are those at ``z[i]``."""

    z: Array  # (h,) m
    order: NDArray[np.int32]
    starts: Indices  # (h,)

    def band(self, values: Array) -> Band:
        """Return minimum, median and maximum of ``values`` (k,) over each height."""
        ordered = values[self.order]
        let_go(values)
        return band(ordered, self.starts)


@dataclass(frozen=True, eq=False)
class Digest:
    """A check with values for its report, each computed once."""

    check: Check
    layers: LayerTable

    @cached_property
    def by_layer(self) -> bool:
        """Whether each of the *stretches* of the summary is one layer."""
        return _FEWEST_STRETCHES <= len(self.layers) <= _MAX_STRETCHES

    @cached_property
    def stretches(self) -> Indices:
        """First sample of each section of the print: of each layer, of groups of layers, or of equal parts."""
        total, first = len(self.check.samples), self.layers.first
        if len(first) < _FEWEST_STRETCHES:
            return np.unique(np.linspace(0, total, _MAX_STRETCHES + 1)[:-1].astype(np.intp))
        return np.asarray(np.union1d([0], first[:: -(-len(first) // _MAX_STRETCHES)]), dtype=np.intp)

    @cached_property
    def extruding(self) -> NDArray[np.int32]:
        """Indices of the samples whose segment lays material and whose error is known; int32, as they may be many."""
        laid = self.check.samples.extruding & np.isfinite(self.check.error_uncompensated)
        return np.flatnonzero(laid).astype(np.int32)

    @property
    def nothing_drawn(self) -> str:
        """Reason why the report of a check may have no pictures."""
        return "no error is known" if self.check.samples.extruding.any() else "nothing is extruded"

    @cached_property
    def worst(self) -> int | None:
        """The extruding sample with the largest uncompensated error, or of all where none is extruded."""
        return largest_at(self.check.error_uncompensated, self.check.samples.extruding)

    @cached_property
    def line_ends(self) -> Array:
        """Platform points (m, 3), m, world, at the worst sample; NaN where there is none."""
        check, at = self.check, self.worst
        if at is None:
            return np.full((check.robot.m, 3), np.nan)
        robot = check.robot if check.retraction is None else check.robot.retracted(float(check.retraction[at]))
        return placed(check.poses[at], [line.platform_point for line in robot.lines])

    @cached_property
    def heights(self) -> Heights:
        """The extruding samples by height; by equal slices where there are too many heights."""
        z = taken(self.check.samples.positions[:, 2], self.extruding)
        grain = _HEIGHT_GRAIN
        levels = np.unique(np.round(z / grain))
        if len(levels) > _MAX_HEIGHTS:
            grain = float(np.ptp(z)) / (_MAX_HEIGHTS // 2)
            levels = np.unique(np.round(z / grain))
        own = np.searchsorted(levels, np.round(z / grain)).astype(np.int16)
        order = np.argsort(own, kind="stable")
        starts = np.searchsorted(own[order], np.arange(len(levels)))
        return Heights(levels * grain, self.extruding[order], starts)

    def nearest_lines(self, count: int) -> list[int]:
        """Return ``count`` lines in the robot's order: those whose tension is nearest to its limits, or beyond."""
        limit = np.array([line.tension_limits for line in self.check.robot.lines])
        lowest = SMALLEST(self.check.statics.lines.lowest_tension)
        highest = LARGEST(self.check.statics.lines.highest_tension)
        room = np.fmin(lowest - limit[:, 0], limit[:, 1] - highest) / np.ptp(limit, axis=1)
        return sorted(int(i) for i in np.argsort(room, kind="stable")[:count])

    def unsolved(self) -> Iterator[tuple[int, int]]:
        """Yield each status code except 0 with the number of its samples, the commonest first."""
        codes, counts = np.unique(self.check.codes, return_counts=True)
        for at in np.argsort(-counts, kind="stable"):
            if codes[at] != 0:
                yield int(codes[at]), int(counts[at])


def band(values: Array, starts: Indices) -> Band:
    """Return minimum, median and maximum of ``values`` (k,) or (k, m) over the groups that begin at ``starts``.

    NaN is no number.
    """
    return Band(*(grouped(choose, values, starts) for choose in (SMALLEST, median, LARGEST)))


def grouped(choose: Callable[[Array], Array], values: Array, starts: Indices) -> Array:
    """Return a statistic of ``values`` (k,) or (k, m) for each of g groups from ``starts`` on: (g,) or (g, m)."""
    if len(starts) == 0:
        return np.empty((0, *values.shape[1:]))
    bounds = zip(starts, [*starts[1:], len(values)], strict=True)
    return np.stack([choose(values[first:stop]) for first, stop in bounds])
