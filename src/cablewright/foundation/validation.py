"""Frozen pydantic models of the content of files, and their validation errors as one line.

An error names the file, the key, its value and what is allowed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Annotated, Any, ClassVar, Final, TypeVar, get_args

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic_core import ErrorDetails, PydanticCustomError

from cablewright.foundation.errors import InputError, suggestion
from cablewright.foundation.units import Dimension

NEWEST_SCHEMA: Final = 1
"""The newest version of the file formats that this cablewright reads."""

KeyPath = tuple[str | int, ...]

_LONGEST_VALUE = 60
_MOST_FAULTS = 5  # of a file that one line names
_ABSENT = object()

_Model = TypeVar("_Model", bound="Description")


class Description(BaseModel):
    """A frozen, hashable description made of floats, texts and tuples. An unknown key is rejected with the nearest.

    ``MOVED``: tables in which keys that once were here belong now, by key.
    """

    MOVED: ClassVar[Mapping[str, str]] = {}

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, serialize_by_alias=True)

    @model_validator(mode="before")
    @classmethod
    def _refuse_unknown_keys(cls, data: Any) -> Any:
        if isinstance(data, dict):
            valid = [field.alias or name for name, field in cls.model_fields.items()]
            unknown = [key for key in data if key not in valid]
            moved = [key for key in unknown if key in cls.MOVED]
            if moved:
                others = f"; moved too: {', '.join(moved[1:])}" if moved[1:] else ""
                raise refusal(moved[0], f"belongs into {cls.MOVED[moved[0]]} of the file now{others}")
            if unknown:
                raise refusal(str(unknown[0]), f"unknown key; {suggestion(str(unknown[0]), valid)}")
        return data


class FileDescription(Description):
    """A description with a file of its own, whose key ``schema`` is the version of the format."""

    schema_version: Annotated[int, Field(alias="schema", strict=True, ge=1, le=NEWEST_SCHEMA)] = NEWEST_SCHEMA


def refusal(key: str, why: str, within: KeyPath = ()) -> PydanticCustomError:
    """Return the error that a model's validator raises for its ``key``, or for the ``key`` of a part ``within`` it."""
    return PydanticCustomError("refusal", "{key}: {why}", {"key": key, "why": why, "within": within})


def require_unique_names(key: str, names: Iterable[str]) -> None:
    """Raise `refusal` of ``key`` (``"lines"``, ``"loads"``) if two of its entries have the same name."""
    for name, count in Counter(names).items():
        if count > 1:
            raise refusal(key, f"{count} {key} are named {name!r}; each needs a name of its own")


def require_rising(key: str, ends: tuple[float, float] | None) -> None:
    """Raise `refusal` of ``key`` unless the first of its two ``ends`` is the lower one; None passes."""
    if ends is not None and not ends[0] < ends[1]:
        raise refusal(key, "must rise: the lowest, then the highest")


def require_box(low_key: str, low: Iterable[float], high_key: str, high: Iterable[float]) -> None:
    """Raise `refusal` of ``high_key`` unless the corner ``high`` (3,) is above ``low`` (3,) along each axis, m."""
    for axis, below, above in zip("xyz", low, high, strict=True):
        if not below < above:
            why = f"must be above {low_key} in {axis}, where they are {above:g} and {below:g} m"
            raise refusal(high_key, why)


def validated(
    model: type[_Model],
    data: Mapping[str, Any],
    origin: object,
    locate: Callable[[KeyPath], tuple[KeyPath, str]] = lambda path: (path, ""),
) -> _Model:
    """Return the ``model`` of ``data``.

    ``locate`` maps a key path in ``data`` to the path in the file, and a note to put after it. Raises `InputError`:
    its errors, the first five, with ``origin`` (the file), key path, value and what is allowed.
    """
    try:
        return model.model_validate(data)
    except ValidationError as error:
        lines = []
        for details in error.errors(include_url=False):
            path, why = _explained(details, data)
            unit = _unit(model, path) if details["type"] in _BOUNDS else ""
            place, note = locate(path)
            value = look_up(data, path, _ABSENT)
            meant = _MEANT.get(unit.strip()) if isinstance(value, int | float) else None
            why += unit if meant is None else f"{unit}: {value:g} {meant}?"
            tables = any(isinstance(entry, dict) for entry in (value if isinstance(value, list) else [value]))
            found = "" if value is _ABSENT or tables else f" = {shown(value)}"
            lines.append(f"{spell(place)}{note}{found}: {why}" if path else why)
    faults = list(dict.fromkeys(lines))
    more = len(faults) - _MOST_FAULTS
    raise InputError(f"{origin}: {'; '.join(faults[:_MOST_FAULTS])}" + (f" (and {more} more)" if more > 0 else ""))


def look_up(data: Any, path: KeyPath, absent: Any = None) -> Any:
    """Return the value at a key path of nested tables, or ``absent``."""
    for part in path:
        try:
            data = data[part]
        except (KeyError, IndexError, TypeError):
            return absent
    return data


def spell(path: KeyPath) -> str:
    """Return a key path as it is written in a sentence: ``lines[2].cable.young_modulus``."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            text += ("." if text else "") + (part if part.isidentifier() else repr(part))
    return text


def _explained(details: ErrorDetails, data: Mapping[str, Any]) -> tuple[KeyPath, str]:
    """Return the key path of an error and its reason."""
    path = tuple(_without_tags(details["loc"], data))
    context = details.get("ctx", {})
    match details["type"]:
        case "refusal":
            return (*path, *context["within"], context["key"]), context["why"]
        case "union_tag_invalid":
            return (*path, "kind"), f"must be one of {context['expected_tags']}"
        case "union_tag_not_found":
            return (*path, "kind"), "is missing"
        case kind if kind in _SENTENCES:
            return path, _SENTENCES[kind].format_map(context)
    return path, details["msg"].removeprefix("Value error, ").replace("Input should be", "must be", 1)


def _unit(annotation: Any, path: KeyPath) -> str:
    """Return the SI unit, after a space, of the number at a key path of a model; "" where it has none."""
    parts = list(_parts(annotation))
    key = next((part for part in path if isinstance(part, str)), None)
    if key is None:
        return next((f" {each.si}" for each in parts if isinstance(each, Dimension)), "")
    fields = (each.model_fields.get(key) for each in parts if isinstance(each, type) and issubclass(each, Description))
    rest = path[path.index(key) + 1 :]
    return next((_unit((found.annotation, *found.metadata), rest) for found in fields if found is not None), "")


def _parts(annotation: Any) -> Iterator[Any]:
    """Yield a type and all that it is made of."""
    yield annotation
    for each in annotation if isinstance(annotation, tuple) else get_args(annotation):
        yield from _parts(each)


_MEANT = {"rad": "deg", "kg/m^3": "g/cm^3"}  # units in which a number that is out of bounds often is
_BOUNDS = ("greater_than_equal", "less_than", "less_than_equal")
_SENTENCES = {
    "bool_type": "must be true or false",
    "greater_than_equal": "must be at least {ge:g}",
    "less_than_equal": "must be at most {le:g}",
    "missing": "is missing",
    "model_attributes_type": "must be a table",
    "model_type": "must be a table",
    "string_too_long": "must have at most {max_length} characters",
    "string_too_short": "must not be empty",
    "string_type": "must be a text",
    "too_long": "must have at most {max_length} entries, has {actual_length}",
    "too_short": "must have at least {min_length} entries, has {actual_length}",
    "tuple_type": "must be a list",
}


def _without_tags(location: KeyPath, data: Any) -> Iterator[str | int]:
    """Drop what pydantic adds to the location of an error: the tags of unions, and ``[key]`` for a key of a table.

    A platform without ``kind`` is a point, so its tag is dropped too. Tags of other unions are in brackets.
    """
    for part in location:
        bracketed = isinstance(part, str) and part.startswith("[")
        added = bracketed or (isinstance(data, dict) and part == data.get("kind", "point"))
        if added and look_up(data, (part,), _ABSENT) is _ABSENT:
            continue
        data = look_up(data, (part,))
        yield part


def shown(value: Any) -> str:
    """Return a value of a file in quotes, shortened if it is long."""
    try:
        text = repr(value)
    except ValueError:  # Python does not print an integer of thousands of digits
        return "(a number of thousands of digits)"
    return text if len(text) <= _LONGEST_VALUE else text[: _LONGEST_VALUE - 3] + "..."
