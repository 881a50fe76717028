"""Tensions of straight lines beside counterweights: those of the winches are distributed, the others are given."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array, Mask
from cablewright.kernels.layout import OK, Code, Packed
from cablewright.kernels.wrench_feasibility.distribution import structure_rows
from cablewright.models.packed_views import PlatformNumbers
from cablewright.models.statics import Model

Found = tuple[Array, Array, NDArray[np.int64]]  # tensions (N, m), margins (N,) and codes (N,)


@dataclass(frozen=True, eq=False)
class WinchedLines:
    """The lines with a winch at N poses: the wrench of counterweights is part of the load."""

    packed: Packed  # of the lines with a winch
    winched: Mask  # (m,) which lines these are
    given: Array  # (m,) N: tensions that counterweights hold; 0 of a line with a winch
    room: float  # N: smallest distance of a given tension from the limits of its line
    codes: NDArray[np.int64]  # (N,) why a line has no direction at a pose

    @classmethod
    def at(cls, model: Model, packed: Packed, poses: Array) -> WinchedLines:
        """Return the lines of *model*, whose arrays for *poses* (N, n) are *packed*."""
        given = model.lines.counterweight
        winched, codes = given == 0.0, np.zeros(len(poses), np.int64)
        if winched.all():
            return cls(packed, winched, given, np.inf, codes)
        limits = model.lines.tension_limits
        structures, _ = structures_at(packed, poses, codes)
        rows = np.repeat(packed.platform, len(poses), axis=0) if len(packed.platform) == 1 else packed.platform.copy()
        PlatformNumbers(rows).wrench[:, : model.n] += np.nan_to_num(structures) @ given
        room = float(np.minimum(given - limits[:, 0], limits[:, 1] - given)[~winched].min())
        lines = np.ascontiguousarray(packed.lines[:, winched])
        return cls(packed._replace(lines=lines, platform=rows), winched, given, room, codes)

    def completed(self, found: Found) -> Found:
        """Return *found*, of the lines with a winch, with the given tensions and their distance from the limits."""
        if self.winched.all():
            return found
        tensions = np.tile(self.given, (len(found[0]), 1))
        tensions[:, self.winched] = found[0]
        lost = (self.codes != OK) | np.isnan(found[0]).any(axis=1)
        tensions[lost] = np.nan
        margins, codes = self.judged(np.minimum(found[1], self.room), found[2])
        return tensions, margins, codes

    def judged(self, margins: Array, codes: NDArray[np.int64]) -> tuple[Array, NDArray[np.int64]]:
        """Return *margins* and *codes* (N,) where lines without a direction and given tensions out of limits count."""
        outside = (codes == OK) & (self.room < 0.0)
        codes = np.where(self.codes != OK, self.codes, np.where(outside, Code.INFEASIBLE, codes))
        return np.where(self.codes != OK, -np.inf, margins), codes


def structures_at(packed: Packed, poses: Array, codes: NDArray[np.int64] | None = None) -> tuple[Array, Array]:
    """Return structure matrices (N, n, m) and wrenches (N, n) at *poses* (N, n); NaN where *codes* (N,) are not OK."""
    rows, n, m = len(poses), packed.freedoms, packed.lines.shape[1]
    A, w = np.zeros((rows, n, m)), np.zeros((rows, n))
    structure_rows(packed, poses, A, w, np.zeros(rows, np.int64) if codes is None else codes)
    return A, w
