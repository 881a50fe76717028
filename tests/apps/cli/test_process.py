"""The command as a process: exit codes, a pure stdout, interruptions, tracebacks only on request."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cablewright.apps.cli import main
from cablewright.robot import Scene, library_text
from cases import some

HOUSE = Path(__file__).resolve().parents[3] / "examples" / "house.toml"
COMMAND = [sys.executable, "-m", "cablewright"]


def start(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*COMMAND, *arguments], capture_output=True, text=True, timeout=300, check=False)


@pytest.mark.slow  # as test_a_no, with the other status
def test_a_yes() -> None:
    ended = start("inverse", "merlet2023", "--at", "0,0,1", "--json")
    assert ended.returncode == 0
    assert json.loads(ended.stdout)["status"] == "ok"


def test_a_no() -> None:
    ended = start("inverse", "merlet2023", "--at", "0,0,4.5", "--json")
    assert ended.returncode == 1
    assert json.loads(ended.stdout)["status"] == "infeasible"
    assert "no tensions within the limits" in ended.stderr.splitlines()[-1]


def test_bad_input() -> None:
    ended = start("inverse", "merlet2023", "--at", "0,0")
    assert (ended.returncode, ended.stdout) == (2, "")
    assert "Traceback" not in ended.stderr


@pytest.mark.parametrize(
    ("given", "used"), [({}, "1"), ({"OPENBLAS_NUM_THREADS": "3"}, "3"), ({"OMP_NUM_THREADS": "2"}, "None")]
)
def test_numpy_has_one_thread_unless_the_user_wants_more(given: dict[str, str], used: str) -> None:
    run = "import os, sys\nfrom cablewright.__main__ import main\nsys.argv[1:] = ['--version']\ntry:\n    main()\n"
    others = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
    told = [sys.executable, "-c", run + "finally:\n    print(os.environ.get('OPENBLAS_NUM_THREADS'))"]
    ended = subprocess.run(told, env=others | given, capture_output=True, text=True, timeout=60, check=False)
    assert ended.stdout.splitlines()[-1] == used


def test_help_appears_within_its_time() -> None:
    walls = []
    for _ in range(3):
        begin = time.perf_counter()
        ended = start("--help")
        walls.append(time.perf_counter() - begin)
        assert ended.returncode == 0
        assert "check" in ended.stdout
    assert min(walls) <= 1.5


def test_a_reader_that_has_seen_enough_is_no_failure() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    try:
        ended = subprocess.run([*COMMAND, "robots", "paty2021"], stdout=writer, stderr=subprocess.PIPE, check=False)
    finally:
        os.close(writer)
    assert ended.returncode == 0
    assert ended.stderr == b""


def test_a_full_disk_under_stdout() -> None:
    if not os.path.exists("/dev/full"):  # noqa: PTH110
        pytest.skip("no /dev/full here")
    with open("/dev/full", "w") as full:
        ended = subprocess.run([*COMMAND, "schema"], stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert ended.returncode == 3
    assert ended.stderr.count("\n") == 1


def raising(error: BaseException) -> Callable[..., None]:
    def call(*_arguments: object, **_options: object) -> None:
        raise error

    return call


def test_full_memory_is_the_environments_fault(cli, monkeypatch) -> None:
    monkeypatch.setattr("cablewright.solvers.inverse.solve_inverse", raising(MemoryError()))
    answer = cli("inverse", "merlet2023", "--at", "0,0,1", "--json")
    assert (answer.code, answer.out) == (3, "")
    assert answer.err == "cablewright: there is not enough memory for this\n"


@pytest.mark.parametrize(
    "error", [np.linalg.LinAlgError("Singular matrix"), OverflowError("too large"), ZeroDivisionError()]
)
def test_numbers_that_cannot_be_computed_with_are_a_no(cli, monkeypatch, error: Exception) -> None:
    monkeypatch.setattr("cablewright.solvers.inverse.solve_inverse", raising(error))
    answer = cli("inverse", "merlet2023", "--at", "0,0,1", "--json")
    assert answer.code == 1
    assert answer.json["status"] == "not-computed"
    assert type(error).__name__ in answer.no


def test_a_robot_that_follows_and_is_none_is_bad_input(cli, monkeypatch) -> None:
    def made(*_arguments: object, **_options: object) -> None:
        Scene(frame_min=(0.0, 0.0, 0.0), frame_max=(1.0, 1.0, -1.0))

    monkeypatch.setattr("cablewright.solvers.inverse.solve_inverse", made)
    assert "must be above frame_min in z" in cli("inverse", "merlet2023", "--at", "0,0,1").refusal


@pytest.mark.parametrize(
    ("asked", "waits"), [(signal.SIGINT, (0.2, 2.0)), (signal.SIGTERM, (0.3,))], ids=["interrupt", "terminate"]
)
def test_a_request_to_end_is_heard_anywhere(asked: signal.Signals, waits: tuple[float, ...], tmp_path: Path) -> None:
    """Early, in our imports; later, while kernels are compiled, where Numba makes errors of its own of it."""
    for wait in waits:
        process = subprocess.Popen(
            [*COMMAND, "check", "house-printer", str(HOUSE), "--out", str(tmp_path / "run")],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path,
            env=os.environ | {"CABLEWRIGHT_CACHE_DIR": str(tmp_path / "cache")},
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )  # fmt: skip
        time.sleep(wait)
        process.send_signal(asked)
        _, err = process.communicate(timeout=60)
        assert "Traceback" not in err, wait
        assert process.returncode == 130, wait
        assert [each.name for each in tmp_path.iterdir() if each.name != "cache"] == []


def test_objects_half_made_by_an_interruption_are_not_reported() -> None:
    program = """
import os, signal
from cablewright.apps.cli import main
class Half:
    def __del__(self):
        raise ValueError("half made")
def run(_):
    Half()
    try:
        os.kill(os.getpid(), signal.SIGTERM)
    except KeyboardInterrupt:
        pass
    Half()
    return main.INTERRUPTED
main.run = run
main.main()
"""
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, check=False, text=True)
    assert ended.returncode == 130
    assert ended.stderr.count("half made") == 1  # before it was asked


@pytest.mark.parametrize("asked", some([signal.SIGINT, signal.SIGTERM]))
def test_a_request_after_the_answer_changes_nothing(asked: signal.Signals) -> None:
    program = (
        "import atexit, os; from cablewright.apps.cli.main import main; "
        f"atexit.register(os.kill, os.getpid(), {int(asked)}); main()"
    )
    ended = subprocess.run([sys.executable, "-c", program, "machines"], capture_output=True, check=False)
    assert (ended.returncode, ended.stderr) == (0, b"")
    assert b"merlet2023" in ended.stdout


def solved_by(function: str) -> tuple[int, str, str]:
    """Exit code, output and messages of `inverse` with the text of a function ``solve`` in the place of the solver."""
    begin = """
import contextlib, ctypes, os, signal, time
import cablewright.solvers.inverse
from cablewright.apps.cli.main import main
"""
    finish = """
cablewright.solvers.inverse.solve_inverse = solve
signal.signal(signal.SIGINT, signal.SIG_DFL)
main()
"""
    asked = [sys.executable, "-c", begin + function + finish, "inverse", "merlet2023", "--at", "0,0,1"]
    ended = subprocess.run(asked, capture_output=True, text=True, check=False, timeout=50)
    return ended.returncode, ended.stdout, ended.stderr


def test_a_request_while_llvm_makes_something_waits_until_that_is_made() -> None:
    """What it leaves half made has ended the process with a segmentation fault."""
    making = """
text = "def make():\\n    os.kill(os.getpid(), signal.SIGINT)\\n    time.sleep(0.15)\\n    print('made')"
llvm = {"__name__": "llvmlite.binding.module", "os": os, "signal": signal, "time": time}
exec(text, llvm)

def solve(*arguments, **options):
    llvm["make"]()
    time.sleep(5.0)
    print("not ended")
"""
    assert solved_by(making) == (130, "made\n", "cablewright: interrupted\n")


def test_a_request_in_a_callback_from_c_is_not_lost() -> None:
    """There Python cannot raise: LLVM calls back while it compiles."""
    compiling = """
@ctypes.CFUNCTYPE(None)
def back():
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(0.01)

def solve(*arguments, **options):
    back()
    while True:
        time.sleep(0.01)
"""
    assert solved_by(compiling) == (130, "", "cablewright: interrupted\n")


def test_a_request_that_c_code_swallows_is_not_lost() -> None:
    """As imports of Cython modules do, which catch everything."""
    swallowing = """
def solve(*arguments, **options):
    with contextlib.suppress(BaseException):
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(5)
    while True:
        time.sleep(0.01)
"""
    assert solved_by(swallowing) == (130, "", "cablewright: interrupted\n")


def test_a_request_that_is_being_handled_is_not_repeated() -> None:
    """Saving at the end may take as long as needed."""
    saving = """
def solve(*arguments, **options):
    try:
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(5)
    finally:
        for _ in range(50):
            time.sleep(0.01)
        print("saved", flush=True)
"""
    assert solved_by(saving) == (130, "saved\n", "cablewright: interrupted\n")


def test_an_error_after_an_interruption_is_the_interruption(cli, monkeypatch) -> None:
    def call(*_arguments: object, **_options: object) -> None:
        try:
            main._interrupt(2, None)
        except KeyboardInterrupt:
            raise RuntimeError("what a library makes of it") from None

    monkeypatch.setattr(main._Interrupts, "asked", 0)
    monkeypatch.setattr("cablewright.solvers.inverse.solve_inverse", call)
    assert cli("inverse", "merlet2023", "--at", "0,0,1").code == 130
    monkeypatch.setattr(main._Interrupts, "asked", 0)
    monkeypatch.setattr("cablewright.solvers.inverse.solve_inverse", raising(RuntimeError("our own fault")))
    with pytest.raises(RuntimeError):
        cli("inverse", "merlet2023", "--at", "0,0,1")


@pytest.mark.parametrize("encoding", ["latin-1", "ascii", "cp437"])
def test_letters_that_a_terminal_does_not_know(encoding: str) -> None:
    ended = subprocess.run(
        [*COMMAND, "trade", "--help"], capture_output=True, env=os.environ | {"PYTHONIOENCODING": encoding}, check=False
    )
    assert (ended.returncode, ended.stderr) == (0, b"")


def test_names_from_files_do_not_reach_the_terminal_raw(cli, tmp_path: Path) -> None:
    evil = "\x1b]0;pwned\x07\x1b[31m\nstatus  ok\u009b\u202e"
    text = library_text("merlet2023").replace('name = "merlet2023"', f"name = {json.dumps(evil)}")
    (tmp_path / "evil.toml").write_text(text)
    (tmp_path / "worse.toml").write_text(text.replace("[cable]", f"[cable]\n{json.dumps(evil)} = 1"))
    for command in (("inverse", tmp_path / "evil.toml", "--at", "0,0,1"), ("inverse", tmp_path / "worse.toml")):
        answer = cli(*command)
        assert (answer.out + answer.err).replace("\n", "").isprintable()
    assert "\\x1b" in cli("inverse", tmp_path / "evil.toml", "--at", "0,0,1").out
    assert cli("inverse", tmp_path / "evil.toml", "--at", "0,0,1").out.count("status  ok") == 0 + 1
    written = cli("machines", "--for", tmp_path / "evil.toml").out
    assert written.replace("\n", "").isprintable()
    assert tomllib.loads(written)["robot"] == evil


def test_no_message_is_long(cli, tmp_path: Path) -> None:
    (tmp_path / "long.toml").write_text("\n".join(f"key{k}{'x' * 2000} = 1" for k in range(200)))
    answer = cli("inverse", tmp_path / "long.toml", "--at", "0,0,1")
    assert answer.code == 2
    assert len(answer.err) < 2100


def test_an_interruption(cli, monkeypatch) -> None:
    monkeypatch.setattr("cablewright.solvers.inverse.solve_inverse", raising(KeyboardInterrupt()))
    answer = cli("inverse", "merlet2023", "--at", "0,0,1", "--json")
    assert (answer.code, answer.out) == (130, "")
    assert "Traceback" not in answer.err


@pytest.mark.parametrize("place", [0, -1])
def test_debug_shows_where_an_error_came_from(cli, place: int) -> None:
    arguments = ["inverse", "unknown", "--at", "0,0,1"]
    arguments.insert(place % (len(arguments) + 1), "--debug")
    answer = cli(*arguments)
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith("Traceback")
    assert answer.err.splitlines()[-1].startswith("cablewright: no robot 'unknown'")


def test_debug_adds_nothing_to_a_yes(cli) -> None:
    plain = cli("inverse", "merlet2023", "--at", "0,0,1", "--json")
    assert cli("--debug", "inverse", "merlet2023", "--at", "0,0,1", "--json") == plain


def test_version_and_help(cli) -> None:
    assert cli("--version").out.startswith("cablewright ")
    for command in ("check", "forward", "inverse", "robots", "schema"):
        assert command in cli("--help").out
        assert cli(command, "--help").code == 0
