"""Statements of a release: one version and one date in all places, and a section of the changelog."""

from __future__ import annotations

import re
import tomllib
from datetime import date
from pathlib import Path

import pytest
from tools.release import build as release
from tools.release import try_extras

import cablewright

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]


def test_changelog_citation_and_project_have_one_version() -> None:
    day, notes = release.section((ROOT / "CHANGELOG.md").read_text("utf-8"), PROJECT["version"])
    citation = (ROOT / "CITATION.cff").read_text("utf-8")
    release.require_cited(citation, PROJECT["version"], day)
    assert notes
    assert f"license: {PROJECT['license']}" in citation


def test_a_section_ends_where_the_next_one_begins() -> None:
    older = "## 0.1.0 (2026-01-01)\n\n* old\n"
    text = f"# Changelog\n\n## Unreleased\n\n* new\n\n## 0.2.0 (2027-01-02)\n\n* one\n* two\n\n{older}"
    assert release.section(text, "0.2.0") == (date(2027, 1, 2), "* one\n* two")
    with pytest.raises(SystemExit, match=r"no section '## 0.3.0 \(YYYY-MM-DD\)'"):
        release.section(text, "0.3.0")


def test_a_citation_of_another_version_is_named() -> None:
    with pytest.raises(SystemExit, match="date-released must be 2027-01-02"):
        release.require_cited("version: 0.2.0\ndate-released: 2026-01-02\n", "0.2.0", date(2027, 1, 2))


def test_a_folder_with_files_is_not_written_into(tmp_path: Path) -> None:
    (tmp_path / "x").touch()
    with pytest.raises(SystemExit, match="is not empty"):
        release.main(tmp_path)


def test_required_files_are_in_the_archive_of_sources() -> None:
    config = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["hatch"]["build"]["targets"]["sdist"]
    for name in config["only-include"]:
        assert (ROOT / name).exists(), name
    assert {"CITATION.cff", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md", "src"} <= {*config["only-include"]}


def test_files_that_the_guide_names_exist() -> None:
    for name in re.findall(r"\]\(([\w./]+)\)", (ROOT / "CONTRIBUTING.md").read_text("utf-8")):
        assert (ROOT / name).exists(), name
    assert cablewright.__doc__


def test_each_extra_for_users_is_tried() -> None:
    """Others are tools of developers: tests, lint, documentation, benchmarks."""
    for_users = {*PROJECT["optional-dependencies"]} - {"test", "dev", "docs", "bench"}
    assert set(try_extras.BROUGHT) == for_users
