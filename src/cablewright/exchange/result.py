"""Results of `import` and `export`: files, and lists of lost and assumed values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar

from cablewright.foundation.results import Figure, Result

_LOST = Figure("lost", "", "What of the one side the other does not have, a sentence each.", sentences=True)
_ASSUMED = Figure("assumed", "", "What the other side needs and had to be assumed, a sentence each.", sentences=True)


class _Told(Result):
    """People read what was lost and assumed on stderr."""

    lost: tuple[str, ...]
    assumed: tuple[str, ...]

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on lost and assumed values for stderr."""
        return (*(f"lost: {each}" for each in self.lost), *(f"assumed: {each}" for each in self.assumed))


@dataclass(frozen=True, repr=False)
class Imported(_Told):
    """A robot that was read from another program's file."""

    FIGURES: ClassVar = (
        Figure("format", "", "Format that was read."),
        Figure("name", "", "Name of the robot."),
        Figure("lines", "1", "Number of lines.", "m"),
        Figure(
            "freedoms", "1", "Degrees of freedom of the platform: 3 of a point, 6 of a rigid one; fewer in a plane."
        ),
        Figure("lost", "", _LOST.meaning, detail=True),
        Figure("assumed", "", _ASSUMED.meaning, detail=True),
    )

    format: str
    name: str
    m: int
    freedoms: int
    lost: tuple[str, ...]
    assumed: tuple[str, ...]


@dataclass(frozen=True, repr=False)
class Exported(_Told):
    """Files that an export has written for another program."""

    FIGURES: ClassVar = (
        Figure("format", "", "Format that was written."),
        Figure("name", "", "Name of the robot."),
        Figure("points", "1", "Points of the path that the file of the job has.", only=lambda of: of.points > 0),
        Figure(
            "path_error", "m", "Largest error of a line's length between two points, measured half-way between them.",
            only=lambda of: of.path_error is not None,
        ),
        Figure(
            "nozzle_error", "m", "Largest error of the nozzle by the firmware's own model, at the points and half-way.",
            only=lambda of: of.nozzle_error is not None,
        ),
        Figure("messages", "1", "Messages of the bag, by topic.", only=lambda of: bool(of.messages)),
        Figure("lost", "", _LOST.meaning, detail=True),
        Figure("assumed", "", _ASSUMED.meaning, detail=True),
    )  # fmt: skip

    format: str
    name: str
    lost: tuple[str, ...]
    assumed: tuple[str, ...]
    points: int = 0
    path_error: float | None = None
    nozzle_error: float | None = None
    messages: Mapping[str, int] = field(default_factory=dict)
