"""A small file of each dialect, read twice: by the package, and by a plain interpreter that shares nothing with it."""

import io
import re
from pathlib import Path

import numpy as np
import pytest

import plain_gcode
from cablewright.foundation.errors import InputError
from cablewright.printing.gcode import parse
from cablewright.printing.line_types import LineType
from cablewright.printing.toolpath import BY_HEIGHT

CORPUS = Path(__file__).parent / "corpus"
FILES = sorted(CORPUS.glob("*.gcode"))
MATERIAL = {"concrete_pump": "M3", "concrete_inches": "every G1", "clay_a_axis": "A", "foam_pump": "M106"}
"""What lays, for the files whose job has to say so."""
KNOWN = {
    # file: slicer, layers, what they come from, objects
    "arcwelder": ("SuperSlicer 2.5.59", 3, ";LAYER_CHANGE", ("ring (left)", "ring (right)")),
    "bambustudio": ("BambuStudio 01.09.05.51", 3, "; CHANGE_LAYER", ("unique label id: 58",)),
    "clay_a_axis": ("Grasshopper clay script v2", 3, ";LAYER:n", ()),
    "concrete_inches": ("", 3, "; layer n", ()),
    "concrete_pump": ("", 4, "(LAYER n)", ()),
    "cura": ("Cura_SteamEngine 5.7.1", 4, ";LAYER:n", ("tower.stl",)),
    "foam_pump": ("", 3, ";Z:", ()),
    "host_stream": ("", 2, BY_HEIGHT, ()),
    "kisslicer": ("KISSlicer", 3, "; BEGIN_LAYER_OBJECT", ()),
    "orcaslicer": ("OrcaSlicer 2.1.1", 2, ";LAYER_CHANGE", ("left_id_0_copy_0", "right_id_1_copy_0")),
    "prusaslicer": ("PrusaSlicer 2.8.0", 3, ";LAYER_CHANGE", ("wall.stl id:0 copy 0",)),
    "simplify3d": ("Simplify3D 4.1.2", 3, "; layer n", ()),
    "skeinforge": ("skeinforge", 3, "(<layer> z)", ()),
    "slic3r": ("Slic3r 1.3.0", 4, BY_HEIGHT, ()),
}
TYPES = {
    "Custom": LineType.PRIME,
    "Perimeter": LineType.INNER_PERIMETER,
    "External perimeter": LineType.OUTER_PERIMETER,
    "Solid infill": LineType.SOLID_INFILL,
    "Internal infill": LineType.INFILL,
    "Inner wall": LineType.INNER_PERIMETER,
    "Outer wall": LineType.OUTER_PERIMETER,
    "Sparse infill": LineType.INFILL,
    "Bottom surface": LineType.SURFACE,
    "SKIRT": LineType.SKIRT,
    "WALL-INNER": LineType.INNER_PERIMETER,
    "WALL-OUTER": LineType.OUTER_PERIMETER,
    "FILL": LineType.INFILL,
    "SKIN": LineType.SURFACE,
    "skirt": LineType.SKIRT,
    "inner perimeter": LineType.INNER_PERIMETER,
    "outer perimeter": LineType.OUTER_PERIMETER,
    "solid layer": LineType.SOLID_INFILL,
    "infill": LineType.INFILL,
    "Perimeter Path": LineType.OUTER_PERIMETER,
    "Loop Path": LineType.INNER_PERIMETER,
    "Solid Path": LineType.SOLID_INFILL,
    "Sparse Infill Path": LineType.INFILL,
    "perimeter inner": LineType.INNER_PERIMETER,
    "perimeter outer": LineType.OUTER_PERIMETER,
}
ARC_STEP, ARC_ERROR = 1.0, 1e-6  # m


def toolpath(file: Path, data: bytes | None = None):
    source = file if data is None else io.BytesIO(data)
    return parse(source, ARC_STEP, arc_error=ARC_ERROR, material=MATERIAL.get(file.stem, "E"))


def require_same_lengths(path, plain, relative=1e-9) -> None:
    """Lengths agree; a chord that is e off its arc of angle a is shorter than it by e a / 3, to first order."""
    for mask, length, sweep in (
        (path.extruding, plain.extruded, plain.extruded_sweep),
        (~path.extruding, plain.travelled, plain.travelled_sweep),
    ):
        shorter = 1e-3 * length - path.length[mask].sum()
        assert -relative * 1e-3 * length <= shorter <= relative * 1e-3 * length + 0.34 * ARC_ERROR * sweep


def test_every_file_is_known():
    assert [file.stem for file in FILES] == sorted(KNOWN)


def test_the_house_of_the_examples():
    file = CORPUS.parents[2] / "examples" / "house.gcode"
    path, plain = toolpath(file), plain_gcode.read(file.read_bytes())
    require_same_lengths(path, plain)
    assert path.layer_count == len(plain.layers) == 140


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
class TestAgainstThePlainInterpreter:
    @pytest.fixture
    def pair(self, file):
        path = toolpath(file)
        return path, plain_gcode.read(file.read_bytes(), path.material_by)

    def test_lengths(self, pair):
        require_same_lengths(*pair)

    def test_what_lays(self, pair, file):
        assert pair[0].material_by == MATERIAL.get(file.stem, "M101" if file.stem == "skeinforge" else "E")

    def test_layers(self, pair, file):
        path, plain = pair
        slicer, count, layers_by, _ = KNOWN[file.stem]
        assert (path.slicer, path.layer_count, path.layers_by) == (slicer, count, layers_by)
        laid = path.layer[path.extruding]
        assert sorted(set(laid.tolist()) - {0})[0] == 1
        found = [path.length[path.extruding & (path.layer == n)].sum() for n in sorted(set(laid.tolist()) - {0})]
        assert found == pytest.approx([1e-3 * length for _, length in sorted(plain.layers.items())], rel=1e-4)

    def test_line_types(self, pair):
        path, plain = pair
        expected = dict.fromkeys(LineType, 0.0)
        for word, length in plain.types.items():
            if word:
                expected[TYPES[word]] += 1e-3 * length
        for kind in set(LineType) - {LineType.TRAVEL, LineType.UNSPECIFIED, LineType.PRIME}:
            assert path.length[path.kind == kind].sum() == pytest.approx(expected[kind], rel=1e-4), kind
        assert ((path.kind == LineType.TRAVEL) == ~path.extruding).all()

    def test_objects(self, pair, file):
        path, plain = pair
        assert path.objects == KNOWN[file.stem][3]
        found = [path.length[path.extruding & (path.object == n)].sum() for n in range(len(path.objects))]
        labelled = [1e-3 * length for label, length in plain.objects.items() if label]
        assert found == pytest.approx(labelled, rel=1e-4)


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
class TestBadInput:
    def test_truncated_anywhere(self, file):
        data = file.read_bytes()
        for end in np.linspace(0, len(data) - 1, 60).astype(int):
            try:
                path = toolpath(file, data[:end])
            except InputError as error:
                message = str(error)
            else:
                off_circle = 1e-3  # an arc whose end is cut may end beside its circle, as far as files may
                require_same_lengths(path, plain_gcode.read(data[:end], path.material_by), off_circle)
                continue
            assert message.startswith("G-code")

    def test_cut_inside_a_word(self, file):
        data = file.read_bytes()
        whole = data[: data.rindex(b"\nG1 ") + 1] if b"\nG1 " in data else data
        number = whole.count(b"\n") + 1
        with pytest.raises(InputError, match=rf"^G-code, line {number}: 'G1 X': the line ends inside a word"):
            toolpath(file, whole + b"G1 X")

    def test_decimal_comma(self, file):
        lines = file.read_bytes().split(b"\n")
        at = max(n for n, line in enumerate(lines) if re.match(rb"(N\d+ )?G1 [XYZ]", line))
        lines[at] = re.sub(rb"([XYZ])([-\d]*)[.\d]*", rb"\1\2,5", lines[at].split(b"*")[0], count=1)
        with pytest.raises(InputError, match=rf"^G-code, line {at + 1}: .*,' is a decimal comma; export the file with"):
            toolpath(file, b"\n".join(lines))

    def test_in_inches(self, file):
        data = b"G20\n" + re.sub(rb"(?m)^G2[01]\b.*$", b"", file.read_bytes())
        path = toolpath(file, data.replace(b"*", b";"))  # without checksums, which no longer fit
        require_same_lengths(path, plain_gcode.read(data, path.material_by))

    @pytest.mark.parametrize("other", ["prusaslicer", "cura", "skeinforge"])
    def test_mixed_with_another(self, file, other):
        first = re.sub(rb"(?m)^(M2|M30|%)$", b"", file.read_bytes())  # which end a program
        data = first + b"\nG21\nG90\nM82\nG92\n" + (CORPUS / f"{other}.gcode").read_bytes()
        path = toolpath(file, data)
        require_same_lengths(path, plain_gcode.read(data, path.material_by))
        first, second = KNOWN[file.stem][2], KNOWN[other][2]
        weak = first in (BY_HEIGHT, ";Z:")  # a marker of layers overrides it, if material follows
        assert path.layers_by in ({first, second} if weak else {first})
