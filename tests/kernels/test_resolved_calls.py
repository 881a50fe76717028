"""Types of calls that are remembered: the same as Numba finds, with the implementation of the options at hand."""

from __future__ import annotations

import operator
from collections.abc import Iterator
from typing import Any

import numba
import numpy as np
import pytest
from numba.core import types
from numba.core.compiler import Flags
from numba.core.registry import cpu_target
from numba.core.targetconfig import ConfigStack, TargetConfig
from numba.core.types.functions import BaseFunction

from cablewright.kernels import jit, resolved_calls

MATRIX = numba.typeof(np.zeros((2, 3)))
CALLS = [
    (operator.mul, (types.float64, types.int64)),
    (operator.mul, (types.float64, types.float64)),
    (operator.eq, (types.int64, types.intp)),
    (operator.getitem, (MATRIX, types.intp)),
    (operator.getitem, (MATRIX, types.UniTuple(types.intp, 2))),
    (operator.getitem, (types.UniTuple(types.float64, 3), types.intp)),
    (max, (types.float64, types.float64)),
]


def flags(*, allocates: bool) -> Flags:
    found = Flags()
    found.nrt = allocates
    return found


@pytest.fixture
def context() -> Iterator[Any]:
    found = cpu_target.typing_context
    found.refresh()
    with ConfigStack().enter(flags(allocates=True)):
        yield found


@pytest.mark.parametrize(("function", "arguments"), CALLS)
def test_what_is_remembered_is_what_numba_finds(context: Any, function: Any, arguments: Any) -> None:
    asked = context.resolve_value_type(function)
    remembered = [asked.get_call_type(context, arguments, {}) for _ in range(2)][1]
    key = asked.get_impl_key(remembered)
    found = resolved_calls._resolve(asked, context, arguments, {})
    assert remembered == found
    assert asked.get_impl_key(found) == key


def test_the_implementation_is_of_the_options_at_hand(context: Any) -> None:
    """Without reference counts an overload is compiled apart: its key is not that of the call in between."""
    asked, arguments = context.resolve_value_type(max), (types.float64, types.float64)
    counted = asked.get_impl_key(asked.get_call_type(context, arguments, {}))
    with ConfigStack().enter(flags(allocates=False)):
        asked.get_call_type(context, arguments, {})
    assert asked.get_impl_key(asked.get_call_type(context, arguments, {})) == counted


def test_a_call_is_resolved_once(context: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []
    inner = resolved_calls._resolve

    def count(self: Any, *arguments: Any) -> Any:
        asked.append((self, arguments[1]))
        return inner(self, *arguments)

    monkeypatch.setattr(resolved_calls, "_resolve", count)
    monkeypatch.setattr(resolved_calls, "_found", {})
    kernel = jit(lambda x, y: x * y + x * y * x * y)
    assert kernel(2.0, 3.0) == 42.0
    products = [args for function, args in asked if function.typing_key is operator.mul]
    assert products == [(types.float64, types.float64)]


def test_options_are_equal_where_all_their_values_are() -> None:
    plain, told, other = Flags(), Flags(), Flags()
    told.nrt = plain.nrt
    other.nrt = not plain.nrt
    assert plain == told
    assert plain != other
    assert plain != "flags"
    assert plain != TargetConfig()
    assert hash(plain) == hash(told) == TargetConfig.__hash__(told)


def test_calls_with_keywords_are_not_remembered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(resolved_calls, "_found", {})
    assert jit(lambda x: np.sum(a=x), allocates=True)(np.ones(3)) == 3.0
    assert not [asked for asked, *_ in resolved_calls._found if asked.typing_key is np.sum]


def test_numba_uses_it() -> None:
    assert BaseFunction.get_call_type is resolved_calls._call_type
    assert Flags.__eq__ is resolved_calls._are_equal
    assert Flags.__hash__ is resolved_calls._hash_of


def test_an_unknown_call_is_an_error_each_time() -> None:
    for _ in range(2):
        with pytest.raises(numba.TypingError, match="No implementation of function"):
            jit(lambda x: x + "text")(1.0)
