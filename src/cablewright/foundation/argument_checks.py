"""Type checks of arguments of public functions: a wrong type is an error of one line, before any work."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache, wraps
from inspect import Parameter, Signature, signature
from numbers import Integral, Real
from os import PathLike
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Union, Unpack, get_args, get_origin, get_type_hints, is_typeddict

from cablewright.foundation.errors import InputError, suggestion

_AS_GIVEN: Mapping[Any, tuple[Any, ...]] = {float: (Real,), int: (Integral,), Path: (PathLike,)}
_WORDS: Mapping[Any, str] = {
    Real: "a number in SI units",
    Integral: "a whole number",
    PathLike: "a path",
    str: "a text",
    bool: "True or False",
    NoneType: "None",
    Sequence: "a list",
    Mapping: "a dict",
}
_VARIED = (Parameter.VAR_POSITIONAL, Parameter.VAR_KEYWORD)


def checked(function: Callable[..., Any], name: str) -> Callable[..., Any]:
    """Return a public *function* that raises `InputError` for an argument of another type than it declares.

    Only types that `isinstance` can decide count: classes, numbers, texts and paths. Arrays and callables are looked at
    where they are used. *name*: name of the function in `cablewright`, by which other processes find it.
    """

    @wraps(function)
    def call(*arguments: Any, **options: Any) -> Any:
        shape, rules, known = _rules(function)
        try:
            given = shape.bind(*arguments, **options).arguments
        except TypeError:
            return function(*arguments, **options)  # its TypeError names the missing or surplus argument
        for key in options:
            if known and key not in known:
                raise InputError(f"{name}: unknown argument {key!r}; {suggestion(key, known)}")
        for key, classes in rules.items():
            if key in given and not isinstance(given[key], classes):
                asked = " or ".join(_WORDS.get(each, _article(each.__name__)) for each in classes)
                raise InputError(f"{name}: {key} = {given[key]!r:.60}: {asked} is expected")
        return function(*arguments, **options)

    call.__module__, call.__qualname__ = "cablewright", name
    return call


def _article(name: str) -> str:
    return f"{'an' if name[0] in 'AEIOU' else 'a'} {name}"


@cache
def _rules(function: Callable[..., Any]) -> tuple[Signature, dict[str, tuple[Any, ...]], tuple[str, ...]]:
    """Return the signature of a function, and the classes of its parameters that can be checked, by name.

    Last come the names of all keyword arguments, of a function that has some of them in a `TypedDict`; else none.
    """
    shape, hints = signature(function), get_type_hints(function)
    fixed = [key for key, each in shape.parameters.items() if each.kind not in _VARIED]
    found = {key: _classes(hints[key]) for key in fixed if key in hints}
    rest = next((hints.get(key) for key, each in shape.parameters.items() if each.kind is Parameter.VAR_KEYWORD), None)
    table = get_args(rest)[0] if get_origin(rest) is Unpack else None
    known = () if table is None else (*fixed, *get_type_hints(table))
    return shape, {key: classes for key, classes in found.items() if classes}, known


def _classes(hint: Any) -> tuple[Any, ...]:
    """Return the classes of which a value may be; none where the class does not decide."""
    found: list[Any] = []
    for part in get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,):
        if part in _AS_GIVEN:
            found += _AS_GIVEN[part]
        elif get_origin(part) in (Sequence, Mapping) and not {*get_args(part)} & {float, int}:
            found.append(get_origin(part))
        elif isinstance(part, type) and not (getattr(part, "_is_protocol", False) or is_typeddict(part)):
            found.append(part)
        else:
            return ()
    return tuple(found)
