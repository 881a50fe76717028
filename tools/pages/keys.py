"""Write ``docs/keys.md``: every key of every file that is read, from the JSON Schemas and ``apps/keys.toml``.

A test compares the page with this output. Run it from the repository root: ``python tools/pages/keys.py``.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from cablewright.apps.schemas import json_schema, meanings
from cablewright.foundation import units
from cablewright.foundation.choices import FileKind
from cablewright.robot.parameters import KINDS_OF

PAGE = Path(__file__).resolve().parents[2] / "docs" / "keys.md"
HEAD = """# Keys of files

All keys of the files that cablewright reads, with types, defaults and meanings. `cablewright schema KIND` prints the
same as a JSON Schema, for editors. [Robot files](robots.md#numbers-and-units) explains numbers and units: a number is
in [SI units](#units), a text has one number and one unit. The error for an unknown key names the nearest known one.

Lower limits: "> 0" is positive, "≥ 0" allows 0. Positive lengths of machine and job files are 1 um to 100 km, positive
durations at least 1 us. Italics name the kinds that have a key, if not all have it.

This page is written by `tools/pages/keys.py` from the schemas in the code and `apps/keys.toml`.
"""
KINDS: dict[FileKind, tuple[str, str, str]] = {
    "robot": ("Robot", "Robot files", "Examples: [Robot files](robots.md)."),
    "job": ("Job", "Job files", "Examples: [Jobs and G-code](jobs.md). A job has one of `gcode`, `curve` and `helix`."),
    "machine": ("Machine", "Machine files", "Explanation: [Machine files](machine_files.md)."),
    "uncertainty": ("Uncertainty", "Uncertainty files", "Examples: [Uncertainty files](uncertainty.md)."),
    "calibration": (
        "Calibration",
        "Calibration plans",
        "Example: [Calibration](calibration.md#further-measurements).",
    ),
    "survey": ("Survey", "Survey plans", "Examples: [Survey](survey.md)."),
}
ELSEWHERE = {"Uncertainty": "#uncertainty-files"}  # of a robot file
NEVER = 1e9  # s
GENERIC = 1e5  # an upper limit that no machine is near is left out

Schema = dict[str, Any]


def page() -> str:
    """The whole page."""
    parts = [HEAD]
    for kind, (word, title, text) in KINDS.items():
        parts += [f"## {title}\n", f"{text}\n", *_sections(kind, word)]
        if kind == "uncertainty":
            parts.append(_numbers())
    dimensions = [each for each in vars(units).values() if isinstance(each, units.Dimension)]
    parts += ["## Units\n", "| dimension | units, SI first |", "| --- | --- |"]
    parts += [f"| {each.name} | {', '.join(each.units)} |" for each in dimensions]
    return "\n".join(parts).rstrip() + "\n"


def _numbers() -> str:
    """The table of the uncertain numbers, the three axes of a vector in one row."""
    rows = []
    for base, found in KINDS_OF.items():
        kind = found[0]
        if kind.role in ("winch", "sensor") or base != kind.base:
            continue
        name = ", ".join([f"`{kind.name}`", *(f"`.{each.name.rpartition('.')[2]}`" for each in found[1:])])
        unit = kind.dimension.si if kind.dimension else kind.plain_unit or "1"
        of = {"line": "each line", "all lines": "all lines", "platform": "platform"}[kind.of]
        nominal = "" if kind.nominal is None else f"{kind.nominal:g}"
        rows.append(f"| {name} | {unit} | {of} | {'yes' if kind.shareable else 'no'} | {nominal} | {kind.meaning} |")
    head = "| name | unit | of | can be `shared` | value of the robot file | meaning |"
    return "\n".join(["### Uncertainty: uncertain numbers\n", head, "| --- | --- | --- | --- | --- | --- |", *rows, ""])


def _sections(kind: FileKind, word: str) -> Iterator[str]:
    """The tables of a kind of file, each class at the first path that leads to it."""
    schema = json_schema(kind)
    definitions = schema.get("$defs", {})
    anchors: dict[tuple[str, ...], str] = {}
    queue: list[tuple[str, str, list[Schema]]] = [("", "", [schema])]  # path, heading, its tables: grows meanwhile
    for path, heading, tables in queue:
        rows: list[str] = []
        for key, found in [each for table in tables for each in table["properties"].items()]:
            names = tuple(_references(found))
            if names and names not in anchors:
                plain = _plain(found)
                below = f"{path}.{key}".lstrip(".") + (".NAME" if "additionalProperties" in plain else "")
                title = f"[[{below}]]" if "items" in plain else f"[{below}]"
                anchors[names] = "#" + re.sub(r"[^\w-]", "", f"{word}-{title}".lower())
                if kind == "robot" and names[0] in ELSEWHERE:
                    anchors[names] = ELSEWHERE[names[0]]
                else:
                    queue.append((below, title, [definitions[name] for name in names]))
        for key in dict.fromkeys(key for table in tables for key in table["properties"]):
            rows += _rows(key, tables, anchors)
        if heading:
            yield f"### {word}: `{heading}`\n"
        yield "\n".join(["| key | type | default | meaning |", "| --- | --- | --- | --- |", *rows, ""])


def _rows(key: str, tables: list[Schema], anchors: dict[tuple[str, ...], str]) -> Iterator[str]:
    """A row of a key for each different form that it has in the *tables*."""
    forms: dict[tuple[str, str, str], list[str]] = {}
    for table in tables:
        if (found := table["properties"].get(key)) is not None:
            made = any(_references(found)) or found.get("type") == "object"  # a table without keys, by default
            needed = key in table.get("required", ()) or ("default" not in found and not made)
            default = "required" if needed else _default(found)
            kind = table["properties"].get("kind", {}).get("const", "")
            forms.setdefault((_type(found, anchors), default, meanings(table["title"]).get(key, "")), []).append(kind)
    if key == "kind" and len(tables) > 1:
        kinds = [kind for each in forms.values() for kind in each]
        forms = {(_choice(kinds), "required" if len(tables) > 2 else f'`"{kinds[0]}"`', next(iter(forms))[2]): kinds}
    for (what, default, meaning), kinds in forms.items():
        of = f"*{', '.join(kinds)}*: " if any(kinds) and len(kinds) < len(tables) else ""
        yield f"| `{key}` | {what} | {default} | {of}{meaning} |"


def _plain(found: Schema) -> Schema:
    """The schema of a value without the alternative null."""
    choices = [each for each in found.get("anyOf", ()) if each != {"type": "null"}]
    return _plain(choices[0]) if len(choices) == 1 else {**found, "anyOf": choices} if choices else found


def _references(found: Schema) -> Iterator[str]:
    """The names of the tables that a value can be."""
    found = _plain(found)
    if "$ref" in found:
        yield found["$ref"].rpartition("/")[2]
    inner = [found.get("items"), found.get("additionalProperties"), *found.get("anyOf", ()), *found.get("oneOf", ())]
    for each in inner:
        if isinstance(each, dict):
            yield from _references(each)


def _type(found: Schema, anchors: dict[tuple[str, ...], str]) -> str:
    """What a value is, in words."""
    found, names = _plain(found), tuple(_references(found))
    many = f", up to {found['maxItems']}" if "maxItems" in found else ""
    if "prefixItems" in found:
        return _tuple(found["prefixItems"], anchors)
    if names and names in anchors:
        return f"[list of tables]({anchors[names]}){many}" if "items" in found else f"[table]({anchors[names]})"
    if "items" in found:
        return f"list of {_plural(_type(found['items'], anchors))}{many}"
    if isinstance(found.get("additionalProperties"), dict):
        return f"table of {_plural(_type(found['additionalProperties'], anchors))}"
    if dimension := re.search(r"(?:^|\. )([\w ]+); a plain number is in (.+)$", found.get("description", "")):
        return dimension[1] + _range(found["anyOf"][0], f" {dimension[2]}")
    if choices := found.get("anyOf", found.get("oneOf")):
        words = dict.fromkeys(_type(each, anchors) for each in choices)
        return "number or text with a unit" if set(words) == {"number", "text"} else " or ".join(words)
    if "enum" in found or "const" in found:
        return _choice(found.get("enum", [found.get("const")]))
    if found.get("type") == "string":
        return "text" + (f", up to {found['maxLength']}" if "maxLength" in found else "")
    return {"boolean": "true or false", "object": "table"}.get(found["type"], str(found["type"])) + _range(found, "")


def _tuple(entries: list[Schema], anchors: dict[tuple[str, ...], str]) -> str:
    """The words for a list of fixed length."""
    words = [_type(each, anchors) for each in entries]
    if words[0][0].isdigit():
        return f"{len(entries)} x {words[0]}"
    return f"{len(words)} {_plural(words[0])}" if len(set(words)) == 1 else ", ".join(words)


def _plural(words: str) -> str:
    """The plural of a type: its first word, before limits."""
    if words[0] in "0123456789[" or words.startswith("number or"):
        return words
    name = re.split(r"[^\w ]| [>≥]", words)[0]
    return (name[:-1] + "ies" if name.endswith("y") else name + "s") + words[len(name) :]


def _range(found: Schema, unit: str) -> str:
    """The limits of a number."""
    lows = [found[key] for key in ("minimum", "exclusiveMinimum") if key in found]
    highs = [found[key] for key in ("maximum", "exclusiveMaximum") if key in found]
    low, high = max(lows, default=-math.inf), min(highs, default=math.inf)
    above = "exclusiveMinimum" in found or 0.0 < low <= 1e-6
    if low == high:
        return f", {low:.6g}{unit}"
    if high >= GENERIC:
        return "" if low < 0.0 else " > 0" if above else " ≥ 0" if low == 0.0 else f", {low:.6g}{unit} or more"
    if low == -math.inf:
        return f", up to {high:.6g}{unit}"
    return f", over 0, up to {high:.6g}{unit}" if above else f", {low:.6g} to {high:.6g}{unit}"


def _default(found: Schema) -> str:
    """The default of a value, in the unit that needs the fewest digits."""
    value = found.get("default")
    if value is None or value == [] or isinstance(value, dict) or value == NEVER:
        return "none"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'`"{value}"`' if value else "empty"
    if isinstance(value, list):
        return ", ".join(f'`"{each}"`' if isinstance(each, str) else f"{each:g}" for each in value)
    pattern = next((each["pattern"] for each in _plain(found).get("anyOf", ()) if "pattern" in each), "")
    names = [each.replace("\\", "") for each in re.findall(r"\(([^()?]*)\) \*\$$", pattern) for each in each.split("|")]
    texts = [f"{value / units.unit_size(unit):.6g} {unit}" for unit in names if value]
    return min(texts, key=lambda text: len(text.split()[0])) if texts else f"{value:.10g}"


def _choice(values: list[Any]) -> str:
    """Values to choose from."""
    words = [f'`"{value}"`' if isinstance(value, str) else f"{value}" for value in values]
    return f"{', '.join(words[:-1])} or {words[-1]}" if len(words) > 1 else words[0]


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
