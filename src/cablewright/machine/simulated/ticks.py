"""Sampling intervals of sensors in steps of a machine."""

from __future__ import annotations

from cablewright.errors import InputError


def steps_per_interval(period: float, interval: float, what: str) -> int:
    """Return how many steps of *period* (s) make an *interval* (s). Raises `InputError`, naming *what*, if none do."""
    count = interval / period
    whole = round(count)
    if whole < 1 or abs(count - whole) > 1e-6 * whole:
        raise InputError(
            f"{what}: every {interval:g} s is no whole number of the machine's steps, {period:g} s; "
            f"allowed: {period:g}, {2 * period:g}, {3 * period:g} s and so on"
        )
    return whole
