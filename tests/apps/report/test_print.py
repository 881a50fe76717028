"""The report of a print: whole in itself, honest about missing data, with the structure as meshes."""

from __future__ import annotations

import re
import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cablewright.apps.pictures.print import states_picture
from cablewright.apps.report.document import script
from cablewright.apps.report.print import write
from cablewright.foundation.signals import PrintState
from cablewright.live.prints.record import record
from cablewright.live.prints.result import PrintRecord, Span
from cablewright.printing.stl import read_stl
from print_logs import SPEED, printed, standard, without
from twins import TWIN, head


@pytest.fixture(scope="module")
def found() -> PrintRecord:
    entries, track, twin = standard()
    return record(entries, head(), track, print_speed=SPEED, true_structure=twin.rig.ground.field)


@pytest.fixture(scope="module")
def folder(found: PrintRecord, tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("print")
    report = write(found, made, "three <b>rounds</b>", np.geomspace(1e-4, 3e-3, 1000))
    assert report == made / "report.html"
    return made


def asks_nobody(page: str) -> None:
    own = page.replace(script(), "")  # three.js names specifications and its own pages
    assert "http://" not in own
    assert "https://" not in own
    assert "default-src 'none'" in page
    assert "<link" not in page
    for source in re.findall(r'src="([^"]{0,20})', page):
        assert source.startswith("data:image/png")


def test_the_page_is_whole_in_itself(folder: Path) -> None:
    page = (folder / "report.html").read_text()
    asks_nobody(page)
    assert "<b>rounds" not in page
    assert "three &lt;b&gt;rounds" in page
    assert page.count("<img") == len(list(folder.glob("*.png"))) >= 11
    assert not re.search(r"\bnan\b", page)
    assert "Not finished" in page
    assert "0 of 3 layers" in re.sub(r"</?a\b[^>]*>", "", page)
    assert "the light barrier is broken" in page
    assert "Beside the paper" in page
    assert {f.name for f in folder.iterdir() if f.suffix != ".png"} == {"report.html", "structure.stl", "structure.glb"}


def test_figures_of_the_page_are_those_of_the_metrics(found: PrintRecord, folder: Path) -> None:
    page, told = (folder / "report.html").read_text(), found.to_dict()
    assert f"{1e6 * told['path_error_variance']:.4g}" in page
    assert f"{1e3 * told['mean_speed']:.4g}" in page
    assert f"{told['structure']['mass']:.4g}" in page
    head, *rows = re.findall(r"<tr>(.*?)</tr>", page[page.index("Lines: load and slack") :], re.DOTALL)[:5]
    assert "taut, %" in head
    for line, row in zip(told["lines"], rows, strict=True):
        cells = re.findall(r"<td[^>]*>(.*?)</td>", row)
        assert cells[0] == line["name"]
        assert [float(cell) for cell in cells[1:3]] == pytest.approx(
            [1e2 * line["taut"], 1e2 * line["true_taut"]], abs=0.5
        )


def test_the_structure_is_a_closed_body_of_its_volume(found: PrintRecord, folder: Path) -> None:
    mesh = read_stl(folder / "structure.stl")
    assert mesh.is_closed
    wide, deep, _ = np.ptp(mesh.vertices, axis=0)
    assert found.structure is not None
    assert found.structure.true is not None
    assert mesh.volume - 0.01 * wide * deep == pytest.approx(found.structure.true.volume, rel=1e-3)
    magic, version, length = struct.unpack("<4sII", (folder / "structure.glb").read_bytes()[:12])
    assert (magic, version, length) == (b"glTF", 2, (folder / "structure.glb").stat().st_size)


@pytest.mark.usefixtures("undrawn_here")
@pytest.mark.parametrize("missing", [("truth",), ("estimate", "truth"), ("progress",)])
def test_missing_data_is_left_out(missing: tuple[str, ...], tmp_path: Path) -> None:
    entries, track, _ = standard()
    found = record(without(entries[:1200], *missing), head(), track, print_speed=SPEED)
    page = write(found, tmp_path, "part").read_text()
    asks_nobody(page)
    assert not re.search(r"\bnan\b", page)
    assert (tmp_path / "path.png").exists() == (missing == ("truth",))
    assert (tmp_path / "drum.png").exists() == ("estimate" not in missing)
    assert (tmp_path / "structure.stl").exists() == ("estimate" not in missing)


def test_a_machine_without_lidars_and_radii_is_recorded() -> None:
    entries, track, _ = standard()
    bare = TWIN.with_owner(lidars={}, line_angles=None)
    robot = head().robot
    lines = tuple(
        line.model_copy(update={"winch": line.winch.model_copy(update={"drum_radius": None})}) for line in robot.lines
    )
    poor = replace(head(bare), robot=robot.model_copy(update={"lines": lines, "name": "poor"}))
    found = record(entries[:1200], poor, track, print_speed=SPEED)
    assert found.structure is None
    assert all(np.isnan(line.irregularity) for line in found.lines)


def test_a_quasi_static_print_has_no_frequencies() -> None:
    entries, track, _ = printed(40.0, seed=5, plant="quasi-static")
    found = record(entries, head(plant="quasi-static"), track, print_speed=SPEED)
    assert np.isnan(found.vibration.frequencies).all()
    assert found.true.error.size < 0.05
    assert found.distance == pytest.approx(SPEED * 39.0, abs=0.1)


def test_every_state_is_drawn() -> None:
    entries, track, _ = standard()
    found = record(iter(entries), head(), track, print_speed=SPEED)
    spans = tuple(Span(state, float(k), k + 1.0, "") for k, state in enumerate(PrintState))
    drawn = states_picture(replace(found, spans=spans))
    assert drawn is not None
    names = [label.get_text() for label in drawn.axes[0].get_yticklabels()]
    assert names == [str(state) for state in reversed(PrintState)]
