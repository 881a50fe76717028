"""Rows of a batch on all threads: kernels hold no lock of Python's, so that plain threads can share them."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import contextmanager
from typing import Any

from cablewright.kernels import compile_for, is_compiled, thread_count
from cablewright.kernels.layout import CHUNK, Packed

log = logging.getLogger(__name__)

SHARES = 8  # blocks of rows for each thread, so that none waits long for the others
MAX_CHUNKS = 16  # in a block, after which an interruption is seen


class _Threads:
    """Threads besides the one that asks. A forked child has none of its parent's and makes its own."""

    pool: ThreadPoolExecutor | None = None

    @classmethod
    def get(cls) -> ThreadPoolExecutor:
        """Reserve all threads of the computer that may be used but one."""
        if cls.pool is None:
            cls.pool = ThreadPoolExecutor(max(1, thread_count() - 1), "kernels")
        return cls.pool

    @classmethod
    def forget(cls) -> None:
        """Forget the threads: they belong to another process."""
        cls.pool = None


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_Threads.forget)


class _Limit:
    """Threads that a batch may take at most; None: all of `thread_count`."""

    threads: int | None = None


@contextmanager
def use_threads(most: int | None) -> Iterator[None]:
    """Limit the threads of batches inside the context, where others compute too; None: unchanged."""
    before = _Limit.threads
    _Limit.threads = before if most is None else most
    try:
        yield
    finally:
        _Limit.threads = before


class _Words:
    """Message on compilation: one line in a process, unless the caller reports more."""

    said = False

    @classmethod
    def say(cls) -> None:
        """Log that the numerical kernels are being compiled, which takes time."""
        if not cls.said:
            log.info("compiling kernels (once, up to a minute)")
        cls.said = True


@contextmanager
def saying_more() -> Iterator[None]:
    """Return a context in which the caller itself reports compilation."""
    before, _Words.said = _Words.said, True
    try:
        yield
    finally:
        _Words.said = before


_ahead: list[Callable[[], None]] = []


@contextmanager
def before_compiling(action: Callable[[], None]) -> Iterator[None]:
    """Call *action*, once, before a kernel that was never compiled is run inside this context."""
    _ahead.append(action)
    try:
        yield
    finally:
        _ahead.clear()


_ready: set[tuple[Any, bool | None]] = set()  # kernels of which this process knows that they are compiled, by variant


def run(kernel: Callable[..., None], rows: int, *arguments: Any, chunk: int = CHUNK) -> None:
    """Run *kernel* on the *rows* of a batch, on several threads if they are more than one *chunk*.

    The kernel takes *arguments*, the first row, and the row after the last. Results do not depend on the threads.
    """
    if not rows:
        return
    variant = kernel, next((each.general for each in arguments if isinstance(each, Packed)), None)
    if variant not in _ready:
        if _ahead and not is_compiled(kernel, *arguments, 0, rows):
            _ahead.pop()()
        if not is_compiled(kernel, *arguments, 0, rows):
            _Words.say()
        compile_for(kernel, *arguments, 0, rows)
        _ready.add(variant)
    threads = min(_Limit.threads or thread_count(), -(-rows // chunk))
    if threads == 1:
        kernel(*arguments, 0, rows)
        return
    block = chunk * min(MAX_CHUNKS, -(-rows // (SHARES * threads * chunk)))
    _share(kernel, rows, arguments, threads, block)


def _share(kernel: Callable[..., None], rows: int, arguments: Any, threads: int, block: int) -> None:
    """Run *kernel* on blocks of rows, each begun by whichever thread is free."""
    firsts = iter(range(0, rows, block))  # which one thread at a time takes from

    def work() -> None:
        for first in firsts:
            kernel(*arguments, first, min(rows, first + block))

    others = [_Threads.get().submit(work) for _ in range(threads - 1)]
    try:
        work()
    finally:
        for _ in firsts:  # after an interruption no thread begins another block
            pass
        begun = [other for other in others if not other.cancel()]
        wait(begun)
    for other in begun:
        other.result()
