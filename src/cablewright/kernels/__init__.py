"""Compiled kernels: arrays in, arrays and a status code out. Nothing here knows a Robot.

All compilation in the package goes through `jit`; `cache` keeps compiled kernels on disk for later processes.
"""

from collections.abc import Callable
from typing import Any

import numba
from numba.core import config

from cablewright.kernels.cache import KernelCache, is_stamped

__all__ = ["is_compiled", "jit", "prange"]

prange = numba.prange


def jit(function: Callable[..., Any] | None = None, *, parallel: bool = False, allocates: bool = False) -> Any:
    """Compile *function* with the package's options, and cache it if it is one of the package's kernels.

    *allocates*: the kernel creates arrays. All others are compiled without reference counting, which would cost more
    per view of a row than the arithmetic on it.
    """
    if function is None:
        return lambda inner: jit(inner, parallel=parallel, allocates=allocates)
    options: dict[str, Any] = {"nopython": True, "error_model": "numpy", "parallel": parallel, "nogil": True}
    dispatcher = numba.jit(_nrt=allocates or parallel, **options)(function)
    if not config.DISABLE_JIT and is_stamped(function):
        dispatcher._cache = KernelCache(function)
    return dispatcher


def is_compiled(function: Any) -> bool:
    """Whether *function*, made by `jit`, was compiled from the present sources by this process or an earlier one."""
    if config.DISABLE_JIT or function.signatures:
        return True
    return isinstance(function._cache, KernelCache) and function._cache.holds_any()
