"""What every solver does with its arguments: shapes, finite numbers, serial or parallel kernels."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.errors import InputError
from cablewright.kernels import is_compiled

__all__ = ["as_rows", "run"]

log = logging.getLogger(__name__)

SERIAL_BELOW = 64
"""Rows under which one thread is faster than waking the others."""

_sweeping = threading.Lock()  # one of Numba's threading layers kills the process when two threads sweep at once


def as_rows(values: ArrayLike, width: int, what: str, unit: str) -> tuple[NDArray[np.float64], bool]:
    """*values* as a fresh (rows, width) array, and whether they were a single row.

    Raises `InputError` for a wrong count, text or numbers that are not finite.
    """
    try:
        array = np.array(values, dtype=np.float64, order="C")
    except (TypeError, ValueError) as reason:
        raise InputError(f"{what}: numbers in {unit} are wanted ({reason})") from None
    if array.ndim not in (1, 2) or array.shape[-1] != width:
        shape = " x ".join(map(str, array.shape)) or "a single number"
        raise InputError(f"{what}: {width} numbers are wanted, or rows of {width}; got {shape}")
    if not np.isfinite(array).all():
        raise InputError(f"{what}: every number must be finite; got {array[~np.isfinite(array)][0]}")
    return np.atleast_2d(array), array.ndim == 1


@cache
def _say_compiling() -> None:
    """Say, once a process, why this takes longer than it will the next time."""
    log.info("compiling kernels (once, up to a minute)")


def run(rows_kernel: Callable[..., None], sweep_kernel: Callable[..., None], rows: int, *arguments: Any) -> None:
    """Run the serial kernel on few rows, the parallel one on many."""
    serial = rows < SERIAL_BELOW
    if not is_compiled(rows_kernel if serial else sweep_kernel):
        _say_compiling()
    if serial:
        rows_kernel(*arguments, 0, rows)
        return
    with _sweeping:
        sweep_kernel(*arguments)
