"""Robots from TOML: a file, a text, or a name of the library."""

from __future__ import annotations

import logging
import os
from functools import partial
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any, Final

from cablewright.foundation.errors import InputError, UnknownName, suggestion
from cablewright.foundation.toml_input import MAX_BYTES, is_file, parse_table, read_table, require_schema
from cablewright.foundation.validation import validated
from cablewright.robot.default_tables import locate, merge
from cablewright.robot.plausibility import doubts
from cablewright.robot.robot import Robot

_OF_OTHERS: Final = (".cfg", ".conf", ".g", ".gcode", ".ini", ".json", ".wcrfx", ".xml", ".yaml", ".yml")
"""Endings of robots of other programs, some of which `exchange` reads."""

log = logging.getLogger(__name__)


def load(name_or_path: str | Path) -> Robot:
    """Return the robot of a library name or of a TOML file. Raises `InputError`.

    A text with a path separator or the ending ``.toml`` is a file; any other that is a library name is of the library.
    """
    if isinstance(name_or_path, str) and not _looks_like_a_path(name_or_path):
        if name_or_path in library_names():
            return loads(library_text(name_or_path), f"{name_or_path} (library)")
        if not is_file(Path(name_or_path)):
            hint = suggestion(name_or_path, library_names())
            raise InputError(f"no robot {name_or_path!r} in the library and no file of that name; {hint}")
    try:
        return _build(read_table(name_or_path)[0], str(name_or_path))
    except InputError as error:
        if Path(name_or_path).suffix.lower() not in _OF_OTHERS or not is_file(Path(name_or_path)):
            raise
        how = f"`cablewright import {name_or_path} --out robot.toml` converts a file of another program"
        raise InputError(f"{error}; {how}") from None


def loads(text: str, origin: str = "the text") -> Robot:
    """Return the robot a TOML text describes; ``origin`` names the text in messages. Raises `InputError`."""
    if len(text) > MAX_BYTES:
        raise InputError(f"{origin}: longer than {MAX_BYTES} characters, the most a robot file may hold")
    return _build(parse_table(text, origin), origin)


def library_names() -> tuple[str, ...]:
    """Return the names of the robots that come with cablewright, sorted."""
    names = (item.name for item in _library().iterdir())
    return tuple(sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml")))


def library_text(name: str) -> str:
    """Return the TOML text of a library robot. Raises `UnknownName`."""
    if name not in library_names():
        raise UnknownName("robot", name, library_names())
    return _library().joinpath(f"{name}.toml").read_text(encoding="utf-8")


def file_text(name: str) -> str:
    """Return the TOML text of a robot's file, or of a library robot. Raises `InputError`."""
    return library_text(name) if name in library_names() else read_table(name)[1]


def _library() -> Traversable:
    return resources.files("cablewright.robot") / "library"


def _looks_like_a_path(name: str) -> bool:
    return name.endswith(".toml") or any(mark in name for mark in ("/", os.sep, os.altsep) if mark)


def _build(document: dict[str, Any], origin: str) -> Robot:
    require_schema(document, origin)
    robot = validated(Robot, merge(document, origin), origin, partial(locate, document))
    for doubt in doubts(robot):
        if doubt.impossible:
            raise InputError(f"{origin}: {doubt.sentence}")
        log.warning("note: %s: %s", origin, doubt.sentence)
    return robot
