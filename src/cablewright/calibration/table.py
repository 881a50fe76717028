"""Tables as text that a stranger wrote: capped, line by line, and refused in one line that says where."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Iterator
from pathlib import Path

from cablewright.errors import InputError
from cablewright.toml_input import read_bytes

__all__ = ["bare", "number", "rows_of"]

_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")


def rows_of(path: Path, most_bytes: int, longest_line: int, what: str) -> Iterator[tuple[int, str]]:
    """Yield number and text of each line that is neither empty nor a comment; *what* it is of is for messages.

    Raises `InputError` where it cannot be read, is too large or has a line that is too long or not UTF-8.
    """
    for number, raw in enumerate(io.BytesIO(read_bytes(path, most_bytes, what)), 1):
        if len(raw) > longest_line:
            raise InputError(f"{path}, line {number}: longer than {longest_line} bytes, the most a line may hold")
        try:
            text = raw.decode("utf-8-sig" if number == 1 else "utf-8").strip(" \r\n")
        except UnicodeDecodeError:
            raise InputError(f"{path}, line {number}: not UTF-8 text; save the table as CSV in UTF-8") from None
        if text and not text.startswith("#"):
            yield number, text


def bare(cell: str) -> str:
    """A cell without blanks and quotes around it."""
    cell = cell.strip()
    return cell[1:-1].strip() if len(cell) > 1 and cell[0] == cell[-1] == '"' else cell


def number(cell: str, place: str, largest: float = math.inf) -> float:
    """The number in a cell. Raises `InputError` that names *place* where it is none, or over *largest* in size."""
    cell = bare(cell)
    value = float(cell) if _NUMBER.fullmatch(cell) else math.nan
    if not abs(value) <= largest:
        shown = repr(cell if len(cell) <= 60 else cell[:57] + "...")
        raise InputError(f"{place} = {shown}: must be a finite number, with a decimal point and without a unit")
    return value
