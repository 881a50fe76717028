"""Result of a translation between formats: its text, and lists of carried, lost and assumed values."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from cablewright.foundation.arrays import Array
from cablewright.robot import Robot


@dataclass(frozen=True)
class Mapped:
    """One feature of a format.

    ``theirs``: its key in the other format; ``ours``: its key in a robot file; ``note``: how it is converted.
    """

    theirs: str
    ours: str
    note: str = ""


@dataclass(frozen=True)
class ImportedRobot:
    """A robot read from another program's file.

    ``lost``: sentences, each a part of the file that the robot does not have; ``assumed``: numbers of the robot that
    the file does not have.
    """

    robot: Robot
    format: str
    lost: tuple[str, ...]
    assumed: tuple[str, ...]


@dataclass(frozen=True)
class ExportedFile:
    """The text of another program's file. ``lost``: sentences, each a part of the robot that the text does not have."""

    text: str
    lost: tuple[str, ...] = ()
    assumed: tuple[str, ...] = ()


class Notes:
    """Notes in the order of their first mention, each once."""

    def __init__(self) -> None:
        self._sentences: dict[str, None] = {}

    def add(self, sentence: str) -> None:
        """Add a sentence to the notes about lost and assumed values of a translation."""
        self._sentences[sentence] = None

    def add_all(self, sentences: Iterable[str]) -> None:
        """Add sentences to the notes about lost and assumed values of a translation."""
        for sentence in sentences:
            self.add(sentence)

    def drop(self, sentence: str) -> None:
        """Remove a sentence from the notes."""
        del self._sentences[sentence]

    @property
    def all(self) -> tuple[str, ...]:
        """All notes about lost and assumed values of a translation."""
        return tuple(self._sentences)


def xml_numbers(values: Sequence[float] | Array) -> str:
    """Return *values* as an attribute of XML lists them: to the last digit, with spaces between."""
    return " ".join(repr(float(value)) for value in values)
