"""A key is held at a terminal by a person: a pipe, or what was typed before, holds nothing."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).parents[3] / "examples" / "virtual-drives.toml"
WATCH = """
import sys, time
from cablewright.apps.cli.drives.terminal import button
with button() as held:
    print("ready", flush=True)
    end, found = time.monotonic() + 1.0, 0
    while time.monotonic() < end:
        found += held.held()
        time.sleep(0.005)
    print(found, held.ended(), flush=True)
"""


def test_a_pipe_is_no_held_button() -> None:
    command = [sys.executable, "-m", "cablewright", "drives", "jog", "merlet2023", "--machine", str(EXAMPLE)]
    found = subprocess.run(
        [*command, "--line", "south-west"], input="jjjjjjjj\n" * 1000, capture_output=True, text=True, timeout=60.0
    )
    assert found.returncode == 3
    assert (
        found.stderr.strip()
        .splitlines()[-1]
        .endswith("drives jog: a key has to be held at a terminal (Linux or macOS); the standard input is none")
    )


@pytest.mark.skipif(sys.platform == "win32", reason="needs a pseudo terminal")
def test_keys_of_before_are_forgotten_and_the_letter_q_ends_it() -> None:
    import pty

    own, other = pty.openpty()
    os.write(own, b"jjjj")  # typed while it starts
    assert watched(own, other, []) == ["0", "False"]
    counted, ended = watched(own, other, [b"j"] * 10 + [b"q"])
    assert int(counted) > 20
    assert ended == "True"
    os.close(own)
    os.close(other)


def watched(own: int, other: int, keys: list[bytes]) -> list[str]:
    """In how many of 200 looks the button was held, and whether the person ended it."""
    with subprocess.Popen([sys.executable, "-c", WATCH], stdin=other, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        for key in keys:
            os.write(own, key)
            time.sleep(0.03)
        return process.stdout.readline().split()
