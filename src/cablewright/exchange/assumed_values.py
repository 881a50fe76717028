"""Values that a robot file needs and other formats do not have: assumed by a stated rule, and listed in the answer."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, Final

from cablewright.exchange.translation_result import Notes
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.units import three_digits
from cablewright.robot.cable_table import CABLES, DENSITY, ELONGATION, SAFETY, STRENGTH

Point = tuple[float, ...]

SIZES: Final = (0.05, 1000.0)
"""Largest distance of two exit points, m, that a file may have: others are in mm where m are meant, or the reverse."""


BOX: Final = "scene.frame_min and frame_max: the box around the exit points, from the floor z = 0 up"


def frame_of(exits: Sequence[Point], path: Path, notes: Notes, normal: int | None = None) -> dict[str, Any]:
    """Return the ``scene`` of a robot with those exit points (m): the box around them, from the floor z = 0 up.

    *path*: its file, for messages. A box without an extent along an axis is made a tenth of its largest side wide
    there, and 1 cm along *normal*.
    Raises `InputError` for a robot of no size that one has: a file without units that was not in the format's own.
    """
    _require_some_size(exits, path)
    low, high = ([pick(each[k] for each in exits) for k in range(3)] for pick in (min, max))
    low[2] = min(low[2], 0.0)
    size = max(max(h - b for b, h in zip(low, high, strict=True)), 0.1)
    for k in range(3):
        if k == normal or high[k] - low[k] < 1e-3 * size:
            margin = 0.01 if k == normal else 0.05 * size
            low[k], high[k] = low[k] - margin, high[k] + margin
    notes.add("scene.gravity: 9.81 m/s^2 along -z")
    notes.add(BOX)
    return {"frame_min": tuple(low), "frame_max": tuple(high)}


def _require_some_size(exits: Sequence[Point], path: Path) -> None:
    apart = math.dist(*([pick(each[k] for each in exits) for k in range(3)] for pick in (min, max)))
    least, most = SIZES
    if apart > most or (len(exits) > 1 and 0.0 < apart < least):
        why = f"at most {most:g} m is" if apart > most else f"at least {least:g} m is"
        raise InputError(
            f"{path}: the exit points are {apart:g} m apart; {why} read: are lengths in the unit of the format?"
        )


def chosen_cable(name: str) -> dict[str, Any]:
    """Return the table of a cable that can be bought, by its *name* in `CABLES`. Raises `UnknownName`."""
    if name not in CABLES:
        raise UnknownName("cable", name, CABLES)
    return CABLES[name].cable.model_dump(exclude_defaults=True)


def assumed_cable(max_tension: float, notes: Notes) -> dict[str, Any]:
    """Return a braided Dyneema cable that bears *max_tension* (N) with the safety of `SAFETY`, by its table's rules."""
    breaking = SAFETY * max_tension
    diameter = math.sqrt(breaking / STRENGTH)
    notes.add(
        f"cable: braided Dyneema of {1e3 * diameter:.3g} mm, whose breaking load is {SAFETY:g} times the max tension; "
        "--cable takes another of the table"
    )
    return {
        "axial_stiffness": three_digits(max_tension / ELONGATION),
        "linear_density": three_digits(DENSITY * diameter**2),
        "breaking_load": breaking,
        "diameter": three_digits(diameter),
    }


def require_right_handed(axes: Sequence[Sequence[float]], place: str) -> None:
    """Raise `InputError` unless the columns *axes* (3, 3) are a rotation: orthogonal, of length one, right-handed."""
    x, y, z = axes
    for one, other, wanted in ((x, x, 1.0), (y, y, 1.0), (z, z, 1.0), (x, y, 0.0), (y, z, 0.0), (z, x, 0.0)):
        if abs(sum(a * b for a, b in zip(one, other, strict=True)) - wanted) > 1e-4:
            raise InputError(f"{place}: a11 to a33 are no rotation: columns must be orthogonal and of length 1")
    if _determinant(x, y, z) < 0.0:
        raise InputError(
            f"{place}: a11 to a33 are left-handed axes (determinant -1); only right-handed axes are supported"
        )


def as_point(lines: Iterable[dict[str, Any]]) -> bool:
    """Return whether all lines end at one platform point."""
    return len({line["platform_point"] for line in lines}) == 1


def name_of(text: str, path: Path) -> str:
    """Return the name of a robot: the file's *text*, or the file's name where that is empty."""
    return text.strip()[:100] or path.stem[:100] or "imported"


def _determinant(x: Sequence[float], y: Sequence[float], z: Sequence[float]) -> float:
    return x[0] * (y[1] * z[2] - y[2] * z[1]) - x[1] * (y[0] * z[2] - y[2] * z[0]) + x[2] * (y[0] * z[1] - y[1] * z[0])
