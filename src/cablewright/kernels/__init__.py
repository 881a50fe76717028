"""Compiled kernels: functions of arrays that return arrays and a status code, compiled by Numba.

No kernel takes a Robot: its callers pack it into arrays. All compilation in the package goes through `jit`; `cache`
keeps compiled kernels on disk for later processes.
"""

from collections.abc import Callable
from typing import Any

import numba
from numba.core import config

from cablewright.kernels.cache import KernelCache, is_stamped
from cablewright.kernels.compiler import KernelCompiler, KernelDispatcher

__all__ = ["Direct", "compile_for", "is_compiled", "jit", "prepared_count", "thread_count"]


def jit(
    function: Callable[..., Any] | None = None,
    *,
    allocates: bool = False,
    inline: bool = False,
) -> Any:
    """Compile *function* by Numba with the package's options; cache it on disk if it is one of the package's kernels.

    *allocates*: the kernel creates arrays. All others are compiled without reference counting, which would cost more
    per view of a row than the arithmetic on it. *inline*: the kernel is always inlined in its callers. Use it for short
    kernels on views of arrays: a call copies each size and stride, a cost that LLVM underestimates.
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


class Direct:
    """A kernel that a loop of control calls again and again, with arguments of the same types each time.

    A call saves what finding the compiled code for these types takes: 2 us where arrays are in tuples. The types are
    those of the first call; arrays are contiguous ones of the caller's own. Kernels do not check that.
    """

    def __init__(self, kernel: Any) -> None:
        """Take a *kernel* made by `jit`, not called before."""
        self._kernel = kernel
        self.call: Callable[..., Any] = kernel if config.DISABLE_JIT else self._first

    def __deepcopy__(self, memo: dict[int, Any]) -> "Direct":
        return Direct(self._kernel)

    def _first(self, *arguments: Any) -> Any:
        types = tuple(map(numba.typeof, arguments))
        self._kernel.compile(types)
        self.call = self._kernel.overloads[types].entry_point
        return self.call(*arguments)


def is_compiled(function: Any, *arguments: Any) -> bool:
    """Return whether *function*, made by `jit`, is compiled for the types of *arguments*, here or in the disk cache.

    Kernels of earlier processes count if their sources have not changed since.
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
    """Return how many kernels this process has compiled, or loaded from disk.

    A control step during which the number grows has waited for that.
    """
    return KernelCompiler.count


def compile_for(function: Any, *arguments: Any) -> None:
    """Compile *function*, made by `jit`, for the types of *arguments*, or load it from the disk cache."""
    if not config.DISABLE_JIT:
        function.compile(tuple(map(numba.typeof, arguments)))
