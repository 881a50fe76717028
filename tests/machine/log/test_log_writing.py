"""How a log is written: the bytes of mcap's own writer, in a thread, thinned, and on a disk that is too slow."""

from __future__ import annotations

import errno
import io
import threading
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zstandard
from mcap.writer import CompressionType, IndexType, Writer

from cablewright.foundation.errors import EnvironmentFault
from cablewright.foundation.signals import (
    Climate,
    Condition,
    Order,
    OrderKind,
    PrintState,
    Progress,
    Scan,
    SensorFrame,
)
from cablewright.live.prints.snapshot_writer import SnapshotWriter
from cablewright.machine.log import disk_thread
from cablewright.machine.log.log import SCHEMAS, LogWriter, read_log, write_log
from cablewright.machine.log.mcap_file import HEAD
from cablewright.machine.log.mcap_writer import McapWriter
from twins import head


def test_bytes_are_those_of_mcaps_own_writer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mcap.writer.zstandard.compress", zstandard.ZstdCompressor(level=1).compress)
    rng, topics = np.random.default_rng(1), ("/frame", "/imu", "/truth", "/scene")
    own, theirs = io.BytesIO(), io.BytesIO()
    writer = McapWriter(own, {"key": "text"}, SCHEMAS, 2000)
    other = Writer(theirs, chunk_size=2000, compression=CompressionType.ZSTD, index_types=IndexType.ALL)
    other.start(profile="", library="cablewright")
    other.add_metadata(HEAD, {"key": "text"})
    numbers: dict[str, int] = {}
    for k in range(300):
        topic, data = topics[rng.integers(1 + k // 80)], rng.bytes(rng.integers(200))
        if topic not in numbers:
            name, content = SCHEMAS[topic]
            made = McapWriter(io.BytesIO(), {}, {topic: (name, content)}, 1)
            made.add(topic, 0, 0, b"")
            schema = other.register_schema(name, "jsonschema", made._described[topic].data)
            numbers[topic] = other.register_channel(topic, "json", schema)
        times = 1000 * k + int(rng.integers(5000)), 7 * k
        writer.add(topic, *times, data)
        other.add_message(numbers[topic], times[0], data, times[1])
        if k % 100 == 50:
            writer.flush()
            other.flush()
    writer.end_chunk()
    writer.finish()
    other.finish()
    assert own.getvalue() == theirs.getvalue()


def frame(k: int, *readings: Any) -> SensorFrame:
    return SensorFrame(0.01 * k, (Climate(0.01 * k, float(k), 0.5), *readings))


def test_a_log_in_a_thread_has_the_same_bytes(tmp_path: Path) -> None:
    for name, threaded in (("a.mcap", False), ("b.mcap", True)):
        with write_log(tmp_path / name, head(), flush_every=None, threaded=threaded) as log:
            for k in range(1, 3000):
                log.write(frame(k))
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()


class SlowDisk(io.BytesIO):
    """A disk that takes nothing until it is released, but for what comes first."""

    name = "slow.mcap"

    def __init__(self) -> None:
        super().__init__()
        self.free = threading.Event()
        self.writes = 0

    def write(self, data: Any) -> int:
        self.writes += 1
        if self.writes > 2:
            assert self.free.wait(10.0)
        return super().write(data)


def test_a_disk_slower_than_the_loop_drops_steps_and_says_how_many(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(disk_thread, "MAX_WAITING", 4)
    disk = SlowDisk()
    with LogWriter(disk, head(), flush_every=0.01, threaded=True, drops=True) as log:
        for k in range(1, 21):
            log.write(frame(k))  # no step waits for the disk
        dropped = log.dropped
        disk.free.set()
        assert log._disk is not None
        log._disk.wait()
        log.write(frame(21))
        log.write(frame(22))
    assert 0 < dropped < 20
    (tmp_path / "a.mcap").write_bytes(disk.getvalue())
    with read_log(tmp_path / "a.mcap") as read:
        entries = list(read.entries())
        assert read.notes == ["steps are left out in 1 places: the disk was slower than the log"]
    assert [round(each.frame.time / 0.01) for each in entries] == [*range(1, 21 - dropped), 21, 22]
    notices = {each.frame.time: each.frame.notices for each in entries if each.frame.notices}
    assert [(each.condition, each.subject) for each in notices[0.21]] == [(Condition.LOG_BEHIND, f"{dropped} steps")]


def test_a_disk_that_stays_behind_to_the_end_still_gets_the_last_step(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(disk_thread, "MAX_WAITING", 4)
    disk = SlowDisk()
    with LogWriter(disk, head(), flush_every=0.01, threaded=True, drops=True) as log:
        for k in range(1, 21):
            log.write(frame(k))
        disk.free.set()
    (tmp_path / "a.mcap").write_bytes(disk.getvalue())
    with read_log(tmp_path / "a.mcap") as read:
        entries = list(read.entries())
    last = entries[-1].frame
    assert round(last.time / 0.01) == 20
    assert len(entries) + log.dropped == 20
    assert last.notices[0].subject == f"{log.dropped} steps"


def test_a_full_disk_ends_a_log_in_a_thread() -> None:
    def fill() -> None:
        with write_log(Path("/dev/full"), head(), threaded=True, drops=True) as log:
            for k in range(1, 100_000):
                log.write(frame(k))

    with pytest.raises(EnvironmentFault, match="/dev/full: cannot be written: No space left on device"):
        fill()


class FullDisk(io.BytesIO):
    """A disk that is full after the first bytes of a log."""

    name = "full.mcap"

    def write(self, data: Any) -> int:
        if self.tell() > 1000:
            raise OSError(errno.ENOSPC, "No space left on device")
        return super().write(data)


def test_no_checkpoint_is_written_whose_log_the_disk_could_not_write(tmp_path: Path) -> None:
    path = tmp_path / "checkpoint.bin"

    def fill() -> None:
        with LogWriter(FullDisk(), head(), flush_every=None, threaded=True, drops=True) as log:
            log.write(frame(1))
            with SnapshotWriter(path) as writer:
                writer.put({}, after=log.flush())

    with pytest.raises(EnvironmentFault, match=r"full\.mcap: cannot be written: No space left on device"):
        fill()
    assert not path.exists()


def scan(k: int) -> Scan:
    return Scan("north", 0.01 * k, 1e-4, 0.0, 0.1, np.array([1.0, 2.0]))


def test_a_thinned_log_keeps_scans_last_readings_orders_and_new_states(tmp_path: Path) -> None:
    path, states = tmp_path / "a.mcap", {30: PrintState.READY}
    state = PrintState.IDLE
    with write_log(path, replace(head(), every=10)) as log:
        for k in range(1, 58):
            state = states.get(k, state)
            progress = Progress(0.01 * k, state, 0, 0.0, np.zeros(3), 0.0, "")
            orders = (Order(OrderKind.START, "somebody", 0.01 * k),) if k == 44 else ()
            log.write(frame(k, *((scan(k),) if k % 4 == 0 else ())), progress=progress, orders=orders)
    with read_log(path) as read:
        assert read.head.every == 10
        entries = list(read.entries())
        assert read.notes == ["thinned to one of 10 steps: results are of these steps alone"]
    assert [round(each.frame.time / 0.01) for each in entries] == [1, 11, 21, 30, 40, 44, 54, 57]
    assert sum(len(each.frame.of(Scan)) for each in entries) == 14
    assert [each.temperature for entry in entries for each in entry.frame.of(Climate)] == [
        1,
        11,
        21,
        30,
        40,
        44,
        54,
        57,
    ]


def test_so_many_scans_that_no_step_could_hold_them_are_logged_before_the_next_step_is_due(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with write_log(path, replace(head(), every=10_000)) as log:
        for k in range(1, 1202):
            log.write(frame(k, scan(k)))
    with read_log(path) as read:
        entries = list(read.entries())
    assert [round(each.frame.time / 0.01) for each in entries] == [1, 501, 1001, 1201]
    assert sum(len(each.frame.of(Scan)) for each in entries) == 1201
