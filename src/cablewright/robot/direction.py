"""Directions in robot files: three numbers of any length but zero."""

import math
from typing import Annotated

from pydantic import AfterValidator, Strict
from pydantic_core import PydanticCustomError

from cablewright.foundation.units import Vec3

_Number = Annotated[float, Strict()]


def _not_zero(direction: tuple[float, float, float]) -> tuple[float, float, float]:
    if not any(direction):
        raise PydanticCustomError("zero", "must not be zero")
    return direction


Direction = Annotated[tuple[_Number, _Number, _Number], AfterValidator(_not_zero)]
"""Three numbers, not all zero; their size has no meaning."""


def cross(a: Vec3, b: Vec3) -> Vec3:
    """Return the cross product of two vectors."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def unit_vector(direction: tuple[float, float, float]) -> Vec3:
    """Return the unit vector of a *direction*."""
    largest = max(abs(number) for number in direction)  # divided out: nothing under- or overflows
    x, y, z = (number / largest for number in direction)
    size = math.hypot(x, y, z)
    return x / size, y / size, z / size
