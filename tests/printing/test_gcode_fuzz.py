"""Whatever stands in a file, the answer is a toolpath or one line."""

import io
from typing import get_args

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from cablewright.foundation.errors import InputError
from cablewright.printing.gcode import parse
from cablewright.printing.layers import layer_table
from cablewright.printing.line_types import LineType
from cablewright.printing.path import sample
from cablewright.printing.timing import time_law
from cablewright.printing.toolpath import Material, Toolpath

WORD = st.builds(
    str.__add__,
    st.sampled_from("GGGXYZEFIJRSPMTNK*;( \tge"),
    st.one_of(st.integers(-5, 120).map(str), st.floats(-1e3, 1e3).map(lambda v: f"{v:.3f}"), st.text(max_size=3)),
)
CODES = [
    "G0", "G1", "G2", "G3", "G4", "G20", "G28", "G90", "G91", "G92", "M82", "M83", "M3", "M5", "M101", "M103", "M106",
    "M107", "M486 S1", "M486 AName", "M486 S-1", "EXCLUDE_OBJECT_START NAME=a", "EXCLUDE_OBJECT_END", ";LAYER:1",
    ";LAYER_CHANGE", "; CHANGE_LAYER", ";Z:0.3", ";Z:0.4", ";HEIGHT:0.2", ";TYPE:FILL", ";TYPE:x", "(<layer> 0.2 )",
    "(<infill>)", "; printing object a", "; stop printing object a", "M120", "M121", "M70", "M72", "M30", "M2", "%",
    "G43 H1", "G53", "SAVE_GCODE_STATE NAME=a", "RESTORE_GCODE_STATE NAME=a", "M220 S100", "G10 P0 S200", "M67 E0 Q5",
    "M117 5*3", "S0",
]  # fmt: skip
CODE = st.sampled_from(CODES)
LINE = st.lists(st.one_of(CODE, WORD), max_size=6).map(" ".join)
GCODE = st.lists(LINE, max_size=12).map("\n".join)


def check(data: bytes, material: Material = "E") -> None:
    try:
        path = parse(io.BytesIO(data), arc_step=0.01, material=material)
    except InputError:  # one line, by its constructor
        return
    k = len(path.line)
    assert path.start.shape == path.end.shape == (k, 3)
    assert all(len(column) == k for column in (path.extrusion, path.feed, path.dwell, path.layer))
    assert np.isfinite(path.end).all()
    assert np.isfinite(path.extrusion).all()
    assert (path.feed > 0).all()
    assert (path.dwell >= 0).all()
    assert (np.diff(path.line) >= 0).all()
    assert (path.start[1:] == path.end[:-1]).all()
    assert path.extruding.any()
    assert path.in_part.shape == path.homing.shape == path.bead_height.shape == (k,)
    assert ((path.kind == LineType.TRAVEL) == ~path.extruding).all()
    assert (path.object >= -1).all()
    assert (path.object < len(path.objects)).all()
    check_motion(path)


def check_motion(path: Toolpath) -> None:
    try:
        samples = sample(path, step=20.0)
    except InputError:  # nothing longer than a nanometre
        return
    law = time_law(samples, 0.5)
    assert (np.diff(law.time) > 0).all()
    assert np.isfinite(law.duration)
    assert layer_table(samples, law).duration.sum() <= law.duration * (1 + 1e-9)


@given(st.binary(max_size=300))
def test_bytes(data):
    check(data)


@given(st.text(max_size=300))
def test_text(text):
    check(text.encode("utf-8", "surrogatepass"))


@settings(max_examples=500)
@given(GCODE, st.booleans(), st.sampled_from(get_args(Material)))
def test_words(text, prefixed, material):
    check(("G1 X1 Y1 E1 F100\n" * prefixed + text).encode("utf-8", "surrogatepass"), material)


@given(st.binary(max_size=40), st.integers(0, 60))
def test_a_good_file_with_a_wound(wound, at):
    good = b"G21\nG90\nM83\n;LAYER:0\nG1 X10 Y0 E1 F600\nG2 X0 Y0 I-5 J0 E2\n"
    check(good[:at] + wound + good[at:])
    check(good[:at])
