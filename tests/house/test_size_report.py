"""The ceilings of statements: above one, the report fails and says what raising it needs."""

from __future__ import annotations

from pathlib import Path

import pytest
from tools import size_report
from tools.size_report import Content, ceilings, folder_contents, over_ceilings

TEXT = '''"""A module.

Of two lines.
"""

import math
from os import (
    path,
)

# a comment


def root(of: float) -> float:
    """Return the root."""
    return math.sqrt(
        of
    )
'''


def test_lines_and_statements_are_counted_by_kind() -> None:
    found = Content.of(TEXT)
    assert found == Content(statements=6, code=4, imports=4)  # docstrings are statements, as in any count by `ast`
    assert Content.of("") == Content(0, 0, 0)


@pytest.mark.slow  # `make check` runs the tool
def test_each_folder_has_a_ceiling_and_none_is_above_it() -> None:
    contents = folder_contents(size_report.ROOT / "src" / "cablewright")
    most = ceilings(size_report.ROOT / "pyproject.toml")
    assert over_ceilings(contents, most) == []
    assert contents.keys() == most.keys()


@pytest.mark.parametrize(
    ("most", "says"),
    [
        ({"a": 2, "cablewright": 5}, "src/cablewright/a has 3 statements, its ceiling is 2: raise it in"),
        ({"cablewright": 5}, "src/cablewright/a has no ceiling of statements: raise it"),
        ({"a": 3, "b": 1, "cablewright": 5}, "pyproject.toml has a ceiling of b: no such folder"),
    ],
)  # fmt: skip
def test_a_folder_above_its_ceiling_is_named(most: dict[str, int], says: str, tmp_path: Path) -> None:
    (tmp_path / "a" / "b").mkdir(parents=True)
    (tmp_path / "a" / "b" / "one.py").write_text("x = 1\ny = 2\nz = 3\n")
    (tmp_path / "two.py").write_text("x = 1\n")
    told = over_ceilings(folder_contents(tmp_path), most)
    assert len(told) == 1
    assert told[0].startswith(says)
    assert told[0].endswith(("no such folder", "a line in CHANGELOG.md: capability, statements added, removed"))
