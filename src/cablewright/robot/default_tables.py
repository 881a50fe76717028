"""The tables ``[cable] [sheave] [winch] [line]`` of a robot file: default values of each of its lines."""

from __future__ import annotations

from typing import Any

from cablewright.foundation.errors import InputError, suggestion
from cablewright.foundation.validation import KeyPath, look_up, spell
from cablewright.robot.line import Line
from cablewright.robot.robot import Robot

PARTS = ("cable", "sheave", "winch")
"""Tables of a line that have a default table of the same name."""

LINE_KEYS = tuple(key for key in Line.model_fields if key not in (*PARTS, "name"))
"""Keys that ``[line]`` may give."""

FILE_KEYS = (*(field.alias or name for name, field in Robot.model_fields.items()), *PARTS, "line")

Tables = dict[str, Any]


def merge(document: Tables, origin: str) -> Tables:
    """Return the document with its default tables merged key by key into each line, as `Robot` reads it.

    Raises `InputError` for a default that is no table, or has a key that it cannot have.
    """
    _check(document, origin)
    merged = {key: value for key, value in document.items() if key not in (*PARTS, "line")}
    if isinstance(document.get("lines"), list):
        merged["lines"] = [_merge_line(document, entry) for entry in document["lines"]]
    return merged


def holder(document: Tables, index: int, key: KeyPath) -> KeyPath | None:
    """Return the path of the table in a robot file that sets the ``key`` of line ``index``; None if none does.

    ``key`` is relative to the line: ``("tension_limits",)`` or ``("cable", "breaking_load")``.
    """
    entry = document["lines"][index]
    if key[0] not in PARTS:
        own, default, place = entry, document.get("line", {}), ("line",)
    else:
        own, default, place = entry.get(key[0], {}), document.get(key[0], {}), (key[0],)
        if _replaces(own, default):
            default = {}
    if key[-1] in own:
        return ("lines", index, *key[:-1])
    return place if key[-1] in default else None


def locate(document: Tables, path: KeyPath) -> tuple[KeyPath, str]:
    """Return the place in the file of a key path of the merged document, and a note with the line's name."""
    if len(path) < 3 or path[0] != "lines" or not isinstance(look_up(document, path[:2]), dict):
        return path, ""
    index, key = path[1], path[2:]
    assert isinstance(index, int)
    entry = document["lines"][index]
    note = f" (line {entry['name']!r})" if isinstance(entry.get("name"), str) else ""
    if key[0] not in PARTS:
        shared = holder(document, index, key[:1]) == ("line",)
        return (("line", *key), "") if shared else (path, note)
    whole = key[0] in document and key[0] not in entry
    one = len(key) > 1 and isinstance(entry.get(key[0]), dict) and holder(document, index, key[:2]) == key[:1]
    return (key, "") if whole or one else (path, note)


def _check(document: Tables, origin: str) -> None:
    for key in document:
        if key not in FILE_KEYS:
            raise InputError(f"{origin}: {spell((key,))}: unknown key; {suggestion(key, FILE_KEYS)}")
    for part in (*PARTS, "line"):
        if not isinstance(document.get(part, {}), dict):
            raise InputError(f"{origin}: {part} = {document[part]!r}: must be a table")
    for key in document.get("line", {}):
        if key in (*PARTS, "name"):
            why = "each line has its own" if key == "name" else f"the table [{key}] is for that"
            raise InputError(f"{origin}: line.{key}: cannot be a default here; {why}")


def _merge_line(document: Tables, entry: Any) -> Any:
    if not isinstance(entry, dict):
        return entry
    merged = {**document.get("line", {}), **entry}
    for part in PARTS:
        if part == "winch" and "counterweight" in merged:
            continue
        own, default = entry.get(part, {}), document.get(part)
        if default is not None and isinstance(own, dict) and not _replaces(own, default):
            merged[part] = {**default, **own}
    return merged


def _replaces(own: Tables, default: Tables) -> bool:
    """Whether a line's own sheave is of another kind than the default, which then gives it nothing."""
    return "kind" in own and "kind" in default and own["kind"] != default["kind"]
