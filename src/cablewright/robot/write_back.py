"""Update of a robot file with changed values: comments, units and unchanged values stay."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError

from cablewright.foundation.errors import InputError
from cablewright.foundation.units import respell
from cablewright.foundation.validation import KeyPath, look_up
from cablewright.robot.default_tables import PARTS, holder
from cablewright.robot.files import loads
from cablewright.robot.robot import Robot

_ORIGIN = "the file to update"


def update(text: str, robot: Robot) -> str:
    """Return the ``text`` of a robot file with the values of ``robot``.

    A changed value keeps its unit and its comment. A value from a default table is changed there if it is the same for
    all lines that take it, else in the lines. Raises `InputError` if the text is not a robot file, or if more than
    values differs (lines added or removed, a default that one line no longer has).
    """
    before, after = loads(text, _ORIGIN).model_dump(), robot.model_dump()
    try:
        document = tomlkit.parse(text)
        for path, value in _places(document, before, after):
            _put(document, path, value)
        result = document.as_string()
    except TOMLKitError as error:
        raise InputError(f"{_ORIGIN}: its TOML cannot be changed: {error}; edit the file by hand") from None
    if loads(result, _ORIGIN) != robot:
        raise InputError(f"{_ORIGIN}: the robots differ in more than values; edit the file by hand")
    return result


def _places(document: Any, before: Any, after: Any) -> Iterator[tuple[KeyPath, Any]]:
    """Yield the key paths in the document to set, and their values."""
    if len(before["lines"]) != len(after["lines"]):
        raise InputError(f"{_ORIGIN}: has {len(before['lines'])} lines, the robot has {len(after['lines'])}")
    inherited: dict[KeyPath, dict[int, Any]] = {}
    for path, value in _changes(before, after):
        if path[0] != "lines":
            yield _as_written(document, path, value, after)
            continue
        index, key = path[1], path[2 : 4 if path[2] in PARTS else 3]
        assert isinstance(index, int)
        home = holder(document, index, key)
        if home is not None and home[0] == "lines":
            yield path, value
        else:
            inherited.setdefault(key, {})[index] = look_up(after, ("lines", index, *key))
    for key, values in inherited.items():
        yield from _inherited_places(document, len(after["lines"]), key, values)


def _as_written(document: Any, path: KeyPath, value: Any, after: Any) -> tuple[KeyPath, Any]:
    """Return key path and value; those of the whole list where the file does not give the list."""
    for end, part in enumerate(path):
        if isinstance(part, int) and look_up(document, path[:end]) is None:
            return path[:end], look_up(after, path[:end])
    return path, value


def _inherited_places(document: Any, m: int, key: KeyPath, values: dict[int, Any]) -> Iterator[tuple[KeyPath, Any]]:
    """Yield the default's key path if all lines that take it have one new value, else those of the lines."""
    homes = {index: holder(document, index, key) for index in range(m)}
    home = homes[next(iter(values))]
    heirs = {index for index in range(m) if homes[index] == home}
    first = next(iter(values.values()))
    if home is not None and heirs == set(values) and all(value == first for value in values.values()):
        yield (*home, key[-1]), first
        return
    for index, value in values.items():
        like = look_up(document, (*(homes[index] or ()), key[-1]))
        yield ("lines", index, *key), _spelled(value, like)


def _changes(before: Any, after: Any, path: KeyPath = ()) -> Iterator[tuple[KeyPath, Any]]:
    """Yield the key paths of values that differ, with the new values; None where a key is gone."""
    if before == after:
        return
    if isinstance(before, dict) and isinstance(after, dict):
        for key in dict.fromkeys([*before, *after]):
            yield from _changes(before.get(key), after.get(key), (*path, key))
    elif isinstance(before, tuple) and isinstance(after, tuple) and len(before) == len(after):
        for index, pair in enumerate(zip(before, after, strict=True)):
            yield from _changes(*pair, (*path, index))
    else:
        yield path, after


def _put(document: Any, path: KeyPath, value: Any) -> None:
    """Set the value at a path in the unit of the present value, or remove it for None."""
    *parents, last = path
    table = document
    for part in parents:
        if isinstance(part, str) and part not in table:
            table[part] = tomlkit.inline_table()
        table = table[part]
    if value is not None:
        table[last] = _spelled(value, look_up(table, (last,)))
    elif last in table:
        table.remove(last)


def _spelled(value: Any, like: Any) -> Any:
    """Return ``value`` in the units of ``like``, where it has any, and without keys whose value is None."""
    if isinstance(value, dict):
        return {key: _spelled(entry, look_up(like, (key,))) for key, entry in value.items() if entry is not None}
    if isinstance(value, tuple):
        likes = like if isinstance(like, list) and len(like) == len(value) else [None] * len(value)
        return [_spelled(*pair) for pair in zip(value, likes, strict=True)]
    return respell(value, like) if isinstance(value, float) and isinstance(like, str) else value
