"""Arrays in files: the same numbers, space that is reserved or rejected before the work, and nothing left behind."""

from __future__ import annotations

import errno
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from cablewright.foundation import memory_mapped
from cablewright.foundation.arrays import Array
from cablewright.foundation.memory_mapped import Room, blocks, in_room, let_go, taken

SHAPE = (1 << 14, 4)
in_files = pytest.mark.skipif(not hasattr(os, "posix_fallocate"), reason="no promise of room in a file")


@dataclass(frozen=True)
class Pair:
    one: Array
    other: Array


def resident() -> int:
    """Bytes of files that this process has in memory."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(1024 * int(line.split()[1]) for line in lines if line.startswith("RssFile"))


@in_files
def test_an_array_in_a_file_keeps_its_numbers_and_leaves_memory(tmp_path: Path) -> None:
    room = Room(tmp_path)
    pair = Pair(room.empty((1 << 20, 4)), room.empty(SHAPE, np.int64))
    wanted = np.arange(pair.one.size, dtype=float).reshape(pair.one.shape)
    pair.one[:], pair.other[:] = wanted, 7
    before = resident() if Path("/proc/self/status").exists() else None
    let_go(pair)
    if before is not None:
        assert resident() < before - 0.9 * pair.one.nbytes
    assert np.array_equal(pair.one, wanted)
    assert (pair.other == 7).all()
    let_go(pair.one[5:, 1])
    assert np.array_equal(pair.one, wanted)
    assert not list(tmp_path.iterdir())


@in_files
def test_a_disk_without_room_is_an_error_before_anything_is_written(tmp_path: Path, monkeypatch) -> None:
    def full(*_arguments: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(memory_mapped.os, "posix_fallocate", full)
    with pytest.raises(OSError, match="No space"):
        Room(tmp_path).empty(SHAPE)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("room", [Room(), Room(Path("nowhere"))])
def test_a_small_array_and_one_without_a_folder_are_in_memory(room: Room) -> None:
    shape = (3, 4) if room.folder else SHAPE
    values = room.empty(shape)
    values[:] = 1.0
    let_go(values)
    assert (values == 1.0).all()


@pytest.mark.parametrize("folder", [False, pytest.param(True, marks=in_files)])
def test_rows_that_are_taken_are_those_rows(folder: bool, tmp_path: Path) -> None:
    values = Room(tmp_path if folder else None).empty((1 << 16, 3))
    values[:] = np.random.default_rng(5).normal(size=values.shape)
    rows = np.flatnonzero(np.random.default_rng(6).random(len(values)) < 0.4)
    assert np.array_equal(taken(values, rows), values[rows])
    assert np.array_equal(taken(values[:, 1], rows), values[rows, 1])
    assert taken(values, rows[:0]).shape == (0, 3)


@in_files
def test_a_dataclass_moves_into_a_room_as_it_is(tmp_path: Path) -> None:
    pair = Pair(np.arange(1 << 16, dtype=float), np.zeros((0, 2)))
    moved = in_room(pair, Room(tmp_path))
    assert np.array_equal(moved.one, pair.one)
    assert moved.other.shape == (0, 2)
    assert moved.one is not pair.one
    assert not moved.one.flags.writeable
    assert in_room(pair, Room()) is pair


@pytest.mark.parametrize(("rows", "size", "wanted"), [(0, 3, []), (3, 3, [(0, 3)]), (7, 3, [(0, 3), (3, 6), (6, 7)])])
def test_blocks_cover_all_rows_once(rows: int, size: int, wanted: list[tuple[int, int]]) -> None:
    assert [(at.start, at.stop) for at in blocks(rows, size)] == wanted
