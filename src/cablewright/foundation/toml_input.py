"""Reader of TOML files from any source: size limits before they are parsed; errors are one line."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO, TypeVar

from cablewright.foundation.errors import InputError
from cablewright.foundation.validation import NEWEST_SCHEMA, FileDescription, shown, validated

MAX_BYTES = 1 << 20
MAX_DEPTH = 32

# Strings and comments, so that a bracket inside one does not count as nesting. The end of the text closes them too, so
# that no match fails and backtracks: the time is linear whatever the file holds. Not possessive: Python 3.11.2 errs.
_STRING_OR_COMMENT = re.compile(
    r'"""(?:\\.|"{1,2}(?!")|[^"\\])*(?:"{3,5}|\\?\Z)'
    r"|'''(?:'{1,2}(?!')|[^'])*(?:'{3,5}|\Z)"
    r'|"(?:\\[^\n]|[^"\\\n])*["\\]?'
    r"|'[^'\n]*'?"
    r"|\#[^\n]*",
    re.DOTALL,
)
_KEY_END = re.compile(r"[=\[\]{},\n]")

_File = TypeVar("_File", bound=FileDescription)


def is_file(path: Path) -> bool:
    """Return whether there is a file at ``path``; false for a name that is invalid for the system."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def open_regular(path: Path) -> BinaryIO:
    """Open the file at ``path`` to read. Raises `InputError` where it is no regular file or cannot be opened."""
    try:
        if path.exists() and not path.is_file():
            raise InputError(f"{path}: not a regular file")
        return path.open("rb")
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except (OSError, ValueError) as error:  # ValueError: a NUL in the path
        raise InputError(f"{path}: cannot be read: {getattr(error, 'strerror', error)}") from None


def read_bytes(path: Path, max_bytes: int, what: str) -> bytes:
    """Read the regular file at ``path``; ``what``: the expected content, for messages.

    Raises `InputError` where it cannot be read, is no regular file or holds more than ``max_bytes``.
    """
    with open_regular(path) as file:
        try:
            data = file.read(max_bytes + 1)
        except OSError as error:
            raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    if len(data) > max_bytes:
        raise InputError(f"{path}: larger than {max_bytes} bytes, the maximum size of a {what}")
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


def load_model(model: type[_File], path: str | Path) -> _File:
    """Return the ``model`` of the TOML file at ``path``.

    Raises `InputError` as `read_table`, `require_schema` and `validated` do: one line with file, key, value and what is
    allowed.
    """
    table, _ = read_table(path)
    require_schema(table, path)
    return validated(model, table, path)


def require_schema(table: Mapping[str, Any], origin: str | Path) -> None:
    """Raise `InputError` unless ``table`` has ``schema = n`` with n from 1 to `NEWEST_SCHEMA`."""
    if "schema" not in table:
        raise InputError(f"{origin}: missing key 'schema'; write schema = {NEWEST_SCHEMA}")
    found = table["schema"]
    if type(found) is not int or found < 1:
        raise InputError(f"{origin}: schema = {shown(found)}: must be an integer from 1 to {NEWEST_SCHEMA}")
    if found > NEWEST_SCHEMA:
        newer = f"written for a newer cablewright; this one reads up to {NEWEST_SCHEMA}"
        raise InputError(f"{origin}: schema = {shown(found)}: {newer}")


def _depth(text: str) -> int:
    """Return an upper bound of the nesting of ``text``: open brackets plus the dots of the longest dotted key."""
    bare = _STRING_OR_COMMENT.sub('""', text)
    opened = deepest = 0
    for mark in re.finditer(r"[\[\]{}]", bare):
        opened = opened + 1 if mark[0] in "[{" else max(0, opened - 1)
        deepest = max(deepest, opened)
    return max(deepest, *(1 + run.count(".") for run in _KEY_END.split(bare)))
