"""Bad files: one line that names the file, the line, its text and what is allowed."""

import io

import pytest

from cablewright.foundation.errors import InputError
from cablewright.printing import gcode, modal
from cablewright.printing.gcode import parse


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("G1 Xabc", "X has no number; digits"),
        ("G1 X", "X has no number; digits"),
        ("G1 X Y5", "X has no number; digits"),
        ("G1 X1.2.3", "X1.2.3 is no number; digits"),
        ("G1 X--1", "X--1 is no number"),
        ("G1 X-", "X- is no number"),
        ("G1 X.", "X. is no number"),
        ("G1 X1e400", "'e400' is no G-code word; a letter and a number without exponent"),
        ("G1 X1e-5 Y2", "'e-5 Y2' is no G-code word"),
        ("G1 Xnan", "X has no number"),
        ("G1 Xinf", "X has no number"),
        ("G1 X1_0", "'_0' is no G-code word"),
        ("G1 X0x10", "X is given twice; once is allowed"),
        ("G1 X1,5", "'X1,' is a decimal comma; export the file with decimal points, as in X1.5"),
        ("G1 X1.5 Y2 F1200,5", "'F1200,' is a decimal comma"),
        ("G4 S0,5", "'S0,' is a decimal comma"),
        ("G1 X1, Y2", "', Y2' is no G-code word"),
        ("(one (two) G1 X5", "the parentheses of the comment do not match; each ( needs its )"),
        ("G1 X5 (one (two) Y7", "the parentheses of the comment do not match"),
        ("G1 X5 (one) ) Y7", "the parentheses of the comment do not match"),
        ("G1 X\u0663", "'??' is no G-code word"),
        ("G1 X" + "9" * 400, "farther than 1000000 m"),
        ("G1 Y5 X" + "9" * 400, "the number of X is too large"),
        ("G1 X2e9", "no G-code word"),
        ("G1 X2000000000", "farther than 1000000 m from the origin"),
        ("G1 X1 X2", "X is given twice"),
        ("G1 F1 X1 F2", "F is given twice"),
        ("G1 F0", "F must be above 0"),
        ("G1 F-5", "F must be above 0"),
        ("G1 X1 F" + "9" * 400, "F must be above 0"),
        ("G", "G has no number"),
        ("12 34", "'12 34' is no G-code word"),
        ("? !", "'? !' is no G-code word"),
        ("G1 X1 G92 E0", "G1 and G92 in one line; one of them"),
        ("G18", "G17"),
        ("G19", "G17"),
        ("G5 X1 Y1 I1 J1 P1 Q1", "splines"),
        ("G90.1", "absolute arc centres"),
        ("G93", "inverse-time"),
        ("G4 S-1", "a dwell must last from 0"),
        ("G4 S99999999", "a dwell must last from 0"),
        ("G92 X" + "9" * 400, "too large"),
        ("G2 X1 Y1", "an arc needs either R, or I and J"),
        ("G2 X1 Y1 I1 R1", "an arc needs either R, or I and J"),
        ("G2 X10 R2", "R is too small to reach the end: at least 5 mm"),
        ("G3 X10 R-2", "R is too small"),
        ("G2 X1 R0", "zero radius"),
        ("G2 X1 I0 J0", "zero radius"),
        ("G2 X0 Y0 R5", "a full circle has no centre by R; give I and J"),
        ("G2 X1 Y1 I5", "off the circle"),
        ("G2 X1 R5 P0", "P is the number of turns of an arc; whole numbers from 1 to 1000"),
        ("G2 X1 R5 P1.5", "P is the number of turns"),
        ("G2 X1 R5 P1001", "P is the number of turns"),
        ("G2 X1 R5 P", "P has no number"),
        ("G2 X1 I5 K5", "K of an arc is not read"),
        ("G2 X9000000000 R5", "X is out of range"),
        ("G2 X1 R9000000000", "R is out of range"),
        ("N3 G1 X5*1", "the checksum 1 does not match"),
    ],
)
def test_a_bad_line_is_named(line, reason, read):
    with pytest.raises(InputError) as caught:
        read(f"M83\nG1 X0 Y0 E1\n{line}\nG1 X5 E1\n")
    message = str(caught.value)
    assert message.startswith("G-code, line 3: ")
    assert reason in message
    assert line[:20] in message
    assert "\n" not in message
    assert len(message) < 250
    assert caught.value.exit_code == 2


def test_axes_before_any_motion(read):
    with pytest.raises(InputError, match="line 2: 'X5': axes without a G code before any of G0 to G3"):
        read("G21\nX5\nG1 X1 E1\n")


@pytest.mark.parametrize("end", ["G1 X12.3 Y", "G1 X12.3 Y-", "G1 X12.3 Y.", "G", "G1 X2 E"])
def test_a_truncated_file_is_recognised(end, read):
    with pytest.raises(InputError, match=r"line 2: .*: the line ends inside a word; the file looks truncated"):
        read("G1 X1 E1\n" + end)
    with pytest.raises(InputError, match="no number"):
        read("G1 X1 E1\n" + end + "\n")


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", "the file is empty"),
        (b"\n\n", "no extruding move"),
        (b"G1 X5\nG1 Y5\n", "no extruding move"),
        (b"G1 E5\n", "no extruding move"),
        (b"G1 X5 E-5\n", "no extruding move"),
        (b"Dear reader, this is prose.\n", "no extruding move"),
        (b"G1 X0." + b"0" * 300 + b"1 E1\n", "no extruding move"),
        (b"\x7fELF\x02\x01\x01\0\0\0", "binary"),
        (b"G1 X1 E1\n" * 40_000 + b"\0", "NUL bytes: a binary file"),
        (bytes(range(128, 256)) * 10, "a binary file, no G-code"),
        ("G1 X1 E1\n".encode("utf-16"), "binary"),
        (b"G1 X1 E1\n" + b"X" * 4097 + b"\n", "line 2: longer than 4096 bytes without its comments"),
        (b"G1 X1 E1\n" + b"(" * 5000 + b"\n", "line 2: longer than 4096 bytes"),
        (b"GCDE\1\0\0\0", "binary G-code; export it as text"),
        (b"PK\3\4" + b"x" * 30, "a zip archive; unpack it"),
        (b"G1 X1 E1\n" * 60_000 + b"x" * 5000 + b"\n", "line 60001: longer than 4096 bytes"),
        (b"G1 X1 E1\n" + b"x" * 1_000_000, "line 2: longer than 4096 bytes"),
        (b"G1 X1 E" + b"9" * 400 + b"\n", "line 1: E is too large"),
    ],
)
def test_a_bad_file_is_named(data, reason, tmp_path):
    file = tmp_path / "part.gcode"
    file.write_bytes(data)
    with pytest.raises(InputError) as caught:
        parse(file)
    assert str(caught.value).startswith(str(file))
    assert reason in str(caught.value)


def test_a_file_that_cannot_be_opened(tmp_path):
    for path, reason in [
        (tmp_path / "none.gcode", "no such file"),
        (tmp_path, "not a regular file"),
        ("a\0b", "cannot be read"),
        ("x" * 5000, "cannot be read"),
    ]:
        with pytest.raises(InputError, match=reason):
            parse(path)


@pytest.mark.parametrize("arc_step", [0.0, -1.0, 1e-9, float("nan"), float("inf")])
def test_arc_step_must_be_a_length(arc_step, read):
    with pytest.raises(InputError, match="arc_step"):
        read("G1 X1 E1", arc_step)


class TestCaps:
    def test_size(self, monkeypatch, read):
        monkeypatch.setattr(gcode, "MAX_BYTES", 100)
        with pytest.raises(InputError, match="larger than 100 bytes"):
            read("G1 X1 E1\n" * 20)

    def test_moves(self, monkeypatch, read):
        monkeypatch.setattr(modal, "MAX_MOVES", 100)
        with pytest.raises(InputError, match="more than 100 moves"):
            read("G1 X1 E1\n" * 101)

    def test_one_hostile_arc(self, read):
        with pytest.raises(InputError, match=r"line 1: .*: more than 20000000 moves"):
            read("G2 X0 Y0 I900000000 J0 E1\n")

    def test_a_stream_is_read_no_further_than_needed(self):
        stream = io.BytesIO(b"G1 Xbad\n" + b"G1 X1 E1\n" * 200_000)
        with pytest.raises(InputError, match="line 1"):
            parse(stream)
        assert stream.tell() < 500_000
