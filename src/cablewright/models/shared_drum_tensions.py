"""Tensions of lines that share winch drums: each follows from that of the line that the winch is named for (host)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.kernels.layout import Packed
from cablewright.kernels.shared_winches.lengths import lengths_at_pulls
from cablewright.kernels.shared_winches.quadratic_program import LINE, OFFSET, OTHER, SENSE
from cablewright.models.fidelity import CableLaw
from cablewright.models.shared_winches import shares
from cablewright.models.statics import Model


@dataclass(frozen=True, eq=False)
class Drums:
    """Relations of tensions on shared drums at N poses: t = base + gain * (tension of the host).

    ``misfit`` (N,): largest length, m, by which rigid cables miss their drums; 0 of others, which adapt.
    """

    table: Array  # (s, 4): one row a line, see `kernels/shared_winches/quadratic_program.py`
    gain: Array  # (N, s)
    base: Array  # (N, s) N
    misfit: Array  # (N,) m
    rigid: bool

    @classmethod
    def at(cls, model: Model, packed: Packed, poses: Array, tensions: Array) -> Drums:
        """Linearise the relations at *tensions* (N, m), N, of lines at *poses* (N, n)."""
        table = shares(model.robot)
        poses, tensions = np.ascontiguousarray(poses), np.ascontiguousarray(tensions)  # the kernel has one signature
        own, host = table[:, LINE].astype(int), table[:, OTHER].astype(int)
        lengths, slopes = np.full_like(tensions, np.nan), np.full_like(tensions, np.nan)
        lengths_at_pulls(packed, poses, np.maximum(tensions, 1e-9 * tensions.max(initial=0.0)), lengths, slopes)
        missed = table[:, OFFSET] + table[:, SENSE] * lengths[:, host] - lengths[:, own]
        if model.fidelity.cable is CableLaw.RIGID:
            none = np.zeros_like(missed)
            return cls(table, none, none, np.nan_to_num(np.abs(missed).max(axis=1), nan=np.inf), True)
        gain = table[:, SENSE] * slopes[:, host] / slopes[:, own]
        base = tensions[:, own] + missed / slopes[:, own] - gain * tensions[:, host]
        return cls(table, gain, base, np.zeros(len(poses)), False)

    def rows(self, row: int, m: int) -> tuple[Array, Array]:
        """Return equations (s, m) of the tensions of row *row*, and their right sides (s,), N; none of rigid cables."""
        if self.rigid:
            return np.zeros((0, m)), np.zeros(0)
        found = np.zeros((len(self.table), m))
        found[np.arange(len(found)), self.table[:, LINE].astype(int)] = 1.0
        found[np.arange(len(found)), self.table[:, OTHER].astype(int)] = -self.gain[row]
        return found, self.base[row]

    def reduced(self, row: int, limits: Array) -> tuple[Array, Array, Array]:
        """Return a matrix (m, k), offsets (m,) and limits (k, 2), N: all tensions of *row* from one of each drum.

        *limits* (m, 2), N, of the lines; a drum has those that all its lines leave: the lower above the upper if none.
        """
        m = len(limits)
        if self.rigid:
            return np.eye(m), np.zeros(m), limits
        matrix, offsets, left = np.eye(m), np.zeros(m), limits.copy()
        for (line, host), gain, base in zip(
            self.table[:, [LINE, OTHER]].astype(int), self.gain[row], self.base[row], strict=True
        ):
            matrix[line, line], matrix[line, host], offsets[line] = 0.0, gain, base
            low, high = np.sort((limits[line] - base) / gain)
            left[host] = max(left[host, 0], low), min(left[host, 1], high)
        hosts = np.setdiff1d(np.arange(m), self.table[:, LINE].astype(int))
        return matrix[:, hosts], offsets, left[hosts]
