"""What the declaration of a sensor's data sheet says: whose readings it is about, and where a machine file has it."""

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
        """Number of the sensor's random numbers, and its place among others."""
        return SOURCES[self.source].stream


def moved_flaws(table: str) -> dict[str, str]:
    """Return where the flaws of one unit, once keys of its *table*, belong now."""
    return dict.fromkeys(("dropout", "outliers"), f"[simulation.{table}]")
