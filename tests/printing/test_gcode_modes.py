"""Codes of machine tools and firmwares beside motions: each program has the path of the same program written out."""

from __future__ import annotations

import io
import re

import numpy as np
import pytest

from cablewright.foundation.errors import InputError
from cablewright.printing.gcode import parse
from cablewright.printing.gcode_words import BESIDE
from cablewright.printing.toolpath import Material, Toolpath

HEAD = "G21 G90 M83\nG0 X-100 Y-100 Z10 F3000\nG1 X100 Y-100 E5 F1200\n"
TAIL = "\nG1 X-90 E1\nY33 E2\n"
OWN = {"H": "H1", "D": "D50", "S": "S900", "I": "I", "O": "O", "P": "P0.1", "Q": "Q2", "R": "R30", "L": "L3", "E": "E0"}
"""A word of each letter that a code may own, as its machine takes it."""
MOVING = [code for code, letters in BESIDE.items() if code not in ("M2", "M30", "G53") and "E" not in letters]


def read(text: str | bytes, material: Material = "E") -> Toolpath:
    return parse(io.BytesIO(text.encode() if isinstance(text, str) else text), material=material)


def require_same(found: Toolpath, plain: Toolpath) -> None:
    """Both have the same moves: ends, material, feeds and dwells."""
    np.testing.assert_allclose(found.end, plain.end, atol=1e-12)
    np.testing.assert_allclose(found.extrusion, plain.extrusion, atol=1e-12)
    np.testing.assert_allclose(found.feed, plain.feed)
    np.testing.assert_allclose(found.dwell, plain.dwell)
    assert found.extruding.tolist() == plain.extruding.tolist()


class TestWordsBesideCodes:
    @pytest.mark.parametrize("code", [*MOVING, "T3", "T1 M6", "G90", "G17", "G21", "M83", "G91.1", "G40 G49 G54 M8"])
    @pytest.mark.parametrize("order", ["{code} {move}", "{move} {code}"])
    @pytest.mark.parametrize("move", ["X50", "Z30", "X100 Y100 E5", "X7 Y8 Z9 E1 F600", "E-2", "Y3 F90"])
    def test_are_a_move_of_the_active_motion(self, code: str, order: str, move: str) -> None:
        found = read(HEAD + order.format(code=code, move=move) + TAIL)
        require_same(found, read(HEAD + f"G1 {move}" + TAIL))

    @pytest.mark.parametrize("code", [code for code, letters in BESIDE.items() if letters])
    @pytest.mark.parametrize("where", ["{code} {own} {move}", "{code} {move} {own}", "{move} {code} {own}"])
    def test_own_words_are_no_part_of_the_move(self, code: str, where: str) -> None:
        own = " ".join(OWN[letter] for letter in BESIDE[code])
        move = "X40 Y20" if "E" in BESIDE[code] else "X40 E2"
        require_same(read(HEAD + where.format(code=code, own=own, move=move) + TAIL), read(HEAD + "G1 " + move + TAIL))
        require_same(read(HEAD + f"{code} {own}" + TAIL), read(HEAD + TAIL))

    @pytest.mark.parametrize("code", ["M8", "G54", "T2"])
    def test_continue_an_arc_with_its_centre(self, code: str) -> None:
        arc = HEAD + "G2 X120 I10 E1\n"
        require_same(read(arc + f"{code} X140 I10 E1" + TAIL), read(arc + "G2 X140 I10 E1" + TAIL))

    @pytest.mark.parametrize("code", ["M106 P1", "M104 S200", "M400", "M204 P500", "M73 P10 R2", "M900 K0.1"])
    def test_before_a_command_of_a_firmware_are_a_move(self, code: str) -> None:
        require_same(read(HEAD + f"X50 E1 {code}" + TAIL), read(HEAD + "G1 X50 E1" + TAIL))

    @pytest.mark.parametrize("code", ["M207 S1 Z2 F300", "M84 X Y E", "M92 X80 E400", "M106 S9 F500", "G29 X5 Y5"])
    def test_after_a_command_of_a_firmware_are_its_own(self, code: str) -> None:
        require_same(read(HEAD + code + TAIL), read(HEAD + TAIL))
        require_same(read(HEAD + f"{code} G1 X50 E1" + TAIL), read(HEAD + "G1 X50 E1" + TAIL))

    def test_without_an_active_motion_are_an_error(self) -> None:
        with pytest.raises(InputError, match="line 1: 'G54 X5': axes without a G code before any of G0 to G3"):
            read("G54 X5\n" + HEAD)

    def test_that_are_no_words_are_an_error(self) -> None:
        with pytest.raises(InputError, match="is no G-code word"):
            read(HEAD + "M8 X#5" + TAIL)


HOP = "\nG91\nG0 Z5\nG0 Z-5\n"
HOPPED = "\nG0 Z15\nG0 Z10\n"
SQUARE = "\nG1 X100 Y100 E5\nG1 X-100 Y100 E5\nG1 X-100 Y-100 E5\n"


class TestSavedModes:
    PAIRS = (
        ("M120", "M121"),
        ("M70", "M72"),
        ("M73", "M72"),
        ("SAVE_GCODE_STATE NAME=hop", "RESTORE_GCODE_STATE NAME=hop"),
        ("save_gcode_state", "Restore_Gcode_State NAME=default MOVE=0"),
    )

    @pytest.mark.parametrize(("save", "restore"), PAIRS)
    def test_a_hop(self, save: str, restore: str) -> None:
        found = read(HEAD + save + HOP + restore + SQUARE)
        require_same(found, read(HEAD + HOPPED + SQUARE.replace("G1 X100 Y100", "G1 F1200 X100 Y100")))
        assert found.unknown == {}

    @pytest.mark.parametrize(("save", "restore"), PAIRS)
    def test_units_extrusion_and_feed(self, save: str, restore: str) -> None:
        between = "\nG20\nM82\nG92 E0\nG1 X1 E1 F10\nG21\nM82\n"
        plain = "\nG1 X25.4 E25.4 F254\nF1200\n"
        require_same(read(HEAD + save + between + restore + SQUARE), read(HEAD + plain + SQUARE))

    @pytest.mark.parametrize("text", ["M121\n", "M120\nM121\nM121\n", "M120 S500\nM121\n", "M70 P5\nM72 P1\nM73\n"])
    def test_nothing_to_restore(self, text: str) -> None:
        require_same(read(HEAD + text + SQUARE), read(HEAD + SQUARE))

    def test_nested(self) -> None:
        nested = HEAD + "M120\nG91\nM120\nG90\nM121\nG1 X-5 E1\nM121" + SQUARE
        require_same(read(nested), read(HEAD + "G1 X95 E1" + SQUARE))

    def test_klipper_restores_the_shift_and_e(self) -> None:
        between = "\nG92 X0 Y0 E3\nM82\nG1 X-10 E4\n"
        for times in (1, 2):
            text = HEAD + "M82\nG92 X90 E7\nSAVE_GCODE_STATE" + (between + "RESTORE_GCODE_STATE") * times
            written = (80, 70)[:times]  # X of the place at the end of each, in the coordinates that were saved
            plain = HEAD + "M82\nG92 X90 E7" + "".join(f"{between}G92 X{x} Y-100 E7" for x in written)
            require_same(read(text + "\nG1 X1 E8\n"), read(plain + "\nG1 X1 E8\n"))

    def test_names_are_kept_apart(self) -> None:
        text = "SAVE_GCODE_STATE NAME=a\nG91\nSAVE_GCODE_STATE NAME='b'\nRESTORE_GCODE_STATE NAME=a ; NAME=b"
        require_same(read(HEAD + text + SQUARE), read(HEAD + SQUARE))
        relative = read(HEAD + text + '\nRESTORE_GCODE_STATE NAME="b"\nG1 X-50 E1\n')
        assert relative.end[-1] == pytest.approx([0.05, -0.1, 0.01])

    def test_linuxcnc_restores_the_spindle(self) -> None:
        text = "G0 X1\nM3 S100\nG1 X2\nM70\nS0\nG1 X3\nM5\nG1 X4\nM72\nG1 X5\nS0\nG1 X6\nM72\nG1 X7\n"
        assert read(text, "M3").extruding.tolist() == [False, True, False, False, True, False, True]

    @pytest.mark.parametrize(
        ("text", "why"),
        [
            ("M72", "no modes are saved; M70 must stand before M72"),
            ("M70\nM71\nM72", "no modes are saved"),
            ("RESTORE_GCODE_STATE NAME=x", "no modes are saved; SAVE_GCODE_STATE NAME=x must stand before"),
            ("SAVE_GCODE_STATE\nRESTORE_GCODE_STATE MOVE=1", "MOVE=1 is not read; write the move back"),
            ("G91 M120", "M120 is read on a line of its own"),
            ("M73 X5", "M73 is read on a line of its own"),
            ("M70 G1 X5", "M70 is read on a line of its own"),
            ("M120\n" * 200, "more than 100 saved modes"),
            ("".join(f"SAVE_GCODE_STATE NAME=s{n}\n" for n in range(200)), "more than 100 saved modes"),
        ],
    )
    def test_what_cannot_be_restored_is_an_error(self, text: str, why: str) -> None:
        with pytest.raises(InputError, match=why):
            read(HEAD + text + SQUARE)


CHANGING = """G5 X1 Y1 I1 J1 P1 Q1|G5.1 X1 I1|G5.2 X1 Y1 P1|G5.3|G7|G12.1|G16|G18|G19|G30 Z0|G33 Z-5 K1|G33.1 Z-5 K1
G38.2 Z-5|G38.4 X5|G41 D1|G42|G41.1 D3|G43.1 Z5|G10 L2 P1 X50|G10 L20 P0 X0|G10 L2 P2 X5|G10 P1 X20|G10 L10 P1 Z5
G51 X0 Y0 P2|G51.1 X0|G52 X5|G55|G56|G57|G58|G59|G59.1|G59.3|G54.1 P2|G60 S0|G65 P100|G66 P1|G68 R45|G68.2 X0
G70|G71|G73 X1 Z-5 R2 Q1|G76 Z-5|G81 X10 Y10 Z-5 R2 F100|G83 Z-5|G85 X1|G89 Z1|G90.1|G92.1|G92.2|G92.3|G93|G95
G150 X5|G28.3 X0|M26 S0|M32 a.g|M47|M97 P1|M98 P1000 L5|M99|M206 X10|M206 Z-0.5|M220 S50|M220 S150|M290 Z0.1
M290 S0.05|M428|M579 X2|M579 Y1.01|M808 L5|M808 L|G1 X5 R1|G0 X5 R0|G1 X5 H1|G1 H2 X5|if true|if {a > 1}
IF [#1 GT 2] GOTO 5|elif x|else|while iterations < 20|WHILE [#1 LT 5] DO1|break|continue|abort|GOTO 10|o100 sub
o<x> call [1]|O100 while [#1 LT 5]|o1 repeat [5]|O100 if [1]
SDCARD_LOOP_BEGIN COUNT=3|SDCARD_LOOP_END
FORCE_MOVE STEPPER=x|SET_KINEMATIC_POSITION X=5|SET_GCODE_OFFSET X=50|SET_GCODE_OFFSET Z_ADJUST=-0.1 MOVE=1
TRANS X10|AROT Z45|SCALE X2
MIRROR X0|REPEAT A B P=3"""
"""Lines that move, shift, scale or turn axes, repeat lines, or change the meaning of F."""
HARMLESS = """G8|G13.1|G15|G28.1|G29|G29 P1 X30 Y0 W50|G29.1 Z-0.02|G30|G32|G33|G34|G40|G43 H1|G49|G50|G54
G61|G64 P0.01|G69
G80|G10|G11|G10 P0 S200 R180|G10 P1 X0 Y0 Z0|G161 X Y F1000|G380 S2 Z30 F1200|G94|G97 S5000|G98|G99|M0|M1
M30 a.gcode|O1000|M98 P"bed.g"|M206 X0 Y0|M206|M220 S100|M220 B|M220 R|M290 S0
M579 X1 Y1 Z1|M808|M221 S95
M600|M125|T1|Tx|T?|M3 I|M5
SET_GCODE_OFFSET Z=0.0|SET_GCODE_OFFSET X=0 Y=0 MOVE=1|G53
START_PRINT X=5|GO_HOME X=5|BREAK_IN X=1|FORMAT X=1|M23 a*5
set global.x = 5|echo "a"|M117 if this|M118 G1 X5*9|M9|M62 P1|M67 E0 Q5|M68 E1 Q0.5|G1 H0
M1006 A0 B10 L100 C37 D10 M60 E37 F10 N60|M1006 A53 B9 M99 E53 F9 N99|M290 X40 Y40 Z2.666
M624 AQAAAG93M99=|M1002 set_flag g18_x=1|M106 X50|M84 X Y Z E"""


class TestCodesThatChangeThePath:
    @pytest.mark.parametrize("line", re.split(r"[|\n]", CHANGING))
    def test_are_an_error_that_names_line_and_way_out(self, line: str) -> None:
        with pytest.raises(InputError) as caught:
            read(HEAD + line + "\n" + SQUARE)
        message = str(caught.value)
        assert message.startswith(f"G-code, line 4: {line!r}: ")
        assert any(word in message for word in ("write", "allowed", "expand", "read", "G0 to G3"))
        assert len(message) < 250

    @pytest.mark.parametrize("line", re.split(r"[|\n]", HARMLESS))
    def test_others_leave_the_path_as_it_is(self, line: str) -> None:
        require_same(read(HEAD + line + "\n" + SQUARE), read(HEAD + SQUARE))

    def test_machine_coordinates(self) -> None:
        require_same(read(HEAD + "G53 G0 X5 Y6\nG53 Z20\nG1 G53 X7 E1\n"), read(HEAD + "G0 X5 Y6\nZ20\nG1 X7 E1\n"))
        for shift in ("G92 X0", "G91"):
            with pytest.raises(InputError, match="G53 is read with G90 and where nothing shifts the axes"):
                read(HEAD + shift + "\nG53 G0 X5" + SQUARE)
        require_same(read(HEAD + "G92 X0\nG28 X\nG53 X5" + SQUARE), read(HEAD + "G28 X\nG1 X5" + SQUARE))


class TestEndOfProgram:
    @pytest.mark.parametrize("end", ["M2", "M30", "M02", "M5 M30", "M30 (end)", "N90 M30", "%"])
    def test_nothing_after_it_is_a_move(self, end: str) -> None:
        found = read(f"{HEAD}{end}\nG1 X5000 E5\n(a comment)\n\nM104 S0\nG18\n")
        require_same(found, read(HEAD))
        code = "%" if end == "%" else "M30" if "30" in end else "M2"
        assert found.unknown[f"after {code}"] == 3

    def test_comments_after_it_are_read(self) -> None:
        assert read(HEAD + "M30\n; filament_diameter = 1.75\n").settings["filament_diameter"] == pytest.approx(1.75e-3)

    def test_its_own_line_moves(self) -> None:
        require_same(read(HEAD + "X5 E1 M30\nG1 X9 E1\n"), read(HEAD + "G1 X5 E1\n"))
        require_same(read("%\n" + HEAD + "%\nG1 X9 E1\n"), read(HEAD))

    def test_in_any_block_of_the_file(self) -> None:
        long = HEAD + "G1 X5 E1\nG1 X6 E1\n" * 20_000
        require_same(read(long + "M2\n" + "G1 X5 E1\n" * 60_000), read(long))


class TestPumps:
    @pytest.mark.parametrize(
        ("text", "plain", "material"),
        [
            ("M3 S9\nG1 X1\nS0\nG1 X2\nS9\nG1 X3\nM5\n", "M3\nG1 X1\nM5\nG1 X2\nM3\nG1 X3\nM5\n", "M3"),
            ("M3 S0\nG1 X1\nG1 X2 S9\nG1 X3\nM5\nG1 X4\n", "G1 X1\nM3\nG1 X2\nG1 X3\nM5\nG1 X4\n", "M3"),
            ("S0\nM4\nG1 X1\nS.5\nG1 X2\nM5\nS9\nG1 X3\n", "G1 X1\nM3\nG1 X2\nM5\nG1 X3\n", "M3"),
            ("S9 M3\nG0 X1 S0\nG1 X2 S9\nX3 S0.0\n", "G0 X1\nM3\nG1 X2\nM5\nG1 X3\n", "M3"),
            ("M3 S9\nM5\nM3\nG1 X1\nG4 S0\nG1 X2\nM104 S0\nG1 X3\n", "M3\nG1 X1\nG1 X2\nG1 X3\n", "M3"),
            ("G4 P5 M3 S9\nG1 X1\nG4 S0\nG1 X2\n", "G4 P5\nM3\nG1 X1\nG1 X2\n", "M3"),
            ("M3 S9\nG2 X4 I2 S0\nG1 X5 S9\n", "G2 X4 I2\nM3\nG1 X5\n", "M3"),
            ("M106 P0 S9\nG1 X1\nM106 P2 S0\nG1 X2\nM107 P1\nG1 X3\n", "M106\nG1 X1\nG1 X2\nG1 X3\n", "M106"),
            ("M106 P1 S9\nG1 X1\nM106 S9\nG1 X2\nM107 P0\nG1 X3\n", "G1 X1\nM106\nG1 X2\nM107\nG1 X3\n", "M106"),
            ("M101\nX1\nM103 X2\nX3 M101\n", "M101\nG1 X1\nM103\nG1 X2\nM101\nG1 X3\n", "M101"),
        ],
    )
    def test_as_written_out(self, text: str, plain: str, material: Material) -> None:
        start = "G1 X0 Y0 Z1\n"
        require_same(read(start + text, material), read(start + plain, material))

    def test_other_outputs_are_counted(self) -> None:
        path = read("M106\nG1 X1\nM106 P2 S9\nM107 P2\n", "M106")
        assert path.unknown == {"M106 P2": 1, "M107 P2": 1}
        with pytest.raises(InputError, match="no move while M106 is on, by P0 or without P"):
            read("M106 P1\nG1 X1\n", "M106")


class TestLines:
    PROGRAM = HEAD + "M8 X5 ; a comment\n;LAYER:2\nG1 X-90 E1\n"

    def test_ends(self) -> None:
        for end in ("\r", "\r\n"):
            found = read(self.PROGRAM.replace("\n", end))
            require_same(found, read(self.PROGRAM))
            assert found.line.tolist() == read(self.PROGRAM).line.tolist()
            assert found.layer.tolist() == read(self.PROGRAM).layer.tolist()
        with pytest.raises(InputError, match=r"line 2: .*a carriage return inside a line of a file with line feeds"):
            read("G21\nG1 X1 E1\rG1 X2 E1\n")
        with pytest.raises(InputError, match="the line ends inside a word; the file looks truncated"):
            read("G21\rG1 X1 E1\rG1 X")

    @pytest.mark.parametrize("text", ["M117 5*3", "M118 a*1", "m0117 5*3", "M0 5*3", "M23 part*2", "RESPOND MSG=5*3"])
    def test_a_star_in_free_text_is_no_checksum(self, text: str) -> None:
        require_same(read(HEAD + text + SQUARE), read(HEAD + SQUARE))
        own = 0
        for byte in f"N5 {text}".encode():
            own ^= byte
        require_same(read(HEAD + f"N5 {text}*{own}" + SQUARE), read(HEAD + SQUARE))
        with pytest.raises(InputError, match="does not match"):
            read(HEAD + f"N5 {text}*{own ^ 1}" + SQUARE)

    @pytest.mark.parametrize("line", ["G1 X5*3", "M104 S200*3", "M1170*3", "M11.7*3"])
    def test_a_star_elsewhere_is_one(self, line: str) -> None:
        with pytest.raises(InputError, match="the checksum 3 does not match"):
            read(HEAD + line + SQUARE)
