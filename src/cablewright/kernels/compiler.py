"""Compilation of kernels by Numba: an entry point is optimised and assembled together with all functions it calls.

Numba by itself does both for every function, and again for each of its callers. Here a function that another kernel
calls (a part) stays as LLVM code, not optimised, until the kernel that Python calls is complete.
`docs/decisions/0019-kernels-at-once.md` has the measurements, and lists the properties of Numba that this relies on.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import register_pass
from numba.core.environment import lookup_environment
from numba.core.registry import CPUDispatcher
from numba.core.sigutils import normalize_signature
from numba.core.typed_passes import NativeLowering

from cablewright.kernels.resolved_calls import remember

_COLLECT = 20_000  # new objects of a compilation between two garbage collections: a tenth less time, no more memory
_ENVIRONMENT = "_ZN08NumbaEnv"  # prefix of Numba's symbols for raising errors


remember()


class Part:
    """Placeholder for the entry point of a function that only kernels call."""


class KernelLibrary(JITCodeLibrary):  # type: ignore[misc]
    """LLVM code of one function before optimisation, and the libraries of the functions that it calls."""

    is_part = False
    _shared_module: Any

    def add_linking_library(self, library: Any) -> None:
        """Add a library that the function calls; a part stays without optimisation."""
        if _is_part(library):
            self._linking_libraries.append(library)
        else:
            super().add_linking_library(library)

    def finalize(self) -> None:
        """Optimise and assemble the function with all functions that it calls."""
        self._linking_libraries = _callees(self)
        super().finalize()
        for variable in self._final_module.global_variables:
            environment = lookup_environment(variable.name) if variable.name.startswith(_ENVIRONMENT) else None
            if environment is not None:
                self.codegen.set_env(variable.name, environment)

    def _optimize_final_module(self) -> None:
        """Optimise functions as private ones: LLVM then removes calls, and arguments that are not used.

        They get names of their own, since LLVM's loader finds functions by name in all that it has loaded, internal
        ones too: code that was compiled apart would call one of these, which has lost arguments, for the whole kernel.
        """
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage.name == "linkonce_odr":
                function.linkage, function.name = "internal", f"part.{function.name}"
        super()._optimize_final_module()

    def _get_module_for_linking(self) -> Any:
        if not self.is_part:
            return super()._get_module_for_linking()
        module = self._shared_module
        if module is None:
            self._shared_module = module = self._final_module.clone()
            for function in module.functions:
                if not function.is_declaration and function.linkage.name == "external":
                    function.linkage = "linkonce_odr"
        return module


def _is_part(library: Any) -> bool:
    return isinstance(library, KernelLibrary) and library.is_part


def _callees(library: KernelLibrary) -> list[Any]:
    """Libraries of all that is called, callers first: LLVM leaves out functions without a caller so far."""
    seen: set[Any] = set()
    found: list[Any] = []

    def visit(libraries: list[Any]) -> None:
        for each in reversed(libraries):
            if each not in seen:
                seen.add(each)
                if _is_part(each):
                    visit(each._linking_libraries)
                found.append(each)

    visit(library._linking_libraries)
    return found[::-1]


@register_pass(mutates_CFG=True, analysis_only=False)
class _Lowering(NativeLowering):  # type: ignore[misc]
    """Numba's own lowering into a `KernelLibrary`; that of a part has neither a wrapper for Python nor an address."""

    _name = "kernel_lowering"

    def run_pass(self, state: Any) -> bool:
        """Lower one function to LLVM code."""
        library = KernelLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        library.enable_object_caching()
        library.is_part = state.flags.no_compile = state.flags.no_cpython_wrapper = KernelCompiler.depth > 1
        state.library = library
        super().run_pass(state)
        if library.is_part:
            state.cr = state.cr._replace(cfunc=Part())
            state.targetctx.insert_user_function(state.cr.cfunc, state.cr.fndesc, [library])
        return True


class KernelCompiler(Compiler):  # type: ignore[misc]
    """Numba's compiler pipeline with its own lowering pass.

    It runs under Numba's lock, one thread at a time.
    """

    depth = 0
    """Depth of the kernels in compilation, each called by the one before; 1: called by Python."""

    count = 0
    """Number of kernels that this process has loaded: compiled, or read from the disk."""

    def define_pipelines(self) -> Any:
        """Return the compiler's only pipeline."""
        (manager,) = super().define_pipelines()
        manager.passes = [(_Lowering if each is NativeLowering else each, text) for each, text in manager.passes]
        manager._finalized = False
        manager.finalize()
        return [manager]

    def compile_extra(self, function: Any) -> Any:
        """Compile *function* for the given argument types."""
        KernelCompiler.depth += 1
        try:
            return super().compile_extra(function)
        finally:
            KernelCompiler.depth -= 1


class KernelDispatcher(CPUDispatcher):  # type: ignore[misc]
    """A kernel, callable from Python and from other kernels.

    A function that was compiled only as a part of other kernels is compiled again when Python calls it.
    """

    def add_overload(self, result: Any) -> None:
        """Store a compiled signature; Python cannot call a function that is compiled as a part."""
        if isinstance(result.entry_point, Part):
            self.overloads[tuple(result.signature.args)] = result
        else:
            super().add_overload(result)

    def compile(self, signature: Any) -> Any:
        """Compile for *signature*, or load it from the disk cache."""
        KernelCompiler.count += 1
        with global_compiler_lock:
            arguments = tuple(normalize_signature(signature)[0])
            if not KernelCompiler.depth and self.is_only_part(arguments):
                del self.overloads[arguments]
            with _rarely_collected():
                return super().compile(signature)

    def is_only_part(self, arguments: tuple[Any, ...]) -> bool:
        """Return whether the kernel is compiled for these argument types only as a part of other kernels."""
        known = self.overloads.get(arguments)
        return known is not None and isinstance(known.entry_point, Part)


@contextmanager
def _rarely_collected() -> Iterator[None]:
    """Collect garbage rarely for now: almost all objects that compilation makes stay until its end."""
    before = gc.get_threshold()
    if before[0]:
        gc.set_threshold(max(before[0], _COLLECT), *before[1:])
    try:
        yield
    finally:
        gc.set_threshold(*before)
