"""The set-up of the instrument in a GSI file: station, heights of instrument and reflector, signs of another one."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final

from cablewright.calibration.survey.gsi import Block
from cablewright.foundation.csv_input import shown
from cablewright.foundation.errors import InputError

Vector = tuple[float, float, float]

MEASURED: Final = frozenset({21, 22, 31, 81, 82, 83})
"""Words of a shot: circle, zenith angle, slope distance; E, N, H of the target."""

_STATION: Final[tuple[int, ...]] = (84, 85, 86, 88)  # E0, N0, H0 of the mark, height of the instrument over it
_REFLECTOR: Final = 87
_APART: Final = 0.02  # m, between coordinates and angles of one block in one grid


@dataclass
class GsiSetup:
    """The set-up as it holds at a block. It may not change after the first sight: another station has another circle.

    ``origin``: the file's name. ``sighted``: line of the last sight by angles and distance, 0 before the first.
    ``remarks``: blocks of codes after a sight.
    """

    origin: str
    sighted: int = 0
    remarks: list[Block] = field(default_factory=list)
    _words: dict[int, float | None] = field(default_factory=dict)  # those of the station, m; None: without a value
    _reflector: float = 0.0  # m, by a block without a shot
    _of_sight: tuple[int, float] | None = None  # line and height of the last sight with a reflector of its own
    _opening: tuple[str, ...] = ()  # the codes before the first sight
    _doubtful: Block | None = None  # after a sight; may begin another station
    _unlike: tuple[float, int] = (0.0, 0)  # m, line: coordinates that are furthest from their angles

    def follow(self, block: Block) -> None:
        """Take the words of a set-up from *block*. Raises `InputError` for another station after a sight."""
        held = block.words.keys() | block.blank
        given = {index: block.words.get(index) for index in _STATION if index in held}
        news = [index for index in given if index not in self._words or self._words[index] != given[index]]
        if news and self.sighted:
            raise InputError(
                f"{self.origin}, line {block.line}: the station differs from that of line {self.sighted}; survey from "
                f"one station, or export coordinates (words 81 to 83); word {news[0]} is another, or has no value"
            )
        if any(index in self._words for index in news):
            self._words.clear()  # another station: what its block lacks is not known
        self._words |= given
        if _REFLECTOR in block.words and MEASURED.isdisjoint(held):
            self._reflector, self._of_sight = block.words[_REFLECTOR], None
        if not self.sighted:
            self._opening = block.codes or self._opening
        elif (len(block.codes) > 1 and block.codes != self._opening) or not (
            block.codes or given or _REFLECTOR in held or held & MEASURED
        ):
            self._doubtful = self._doubtful or block
        if self.sighted and block.codes:
            self.remarks.append(block)

    @property
    def axis(self) -> Vector | None:
        """The instrument's axis in the file's grid, m; None unless words 84 to 86 have a value."""
        e, n, h, over = (self._words.get(index) for index in _STATION)
        return None if e is None or n is None or h is None else (e, n, h + (over or 0.0))

    def sight(self, block: Block, sight: Vector) -> tuple[Vector, float]:
        """Return position of the point that is measured by a *sight*, and height of the reflector over it, m.

        The position is in the file's grid where the station is known, else from its mark. A sight without word 87 has
        the reflector of the last block without a shot, else 0. Raises `InputError` where the sight before had another
        one of its own, and after a block that may begin another station: codes with a text, or a lone point. Codes
        like those before the first sight say nothing new; a code alone is of a point.
        """
        doubtful, place = self._doubtful, f"{self.origin}, line {block.line}"
        if doubtful is not None:
            kind = f"of codes, {shown(', '.join(doubtful.codes))}," if doubtful.codes else "without a measurement"
            raise InputError(
                f"{self.origin}, line {doubtful.line}: a block {kind} before the sight at line {block.line} may begin "
                "another station; one station is allowed: survey from one, export coordinates (words 81 to 83), or "
                "delete the block where it is a remark"
            )
        self.sighted = block.line
        if _REFLECTOR in block.words:
            self._of_sight = block.line, block.words[_REFLECTOR]
        elif self._of_sight is not None and self._of_sight[1] != self._reflector:
            raise InputError(
                f"{place}: the sight has no word 87, that of line {self._of_sight[0]} has {self._of_sight[1]:g} m: "
                "write the height of the reflector into each block, also where it is 0"
            )
        return self._placed(block, sight)

    def compare(self, block: Block, position: Vector, sight: Vector) -> None:
        """Keep how far the coordinates of *block* are from its own *sight*."""
        self._unlike = max(self._unlike, (math.dist(position, self._placed(block, sight)[0]), block.line))

    def require_one_grid(self, coordinates: int) -> str:
        """Return a note that sights and coordinates have one grid. *coordinates*: line of the first block with some.

        Raises `InputError` if the station is not known whole, or angles are not in that grid.
        """
        missing = [str(index) for index in _STATION if self._words.get(index) is None]
        mixed = (
            f"{self.origin}, line {self.sighted}: a sight by angles beside coordinates (words 81 to 83, line "
            f"{coordinates}), but"
        )
        if missing:
            raise InputError(
                f"{mixed} the station before it has no word {', '.join(missing)}: write E0, N0, H0 and the height of "
                "the instrument (84, 85, 86, 88) into its block, or export coordinates of all points"
            )
        if self._unlike[0] > _APART:
            raise InputError(
                f"{mixed} at line {self._unlike[1]} angles and coordinates of one point are {self._unlike[0]:.3g} m "
                "apart: the circle is not oriented to the grid, or a height is wrong; export coordinates of all points"
            )
        return (
            "sights by angles are in the grid of the coordinates by the words 84 to 88 of their station, if its circle "
            "was oriented to that grid"
        )

    def _placed(self, block: Block, sight: Vector) -> tuple[Vector, float]:
        reflector = block.words.get(_REFLECTOR, self._reflector)
        x, y, z = self.axis or (0.0, 0.0, self._words.get(88) or 0.0)
        return (x + sight[0], y + sight[1], z + sight[2] - reflector), reflector
