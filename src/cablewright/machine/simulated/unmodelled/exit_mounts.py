"""Compliant exit points of the simulated machine: the force F displaces each mount by d = C F, in equilibrium.

F is the pull of the free span, and of the dead span where its winch stands apart (`winch_exit`); a winch that is not
described sits on the same mount, whose own forces cancel out. d is from the surveyed exit point without load. The winch
stays where it is.
"""

from __future__ import annotations

import numpy as np

from cablewright.foundation.arrays import Array, Indices
from cablewright.kernels.layout import Packed
from cablewright.kernels.plant import exit_mounts
from cablewright.kernels.statics.equilibrium import Work
from cablewright.kernels.statics.line.guides import GUIDE_SIZE


class ExitMountState:
    """Displacements of the m exit points by the pull on their compliant mounts."""

    SAVED = ("displaced",)

    def __init__(self, compliance: Array) -> None:
        """*compliance* (m, 3, 3), m/N; no mount is displaced yet."""
        self._compliance = compliance
        self.displaced = np.zeros((len(compliance), 3))  # m
        self._steps, self._guide = np.zeros_like(self.displaced), np.zeros(GUIDE_SIZE)

    def give(self, packed: Packed, states: Array, planes: Array, ratio: Array) -> float:
        """Move the exit points of *packed* by a step towards equilibrium; return the largest step, m."""
        given = (packed, states, planes, ratio, self._compliance, self.displaced, self._steps, self._guide)
        return float(exit_mounts.give(*given))

    def close(
        self, packed: Packed, kept: Indices, lengths: Array, pose: Array, states: Array, ratio: Array, work: Work
    ) -> int:
        """Displace the exit points of *packed* until lines, mounts and platform are in equilibrium; return a code.

        *kept*: indices of the lines in *packed*.
        """
        displaced = self.displaced[kept]
        given = (packed, lengths, pose, states, ratio[kept], self._compliance[kept], displaced, work)
        code = int(exit_mounts.close(*given))
        self.displaced[kept] = displaced
        return code
