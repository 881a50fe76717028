"""Control of the platform's height over the structure, by the fictive height (Merlet and Papegay 2023, III.A)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from cablewright.foundation.errors import require_positive


@dataclass(frozen=True)
class HeightControl:
    """Settings of height control.

    ``clearance``: mean height over the surface below, m. ``gain``: gain on the height error, 1/s. ``max_speed``:
    largest vertical speed of the correction, m/s.
    """

    clearance: float
    gain: float = 0.1
    max_speed: float = 2e-3

    def __post_init__(self) -> None:
        """Raise `InputError` for numbers that are not positive and finite."""
        require_positive(**vars(self))


def step(settings: HeightControl, lift: float, clearance: float, dt: float) -> float:
    """Return the new *lift* (m) of the target over its path, from the measured *clearance* (m); NaN keeps the lift."""
    if not math.isfinite(clearance):
        return lift
    rate = min(settings.gain, 0.5 / dt) * (settings.clearance - clearance)
    return lift + dt * min(max(rate, -settings.max_speed), settings.max_speed)
