"""Settings files of firmware, however their lines are broken: commands on one line, ends of lines, inches, hostile.

Oracle: the same file with a command on each line, or in mm, or with its formula computed by hand.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

from cablewright.calibration.survey.shots import read_shots
from cablewright.calibration.tensile.recording import read_test
from cablewright.exchange.formats import read_robot
from cablewright.exchange.translation_result import ImportedRobot
from cablewright.foundation.csv_input import text_lines
from cablewright.foundation.errors import InputError
from cablewright.robot import Robot

COMMANDS = [
    "M669 K6 N4 A0:-1600:-110 B1460:815:-110 C-1450:830:-110 D0:0:2350",
    "M666 Q0.1 R66.5:66.5:66.5:66.5 U4:4:4:8 O1:1:1:1",
    "M203 X9000",
    "M666 W1.5 S22000 I8:8:8:8 X120:120:120:120",
]


def rrf(tmp_path: Path, text: str) -> ImportedRobot:
    path = tmp_path / "config.g"
    path.write_bytes(text.encode())
    return read_robot([path], "reprapfirmware")


@pytest.mark.parametrize("end", ["\r", "\r\n", " ", "", "\t", ' M98 P"a;M666 W9.g" ', ' M117 "M666 W9" ', " G4 P1 "])
@pytest.mark.parametrize("start", ["", "M569 P40 S1 T2 ", 'M550 P"my M666 W9" ', "N1 ", "T0 ", "g90 "])
def test_commands_on_one_line_are_those_on_their_own_lines(tmp_path: Path, end: str, start: str) -> None:
    plain, joined = rrf(tmp_path, "\n".join(COMMANDS)), rrf(tmp_path, start + end.join(COMMANDS))
    assert joined.robot == plain.robot
    assert joined.format == plain.format
    assert joined.robot.platform.mass == 1.5
    assert set(plain.lost) <= set(joined.lost)
    assert all(each.startswith(("M98", "M666", "M669")) for each in set(joined.lost) - set(plain.lost))


def test_lines_with_numbers_and_checksums_are_those_without(tmp_path: Path) -> None:
    numbered = "\n".join(f"N{10 * k} {each}*{57 + k}" for k, each in enumerate(COMMANDS))
    assert rrf(tmp_path, numbered).robot == rrf(tmp_path, "\n".join(COMMANDS)).robot


@pytest.mark.parametrize("wrong", ["500,5", "500 mm", "foo", ""])
def test_a_setting_of_maslows_that_is_no_number_is_no_default(tmp_path: Path, wrong: str) -> None:
    path = tmp_path / "settings.txt"
    path.write_text(f"$1=1219.2 (bed height)\n$2=3000\n$3={wrong} (motor offset)\n")
    with pytest.raises(InputError, match=r"line 3, \$3: motoroffsety = .*must be a finite number"):
        read_robot([path], "maslow-classic")


ANCHORS = [(0.0, -1600.0, -120.0), (1300.0, 1260.0, -120.0), (-1400.0, 700.0, -120.0), (0.0, 0.0, 2300.0)]


def klipper(tmp_path: Path, first: float, end: str = "", spans: str = "2, 2, 2, 4", key: str = "anchor_x") -> Robot:
    """A robot of four winches, the first at *first*, mm."""
    text = f"[printer]\nkinematics: winch\nwinch_mechanical_advantage: {spans}\n"
    for letter, (x, y, z) in zip("abcd", [(first, *ANCHORS[0][1:]), *ANCHORS[1:]], strict=True):
        text += f"[stepper_{letter}]\nrotation_distance: 240\n{key}: {x}\nanchor_y: {y}\nanchor_z: {z}\n"
    path = tmp_path / "printer.cfg"
    path.write_text(text + end)
    return read_robot([path], "klipper").robot


def test_what_klipper_saved_replaces_what_stands_above(tmp_path: Path) -> None:
    saved = "\n#*# <--- SAVE_CONFIG --->\n#*# DO NOT EDIT THIS BLOCK\n#*#\n#*# [stepper_a]\n#*# anchor_x = 25.0\n"
    assert klipper(tmp_path, 0.0, saved) == klipper(tmp_path, 25.0) != klipper(tmp_path, 0.0)


def test_klipper_takes_values_over_several_lines_and_keys_in_capitals(tmp_path: Path) -> None:
    plain = klipper(tmp_path, 5.0)
    assert klipper(tmp_path, 5.0, spans="\n  2, 2,\n  2, 4  # spans") == plain
    assert klipper(tmp_path, 5.0, key="Anchor_X") == plain


@pytest.mark.parametrize(
    "text",
    [
        "M117 M666 W9", "M98 P/sys/M666 W9.g", "M550 PM666 W9", "G92 {move.M666 W9}", "G92 'm666 W9", 'M118 S"M666 W9"',
        "echo {M666} W9", "if W9\n  G4 P0", "; M666 W9", "G4 P1 ; M666 W9", "K6 M666 W9",
    ],
)  # fmt: skip
def test_what_is_no_command_is_not_read(tmp_path: Path, text: str) -> None:
    assert rrf(tmp_path, "\n".join([*COMMANDS, text])).robot == rrf(tmp_path, "\n".join(COMMANDS)).robot


def test_a_command_under_a_condition_is_rejected_on_any_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="line 6: M666 stands under 'if'"):
        rrf(tmp_path, "\n".join([*COMMANDS, "if true", "  G4 P1 M666 W9"]))


def test_lines_end_with_cr_too(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_bytes(b"a\rb\r\nc\n\r\n# d\r e")
    assert [text for _, text in text_lines(path, 99, "file")] == ["a", "b", "c", "e"]
    (tmp_path / "c.g").write_bytes(("; made\r" + "\r".join(COMMANDS)).encode())
    assert read_robot([tmp_path / "c.g"]).robot.platform.mass == 1.5  # the format by its content


# Polargraphs

LISTING = """echo:  {unit}
echo:; Maximum feedrates (units/s):
echo:  M203 X{v} Y{v} Z2.0
echo:  M665 S5.00 L-{a} R{a} T{b} B-{b} H{h}
"""


def polargraph(tmp_path: Path, text: str, name: str = "m.gcode") -> ImportedRobot:
    path = tmp_path / name
    path.write_text(text)
    return read_robot([path], "polargraph")


@pytest.mark.parametrize("unit", ["G20    ; Units in inches", "G20", "g20"])
def test_listings_in_inches(tmp_path: Path, unit: str) -> None:
    inch = polargraph(tmp_path, LISTING.format(unit=unit, v=4, a=20, b=18, h=40)).robot
    mm = polargraph(tmp_path, LISTING.format(unit="G21", v=101.6, a=508, b=457.2, h=1016)).robot
    for one, other in zip(inch.lines, mm.lines, strict=True):
        assert one.exit_point == pytest.approx(other.exit_point, rel=1e-12)
        assert one.winch.max_speed == pytest.approx(0.1016, rel=1e-12)
        assert one.winch.capacity == pytest.approx(other.winch.capacity, rel=1e-12)
    assert inch.scene.frame_min == pytest.approx(mm.scene.frame_min, rel=1e-12)


def test_the_last_unit_before_a_command_counts(tmp_path: Path) -> None:
    text = LISTING.format(unit="G20", v=4, a=508, b=457, h=1016).replace("echo:  M665", "echo:  G21\necho:  M665")
    robot = polargraph(tmp_path, text).robot
    assert robot.lines[1].exit_point == pytest.approx((0.508, 0.0, 0.457))
    assert robot.lines[1].winch.max_speed == pytest.approx(0.1016)
    path = tmp_path / "k.gcode"
    path.write_text("G20\nM101 A0 T20 B-20\nM101 A1 T30 B-30\n")
    with pytest.raises(InputError, match="line 1: G20: inches"):
        read_robot([path], "makelangelo")


@pytest.mark.parametrize(
    ("formula", "millimetres"),
    [
        ("(841/2)", 420.0),
        ("-(-841/2)", 420.0),
        ("(841.0/2)", 420.5),
        ("(841/2.)", 420.5),
        ("7/2*100", 300.0),
        ("100*7/2", 350.0),
        ("(W/2)", 420.0),  # of a name
        ("(F/2)", 420.5),
        ("S/2", 840.0),  # S is 800+80 without brackets: C replaces names by their texts
        ("sq(21)/2", 220.0),
        ("sqrt(176400)/1", 420.0),
    ],
)
def test_formulas_are_those_of_c(tmp_path: Path, formula: str, millimetres: float) -> None:
    text = f"""#define POLARGRAPH
#define W 841
#define F 841.0 // of a drawing
#define S 800+80
#define X_MAX_POS {formula}
#define X_MIN_POS -X_MAX_POS
#define Y_MAX_POS (1189/2)
#define Y_MIN_POS -(1189/2)
"""
    left, right = polargraph(tmp_path, text.replace("-X_MAX_POS", "-400"), "c.h").robot.lines
    assert right.exit_point == pytest.approx((1e-3 * millimetres, 0.0, 0.594))
    assert left.exit_point == pytest.approx((-0.4, 0.0, 0.594))


@pytest.mark.parametrize("text", ["A*A", "(A+A)", "A/0", "A", "1/(A-A)", "undefined_name"])
def test_formulas_without_end_are_rejected(tmp_path: Path, text: str) -> None:
    defines = "\n".join(f"#define A{k} {text.replace('A', f'A{k + 1}')}" for k in range(400))
    with pytest.raises(InputError):
        polargraph(tmp_path, f"#define POLARGRAPH\n#define A400 999999999999\n{defines}\n#define X_MIN_POS A0\n", "c.h")
    with pytest.raises(InputError, match="over 20 conditions"):
        polargraph(tmp_path, "#define POLARGRAPH\n" + "#if 1\n" * 1000, "c.h")


# Hostile lines

KLIPPER = "[printer]\nkinematics: winch\n" + "".join(
    f"[stepper_{k}]\nanchor_x: {x}\nanchor_y: {y}\nanchor_z: 900\nrotation_distance: 40\n"
    for k, (x, y) in {"a": (0, -900), "b": (900, 500), "c": (-900, 500)}.items()
)
MASLOW = "".join(
    f"Maslow_{name}X: {x}\nMaslow_{name}Y: {y}\nMaslow_{name}Z: 0\n"
    for name, (x, y) in {"tl": (0, 2000), "tr": (3000, 2000), "bl": (0, 0), "br": (3000, 0)}.items()
)
HOSTILE = (
    "[ {} x", "[{}] x", "a = {} x", "a: x{} y", "a: {}#", "a{}", "- {} a: b", "a:{}", "; {} ]", "$1= {} 2 (",
    "M666 Q{} x", "M669{}", 'M98 P"{}', "#define{}", "# define A {} (", "#if {} (", "M665 L{}x",
    "echo: {}", "G4 {}", "{}x", "{}:", "{}]",
)  # fmt: skip
FILLS = (" ", "\t", "1", "a", "-", "[", "(", "{", '"', " 1", "a ")
READERS: dict[str, tuple[str, Callable[[Path], object]]] = {
    "printer.cfg": (KLIPPER, lambda path: read_robot([path], "klipper")),
    "maslow.yaml": (MASLOW, lambda path: read_robot([path], "maslow")),
    "plotter.yaml": (MASLOW, lambda path: read_robot([path], "wallplotter")),
    "classic.ini": ("motorSpacingX = 2978\n", lambda path: read_robot([path], "maslow-classic")),
    "config.g": ("\n".join(COMMANDS) + "\n", lambda path: read_robot([path], "reprapfirmware")),
    "m.gcode": ("M665 L-300 R300 T500 B-600 H1000\n", lambda path: read_robot([path], "polargraph")),
    "c.h": ("#define POLARGRAPH\n#define X_MIN_POS 1\n", lambda path: read_robot([path], "polargraph")),
    "k.gcode": ("M101 A0 T20 B-20\nM101 A1 T30 B-30\n", lambda path: read_robot([path], "makelangelo")),
    "unknown": ("", lambda path: read_robot([path])),
    "survey.csv": ("point,x,y,z\n", read_shots),
    "survey.gsi": ("110001+00000X11 31..00+00012345\n", read_shots),
    "test.csv": ("force,elongation\n", read_test),
}


@pytest.mark.parametrize("name", READERS)
def test_a_hostile_line_takes_a_time_in_proportion_to_its_length(tmp_path: Path, name: str) -> None:
    """Of ten times the length: quadratic time is 100 times as long. The half second is that of a slow machine."""
    good, read = READERS[name]
    path = tmp_path / name
    longest = (
        40_000 if name in ("c.h", "unknown", "survey.csv", "survey.gsi") else 3_800
    )  # others have a limit of lines
    spent = [0.0, 0.0]
    for form in HOSTILE:
        for fill in FILLS:
            for which, size in enumerate((longest // 10, longest)):
                path.write_text(good + form.format(fill * (size // len(fill))) + "\n")
                start = time.process_time()
                with suppress(InputError):
                    read(path)
                spent[which] += time.process_time() - start
    assert spent[1] < 40.0 * spent[0] + 0.5


def test_a_number_of_many_digits_is_rejected_soon(tmp_path: Path) -> None:
    for text, read in (
        (f"point,x,y,z\nA,{'1' * 1_000_000}x,2,3\n", read_shots),
        (f"<model>\n{'1' * 1_000_000}x", lambda path: read_robot([path])),
    ):
        path = tmp_path / "a.csv"
        path.write_text(text)
        start = time.process_time()
        with pytest.raises(InputError):
            read(path)
        assert time.process_time() - start < 5.0
