"""Profiles for slicers: outlines that the robot reaches, speeds that winches have, and slices where a slicer is."""

from __future__ import annotations

import json
import math
import os
import re
import shutil
import subprocess
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import cablewright as cw
from cablewright.apps.cli.main import run
from cablewright.exchange.firmware import firmware
from cablewright.exchange.slicers.formats import slicer_files
from cablewright.exchange.slicers.profile import SWING, profile_of
from cablewright.exchange.translation_result import Notes
from cablewright.foundation.errors import InputError
from cablewright.printing.job import Bead, load_job
from cablewright.robot import Robot, load

BEAD = Bead(width=1.2e-3, height=0.6e-3)


@pytest.fixture(scope="module")
def hangprinter() -> Robot:
    return load("hangprinter-v4")


def outline(text: list[str]) -> np.ndarray:
    return np.array([[float(each) for each in corner.split("x")] for corner in text])


def ini(text: str) -> dict[str, str]:
    return dict(line.split(" = ", 1) for line in text.splitlines() if not line.startswith("#"))  # type: ignore[misc]


def test_all_of_the_bed_is_held(hangprinter: Robot) -> None:
    """At the outline, and half-way between its corners, from the bed to its height."""
    found = json.loads(slicer_files("orca", hangprinter, BEAD).files["orca-machine.json"])
    corners = outline(found["printable_area"]) / 1e3
    tall = float(found["printable_height"]) / 1e3
    assert len(corners) == 48
    assert tall > 0.3
    for z in (0.0, 0.5 * tall, tall):
        held = cw.inverse(hangprinter, np.column_stack([corners, np.full(len(corners), z)]))
        assert held.ok.all()
    area = 0.5 * abs(sum(a[0] * b[1] - a[1] * b[0] for a, b in pairwise([*corners, corners[0]])))
    assert 0.2 < area < 2.5


def test_a_bed_over_the_limit_of_a_slicer_is_scaled(hangprinter: Robot) -> None:
    """PrusaSlicer has beds up to 1200 mm: all lengths are halved, and the job's scale is 2."""
    made = slicer_files("prusa", hangprinter, BEAD)
    values, other = ini(made.files["prusa.ini"]), slicer_files("orca", hangprinter, BEAD).files["orca-machine.json"]
    assert "print with scale = 2 in the job file" in " ".join(made.assumed)
    corners = outline(values["bed_shape"].split(","))
    assert 600.0 < np.ptp(corners, axis=0).max() <= 1200.0
    np.testing.assert_allclose(2.0 * corners, outline(json.loads(other)["printable_area"]), atol=0.01)
    assert values["layer_height"] == "0.3"
    assert values["external_perimeter_extrusion_width"] == "0.6"
    assert values["gcode_label_objects"] == "1"
    assert "M84" not in values["end_gcode"].replace("no M84", "")


def test_speeds_are_those_of_the_slowest_winch(hangprinter: Robot) -> None:
    """A winch of 80 mm/s with two spans moves the nozzle at 40 mm/s along its line."""
    lines = tuple(
        line.model_copy(update={"winch": line.winch.model_copy(update={"max_speed": 0.08})})
        for line in hangprinter.lines
    )
    slow = hangprinter.model_copy(update={"lines": lines})
    made = json.loads(slicer_files("orca", slow, BEAD).files["orca-process.json"])
    assert made["outer_wall_speed"] == made["travel_speed"] == "40"


def test_the_acceleration_is_that_of_the_lowest_mode(hangprinter: Robot) -> None:
    """A mass on a spring yields by a over the square of its angular frequency."""
    found = profile_of(hangprinter, BEAD, 100.0, Notes())
    places = np.array([[*found.centre, found.bed + share * found.tall] for share in (0.0, 0.5, 1.0)])
    lowest = min(float(np.min(cw.modes(cw.inverse(hangprinter, at)).frequencies)) for at in places)
    assert found.acceleration / (2 * math.pi * lowest) ** 2 == pytest.approx(SWING * 1.2e-3, rel=1e-3)


def test_cura_has_a_rectangle_within_the_outline(hangprinter: Robot) -> None:
    made = slicer_files("cura", hangprinter, BEAD)
    values = {key: each["default_value"] for key, each in json.loads(made.files["cura.def.json"])["overrides"].items()}
    half = 0.5e-3 * np.array([values["machine_width"], values["machine_depth"]])
    corners = np.array([[a, b] for a in (-1, 1) for b in (-1, 1)]) * half
    tall = 1e-3 * values["machine_height"]
    for z in (0.0, tall):
        assert cw.inverse(hangprinter, np.column_stack([corners, np.full(4, z)])).ok.all()
    assert values["machine_center_is_zero"] is True


def test_a_plane_has_no_bed() -> None:
    with pytest.raises(InputError, match="a slicer needs a bed"):
        slicer_files("prusa", load("maslow4"), BEAD)


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    given = ["export", "slicer", "hangprinter-v4", "--out", str(tmp_path / "out")]
    for more, why in (
        ([], "--for = None: must be orca or prusa or cura"),
        (["--for", "rrf", "--bead", "1mm,1mm"], "--for = rrf: must be orca or prusa or cura"),
        (["--for", "orca"], "a slicer needs --bead WIDTH,HEIGHT"),
    ):
        assert run([*given, *more]) == 2
        assert why in capsys.readouterr().err
    assert run([*given, "--for", "orca", "--bead", "1.2mm,0.6mm"]) == 0
    assert {each.name for each in (tmp_path / "out").iterdir()} == {"orca-machine.json", "orca-process.json"}


def solid(outline_mm: list[tuple[float, float]], height: float) -> str:
    """An STL text of a prism."""
    facets, k = [], len(outline_mm)
    low, high = [(*each, 0.0) for each in outline_mm], [(*each, height) for each in outline_mm]
    for i in range(k):
        j = (i + 1) % k
        facets += [(low[i], low[j], high[j]), (low[i], high[j], high[i])]
        if 0 < i < k - 1:
            facets += [(low[0], low[i + 1], low[i]), (high[0], high[i], high[i + 1])]
    return "solid s\n" + "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join("vertex {} {} {}\n".format(*corner) for corner in facet)
        + "endloop\nendfacet\n"
        for facet in facets
    ) + "endsolid s\n"  # fmt: skip


def stl(folder: Path, spiral: bool) -> None:
    """Write the part to slice, 6 mm high: a block, or a cylinder for a spiral vase."""
    ring = [(30.0 * math.cos(a), 30.0 * math.sin(a)) for a in np.linspace(0.0, 2 * math.pi, 49)[:-1]]
    (folder / "part.stl").write_text(solid(ring if spiral else [(0, 0), (60, 0), (60, 40), (0, 40)], 6.0))


@pytest.mark.skipif(shutil.which("prusa-slicer") is None, reason="needs PrusaSlicer (Debian: prusa-slicer)")
@pytest.mark.parametrize("spiral", [False, True])
def test_prusa_slices_with_the_profile(spiral: bool, hangprinter: Robot, tmp_path: Path) -> None:
    """A block with labels, and a spiral vase: on the bed, with the profile's strands, and then for the firmware."""
    made = slicer_files("prusa", hangprinter, BEAD)
    (tmp_path / "prusa.ini").write_text(made.files["prusa.ini"])
    stl(tmp_path, spiral)
    command = ["prusa-slicer", "--load", "prusa.ini", "-g", "part.stl", "-o", "part.gcode", "--center", "0,0"]
    command += ["--spiral-vase", "--perimeters", "1", "--top-solid-layers", "0", "--fill-density", "0"] * spiral
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    text = (tmp_path / "part.gcode").read_text()
    assert ("printing object" in text) or spiral
    (tmp_path / "job.toml").write_text('schema = 1\nname = "part"\ngcode = "part.gcode"\nscale = 2.0\n')
    job = load_job(tmp_path / "job.toml")
    toolpath = job.toolpath()
    assert toolpath.layer_count == pytest.approx(20, abs=1)
    wide = toolpath.bead_width[toolpath.extruding]
    assert np.nanmedian(wide) == pytest.approx(0.6e-3, rel=0.05)
    laid = 2.0 * toolpath.end[toolpath.extruding]
    assert np.abs(laid[:, :2]).max() < 0.09  # with a skirt
    found = cw.check(hangprinter, job, skip=("interference", "expected-error"))
    assert found.verdict
    firmware("reprapfirmware", hangprinter, job)


DEFINITIONS = next(
    (folder for folder in map(Path, [*os.environ.get("CURA_ENGINE_SEARCH_PATH", "").split(":"),
                                     "/usr/share/cura/resources/definitions"])
     if (folder / "fdmprinter.def.json").is_file()), None,
)  # fmt: skip


@pytest.mark.skipif(
    shutil.which("CuraEngine") is None or DEFINITIONS is None, reason="needs CuraEngine and fdmprinter (Debian: cura)"
)
@pytest.mark.parametrize("spiral", [False, True])
def test_cura_slices_with_the_profile(spiral: bool, hangprinter: Robot, tmp_path: Path) -> None:
    """As PrusaSlicer does, by the engine alone: a block, and a spiral vase around zero."""
    (tmp_path / "cura.def.json").write_text(slicer_files("cura", hangprinter, BEAD).files["cura.def.json"])
    stl(tmp_path, spiral)
    command = ["CuraEngine", "slice", "-j", "cura.def.json", "-o", "part.gcode"]
    command += ["-s", "magic_spiralize=true", "-s", "adhesion_type=none"] if spiral else []
    done = subprocess.run(
        [*command, "-e0", "-s", "material_diameter=1.75", "-l", "part.stl"], cwd=tmp_path, capture_output=True,
        text=True, check=False, timeout=300, env=os.environ | {"CURA_ENGINE_SEARCH_PATH": f"{tmp_path}:{DEFINITIONS}"},
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    job = load_job(tmp_path / "part.gcode")
    toolpath = job.toolpath()
    assert toolpath.layer_count == pytest.approx(10, abs=1)
    laid = toolpath.end[toolpath.extruding]
    assert np.abs(laid[:, :2]).max() < 0.09  # with a skirt
    assert np.ptp(laid[:, 2]) == pytest.approx(5.4e-3, abs=1e-3)
    text = (tmp_path / "part.gcode").read_text()
    fed = sum(map(float, re.findall(r"(?m)^G1 (?:F\S+ )?X\S+ Y\S+(?: Z\S+)? E(\S+)", text)))
    length = 1e3 * np.linalg.norm(laid - toolpath.start[toolpath.extruding], axis=1).sum()
    assert fed * math.pi * 1.75**2 / 4.0 / (0.6 * length) == pytest.approx(1.2, rel=0.1)  # the strands' width, mm
    firmware("reprapfirmware", hangprinter, job)
