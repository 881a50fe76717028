"""Compiled kernels: arrays in, arrays and a status out. Nothing here knows a Robot.

`jit` is the only spelling of compilation in the package; `cache` keeps what it compiled for later processes.
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

    A kernel that makes arrays says so with *allocates*. The others count no references: each view of a row
    would cost more than the arithmetic done on it.
    """
    if function is None:
        return lambda inner: jit(inner, parallel=parallel, allocates=allocates)
    options: dict[str, Any] = {"nopython": True, "error_model": "numpy", "parallel": parallel, "nogil": True}
    dispatcher = numba.jit(_nrt=allocates or parallel, **options)(function)
    if not config.DISABLE_JIT and is_stamped(function):
        dispatcher._cache = KernelCache(function)
    return dispatcher


def is_compiled(function: Any) -> bool:
    """Whether *function*, a product of `jit`, was compiled for these sources by this process or an earlier one."""
    if config.DISABLE_JIT or function.signatures:
        return True
    return isinstance(function._cache, KernelCache) and function._cache.holds_any()
