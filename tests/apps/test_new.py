"""`new`: a folder of one's own, complete or absent, from options or from questions on a terminal."""

from __future__ import annotations

import os
import pty
import select
import shlex
import signal
import sys
import tomllib
from pathlib import Path

import pytest

from cases import some

pytestmark = pytest.mark.usefixtures("undrawn")

PATIENCE = 60  # s
INTERRUPT = "\x03"
PROGRAM = "import sys; sys.argv[0] = 'cablewright'; from cablewright.apps.cli.main import main; main()"


@pytest.fixture(autouse=True)
def _within(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def on_terminal(*typed: str) -> tuple[str, int]:
    """What `new attic` says on a terminal where each of *typed* is an answer, and its exit code."""
    pid, terminal = pty.fork()
    if pid == 0:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # ignored where the tests run in the background of a shell
        os.execv(sys.executable, [sys.executable, "-c", PROGRAM, "new", "attic"])
    said, answers, last, waited = "", list(typed), "", 0
    while True:
        if not select.select([terminal], [], [], 1.0)[0]:
            waited += 1
            if waited > PATIENCE:
                os.kill(pid, signal.SIGKILL)
                raise AssertionError(f"nothing was said for {PATIENCE} s after {said!r}")
            if last == INTERRUPT:  # it came between prompt and read, which Python hears with the next letter only
                os.write(terminal, last.encode())
            continue
        waited = 0
        try:
            said += os.read(terminal, 4096).decode()
        except OSError:  # Linux: the other end is closed
            return said, os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
        if said.endswith("]: ") and answers:
            last = answers.pop(0)
            os.write(terminal, last.encode())


def names(folder: str = ".") -> list[str]:
    return sorted(path.name for path in Path(folder).iterdir())


def robot(folder: str) -> dict[str, object]:
    return tomllib.loads((Path(folder) / "robot.toml").read_text())


def test_without_a_terminal_it_asks_nothing(cli) -> None:
    found = cli("new", "attic", "--json")
    assert found.code == 0
    assert found.json["folder"] == "attic"
    assert sorted(each["file"] for each in found.json["files"]) == names("attic")
    assert names() == ["attic"]
    assert found.json["print"].split()[-1] == "attic/machine.toml"


def test_on_a_terminal_it_asks_for_missing_values() -> None:
    said, code = on_terminal("round\n", "planar\n", "4\n", "3,2.5\n", "heavy\n", "3\n", "belt-at5-10mm\n", "\n")
    assert code == 0, said
    assert "allowed: body, over-middle, planar, suspended" in said
    assert "expected 2 finite numbers" in said
    assert "could not convert string to float: 'heavy'" in said
    assert robot("attic")["platform"] == {"kind": "point", "mass": "3 kg"}
    assert robot("attic")["cable"]["axial_stiffness"] == "140 kN"
    assert robot("attic")["lines"][0]["exit_point"] == [-1.5, 0.0, 2.5]


@pytest.mark.parametrize(
    "typed", [[INTERRUPT], ["\n", INTERRUPT], ["\n", "\x04"]], ids=["first", "second", "end of file"]
)
def test_leaving_the_questions_writes_nothing(typed: list[str]) -> None:
    said, code = on_terminal(*typed)
    assert code == 130
    assert "Traceback" not in said
    assert names() == []


@pytest.mark.parametrize("there", ["folder", "file", "link"])
def test_nothing_is_overwritten(cli, there: str) -> None:
    match there:
        case "folder":
            Path("attic").mkdir()
        case "file":
            Path("attic").write_text("mine")
        case _:
            Path("attic").symlink_to("elsewhere")
    assert "attic: exists already and is not overwritten" in cli("new", "attic").refusal
    assert names() == ["attic"]


def test_a_folder_that_cannot_be_made_is_the_environments_fault(cli, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    found = cli("new", "attic")
    assert found.code == 3
    assert "No space left on device" in found.err
    assert names() == []


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--size", "4,4"], "--size = '4,4': expected 3 finite numbers"),
        (["--size", ""], "--size = ''"),
        (["--size", "4,4,3", "--layout", "planar"], "expected 2 finite numbers"),
        (["--lines", "0"], "lines = 0"),
        (["--mass", "nan"], "mass = nan kg"),
    ],
)
def test_bad_options_are_one_line(cli, options: list[str], says: str) -> None:
    assert says in cli("new", "attic", *options).refusal
    assert names() == []


@pytest.mark.parametrize("name", ["house-printer", "cogiro"])
def test_a_name_of_the_library_is_taken(cli, name: str) -> None:
    assert "a robot or machine of the library has it" in cli("new", name).refusal


def test_a_hall_gets_a_square_too(cli) -> None:
    found = cli("new", "hall", "--size", "60,6,5", "--json")
    assert found.json["files"][2]["content"] == "a square of three layers"
    gcode = (Path("hall") / "part.gcode").read_text()
    assert "Y540.000" in gcode


def test_a_body_has_a_machine_that_holds_it(cli) -> None:
    assert cli("new", "attic", "--layout", "body").code == 0
    held = shlex.split("simulate attic/robot.toml --machine attic/machine.toml --hold 0,0,1 --duration 1")
    assert cli(*held).code == 0


@pytest.mark.parametrize("layout", some(["over-middle", "planar", "body"]))
def test_the_first_part_of_each_layout_can_be_printed(cli, layout: str) -> None:
    cli("new", "attic", "--layout", layout)
    found = cli("check", "attic/robot.toml", "attic/part.toml", "--json")
    assert found.json["feasible"], found.err
    assert found.json["uncertainty"] == "assumed"
    assert found.json["layers"] == 3


@pytest.mark.parametrize("layout", ["over-middle", "planar"])
def test_and_prints_on_the_simulated_machine(cli, layout: str) -> None:
    cli("new", "attic", "--layout", layout)
    options = ("--machine", "attic/machine.toml", "--plant", "quasi-static", "--layers", "1", "--json")
    found = cli("print", "attic/robot.toml", "attic/part.toml", *options)
    assert found.json["status"] == "finished"
    assert found.json["max_error_in_space"] < 0.01
