"""Directions in robot files: three numbers of any length but zero."""

from __future__ import annotations

import math
from typing import Annotated, Final

from pydantic import AfterValidator, Strict
from pydantic_core import PydanticCustomError

from cablewright.foundation.units import Vec3

_Number = Annotated[float, Strict()]
_MIN_SINE: Final = 0.1  # of the angle between a normal and the direction of a top


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


def facing(normal: Vec3, up: Vec3) -> tuple[Vec3, Vec3, Vec3]:
    """Return right, top and normal of a picture that faces along *normal*: unit vectors at right angles.

    Its top is towards *up*. Raises `ValueError` where both directions are along each other.
    """
    z, top = unit_vector(normal), unit_vector(up)
    across = cross(top, z)
    if math.hypot(*across) < _MIN_SINE:
        raise ValueError("is parallel to the direction that it faces: give the direction of its top")
    x = unit_vector(across)
    return x, cross(z, x), z
