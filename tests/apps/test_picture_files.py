"""Pictures as files: formats by ending, sizes of papers, embedded fonts, style sheets, and the data beside them."""

from __future__ import annotations

import csv
import re
import zlib
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from matplotlib.legend import Legend
from matplotlib.text import Text

import cablewright as cw
from cablewright.apps import style
from cablewright.apps.cli.main import run
from cablewright.apps.pictures.data_tables import table_of

ROBOT = cw.load("jung2020")
WAY = cw.Trajectory.through([[0, 0, 3], [1, 1, 4]], speed=1.0, acceleration=1.0, period=0.1)
MAGIC = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}


@cache
def tensions() -> cw.TensionComparison:
    return cw.compare_tensions(ROBOT, [0.2, 0.1, 0.9])


@cache
def dynamics() -> cw.InverseDynamics:
    return cw.inverse_dynamics(cw.load("house-printer"), WAY)


@pytest.mark.parametrize("ending", style.FORMATS)
def test_the_ending_decides_the_format_and_the_bytes_are_the_same_again(ending: str, tmp_path: Path) -> None:
    files = [tmp_path / f"{name}{ending}" for name in ("one", "other")]
    for file in files:
        tensions().plot(file)
    one, other = (file.read_bytes() for file in files)
    assert one.startswith(MAGIC[ending])
    assert one == other
    assert sorted(tmp_path.iterdir()) == sorted([*files, *(file.with_name(f"{file.name}.csv") for file in files)])


def test_fonts_are_embedded_in_a_pdf_as_truetype(tmp_path: Path) -> None:
    tensions().plot(tmp_path / "x.pdf")
    content = (tmp_path / "x.pdf").read_bytes()
    parts = [content]
    for stream in re.findall(rb"stream\r?\n(.*?)\r?\nendstream", content, re.DOTALL):
        try:
            parts.append(zlib.decompress(stream))
        except zlib.error:
            continue
    text = b"".join(parts)
    assert b"/FontFile2" in text
    assert b"/Type3" not in text
    tensions().plot(tmp_path / "x.svg")
    assert "<text" not in (tmp_path / "x.svg").read_text("utf-8")


@pytest.mark.parametrize(
    ("width", "inches"), [("one-column", 3.5), ("two-column", 7.16), ("90 mm", 3.543), (0.1, 3.937)]
)
def test_a_width_of_a_paper_has_texts_of_seven_points(width: str | float, inches: float) -> None:
    drawn = dynamics().plot(width=width)
    assert drawn.get_figwidth() == pytest.approx(inches, abs=1e-3)
    assert drawn.axes[0].yaxis.label.get_fontsize() == pytest.approx(7.0)
    sizes = {text.get_fontsize() for text in drawn.findobj(Text) if text.get_text()}
    assert 5.5 < min(sizes) <= max(sizes) < 9.0
    assert max(size for size in dynamics().plot().get_size_inches()) > 9.0  # the page is that of the call alone


ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"
RIGID = {"cable": "rigid", "tolerance": 0.05}
SEVERAL_PANELS = {
    "Trajectory": lambda: WAY,
    "Simulation": lambda: cw.simulate(cw.load("merlet2023"), hold=[0.0, 0.0, 1.2], duration=4.0, plant="quasi-static"),
    "Replay": lambda: cw.replay(EXAMPLES / "merlet2023-loop.mcap", "paper"),
    "Workspace": lambda: cw.workspace(ROBOT, "closed-form", **RIGID),
    "Boundary": lambda: cw.boundary_modes(cw.Model(ROBOT, cw.Fidelity.of("elastic")), "closed-form", grid=9),
    "RetractionStudy": lambda: cw.retraction(ROBOT, "closed-form", steps=3, heights=8, tolerance=0.05),
    "Survey": lambda: cw.survey(EXAMPLES / "survey.gsi", EXAMPLES / "survey.toml", robot=cw.load("merlet2023")),
    "CreepResult": lambda: cw.creep(EXAMPLES / "creep.csv", initial_length=2.0),
    "TensileResult": lambda: cw.modulus(
        EXAMPLES / "tensile.csv", initial_length=1.0, section=12.6e-6, breaking_load=8e3
    ),
    "Trade": lambda: cw.trade(
        ROBOT, {"exit-distance": [0.1, 0.2]}, settings=cw.TradeSettings(criterion="closed-form", grid=9)
    ),
    "BracketStress": lambda: cw.bracket(cw.load("house-printer"), [-2.25, -6.75, 13.0], times=1),
}


@pytest.mark.parametrize(
    "name", [pytest.param(each, marks=[pytest.mark.slow] * (each == "BracketStress")) for each in SEVERAL_PANELS]
)
def test_panels_side_by_side_are_one_below_the_other_in_one_column(name: str) -> None:
    found = SEVERAL_PANELS[name]()
    assert type(found).__name__ == name
    drawn = found.plot(width="one-column")
    assert drawn.get_figwidth() == pytest.approx(3.5)
    assert 3.0 < drawn.get_figheight() <= 9.0
    low, high = drawn.bbox.x0 - 2.0, drawn.bbox.x1 + 2.0
    for legend in drawn.findobj(Legend):
        box = legend.get_window_extent()
        assert low <= box.x0 < box.x1 <= high, [text.get_text() for text in legend.get_texts()]
    bars = {axes for axes in drawn.axes if axes.get_label() == "<colorbar>"}
    middles = [axes.get_position().y0 for axes in drawn.axes if axes not in bars]
    assert len({round(middle, 3) for middle in middles}) >= 2
    assert found.plot(width="two-column").get_figwidth() == pytest.approx(7.16)


def test_a_style_sheet_changes_its_settings(tmp_path: Path) -> None:
    sheet = tmp_path / "mine.mplstyle"
    sheet.write_text("font.size: 8\naxes.prop_cycle: cycler('color', ['112233', '445566'])  # mine\n")
    drawn = dynamics().plot(width="one-column", style=sheet)
    assert drawn.axes[0].get_lines()[0].get_color().strip("#") == "112233"
    assert drawn.axes[0].yaxis.label.get_fontsize() == pytest.approx(8.0)
    drawn = dynamics().plot(style={"axes.grid": False, "font.size": 12.0})
    assert drawn.axes[0].yaxis.label.get_fontsize() == pytest.approx(12.0)
    whole = tmp_path / "whole.mplstyle"
    whole.write_bytes(style.STYLE_SHEET.read_bytes())
    dynamics().plot(tmp_path / "a.png")
    dynamics().plot(tmp_path / "b.png", style=whole)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_the_data_beside_a_picture_are_what_it_shows(tmp_path: Path) -> None:
    dynamics().plot(tmp_path / "x.png")
    with (tmp_path / "x.png.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    known = [row for row in rows if (row["panel"], row["kind"], row["label"]) == ("1", "curve", "south-west")]
    assert [float(row["x"]) for row in known] == WAY.times.tolist()
    assert [float(row["y"]) for row in known] == dynamics().tensions[:, 0].tolist()
    tensions().plot(tmp_path / "bars.png")
    with (tmp_path / "bars.png.csv").open(newline="") as file:
        bars = [row for row in csv.DictReader(file) if row["kind"] == "bar"]
    assert [float(row["y"]) for row in bars] == pytest.approx(tensions().tensions.ravel())


def test_data_of_maps_markers_and_pieces_in_space(tmp_path: Path) -> None:
    cw.available_wrenches(ROBOT, [0.2, 0.1, 0.9]).plot(tmp_path / "x.png")
    with (tmp_path / "x.png.csv").open(newline="") as file:
        kinds = {row["kind"] for row in csv.DictReader(file) if row["z"]}
    assert kinds >= {"curve", "face", "piece"}
    with style.drawing():
        drawn, axes = style.axes(3.0, 3.0)
        axes.pcolormesh([0.5, 1.5], [0.5, 2.5], np.array([[1.0, 2.0], [3.0, np.nan]]), shading="nearest")
        axes.scatter([1.0, 2.0], [3.0, 4.0], c=[5.0, 6.0])
        rows = list(csv.DictReader(table_of(drawn).decode().splitlines()))
    cells = [(row["x"], row["y"], row["value"]) for row in rows if row["kind"] == "map"]
    assert cells == [("0.5", "0.5", "1.0"), ("1.5", "0.5", "2.0"), ("0.5", "2.5", "3.0"), ("1.5", "2.5", "")]
    assert [(row["x"], row["value"]) for row in rows if row["kind"] == "marker"] == [("1.0", "5.0"), ("2.0", "6.0")]


@pytest.mark.parametrize(
    ("file", "options", "text", "error"),
    [
        ("x.jpg", {}, r"ends in .png, .svg or .pdf", cw.InputError),
        ("x", {}, r"ends in .png, .svg or .pdf", cw.InputError),
        ("nowhere/x.pdf", {}, "there is no folder", cw.EnvironmentFault),
        ("x.pdf", {"width": "one-colum"}, "did you mean 'one-column'", cw.InputError),
        ("x.pdf", {"width": 7.0}, "from 0.02 to 2 m", cw.InputError),
        ("x.pdf", {"width": float("nan")}, "unknown width", cw.InputError),
        ("x.pdf", {"style": {"font.sise": 3}}, "did you mean 'font.size'", cw.InputError),
        ("x.pdf", {"style": {"font.size": "huge"}}, "style: ", cw.InputError),
        ("x.pdf", {"style": {"font.size": "huge"}, "width": "two-column"}, "style: ", cw.InputError),
        ("x.pdf", {"style": "absent.mplstyle"}, "cannot be read", cw.InputError),
    ],
)
def test_what_cannot_be_written_is_rejected_before_it_is_drawn(
    file: str, options: dict[str, object], text: str, error: type[Exception], tmp_path: Path
) -> None:
    with pytest.raises(error, match=text) as caught:
        tensions().plot(tmp_path / file, **options)
    assert "\n" not in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_a_wrong_line_of_a_style_sheet_is_named(tmp_path: Path) -> None:
    sheet = tmp_path / "wrong.mplstyle"
    sheet.write_text("axes.grid: True\naxes.grit: True\n")
    with pytest.raises(cw.InputError, match=r"line 2: unknown setting 'axes.grit'; did you mean 'axes.grid'"):
        tensions().plot(style=sheet)
    sheet.write_text("axes.grid: True\nfont.size: huge\n")
    with pytest.raises(cw.InputError, match=r"line 2: font.size: the value is not one"):
        tensions().plot(style=sheet)


def test_a_batch_is_not_drawn_where_a_picture_is_of_one_pose() -> None:
    with pytest.raises(cw.InputError, match="take a row"):
        cw.modes(ROBOT, [[0.2, 0.1, 0.9], [0.0, 0.0, 0.8]]).plot()


def test_the_command_line_takes_the_same_endings(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    held = ["modes", "house-printer", "--at", "1,2,3"]
    file = tmp_path / "m.pdf"
    assert run([*held, "--plot", str(file), "--plot-width", "two-column"]) == 0
    assert file.read_bytes().startswith(b"%PDF")
    assert file.with_name("m.pdf.csv").exists()
    capsys.readouterr()
    for options, text in (
        (["--plot", "m.tiff"], "ends in .png or .svg or .pdf"),
        (["--plot", str(file), "--plot-width", "wide"], "unknown width"),
        (["--plot-width", "one-column"], "give --plot FILE too"),
    ):
        assert run([*held, *options]) == 2
        assert text in capsys.readouterr().err
