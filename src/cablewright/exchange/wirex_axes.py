"""The axes of a sheave's mounting in WireX: the third is that about which it swivels, along which the cable comes."""

from __future__ import annotations

import math
from collections.abc import Sequence

Axes = tuple[tuple[float, ...], ...]


def axes_of(axis: Sequence[float]) -> Axes:
    """Return right-handed axes (columns x, y, z) with that third *axis* of length one: the world's for an upright one.

    Which way x and y point means nothing here.
    """
    a, b, c = axis
    if a == b == 0.0:
        return ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)) if c > 0.0 else _DOWN
    level = math.hypot(a, b)
    x = (-b / level, a / level, 0.0)
    y = (-c * x[1], c * x[0], a * x[1] - b * x[0])
    return x, tuple(each + 0.0 for each in y), (a, b, c)


_DOWN: Axes = ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0))
