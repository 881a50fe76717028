"""`curves`: many closed curves to choose one from."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cablewright.apps.cli.main import run
from cablewright.printing.random_curve import CurveRequirements, draw


def test_json_ranks_curves_that_can_be_drawn_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sheet = tmp_path / "sheet.png"
    assert run(["curves", "--count", "7", "--seed", "3", "--plot", str(sheet), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert sorted(row["number"] for row in found["curves"]) == list(range(7))
    distances = [row["mean_distance"] for row in found["curves"]]
    assert distances == sorted(distances)
    first = found["curves"][0]
    again = draw(CurveRequirements(28.0, (3.6, 8.0)), 3, first["number"])
    assert len(again.crossings) == first["crossings"] >= 2
    assert again.min_radius == first["min_radius"] >= 0.3
    assert sheet.read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow  # curves are ranked in the test above
def test_the_table_names_the_seed(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["curves", "--count", "62"]) == 0
    out = capsys.readouterr().out
    assert "the first 60 of 62 rows; --json has all" in out
    assert "seed    0" in out
    distances = [float(line.split()[-1]) for line in out.splitlines()[5:65]]
    assert distances == sorted(distances)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--count", "0"], "count = 0"),
        (["--area", "3"], "--area = '3'"),
        (["--seed", "-1"], "seed = -1"),
        (["--length", "-3"], "length = -3"),
        (["--min-radius", "5"], "minimum radius = 5"),
        (["--plot", "sheet.jpg"], "--plot"),
    ],
)
def test_one_line_says_what_is_wrong(arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["curves", *arguments]) == 2
    captured = capsys.readouterr()
    assert words in captured.err
    assert captured.err.count("\n") == 1
    assert captured.out == ""
