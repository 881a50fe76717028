"""Exits that give: the mount of each is displaced by the force of its cable, d = C F, closed with the statics.

F is the pull of the free span, and of the dead span where its winch stands apart (`winch_exit`); a winch that is not
described sits on the same mount, whose own forces cancel out. d is from where the exit was surveyed without load. The
winch stays where it is.
"""

import numpy as np

from cablewright.foundation.arrays import Array, Indices
from cablewright.kernels.layout import Packed
from cablewright.kernels.plant import exit_mounts
from cablewright.kernels.statics.equilibrium import Work


class ExitMountState:
    """Displacements of m exits."""

    SAVED = ("displaced",)

    def __init__(self, compliance: Array) -> None:
        """*compliance* (m, 3, 3), m/N; no mount is displaced yet."""
        self._compliance = compliance
        self.displaced = np.zeros((len(compliance), 3))  # m
        self._steps = np.zeros_like(self.displaced)

    def give(self, lines: Array, states: Array, planes: Array, ratio: Array) -> float:
        """Move the exits of the packed *lines* by a step of `exit_mounts.give`; return by how much at most, m."""
        given = (lines, states, planes, ratio, self._compliance, self.displaced, self._steps)
        return float(exit_mounts.give(*given))

    def close(
        self, packed: Packed, kept: Indices, lengths: Array, pose: Array, states: Array, ratio: Array, work: Work
    ) -> int:
        """Let the exits of *packed*, the lines numbered *kept*, give until all is in equilibrium; return a code."""
        displaced = self.displaced[kept]
        given = (packed, lengths, pose, states, ratio[kept], self._compliance[kept], displaced, work)
        code = int(exit_mounts.close(*given))
        self.displaced[kept] = displaced
        return code
