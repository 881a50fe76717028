"""All readings of a machine in one step."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from cablewright.foundation.arrays import Array
from cablewright.foundation.signals.notices import Notice
from cablewright.foundation.signals.reading import Reading

_Kind = TypeVar("_Kind")


@dataclass(frozen=True, eq=False)
class SensorFrame:
    """All readings that arrived since the last frame, in the order of arrival.

    A reading's own time is that of its measurement, possibly before the last frame. Readings may be missing: a silent
    sensor, a lost message, a gap of the wireless link.
    """

    time: float  # s
    readings: tuple[Reading, ...] = ()
    notices: tuple[Notice, ...] = ()

    def of(self, kind: type[_Kind]) -> tuple[_Kind, ...]:
        """Return the frame's readings of one kind: ``frame.of(Scan)``."""
        return tuple(self._by_kind.get(kind, ()))

    @cached_property
    def _by_kind(self) -> dict[type, list[Any]]:
        found: dict[type, list[Any]] = {}
        for reading in self.readings:
            found.setdefault(type(reading), []).append(reading)
        return found


def frozen(values: ArrayLike) -> Array:
    """Return a read-only copy of an array as floats."""
    copy = np.array(values, dtype=np.float64)
    copy.flags.writeable = False
    return copy
