"""Compliance of the mount of an exit point: displacement per force, m/N."""

from __future__ import annotations

import math
from typing import Annotated, Final

from pydantic import AfterValidator, Field, Strict

from cablewright.foundation.validation import refusal

MOST: Final = 1e-2
"""The largest compliance, m/N."""

_ROUNDING: Final = 1e-12  # of a compliance's largest entry
_Entry = Annotated[float, Strict(), Field(ge=-MOST, le=MOST)]
_Row = tuple[_Entry, _Entry, _Entry]
_Matrix = tuple[_Row, _Row, _Row]


def _require_passive(value: float | _Matrix) -> float | _Matrix:
    if isinstance(value, float):
        if not 0.0 <= value <= MOST:
            raise refusal("compliance", f"{value:g} m/N: must be 0 to {MOST:g} m/N")
        return value
    slight = _ROUNDING * max(abs(entry) for row in value for entry in row)
    if any(abs(value[i][j] - value[j][i]) > slight for i, j in ((0, 1), (0, 2), (1, 2))):
        raise refusal("compliance", "must be a symmetric matrix: a mount that is not gains energy over a cycle")
    least = _least_eigenvalue(value)
    if least < -slight:
        raise refusal("compliance", f"makes the stiffness indefinite: its smallest eigenvalue is {least:g} m/N")
    return value


Compliance = Annotated[Annotated[float, Strict()] | _Matrix, AfterValidator(_require_passive)]
"""Displacement per force, m/N: the same in all directions, or a symmetric matrix (3, 3) in world axes."""


def compliance_matrix(compliance: float | _Matrix) -> _Matrix:
    """Return the matrix (3, 3), m/N, of a compliance that may be the same in all directions."""
    if isinstance(compliance, float):
        return (compliance, 0.0, 0.0), (0.0, compliance, 0.0), (0.0, 0.0, compliance)
    return compliance


def _least_eigenvalue(matrix: _Matrix) -> float:
    """Smallest eigenvalue of a symmetric matrix, by the angle of its characteristic polynomial (Smith 1961)."""
    (a, d, e), (_, b, f), (_, _, c) = matrix
    mean = (a + b + c) / 3.0
    a, b, c = a - mean, b - mean, c - mean
    size = math.sqrt((a * a + b * b + c * c + 2.0 * (d * d + e * e + f * f)) / 6.0)
    if size == 0.0:
        return mean
    half = 0.5 * (a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e)) / size**3
    return mean + 2.0 * size * math.cos((math.acos(min(max(half, -1.0), 1.0)) + 2.0 * math.pi) / 3.0)
