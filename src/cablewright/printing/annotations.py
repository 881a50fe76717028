"""Comments and object labels of slicers in G-code: layers, line types, objects, beads, settings, slicer name."""

from __future__ import annotations

import re
from typing import Final

from cablewright.printing.gcode_words import WordError
from cablewright.printing.line_types import LineType, line_type
from cablewright.printing.row_changes import Changes

MAX_LAYER: Final = 1_000_000
MAX_OBJECTS: Final = 10_000
MAX_NAME: Final = 100  # characters of an object's name
HEADER: Final = 1 << 14  # bytes at the begin of a file in which its slicer is looked for

LAYER_MARKERS: Final = {
    "colon": ";LAYER:n",
    "change": ";LAYER_CHANGE",
    "change_layer": "; CHANGE_LAYER",
    "named": "; layer n",
    "bracketed": "(LAYER n)",
    "begin": "; BEGIN_LAYER_OBJECT",
    "tag": "(<layer> z)",
    "z": ";Z:",
}
"""Kinds of layer markers, as they are written."""

SETTINGS: Final = {
    "filament_diameter": ("filament_diameter", "filamentDiameters", "fiber_dia_mm", "Filament Diameter #1"),
    "layer_height": ("layer_height", "layerHeight", "layer_thickness_mm", "Layer height"),
    "line_width": ("line_width", "extrusion_width", "extruderWidth", "extrusion_width_mm"),
    "volumetric": ("use_volumetric_e",),
}
"""Settings of slicers that say how large beads are, m, and what slicers call them; ``volumetric``: 1 for E in mm^3."""

_BY_NAME: Final = {name: setting for setting, names in SETTINGS.items() for name in names}
_KEYS = "|".join(re.escape(name) for name in _BY_NAME)
_Z = r"[-+]?[0-9]{1,9}(?:\.[0-9]{0,9})?"
_NOTE: Final = re.compile(
    rf"""
      ;LAYER:(?P<colon>[-+]?[0-9]{{1,9}})(?:\s.*)?
    | ;LAYER_CHANGE(?P<change>)\s*
    | ;[ ]?CHANGE_LAYER(?P<change_layer>)\s*
    | ;;?[ ]?(?:---[ ])?(?i:layer)(?:[ ]|:[ ]?|[ ]?\#)(?P<named>[0-9]{{1,9}})(?:\s*|[\s,:]+[^\s=].*)
    | \((?i:layer)(?:[ ]|:[ ]?|[ ]?\#)(?P<bracketed>[0-9]{{1,9}})(?:[\s,:][^()]*)?\)\s*
    | ;[ ]?BEGIN_LAYER_(?:OBJECT|RAFT)[ ]z=(?P<begin>{_Z})(?:\s.*)?
    | \(<layer>[ ]*(?P<tag>{_Z})[ ]*\)\s*
    | ;(?:Z|[ ]Z_HEIGHT):[ ]?(?P<z>{_Z})\s*
    | ;(?:HEIGHT|[ ]LAYER_HEIGHT):[ ]?(?P<height>{_Z})\s*
    | ;(?:WIDTH|[ ]LINE_WIDTH):[ ]?(?P<width>{_Z})\s*
    | ;[ ]tool[ ]H(?P<tool_height>{_Z})[ ]W(?P<tool>{_Z})\s*
    | (?:;TYPE:|;[ ]?FEATURE:|;[ ]feature[ ])[ ]?(?P<type>.{{1,80}})
    | ;[ ]'(?P<path>[^']{{1,60}}[ ]Path)'.*
    | \(<(?P<nested>(?:perimeter|edge|loop|infill)>[^()]{{0,20}})\)\s*
    | \(</(?:perimeter|edge|loop|infill)>(?P<nested_end>)\)\s*
    | ;[ ](?:start[ ])?printing[ ]object,?[ ](?P<object>.{{1,300}})
    | ;[ ]stop[ ]printing[ ]object(?P<object_end>.*)
    | ;MESH:(?P<mesh>.{{1,300}})
    | ;[ ]*(?P<key>{_KEYS})[ ]?[=,:][ ]?(?P<setting>{_Z})(?:mm)?(?:[|,;\s].*)?
    | ;FLAVOR:(?P<flavour>[A-Za-z]{{1,30}})\s*
    | ;[ ](?P<bare>[a-z][a-z ]{{2,30}})\s*
    """.encode(),
    re.VERBOSE | re.DOTALL,
)
_COUNTED: Final = ("change", "change_layer")  # markers without a number or a height
_BY_HEIGHT: Final = ("begin", "tag", "z")
_LABEL_NAME: Final = re.compile(rb"\bNAME=(?:'([^']*)'|\"([^\"]*)\"|(\S+))", re.IGNORECASE)
_M486: Final = re.compile(
    rb"\s*(?:N\s*[0-9]+\s*)?M486\s+(?:S\s*(?P<index>-?[0-9]{1,9})|A(?P<name>[^;*]*))", re.IGNORECASE
)

_SLICERS: Final = re.compile(
    rb"(?i:\b(?P<name>PrusaSlicer|OrcaSlicer|SuperSlicer|Bambu ?Studio|Slic3r|Cura(?:_SteamEngine)?|Simplify3D|"
    rb"KISSlicer|ideaMaker|Skeinforge|ReplicatorG|Kiri:Moto)\b)(?:[^\n\r0-9]{0,20}(?P<version>[0-9]{1,4}(?:\.[0-9]{1,6}){1,4}))?"
)
_MAKER: Final = re.compile(
    rb"(?i:(?:generated|created|sliced|exported)\s+(?:by|with|from))\s+(?P<name>[^\n\r;()]{1,60})"
)


def slicer_of(block: bytes) -> str:
    """Return the name and version of the program that a file's first *block* names in a comment; empty if none."""
    lines = (line.lstrip() for line in block[:HEADER].split(b"\n"))
    header = b"\n".join(line for line in lines if line.startswith((b";", b"(")))
    found = _SLICERS.search(header) or _MAKER.search(header)
    if found is None:
        return ""
    return " ".join(_printable(part) for part in found.groups() if part)


class Annotations:
    """Comments and labels for the rows of a growing table of moves."""

    def __init__(self) -> None:
        """Start a file."""
        self.layers: dict[str, Changes] = {}  # by kind of marker
        self.marker = ""  # the kind that counts: the first in the file; ;Z: only if there is no other
        self.types = Changes()  # `LineType` of each extruding move
        self.bead_widths, self.bead_heights = Changes(), Changes()  # m, file scale
        self.settings: dict[str, float] = {}  # see `SETTINGS`
        self.objects = Changes()  # index into `names`; -1: none
        self.names: list[str] = []  # of objects
        self._keys: dict[str, int] = {}  # index of an object, by its name in the file
        self._heights: dict[str, float] = {}  # last height of each kind of marker that has heights

    def read(self, line: bytes, row: int) -> str:
        """Read the comment at the start of *line*; *row* is the next move.

        Returns the name of a line type that is not known, else an empty text. Raises `WordError` for a number or a
        count out of range.
        """
        found = _NOTE.fullmatch(line)
        if found is None:
            return ""
        what = str(found.lastgroup)
        word = _printable(found[what])
        match what:
            case "type" | "path" | "nested" | "bare":
                return self._type(what, word.replace(">", ""), row)
            case "nested_end":
                self.types.set(row, LineType.UNSPECIFIED)
            case "height":
                self.bead_heights.set(row, float(word) * 1e-3)
            case "width":
                self.bead_widths.set(row, float(word) * 1e-3)
            case "tool":
                self.bead_widths.set(row, float(word) * 1e-3)
                self.bead_heights.set(row, float(found["tool_height"]) * 1e-3)
            case "setting" if float(word) > 0.0:
                key = _BY_NAME[found["key"].decode()]
                self.settings.setdefault(key, float(word) * (1.0 if key == "volumetric" else 1e-3))
            case "setting":
                pass  # 0: chosen by the slicer itself
            case "flavour":
                self.settings |= {"volumetric": 1.0} if word == "UltiGCode" else {}
            case "object" | "mesh":
                self._enter(None if word == "NONMESH" else word, row)
            case "object_end":
                self._enter(None, row)
            case _:
                self._layer(what, word, row)
        return ""

    def read_label(self, macro: str, line: bytes, row: int) -> None:
        """Read ``EXCLUDE_OBJECT_START NAME=...`` and ``EXCLUDE_OBJECT_END``. Raises `WordError` as `read` does."""
        named = _LABEL_NAME.search(line)
        if macro == "EXCLUDE_OBJECT_END":
            self._enter(None, row)
        elif macro == "EXCLUDE_OBJECT_START" and named is not None:
            self._enter(_printable(named[named.lastindex or 0]), row)

    def read_m486(self, line: bytes, row: int) -> None:
        """Read ``M486 S3`` (an object begins; -1: none) and ``M486 AName``. Raises `WordError` as `read` does."""
        found = _M486.match(line)
        if found is None:
            return
        if found["index"] is not None:
            number = int(found["index"])
            self._enter(None if number < 0 else str(number), row)
        elif (last := self.objects.last) is not None and last >= 0:
            self.names[int(last)] = _printable(found["name"])

    def _enter(self, key: str | None, row: int) -> None:
        """Begin the object that the file calls *key*; None: none."""
        if key is None:
            self.objects.set(row, -1)
            return
        if key not in self._keys:
            if len(self.names) >= MAX_OBJECTS:
                raise WordError(f"more than {MAX_OBJECTS} objects, the most a file may name")
            self._keys[key] = len(self.names)
            self.names.append(key)
        self.objects.set(row, self._keys[key])

    def _type(self, what: str, word: str, row: int) -> str:
        """Begin moves of the line type *word*; return it where it is not known."""
        kind = line_type(word)
        if kind is None and what == "bare":
            return ""  # a plain comment
        self.types.set(row, LineType.OTHER if kind is None else kind)
        return word if kind is None else ""

    def _layer(self, kind: str, word: str, row: int) -> None:
        """Begin a layer at a marker of the kind that the file uses first; others are plain comments."""
        if kind != "z":
            self.marker = self.marker or kind
            if kind != self.marker:
                return
        layers = self.layers.setdefault(kind, Changes())
        if kind in _BY_HEIGHT:
            if self._heights.get(kind) == float(word):
                return
            self._heights[kind] = float(word)
        counted = kind in _COUNTED or kind in _BY_HEIGHT
        number = int(word) if not counted else 0 if layers.last is None else int(layers.last) + 1
        if abs(number) > MAX_LAYER:
            raise WordError(f"layer {number} is out of range; numbers up to {MAX_LAYER} are allowed")
        layers.set(row, number)


def _printable(name: bytes) -> str:
    """Return a name from a file as one short line."""
    text = name[: 4 * MAX_NAME].decode("utf-8", "replace").strip()
    return "".join(character if character.isprintable() else "?" for character in text)[:MAX_NAME]
