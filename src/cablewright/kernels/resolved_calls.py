"""The types that Numba infers for calls, remembered.

At each place where a function is called, Numba tries all its implementations, those for strings and sets too, and takes
the first that fits. For the same types and options it finds the same. Calls of all functions that this process compiles
by Numba are remembered, but no errors and no calls with keywords.
"""

from __future__ import annotations

from operator import attrgetter
from typing import Any

from numba.core.compiler import Flags
from numba.core.targetconfig import ConfigStack, TargetConfig
from numba.core.types.functions import BaseFunction

_found: dict[tuple[Any, ...], tuple[Any, Any]] = {}
_HASH = hash(Flags())  # that of all: Numba hashes the options' names alone
_resolve: Any = BaseFunction.get_call_type
_told = attrgetter("_values")  # the options that were set


def _call_type(self: Any, context: Any, args: Any, kws: Any) -> Any:
    """Return the signature for the types of a call's arguments, as Numba's own function does.

    The key of the implementation is stored as there: that of other options may have been stored meanwhile.
    """
    if kws:
        return _resolve(self, context, args, kws)
    asked = self, context, tuple(args), ConfigStack.top_or_none()
    known = _found.get(asked)
    if known is None:
        signature = _resolve(self, context, args, kws)
        _found[asked] = signature, self._impl_keys[signature.args]
        return signature
    signature, key = known
    self._impl_keys[signature.args] = key
    return signature


def _are_equal(self: Any, other: Any) -> Any:
    """Compare the options that were set; if they differ, all options, with their defaults."""
    if type(self) is type(other) and _told(self) == _told(other):
        return True
    return TargetConfig.__eq__(self, other)


def _hash_of(_: Any) -> int:
    return _HASH


def remember() -> None:
    """Let Numba remember the types of calls, in this process."""
    for owner, name, function in (
        (BaseFunction, "get_call_type", _call_type),
        (Flags, "__eq__", _are_equal),
        (Flags, "__hash__", _hash_of),
    ):
        setattr(owner, name, function)
