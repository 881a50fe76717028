"""Compiled kernels: arrays in, arrays and a status code out. Nothing here knows a Robot.

All compilation in the package goes through `jit`; `cache` keeps compiled kernels on disk for later processes.
"""

from collections.abc import Callable
from typing import Any

import numba
from numba.core import config

from cablewright.kernels.cache import KernelCache, is_stamped
from cablewright.kernels.compiler import KernelCompiler, KernelDispatcher

__all__ = ["compile_for", "is_compiled", "jit", "prepared_count", "thread_count"]


def jit(
    function: Callable[..., Any] | None = None,
    *,
    allocates: bool = False,
    inline: bool = False,
) -> Any:
    """Compile *function* with the package's options, and cache it if it is one of the package's kernels.

    *allocates*: the kernel creates arrays. All others are compiled without reference counting, which would cost more
    per view of a row than the arithmetic on it. *inline*: the kernel is always made part of its callers. It is for
    short ones on views of arrays, of which a call copies each size and stride: LLVM sees that cost only in part.
    """
    if function is None:
        return lambda inner: jit(inner, allocates=allocates, inline=inline)
    if config.DISABLE_JIT:
        return function
    options: dict[str, Any] = {"nopython": True, "error_model": "numpy", "nogil": True, "boundscheck": None}
    options |= {"_nrt": allocates, "forceinline": inline, "no_cfunc_wrapper": True}
    dispatcher = KernelDispatcher(function, targetoptions=options, pipeline_class=KernelCompiler)
    if is_stamped(function):
        dispatcher._cache = KernelCache(function)
    return dispatcher


def is_compiled(function: Any, *arguments: Any) -> bool:
    """Whether *function*, made by `jit`, was compiled for the types of *arguments*, by this process or an earlier one.

    Kernels of earlier processes count if they are of the present sources.
    """
    if config.DISABLE_JIT:
        return True
    signature = tuple(map(numba.typeof, arguments))
    if signature in function.overloads and not function.is_only_part(signature):
        return True
    return isinstance(function._cache, KernelCache) and function._cache.holds(signature, function.targetctx.codegen())


def thread_count() -> int:
    """Number of threads for a batch: `NUMBA_NUM_THREADS`, by default one for each processor."""
    return int(config.NUMBA_NUM_THREADS)


def prepared_count() -> int:
    """Return how many kernels this process has compiled, or read: a step that waited for one is late for that."""
    return KernelCompiler.count


def compile_for(function: Any, *arguments: Any) -> None:
    """Compile *function*, made by `jit`, for the types of *arguments*, or load it from the disk cache."""
    if not config.DISABLE_JIT:
        function.compile(tuple(map(numba.typeof, arguments)))
