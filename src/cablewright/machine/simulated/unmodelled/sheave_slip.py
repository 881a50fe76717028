"""Friction of sheaves: tensions before and after one differ by the direction in which the cable moves.

Capstan formula (Euler, Eytelwein): T_winch = T_platform exp(-mu a s), a the angle by which the cable turns and s the
state of sliding, 1 while it is paid out and -1 while it is reeled in. Where the motion turns round, s goes from the one
to the other over a short way, by elements that stick first and slip then (Maxwell slip): no jump, and no rate.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.kernels.layout import Packed
from cablewright.kernels.plant import sheave_slip
from cablewright.kernels.statics.line.guides import GUIDE_SIZE
from cablewright.models.packed_views import LineStates

STICKS: Final = np.array([0.2e-3, 0.5e-3, 1e-3])  # assumed: m, from rest until an element slips; equal shares


class SheaveSlip:
    """Sliding of m lines over their guides, and their sheaves or eyelets at the exit.

    Pulleys of an advantage and sheaves on the platform turn without friction. Where a winch is not described its dead
    span arrives vertically, as for the contact in statics.
    """

    SAVED = ("_free", "elements", "ratio")

    def __init__(self, friction: float, states: Array, turned: Array) -> None:
        """*friction*: share that is lost over a right angle; *states* (m, 6) are those of lines at rest.

        *turned* (m,): rad, by which each cable turns on its guides before the exit point.
        """
        self._rate = -math.log1p(-friction) / (0.5 * math.pi)  # mu
        self._free, self._turned = LineStates(states).free_length.copy(), turned
        self._guide = np.zeros(GUIDE_SIZE)
        self.elements = np.zeros((len(states), len(STICKS)))
        self.ratio = np.ones(len(states))
        """Tension at the winch over that at the platform, (m,)."""
        self.stretch = np.zeros(len(states))
        """Stretch of the dead spans minus their stretch in statics, (m,) m."""

    def slide(self, packed: Packed, states: Array, planes: Array) -> Array:
        """Move the cables over their sheaves to *states* (m, 6); return tension at the winch over that at the platform.

        The states changed in one direction since the last call. The ratio is (m,).
        """
        given = (packed, states, planes, self._turned, self._guide, self._rate, STICKS)
        sheave_slip.slide(*given, self._free, self.elements, self.ratio, self.stretch)
        return self.ratio
