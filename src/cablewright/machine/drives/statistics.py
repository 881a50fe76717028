"""Statistics of a bus: cycles, missed, late or foreign frames, and delays of the computer."""

from __future__ import annotations

from array import array
from dataclasses import dataclass, field
from typing import Final

_BITS: Final = 47  # of a frame of CAN without data
_STUFFED: Final = 1.2  # bits for one, with those that keep the bus in step


@dataclass(eq=False)
class BusStatistics:
    """Statistics of the bus since it was opened.

    ``lateness``: delay of each SYNC, s; ``answer``: time from a SYNC to the last PDO that answers it, s.
    """

    cycles: int = 0
    sent: int = 0
    received: int = 0
    missed: int = 0  # answers of a drive that a cycle did not bring
    malformed: int = 0  # frames of a length that is not theirs
    errors: int = 0  # of the bus
    late_cycles: int = 0  # SYNCs over half a period late
    bits: float = 0.0
    lateness: array[float] = field(default_factory=lambda: array("f"))
    answer: array[float] = field(default_factory=lambda: array("f"))

    def count(self, size: int) -> None:
        """Count the bits of a frame with *size* bytes."""
        self.bits += _STUFFED * (_BITS + 8 * size)

    def figures(self, period: float, bitrate: int) -> dict[str, float | int]:
        """The statistics by name; ``load`` is the share of the bus that is used."""
        busy = self.bits / (self.cycles * period * bitrate) if self.cycles else 0.0
        numbers: dict[str, float | int] = {"cycles": self.cycles, "sent": self.sent, "received": self.received}
        numbers |= {"missed": self.missed, "malformed": self.malformed, "errors": self.errors}
        return numbers | {"late_cycles": self.late_cycles, "load": busy}


def cyclic_load(drives: int, period: float, bitrate: int) -> float:
    """Return the share of a bus's capacity that cyclic frames of *drives* drives use, one with the valve's output."""
    sizes = (7, 2, 7, 8, 8)
    bits = drives * sum(_STUFFED * (_BITS + 8 * size) for size in sizes) + 2.0 * _STUFFED * (_BITS + 8)
    bits += _STUFFED * 32
    return bits / (period * bitrate)
