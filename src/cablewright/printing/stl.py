"""Reader of STL files from any source, binary and text, with bounded memory."""

from __future__ import annotations

import math
import os
from array import array
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.toml_input import open_regular
from cablewright.foundation.triangle_mesh import STL_FACET, TriangleMesh

MAX_TRIANGLES: Final = 2_000_000
MAX_COORDINATE: Final = 1e6  # m, after scaling, so that no computation overflows
MIN_SCALE: Final = 1e-9
_HEADER: Final = 84  # bytes: 80 of anything and the number of triangles
_MAX_LINE: Final = 4096  # bytes
_MAX_TEXT: Final = 400 * MAX_TRIANGLES  # bytes


def read_stl(path: str | Path, scale: float = 1.0) -> TriangleMesh:
    """Read a mesh; its numbers times *scale* are metres in the machine's frame.

    Raises `InputError`, one line, for a file that cannot be read, is truncated, empty, no STL file or has more than
    `MAX_TRIANGLES`, and for numbers that are not finite or too large.
    """
    path = Path(path)
    if not MIN_SCALE <= scale <= 1.0 / MIN_SCALE:
        raise InputError(f"mesh scale {scale:g}: must be from {MIN_SCALE:g} to {1.0 / MIN_SCALE:g}")
    with open_regular(path) as file:
        corners = _read(file, path, os.fstat(file.fileno()).st_size)
    if len(corners) == 0:
        raise InputError(f"{path}: holds no triangle")
    wrong = np.flatnonzero(~(np.abs(corners) <= MAX_COORDINATE / scale).all(axis=(1, 2)))
    if len(wrong):
        limit = f"not finite, or over {MAX_COORDINATE:g} m when scaled"
        raise InputError(f"{path}: triangle {wrong[0] + 1}: a coordinate is {limit}")
    return TriangleMesh.of_corners(corners * scale)


def _read(file: BinaryIO, path: Path, size: int) -> Array:
    """Return triangles (F, 3, 3) of an open file of *size* bytes. Text begins with ``solid``; so do some binaries."""
    header = file.read(_HEADER)
    count = int.from_bytes(header[80:84], "little") if len(header) == _HEADER else -1
    whole = _HEADER + STL_FACET.itemsize * count
    if header.lstrip()[:5].lower() == b"solid" and size != whole:
        file.seek(0)
        return _text(file, path)
    if count < 0:
        raise InputError(f"{path}: {size} bytes, too few for an STL file: its header takes {_HEADER}")
    if count > MAX_TRIANGLES:
        raise InputError(
            f"{path}: its header states {count} triangles; at most {MAX_TRIANGLES} are read: reduce the mesh"
        )
    if size < whole:
        raise InputError(f"{path}: truncated: {count} triangles by its header take {whole} bytes, it has {size}")
    data = file.read(STL_FACET.itemsize * count)
    if len(data) < STL_FACET.itemsize * count:
        raise InputError(f"{path}: truncated while it was read")
    with np.errstate(invalid="ignore"):  # signalling NaN are reported later with other NaN
        return np.frombuffer(data, STL_FACET)["corners"].astype(np.float64)


def _text(file: BinaryIO, path: Path) -> Array:
    """Return triangles (F, 3, 3) of the text form: the three vertices between each ``outer loop`` and ``endloop``."""
    numbers = array("d")
    corners, ended, number, read = -1, False, 0, 0
    while line := file.readline(_MAX_LINE + 1):
        number += 1
        read += len(line)
        if len(line) > _MAX_LINE or read > _MAX_TEXT or len(numbers) > 9 * MAX_TRIANGLES:
            raise InputError(f"{path}, line {number}: too long; at most {_MAX_LINE} bytes, {MAX_TRIANGLES} triangles")
        words = line.split()
        if not words:
            continue
        word = words[0].lower()
        ended = word == b"endsolid"
        if word == b"outer" and corners < 0:
            corners = 0
        elif word == b"vertex" and 0 <= corners < 3:
            numbers.extend(_vertex(words, path, number))
            corners += 1
        elif word == b"endloop" and corners == 3:
            corners = -1
        elif word not in (b"solid", b"facet", b"endfacet", b"endsolid") or corners >= 0:
            shown = line[:40].decode("ascii", "replace").strip()
            raise InputError(f"{path}, line {number}: {shown!r}: must be part of a facet of three vertices")
    if not ended:
        raise InputError(f"{path}: truncated: the last line is no endsolid")
    return np.frombuffer(numbers, np.float64).reshape(-1, 3, 3).copy()


def _vertex(words: list[bytes], path: Path, number: int) -> list[float]:
    try:
        values = [float(word) for word in words[1:]]
    except ValueError:
        values = []
    if len(values) != 3 or not all(map(math.isfinite, values)):
        raise InputError(f"{path}, line {number}: a vertex must be 3 finite numbers")
    return values
