"""Comments, objects, line types, what lays, and what is outside the part."""

import io
import tracemalloc

import numpy as np
import pytest

from cablewright.foundation.errors import InputError
from cablewright.printing import annotations
from cablewright.printing.gcode import parse
from cablewright.printing.job import load_job
from cablewright.printing.line_types import LineType


class TestComments:
    @pytest.mark.parametrize(
        "line",
        [
            "G1 X10 Y5 (a (b) c)",
            "(a (b (c)) d) G1 X10 Y5",
            "G1 (a (b)) X10 (c) Y5 (d",
            "G1 X10 Y5 (a ; (b)) ; c (",
            "G1 X10 Y5 ; (((",
            "N3 (N4 (N5)) G1 X10 Y5",
            "G1 X10 Y5 ;" + "x" * 100_000,
            "G1 X10 Y5 (" + "x" * 600_000 + ")",
            "(" + "x(y)" * 200_000 + ") G1 X10 Y5",
            "(" + "x" * 600_000 + ") G1 X10 (" + "y" * 600_000 + ") Y5 ; " + "z" * 600_000,
        ],
        ids=lambda line: line[:40],
    )
    def test_of_any_length_and_depth(self, line, points):
        assert points(line) == [(10, 5, 0)]

    def test_display_text_needs_no_match(self, points):
        assert points("M117 (a (b\nRESPOND MSG=((\nG1 X1") == [(1, 0, 0)]

    def test_a_marker_of_any_length(self, read):
        assert read(";LAYER:3 " + "x" * 300_000 + "\nG1 X1 E1\n").layer.tolist() == [3]

    def test_a_huge_comment_takes_no_memory(self):
        class Endless(io.RawIOBase):
            left = 400

            def read(self, size=-1):
                self.left -= 1
                return b"G1 X1 E1\n;" if self.left == 399 else b"x" * size if self.left > 0 else b""

        tracemalloc.start()
        path = parse(Endless())
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert len(path.line) == 1
        assert peak < 8 << 20


class TestLayerMarkers:
    @pytest.mark.parametrize(
        ("markers", "layers", "by"),
        [
            (("; CHANGE_LAYER", ";CHANGE_LAYER", "; CHANGE_LAYER\r"), [1, 2, 3], "; CHANGE_LAYER"),
            (("; CHANGE_LAYER\n; Z_HEIGHT: 0.2\n; layer num/total_layer_count: 1/2",) * 2, [1, 2], "; CHANGE_LAYER"),
            ((";LAYER_CHANGE\n;Z:0.2\n;HEIGHT:0.2", ";LAYER_CHANGE\n;Z:0.4"), [1, 2], ";LAYER_CHANGE"),
            ((";Z:0.2", ";Z:0.4", ";Z:0.4", ";Z:0.6"), [1, 2, 2, 3], ";Z:"),
            ((";Z:0.2", ";LAYER:7"), [0, 7], ";LAYER:n"),
            (("(<layer> 0.4 )", "(<layer> 0.8 )"), [1, 2], "(<layer> z)"),
            (
                ("; BEGIN_LAYER_OBJECT z=0.20 z_thickness=0.20", "; BEGIN_LAYER_RAFT z=0.40"),
                [1, 2],
                "; BEGIN_LAYER_OBJECT",
            ),
            (("(LAYER 1)", "(LAYER 2)", "(layer: 4)", "(Layer #5, z = 3)"), [1, 2, 4, 5], "(LAYER n)"),
            (("; LAYER 1", ";Layer: 2", "; Layer #3", ";; --- layer 4 (0.25mm @ 1.00mm)"), [1, 2, 3, 4], "; layer n"),
            ((";HEIGHT:0.2", ";HEIGHT:0.3"), [1, 1], "height"),
        ],
    )
    def test_of_slicers(self, markers, layers, by, read):
        path = read("M83\nG1 X9\n" + "".join(f"{marker}\nG1 X0\nG1 X1 E1\n" for marker in markers))
        assert path.layer[path.extruding].tolist() == layers
        assert path.layers_by == by

    def test_a_marker_after_all_material_is_none(self, read):
        path = read("M83\nG1 X1 E1\nG1 Z1\nG1 X2 E1\n;LAYER:5\n")
        assert (path.layer_count, path.layers_by) == (2, "height")

    def test_said_bead_heights(self, read):
        path = read("M83\nG1 X1 E1\n;HEIGHT:0.3\nG1 X2 E1\nG1 X3 E1\n; LAYER_HEIGHT: 0.2\nG1 X4 E1\n")
        assert path.bead_height == pytest.approx([np.nan, 3e-4, 3e-4, 2e-4], nan_ok=True)


class TestLineTypes:
    def test_per_move(self, read):
        path = read(
            "M83\nG1 X1 E1\n;TYPE:External perimeter\nG1 X2 E1\nG0 X3\n;TYPE:FILL\r\nG1 X4 E1\nG1 E-1\nG1 X5 E2\n"
        )
        assert path.kind.tolist() == [1, 2, 0, 5, 0, 5]
        assert not path.kind.flags.writeable

    @pytest.mark.parametrize(
        ("comment", "kind"),
        [
            (";TYPE:Overhang perimeter", LineType.OVERHANG),
            ("; FEATURE: Internal Bridge", LineType.BRIDGE),
            (";TYPE:SUPPORT-INTERFACE", LineType.SUPPORT),
            (";TYPE:PRIME_TOWER", LineType.PRIME),
            (";TYPE:Gap fill", LineType.GAP_FILL),
            ("; feature raft", LineType.SKIRT),
            ("; outer perimeter", LineType.OUTER_PERIMETER),
            ("; solid layer", LineType.SOLID_INFILL),
            ("; 'Stacked Sparse Infill Path', 1.0 [feed mm/s]", LineType.INFILL),
            ("(<loop> outer )", LineType.OUTER_PERIMETER),
            ("(<edge> inner )\r", LineType.INNER_PERIMETER),
            ("(<infill>)\n(</infill>)", LineType.UNSPECIFIED),
        ],
    )
    def test_of_slicers(self, comment, kind, read):
        assert read(f"M83\n{comment}\nG1 X1 E1\n").kind.tolist() == [kind]

    def test_an_unknown_type_is_named(self, read):
        path = read("M83\n;TYPE:Zigzag seam\nG1 X1 E1\n;TYPE:Zigzag seam\nG1 X2 E1\n")
        assert path.kind.tolist() == [LineType.OTHER] * 2
        assert path.unknown == {";TYPE:Zigzag seam": 2}

    def test_before_the_first_layer(self, read):
        assert read("M83\nG1 X1 E1\n;LAYER:0\nG1 X2 E1\n").kind.tolist() == [LineType.PRIME, LineType.UNSPECIFIED]

    @pytest.mark.parametrize("comment", ["; a comment", "; support us", ";TYPE:", "; feature", "; feature_x = 1"])
    def test_plain_comments(self, comment, read):
        path = read(f"M83\n{comment}\nG1 X1 E1\n")
        assert path.kind.tolist() == [LineType.UNSPECIFIED]
        assert path.unknown == {}


class TestObjects:
    def test_klipper_labels(self, read):
        path = read(
            "M83\nEXCLUDE_OBJECT_DEFINE NAME=a CENTER=1,2 POLYGON=[[0,0],[1,1]]\n"
            "EXCLUDE_OBJECT_START NAME=Abc_1\nG1 X1 E1\nEXCLUDE_OBJECT_END NAME=Abc_1\nG1 X2\n"
            "EXCLUDE_OBJECT_START NAME='b c'\nG1 X3 E1\nEXCLUDE_OBJECT_START NAME=Abc_1\nG1 X4 E1\n"
        )
        assert path.objects == ("Abc_1", "b c")
        assert path.object.tolist() == [0, -1, 1, 0]
        assert path.unknown == {}

    def test_m486(self, read):
        path = read("M83\nM486 T2\nM486 S0\nM486 Aleft\nG1 X1 E1\nM486 S-1\nG1 X2\nM486 S1\nG1 X3 E1\n")
        assert path.objects == ("left", "1")
        assert path.object.tolist() == [0, -1, 1]

    def test_number_is_bounded(self, monkeypatch, read):
        monkeypatch.setattr(annotations, "MAX_OBJECTS", 10)
        with pytest.raises(InputError, match=r"line 12: 'M486 S10': more than 10 objects"):
            read("M83\n" + "".join(f"M486 S{n}\n" for n in range(20)) + "G1 X1 E1\n")

    def test_names_are_one_short_line(self, read):
        path = read(b"M83\n; printing object \x1b[31m\xff" + b"x" * 250 + b"\nG1 X1 E1\n")
        assert len(path.objects[0]) == 100
        assert path.objects[0].isprintable()


PUMP = "G21\nG0 X1\n{on}\nG1 X2\nG4 P5\nG0 X3\n{off}\nG1 X4\nG28\n"


class TestWithoutE:
    @pytest.mark.parametrize(
        ("on", "off", "material"),
        [
            ("M101", "M103", "E"),
            ("M101", "M102", "M101"),
            ("M106", "M107", "M106"),
            ("M106 S255", "M106 S0", "M106"),
            ("M3 S1000", "M5", "M3"),
            ("M4", "M3 S0.0", "M3"),
        ],
    )
    def test_a_switch(self, on, off, material):
        path = parse(io.BytesIO(PUMP.format(on=on, off=off).encode()), material=material)
        assert path.extruding.tolist() == [False, True, False, True, False, False]
        assert path.extrusion == pytest.approx([0, 1e-3, 0, 1e-3, 0, 0])
        assert path.material_by == (material if material != "E" else "M101")
        assert path.unknown == {}

    def test_every_g1(self):
        path = parse(io.BytesIO(b"G0 X1\nG1 X2\nX3\nG00 Y1\nY2\nG2 X4 Y2 R0.5\nG28\n"), 1.0, material="every G1")
        assert path.extruding.tolist() == [False, True, True, False, False] + [True] * 32 + [False]

    def test_an_axis(self):
        path = parse(io.BytesIO(b"G92 A0 E0\nG1 X1 A1 E7\nG1 X2 A2\nG1 A1\nG1 X3\n"), material="A")
        assert path.extrusion == pytest.approx([1e-3, 1e-3, -1e-3, 0])
        assert path.unknown == {"E": 2}
        with pytest.raises(InputError, match="A is given twice"):
            parse(io.BytesIO(b"G1 X1 A1 A2\n"), material="A")

    def test_e_rules_where_it_extrudes(self, read):
        path = read("M101\nG1 X1 E1\nM103\nG1 X2 E2\n")
        assert path.extruding.tolist() == [True, True]
        assert path.unknown == {"M101": 1, "M103": 1}

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            ("M106\nG1 X1\nM107\n", 'The file has M106: in a job file, material = "M106" lays material by it'),
            ("G1 X1 A1\nM3\n", 'The file has M3, A: in a job file, material = "A" or material = "M3" lays'),
            ("G1 X1\n", "at least one move must increase E"),
        ],
    )
    def test_what_to_do(self, text, message, read):
        with pytest.raises(InputError) as caught:
            read(text)
        assert message in str(caught.value)

    def test_nothing_while_it_is_on(self):
        with pytest.raises(InputError, match="no move while M3 is on"):
            parse(io.BytesIO(b"G1 X1\nM3\nM5\n"), material="M3")
        with pytest.raises(InputError, match="no G1, G2 or G3 has a length"):
            parse(io.BytesIO(b"G0 X1\n"), material="every G1")

    def test_in_a_job(self, tmp_path):
        (tmp_path / "part.gcode").write_text("G0 X1\nG1 X2\n")
        (tmp_path / "job.toml").write_text('schema = 1\nname = "w"\ngcode = "part.gcode"\nmaterial = "every G1"\n')
        assert load_job(tmp_path / "job.toml").toolpath().extruding.tolist() == [False, True]
        (tmp_path / "bad.toml").write_text('schema = 1\nname = "w"\ngcode = "part.gcode"\nmaterial = "M7"\n')
        with pytest.raises(InputError, match="material = 'M7': must be 'E', 'A', 'M101', 'M106', 'M3' or 'every G1'"):
            load_job(tmp_path / "bad.toml")


class TestOutsideThePart:
    def test_home_park_and_return(self, read):
        path = read(
            "M83\nG1 X5 Y5\nG1 X10 E1\n;LAYER:0\nG1 X50 Y50\nG1 X60 E1\nG1 X55 Y55\nG1 Y60 E1\n"  # 0 1 | 2 3 4 5
            "G1 X0 Y0\nG1 X50 Y50\nG1 X51 E1\nG28 X\nG1 X50\nG1 Y51 E1\nG1 X0 Y0\n"  # 6 7 8 9 10 11 12
        )
        assert path.homing.tolist() == [False] * 9 + [True] + [False] * 3
        assert np.flatnonzero(path.in_part).tolist() == [3, 4, 5, 8, 11]

    def test_a_part_and_nothing_else(self, read):
        assert read("M83\nG1 X1 E1\nG1 X2\nG1 X3 E1\n").in_part.all()


@pytest.mark.parametrize(
    ("header", "slicer"),
    [
        (";FLAVOR:Marlin\n;Generated with Cura_SteamEngine 5.4.0\n", "Cura_SteamEngine 5.4.0"),
        ("; generated by PrusaSlicer 2.7.1+win64 on 2024-01-01 at 00:00:00 UTC\n", "PrusaSlicer 2.7.1"),
        ("(generated by wall maker)\n", "wall maker"),
        ("G1 X0 ; generated by no one\n", ""),
        ("", ""),
    ],
)
def test_slicer(header, slicer, read):
    assert read(header + "G1 X1 E1\n").slicer == slicer
