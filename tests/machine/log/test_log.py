"""A log returns its written signals to the bit; a cut or damaged one up to the damage, which it reports."""

from __future__ import annotations

import dataclasses
import json
import struct
import tracemalloc
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import lz4.frame
import numpy as np
import pytest
import zstandard
from jsonschema import Draft202012Validator
from mcap.reader import make_reader
from mcap.records import Chunk
from mcap.stream_reader import CRCValidationError
from mcap.writer import CompressionType, Writer

from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import (
    Command,
    Condition,
    Encoders,
    Estimate,
    Fault,
    Notice,
    PrintState,
    Progress,
    Scan,
    SensorFrame,
    frozen,
)
from cablewright.machine.log import mcap_file as logs
from cablewright.machine.log.log import Entry, LogWriter, read_log
from cablewright.machine.log.messages import decode, encode
from cablewright.machine.log.topics import TOPICS
from twins import head, machine

SPEEDS = np.array([0.4, -0.3, 0.1, -0.2])


def write(path: Path, steps: int = 150, plant: Any = "dynamic") -> list[Entry]:
    """A log at *path*, and its entries."""
    twin, entries = machine(plant=plant), []
    with path.open("wb") as file, LogWriter(file, head(plant=plant)) as log:
        for _ in range(steps):
            command = Command(twin.time, SPEEDS, 0.5)
            frame = twin.step(command)
            entry = Entry(frame, command, twin.truth, *beside(twin.time))
            log.write(entry.frame, entry.command, entry.truth, entry.estimate, entry.progress)
            entries.append(entry)
    return entries


def beside(time: float) -> tuple[Estimate, Progress]:
    """An estimate of a user's own estimator, with a value of each kind."""
    some, line = frozen([0.1, np.nan, time]), frozen(SPEEDS)
    covariance = frozen(time * np.eye(9)) if time > 0.5 else None
    fault = Fault("north", 0.25, "it is dark")
    estimate = Estimate(
        time, some, some, some, line, line, SPEEDS > 0.0, line, covariance, (fault,), time < 0.7, np.nan
    )
    return estimate, Progress(time, PrintState.PAUSED, 3, 1e3 * time, frozen([1.0, 2.0, 3.0]), np.nan, "a test")


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Entry]]:
    path = tmp_path_factory.mktemp("log") / "run.mcap"
    return path, write(path)


def read(path: Path) -> tuple[list[Entry], list[str]]:
    with read_log(path) as log:
        return list(log.entries()), log.notes


def same(a: Any, b: Any) -> bool:
    """Whether two signals are equal to the bit."""
    if dataclasses.is_dataclass(a):
        return type(a) is type(b) and all(
            same(getattr(a, each.name), getattr(b, each.name)) for each in dataclasses.fields(a)
        )
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and np.array_equal(a, b, equal_nan=a.dtype.kind == "f")
    if isinstance(a, tuple):
        return len(a) == len(b) and all(map(same, a, b))
    return a == b or (a != a and b != b)


def test_written_signals_are_read_back(written: tuple[Path, list[Entry]]) -> None:
    path, entries = written
    found, notes = read(path)
    assert notes == []
    assert len(found) == len(entries)
    assert all(map(same, found, entries))


def test_other_readers_find_schemas_and_messages(written: tuple[Path, list[Entry]]) -> None:
    """By mcap's own indexed reader; every message fits its JSON schema."""
    path, entries = written
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        names = {channel.topic: summary.schemas[channel.schema_id].name for channel in summary.channels.values()}
        assert names["/scan/north"] == "foxglove.LaserScan"
        assert names["/imu"] == "sensor_msgs/Imu"
        assert names["/encoders"] == "sensor_msgs/JointState"
        assert {"/tf", "/scene"} < set(names) <= {topic.topic for topic in TOPICS} | {"/tf", "/scene"}
        counts = summary.statistics.channel_message_counts
        assert all(counts[number] > 0 for number in summary.channels)  # no topic is empty
        seen, validators = 0, dict[int, Draft202012Validator]()
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            assert schema is not None
            assert channel.message_encoding == "json"
            content = json.loads(schema.data)
            values = json.loads(message.data, parse_constant=lambda text: pytest.fail(f"{text} is not valid JSON"))
            validators.setdefault(schema.id, Draft202012Validator(content)).validate(values)
            left_out = {
                "/command": {"modes", "tensions", "outputs"},
                "/estimate": {"consistency"},
                "/truth": {"retraction"},
                "/progress": {"tensions"},
            }.get(channel.topic, set())
            assert set(values) == set(content["properties"]) - left_out
            seen += channel.topic not in ("/tf", "/scene")
    assert seen == sum(len(entry.frame.readings) + 5 for entry in entries)


def test_a_cut_log_is_read_up_to_there(written: tuple[Path, list[Entry]], tmp_path: Path) -> None:
    path, entries = written
    whole = path.read_bytes()
    lengths = []
    for share in (0.999, 0.9, 0.7, 0.5, 0.35):
        cut = tmp_path / "cut.mcap"
        cut.write_bytes(whole[: int(share * len(whole))])
        found, notes = read(cut)
        assert len(notes) <= 2
        assert notes[0].startswith("cut or damaged before byte")
        assert all(map(same, found, entries))
        lengths.append(len(found))
    assert lengths == sorted(lengths, reverse=True)
    assert lengths[0] == len(entries)
    assert 0 < lengths[2] < len(entries)


def test_a_log_whose_writer_died_is_read_up_to_its_last_chunk(tmp_path: Path) -> None:
    """As a crash leaves it: no footer, nothing of unwritten messages."""
    path, twin = tmp_path / "died.mcap", machine(plant="quasi-static")
    with path.open("wb") as file:
        log = LogWriter(file, head(plant="quasi-static"))
        for _ in range(200):
            log.write(twin.step(Command(twin.time, SPEEDS)), None, twin.truth)
    found, notes = read(path)
    assert 50 < len(found) < 200
    assert "cut or damaged" in notes[0]
    assert found[0].command is None


def test_damage_is_found_by_its_checksum(written: tuple[Path, list[Entry]], tmp_path: Path) -> None:
    path, entries = written
    damaged = bytearray(path.read_bytes())
    damaged[int(0.6 * len(damaged))] ^= 0x10
    (tmp_path / "damaged.mcap").write_bytes(damaged)
    found, notes = read(tmp_path / "damaged.mcap")
    assert len(found) < len(entries)
    assert "cut or damaged" in notes[0]


def frames(path: Path, times: list[float]) -> None:
    with path.open("wb") as file, LogWriter(file, head()) as log:
        for time in times:
            log.write(SensorFrame(time, ()))


def test_a_clock_that_jumps_back_is_named(tmp_path: Path) -> None:
    frames(tmp_path / "a.mcap", [0.01, 0.02, 0.03, 0.015, 0.02, 0.04, 0.05])
    found, notes = read(tmp_path / "a.mcap")
    assert [entry.frame.time for entry in found] == [0.01, 0.02, 0.03, 0.04, 0.05]
    assert notes == ["the clock jumps back from 0.03 to 0.015 s: frames left out"]
    assert found[3].frame.notices == (Notice(Condition.CLOCK_BACK),)
    assert found[4].frame.notices == ()


@pytest.mark.parametrize(
    ("topic", "data", "says"),
    [
        ("/imu", b"{", "a message of /imu is not valid JSON"),
        ("/imu", b"[]", "/imu: an object is expected"),
        ("/imu", b"[" * 100_000, "not valid JSON"),
        ("/imu", b'{"time": 1, "linear_acceleration": {"x": 1, "y": 2}}', "linear_acceleration: z: a finite number"),
        ("/encoders", b'{"time": 1, "counts": [1.5]}', "counts: a list of whole numbers"),
        ("/encoders", b'{"time": 1, "counts": [1' + b"0" * 40 + b"]}", "counts: a list of whole numbers"),
        ("/scan/north", b'{"time": 1, "ranges": [true]}', "ranges: a list of numbers"),
        ("/line_angles", b'{"time": NaN, "angles": [null]}', "time: a finite number"),
        ("/line_angles", b'{"time": 1, "angles": [NaN]}', "angles: a list of numbers or null"),
        ("/line_angles", b'{"time": 1, "angles": [null, Infinity]}', "angles: a list of numbers or null"),
        ("/line_angles", b'{"time": 1, "angles": [1' + b"0" * 400 + b"]}", "angles: a list of numbers or null"),
        ("/command", b'{"time": 1, "winch_speeds": [null], "valve": 0}', "winch_speeds: a list of numbers"),
        ("/truth", b'{"time": 1, "position": [1, 2]}', "a message of /truth"),
        ("/frame", b'{"time": 1, "notices": [{"condition": "LOUD"}]}', "unknown condition 'LOUD'"),
        ("/frame", b'{"time": 1}', "notices: a list of notices is expected"),
        ("/barrier", b'{"time": 1, "broken": 0}', "broken: true or false is expected"),
        ("/progress", b'{"time": 1, "state": "dancing", "target": []}', "unknown state 'dancing'"),
    ],
)
def test_a_message_that_is_none_is_named(topic: str, data: bytes, says: str) -> None:
    with pytest.raises(InputError, match=r"a\.mcap") as refused:
        decode(topic, data, "a.mcap")
    assert says in str(refused.value)


def test_topics_of_others_are_left_alone() -> None:
    assert decode("/camera", b"\0\1", "a.mcap") is None


def empty(path: Path, metadata: dict[str, str] | None) -> None:
    with path.open("wb") as file:
        writer = Writer(file, compression=CompressionType.NONE)
        writer.start()
        if metadata is not None:
            writer.add_metadata("cablewright", metadata)
        writer.finish()


def test_what_is_no_log_is_rejected(tmp_path: Path, written: tuple[Path, list[Entry]]) -> None:
    path = tmp_path / "a.mcap"
    for content in (b"", b"hello", written[0].read_bytes()[:300], bytes(500)):
        path.write_bytes(content)
        with pytest.raises(InputError, match="is not a log of a machine"):
            read_log(path)
    empty(path, None)
    with pytest.raises(InputError, match="is not a log of a machine"):
        read_log(path)
    for metadata, says in (
        ({"schema": "3"}, "schema 3"),
        ({"schema": "x"}, "not valid JSON"),
        ({"schema": "1", "robot": "{}"}, "the head's"),
    ):
        empty(path, metadata)
        with pytest.raises(InputError, match=says):
            read_log(path)
    with pytest.raises(InputError, match="no such file"):
        read_log(tmp_path / "b.mcap")
    with pytest.raises(InputError, match="not a regular file"):
        read_log("/dev/null")
    with pytest.raises(InputError, match="no log in this folder"):
        read_log(tmp_path)


def test_a_chunk_that_unpacks_to_too_much_is_rejected(
    written: tuple[Path, list[Entry]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(logs, "MAX_RECORD", 100_000)
    with read_log(written[0]) as log, pytest.raises(InputError, match="at most 100000 are read"):
        list(log.entries())


@pytest.mark.parametrize("grain", [0.25e-3, 1e-3, 1e-5, 0.5, 1e-12])
@pytest.mark.parametrize("longest", [1.0, 12.0, 99.99, 150.0, 1e6])
def test_ranges_of_any_grain_come_out_again(grain: float, longest: float) -> None:
    """Those that tables write, and all others."""
    random = np.random.default_rng(5)
    ranges = np.maximum(np.round(random.uniform(0.0, longest, 721) / grain), 1.0) / (1.0 / grain)
    ranges[random.random(721) < 0.3] = np.nan
    scan = Scan("north", 1.0, 1e-3, -3.0, 0.01, frozen(ranges))
    topic, data = encode(scan, (), 1)
    assert same(decode(topic, data, "a.mcap"), scan)
    decoded = json.loads(data)["ranges"]
    np.testing.assert_array_equal(decoded, np.nan_to_num(ranges))


def chunk_of(compression: str, data: bytes, size: int, check: int = 0) -> Chunk:
    return Chunk(
        compression=compression,
        data=data,
        message_start_time=0,
        message_end_time=0,
        uncompressed_crc=check,
        uncompressed_size=size,
    )


@pytest.mark.parametrize(
    ("compression", "pack"), [("zstd", zstandard.compress), ("lz4", lz4.frame.compress), ("", lambda data: data)]
)
def test_a_chunk_is_unpacked_as_far_as_it_declares(compression: str, pack: Callable[[bytes], bytes]) -> None:
    data = b"abc" * 1000
    packed = pack(data)
    assert logs.unpacked(chunk_of(compression, packed, len(data), zlib.crc32(data))) == data
    for size in (len(data) - 1, len(data) + 1, 0):
        with pytest.raises(struct.error):
            logs.unpacked(chunk_of(compression, packed, size))
    with pytest.raises(CRCValidationError):
        logs.unpacked(chunk_of(compression, packed, len(data), 1))


@pytest.mark.parametrize(("compression", "pack"), [("zstd", zstandard.compress), ("lz4", lz4.frame.compress)])
def test_a_bomb_costs_no_more_than_it_declares(compression: str, pack: Callable[[bytes], bytes]) -> None:
    """A frame of a gigabyte in a chunk that declares a kilobyte, as frames say their own size and lz4 has no limit."""
    bomb = pack(bytes(1 << 30))
    tracemalloc.start()
    try:
        with pytest.raises(struct.error, match="another size"):
            logs.unpacked(chunk_of(compression, bomb, 1000))
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert most < 64 << 20


@pytest.mark.parametrize("data", [b"", b"\0", b"no frame", bytes(1000)])
@pytest.mark.parametrize("compression", ["zstd", "lz4", "gzip", "\x1b[31m"])
def test_packed_data_that_is_none_is_damage(compression: str, data: bytes) -> None:
    with pytest.raises(logs.BROKEN):
        logs.unpacked(chunk_of(compression, data, 10))


@pytest.mark.parametrize("signal", [Command(0.0, frozen([1.0, 2.0])), Encoders(0.0, np.arange(3, dtype=np.int64))])
def test_numbers_of_another_count_of_lines_are_rejected(signal: Any, tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    readings = (signal,) if isinstance(signal, Encoders) else ()
    with path.open("wb") as file, LogWriter(file, head()) as log:
        log.write(SensorFrame(0.01, readings), signal if isinstance(signal, Command) else None, None, None, None)
    with pytest.raises(InputError, match="numbers; the robot of the log has 4 lines"):
        read(path)
