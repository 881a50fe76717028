"""The page of verdicts: each command on it answers with the sentence beside it."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

pytestmark = pytest.mark.usefixtures("undrawn")

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "verdicts.md").read_text("utf-8")
ROWS = re.findall(r"^\| `cablewright (.*?)` \| (.*) \|$", PAGE, re.MULTILINE)
(BEFORE,) = re.findall(r"^```sh\ncablewright (.*)\n```$", PAGE, re.MULTILINE)


@pytest.fixture(scope="module")
def folder(cli, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The examples, and the log of a machine that sees nothing."""
    place = tmp_path_factory.mktemp("verdicts")
    (place / "examples").symlink_to(ROOT / "examples")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(place)
        assert cli(*shlex.split(BEFORE)).code == 0
    return place


SLOW = re.compile(r"check house-printer .*(verdicts/|--)|retraction ")
"""All verdicts of `check` except a yes: studies/test_check.py and test_check_verdicts.py have them. And the no of
`retraction`, which cli/test_workspace.py has too."""


@pytest.mark.parametrize(
    ("command", "sentence"),
    [pytest.param(*row, id=row[0], marks=[pytest.mark.slow] * bool(SLOW.match(row[0]))) for row in ROWS],
)
def test_a_command_answers_with_its_sentence(cli, folder: Path, monkeypatch, command: str, sentence: str) -> None:
    monkeypatch.chdir(folder)
    answer = cli(*shlex.split(command), "--json")
    told = answer.json or {}
    said = told["verdict"] if "verdict" in told and "reasons" not in told else answer.no
    assert re.fullmatch(re.escape(sentence).replace(r"\.\.\.", ".+?"), said), said
    assert answer.code == (0 if " can print " in sentence else 1)


def test_the_page_is_read() -> None:
    assert len(ROWS) == 24
