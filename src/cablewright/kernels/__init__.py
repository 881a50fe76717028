"""Compiled kernels: arrays in, arrays and a status out. Nothing here knows a Robot.

`jit` is the only spelling of compilation in the package. Numba's disk cache stamps a compiled function with
the file it stands in, so that after an edit of a *callee* in another file the cached caller would silently
return the old number. Here every cache entry is stamped with a hash of all files of this package instead.
"""

import hashlib
import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
from numba.core import config

__all__ = ["is_compiled", "jit", "prange"]

prange = numba.prange
log = logging.getLogger(__name__)


def _stamp() -> str:
    digest = hashlib.sha256(numba.__version__.encode())
    for file in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(file.name.encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()


STAMP = _stamp()


def jit(function: Callable[..., Any] | None = None, *, parallel: bool = False, allocates: bool = False) -> Any:
    """Compile *function* with the package's options and the package-wide cache stamp.

    A kernel that makes arrays says so with *allocates*. The others count no references: each view of a row
    would cost more than the arithmetic done on it.
    """
    if function is None:
        return lambda inner: jit(inner, parallel=parallel, allocates=allocates)
    options: dict[str, Any] = {"nopython": True, "error_model": "numpy", "parallel": parallel, "nogil": True}
    options["_nrt"] = allocates or parallel
    try:
        dispatcher = numba.jit(cache=True, **options)(function)
    except RuntimeError as reason:  # numba found no folder that it may write its cache to
        log.warning("kernels are compiled anew in each process: %s", reason)
        return numba.jit(**options)(function)
    if not config.DISABLE_JIT:
        dispatcher._cache._cache_file._source_stamp = STAMP
    return dispatcher


def is_compiled(function: Any) -> bool:
    """Whether *function*, a product of `jit`, was compiled for these sources by this process or an earlier one."""
    if config.DISABLE_JIT or function.signatures:
        return True
    return hasattr(function._cache, "_cache_file") and bool(function._cache._cache_file._load_index())
