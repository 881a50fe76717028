"""The paper about the software: its length, and what it cites."""

from __future__ import annotations

import re
from pathlib import Path

PAPER = Path(__file__).parents[2] / "paper"
MOST_WORDS = 1000


def test_the_paper_is_short_and_cites_what_is_listed() -> None:
    text = (PAPER / "paper.md").read_text("utf-8").split("---", 2)[2]
    listed = re.findall(r"(?m)^@\w+\{(\w+),$", (PAPER / "paper.bib").read_text("utf-8"))
    assert len(text.split()) <= MOST_WORDS
    assert set(re.findall(r"@(\w+)", text)) == set(listed)
    assert len(listed) == len(set(listed))
