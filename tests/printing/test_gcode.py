"""What each word of G-code does to the path."""

import numpy as np
import pytest

from cablewright.printing.gcode import parse


@pytest.mark.parametrize(
    "line",
    [
        "G1 X10 Y5",
        "G1X10Y5",
        "g1 x10 y5",
        "G01 X10 Y5",
        "G1.0 X10 Y5",
        "G0 X10 Y5",
        "G00 X10 Y5",
        "G1 Y5 X10",
        "  G1\tX10   Y5  ",
        "G1 X 10 Y 5",
        "G1 X10. Y+5",
        "G1 X10.000 Y05",
        "G1 X10 Y5 ; a comment (with) ; more",
        "G1 X10 (X99) Y5 (Y99",
        "(X1) G1 X10 Y5",
        "N7 G1 X10 Y5",
        "N7G1X10Y5",
        "G1 X10 Y5 *97",
        "G90 G1 X10 Y5",
        "G21 G90 G1 F600 X10 Y5",
        "G1 F600 X10 Y5",
        "G1 X10 Y5 F600",
        "G1 X10 Y5\r",
        "G54 G1 X10 Y5",
        "G1 X10 Y5 M106 P1",
    ],
)
def test_spellings_of_one_move(line, points):
    if "*" in line:
        checksum = 0
        for byte in line.split("*")[0].encode():
            checksum ^= byte
        line = line.split("*")[0] + f"*{checksum}"
    assert points(line) == [(10, 5, 0)]


@pytest.mark.parametrize(("text", "value"), [("1.", 1), (".5", 0.5), ("-.5", -0.5), ("+3", 3), ("-0", 0), ("007", 7)])
def test_spellings_of_numbers(text, value, points):
    assert points(f"G1 X{text}") == [(value, 0, 0)]


def test_one_row_per_move_with_its_line_feed_and_extrusion(read):
    path = read("; head\nG21\n\nG1 X10 F600\nG1 F1200\nM104 S200\nG1 X30 E2.5\nG0 Z5\n")
    assert path.end == pytest.approx(np.array([[0.01, 0, 0], [0.03, 0, 0], [0.03, 0, 0.005]]))
    assert path.start[1:] == pytest.approx(path.end[:-1])
    assert path.start[0] == pytest.approx(0)
    assert path.line.tolist() == [4, 7, 8]
    assert path.feed == pytest.approx([0.01, 0.02, 0.02])
    assert path.extrusion == pytest.approx([0, 0.0025, 0])
    assert path.extruding.tolist() == [False, True, False]
    assert path.length == pytest.approx([0.01, 0.02, 0.005])


def test_no_feed_yet_is_no_limit(read):
    assert read("G1 X1 E1\nG1 F60\nG1 X2 E2").feed.tolist() == [np.inf, 1e-3]


def test_arrays_cannot_be_written(read):
    path = read("G1 X1 E1")
    for column in (path.start, path.end, path.extrusion, path.feed, path.dwell, path.layer, path.line):
        with pytest.raises(ValueError, match="read-only"):
            column[0] = 1


def test_inches(read):
    path = read("G20\nG1 X1 Y2 E3 F60\nG21\nG1 X0\n")
    assert path.end[0] == pytest.approx([0.0254, 0.0508, 0])
    assert path.extrusion[0] == pytest.approx(3 * 0.0254)
    assert path.feed[0] == pytest.approx(0.0254)
    assert path.end[1] == pytest.approx([0, 0.0508, 0])


def test_relative_and_absolute(points):
    assert points("G1 X10\nG91\nG1 X5 Y-1\nG1 X5\nG90\nG1 X5") == [(10, 0, 0), (15, -1, 0), (20, -1, 0), (5, -1, 0)]


class TestExtrusionMode:
    def test_follows_g90_and_g91(self, read):
        assert read("G91\nG1 X1 E2\nG1 X1 E2").extrusion == pytest.approx([2e-3, 2e-3])
        assert read("G90\nG1 X1 E2\nG1 X2 E3").extrusion == pytest.approx([2e-3, 1e-3])

    def test_m82_and_m83_rule_from_then_on(self, read):
        assert read("M83\nG90\nG1 X1 E2\nG1 X2 E2").extrusion == pytest.approx([2e-3, 2e-3])
        assert read("M82\nG91\nG1 X1 E2\nG1 X1 E3").extrusion == pytest.approx([2e-3, 1e-3])

    def test_absolute_extrusion_continues_from_relative_extrusion(self, read):
        assert read("M83\nG1 X1 E2\nM82\nG1 X2 E3").extrusion == pytest.approx([2e-3, 1e-3])

    def test_drawing_back_is_no_extruding(self, read):
        path = read("G1 X1 E5\nG1 E3\nG1 X2\nG1 E5\nG1 X3 E6\n")
        assert path.extrusion == pytest.approx([5e-3, -2e-3, 0, 2e-3, 1e-3])
        assert path.extruding.tolist() == [True, False, False, False, True]


class TestRename:
    def test_e_starts_again(self, read):
        assert read("G1 X1 E5\nG92 E0\nG1 X2 E1").extrusion == pytest.approx([5e-3, 1e-3])

    def test_axes_shift_and_the_machine_stands(self, points):
        assert points("G1 X10 Y10\nG92 X0 Y100\nG1 X5\nG1 Y90") == [(10, 10, 0), (15, 10, 0), (15, 0, 0)]

    def test_bare_makes_all_zero(self, read, points):
        assert points("G1 X10 Y20 Z30\nG92\nG1 X1 Y2 Z3") == [(10, 20, 30), (11, 22, 33)]
        assert read("G1 X1 E5\nG92\nG1 X2 E1").extrusion[-1] == pytest.approx(1e-3)


class TestHome:
    def test_all_axes(self, points):
        assert points("G1 X1 Y2 Z3\nG28\nG1 X1") == [(1, 2, 3), (0, 0, 0), (1, 0, 0)]

    def test_named_axes(self, points):
        assert points("G1 X1 Y2 Z3\nG28 X Y0") == [(1, 2, 3), (0, 0, 3)]

    def test_drops_the_shift(self, points):
        assert points("G1 X10\nG92 X0\nG28 X\nG1 X5") == [(10, 0, 0), (0, 0, 0), (5, 0, 0)]

    def test_at_home_nothing_moves(self, points):
        assert points("G28\nG1 X5") == [(5, 0, 0)]


class TestDwell:
    def test_milliseconds_and_seconds(self, read):
        path = read("G1 X1 E1\nG4 P250\nG4 S3\nG4 P5 S1\nG4\nG1 X2 E2")
        assert path.dwell == pytest.approx([0, 0.25, 3, 1, 0])
        assert path.length == pytest.approx([1e-3, 0, 0, 0, 1e-3])


def test_axes_alone_repeat_the_last_motion(points):
    assert points("G1 X1\nX2 Y3\nY4") == [(1, 0, 0), (2, 3, 0), (2, 4, 0)]


class TestUnknown:
    def test_counted_by_name(self, read):
        path = read("M107\nM104 S200 T1\nM107\nT0\nSTART_PRINT BED=60 NOZZLE=1e3\n%\nG29 X5\nG1 X1 E1 A3\n")
        assert path.unknown == {"M107": 2, "M104": 1, "T0": 1, "START_PRINT": 1, "%": 1, "G29": 1, "A": 1}

    def test_words_behind_belong_to_it(self, points):
        assert points("M117 G1 X5 (lovely) 1e5 Y\nM84 X Y E\nG29 X5 Y5\nM221 S{if layer}100\nG1 X1") == [(1, 0, 0)]

    def test_kinds_are_bounded(self, read):
        path = read("".join(f"M{n}\n" for n in range(500, 1800)) + "G1 X1 E1\n")
        assert len(path.unknown) == 1001
        assert sum(path.unknown.values()) == 1300


def test_byte_order_mark_and_missing_last_line_end(read):
    assert read(b"\xef\xbb\xbfG1 X1 E1").end.tolist() == [[1e-3, 0, 0]]


def test_lines_across_blocks_keep_their_numbers(read):
    padding = ";" + "x" * 61 + "\n"  # 63 bytes, which divides no block
    path = read("".join(padding + f"G1 X{n} E{n}\n" for n in range(1, 9001)))
    assert path.line.tolist() == list(range(2, 18001, 2))
    assert path.end[:, 0] == pytest.approx(np.arange(1, 9001) * 1e-3)


def test_path_and_progress(tmp_path):
    file = tmp_path / "part.gcode"
    file.write_bytes(b"G1 X1 E1\n" * 50_000 + b"G1 X2 E2\n")
    calls = []
    path = parse(file, progress=lambda _, done, total: calls.append((done, total)))
    assert len(path.line) == 50_001
    assert [total for _, total in calls] == [file.stat().st_size] * len(calls)
    assert [done for done, _ in calls] == sorted(done for done, _ in calls)
    assert calls[-1][0] == file.stat().st_size
    assert len(calls) > 1
