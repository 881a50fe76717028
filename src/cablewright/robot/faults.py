"""What is wrong with a robot file, in one line: where, what stands there and what is allowed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from cablewright.errors import InputError

KeyPath = tuple[str | int, ...]

_LONGEST_VALUE = 60
_ABSENT = object()


def explain(
    error: ValidationError,
    data: dict[str, Any],
    origin: str,
    locate: Callable[[KeyPath], tuple[KeyPath, str]] = lambda path: (path, ""),
) -> InputError:
    """Return pydantic's error as one line: the first fault with file, key path, value and what is allowed.

    ``locate`` maps a key path in ``data`` to where a person finds it in the file, and a note to put after it.
    """
    lines = []
    for details in error.errors(include_url=False):
        path, why = _fault(details, data)
        shown, note = locate(path)
        value = look_up(data, path, _ABSENT)
        lines.append(f"{spell(shown)}{note}{_shown(value)}: {why}")
    more = len(set(lines)) - 1
    return InputError(f"{origin}: {lines[0]}" + (f" (and {more} more)" if more else ""))


def look_up(data: Any, path: KeyPath, absent: Any = None) -> Any:
    """Return the value at a key path, or ``absent``."""
    for part in path:
        try:
            data = data[part]
        except (KeyError, IndexError, TypeError):
            return absent
    return data


def spell(path: KeyPath) -> str:
    """Write a key path as in a sentence: ``lines[2].cable.young_modulus``."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            text += ("." if text else "") + (part if part.isidentifier() else repr(part))
    return text or "the file"


def _fault(details: ErrorDetails, data: dict[str, Any]) -> tuple[KeyPath, str]:
    """Return the key path that is to blame, and why."""
    path = tuple(_without_tags(details["loc"], data))
    context = details.get("ctx", {})
    match details["type"]:
        case "refusal":
            return (*path, *context["within"], context["key"]), context["why"]
        case "union_tag_invalid":
            return (*path, "kind"), f"must be one of {context['expected_tags']}"
        case "union_tag_not_found":
            return (*path, "kind"), "is missing"
        case "value_error":
            return path, str(context["error"])
        case kind:
            template = _SENTENCES.get(kind)
            return path, template.format_map(context) if template else details["msg"]


_SENTENCES = {
    "bool_type": "must be true or false",
    "finite_number": "must be finite",
    "float_type": "must be a number",
    "int_type": "must be an integer",
    "greater_than": "must be greater than {gt:g}",
    "greater_than_equal": "must be at least {ge:g}",
    "less_than_equal": "must be at most {le:g}",
    "literal_error": "must be {expected}",
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
    """Drop the tags that pydantic puts into the location of an error within a tagged union.

    A platform that does not say its kind is a point, so its tag is dropped too.
    """
    for part in location:
        if isinstance(data, dict) and part not in data and part == data.get("kind", "point"):
            continue
        data = look_up(data, (part,))
        yield part


def _shown(value: Any) -> str:
    """Write `` = value``, or nothing for a table, a list of tables or no value at all."""
    if (
        value is _ABSENT
        or isinstance(value, dict)
        or (isinstance(value, list) and any(isinstance(v, dict) for v in value))
    ):
        return ""
    try:
        text = repr(value)
    except ValueError:  # an integer of more digits than Python prints
        return ""
    return " = " + (text if len(text) <= _LONGEST_VALUE else text[: _LONGEST_VALUE - 3] + "...")
