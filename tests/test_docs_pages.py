"""What some pages hold: the index of the examples, and the pictures that a tool draws."""

from __future__ import annotations

import re
import runpy
import struct
from pathlib import Path

from cablewright.apps import style

ROOT = Path(__file__).resolve().parent.parent


def test_the_index_of_examples_has_each_of_them() -> None:
    page = (ROOT / "docs" / "examples.md").read_text("utf-8")
    listed = re.findall(r"^\| `(\d\d_\w+\.py)` \|", page, re.MULTILINE)
    assert listed == sorted(path.name for path in (ROOT / "examples").glob("[0-9][0-9]_*.py"))


def test_the_index_of_examples_has_their_pinned_numbers() -> None:
    page = (ROOT / "docs" / "examples.md").read_text("utf-8")
    pinned = runpy.run_path(str(ROOT / "tests" / "test_examples.py"))["PINNED"]
    for name, (number, _) in pinned.items():
        row = re.search(rf"^\| `{name}\.py` \|.*\| ([\d.]+) \S+ \|$", page, re.MULTILINE)
        assert row is not None, name
        assert float(row[1]) == number, name


def test_pictures_of_the_quick_start_and_of_the_frame_are_drawn() -> None:
    tool = runpy.run_path(str(ROOT / "tools" / "docs_pictures.py"), run_name="tool")
    with style.drawing():
        for name, made in (("check-path", tool["draw_check"](2.0)), ("frame", tool["draw_frame"]())):
            kept = (tool["IMAGES"] / f"{name}.png").read_bytes()
            assert max(len(made), len(kept)) < 150_000
            assert struct.unpack(">II", made[16:24]) == struct.unpack(">II", kept[16:24])  # width and height
