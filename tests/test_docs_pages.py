"""What some pages hold: the index of the examples, and the pictures that a tool draws."""

from __future__ import annotations

import re
import runpy
import struct
import tomllib
from pathlib import Path
from typing import get_args

from benchmarks.commands import house

from cablewright.apps import style
from cablewright.apps.schemas import json_schema
from cablewright.foundation.choices import FileKind
from cablewright.robot.cable_table import CABLES
from cablewright.robot.new_robot import LAYOUTS

ROOT = Path(__file__).resolve().parent.parent


def test_the_index_of_examples_is_written_by_its_tool() -> None:
    """`python tools/refresh_docs.py docs/examples.md` writes the page."""
    tool = runpy.run_path(str(ROOT / "tools" / "pages" / "examples.py"))
    page = (ROOT / "docs" / "examples.md").read_text("utf-8")
    assert page == tool["page"]()
    listed = re.findall(r"^\| `(\d\d_\w+\.py)` \|.*\| -?[\d.]+ [^|]+ \|$", page, re.MULTILINE)
    assert listed == sorted(path.name for path in (ROOT / "examples").glob("[0-9][0-9]_*.py"))


def test_the_page_of_support_is_that_of_the_table() -> None:
    tool = runpy.run_path(str(ROOT / "tools" / "pages" / "support.py"))
    assert (ROOT / "docs" / "support.md").read_text("utf-8") == tool["page"]()


def test_pictures_of_the_quick_start_and_of_the_frame_are_drawn(tmp_path: Path) -> None:
    tool = runpy.run_path(str(ROOT / "tools" / "docs_pictures.py"), run_name="tool")
    with style.drawing():
        check = tool["draw_check"](house(tmp_path, 400), 2.0)
        for name, made in (("check-path", check), ("frame", tool["draw_frame"]())):
            kept = (tool["IMAGES"] / f"{name}.png").read_bytes()
            assert max(len(made), len(kept)) < 180_000
            assert struct.unpack(">II", made[16:24]) == struct.unpack(">II", kept[16:24])  # width and height


def test_the_page_of_new_robots_has_every_cable_and_layout() -> None:
    page = (ROOT / "docs" / "library.md").read_text("utf-8")
    for name, stock in CABLES.items():
        own, (low, high) = stock.cable, stock.modulus
        row = (
            f"| `{name}` | {stock.summary} | {1e-3 * own.stiffness:.4g} | {low:g} to {high:g} | "
            f"{1e3 * own.linear_density:.3g} | {1e-3 * own.breaking_load:.4g} | {1e3 * stock.least_radius:g} |"
        )
        assert row in page
    for name, layout in LAYOUTS.items():
        assert f"| `{name}` | {layout.summary} | {layout.lines}" in page


def test_the_page_of_keys_is_written_by_its_tool() -> None:
    """`python tools/refresh_docs.py docs/keys.md` writes the page."""
    tool = runpy.run_path(str(ROOT / "tools" / "pages" / "keys.py"))
    assert (ROOT / "docs" / "keys.md").read_text("utf-8") == tool["page"]()


def test_every_key_of_every_file_has_a_meaning_and_no_other_key() -> None:
    kept = tomllib.loads((ROOT / "src" / "cablewright" / "apps" / "keys.toml").read_text("utf-8"))
    named: dict[str, set[str]] = {}
    for kind in get_args(FileKind):
        schema = json_schema(kind)
        for table in (schema, *schema.get("$defs", {}).values()):
            if "properties" in table:
                named.setdefault(table["title"], set()).update(table["properties"])
    assert {title: set(keys) for title, keys in kept.items()} == named
    assert all(meaning for keys in kept.values() for meaning in keys.values())


def test_the_schema_of_a_key_has_its_meaning_and_unit() -> None:
    cable = json_schema("robot")["$defs"]["Cable"]["properties"]
    assert cable["breaking_load"]["description"] == "breaking load of one cable. force; a plain number is in N"
    assert cable["creep"]["description"].startswith("result of `creep`. The simulated machine")  # links in words only
