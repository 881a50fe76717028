"""Memory-mapped arrays: values are in files, and memory holds only the rows in use."""

from __future__ import annotations

import mmap
import os
from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass, replace
from pathlib import Path
from tempfile import TemporaryFile
from typing import TYPE_CHECKING, Any, Final, TypeVar

import numpy as np
from numpy.typing import DTypeLike, NDArray

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

_Arrays = TypeVar("_Arrays", bound="DataclassInstance")

SMALL: Final = 1 << 18  # bytes, of an array that memory has room for
BLOCK: Final = 1 << 16  # rows of large arrays that are worked on at a time
_TAKEN: Final = 1 << 13  # rows that are taken at a time: those between them are read too


@dataclass(frozen=True)
class Room:
    """Storage for arrays: memory, or unnamed files in a *folder*, which are removed with their arrays."""

    folder: Path | None = None

    def empty(self, shape: tuple[int, ...], dtype: DTypeLike = np.float64) -> NDArray[Any]:
        """Return an empty array in this storage. Raises `OSError` where the disk has no space, and never later.

        In memory without a folder, for a small array, and where a system cannot promise space in a file.
        """
        size = int(np.prod(shape)) * np.dtype(dtype).itemsize
        if self.folder is None or size < SMALL or not hasattr(os, "posix_fallocate"):
            return np.empty(shape, dtype)
        with TemporaryFile(dir=self.folder) as file:
            os.posix_fallocate(file.fileno(), 0, size)
            mapped = mmap.mmap(file.fileno(), size)
        return np.frombuffer(mapped, dtype).reshape(shape)


MEMORY: Final = Room()
"""Room in memory."""


def blocks(rows: int, size: int | None = None) -> Iterator[slice]:
    """Yield slices of *rows* rows, in order, each of *size* rows at most, by default `BLOCK`."""
    size = size or BLOCK
    for first in range(0, rows, size):
        yield slice(first, min(first + size, rows))


def taken(values: NDArray[Any] | RowExtremes, rows: NDArray[np.integer[Any]]) -> NDArray[Any]:
    """Return the *rows* (r,), rising, of a large array (k, ...), read some at a time."""
    found = np.empty((len(rows), *values.shape[1:]), values.dtype)
    for at in blocks(len(rows), _TAKEN):
        found[at] = values[rows[at]]
        let_go(values)
    return found


@dataclass(frozen=True, eq=False)
class RowExtremes:
    """The smallest or largest of each row (k,) of *values* (k, m), computed on first use."""

    choose: np.ufunc
    values: NDArray[np.float64]

    @property
    def shape(self) -> tuple[int]:
        """Shape (k,) of the row minima or maxima."""
        return (len(self.values),)

    @property
    def dtype(self) -> np.dtype[np.float64]:
        """Type of the numbers of the row minima or maxima."""
        return self.values.dtype

    def __len__(self) -> int:
        """How many rows there are."""
        return len(self.values)

    def __getitem__(self, rows: Any) -> NDArray[np.float64]:
        """Those of some rows."""
        found: NDArray[np.float64] = self.choose.reduce(self.values[rows], axis=-1)
        return found


def of_rows(choose: np.ufunc, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the smallest or largest value in each row (k,) of *values* (k, m), by ``np.minimum`` or ``np.maximum``."""
    found = np.empty(len(values))
    for at in blocks(len(values)):
        found[at] = choose.reduce(values[at], axis=1)
        let_go(values)
    return found


def room_for(block: Any, rows: int, room: Room) -> Any:
    """Return empty arrays for *rows* rows of the kind of a *block*: an array, or a dataclass of arrays."""
    if isinstance(block, np.ndarray):
        return room.empty((rows, *block.shape[1:]), block.dtype)
    return type(block)(*(room_for(getattr(block, each.name), rows, room) for each in fields(block)))


def write_rows(block: Any, into: Any, first: int) -> None:
    """Write the rows of a *block* into the arrays of `room_for`, from the row *first* on."""
    if isinstance(block, np.ndarray):
        into[first : first + len(block)] = block
        return
    for each in fields(block):
        write_rows(getattr(block, each.name), getattr(into, each.name), first)


def in_room(values: _Arrays, room: Room) -> _Arrays:
    """Return a dataclass with *values*' arrays copied, read-only, to the storage *room*; itself if that is memory."""
    if room.folder is None:
        return values
    return replace(values, **{each.name: _moved(getattr(values, each.name), room) for each in fields(values)})


def _moved(value: Any, room: Room) -> Any:
    if not isinstance(value, np.ndarray):
        return value
    moved = room.empty(value.shape, value.dtype)
    moved[:] = value
    moved.setflags(write=False)
    let_go(moved)
    return moved


def let_go(values: Any) -> None:
    """Free the memory of a memory-mapped array, or of those in a dataclass or tuple; the next access reads the file."""
    if isinstance(values, np.ndarray):
        base: Any = values
        while isinstance(base, np.ndarray | memoryview):
            base = base.base if isinstance(base, np.ndarray) else base.obj
        if isinstance(base, mmap.mmap) and hasattr(base, "madvise"):
            base.madvise(mmap.MADV_DONTNEED)
    elif isinstance(values, tuple):
        for each in values:
            let_go(each)
    elif is_dataclass(values):
        for each in fields(values):
            let_go(getattr(values, each.name))
