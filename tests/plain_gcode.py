"""A second reader of G-code, for tests: plain Python, one rule after the other; it shares nothing with the package.

It reads what the files of `printing/corpus` hold and no more.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass, field


@dataclass
class Reading:
    """What a file lays, mm."""

    extruded: float = 0.0
    travelled: float = 0.0
    extruded_sweep: float = 0.0  # rad, of all arcs with material
    travelled_sweep: float = 0.0
    layers: dict[object, float] = field(
        default_factory=lambda: defaultdict(float)
    )  # extruded length by marker or height
    types: dict[str, float] = field(default_factory=lambda: defaultdict(float))  # extruded length by the slicer's word
    objects: dict[str, float] = field(default_factory=lambda: defaultdict(float))  # extruded length by the file's label


def code_part(line: str) -> str:
    """The line without comments, line number and checksum."""
    depth, kept = 0, ""
    for character in line:
        if depth == 0 and character == ";":
            break
        depth += character == "("
        if depth == 0:
            kept += character
        depth -= character == ")"
    if kept.startswith("N"):
        kept = kept[1:].lstrip("0123456789")
        kept = kept.split("*")[0]
    return kept.strip()


def words_of(code: str) -> list[tuple[str, float | None]]:
    """Letters with their numbers."""
    found, i = [], 0
    while i < len(code):
        letter, i = code[i], i + 1
        begin = i
        while i < len(code) and code[i] in "+-.0123456789":
            i += 1
        if letter.isalpha():
            try:
                found.append((letter.upper(), float(code[begin:i])))
            except ValueError:
                found.append((letter.upper(), None))
    return found


class Layers:
    """The layer at each moment, by whichever marker the file has; None: no marker yet."""

    def __init__(self, lines: list[str]) -> None:
        starts = (
            ";LAYER:",
            ";LAYER_CHANGE",
            "; CHANGE_LAYER",
            "; layer ",
            "; LAYER ",
            "(LAYER ",
            "; BEGIN_LAYER",
            "(<layer>",
        )
        firsts = [start for line in lines for start in starts if line.startswith(start) and "_change" not in line]
        firsts = [first for first in firsts if first != "; layer " or any(", Z = " in line for line in lines)]
        self.start = firsts[0] if firsts else ";Z:" if any(line.startswith(";Z:") for line in lines) else ""
        self.now: object = None
        self.count = 0

    def see(self, line: str) -> None:
        """Begin the next layer where the line is a marker."""
        if self.start and line.startswith(self.start):
            self.count += 1
            self.now = self.count


def label_of(line: str) -> str | None:
    """The object that begins in the line; empty where one ends, None where nothing is said."""
    for start, stop in (("; printing object ", "; stop printing"), ("; start printing object, ", "; stop printing")):
        if line.startswith(start):
            return line[len(start) :]
        if line.startswith(stop):
            return ""
    if line.startswith(";MESH:"):
        return "" if "NONMESH" in line else line[6:]
    if line.startswith("M486 S"):
        return "" if "-" in line else line[6:]
    if line.startswith("EXCLUDE_OBJECT_START"):
        return line.partition("NAME=")[2]
    return None


def type_of(line: str) -> str | None:
    """The word for the type of the following moves, or None."""
    for start in (";TYPE:", "; FEATURE: ", "; feature "):
        if line.startswith(start):
            return line[len(start) :]
    if line.startswith("; '"):
        return line.split("'")[1]
    if line.startswith(("(<perimeter>", "(<infill>")):
        return line.strip("()").replace("<", "").replace(">", "").strip()
    return None


class Machine:
    """The state of a printer, and the material laid so far."""

    def __init__(self, material: str) -> None:
        self.material = material
        self.reading = Reading()
        self.place, self.shift = dict.fromkeys("XYZ", 0.0), dict.fromkeys("XYZ", 0.0)
        self.unit, self.relative, self.relative_e, self.pushed = 1.0, False, False, 0.0
        self.e_chosen = self.pump = False
        self.layer: object = None
        self.label = self.kind = ""

    def obey(self, words: list[tuple[str, float | None]]) -> None:
        """Change the state by one line, whose first word is its command."""
        command, given = f"{words[0][0]}{words[0][1] or 0:g}", dict(words[1:])
        if command in ("G20", "G21"):
            self.unit = 25.4 if command == "G20" else 1.0
        for number in (number for letter, number in words if letter == "G" and number in (90.0, 91.0)):
            self.relative = number == 91.0
            self.relative_e = self.relative_e if self.e_chosen else self.relative
        if command in ("M82", "M83"):
            self.e_chosen, self.relative_e = True, command == "M83"
        if command == self.material and command[0] == "M":
            self.pump = given.get("S") != 0.0
        if (command, self.material) in (("M103", "M101"), ("M5", "M3"), ("M107", "M106")):
            self.pump = False
        if command == "G92":
            self.rename(given)
        if command == "G28":
            self.home([axis for axis in "XYZ" if axis in given] or list("XYZ"))
        if command in ("G0", "G1", "G2", "G3"):
            self.move(command, given)

    def rename(self, given: dict) -> None:
        """G92."""
        for axis in self.place:
            if axis in given or not given:
                self.shift[axis] = self.place[axis] - given.get(axis, 0.0) * self.unit
        if self.material in given or not given:
            self.pushed = given.get(self.material, 0.0) * self.unit

    def home(self, axes: list[str]) -> None:
        """G28."""
        self.reading.travelled += math.dist([self.place[axis] for axis in axes], [0.0] * len(axes))
        for axis in axes:
            self.place[axis] = self.shift[axis] = 0.0

    def grown(self, given: dict) -> float:
        """How much the extruder pushes."""
        if self.material not in given:
            return 0.0
        value = given[self.material] * self.unit
        before, self.pushed = self.pushed, self.pushed + value if self.relative_e else value
        return self.pushed - before if not self.relative_e else value

    def move(self, command: str, given: dict) -> None:
        """G0 to G3."""
        before = dict(self.place)
        for axis in self.place:
            if given.get(axis) is not None:
                self.place[axis] = given[axis] * self.unit + (self.place[axis] if self.relative else self.shift[axis])
        growth = self.grown(given)
        length, sweep = math.dist(before.values(), self.place.values()), 0.0
        if command in ("G2", "G3"):
            length, sweep = arc(before, self.place, given, self.unit, command == "G2")
        if length > 0 and (growth > 0 or self.pump or (self.material == "every G1" and command != "G0")):
            self.reading.extruded += length
            self.reading.extruded_sweep += sweep
            if self.layer is not None:
                number = round(self.place["Z"], 6) if self.layer == "by height" else self.layer
                self.reading.layers[number] += length
            self.reading.types[self.kind] += length
            self.reading.objects[self.label] += length
        else:
            self.reading.travelled += length
            self.reading.travelled_sweep += sweep


def read(data: bytes, material: str = "E") -> Reading:
    """Read a file of which *material* lays: E, A, "every G1", or the code that switches a pump on."""
    lines = data.decode().replace("\r", "").split("\n")
    layers, machine = Layers(lines), Machine(material)
    for line in lines:
        layers.see(line)
        machine.layer = layers.now if layers.start else "by height"
        for name, found in (("label", label_of(line)), ("kind", type_of(line))):
            if found is not None:
                setattr(machine, name, found)
        code = code_part(line)
        words = words_of(code)
        if words and not code[:3].replace("_", "A").isalpha():
            machine.obey(words)
    return machine.reading


def arc(before: dict, after: dict, given: dict, unit: float, clockwise: bool) -> tuple[float, float]:
    """Length (mm) and angle (rad) of an arc, by the angle between its two radii."""
    chord = complex(after["X"] - before["X"], after["Y"] - before["Y"])
    if "R" in given:
        radius = given["R"] * unit
        sweep = 2 * math.asin(min(1.0, abs(chord) / 2 / abs(radius)))
        sweep = sweep if radius > 0 else math.tau - sweep
    else:
        to_start = -complex(given.get("I", 0.0), given.get("J", 0.0)) * unit
        to_end = to_start + chord
        radius = abs(to_start)
        ratio = to_end / to_start
        sweep = math.atan2(ratio.imag, ratio.real) * (-1 if clockwise else 1) % math.tau
        if abs(chord) < 1e-6:
            sweep = math.tau
    sweep += math.tau * (given.get("P", 1.0) - 1)
    return math.hypot(abs(radius) * sweep, after["Z"] - before["Z"]), sweep
