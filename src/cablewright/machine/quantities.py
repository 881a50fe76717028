"""Types of numbers in machine files with their ranges, and a check of pairs that must rise."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from cablewright.foundation.units import Density, Duration, Length, Mass
from cablewright.foundation.validation import refusal

# Beyond any machine, but so far from the ends of floats that nothing computed from them leaves those.
Span = Annotated[Length, Field(ge=1e-6, le=1e5)]
Width = Annotated[Length, Field(ge=0.0, le=1e5)]
Time = Annotated[Duration, Field(ge=1e-6, le=1e9)]
Delay = Annotated[Duration, Field(ge=0.0, le=1e9)]
Heavy = Annotated[Mass, Field(ge=1e-6, le=1e9)]
Dense = Annotated[Density, Field(ge=10.0)]  # no material that is laid is lighter
Factor = Annotated[float, Field(ge=1e-6, le=1e9)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
Rate = Annotated[float, Field(gt=0.0, le=1e5)]
Size = Annotated[float, Field(ge=0.0, le=1e6)]
Times = Annotated[tuple[tuple[Duration, Duration], ...], Field(max_length=1000)]  # begin and end of each


def require_pairs_rise(key: str, spans: tuple[tuple[float, float], ...], unit: str = "s") -> None:
    """Raise an error for ``key`` unless the second of each pair, in that *unit*, is larger than the first."""
    for begin, end in spans:
        if not begin < end:
            raise refusal(key, f"must each rise; {begin:g} to {end:g} {unit} does not")
