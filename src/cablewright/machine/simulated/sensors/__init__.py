"""Simulated sensors: the flaws of one unit, and its readings of the true state. Modules are found, not listed."""

from __future__ import annotations

from typing import Any, Final

from cablewright.foundation.discovery import declared
from cablewright.machine.simulated.sensors.timed_sensor import Simulated

SIMULATED: Final[tuple[Simulated[Any, Any], ...]] = tuple(
    sorted(declared(__name__, __path__, Simulated), key=lambda each: each.sensor.stream)
)
"""All of them by their streams: the order in which a machine reads them."""
