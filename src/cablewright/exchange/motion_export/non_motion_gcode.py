"""Commands of a job's G-code besides motion, such as temperatures, fans and comments, and which targets take them.

Lines of the file that move nothing are written at their position between the points of the motion, if the target has
the command; others are counted. Motors stay on and supply stays on: without them lines go slack and the platform falls.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import printable
from cablewright.printing.gcode_words import MACRO, WordError, bare_text, checksum, code_of, split
from cablewright.printing.job import Job
from cablewright.printing.toolpath import BY_HEIGHT, Toolpath
from cablewright.studies.checks.winch_angles import WinchPath

LONGEST: Final = 250
"""Bytes of a line that RepRapFirmware reads."""

_PRINTERS: Final = frozenset({
    "M104", "M105", "M106", "M107", "M109", "M117", "M118", "M140", "M190", "M221", "M400", "G10", "G11",
})  # fmt: skip
UNDERSTOOD: Final[Mapping[str, frozenset[str]]] = MappingProxyType({
    "reprapfirmware": _PRINTERS | {
        "M42", "M73", "M116", "M141", "M150", "M191", "M200", "M207", "M280", "M291", "M300", "M486", "M568", "M572",
        "T",
    },
    "klipper": _PRINTERS | {"M73"},
    "linuxcnc": frozenset({"M3", "M4", "M5", "M7", "M8", "M9", "M64", "M65"}),
})  # fmt: skip
"""Commands that a target has and that do not move it. ``T``: a tool by any number."""

MACROS: Final = frozenset({
    "EXCLUDE_OBJECT", "EXCLUDE_OBJECT_DEFINE", "EXCLUDE_OBJECT_START", "EXCLUDE_OBJECT_END", "EXCLUDE_OBJECT_RESET",
    "SET_FAN_SPEED", "SET_HEATER_TEMPERATURE", "SET_PRESSURE_ADVANCE", "TEMPERATURE_WAIT", "RESPOND",
})  # fmt: skip
"""Klipper's own commands that move nothing; a macro of another name may do anything."""

NO_MACROS: Final = "P0"
"""What RepRapFirmware takes after a tool's number for running none of the macros of a change, which may move."""

HARMFUL: Final[Mapping[str, str]] = MappingProxyType(
    {
        code: why
        for why, codes in {
            "motors stay on: without them lines go slack": ("M18", "M84"),
            "supply stays on: without it lines go slack": ("M80", "M81", "M112", "M999"),
            "limits of the motion are the job's own": ("M201", "M203", "M204", "M205", "M566", "M220"),
            "the geometry is that of the robot": ("M206", "M208", "M501", "M502", "M665", "M666", "M669", "M92"),
            "it may move the platform": ("G29", "G30", "G32", "M98", "M290"),
        }.items()
        for code in codes
    }
)

_TEXTS: Final = ("M0", "M1", "M117", "M118", "M291", "M486")
"""Commands whose words are text up to the end of the line."""

_WORDS: Final[Mapping[str, Mapping[str, str]]] = MappingProxyType(
    {
        "reprapfirmware": {"G10": "PRS", "M207": "FPRST"},
        "klipper": {"G10": "", "G11": ""},
        "linuxcnc": {"": "PQS"},
    }
)
"""Letters that a command may have: with others it moves axes, or their zero. ``""``: of each command."""

_MOTION: Final = frozenset({
    "G0", "G1", "G2", "G3", "G4", "G17", "G20", "G21", "G28", "G40", "G43", "G49", "G54", "G61", "G64", "G80", "G90",
    "G91", "G92", "G94", "G53", "M70", "M71", "M72", "M82", "M83", "M120", "M121",
})  # fmt: skip
"""Codes that the path covers, or that the export writes itself."""


_ACTIVE: Final = re.compile(r"[;\s]*(?:py|msg|debug|print|log\w*|probe\w*|abort)\s*,", re.IGNORECASE | re.ASCII)
"""Comments that LinuxCNC executes."""


@dataclass(frozen=True, eq=False)
class Beside:
    """Lines of a job's G-code file other than motion, for one export target.

    ``dropped``: number of dropped lines by code, counted as lines are read. ``feeds``: (k,) mm of filament that each
    piece of the path feeds; None where E is mm of strand. ``whole``: whether comments are kept, as when the whole job
    is exported. ``has_layers``: whether comments mark the layers.
    """

    source: Path | None
    target: str
    feeds: Array | None
    alone: tuple[tuple[int, float, float], ...]  # line of the file, mm of filament, mm/min of a feed without motion
    whole: bool
    has_layers: bool
    dropped: dict[str, int] = field(default_factory=dict)

    def lines(self) -> Iterator[tuple[int, str]]:
        """Yield the G-code lines without motion, with the number of the file's line that each is of, in order."""
        alone = iter((*self.alone, (1 << 62, 0.0, 0.0)))
        number, fed, speed = next(alone)
        if self.source is not None:
            with self.source.open(encoding="utf-8-sig", errors="replace", newline="\n") as stream:
                for at, raw in enumerate(
                    (line for each in stream for line in ([each] if "\n" in each else each.split("\r"))), 1
                ):
                    while number < at or (number == at and self.feeds is not None):
                        yield number, _feed(fed, speed)
                        number, fed, speed = next(alone)
                    is_comment = raw.lstrip().startswith((";", "("))
                    kept = self._kept(raw.strip()) if self.whole or not is_comment else ""
                    if kept:
                        yield at, kept
        while number < 1 << 62:
            yield number, _feed(fed, speed)
            number, fed, speed = next(alone)

    def _kept(self, raw: str) -> str:
        """Return a line as the target has it; empty where it has none."""
        if raw.startswith(";"):
            return "" if self.target == "linuxcnc" and _ACTIVE.match(raw) else printable(raw)[:LONGEST] + "\n"
        try:
            text = bare_text(raw.encode())
        except WordError:  # of a checksum: the toolpath was read, so that this is no motion
            return ""
        if not text:
            return f"; {printable(raw)[:LONGEST]}\n" if raw else ""
        if (macro := MACRO.match(text)) is not None:
            if self.target == "klipper" and macro[0] in MACROS:
                return printable(raw.partition(";")[0].strip()) + "\n"
            return self._drop(macro[0])
        words = split(text)[0]
        heads = [
            k for k, (letter, digits) in enumerate(words) if digits and (letter in "GM" or (letter, k) == ("T", 0))
        ]
        if heads and code_of(*words[heads[0]]) in _TEXTS:
            heads = heads[:1]
        parts = [words[k:end] for k, end in zip(heads, [*heads[1:], len(words)], strict=True)]
        kept = [part for part in parts if self._is_kept(part)]
        if self.target == "reprapfirmware":
            kept = [[part[0], (NO_MACROS[0], NO_MACROS[1:])] if part[0][0] == "T" else part for part in kept]
        if kept == parts and heads == [0]:
            return printable(_bare(raw))[:LONGEST] + "\n"
        return "".join(f"{' '.join(letter + digits for letter, digits in part)}\n" for part in kept)

    def _is_kept(self, part: list[tuple[str, str]]) -> bool:
        """Return whether the target has a command, a code and its words, that does not move it; count it if not."""
        code = code_of(*part[0])
        known = "T" if code[0] == "T" else code
        if known in _MOTION:
            return False
        letters = {letter for letter, _ in part[1:]}
        allowed = _WORDS[self.target].get(known, _WORDS[self.target].get("", letters))
        if known in UNDERSTOOD[self.target] and letters <= {*allowed}:
            return True
        self._drop(code)
        return False

    def _drop(self, code: str) -> str:
        self.dropped[code] = self.dropped.get(code, 0) + 1
        return ""

    def notes(self) -> Iterator[str]:
        """Yield sentences on the codes that were dropped, once all lines are read."""
        by_reason: dict[str, list[str]] = {}
        for code, count in self.dropped.items():
            why = HARMFUL.get(code, f"{self.target} has no such command, or it may move the platform")
            by_reason.setdefault(why, []).append(f"{code} ({count})")
        for why, codes in by_reason.items():
            yield f"job: {', '.join(codes)}: {why}"


def beside(job: Job, path: WinchPath, target: str) -> Beside:
    """Return the lines of a *job*'s file other than motion along *path*, for a *target* of `UNDERSTOOD`.

    E is filament as the file has it where its own axis extrudes and the job has no scale; else E is mm of strand.
    """
    toolpath = path.toolpath
    filament = job.gcode is not None and toolpath.material_by in ("E", "A") and job.scale == 1.0
    feeds = _feeds(path, toolpath) if filament and target != "linuxcnc" else None
    alone = np.flatnonzero((toolpath.extrusion != 0.0) & (toolpath.length == 0.0)) if feeds is not None else ()
    first, last = (int(path.samples.line.min()), int(path.samples.line.max())) if path.is_part else (0, 1 << 62)
    found = tuple(
        (int(toolpath.line[row]), 1e3 * float(toolpath.extrusion[row]), 6e4 * float(toolpath.feed[row]))
        for row in alone
        if first <= toolpath.line[row] <= last
    )
    return Beside(
        job.gcode, target, feeds, found, not path.is_part, not path.is_part and toolpath.layers_by != BY_HEIGHT
    )


def _feeds(path: WinchPath, toolpath: Toolpath) -> Array:
    """Return how much filament, mm, each piece (k,) of the path feeds: a share of its move's, by length."""
    move = path.samples.move
    ways = np.diff(path.samples.distance, prepend=0.0)
    whole = np.bincount(move, weights=ways, minlength=len(toolpath.line))
    share = np.divide(ways, whole[move], out=np.zeros_like(ways), where=whole[move] > 0.0)
    total = np.cumsum(1e3 * share * toolpath.extrusion[move])
    return np.diff(np.round(total, 5), prepend=0.0)  # rounded sums: the digits that are written add up


def _feed(fed: float, speed: float) -> str:
    return f"G1 E{fed:.5f}{f' F{speed:.3f}' if np.isfinite(speed) else ''}\n"


def _bare(raw: str) -> str:
    """Return a line without its comment, number and checksum; the text of a message stays unchanged."""
    found = checksum(text := raw.partition(";")[0])
    return re.sub(r"^\s*N\s*[0-9]+\s*", "", text[: found.start()] if found else text, flags=re.IGNORECASE).strip()
