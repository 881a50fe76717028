"""The page's table of Merlet and Papegay 2023 beside prints is made of their run folders' metrics."""

from __future__ import annotations

import json
import runpy
import sys
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "papers" / "merlet2023.py"
LINE = {"name": "south-west", "taut": 0.87, "irregularity": 7.9e-4}
METRICS = {
    "layers": 3,
    "distance": 84.0,
    "duration": 2850.0,
    "lines": [LINE, LINE | {"name": "south-east", "taut": None, "irregularity": None}],
    "structure": {"mass": 52.0, "estimated_mass": 50.0, "max_height": 0.031},
    **{
        f"{own}{key}": value
        for own in ("", "estimated_")
        for key, value in {
            "mean_path_error": -4.6e-5,
            "path_error_variance": 2.5e-7,
            "max_path_error": 3.36e-3,
            "mean_speed": 0.02996,
            "speed_variance": 1.13e-6,
        }.items()
    },
}


def told(folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> str:
    """Output of the example for a run folder, without the heap of the last test."""
    monkeypatch.setattr(sys, "argv", [str(EXAMPLE), str(folder)])
    main = runpy.run_path(str(EXAMPLE), run_name="example")["main"]
    monkeypatch.setitem(main.__globals__, "heap", lambda _mass: None)
    main()
    return capsys.readouterr().out


def test_figures_are_in_the_paper_s_units(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "metrics.json").write_text(json.dumps(METRICS))
    out = told(tmp_path, capsys, monkeypatch).splitlines()
    rows = {line[:34].strip(): [float(cell) for cell in line[34:].split()] for line in out[2:7]}
    assert rows["mean error beside the path, cm"] == pytest.approx([-0.026, -0.005, -0.005])
    assert rows["its variance, cm^2"] == pytest.approx([0.0774, 0.0025, 0.0025], abs=1e-4)
    assert rows["largest, cm"] == pytest.approx([4.82, 0.34, 0.34])
    assert rows["mean speed, cm/s"] == pytest.approx([3.0168, 2.996, 2.996])
    assert rows["its variance, (cm/s)^2"] == pytest.approx([0.02667, 0.0113, 0.0113])
    assert "south-west 87 %  (paper" in "\n".join(out)


def test_what_is_not_known_is_a_dash(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    bare = METRICS | {key: None for key in METRICS if key.startswith(("mean", "max", "path", "speed"))}
    (tmp_path / "metrics.json").write_text(json.dumps(bare | {"structure": None}))
    assert "4.82         -    0.34" in told(tmp_path, capsys, monkeypatch)
    with pytest.raises(SystemExit, match="print first"):
        told(tmp_path / "none", capsys, monkeypatch)


def test_the_height_of_all_their_powder_needs_no_print(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", [str(EXAMPLE)])
    runpy.run_path(str(EXAMPLE), run_name="__main__")
    assert "1700 kg along the whole curve: 19.5 cm high at most  (paper: 18 cm)" in capsys.readouterr().out
