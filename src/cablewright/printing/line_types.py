"""Purposes of a part's moves (wall, infill, ...), under one set of names for all slicers."""

from __future__ import annotations

from enum import IntEnum
from typing import Final


class LineType(IntEnum):
    """Type of a move. Slicers name the type of each extruding move; every other move is `TRAVEL`."""

    TRAVEL = 0
    """Nothing is laid."""
    UNSPECIFIED = 1
    """Material, of which the file names no type."""
    OUTER_PERIMETER = 2
    INNER_PERIMETER = 3
    OVERHANG = 4
    INFILL = 5
    SOLID_INFILL = 6
    SURFACE = 7
    """Top or bottom surface, ironing."""
    BRIDGE = 8
    GAP_FILL = 9
    SUPPORT = 10
    SKIRT = 11
    """Skirt, brim, raft or shield."""
    PRIME = 12
    """Wipe tower, the user's own code, or whatever is laid before the first layer marker."""
    OTHER = 13
    """Material of a type that is not in this list; the file's word for it is among the ignored words."""


_NAMES: Final = {
    LineType.UNSPECIFIED: "unknown, undefined, mixed, multiple, none, destring/wipe/jump path",
    LineType.OUTER_PERIMETER: (
        "external perimeter, outer wall, wall outer, outer perimeter, outer shell, perimeter outer, loop outer, "
        "edge outer, external single extrusion, perimeter path"
    ),
    LineType.INNER_PERIMETER: (
        "perimeter, inner wall, wall inner, inner perimeter, inner shell, perimeter inner, loop inner, edge inner, "
        "internal single extrusion, thin wall, loop path, loop, edge"
    ),
    LineType.OVERHANG: "overhang perimeter, overhang wall",
    LineType.INFILL: (
        "internal infill, sparse infill, infill, fill, sparse infill path, stacked sparse infill path, infill path"
    ),
    LineType.SOLID_INFILL: "solid infill, internal solid infill, solid layer, solid fill, solid path, solid",
    LineType.SURFACE: "top solid infill, top surface, bottom surface, skin, ironing, crown path",
    LineType.BRIDGE: "bridge infill, internal bridge infill, bridge, internal bridge",
    LineType.GAP_FILL: "gap fill, gap infill",
    LineType.SUPPORT: (
        "support material, support material interface, support, support interface, support transition, "
        "dense support, support path, support (may stack) path, support interface path"
    ),
    LineType.SKIRT: "skirt, brim, skirt/brim, raft, ooze shield, skirt path, raft path",
    LineType.PRIME: (
        "wipe tower, prime tower, prime pillar, custom, purge, prime pillar path, pillar path, "
        "wipe (and de-string) path"
    ),
}
_TYPES: Final = {name: kind for kind, names in _NAMES.items() for name in names.split(", ")}


def line_type(word: str) -> LineType | None:
    """Return the type that a slicer calls *word* (``WALL-OUTER``, ``External perimeter``); None where unknown."""
    return _TYPES.get(word.lower().replace("-", " ").replace("_", " ").strip())
