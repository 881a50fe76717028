"""What a killed run leaves: at most half a second is lost, segments read as one log, and join to one."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader

from cablewright.foundation.errors import EnvironmentFault, InputError
from cablewright.foundation.signals import Climate, Command, Scan, SensorFrame, Truth
from cablewright.machine.log.head import LogHead
from cablewright.machine.log.join import join_log
from cablewright.machine.log.log import LogWriter, read_log, write_log
from cablewright.machine.log.segments import log_files, next_segment
from twins import head, machine

HEAD = head()


def steps(path: Path, begin: int, end: int, mark: float = 0.0, told: LogHead = HEAD, *, ends: bool = True) -> None:
    """A file at *path* of steps *begin* to *end*, whose readings are *mark*; cut off where it does not end."""
    with path.open("wb") as file:
        log = LogWriter(file, told, flush_every=0.05)
        for k in range(begin, end):
            now = 0.01 * (k + 1)
            log.write(SensorFrame(now, (Climate(now, mark, 0.5),)))
        if ends:
            log.__exit__(None, None, None)


def contents(path: Path) -> tuple[list[tuple[int, float]], list[str]]:
    """Number and mark of each step."""
    with read_log(path) as log:
        found = [
            (round(entry.frame.time / 0.01), [each.temperature for each in entry.frame.of(Climate)])
            for entry in log.entries()
        ]
        assert all(len(marks) == 1 for _, marks in found)
        return [(k, marks[0]) for k, marks in found], log.notes


EXPECTED = [(k, 0.0) for k in range(1, 71)] + [(k, 3.0) for k in range(71, 101)] + [(k, 4.0) for k in range(101, 151)]


def killed(folder: Path) -> None:
    """Killed four times: the second had not written a step yet; the fourth resumed before the third began."""
    steps(folder / "log-000.mcap", 0, 100, 0.0, ends=False)
    (folder / "log-001.mcap").write_bytes((folder / "log-000.mcap").read_bytes()[:200])
    steps(folder / "log-002.mcap", 80, 110, 2.0, ends=False)
    steps(folder / "log-003.mcap", 70, 120, 3.0, ends=False)
    steps(folder / "log-004.mcap", 100, 150, 4.0)


def test_segments_read_as_one_log(tmp_path: Path) -> None:
    killed(tmp_path)
    found, notes = contents(tmp_path)
    assert found == EXPECTED
    assert len(notes) == 1
    assert "log-001.mcap: this file is not a log of a machine" in notes[0]
    assert next_segment(tmp_path) == tmp_path / "log-005.mcap"


def test_a_gap_between_segments_is_named(tmp_path: Path) -> None:
    steps(tmp_path / "log-000.mcap", 0, 50)
    steps(tmp_path / "log-001.mcap", 60, 90)
    found, notes = contents(tmp_path)
    assert [k for k, _ in found] == [*range(1, 51), *range(61, 91)]
    assert notes == ["nothing was logged from 0.5 to 0.61 s"]


def test_segments_join_to_one_file_that_others_read(tmp_path: Path) -> None:
    killed(tmp_path)
    assert join_log(tmp_path) == tmp_path / "log.mcap"
    assert [path.name for path in tmp_path.iterdir()] == ["log.mcap"]
    assert contents(tmp_path) == (EXPECTED, [])
    assert contents(tmp_path / "log.mcap") == (EXPECTED, [])
    assert join_log(tmp_path) == tmp_path / "log.mcap"
    with (tmp_path / "log.mcap").open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == 2 * len(EXPECTED)
        assert summary.statistics.metadata_count == 1
        assert sum(1 for _ in reader.iter_messages(topics=["/frame"])) == len(EXPECTED)


def test_a_join_interrupted_anywhere_leaves_the_same_log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    killed(tmp_path)
    whole = Path.unlink
    for left in (4, 2, 1, 0):

        def unlink(path: Path, missing_ok: bool = False, left: int = left) -> None:
            if path.name.startswith("log-") and len(log_files(tmp_path)) - 1 <= left:
                raise KeyboardInterrupt
            whole(path, missing_ok=missing_ok)

        monkeypatch.setattr(Path, "unlink", unlink)
        if left:
            with pytest.raises(KeyboardInterrupt):
                join_log(tmp_path)
        else:
            join_log(tmp_path)
        assert contents(tmp_path)[0] == EXPECTED
    assert [path.name for path in tmp_path.iterdir()] == ["log.mcap"]


def test_a_joined_log_goes_on_with_segments(tmp_path: Path) -> None:
    killed(tmp_path)
    join_log(tmp_path)
    steps(next_segment(tmp_path), 140, 160, 5.0)
    after = [*EXPECTED[:140], *((k, 5.0) for k in range(141, 161))]
    assert contents(tmp_path) == (after, [])
    join_log(tmp_path)
    assert contents(tmp_path) == (after, [])


def test_segments_of_two_machines_are_rejected(tmp_path: Path) -> None:
    steps(tmp_path / "log-000.mcap", 0, 10)
    steps(tmp_path / "log-001.mcap", 5, 10, told=replace(HEAD, seed=2))
    with pytest.raises(InputError, match=r"log-001\.mcap: belongs to another machine or run than log-000\.mcap"):
        read_log(tmp_path)
    for path in log_files(tmp_path):
        path.write_bytes(b"")
    with pytest.raises(InputError, match="nor any of 2 segments"):
        read_log(tmp_path)


PROGRAM = """
import sys
from pathlib import Path
from test_segments import HEAD
from cablewright.machine.log.log import write_log
from cablewright.foundation.signals import Climate, SensorFrame
with write_log(Path(sys.argv[1]), HEAD) as log:
    for k in range(1, 10**9):
        log.write(SensorFrame(0.01 * k, (Climate(0.01 * k, 0.0, 0.5),)))
        print(k, flush=True)
"""


def test_a_killed_writer_loses_half_a_second(tmp_path: Path) -> None:
    path = tmp_path / "log-000.mcap"
    where = os.pathsep.join([*sys.path, str(Path(__file__).parent)])
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, str(path)], stdout=subprocess.PIPE, env={**os.environ, "PYTHONPATH": where}
    )
    assert process.stdout is not None
    with process.stdout as lines:
        for line in lines:
            if int(line) == 333:
                break
        time.sleep(0.01)
        process.send_signal(signal.SIGKILL)
        last = max([333, *(int(line) for line in lines if line.endswith(b"\n"))])
    process.wait()
    found, _ = contents(path)
    assert [k for k, _ in found] == list(range(1, len(found) + 1))
    assert len(found) >= last - 50


def test_a_clock_of_its_own_decides_when_to_flush(tmp_path: Path) -> None:
    now = [0.0]
    with write_log(tmp_path / "a.mcap", HEAD, flush_every=1.0, clock=lambda: now[0]) as log:
        sizes = []
        for k in range(1, 41):
            now[0] = 0.05 * k
            log.write(SensorFrame(0.01 * k))
            sizes.append((tmp_path / "a.mcap").stat().st_size)
    assert [k + 1 for k in range(1, 40) if sizes[k] != sizes[k - 1]] == [21]


class Full(io.RawIOBase):
    """A file on a disk that holds no more than some bytes."""

    name = "full.mcap"

    def __init__(self, room: int) -> None:
        self.room, self.at = room, 0

    def writable(self) -> bool:
        return True

    def tell(self) -> int:
        return self.at

    def write(self, data: Any) -> int:
        took = min(len(data), self.room - self.at)
        if not took:
            raise OSError(28, "No space left on device")
        self.at += took
        return took


@pytest.mark.parametrize("room", [10, 3000, 40_000])
def test_a_full_disk_is_reported_in_one_line(room: int) -> None:
    twin, logs = machine(plant="quasi-static"), list[LogWriter]()

    def fill() -> None:
        with LogWriter(io.BufferedWriter(Full(room)), HEAD, flush_every=0.5) as log:
            logs.append(log)
            for _ in range(300):
                log.write(twin.step(Command(twin.time, np.zeros(4))))

    with pytest.raises(EnvironmentFault, match=r"^full\.mcap: cannot be written: No space left on device$"):
        fill()
    assert twin.time < 300 * twin.period
    for log in logs:
        with pytest.raises(EnvironmentFault, match="could not be written before"):
            log.write(SensorFrame(1e3))
    with pytest.raises(EnvironmentFault, match="/dev/full: cannot be written"), write_log(Path("/dev/full"), HEAD):
        pass


def test_a_folder_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(EnvironmentFault, match="cannot be written"), write_log(tmp_path / "none" / "a.mcap", HEAD):
        pass


def test_kinds_are_left_out(tmp_path: Path) -> None:
    twin = machine()
    with write_log(tmp_path / "a.mcap", HEAD) as log:
        for _ in range(120):
            command = Command(twin.time, np.zeros(4))
            log.write(twin.step(command), command, twin.truth)
    with read_log(tmp_path / "a.mcap") as all_of_it, read_log(tmp_path / "a.mcap") as bare:
        for whole, some in zip(all_of_it.entries(), bare.entries(without={Scan, Truth}), strict=True):
            assert some.truth is None
            assert some.command is not None
            assert whole.truth is not None
            kept = [type(each) for each in whole.frame.readings if not isinstance(each, Scan)]
            assert [type(each) for each in some.frame.readings] == kept
    with read_log(tmp_path / "a.mcap") as log:
        seen = {
            reading.source
            for entry in log.entries(without={"/scan/north", "/frame"})
            for reading in entry.frame.of(Scan)
        }
        assert seen == {"south", "vertical"}
