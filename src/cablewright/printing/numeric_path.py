"""Paths that a job describes by numbers, with rounds at rising heights: a random closed curve, a helix."""

from __future__ import annotations

from typing import Annotated, Final

import numpy as np
from annotated_types import Ge, Gt, Le
from numpy.typing import NDArray
from pydantic import Field

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.units import Length
from cablewright.foundation.validation import Description
from cablewright.printing.line_types import LineType
from cablewright.printing.modal import MAX_COORDINATE
from cablewright.printing.random_curve import CurveRequirements, draw
from cablewright.printing.toolpath import Toolpath

CHORD: Final = 0.02  # m, maximum length of the pieces of a round
_SLOW_RISE: Final = 50.0  # m along the path per m of rise to the next round
_MAX_PIECES: Final = 5_000_000

_Distance = Annotated[Length, Ge(1e-6), Le(1e3)]
_Height = Annotated[Length, Ge(-MAX_COORDINATE), Le(MAX_COORDINATE)]
_Count = Annotated[int, Field(strict=True, ge=1, le=100_000)]


class _Rounds(Description):
    """Rounds about the job's origin, one above the other."""

    layers: _Count
    layer_height: Annotated[Length, Ge(0.0), Le(1e3)]
    """Height between two rounds."""
    first_height: _Height = 0.0


class RandomCurve(_Rounds):
    """A closed curve that crosses itself: number *number* of *seed*. See `printing/random_curve.py`."""

    seed: Annotated[int, Field(strict=True, ge=0, le=2**63 - 1)]
    number: Annotated[int, Field(strict=True, ge=0, le=1_000_000)] = 0
    length: _Distance
    area: tuple[_Distance, _Distance]
    """Sides of the rectangle about the origin that encloses the curve, along x and y."""
    crossings: Annotated[int, Field(strict=True, ge=0, le=50)] = 2
    least_radius: Annotated[Length, Ge(0.0), Le(1e3)] = 0.3

    @property
    def requirements(self) -> CurveRequirements:
        """Return the requirements that the random curve has to meet. Raises `InputError`."""
        return CurveRequirements(self.length, self.area, self.crossings, self.least_radius)

    @property
    def title(self) -> str:
        """Name of the path in reports."""
        return f"random curve {self.number} of seed {self.seed}"

    def toolpath(self) -> Toolpath:
        """Return all rounds as one path: each begins with the rise from the one below. Raises `InputError`."""
        pieces = int(np.ceil(self.length / CHORD))
        _limit(pieces * self.layers)
        once = draw(self.requirements, self.seed, self.number).even(pieces)
        along = self.length / pieces * np.arange(1, pieces + 1)
        rise = min(_SLOW_RISE * self.layer_height, 0.5 * self.length)
        risen = np.minimum(along / rise, 1.0) if rise else np.ones(pieces)
        number = np.repeat(np.arange(1, self.layers + 1, dtype=np.int32), pieces)
        height = np.maximum(number - 2.0 + np.tile(risen, self.layers), 0.0)
        places = np.empty((pieces * self.layers + 1, 3))
        places[0, :2], places[1:, :2] = once[0], np.tile(once[1:], (self.layers, 1))
        places[0, 2], places[1:, 2] = self.first_height, self.first_height + self.layer_height * height
        return _toolpath(places, number)


class Helix(_Rounds):
    """A helix about the origin that rises by *layer_height* per turn; each turn is a layer."""

    layer_height: Annotated[Length, Gt(0.0), Le(1e3)]
    radius: _Distance

    @property
    def title(self) -> str:
        """Name of the path in reports."""
        return f"helix of {self.layers} turns"

    def toolpath(self) -> Toolpath:
        """Return all turns of the helix as moves. Raises `InputError`."""
        pieces = max(36, int(np.ceil(2.0 * np.pi * self.radius / CHORD)))
        _limit(pieces * self.layers)
        turns = np.arange(pieces * self.layers + 1) / pieces
        angle = 2.0 * np.pi * turns
        height = self.first_height + self.layer_height * turns
        places = np.stack([self.radius * np.cos(angle), self.radius * np.sin(angle), height], axis=1)
        layer = np.repeat(np.arange(1, self.layers + 1, dtype=np.int32), pieces)
        return _toolpath(places, layer)


def _limit(pieces: int) -> None:
    if pieces > _MAX_PIECES:
        raise InputError(f"the path has {pieces} pieces of {CHORD} m; at most {_MAX_PIECES} are allowed: fewer layers")


def _toolpath(places: Array, layer: NDArray[np.int32]) -> Toolpath:
    """Return moves from place to place without a feed, each with its own length as extrusion."""
    start, end = places[:-1], places[1:]
    moves = len(start)
    columns = {
        "start": start,
        "end": end,
        "extrusion": np.linalg.norm(end - start, axis=1),
        "feed": np.full(moves, np.inf),
        "dwell": np.zeros(moves),
        "layer": layer,
        "line": np.arange(1, moves + 1, dtype=np.int32),
        "kind": np.full(moves, LineType.UNSPECIFIED, dtype=np.int8),
        "object": np.full(moves, -1, dtype=np.int32),
        "bead_width": np.full(moves, np.nan),
        "bead_height": np.full(moves, np.nan),
        "homing": np.zeros(moves, dtype=bool),
    }
    for column in columns.values():
        column.setflags(write=False)
    return Toolpath(
        **columns, objects=(), layers_by="rounds", material_by="every G1", slicer="", settings={}, unknown={}
    )
