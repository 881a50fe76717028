"""Virtual drives in a process of their own: what is typed at their terminal."""

from __future__ import annotations

import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from cablewright.apps.cli.drives import terminal

EXAMPLE = Path(__file__).parents[3] / "examples" / "virtual-drives.toml"


def free_channel() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


@pytest.fixture
def drives(tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    file = tmp_path / "machine.toml"
    file.write_text(EXAMPLE.read_text("utf-8").replace('"43113"', f'"{free_channel()}"'), encoding="utf-8")
    command = [sys.executable, "-m", "cablewright", "drives", "--virtual", str(file), "--at", "0.7,-0.5,1"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        yield process
        process.kill()


def test_refill_fills_the_drum_and_the_end_of_the_input_ends_nothing(drives: subprocess.Popen[str]) -> None:
    assert drives.stdin is not None
    assert drives.stderr is not None
    said = [drives.stderr.readline(), drives.stderr.readline()]
    assert said[0].endswith("Ctrl-C ends them\n")
    assert said[1] == "refill, typed here, fills the drum\n"
    drives.stdin.write(f"  refill \nhello {'x' * 5000}\n\n")
    drives.stdin.close()
    assert drives.stderr.readline() == "the drum holds 10 kg again\n"
    refused = drives.stderr.readline()
    assert refused.startswith("no order 'hello xxx")
    assert refused.endswith("virtual drives know: refill\n")
    assert len(refused) < 300
    with pytest.raises(subprocess.TimeoutExpired):
        drives.wait(timeout=0.5)
    drives.terminate()
    assert drives.wait(timeout=20.0) == 130


def test_a_terminal_of_another_job_is_the_end_of_the_input(monkeypatch: pytest.MonkeyPatch) -> None:
    class Taken:
        def __iter__(self) -> Iterator[bytes]:
            yield b"refill\n"
            raise OSError(5, "Input/output error")

    class Terminal:
        buffer = Taken()

    monkeypatch.setattr(sys, "stdin", Terminal())
    lines = terminal.TypedLines()
    lines.begin()
    found: list[str] = []
    while not lines.over():
        found += lines.typed()
    assert found == ["refill\n"]
