"""Exits that give: the mount of each is displaced by the force of its cable, d = C F, closed with the statics.

F is the pull of the free span, and of the dead span where its winch stands apart (`winch_exit`); a winch that is not
described sits on the same mount, whose own forces cancel out. d is from where the exit was surveyed without load. The
winch stays where it is.
"""

from __future__ import annotations

import numpy as np

from cablewright.arrays import Array
from cablewright.machine.simulated.snapshot import Archive
from cablewright.models.packed_views import LineNumbers, LineStates


class ExitMountState:
    """Displacements of m exits."""

    def __init__(self, compliance: Array) -> None:
        """*compliance* (m, 3, 3), m/N; no mount is displaced yet."""
        self._compliance = compliance
        self.displaced = np.zeros((len(compliance), 3))  # m

    def give(self, lines: Array, states: Array, planes: Array, ratio: Array) -> float:
        """Move the exits of the packed *lines* towards where the forces put them; return by how much at most, m.

        *planes* (m, 4) are those of the lines, *ratio* (m,) the tension of each dead span over that of its free span.
        One step of Newton's method for each line between a fixed winch and a fixed platform, whose tension falls as the
        exit gives. Where the platform gives too, it takes several, and always arrives (`docs/machine.md`).
        """
        numbers, state = LineNumbers(lines), LineStates(states)
        free = _along(state.free_angle, planes)
        dead = _along(state.dead_angle, planes) * numbers.has_dead_span[:, None]
        tension = state.tension * (numbers.pulls > 0.0)
        force = tension[:, None] * (free + ratio[:, None] * dead)
        missing = np.einsum("ijk,ik->ij", self._compliance, force) - self.displaced
        along = free + dead
        soft = np.einsum("ijk,ik->ij", self._compliance, along)
        stretch = numbers.free_compliance * state.free_length + numbers.dead_compliance * state.dead_length  # m/N
        share = (along * missing).sum(axis=1) / (stretch + (along * soft).sum(axis=1))
        step = missing - soft * share[:, None]
        self._move(numbers, planes, step)
        return float(np.abs(step).max())

    def _move(self, numbers: LineNumbers, planes: Array, step: Array) -> None:
        """Move exits by *step* (m, 3), m, and their winches by as much the other way, since they are from the exits."""
        self.displaced += step
        numbers.exit_point += step
        numbers.winch_height = numbers.winch_height - numbers.has_dead_span * step[:, 2]
        aside = (step[:, :2] * planes[:, :2]).sum(axis=1)
        numbers.winch_distance = numbers.winch_distance - (numbers.unknowns > 4.0) * aside

    def archive_state(self, archive: Archive, lines: Array) -> None:
        """Save or load the displacements, and with them the packed *lines*."""
        archive.array("displaced", self.displaced)
        archive.array("lines", lines)


def _along(angles: Array, planes: Array) -> Array:
    """Unit vectors (m, 3), world, in the lines' planes at *angles* (m,), rad, above the horizontal."""
    flat = np.cos(angles)
    return np.column_stack([flat * planes[:, 0], flat * planes[:, 1], np.sin(angles)])
