"""Declaration of a sensor: its data sheet, the source of its readings, and its table in a machine file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, TypeVar

from cablewright.foundation.signals import SOURCES
from cablewright.foundation.validation import Description

_SheetT = TypeVar("_SheetT", bound="SensorSheet")


class SensorSheet(Description):
    """Data of a sensor that is read at a ``rate``, Hz. A deviation is the noise of one reading."""

    if TYPE_CHECKING:

        @property
        def rate(self) -> float:
            """Readings a second, Hz."""


@dataclass(frozen=True, eq=False)
class Sensor(Generic[_SheetT]):
    """A sensor that machines may have: name of its source, and keys of its table in a machine file.

    ``key``: key of that table; empty: the source's name. ``noise``: keys of quantities that are smaller in a mean of
    readings.
    """

    source: str
    sheet: type[_SheetT]
    key: str = ""
    noise: tuple[str, ...] = ("deviation",)

    @property
    def table(self) -> str:
        """Key of the sensor's table in a machine file, and of that of its flaws in ``[simulation]``."""
        return self.key or self.source

    @property
    def stream(self) -> int:
        """Number of the sensor's stream of random numbers, which also orders the sensors."""
        return SOURCES[self.source].stream


def moved_flaws(table: str) -> dict[str, str]:
    """Return the new tables for flaws of one unit that older files give among the keys of its *table*."""
    return dict.fromkeys(("dropout", "outliers"), f"[simulation.{table}]")
