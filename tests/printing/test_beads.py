"""Beads of a part, move by move: as slicers write them, by E and heights of layers, and what is odd is said."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cablewright.foundation.errors import InputError
from cablewright.printing.beads import Bead, Beads, beads_of, section, width_of
from cablewright.printing.growing_part import deposit
from cablewright.printing.job import Job, load_job
from cablewright.robot import load
from cablewright.studies.checks.check import check

SIZE = st.floats(1e-4, 0.2)
FILAMENT = 0.25 * math.pi * 1.75**2  # mm^2


def part(layers: int = 3, rise: float = 0.6, comment: str = "", e: float = 1.0, header: str = "", unit: float = 1.0):
    """G-code of a square of 40 mm. *e*: for each mm; *comment*: before each side; *unit*: mm of the file's unit."""
    lines = [header, "G21" if unit == 1.0 else "G20", "G90", "M83"]
    corners = [(20, -20), (20, 20), (-20, 20), (-20, -20)]
    for layer in range(layers):
        lines += [f";LAYER:{layer}", f"G0 X{-20 / unit:.5f} Y{-20 / unit:.5f} Z{(layer + 1) * rise / unit:.5f}"]
        for x, y in corners:
            lines += [comment, f"G1 X{x / unit:.5f} Y{y / unit:.5f} E{40 * e / unit:.6f}"]
    return "\n".join(line for line in lines if line) + "\n"


def beads(read, text: str, given: Bead | None = None, scale: float = 1.0) -> Beads:
    return beads_of(read(text), scale, given, "as given")


@given(SIZE, SIZE)
def test_the_width_of_a_section_is_that_it_was_made_of(width: float, height: float) -> None:
    found = width_of(section(np.array(width), np.array(height)), np.array(height))
    assert float(found) == pytest.approx(width, rel=1e-9)


def test_a_section_is_a_rectangle_with_half_circles() -> None:
    assert Bead(width=0.005, height=0.002).section == pytest.approx(0.003 * 0.002 + math.pi * 0.001**2)


@pytest.mark.parametrize(
    "comment",
    [
        ";WIDTH:1.2\n;HEIGHT:0.6",
        "; LINE_WIDTH: 1.2\n; LAYER_HEIGHT: 0.6",
        "; tool H0.600 W1.200",
        ";TYPE:External perimeter\n;WIDTH:1.20000\n;HEIGHT:0.6",
    ],
)
@pytest.mark.parametrize("scale", [1.0, 20.0])
def test_widths_and_heights_of_comments(read, comment: str, scale: float) -> None:
    found = beads(read, part(comment=comment), scale=scale)
    assert found.source == "by the file's comments"
    assert found.typical.width == pytest.approx(1.2e-3 * scale)
    assert found.typical.height == pytest.approx(6e-4 * scale)
    assert found.width.strides == (0,)  # one number for all moves needs no memory
    assert not found.notes


def test_each_move_has_its_own_bead(read) -> None:
    text = "M83\nG1 X0 Y0 Z0.2\n;HEIGHT:0.2\n"
    widths = [0.4, 0.4, 0.55, 0.7, 0.55]
    text += "".join(f";WIDTH:{width}\nG1 X{10 * (at + 1)} E1\n" for at, width in enumerate(widths))
    path = read(text)
    found = beads_of(path, 1.0, None, "")
    np.testing.assert_allclose(found.width[path.extruding], np.array(widths) * 1e-3)
    job = Job(name="a", gcode=Path("a"))
    samples = job.samples(path, 1.0)
    boxes = deposit(samples, found)
    np.testing.assert_allclose(2e3 * boxes.half[:, 1], widths)
    np.testing.assert_allclose(boxes.half[:, 2], 1e-4)


@pytest.mark.parametrize(
    ("header", "per_mm"),
    [
        ("; filament_diameter = 1.75", 1.0 / FILAMENT),
        ("; filament_diameter = 1.75,1.75", 1.0 / FILAMENT),
        (";   filamentDiameters,1.75|1.75", 1.0 / FILAMENT),
        ("; fiber_dia_mm = 1.75", 1.0 / FILAMENT),
        (";Filament Diameter #1: 1.75", 1.0 / FILAMENT),
        ("; use_volumetric_e = 1", 1.0),
        (";FLAVOR:UltiGCode", 1.0),
        ("M200 D1.75", 1.0),
    ],
)
@pytest.mark.parametrize("width", [0.5, 1.2, 3.0])
def test_e_is_the_volume_of_the_bead(read, header: str, per_mm: float, width: float) -> None:
    area = 0.6 * (width - 0.6) + 0.25 * math.pi * 0.6**2 if width >= 0.6 else None
    area = width * (0.6 - width) + 0.25 * math.pi * width**2 if area is None else area
    found = beads(read, part(e=area * per_mm, header=header))
    assert found.typical.width == pytest.approx(width * 1e-3, rel=1e-4)
    assert found.typical.height == pytest.approx(6e-4)
    assert found.width_by.startswith("by E")
    assert found.height_by == "by the heights of layers"


def test_an_unretraction_while_moving_is_no_wide_bead(read) -> None:
    text = part(e=0.3, header="; filament_diameter = 1.75") + "G1 X-19.999 E5\n"
    found = beads(read, text)
    assert np.nanmax(found.width) == pytest.approx(found.typical.width)


def test_without_any_width_it_follows_the_height_and_never_exceeds_the_default(read) -> None:
    assert beads(read, part(rise=0.2)).typical.width == pytest.approx(6e-4)
    assert beads(read, part(rise=500.0)).typical == Bead()
    assert beads(read, part(rise=0.2, header=";   extruderWidth,0.48")).typical.width == pytest.approx(4.8e-4)


def test_layers_of_their_own_height_have_their_own_beads(read) -> None:
    text = "M83\n" + "".join(f"G1 Z{z} F600\nG1 X10 E1\nG1 X0 E1\n" for z in (0.3, 0.5, 0.7, 1.0))
    found = beads(read, text)
    np.testing.assert_allclose(found.height[np.isfinite(found.height)], np.repeat([3e-4, 2e-4, 2e-4, 3e-4], 2))


def test_two_parts_one_after_the_other_do_not_confuse_heights(read) -> None:
    once = "".join(f";LAYER_CHANGE\nG1 Z{z}\nG1 X10 E1\nG1 X0 E1\n" for z in (0.2, 0.4, 0.6))
    assert beads(read, "M83\n" + once + once).typical.height == pytest.approx(2e-4)


def test_a_vase_without_markers_has_no_layers(read) -> None:
    turn = "".join(
        f"G1 X{10 * math.cos(0.1 * i):.3f} Y{10 * math.sin(0.1 * i):.3f} Z{0.003 * i:.4f} E0.1\n" for i in range(300)
    )
    assert beads(read, "M83\n" + turn).typical == Bead()
    assert beads(read, "; layer_height = 0.2\nM83\n" + turn).typical.height == pytest.approx(2e-4)


def test_given_sizes_count_and_the_rest_is_of_the_file(read, tmp_path: Path) -> None:
    text = part(comment=";WIDTH:1.2\n;HEIGHT:0.6")
    assert beads(read, text, Bead(width=0.002, height=0.001)).typical == Bead(width=0.002, height=0.001)
    (tmp_path / "part.gcode").write_text(text)
    (tmp_path / "job.toml").write_text(
        'schema = 1\nname = "a"\ngcode = "part.gcode"\nscale = 10\n[bead]\nwidth = "15 mm"\n'
    )
    job = load_job(tmp_path / "job.toml")
    found = job.beads(job.toolpath())
    assert (found.typical.width, found.typical.height) == pytest.approx((0.015, 0.006))
    assert found.source == "width by the job file, height by the file's comments"
    assert job.typical_bead() == (found.typical, found.differing)
    assert job.beads(job.toolpath(), Bead(width=0.001, height=0.0005)).source == "as given"


def test_numbers_without_a_file_keep_their_bead() -> None:
    helix = {"radius": 1.0, "layers": 2, "layer_height": 0.01}
    job = Job(name="a", helix=helix)
    assert job.beads(job.toolpath()).typical == Bead()
    assert job.beads(job.toolpath()).source == "assumed"
    assert Job(name="a", helix=helix, bead=Bead(width=0.03)).beads(job.toolpath()).typical == Bead(width=0.03)


@pytest.mark.parametrize(
    ("text", "note"),
    [
        (part(comment=";WIDTH:0\n;HEIGHT:0.6"), "12 moves have a width or height of 0 or less"),
        (part(comment=";WIDTH:-1.2"), "12 moves have a width or height of 0 or less"),
        (part(comment=";WIDTH:1.2\n;HEIGHT:0.6", e=4.0, header="; filament_diameter = 1.75"), "contradict its E"),
        (part(comment=";WIDTH:1.2\n;HEIGHT:0.2"), "beads are 0.2 mm high by the file's comments, which are used, but"),
        (part(comment=";WIDTH:0.0472\n;HEIGHT:0.0236"), "taken for inches: its layers rise by 0.6 mm"),
        (part(comment=";WIDTH:0.0472\n;HEIGHT:0.0236", unit=25.4), "taken for inches: its layers rise by 0.6 mm"),
        (part(comment=";WIDTH:0.0472"), "taken for inches"),
        (part(comment=";WIDTH:80\n;HEIGHT:0.6"), "the bead is 80 mm wide, the part 40 mm"),
        ("M83\n;LAYER:0\n;TYPE:Custom\nG1 Z0.2\nG1 X90 E9\n", "all that is laid is a purge or prime line"),
        ("M83\nG1 Z0.2\nG1 X90 E9\n;LAYER:0\nG1 X0\n", "all that is laid is a purge or prime line"),
    ],
)
def test_odd_beads_are_said(read, text: str, note: str) -> None:
    assert any(note in each for each in beads(read, text).notes), beads(read, text).notes


@pytest.mark.parametrize("unit", [1.0, 25.4])
def test_inches_are_converted_and_millimetres_in_a_file_of_inches_are_not(read, unit: float) -> None:
    for comment in (";WIDTH:0.04724\n;HEIGHT:0.02362", ";WIDTH:1.2\n;HEIGHT:0.6"):
        found = beads(read, part(comment=comment, unit=unit))
        assert found.typical.width == pytest.approx(1.2e-3, rel=1e-3)
        assert found.typical.height == pytest.approx(6e-4, rel=1e-3)


def test_zero_widths_leave_the_others(read) -> None:
    text = part(layers=2, comment=";WIDTH:1.2") + part(layers=1, comment=";WIDTH:0")
    found = beads(read, text)
    assert found.typical.width == pytest.approx(1.2e-3)
    assert np.nanmin(found.width) > 0.0


def test_a_check_judges_by_the_strand_of_the_file(tmp_path: Path) -> None:
    """Half of a strand of 1.2 mm is allowed, not half of the default of 60 mm."""
    file = tmp_path / "part.gcode"
    file.write_text(part(comment=";WIDTH:1.2\n;HEIGHT:0.6"))
    found = check(load("merlet2023"), file, skip=("interference",))
    assert found.allowed_error == pytest.approx(6e-4)
    assert not found.feasible
    assert "(allowed: at most 0.6 mm)" in found.verdict
    given = check(load("merlet2023"), file, skip=("interference",), bead=Bead(width=0.06, height=0.02))
    assert given.allowed_error == pytest.approx(0.03)
    assert given.beads.source == "as given"


def test_each_strand_allows_half_of_its_own_width(tmp_path: Path) -> None:
    """Wide strands, and narrow ones in the middle of them: the narrow ones decide."""
    file = tmp_path / "part.gcode"
    wide, narrow = (part(1, comment=f";WIDTH:{width}\n;HEIGHT:20", rise=20) for width in (60, 2))
    file.write_text(wide + narrow.replace("40", "4").replace("20", "2"))
    found = check(load("merlet2023"), file, skip=("interference",))
    finding = next(each for each in found.findings if each.limit == "expected error")
    assert finding.allowed[1] == pytest.approx(1e-3)
    assert 0 < finding.violations < np.count_nonzero(found.samples.extruding)


def test_a_line_touches_a_thick_strand_and_not_a_thin_one(tmp_path: Path) -> None:
    """The part is as tall in both: what the lines must clear is as high and wide as the strands are."""
    file = tmp_path / "part.gcode"
    file.write_text(part(2, rise=0.6, comment=";WIDTH:1.2\n;HEIGHT:0.6"))
    skip = ("expected-error",)
    thin = check(load("merlet2023"), file, skip=skip)
    thick = check(load("merlet2023"), file, skip=skip, bead=Bead(width=2.0, height=0.6))
    assert thin.nearest.margin > thick.nearest.margin


@pytest.mark.parametrize("text", ["1.2mm", "1.2mm,0", "a,b", "1,2,3", "-1,1", "1 kg,1 m", "1e9,1"])
def test_options_that_are_no_bead(text: str) -> None:
    from cablewright.apps.cli.parsing import bead_size

    with pytest.raises(InputError, match="--bead"):
        bead_size(text)
    assert bead_size("1.2mm,0.6 mm") == Bead(width=0.0012, height=0.0006)
    assert bead_size("0.0012,0.0006") == Bead(width=0.0012, height=0.0006)


def test_beads_that_differ_are_said_where_a_machine_lays_all_with_one(read) -> None:
    one = ";LAYER_CHANGE\n;WIDTH:{}\n;HEIGHT:0.2\nG1 Z0.2\nG1 X10 E1\nG1 X0 E1\n"
    assert beads(read, "M83\n" + one.format(0.4)).differing == ()
    (note,) = beads(read, "M83\n" + one.format(0.4) + one.format(0.8) * 3).differing
    assert note.startswith("beads are 0.4 mm to 0.8 mm wide and 0.2 mm to 0.2 mm high in the file")
    assert note.endswith("lays all with the middle ones, 0.8 mm and 0.2 mm")


def test_a_file_in_inches_without_g20_is_named(read) -> None:
    layers = "".join(f";LAYER_CHANGE\nG1 Z{0.0079 * k:.4f}\nG1 X4 E0.1\nG1 X0 E0.1\n" for k in range(1, 5))
    assert any("is the file in inches, without G20" in note for note in beads(read, "M83\n" + layers).notes)
    assert not any("in inches" in note for note in beads(read, "G20\nM83\n" + layers).notes)
