"""Whatever is wrong with the input: exit 2, one line that says what is wrong, nothing on stdout."""

from __future__ import annotations

from pathlib import Path

import pytest

from cablewright.robot import library_text

HOUSE = "house-printer"
AT = ("--at", "0,0,1")
LENGTHS = ("--lengths", "28,28,28,28")


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["inverse", HOUSE, "--at", "1,2"], "3 numbers are expected"),
        (["inverse", HOUSE, "--at", "1,2,3,4,5,6"], "3 numbers are expected"),
        (["inverse", HOUSE, "--at", "1,2,nan"], "none can be free"),
        (["inverse", HOUSE, "--at", "1,inf,3"], "finite; got inf"),
        (["inverse", HOUSE, "--at", "1,-inf,3"], "finite; got -inf"),
        (["inverse", HOUSE, "--at", "1,2,1e999"], "finite; got inf"),
        (["inverse", HOUSE, "--at", "here"], "'here': expected numbers with commas"),
        (["inverse", HOUSE, "--at", ""], "--at = ''"),
        (["inverse", HOUSE, "--at", "1,,3"], "--at = '1,,3'"),
        (["inverse", HOUSE, "--at", "1;2;3"], "numbers with commas"),
        (["inverse", HOUSE, "--at", "1\n2"], "numbers with commas"),
        (["forward", HOUSE, "--lengths", "28,28,28"], "4 numbers are expected"),
        (["forward", HOUSE, "--lengths", "28,28,28,28,28"], "4 numbers are expected"),
        (["forward", HOUSE, "--lengths", "28,28,28,nan"], "finite"),
        (["forward", HOUSE, "--lengths", "28,28,28,inf"], "finite"),
        (["forward", HOUSE, "--lengths", "28,28,28,-28"], "over zero; got -28 m"),
        (["forward", HOUSE, "--lengths", "28,28,28,0"], "over zero; got 0 m"),
        (["forward", HOUSE, "--lengths", "long"], "'long'"),
        (["forward", HOUSE, *LENGTHS, "--guess", "0,0"], "guess: 3 numbers"),
        (["forward", HOUSE, *LENGTHS, "--guess", "0,0,nan"], "guess: every number must be finite"),
        (["forward", HOUSE, *LENGTHS, "--modulus-factors", "1,1,1"], "modulus factors: 4 numbers"),
        (["forward", HOUSE, *LENGTHS, "--modulus-factors", "1,1,1,0"], "over zero; got 0"),
        (["forward", HOUSE, *LENGTHS, "--modulus-factors", "1,1,1,-1"], "over zero; got -1"),
        (["forward", HOUSE, *LENGTHS, "--modulus-factors", "1,1,1,nan"], "finite"),
        (["forward", HOUSE, *LENGTHS, "--cable", "rigid"], "do not determine tensions; use elastic or catenary"),
        (["inverse", HOUSE, *AT, "--cable", "cord"], "'cord' is not one of 'rigid', 'elastic', 'catenary'"),
        (["inverse", HOUSE, *AT, "--cable", "catenry"], "'catenry' is not one of 'rigid', 'elastic', 'catenary'"),
        (["inverse", HOUSE, *AT, "--sheave", "pulley"], "'pulley' is not one of"),
        (["inverse", "merlet2023", *AT, "--sheave", "universal-joint"], "has only a sheave of kind swivel"),
        (["inverse", HOUSE, *AT, "--tension-limits", "100,50"], "0 <= lowest < highest"),
        (["inverse", HOUSE, *AT, "--tension-limits", "50,50"], "0 <= lowest < highest"),
        (["inverse", HOUSE, *AT, "--tension-limits=-5,50"], "0 <= lowest < highest"),
        (["inverse", HOUSE, *AT, "--tension-limits", "nan,50"], "0 <= lowest < highest"),
        (["inverse", HOUSE, *AT, "--tension-limits", "5,inf"], "0 <= lowest < highest"),
        (["inverse", HOUSE, *AT, "--tension-limits", "5"], "expected MIN,MAX in N"),
        (["inverse", HOUSE, *AT, "--tension-limits", "5,6,7"], "expected MIN,MAX in N"),
        (["inverse", HOUSE, *AT, "--tension-limits", "low,high"], "numbers with commas"),
        (["inverse", "house-printr", *AT], "did you mean 'house-printer'?"),
        (["inverse", "zzz", *AT], "allowed: building-printer, cable-robot-simulator, "),
        (["inverse", "no/such.toml", *AT], "no/such.toml: no such file"),
        (["robots", "paty"], "did you mean 'paty2021'?"),
        (["check", HOUSE, "no-such.gcode"], "no-such.gcode: no such file"),
        (["check", HOUSE, "no-such.toml"], "no-such.toml: no such file"),
        (["sing"], "No such command 'sing'"),
        (["inverse", HOUSE, *AT, "--loud"], "No such option: --loud"),
        (["inverse", HOUSE], "Missing option '--at'"),
        (["inverse", HOUSE, "--at"], "requires an argument"),
        (["forward", HOUSE], "Missing option '--lengths'"),
        (["inverse"], "Missing argument 'ROBOT'"),
        (["check", HOUSE], "Missing argument 'JOB'"),
        (["inverse", HOUSE, "twice", *AT], "unexpected extra argument"),
    ],
)
def test_arguments(cli, arguments: list[str], says: str) -> None:
    assert says in cli(*arguments).refusal
    if arguments[0] != "sing":
        assert says in cli(arguments[0], "--json", *arguments[1:]).refusal


def test_without_a_command_the_help_is_the_answer(cli) -> None:
    """Either help on stdout and exit 0, or a rejection that says something: not help and an empty sentence."""
    answer = cli()
    if answer.code == 0:
        assert "Usage:" in answer.out
        assert answer.err == ""
    else:
        assert "command" in answer.refusal.lower()


def test_a_rejection_is_one_line_even_where_kernels_are_still_to_be_compiled(cli, monkeypatch) -> None:
    monkeypatch.setattr("cablewright.solvers.row_threads.is_compiled", lambda *_: False)
    monkeypatch.setattr("cablewright.solvers.row_threads._ready", set())
    assert "finite" in cli("forward", HOUSE, "--lengths", "1,2,3,nan").refusal
    assert "4 numbers" in cli("forward", HOUSE, "--lengths", "1,2,3").refusal


CHANGES = [
    ("radius =", "radios =", "did you mean 'radius'"),
    ('"40 kg"', '"40 m"', "platform.mass"),
    ('"40 kg"', '"-40 kg"', "greater than 0"),
    ('"40 kg"', '"0 kg"', "greater than 0"),
    ('"40 kg"', '"forty kg"', "platform.mass = 'forty kg'"),
    ('"40 kg"', "nan", "platform.mass"),
    ('"40 kg"', "9e999", "platform.mass"),
    ('"40 kg"', '"9**9**9 kg"', "platform.mass"),
    ("winch_exit = [-2.5, -5.0, 0.0]", "winch_exit = [-2.5, -5.0, 9.0]", "must be below exit_point"),
    ('["1 N", "2 kN"]', '["2 kN", "1 N"]', "tension_limits"),
    ('"swivel"', '"swivle"', "kind"),
    ("schema = 1", "schema = 2", "newer cablewright"),
    ("schema = 1", "", "schema"),
    ('name = "south-east"', 'name = "south-west"', "2 lines are named 'south-west'"),
    ("[platform]", "[platform", "not TOML"),
    ("gravity = ", "gravity = [[[", "not TOML"),
]


@pytest.mark.parametrize(("old", "new", "says"), CHANGES)
def test_robot_files(cli, tmp_path: Path, old: str, new: str, says: str) -> None:
    text = library_text("merlet2023")
    assert old in text
    file = tmp_path / "mine.toml"
    file.write_text(text.replace(old, new, 1))
    line = cli("inverse", file, *AT).refusal
    assert line.startswith(str(file))
    assert says in line


DEEP = ["a = " + 1000 * "[" + 1000 * "]", "a = " + 1000 * "{b=" + "1" + 1000 * "}", ".".join(["a"] * 1000) + " = 1"]


@pytest.mark.parametrize("text", DEEP)
@pytest.mark.parametrize("command", ["inverse", "check"])
def test_nesting_a_thousand_deep(cli, tmp_path: Path, text: str, command: str) -> None:
    file = tmp_path / "deep.toml"
    file.write_text(text)
    arguments = ("inverse", file, *AT) if command == "inverse" else ("check", HOUSE, file)
    assert "nested deeper than" in cli(*arguments).refusal


@pytest.mark.parametrize("data", [b"", b"\xff\xfe\x00\x01" * 500, b"\0" * 100, b"schema = 1\n" * 2, b"= = ="])
def test_robot_files_that_are_none(cli, tmp_path: Path, data: bytes) -> None:
    file = tmp_path / "r.toml"
    file.write_bytes(data)
    assert str(file) in cli("inverse", file, *AT).refusal


def test_a_folder_is_neither_robot_nor_job(cli, tmp_path: Path) -> None:
    assert "not a regular file" in cli("inverse", tmp_path, *AT).refusal
    assert "not a regular file" in cli("check", HOUSE, tmp_path).refusal


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"", "the file is empty"),
        (bytes(range(256)) * 20, "binary"),
        (b"G1 X1 E1\n\0\n", "NUL"),
        (b"G21\nG90\nM83\nG1 X10 E1\nG1 X20 Y", "truncated"),
        (b"G21\nG90\nM83\nG1 X10 E1\nG2 X20 Y1 E1\n", "line 5: 'G2 X20 Y1 E1': an arc needs either R, or I and J"),
        (b"G21\nG90\nM83\nG1 X10 E1\nG2 X20 Y1 R0 E1\n", "line 5"),
        (b"G21\nG90\nG1 X10\n", "no extruding move"),
        (b"; nothing but words\n", "no extruding move"),
        (b"G1 X1e99 E1\n", "line 1"),
        (b"G1 Xten E1\n", "line 1"),
    ],
)
def test_gcode(cli, tmp_path: Path, data: bytes, says: str) -> None:
    file = tmp_path / "part.gcode"
    file.write_bytes(data)
    line = cli("check", HOUSE, file, "--out", tmp_path / "run").refusal
    assert line.startswith(str(file))
    assert says in line
    assert not (tmp_path / "run").exists()


def test_a_job_that_leads_out_of_its_folder(cli, tmp_path: Path) -> None:
    file = tmp_path / "job.toml"
    file.write_text('schema = 1\nname = "x"\ngcode = "../../etc/passwd"\n')
    assert "leaves the folder of the job" in cli("check", HOUSE, file).refusal
