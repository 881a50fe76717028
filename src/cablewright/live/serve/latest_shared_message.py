"""Shared memory of two processes that holds the latest message only: the writer never waits for a reader."""

from __future__ import annotations

import mmap
import os
import struct
import tempfile
import zlib
from typing import Final

_HEAD: Final = struct.Struct("=Q")  # number of the latest message; 0: none
_SLOT: Final = struct.Struct("=QII")  # number, length, checksum
_TRIES: Final = 4


class Latest:
    """Two memory slots, written in turn, so that the latest whole message can be read while the next is written."""

    def __init__(self, number: int, size: int) -> None:
        """On the file *number* that `shared` made, for messages of at most *size* bytes."""
        self.file_number, self._size = number, size
        self._memory = mmap.mmap(number, _HEAD.size + 2 * (_SLOT.size + size))
        self._written = 0

    def write(self, message: bytes) -> bool:
        """Replace the shared message; return whether the new one fits."""
        if len(message) > self._size:
            return False
        self._written += 1
        begin = self._slot(self._written)
        body = begin + _SLOT.size
        _SLOT.pack_into(self._memory, begin, 0, 0, 0)  # whoever reads meanwhile finds nothing
        self._memory[body : body + len(message)] = message
        _SLOT.pack_into(self._memory, begin, self._written, len(message), zlib.crc32(message))
        _HEAD.pack_into(self._memory, 0, self._written)
        return True

    def read(self) -> tuple[int, bytes]:
        """Return number, from 1 on, and bytes of the latest shared message; 0 and nothing if there is none."""
        for _ in range(_TRIES):
            (latest,) = _HEAD.unpack_from(self._memory, 0)
            if not latest:
                break
            begin = self._slot(latest)
            number, length, checksum = _SLOT.unpack_from(self._memory, begin)
            if number != latest or length > self._size:
                continue
            message = self._memory[begin + _SLOT.size : begin + _SLOT.size + length]
            if zlib.crc32(message) == checksum:
                return latest, message
        return 0, b""

    def close(self) -> None:
        """Free the shared memory of the message."""
        self._memory.close()
        os.close(self.file_number)

    def _slot(self, number: int) -> int:
        return _HEAD.size + (number % 2) * (_SLOT.size + self._size)


def shared(size: int) -> Latest:
    """Return new shared memory for messages of at most *size* bytes, on an unnamed file that a child can inherit."""
    if hasattr(os, "memfd_create"):
        number = os.memfd_create("cablewright")
    else:
        with tempfile.TemporaryFile() as file:
            number = os.dup(file.fileno())
    os.ftruncate(number, _HEAD.size + 2 * (_SLOT.size + size))
    return Latest(number, size)
