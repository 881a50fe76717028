"""Each script of the papers' figures draws all of its figures, in its quick mode, with words and data on each."""

from __future__ import annotations

import csv
import runpy
import sys
from pathlib import Path

import pytest

PAPERS = Path(__file__).resolve().parents[2] / "examples" / "papers"
FIGURES = {
    "paty2021": (10, 11, 12, 13),
    "merlet2023": (7, 8, 11),
    "jung2020": (6, 7, 8, 9, 10, 11, 12, 13, 14),
    "wang2021": (4, 5, 6),
}


def test_every_script_is_tried() -> None:
    assert sorted(file.stem for file in PAPERS.glob("*_figures.py")) == sorted(f"{name}_figures" for name in FIGURES)


def run(paper: str, *arguments: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Run a script with arguments; what it imports from its folder is forgotten afterwards."""
    script = PAPERS / f"{paper}_figures.py"
    monkeypatch.syspath_prepend(str(PAPERS))
    monkeypatch.setattr(sys, "argv", [str(script), *arguments])
    for name in ("figure_sheet", *FIGURES):
        monkeypatch.delitem(sys.modules, name, raising=False)
    runpy.run_path(str(script), run_name="__main__")
    for name in ("figure_sheet", *FIGURES):
        monkeypatch.delitem(sys.modules, name, raising=False)


@pytest.mark.parametrize("paper", FIGURES)
@pytest.mark.parametrize("which", ["last", pytest.param("all", marks=pytest.mark.slow)])
def test_figures_are_drawn_as_pdf_with_their_data(
    paper: str, which: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    numbers = FIGURES[paper] if which == "all" else FIGURES[paper][-1:]
    asked = [str(each) for each in numbers] if which == "last" else []
    run(paper, *asked, "--quick", "--out", str(tmp_path / "figures"), monkeypatch=monkeypatch)
    drawn = [tmp_path / "figures" / f"{paper}-{number:02}.pdf" for number in numbers]
    assert sorted((tmp_path / "figures").glob("*.pdf")) == sorted(drawn)
    for file in drawn:
        assert file.read_bytes().startswith(b"%PDF-")
        rows = list(csv.DictReader(file.with_name(f"{file.name}.csv").read_text("utf-8").splitlines()))
        assert len(rows) > 3, file.name
    assert len(capsys.readouterr().out.splitlines()) == len(drawn)


def test_one_figure_and_an_unknown_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    run("merlet2023", "8", "--quick", "--ending", "svg", "--out", str(tmp_path), monkeypatch=monkeypatch)
    assert [file.name for file in tmp_path.glob("*.svg")] == ["merlet2023-08.svg"]
    with pytest.raises(SystemExit):
        run("merlet2023", "9", monkeypatch=monkeypatch)
    assert "there is no figure 9; there are 7, 8, 11" in capsys.readouterr().err
