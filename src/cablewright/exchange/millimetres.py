"""Lengths in mm, as firmware has them: exact conversion to m and back, to the last digit."""

from __future__ import annotations

import math

from cablewright.exchange.xml_input import finite
from cablewright.foundation.errors import InputError
from cablewright.foundation.units import LENGTH
from cablewright.foundation.validation import shown


def from_mm(text: str, place: str) -> float:
    """Return a length, m, of a text in mm. Raises `InputError` unless it is a finite number without a unit."""
    finite(text, place)
    try:
        return LENGTH.read(f"{text.strip()} mm")
    except ValueError:  # of many digits, or farther than any machine reaches
        raise InputError(f"{place} = {shown(text)}: must be in mm, under 1e33, in less than 70 characters") from None


def to_mm(length: float) -> str:
    """Return the shortest text in mm that `from_mm` reads back as *length*, m."""
    return LENGTH.write(length, "mm").removesuffix(" mm")


def radius_of_turn(text: str, place: str) -> float:
    """Return the radius, m, of a drum whose turn is a text in mm. Raises `InputError`."""
    return from_mm(text, place) / math.tau


def turn_of_radius(radius: float) -> str:
    """Return a text in mm that `radius_of_turn` reads back as *radius*, m, where there is one: the nearest else."""
    turn = math.tau * radius
    low = high = turn
    for _ in range(8):
        for candidate in (low, high):
            if candidate / math.tau == radius:
                return to_mm(candidate)
        low, high = math.nextafter(low, 0.0), math.nextafter(high, math.inf)
    return to_mm(turn)
