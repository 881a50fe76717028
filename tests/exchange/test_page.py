"""The pages of exchange and of the library agree with the code."""

from __future__ import annotations

import re
import runpy
from pathlib import Path
from typing import get_args

from cablewright.exchange.firmware import FIRMWARE
from cablewright.exchange.formats import READ
from cablewright.foundation.choices import ReadFormatName, WrittenFormatName
from cablewright.robot import library_names

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "exchange.md").read_text("utf-8")


def test_the_page_of_imported_values_is_written_by_its_tool() -> None:
    """`python tools/refresh_docs.py docs/imported.md` writes the page."""
    tool = runpy.run_path(str(ROOT / "tools" / "pages" / "imported.py"))
    assert (ROOT / "docs" / "imported.md").read_text("utf-8") == tool["page"]()


def test_the_page_has_every_format() -> None:
    assert tuple(READ) == get_args(ReadFormatName)
    assert set(FIRMWARE) < set(get_args(WrittenFormatName))
    for name in {*get_args(ReadFormatName), *get_args(WrittenFormatName)}:
        read, written = (name in get_args(kind) for kind in (ReadFormatName, WrittenFormatName))
        assert re.search(rf"`{name}`.* \| {'yes' if read else 'no'} \| {'yes' if written else 'no'} \|", PAGE), name


def test_the_page_of_the_library_is_written_by_its_tool() -> None:
    tool = runpy.run_path(str(ROOT / "tools" / "pages" / "library.py"))
    assert (ROOT / "docs" / "library.md").read_text("utf-8") == tool["page"]()
    assert tuple(sorted(tool["ABOUT"])) == library_names()
    for name in library_names():
        assert (ROOT / "docs" / "images" / f"robot-{name}.png").stat().st_size < 150_000
