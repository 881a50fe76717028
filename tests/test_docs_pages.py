"""What some pages hold: the index of the examples, and the pictures that a tool draws."""

from __future__ import annotations

import re
import runpy
import struct
from pathlib import Path

import pytest
from benchmarks.commands import house

from cablewright.apps import style
from cablewright.apps.schemas import json_schema
from cablewright.foundation.choices import FileKind
from cablewright.robot.cable_table import CABLES
from cablewright.robot.new_robot import LAYOUTS

ROOT = Path(__file__).resolve().parent.parent


def test_the_index_of_examples_has_each_of_them() -> None:
    page = (ROOT / "docs" / "examples.md").read_text("utf-8")
    listed = re.findall(r"^\| `(\d\d_\w+\.py)` \|", page, re.MULTILINE)
    assert listed == sorted(path.name for path in (ROOT / "examples").glob("[0-9][0-9]_*.py"))


def test_the_index_of_examples_has_their_pinned_numbers() -> None:
    page = (ROOT / "docs" / "examples.md").read_text("utf-8")
    pinned = runpy.run_path(str(ROOT / "tests" / "test_examples.py"))["PINNED"]
    for name, (number, _) in pinned.items():
        row = re.search(rf"^\| `{name}\.py` \|.*\| (-?[\d.]+) \S+ \|$", page, re.MULTILINE)
        assert row is not None, name
        assert float(row[1]) == number, name


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
    page = (ROOT / "docs" / "robots.md").read_text("utf-8")
    for name, stock in CABLES.items():
        own, (low, high) = stock.cable, stock.modulus
        row = (
            f"| `{name}` | {stock.summary} | {1e-3 * own.stiffness:.4g} | {low:g} to {high:g} | "
            f"{1e3 * own.linear_density:.3g} | {1e-3 * own.breaking_load:.4g} | {1e3 * stock.least_radius:g} |"
        )
        assert row in page
    for name, layout in LAYOUTS.items():
        assert f"| `{name}` | {layout.summary} | {layout.lines}" in page


@pytest.mark.parametrize(
    ("kind", "page"),
    [
        ("job", "jobs"),
        ("machine", "machine_files"),
        ("uncertainty", "uncertainty"),
        ("calibration", "plan_files"),
        ("survey", "plan_files"),
    ],
)
def test_the_page_of_a_kind_of_file_has_every_key(kind: FileKind, page: str) -> None:
    text = (ROOT / "docs" / f"{page}.md").read_text("utf-8")
    schema = json_schema(kind)
    tables = [schema, *schema.get("$defs", {}).values()]
    keys = {key for table in tables for key in table.get("properties", {})}
    assert len(keys) > 5
    missing = {key for key in keys if not re.search(rf"(`|\.|\[|^){key}\b", text, re.MULTILINE)}
    assert not missing
