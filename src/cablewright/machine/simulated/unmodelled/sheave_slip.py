"""Friction of sheaves: tensions before and after one differ by the direction in which the cable moves.

Capstan formula (Euler, Eytelwein): T_winch = T_platform exp(-mu a s), a the angle by which the cable turns and s the
state of sliding, 1 while it is paid out and -1 while it is reeled in. Where the motion turns round, s goes from the one
to the other over a short way, by elements that stick first and slip then (Maxwell slip): no jump, and no rate.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from cablewright.arrays import Array
from cablewright.machine.simulated.snapshot import Archive
from cablewright.models.packed_views import LineNumbers, LineStates

STICKS: Final = np.array([0.2e-3, 0.5e-3, 1e-3])  # assumed: m, from rest until an element slips; equal shares


class SheaveSlip:
    """Sliding of m lines over their sheaves or eyelets at the exit."""

    def __init__(self, friction: float, states: Array) -> None:
        """*friction*: share that is lost over a right angle; *states* (m, 6) are those of lines at rest."""
        self._rate = -math.log1p(-friction) / (0.5 * math.pi)  # mu
        self._free = LineStates(states).free_length.copy()
        self.elements = np.zeros((len(states), len(STICKS)))

    def slide(self, lines: Array, states: Array) -> Array:
        """Slide to where *lines* are by their *states*; return the tension at the winch over that of the platform.

        (m,); the way was monotonous since the last call.
        """
        free = LineStates(states).free_length
        self.elements += (free - self._free)[:, None] / STICKS
        np.clip(self.elements, -1.0, 1.0, out=self.elements)
        self._free[:] = free
        return np.asarray(np.exp(-self._rate * turning(lines, states) * self.elements.mean(axis=1)))

    def archive_state(self, archive: Archive) -> None:
        """Save or load the state."""
        archive.array("slip_free", self._free)
        archive.array("slip", self.elements)


def turning(lines: Array, states: Array) -> Array:
    """Return the angle (m,), rad, by which each cable turns between its dead span and its free span.

    Where the winch is not described the dead span arrives vertically, as for the contact in statics.
    """
    state, numbers = LineStates(states), LineNumbers(lines)
    contact = numbers.side * (state.dead_angle - state.free_angle) + np.pi
    bent = np.abs((contact + np.pi) % (2.0 * np.pi) - np.pi)  # in an eyelet it turns by the shorter way
    return np.where(numbers.radius > 0.0, np.maximum(contact, 0.0), bent)


def dead_stretch(lines: Array, states: Array, ratio: Array) -> Array:
    """Return how much more than in statics dead spans stretch, (m,) m: their tension is *ratio* (m,) as large."""
    state, numbers = LineStates(states), LineNumbers(lines)
    return np.asarray((ratio - 1.0) * state.tension * numbers.dead_compliance * state.dead_length)
