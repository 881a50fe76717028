"""Docs against code: files and names in the docs exist, and each file is on its page."""

from __future__ import annotations

import re
import runpy
import shutil
from pathlib import Path

import pytest

import cablewright

ROOT = Path(__file__).resolve().parent.parent
SOURCE = ROOT / "src" / "cablewright"
ARCHITECTURE = (ROOT / "docs" / "architecture.md").read_text("utf-8")
EXTENDING = (ROOT / "docs" / "extending.md").read_text("utf-8")


def test_the_page_of_files_is_as_written_by_its_tool() -> None:
    """`python tools/refresh_docs.py docs/files.md` writes it again."""
    tool = runpy.run_path(str(ROOT / "tools" / "pages" / "files.py"))
    assert (ROOT / "docs" / "files.md").read_text("utf-8") == tool["page"]()


def test_every_file_has_a_docstring() -> None:
    silent = [path for path in SOURCE.rglob("*.py") if not path.read_text("utf-8").startswith('"""')]
    assert silent == []


def test_architecture_names_every_folder_of_a_rank() -> None:
    folders = {path.name for path in SOURCE.iterdir() if (path / "__init__.py").exists()}
    assert folders <= set(re.findall(r"^\| \d \| `(\w+)/` \|", ARCHITECTURE, re.MULTILINE))


@pytest.mark.parametrize("page", sorted((ROOT / "docs").rglob("*.md")), ids=lambda page: page.stem)
def test_files_that_a_page_names_by_their_path_exist(page: Path) -> None:
    known = {file.relative_to(SOURCE).as_posix() for file in SOURCE.rglob("*.py")}
    ends = {"/".join(path.split("/")[-2:]) for path in known}
    for path in re.findall(r"`((?:[a-z_]+/)+[a-z_]+\.py)`", page.read_text("utf-8")):
        assert (ROOT / path).exists() or path in known or path in ends, path


def test_recipes_speak_of_names_that_exist() -> None:
    words = {word for file in SOURCE.rglob("*.py") for word in re.findall(r"\w+", file.read_text("utf-8"))}
    assert set(re.findall(r"`(_?[A-Za-z][A-Za-z_]*)`", EXTENDING)) <= words | {"mypy"}


def test_the_reference_uses_and_lists_every_public_name() -> None:
    page = (ROOT / "docs" / "reference.md").read_text("utf-8")
    tool = runpy.run_path(str(ROOT / "tools" / "pages" / "reference.py"))
    assert page == tool["page"]()
    listed = re.findall(r"^::: cablewright\.[\w.]+\.(\w+)$", page, re.MULTILINE)
    used = set(re.findall(r"\bcw\.(\w+)", "".join(re.findall(r"```python\n(.*?)```", page, re.DOTALL))))
    assert sorted(listed) == sorted(cablewright.__all__)
    assert used >= set(cablewright.__all__)


def test_the_glossary_has_the_terms_of_reports() -> None:
    tool = runpy.run_path(str(ROOT / "tools" / "pages" / "glossary.py"))
    assert (ROOT / "docs" / "glossary.md").read_text("utf-8") == tool["page"]()


def test_the_page_of_commands_is_as_written_by_its_tool() -> None:
    """`python tools/refresh_docs.py docs/commands.md` writes the page."""
    tool = runpy.run_path(str(ROOT / "tools" / "pages" / "commands.py"))
    assert (ROOT / "docs" / "commands.md").read_text("utf-8") == tool["page"]()


def test_texts_can_be_drawn_and_read(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    shutil.copytree(ROOT / "src" / "cablewright" / "apps" / "cli", tmp_path / "src" / "cablewright")
    (tmp_path / "docs").mkdir()
    shutil.copy(ROOT / "docs" / "log.md", tmp_path / "docs")
    tool = runpy.run_path(str(ROOT / "tools" / "writing" / "draw_texts.py"))
    tool["main"](["20", str(tmp_path)])
    drawn = capsys.readouterr().out.splitlines()
    titles = [line for line in drawn if line.startswith("# ")]
    assert [title.partition(" of ")[2].partition(" ")[2] for title in titles] == [
        "help texts", "docstrings", "names of files", "sentences", "messages",
    ]  # fmt: skip
    assert titles[0].startswith(f"# {tool['COUNT']} of ")
    assert len(drawn) == len(titles) + 2 * sum(int(title.split()[1]) for title in titles)
    tool["main"](["20", str(tmp_path)])
    assert capsys.readouterr().out.splitlines() == drawn
