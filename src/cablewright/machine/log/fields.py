"""Kinds of values in a log's messages: the JSON schema of each, and its conversions from and to Python."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from enum import StrEnum
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import (
    Condition,
    DriveState,
    Fault,
    Notice,
    OrderKind,
    PrintState,
    WinchMode,
    frozen,
)

_MAX_NUMBERS: Final = 100_000  # in one array of a message
_MAX_TEXT: Final = 300  # letters
_MAX_SUBJECT: Final = 60  # letters
_MAX_ARGUMENTS: Final = 100  # of an order or a command
_COVARIANCE: Final = 9  # rows of an estimate's covariance


def object_schema(**properties: Any) -> dict[str, Any]:
    """Return the JSON schema of an object."""
    return {"type": "object", "properties": properties}


def array_schema(of: Any) -> dict[str, Any]:
    """Return the JSON schema of an array."""
    return {"type": "array", "items": of}


def as_it_is(value: Any) -> Any:
    """Return the value unchanged: it is JSON already."""
    return value


class FieldKind(NamedTuple):
    """A kind of value in a log's messages.

    ``read`` converts a JSON value, None for a missing key; it raises `ValueError`, a sentence. ``write`` returns None
    for a value that leaves its key out.
    """

    schema: dict[str, Any]
    read: Callable[[Any], Any]
    write: Callable[[Any], Any] = as_it_is


def read_object(kinds: Mapping[str, FieldKind], values: Any) -> dict[str, Any]:
    """Return the values of a JSON object by key. Raises `ValueError`, which names the key."""
    if not isinstance(values, dict):
        raise ValueError("an object is expected")
    found = {}
    for key, kind in kinds.items():
        try:
            found[key] = kind.read(values.get(key))
        except ValueError as reason:
            raise ValueError(f"{key}: {reason}") from None
    return found


def _is_finite(value: float) -> bool:
    """Whether a number of JSON is finite and no longer than a float or a counter holds."""
    return abs(value) < 2**63 if isinstance(value, int) else math.isfinite(value)


def _number(value: Any) -> float:
    if type(value) not in (int, float) or not _is_finite(value):
        raise ValueError("a finite number is expected")
    return float(value)


def _of(kind: type, what: str) -> Callable[[Any], Any]:
    """Return a reader of values of exactly that type."""

    def read(value: Any) -> Any:
        if type(value) is not kind:
            raise ValueError(f"{what} is expected")
        return value

    return read


def _text(value: Any) -> str:
    if not isinstance(value, str) or len(value) > _MAX_TEXT:
        raise ValueError(f"a text of at most {_MAX_TEXT} letters is expected")
    return value


def _fitting(text: str, letters: int) -> str:
    return text[:letters].encode("utf-8", "replace").decode()


def _choice(choices: type[StrEnum], what: str) -> FieldKind:
    """Return the kind of one of the *choices*, by its value."""

    def read(value: Any) -> Any:
        if _text(value) not in choices.__members__.values():
            raise ValueError(f"unknown {what} {value[:60]!r}")
        return choices(value)

    return FieldKind({"type": "string"}, read)


def _tuple_of(kind: FieldKind, what: str, *, optional: bool = False) -> FieldKind:
    """Return the kind of a tuple of values of one *kind*; an *optional* empty one is left out."""

    def read(values: Any) -> tuple[Any, ...]:
        return () if optional and values is None else tuple(map(kind.read, _list(values, (str, bool), what)))

    return FieldKind(array_schema(kind.schema), read, lambda values: list(values) if values or not optional else None)


def _arguments(value: Any) -> dict[str, tuple[float, ...]]:
    if not isinstance(value, dict) or len(value) > _MAX_ARGUMENTS:
        raise ValueError("an object of lists of numbers is expected")
    return {_text(key): tuple(_numbers_or_nan(each).tolist()) for key, each in value.items()}


def _numbers_by_name(value: Any) -> dict[str, float]:
    if value is not None and (not isinstance(value, dict) or len(value) > _MAX_ARGUMENTS):
        raise ValueError("an object of numbers is expected")
    return {_text(key): _number(each) for key, each in (value or {}).items()}


def _list(value: Any, types: Iterable[type], what: str) -> list[Any]:
    if not isinstance(value, list) or len(value) > _MAX_NUMBERS or not set(map(type, value)) <= set(types):
        raise ValueError(f"a list of {what} is expected")
    return value


def _numbers(value: Any, types: Iterable[type] = (int, float), what: str = "numbers") -> Array:
    """Return a list as floats, read-only; null is NaN, and nothing else is."""
    values = _list(value, types, what)
    try:
        found = np.array(values, dtype=np.float64)
    except OverflowError:
        raise ValueError(f"a list of {what} is expected") from None
    if np.count_nonzero(np.isfinite(found)) + values.count(None) < len(values):
        raise ValueError(f"a list of {what} is expected")
    found.flags.writeable = False
    return found


def _numbers_or_nan(value: Any) -> Array:
    return _numbers(value, (int, float, type(None)), "numbers or null")


def _place(value: Any) -> Array:
    found = _numbers(value)
    if len(found) != 3:
        raise ValueError("3 numbers are expected")
    return found


def _counts(value: Any) -> NDArray[np.int64]:
    if not all(map(_is_finite, _list(value, (int,), "whole numbers"))):
        raise ValueError("a list of whole numbers is expected")
    found = np.array(value, dtype=np.int64)
    found.flags.writeable = False
    return found


def _covariance(value: Any) -> Array | None:
    found = _numbers(value)
    if len(found) not in (0, _COVARIANCE**2):
        raise ValueError(f"none or {_COVARIANCE**2} numbers are expected")
    return frozen(found.reshape(_COVARIANCE, _COVARIANCE)) if len(found) else None


def _notice(value: Any) -> Notice:
    name = value.get("condition") if isinstance(value, dict) else None
    if not isinstance(name, str) or name not in Condition.__members__:
        raise ValueError(f"unknown condition {str(name)[:60]!r}")
    return Notice(Condition[name], str(value.get("whose", ""))[:_MAX_SUBJECT])


def listed(values: Any) -> Any:
    """Return an array, or another sequence, as a list."""
    return values.tolist() if isinstance(values, np.ndarray) else np.asarray(values).tolist()


def _vector(names: str) -> FieldKind:
    """Return the kind of a vector that is an object, with a number under each letter of *names*."""
    kinds = dict.fromkeys(names, NUMBER)
    return FieldKind(
        object_schema(**dict.fromkeys(names, NUMBER.schema)),
        lambda value: frozen(list(read_object(kinds, value).values())),
        lambda values: dict(zip(names, listed(values), strict=True)),
    )


NUMBER: Final = FieldKind({"type": "number"}, _number)
NUMBER_OR_NAN: Final = FieldKind(
    {"type": ["number", "null"]}, lambda value: math.nan if value is None else _number(value)
)
NUMBER_OR_NOTHING: Final = NUMBER_OR_NAN._replace(write=lambda value: None if math.isnan(value) else value)
"""NaN is left out."""
WHOLE_NUMBER: Final = FieldKind({"type": "integer"}, _of(int, "a whole number"))
FLAG: Final = FieldKind({"type": "boolean"}, _of(bool, "true or false"))
TEXT: Final = FieldKind({"type": "string"}, _text, lambda text: _fitting(text, _MAX_TEXT))
"""Texts that come from anywhere are cut, and written without what no JSON holds."""
STATE: Final = _choice(PrintState, "state")
ORDER: Final = _choice(OrderKind, "order")
ARGUMENTS: Final = FieldKind(
    {"type": "object"}, _arguments, lambda values: {TEXT.write(key): list(each) for key, each in values.items()}
)
NUMBERS_BY_NAME: Final = FieldKind({"type": "object"}, _numbers_by_name, lambda values: dict(values) or None)
MODES: Final = _tuple_of(_choice(WinchMode, "winch mode"), "winch modes", optional=True)
DRIVE_STATES: Final = _tuple_of(_choice(DriveState, "state of a drive"), "states of drives")
NUMBERS: Final = FieldKind(array_schema(NUMBER.schema), _numbers, listed)
NUMBERS_OR_NAN: Final = FieldKind(array_schema(NUMBER_OR_NAN.schema), _numbers_or_nan, listed)
NUMBERS_OR_NONE: Final = FieldKind(
    NUMBERS_OR_NAN.schema,
    lambda value: None if value is None else _numbers_or_nan(value),
    lambda values: None if values is None else listed(values),
)
TEXTS: Final = _tuple_of(TEXT, "texts")._replace(write=lambda texts: [_fitting(text, _MAX_TEXT) for text in texts])
CLOSED: Final = _tuple_of(FLAG, "true or false")
PLACE: Final = FieldKind(NUMBERS.schema, _place, listed)
COUNTS: Final = FieldKind(array_schema(WHOLE_NUMBER.schema), _counts, listed)
FLAGS: Final = FieldKind(
    array_schema(FLAG.schema), lambda value: np.array(_list(value, (bool,), "true or false"), dtype=np.bool_), listed
)
XYZ: Final = _vector("xyz")
XYZW: Final = _vector("xyzw")
COVARIANCE: Final = FieldKind(
    NUMBERS.schema, _covariance, lambda matrix: [] if matrix is None else matrix.ravel().tolist()
)
"""(9, 9) of an estimate, row by row; None: an empty list."""

_FAULT: Final = {"source": TEXT, "since": NUMBER, "sentence": TEXT}
FAULTS: Final = FieldKind(
    array_schema(object_schema(**{key: kind.schema for key, kind in _FAULT.items()})),
    lambda value: tuple(Fault(**read_object(_FAULT, each)) for each in _list(value, (dict,), "faults")),
    lambda faults: [{"source": f.source, "since": max(f.since, 0.0), "sentence": f.sentence} for f in faults],
)
NOTICES: Final = FieldKind(
    array_schema(object_schema(condition=TEXT.schema, whose=TEXT.schema)),
    lambda value: tuple(map(_notice, _list(value, (dict,), "notices"))),
    lambda notices: [{"condition": n.condition.name, "whose": _fitting(n.subject, _MAX_SUBJECT)} for n in notices],
)
