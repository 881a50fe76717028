"""Reads text dumps of laser scans, as ``ros2 topic echo`` and ``rostopic echo`` print them: a plain subset of YAML."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

from cablewright.foundation.csv_input import shown
from cablewright.foundation.errors import InputError

BEGINS: Final = re.compile(rb"\s*(?:---\s|[A-Za-z_]\w*:(?:\s|$))")
"""How such a dump begins."""

_ENTRY = re.compile(r" *(?:- )?([A-Za-z_]\w*): *(.*)")
_ITEM = re.compile(r" *- *(.*)")


def read_dumps(path: Path, data: bytes) -> list[dict[str, Any]]:
    """Return the messages in *data*: numbers, texts and lists by key; nested keys (``header: frame_id:``) are flat.

    Raises `InputError` for a line that is none of these, and for lists that were cut short.
    """
    try:
        lines = data.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise InputError(f"{path}: not UTF-8 text") from None
    messages: list[dict[str, Any]] = [{}]
    items: list[Any] | None = None  # of the list that lines with a dash continue
    key = ""
    for number, line in _whole_lines(path, lines):
        if line.strip() in ("---", "..."):
            messages.append({})
            items = None
        elif (entry := _ENTRY.fullmatch(line)) is not None:
            key, value, items = entry[1], entry[2], None
            if value:
                messages[-1][key] = _listed(path, key, value) if value.startswith("[") else _scalar(path, key, value)
            else:
                items = messages[-1].setdefault(key, [])
        elif isinstance(items, list) and (item := _ITEM.fullmatch(line)) is not None:
            items.append(_scalar(path, key, item[1]))
        else:
            raise InputError(f"{path}, line {number}: {shown(line.strip())}: expected KEY: VALUE, or - VALUE of a list")
    return [each for each in messages if each]


def _whole_lines(path: Path, lines: list[str]) -> Iterator[tuple[int, str]]:
    """Number and text of lines that say something, a list in brackets as one."""
    parts: list[str] = []
    begin = 0
    for number, line in enumerate(lines, 1):
        text = line.rstrip()
        if parts:
            parts.append(text.strip())
        elif not text or text.lstrip().startswith("#"):
            continue
        elif "[" in text and not text.endswith("]"):
            parts, begin = [text], number
        else:
            yield number, text
        if parts and text.endswith("]"):
            yield begin, " ".join(parts)
            parts = []
    if parts:
        raise InputError(f"{path}, line {begin}: {shown(parts[0].strip())}: the list has no end")


def _listed(path: Path, key: str, text: str) -> list[Any]:
    cells = [cell.strip() for cell in text.strip("[] ").split(",")]
    return [_scalar(path, key, cell) for cell in cells if cell]


def _scalar(path: Path, key: str, text: str) -> float | str:
    """Return a number, or the text without its quotes."""
    bare = text.strip().strip("\"'")
    if bare == "...":
        raise InputError(f"{path}: {key} is cut short by '...'; dump all of it, as with ros2 topic echo --full-length")
    number = bare.replace(".inf", "inf").replace(".nan", "nan").replace(".NaN", "nan").replace(".Inf", "inf")
    try:
        return float(number) if len(number) <= 40 and "_" not in number else bare
    except ValueError:
        return bare
