"""The straight moves of a part, at the scale of its file, with the notes of the file on each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError
from cablewright.printing.annotations import LAYER_MARKERS, Annotations
from cablewright.printing.line_types import LineType
from cablewright.printing.modal import COLUMNS, Controller

Material = Literal["E", "A", "M101", "M106", "M3", "every G1"]
"""What lays material: an axis that extrudes, a switch while it is on (M106 and M107, M3 and M5), every G1 to G3."""

BY_HEIGHT: Final = "height"  # `Toolpath.layers_by` of a file without layer markers

_HEIGHT_GRAIN = 1e-6  # m, resolution of heights in files without layer markers
_BEYOND = 0.1  # of the longer side of the part in plan view: travel farther out than this leaves the part
_CODES: Final = {"M101": ("M101", "M102", "M103"), "M106": ("M106", "M107"), "M3": ("M3", "M4", "M5", "S")}


@dataclass(frozen=True, eq=False)
class Toolpath:
    """The k straight moves of a file, each from the end of the previous one. Read-only arrays.

    A move of zero length is kept where the file extrudes or dwells on the spot.
    """

    start: Array  # (k, 3) m, file scale
    end: Array  # (k, 3) m, file scale
    extrusion: Array  # (k,) m of filament, negative: retracted; without an axis that extrudes, m of path
    feed: Array  # (k,) m/s, file scale; inf before the first F
    dwell: Array  # (k,) s waited at the end of the move
    layer: NDArray[np.int32]  # (k,) from 1; 0 before the first layer
    line: NDArray[np.int32]  # (k,) line of the file, from 1
    kind: NDArray[np.int8]  # (k,) `LineType`
    object: NDArray[np.int32]  # (k,) index into `objects`; -1: none
    bead_width: Array  # (k,) m, file scale, as the file's comments say; NaN where they do not
    bead_height: Array  # (k,) m, file scale, likewise
    homing: Mask  # (k,) whether the move is that of a G28
    objects: tuple[str, ...]  # names of the objects that the file labels
    layers_by: str  # the layer marker of the file, or `BY_HEIGHT`
    material_by: Material
    slicer: str  # program and version that the file names; empty if none
    settings: dict[str, float]  # of the slicer, m, see `annotations.SETTINGS`
    unknown: dict[str, int]  # ignored words, and how often each occurs
    whole: Toolpath | None = None  # of which these are some moves; None: these are all
    first: int = 0  # number of the first of them, from 0

    def part(self, first: int, last: int) -> Toolpath:
        """Return the moves from number *first* to before *last*."""
        columns: dict[str, Any] = {each.name: getattr(self, each.name) for each in fields(self)}
        taken = {name: value[first:last] for name, value in columns.items() if isinstance(value, np.ndarray)}
        return Toolpath(**columns | taken | {"whole": self, "first": first})

    def first_at(self, height: float) -> int:
        """Return the number of the first move towards the first layer at a *height*, m, file scale, or above it.

        It is the number of all moves where no layer is there. Raises `InputError` where material is laid below the
        height after that: the part is not printed layer by layer.
        """
        laid = np.flatnonzero(self.extruding)
        above = laid[self.end[laid, 2] >= height - _HEIGHT_GRAIN]
        if not len(above):
            return len(self.end)
        layer = int(self.layer[above[0]])
        begin = int(laid[np.argmax(self.layer[laid] == layer)])
        late = laid[(laid >= begin) & (self.layer[laid] != layer) & (self.end[laid, 2] < height - _HEIGHT_GRAIN)]
        if len(late):
            raise InputError(
                f"line {self.line[late[0]]}: lays material at {self.end[late[0], 2]:g} m of the file, after a layer at "
                f"{height:g} m or more: only parts that grow layer by layer are divided by height"
            )
        before = laid[laid < begin]
        return int(before[-1]) + 1 if len(before) else 0

    def along(self, x: Sequence[float], y: Sequence[float]) -> Toolpath:
        """Return the moves with X and Y along two unit vectors, and without Z."""
        axes = np.array([x, y])
        return replace(self, start=self.start[:, :2] @ axes, end=self.end[:, :2] @ axes)

    @cached_property
    def length(self) -> Array:
        """Length (k,) of each move, m, file scale."""
        return np.asarray(np.linalg.norm(self.end - self.start, axis=1))

    @cached_property
    def extruding(self) -> Mask:
        """(k,) whether the move lays material: it has a length and a positive extrusion."""
        return np.asarray((self.extrusion > 0) & (self.length > 0))

    @property
    def layer_count(self) -> int:
        """Number of layers with material."""
        numbers = np.unique(self.layer[self.extruding])
        return int(np.count_nonzero(numbers > 0))

    @cached_property
    def in_part(self) -> Mask:
        """(k,) whether the move belongs to the part.

        Outside are: what precedes the first and follows the last material of a layer, G28 and the way back from it, and
        travel that begins or ends beyond the part in plan view by more than a tenth of its longer side (parking).
        """
        laying = self.extruding & (self.layer > 0)
        if not laying.any():
            return laying
        number = np.arange(len(laying))
        since_laid = np.maximum.accumulate(np.where(laying, number, -1))
        since_home = np.maximum.accumulate(np.where(self.homing, number, -1))
        inside = (number <= since_laid[-1]) & (since_laid >= 0) & (since_home <= since_laid)
        low = np.minimum(self.start, self.end)[laying, :2].min(axis=0)
        high = np.maximum(self.start, self.end)[laying, :2].max(axis=0)
        margin = _BEYOND * (high - low).max()
        for ends in (self.start[:, :2], self.end[:, :2]):
            inside &= laying | ((ends >= low - margin) & (ends <= high + margin)).all(axis=1)
        return np.asarray(inside)


def build(controller: Controller, origin: str, material: Material, slicer: str) -> Toolpath:
    """Return the toolpath from moves that the *controller* recorded. Raises `InputError` where no material is laid.

    A file that never extrudes by E, but switches its extruder by M101 and M103, is read by those.
    """
    rows = np.asarray(controller.rows).reshape(-1, COLUMNS)
    line = np.array(controller.lines, dtype=np.int32)
    k = len(line)
    bad = np.flatnonzero(~np.isfinite(rows[:, 3]))
    if len(bad) > 0:
        raise InputError(f"{origin}, line {line[bad[0]]}: E is too large")
    points = np.zeros((k + 1, 3))
    points[1:] = rows[:, :3]
    length = np.linalg.norm(np.diff(points, axis=0), axis=1)
    homing = controller.homing.spread(k, 0.0) > 0.0
    extrusion = rows[:, 3].copy()
    if material == "E" and len(controller.switches["M101"]) and not (extrusion > 0).any():
        material = "M101"
    if material == "every G1":
        extrusion = np.where(controller.rapid.spread(k, 0.0) > 0.0, 0.0, length)
    elif material in _CODES:
        extrusion = np.where(controller.switches[material].spread(k, 0.0) > 0.0, length, 0.0)
        extrusion *= controller.switches["S"].spread(k, 1.0) if material == "M3" else 1.0
    if material not in ("E", "A"):
        extrusion[homing] = 0.0
    extruding = (extrusion > 0) & (length > 0)
    if not extruding.any():
        raise InputError(f"{origin}: {_why_nothing(controller, material)}")
    dwell = np.zeros(k)
    for row, seconds in controller.dwells:
        dwell[row] = seconds
    notes = controller.notes
    layer, layers_by = _layers(notes, points[1:, 2], extruding)
    kind = notes.types.spread(k, LineType.UNSPECIFIED)
    before = (layer < 1) | (layers_by == BY_HEIGHT and bool(notes.layers))  # the first marker with material after it
    kind[(kind == LineType.UNSPECIFIED) & before] = LineType.PRIME
    kind[~extruding] = LineType.TRAVEL
    columns: dict[str, Any] = {
        "extrusion": extrusion,
        "feed": rows[:, 4].copy(),
        "dwell": dwell,
        "layer": layer,
        "line": line,
        "kind": kind.astype(np.int8),
        "object": notes.objects.spread(k, -1.0).astype(np.int32),
        "bead_width": notes.bead_widths.spread(k, np.nan),
        "bead_height": notes.bead_heights.spread(k, np.nan),
        "homing": homing,
    }
    for column in (points, *columns.values()):
        column.setflags(write=False)
    return Toolpath(
        start=points[:-1],
        end=points[1:],
        **columns,
        objects=tuple(notes.names),
        layers_by=layers_by,
        material_by=material,
        slicer=slicer,
        settings=notes.settings,
        unknown={word: n for word, n in controller.unknown.items() if word not in _CODES.get(material, ())},
    )


def _layers(notes: Annotations, height: Array, extruding: Mask) -> tuple[NDArray[np.int32], str]:
    """Return the layer of each move (k,), and what it comes from: a marker that has material after it, or heights."""
    k = len(height)
    for marker in (notes.marker, "z"):
        changes = notes.layers.get(marker)
        if changes is None or not len(changes) or not extruding[changes.rows[0] :].any():
            continue
        shift = max(0.0, 1.0 - min(changes.values))  # many slicers count from 0, and a raft has negative numbers
        layer = np.where(np.arange(k) < changes.rows[0], 0.0, changes.spread(k, 0.0) + shift)
        return layer.astype(np.int32), LAYER_MARKERS[marker]
    grains = np.round(height[extruding] / _HEIGHT_GRAIN)
    layer = np.zeros(k, dtype=np.int32)
    layer[extruding] = np.unique(grains, return_inverse=True)[1] + 1
    last = np.maximum.accumulate(np.where(extruding, np.arange(k), -1))
    return np.where(last >= 0, layer[last], 0).astype(np.int32), BY_HEIGHT


def _why_nothing(controller: Controller, material: Material) -> str:
    """Return why no move lays *material*, and which materials the file has instead."""
    if material in ("E", "A"):
        why = f"no extruding move; at least one move must increase {material}"
    elif material == "every G1":
        why = "no G1, G2 or G3 has a length"
    else:
        why = f"no move while {material} is on{', by P0 or without P' if material == 'M106' else ''}"
    found = [name for name, changes in controller.switches.items() if len(changes) and name not in (material, "S")]
    found += [letter for letter in ("A", "E") if letter in controller.unknown and letter != material]
    if not found:
        return why
    offered = " or ".join(f'material = "{name}"' for name in get_args(Material) if name in found)
    return f"{why}. The file has {', '.join(found)}: in a job file, {offered} lays material by it"
