"""Numbers as text for people: from SI to a unit of suitable size."""

from __future__ import annotations

import math
from collections.abc import Callable

NOT_KNOWN = "not known"

_GAP = "\N{NO-BREAK SPACE}"
_FINEST_LENGTH = 1e-6  # m: below a thousandth of a millimetre a number means nothing on a machine of metres


def quantity(value: float, unit: str) -> str:
    """Return ``value`` (SI) as text with a unit: metres as mm, m or km, newtons as N or kN, radians as degrees."""
    if math.isnan(value):
        return NOT_KNOWN
    if math.isinf(value):
        return "no limit"
    writer = _WRITERS.get(unit)
    return writer(value) if writer else f"{_significant(value)}{_GAP}{unit}".rstrip()


def allowed_range(low: float, high: float, unit: str) -> str:
    """Return the allowed range of a quantity as text: from the lowest to the highest value, or the one bound."""
    if not math.isfinite(low) and not math.isfinite(high):
        return "no limit"
    if not math.isfinite(high):
        return f"at least {quantity(low, unit)}"
    if not math.isfinite(low):
        return f"at most {quantity(high, unit)}"
    return f"{quantity(low, unit)} to {quantity(high, unit)}"


def duration(seconds: float) -> str:
    """Return a time as text in hours and minutes, in minutes, or in seconds where it is less than two minutes."""
    if not math.isfinite(seconds):
        return NOT_KNOWN
    if seconds < 120:
        return f"{_significant(round(seconds, 1))}{_GAP}s"
    hours, minutes = divmod(round(seconds / 60), 60)
    return f"{count(hours)}{_GAP}h {minutes}{_GAP}min" if hours else f"{minutes}{_GAP}min"


def count(number: int) -> str:
    """Return a whole number as text in groups of three digits."""
    return f"{number:,}".replace(",", _GAP)


def enlargement(goal: float, size: float) -> float:
    """Return the factor, 1 or more, that enlarges *size* to at most *goal*: 1, 2 or 5 times a power of ten."""
    if not 0.0 < size < goal:
        return 1.0
    factor = goal / size * (1.0 + 1e-9)
    power = 10.0 ** math.floor(math.log10(factor))
    return next(step * power for step in (5.0, 2.0, 1.0) if step * power <= factor)


def _significant(value: float) -> str:
    """Three significant digits, more before the point, never an exponent for sizes of a machine."""
    size = abs(value)
    if size == 0:
        return "0"
    if not 1e-4 <= size < 1e9:
        return f"{value:.2e}"
    digits = max(0, 2 - math.floor(math.log10(size)))
    text = f"{value:.{digits}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return text.replace("-", "\N{MINUS SIGN}")


def _length(value: float) -> str:
    size = abs(value)
    if 0 < size < _FINEST_LENGTH:
        return f"<{_GAP}0.001{_GAP}mm" if value > 0 else f">{_GAP}\N{MINUS SIGN}0.001{_GAP}mm"
    if 0 < size < 1:
        return f"{_significant(round(value * 1e3, 3))}{_GAP}mm"
    return f"{_significant(value)}{_GAP}m" if size < 1e4 else f"{_significant(value / 1e3)}{_GAP}km"


def _force(value: float) -> str:
    return f"{_significant(value)}{_GAP}N" if abs(value) < 1e3 else f"{_significant(value / 1e3)}{_GAP}kN"


def _angle(value: float) -> str:
    return f"{_significant(round(math.degrees(value), 1))}°"


_WRITERS: dict[str, Callable[[float], str]] = {"m": _length, "N": _force, "rad": _angle, "s": duration}
