"""Arrays that lie in files, so that memory need not hold all of them at once."""

from __future__ import annotations

import mmap
import os
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any, Final

import numpy as np
from numpy.typing import DTypeLike, NDArray

SMALL: Final = 1 << 18  # bytes, of an array that memory has room for


@dataclass(frozen=True)
class Room:
    """Room for arrays: in memory, or in files without a name in a *folder*, which go with their arrays."""

    folder: Path | None = None

    def empty(self, shape: tuple[int, ...], dtype: DTypeLike = np.float64) -> NDArray[Any]:
        """Return an array with room. Raises `OSError` where the disk has none, and never later.

        In memory without a folder, for a small array, and where a system cannot promise room in a file.
        """
        size = int(np.prod(shape)) * np.dtype(dtype).itemsize
        if self.folder is None or size < SMALL or not hasattr(os, "posix_fallocate"):
            return np.empty(shape, dtype)
        with TemporaryFile(dir=self.folder) as file:
            os.posix_fallocate(file.fileno(), 0, size)
            mapped = mmap.mmap(file.fileno(), size)
        return np.frombuffer(mapped, dtype).reshape(shape)


def let_go(values: Any) -> None:
    """Let memory drop what it holds of an array in a file, or of those in a dataclass; it is read again when used."""
    if isinstance(values, np.ndarray):
        base: Any = values
        while isinstance(base, np.ndarray | memoryview):
            base = base.base if isinstance(base, np.ndarray) else base.obj
        if isinstance(base, mmap.mmap) and hasattr(base, "madvise"):
            base.madvise(mmap.MADV_DONTNEED)
    elif is_dataclass(values):
        for each in fields(values):
            let_go(getattr(values, each.name))
