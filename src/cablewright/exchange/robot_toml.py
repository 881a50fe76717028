"""The TOML text of an imported robot: values that all lines share appear once, lost values as comments."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

from cablewright.exchange.translation_result import ImportedRobot
from cablewright.foundation.errors import printable
from cablewright.robot import Robot
from cablewright.robot.default_tables import PARTS

_NEW_SECTION = ("scene", "platform")


def robot_toml(found: ImportedRobot, command: str) -> str:
    """Return the TOML text of an imported robot *found*; *command* made it, for its first comment."""
    parts = [_comment(f"Made by `{command}` from {found.format}. Lengths without a unit are in m.")]
    parts += [_comment(f"lost: {each}") for each in found.lost]
    parts += [_comment(f"assumed: {each}") for each in found.assumed]
    return "".join(parts) + "\n" + plain_toml(found.robot)


def plain_toml(robot: Robot) -> str:
    """Return the text of a robot file without comments, with values that all lines share in the default tables."""
    table = robot.model_dump(by_alias=True, exclude_defaults=True)
    table = {"schema": robot.schema_version} | {key: value for key, value in table.items() if key != "schema"}
    if robot.platform.kind == "rigid":
        table["platform"] = {"kind": "rigid"} | table["platform"]
    lines = [_line(dump, line.sheave.kind) for dump, line in zip(table.pop("lines"), robot.lines, strict=True)]
    top = {key: value for key, value in table.items() if not isinstance(value, dict)}
    sections = {key: value for key, value in table.items() if isinstance(value, dict)}
    text = "".join(f"{key} = {_value(value)}\n" for key, value in top.items())
    for key, value in {**sections, **_shared(lines)}.items():
        text += f"\n[{key}]\n" + "".join(f"{name} = {_value(each)}\n" for name, each in value.items())
    for line in lines:
        text += "\n[[lines]]\n" + "".join(f"{name} = {_value(each)}\n" for name, each in line.items())
    return text


def _line(dump: dict[str, Any], kind: str) -> dict[str, Any]:
    """Return the table of a line with the kind of its sheave, which is a default of its class."""
    return {key: {"kind": kind} | value if key == "sheave" else value for key, value in dump.items()}


def _shared(lines: list[dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """Take out of the lines, and return as default tables, what is the same in all of them."""
    shared: dict[str, dict[str, Any]] = {}
    for part in PARTS:
        first = lines[0].get(part)
        if first and all(line.get(part) == first for line in lines):
            shared[part] = first
            for line in lines:
                del line[part]
    common = {
        key: value
        for key, value in lines[0].items()
        if key not in (*PARTS, "name", "exit_point") and all(line.get(key) == value for line in lines)
    }
    for line in lines:
        for key in common:
            del line[key]
    return shared | ({"line": common} if common else {})


def _value(value: Any) -> str:
    """Return a value as TOML spells it. Numbers are shortest texts that read back to the same number."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_value(each)}" for key, each in value.items() if each is not None) + " }"
    if isinstance(value, Iterable):
        return "[" + ", ".join(map(_value, value)) + "]"
    return repr(value)


def _comment(sentence: str) -> str:
    """Return a sentence as a comment line. It may hold texts of a stranger's file."""
    return f"# {printable(sentence)}\n"
