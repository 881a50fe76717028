"""Banned words and lengths of sentences: the tools find them, and no file has more banned words than its ceiling."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from tools.writing import prose, words

BANNED = words.Words(words.ROOT / "tools" / "words.toml")


@pytest.mark.parametrize(
    ("name", "text", "found"),
    [
        (
            "a.md",
            "It told us.\n\n`told` [x](told.md)\n\n```text\ntold\n```\nNobody\ntells.",
            ["told", "Nobody", "tells"],
        ),
        ("a.py", '"""Nobody told."""\ntold = 1  # what gives\n', ["Nobody", "told", "what gives"]),
        ("felt_air.py", "def test_nobody_is_near() -> None: ...\n", ["felt", "nobody"]),
        ("a.toml", 'a = "told" # told\n', ["told"]),
        ("b.md", "The winch reports a fault. The solver stops.", []),
    ],
)
def test_banned_words_are_found(tmp_path: Path, name: str, text: str, found: list[str]) -> None:
    (tmp_path / name).write_text(text, encoding="utf-8")
    assert [each.word for each in BANNED.found_in(tmp_path / name)] == found


def test_a_line_number_and_a_replacement_are_shown(tmp_path: Path) -> None:
    (tmp_path / "a.md").write_text("One.\n\nTwo cables,\n\nthree\nropes.\n", encoding="utf-8")
    assert [(each.line, each.instead) for each in BANNED.found_in(tmp_path / "a.md")] == [(6, "cables")]


@pytest.mark.slow  # `make check` runs the tool
def test_no_file_is_over_its_ceiling() -> None:
    root = words.ROOT
    counts = {each.relative_to(root).as_posix(): len(BANNED.found_in(each)) for each in BANNED.files_below(root)}
    assert words.over_ceilings(counts, json.loads(words.CEILINGS.read_text(encoding="utf-8"))) == []


def test_a_new_file_has_the_ceiling_zero() -> None:
    assert words.over_ceilings({"docs/new.md": 1, "docs/old.md": 2}, {"docs/old.md": 2}) == [
        "docs/new.md has 1, its ceiling is 0: see python tools/writing/words.py --list docs/new.md"
    ]


def test_prose_counts_sentences_of_paragraphs_and_lists() -> None:
    text = (
        "# Title here\n\nThe winch is driven by `a motor`. It stops.\n\n"
        "* one item\n* two items: three\n\n| a b | c d |\n"
    )
    assert prose.sentences(text) == ["The winch is driven by Code.", "It stops.", "one item", "two items: three"]
    found = prose.prose(text)
    assert (found.sentences, found.median, found.long, found.passive) == (4, 2.5, 0.0, 0.25)
