"""Reader of G-code: from a file to a `Toolpath` of straight moves in metres, at the scale of the file.

The file is read in blocks, so that memory depends on the number of moves only. `cablewright.printing.modal` defines the
meaning of the words.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, Final

from cablewright.foundation.errors import InputError
from cablewright.foundation.progress import Progress
from cablewright.foundation.toml_input import open_regular
from cablewright.printing.annotations import slicer_of
from cablewright.printing.gcode_words import MAX_LINE, shortened
from cablewright.printing.modal import Controller
from cablewright.printing.toolpath import Material, Toolpath, build

MAX_BYTES: Final = 1 << 30
SHORTEST_ARC_STEP: Final = 1e-6  # m
SMALLEST_ARC_ERROR: Final = 1e-9  # m

_BLOCK = 1 << 18
_FORMATS = {
    b"GCDE": "binary G-code; export it as text (in PrusaSlicer: Print Settings, Output options, without binary G-code)",
    b"PK\3\4": "a zip archive; unpack it (a .gcode.3mf holds its G-code in Metadata) and give the text file",
}


def parse(
    source: str | Path | BinaryIO,
    arc_step: float = 1e-3,
    progress: Progress | None = None,
    *,
    arc_error: float | None = None,
    material: Material = "E",
) -> Toolpath:
    """Read G-code from a path or an open binary file as a `Toolpath`.

    ``arc_step`` (m, file scale) is the maximum length of the pieces of an arc, ``arc_error`` (m, file scale; default: a
    fiftieth of ``arc_step``) their maximum distance from it. ``material`` is what lays material; a file that never
    extrudes by E is also read by M101 and M103. Layers come from the slicer's markers (`annotations.LAYER_MARKERS`):
    the kind that the file uses first counts, and numbers below 1 shift all so that the lowest is 1. A file without
    markers has one layer per height at which it extrudes, counted upwards; a travel move then belongs to the last
    extruded layer. Raises `InputError`, with the line and what is allowed, for a file that cannot be read, is no
    G-code, is empty, too large, truncated, or lays no material.
    """
    if not SHORTEST_ARC_STEP <= arc_step < float("inf"):
        raise InputError(f"arc_step = {arc_step!r}: must be a length of at least {SHORTEST_ARC_STEP} m")
    error = arc_step / 50 if arc_error is None else arc_error
    if not SMALLEST_ARC_ERROR <= error < float("inf"):
        raise InputError(f"arc_error = {error!r}: must be a length of at least {SMALLEST_ARC_ERROR} m")
    named = isinstance(source, str | Path)
    origin = str(source if named else getattr(source, "name", "G-code"))
    controller = Controller(origin, arc_step, error, "A" if material == "A" else "E")
    if not isinstance(source, str | Path):
        slicer = _read(controller, source, origin, None, progress)
    else:
        with open_regular(Path(source)) as stream:
            slicer = _read(controller, stream, origin, os.fstat(stream.fileno()).st_size, progress)
    return build(controller, origin, material, slicer)


def _read(controller: Controller, stream: BinaryIO, origin: str, size: int | None, progress: Progress | None) -> str:
    """Let *controller* interpret an open file of ``size`` bytes (None: unknown). Returns the slicer that it names."""
    number = 1
    slicer = ""
    for lines, unterminated in _blocks_of_lines(stream, origin, size, progress):
        if number == 1:
            slicer = slicer_of(b"\n".join(lines[:1000]))
        controller.run(lines, number, unterminated)
        number += len(lines)
    return slicer


def _blocks_of_lines(
    stream: BinaryIO, origin: str, size: int | None, progress: Progress | None
) -> Iterator[tuple[list[bytes], bool]]:
    """Yield lists of lines without line ends, and whether the list is an unterminated last line."""
    rest, end = b"", b"\n"
    number = 1
    read = 0
    while block := stream.read(_BLOCK):
        if read == 0:
            _refuse_binary(block, origin)
            block = block.removeprefix(b"\xef\xbb\xbf")
            end = b"\r" if b"\r" in block and b"\n" not in block else b"\n"
        read += len(block)
        if max(read, size or 0) > MAX_BYTES:  # a known size is rejected before reading
            raise InputError(f"{origin}: larger than {MAX_BYTES} bytes, the most a G-code file may hold")
        if b"\0" in block:
            raise InputError(f"{origin}: holds NUL bytes: a binary file, no G-code")
        lines = (rest + block).split(end)
        if max(map(len, lines)) > MAX_LINE:
            lines = [_short(line, origin, at) for at, line in enumerate(lines, number)]
        rest = lines.pop()
        number += len(lines)
        yield lines, False
        if progress is not None:
            progress("reading G-code", read, size or read)
    if read == 0:
        raise InputError(f"{origin}: the file is empty")
    if rest:
        yield [rest], True


def _short(line: bytes, origin: str, number: int) -> bytes:
    """Return a line, or the begin of one, with short comments. Raises `InputError` where it is too long even so."""
    if len(line) > MAX_LINE:
        line = shortened(line)
    if len(line) > MAX_LINE:
        most = f"longer than {MAX_LINE} bytes without its comments, the most a line may hold"
        raise InputError(f"{origin}, line {number}: {most}")
    return line


def _refuse_binary(block: bytes, origin: str) -> None:
    """Raise `InputError` for a known binary format, or if more than a tenth of a file's first block is no text."""
    for begin, reason in _FORMATS.items():
        if block.startswith(begin):
            raise InputError(f"{origin}: {reason}")
    text = block.decode("utf-8", "replace")
    strange = sum(1 for character in text if character == "\ufffd" or (character < " " and character not in "\t\r\n\f"))
    if strange > 0.1 * len(text):
        raise InputError(f"{origin}: a binary file, no G-code")
