"""One program at a time in the folder of a print: the second one is rejected, and a killed one leaves nothing."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from cablewright.foundation.errors import EnvironmentFault
from cablewright.live.prints.run import LOCK, alone_in

HOLDS = """
import sys, time
from pathlib import Path
from cablewright.live.prints.run import alone_in
with alone_in(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(600)
"""


def refuse(folder: Path) -> None:
    """Somebody else has the lock of *folder*."""
    with pytest.raises(EnvironmentFault) as caught, alone_in(folder):
        pytest.fail("the block must not be entered")
    assert str(caught.value) == f"{folder}: another program works in this folder"


def admit(folder: Path) -> None:
    """Free the lock."""
    with alone_in(folder):
        pass


def test_one_at_a_time_until_it_ends(tmp_path: Path) -> None:
    with alone_in(tmp_path):
        refuse(tmp_path)
    admit(tmp_path)


def test_a_killed_program_leaves_no_lock(tmp_path: Path) -> None:
    with subprocess.Popen([sys.executable, "-c", HOLDS, tmp_path], stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "held\n"
        refuse(tmp_path)
        other.kill()
    admit(tmp_path)


def test_what_goes_wrong_inside_is_not_the_locks(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="mine"), alone_in(tmp_path):
        raise OSError("mine")
    admit(tmp_path)


@pytest.mark.parametrize("there", ["text", ""])
def test_a_link_is_rejected_and_what_it_leads_to_stays(tmp_path: Path, there: str) -> None:
    folder, target = tmp_path / "run", tmp_path / "thesis.txt"
    folder.mkdir()
    if there:
        target.write_text(there)
    (folder / LOCK).symlink_to(target)
    with pytest.raises(EnvironmentFault, match="lock: cannot be written: "), alone_in(folder):
        pytest.fail("the block must not be entered")
    assert target.exists() == bool(there)
    assert not there or target.read_text() == there


def test_what_is_in_the_file_stays(tmp_path: Path) -> None:
    (tmp_path / LOCK).write_text("somebody's notes")
    admit(tmp_path)
    assert (tmp_path / LOCK).read_text() == "somebody's notes"
