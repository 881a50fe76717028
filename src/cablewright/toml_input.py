"""Reading a TOML file a stranger wrote: capped before it is parsed, and refused in one line that names the key.

Robots and jobs are read by the same steps: `read_table`, `require_schema`, `validated`.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, TypeVar, get_args, get_origin

from pydantic import BaseModel, ValidationError

from cablewright.errors import InputError, suggestion

MAX_BYTES = 1 << 20
MAX_DEPTH = 32

# Strings and comments, so that a bracket inside one is not taken for nesting. Closed by the end of the text too, so
# that no match fails and goes back: linear in time whatever the file holds. Not possessive: Python 3.11.2 errs there.
_STRING_OR_COMMENT = re.compile(
    r'"""(?:\\.|"{1,2}(?!")|[^"\\])*(?:"{3,5}|\\?\Z)'
    r"|'''(?:'{1,2}(?!')|[^'])*(?:'{3,5}|\Z)"
    r'|"(?:\\[^\n]|[^"\\\n])*["\\]?'
    r"|'[^'\n]*'?"
    r"|\#[^\n]*",
    re.DOTALL,
)
_KEY_END = re.compile(r"[=\[\]{},\n]")

_Model = TypeVar("_Model", bound=BaseModel)


def read_bytes(path: Path, max_bytes: int, what: str) -> bytes:
    """Read the regular file at ``path`` if it holds at most ``max_bytes``; ``what`` it should be is for the message.

    Raises `InputError` where it cannot be read, is no regular file or holds more.
    """
    try:
        if not path.exists():
            raise InputError(f"{path}: no such file")
        if not path.is_file():
            raise InputError(f"{path}: not a regular file")
        with path.open("rb") as file:
            data = file.read(max_bytes + 1)
    except (OSError, ValueError) as error:  # ValueError: a NUL in the path
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise InputError(f"{path}: cannot be read: {reason}") from None
    if len(data) > max_bytes:
        raise InputError(f"{path}: larger than {max_bytes} bytes, the most a {what} may hold")
    return data


def read_table(path: str | Path) -> tuple[dict[str, Any], str]:
    """Read the TOML file at ``path``: its table, and its text as written.

    Raises `InputError` where it is no readable regular file, holds more than `MAX_BYTES`, is not UTF-8, nests deeper
    than `MAX_DEPTH` or is not TOML.
    """
    path = Path(path)
    data = read_bytes(path, MAX_BYTES, "TOML file")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not UTF-8 text at byte {error.start}; a TOML file is UTF-8") from None
    return parse_table(text, path), text


def parse_table(text: str, origin: str | Path) -> dict[str, Any]:
    """Parse TOML ``text``; ``origin`` names it in messages. Raises `InputError` as `read_table` does."""
    if _depth(text) > MAX_DEPTH:
        raise InputError(f"{origin}: nested deeper than {MAX_DEPTH} levels, the most a TOML file may be")
    try:
        return tomllib.loads(text)
    except ValueError as error:  # tomllib's own error, or an integer of too many digits
        raise InputError(f"{origin}: not TOML: {error}") from None


def require_schema(table: Mapping[str, Any], newest: int, origin: str | Path) -> None:
    """Raise `InputError` unless ``table`` says ``schema = n`` with n from 1 to ``newest``."""
    if "schema" not in table:
        raise InputError(f"{origin}: missing key 'schema'; write schema = {newest}")
    found = table["schema"]
    if type(found) is not int or found < 1:
        raise InputError(f"{origin}: schema = {_shown(found)}: a whole number from 1 to {newest} wanted")
    if found > newest:
        raise InputError(
            f"{origin}: schema = {_shown(found)}: written for a newer cablewright; this one reads up to {newest}"
        )


def validated(model: type[_Model], table: Mapping[str, Any], origin: str | Path) -> _Model:
    """Build a ``model`` from ``table``. Raises `InputError` with the line of `one_line`."""
    try:
        return model.model_validate(table)
    except ValidationError as error:
        raise one_line(error, origin, model) from None


def one_line(error: ValidationError, origin: str | Path, model: type[BaseModel]) -> InputError:
    """Turn pydantic's report into one line: file, key, value, what is allowed, the nearest key for an unknown one.

    An unknown key comes first where there is one: it is most often the misspelling of the key reported missing.
    """
    problems = error.errors(include_url=False, include_context=False)
    first = min(problems, key=lambda problem: problem["type"] != "extra_forbidden")
    unknown = first["type"] == "extra_forbidden"
    key, owners = _located(first["loc"][:-1] if unknown else first["loc"], model)
    if unknown:
        key = f"{key}.{first['loc'][-1]}" if key else str(first["loc"][-1])
        names = {field.alias or name for owner in owners for name, field in owner.model_fields.items()}
        return InputError(f"{origin}: unknown key '{key}'; {suggestion(str(first['loc'][-1]), names)}")
    if first["type"] == "missing":
        return InputError(f"{origin}: missing key '{key}'")
    reason = first["msg"].removeprefix("Value error, ").removeprefix("Assertion failed, ")
    reason = reason.removeprefix("Input ").replace("should be", "must be", 1)
    if not key:
        return InputError(f"{origin}: {reason}")
    return InputError(f"{origin}: {key} = {_shown(first['input'])}: {reason}")


def _depth(text: str) -> int:
    """Return a bound on how deep ``text`` nests: open brackets plus the dots of the longest dotted key."""
    bare = _STRING_OR_COMMENT.sub('""', text)
    opened = deepest = 0
    for mark in re.finditer(r"[\[\]{}]", bare):
        opened = opened + 1 if mark[0] in "[{" else max(0, opened - 1)
        deepest = max(deepest, opened)
    return max(deepest, *(1 + run.count(".") for run in _KEY_END.split(bare)))


def _located(loc: Sequence[int | str], model: type[BaseModel]) -> tuple[str, list[type[BaseModel]]]:
    """Write ``loc`` as a key such as ``lines[3].sheave.radius`` and find the models that may stand there.

    pydantic puts the tags of unions among the names; they are no keys of the file, so they only choose the model.
    """
    key = ""
    inside = [model]
    for part in loc:
        if isinstance(part, int):
            key += f"[{part}]"
            continue
        fields = [
            field for owner in inside for name, field in owner.model_fields.items() if part in (name, field.alias)
        ]
        if fields:
            key += f".{part}" if key else part
            inside = [found for field in fields for found in _models_in(field.annotation)]
        else:
            inside = [owner for owner in inside if _bears_tag(owner, part)] or inside
    return key, inside


def _models_in(annotation: Any) -> Iterator[type[BaseModel]]:
    """Yield the models named anywhere inside a field's annotation: tuples, unions, ``Annotated``."""
    if isinstance(annotation, type) and get_origin(annotation) is None and issubclass(annotation, BaseModel):
        yield annotation
    for argument in get_args(annotation):
        yield from _models_in(argument)


def _bears_tag(model: type[BaseModel], tag: str) -> bool:
    """Say whether ``tag`` picks ``model`` out of a union: by its name, or by a field that can only be ``tag``."""
    literals = (field.annotation for field in model.model_fields.values() if get_origin(field.annotation) is Literal)
    return model.__name__ == tag or any(tag in get_args(literal) for literal in literals)


def _shown(value: object) -> str:
    """Show a value of the file on one line, cut where it is long."""
    try:
        text = repr(value)
    except ValueError:  # Python refuses to write an integer of thousands of digits, which TOML may give in hexadecimal
        return "(a number of thousands of digits)"
    return text if len(text) <= 60 else text[:57] + "..."
