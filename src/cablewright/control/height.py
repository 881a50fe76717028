"""How high over the structure the platform is kept: by the fictive height (Merlet and Papegay 2023, III.A)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from cablewright.errors import InputError

__all__ = ["HeightControl", "step"]


@dataclass(frozen=True)
class HeightControl:
    """``clearance``: m of the platform over what lies below it, on average. ``gain``: 1/s. ``most``: m/s."""

    clearance: float
    gain: float = 0.1
    most: float = 2e-3

    def __post_init__(self) -> None:
        """Refuse what is no height."""
        for name in ("clearance", "gain", "most"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise InputError(f"{name} = {getattr(self, name):g}: a finite number over 0 is wanted")


def step(settings: HeightControl, lift: float, clearance: float, dt: float) -> float:
    """Return the new *lift* (m) of the target over its path, by the *clearance* (m) that is seen; NaN leaves it."""
    if not math.isfinite(clearance):
        return lift
    rate = min(settings.gain, 0.5 / dt) * (settings.clearance - clearance)
    return lift + dt * min(max(rate, -settings.most), settings.most)
