"""Base of sensor readings: source, clock, log topic, random stream, and which fields are per line."""

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Final, Literal, NamedTuple, Self, get_type_hints


class Source(NamedTuple):
    """One sensor. ``stream``: its number, for good: of its random numbers in a simulation, and its place among others.

    ``topic``: topic of the readings in a log. ``clock``: clock that stamps the readings; readings of the drum's clock
    come over the wireless link.
    """

    name: str
    stream: int
    topic: str
    clock: Literal["machine", "drum"] = "machine"


class PerLine(NamedTuple):
    """Marks a field with a number for each line, (m,), or of *winch* for each winch, (w,).

    ``unit``: empty for what has none. A float may be NaN.
    """

    unit: str = ""
    winch: bool = False


OR_NAN: Final = "NaN: not measured"
"""Marks a number that may be NaN."""


@dataclass(frozen=True, eq=False)
class Reading:
    """A reading of a sensor. Its declaration contains the data for logs, simulation and checks of readings."""

    SOURCES: ClassVar[tuple[Source, ...]]
    """Sensors that such readings come from; with several of them, a field ``source`` names the one."""

    if TYPE_CHECKING:

        @property
        def source(self) -> str:
            """Name of the sensor."""

        @property
        def time(self) -> float:
            """Time of the measurement, s."""

    def __init_subclass__(cls, sources: Sequence[Source]) -> None:
        """Declare the *sources*; the name of the only one is that of each reading."""
        cls.SOURCES = tuple(sources)
        if len(sources) == 1:
            type.__setattr__(cls, "source", sources[0].name)

    @property
    def stamp(self) -> float:
        """Time that a clock wrote on the reading, s."""
        return self.time

    def stamped(self, time: float, rate: float = 1.0) -> Self:
        """Return the reading with another stamp, s.

        Times within it are by a clock that runs at a *rate* to the former.
        """
        del rate
        found = object.__new__(type(self))
        found.__dict__.update(self.__dict__, time=time)
        return found


def per_line(kind: type) -> Mapping[str, PerLine]:
    """Return the fields of a kind of signal that have a number for each line, with their marks."""
    return _marks(kind)


def miscounted(signal: object, lines: int, winches: int) -> tuple[str, int, int] | None:
    """Return name, count and right count of the first field that has not a number for each line or winch; or None."""
    kind: type = type(signal)
    for name, mark in _marks(kind).items():
        given, right = len(getattr(signal, name)), winches if mark.winch else lines
        if given != right:
            return name, given, right
    return None


@functools.cache
def _marks(kind: type) -> Mapping[str, PerLine]:
    hints = get_type_hints(kind, include_extras=True)
    return {
        name: mark
        for name, hint in hints.items()
        for mark in getattr(hint, "__metadata__", ())
        if type(mark) is PerLine
    }
