"""Frozen dataclasses that are filled quickly are the same as others."""

from __future__ import annotations

from dataclasses import FrozenInstanceError, dataclass, field, replace
from inspect import signature
from typing import Any

import pytest

from cablewright.foundation.quick_values import quickly_filled


@dataclass(frozen=True)
class Plain:
    time: float
    speed: float
    valve: float = 0.5
    names: list[str] = field(default_factory=list)


@quickly_filled
@dataclass(frozen=True)
class Filled:
    time: float
    speed: float
    valve: float = 0.5
    names: list[str] = field(default_factory=list)


GIVEN: list[tuple[tuple[Any, ...], dict[str, Any]]] = [
    ((1.0, 2.0), {}),
    ((1.0, 2.0, 3.0, ["a"]), {}),
    ((1.0,), {"speed": 2.0}),
    ((), {"time": 1.0, "speed": 2.0, "names": ["b"]}),
    ((), {}),
    ((1.0,), {}),
    ((1.0,), {"valve": 0.0}),
    ((1.0, 2.0, 3.0, [], 5.0), {}),
    ((1.0, 2.0), {"speed": 3.0}),
    ((1.0, 2.0, 3.0), {"speed": 3.0}),
    ((1.0, 2.0), {"other": 3.0}),
    ((1.0,), {"other": 3.0}),
    ((1.0, 2.0, 3.0), {"other": 3.0}),
]


def made_by(kind: type, given: tuple[Any, ...], named: dict[str, Any]) -> str:
    """Text of a value, or of the error."""
    try:
        return repr(kind(*given, **named))
    except TypeError as error:
        return str(error)


@pytest.mark.parametrize(("given", "named"), GIVEN)
def test_values_and_errors_are_those_of_the_dataclass(given: tuple[Any, ...], named: dict[str, Any]) -> None:
    assert made_by(Filled, given, named) == made_by(Plain, given, named).replace("Plain", "Filled")


def test_they_stay_frozen_and_keep_their_signature() -> None:
    value = Filled(1.0, 2.0)
    with pytest.raises(FrozenInstanceError):
        value.time = 2.0  # type: ignore[misc]
    assert Filled(1.0, 2.0).names is not value.names
    assert replace(value, valve=0.25) == Filled(1.0, 2.0, 0.25)
    assert str(signature(Filled)) == str(signature(Plain))
