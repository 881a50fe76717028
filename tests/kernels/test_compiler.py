"""How kernels are compiled: parts once, within the kernel that Python calls, and the same answers whoever calls."""

from __future__ import annotations

import copy
import threading
from typing import Any

import numba
import numpy as np
import pytest

from cablewright.kernels import Direct, compile_for, is_compiled, jit
from cablewright.kernels.certificates import interval
from cablewright.kernels.compiler import KernelLibrary, Part


@jit
def largest_of(row):
    return max((row[0], row[1], row[2]))  # a function of Numba's own, which both that call it need


@jit
def spread(row):
    return largest_of(row) - min((row[0], row[1], row[2]))


@jit
def checked(row):
    if row[0] < 0.0:
        raise ValueError("the first is negative")
    return largest_of(row)


def kernel() -> Any:
    """A kernel that is not compiled yet, and that calls one part by two ways."""

    def whole(row):
        return 100.0 * checked(row) + 10.0 * spread(row) + largest_of(row)

    return jit(whole)


ROW = np.array([1.0, 4.0, 2.0])
WHOLE = 100.0 * 4.0 + 10.0 * 3.0 + 4.0


def compiled(function: Any) -> Any:
    (found,) = function.overloads.values()
    return found


def test_a_part_is_neither_optimised_nor_assembled_by_itself() -> None:
    whole = kernel()
    assert whole(ROW) == WHOLE
    for part in (checked, spread, largest_of):
        found = compiled(part)
        assert isinstance(found.entry_point, Part)
        assert not found.library._finalized
    assert compiled(whole).library._finalized
    assert isinstance(compiled(whole).library, KernelLibrary)


def test_what_was_a_part_can_be_called_from_python_and_stays_one_signature() -> None:
    assert kernel()(ROW) == WHOLE
    part = jit(spread.py_func)
    caller = jit(lambda row: part(row))
    assert caller(ROW) == 3.0
    assert part.is_only_part((numba.typeof(ROW),))
    assert not is_compiled(part, ROW)
    assert part(ROW) == 3.0
    assert is_compiled(part, ROW)
    assert len(part.signatures) == 1
    assert caller(ROW) == 3.0


def test_a_kernel_that_python_calls_can_be_a_part_of_the_next() -> None:
    first = jit(spread.py_func)
    assert first(ROW) == 3.0
    assert jit(lambda row: 2.0 * first(row))(ROW) == 6.0


def test_functions_of_numba_may_call_kernels() -> None:
    assert numba.njit(lambda row: spread(row) + 1.0)(ROW) == 4.0


def test_functions_of_numba_call_the_kernel_and_not_the_copy_in_another() -> None:
    """LLVM takes arguments from that copy, and its loader finds functions by name."""
    sine = jit(interval.sin.py_func)
    alone = sine((0.3, 0.4))
    jit(lambda x: interval.sub(sine((x, x)), sine((2.0 * x, 2.0 * x))))(0.3)
    assert numba.njit(lambda x: sine((x, x + 0.1)))(0.3) == alone


def test_an_error_in_a_part_is_raised() -> None:
    whole = kernel()
    with pytest.raises(ValueError, match="the first is negative"):
        whole(-ROW)
    assert whole(ROW) == WHOLE


def test_threads_may_call_what_others_compile() -> None:
    whole, part = kernel(), jit(spread.py_func)
    found: list[float] = []

    def call(function: Any) -> None:
        found.append(function(ROW))

    threads = [threading.Thread(target=call, args=(each,)) for each in (whole, part, whole, part, checked, spread)]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    assert sorted(found) == [3.0, 3.0, 3.0, 4.0, WHOLE, WHOLE]


def test_what_fails_to_compile_leaves_the_next_as_it_should_be() -> None:
    with pytest.raises(numba.TypingError):
        jit(lambda row: spread(row).nothing)(ROW)
    assert kernel()(ROW) == WHOLE


def test_types_suffice_to_compile() -> None:
    whole = kernel()
    compile_for(whole, np.zeros(3))
    assert is_compiled(whole, ROW)


def test_direct_calls_give_the_same_answers_and_errors() -> None:
    direct = Direct(kernel())
    for caller in (direct, copy.deepcopy(direct)):
        for _ in range(2):  # the first one compiles
            assert caller.call(ROW) == WHOLE
        with pytest.raises(ValueError, match="the first is negative"):
            caller.call(-ROW)
