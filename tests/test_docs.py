"""What the docs say of the code: files and names that they speak of exist, and architecture lists every file."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest

import cablewright

ROOT = Path(__file__).resolve().parent.parent
SOURCE = ROOT / "src" / "cablewright"
ARCHITECTURE = (ROOT / "docs" / "architecture.md").read_text("utf-8")
EXTENDING = (ROOT / "docs" / "extending.md").read_text("utf-8")
UNNAMED = ("apps/cli", "apps/report", "apps/pictures")  # one file a command, report or picture: listed as such
PARTS = (
    "robot",
    "signals",
    "machine/sensors",
    "machine/simulated/sensors",
    "estimation/body/updates",
)  # one file a part


def wings() -> list[str]:
    folders = {file.parent.relative_to(SOURCE).as_posix() for file in SOURCE.rglob("*.py")}
    return sorted(folders - {"."} - {*UNNAMED, "apps"})


def section(folder: str) -> str:
    """The rows of architecture's tables that speak of a folder."""
    if folder.startswith("kernels"):
        table = ARCHITECTURE.partition("### Kernels")[2].partition("Facades above")[0]
        rows, wing = [], ""
        for row in table.splitlines():
            cells = [cell.strip() for cell in row.split("|")]
            if len(cells) > 3:
                wing = cells[1].strip("`/") or wing if cells[1] else wing
                rows.append((wing, row))
        wanted = folder.partition("/")[2]
        return "\n".join(row for wing, row in rows if wing == wanted or (not wanted and wing in ("", "wing", "---")))
    return "\n".join(row for row in ARCHITECTURE.splitlines() if re.match(rf"\| \d \| `{folder}/` \|", row))


@pytest.mark.parametrize("folder", wings())
def test_architecture_lists_every_file_and_no_other(folder: str) -> None:
    told = set(re.findall(r"`(\w+\.py)`", section(folder)))
    there = {file.name for file in (SOURCE / folder).glob("[!_]*.py")}
    assert told <= there
    if folder not in PARTS:
        assert there <= told


@pytest.mark.parametrize("page", sorted((ROOT / "docs").rglob("*.md")), ids=lambda page: page.stem)
def test_files_that_a_page_names_by_their_path_exist(page: Path) -> None:
    known = {file.relative_to(SOURCE).as_posix() for file in SOURCE.rglob("*.py")}
    ends = {"/".join(path.split("/")[-2:]) for path in known}
    for path in re.findall(r"`((?:[a-z_]+/)+[a-z_]+\.py)`", page.read_text("utf-8")):
        assert (ROOT / path).exists() or path in known or path in ends, path


def test_recipes_speak_of_names_that_exist() -> None:
    code = "\n".join(file.read_text("utf-8") for file in SOURCE.rglob("*.py"))
    for name in set(re.findall(r"`(_?[A-Za-z][A-Za-z_]*)`", EXTENDING)) - {"mypy"}:
        assert re.search(rf"\b{re.escape(name)}\b", code), name


def test_the_reference_uses_and_lists_every_public_name() -> None:
    page = (ROOT / "docs" / "reference.md").read_text("utf-8")
    listed = re.findall(r"^::: cablewright\.[\w.]+\.(\w+)$", page, re.MULTILINE)
    used = set(re.findall(r"\bcw\.(\w+)", "".join(re.findall(r"```python\n(.*?)```", page, re.DOTALL))))
    assert sorted(listed) == sorted(cablewright.__all__)
    assert used >= set(cablewright.__all__)


def test_help_names_every_public_name_by_its_group() -> None:
    assert cablewright.__doc__ is not None
    assert set(re.findall(r"\w+", cablewright.__doc__)) >= set(cablewright.__all__)


def test_the_glossary_has_the_terms_of_reports() -> None:
    tool = runpy.run_path(str(ROOT / "tools" / "glossary_page.py"))
    assert (ROOT / "docs" / "glossary.md").read_text("utf-8") == tool["page"]()


def test_texts_can_be_drawn_and_read(capsys: pytest.CaptureFixture[str]) -> None:
    tool = runpy.run_path(str(ROOT / "tools" / "draw_texts.py"))
    tool["main"](["20"])
    drawn = capsys.readouterr().out.splitlines()
    assert len(drawn) == 2 * (1 + tool["COUNT"])
    tool["main"](["20"])
    assert capsys.readouterr().out.splitlines() == drawn
