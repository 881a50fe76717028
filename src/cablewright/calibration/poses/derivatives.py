"""Residuals of a calibration with their derivatives, and vectors of unknowns merged with known numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array, Mask


@dataclass(frozen=True, eq=False)
class Derivatives:
    """Weighted residuals and their derivatives: e rows at each of N poses, and g rows without a pose.

    The p unknowns of a pose are its degrees of freedom for straight lines, n or those in a plane; its m lengths for
    elastic ones.
    """

    residual: Array  # (N, e)
    by_pose: Array  # (N, e, p)
    by_unknown: Array  # (N, e, k)
    others: Array  # (g,) residuals without a pose: distances, then linear rows
    others_by_unknown: Array  # (g, k)

    @property
    def whole(self) -> Mask:
        """Mask (N,) of poses whose residuals are defined: not those inside a sheave, or without an equilibrium."""
        return np.asarray(np.isfinite(self.by_pose).all(axis=(1, 2)) & np.isfinite(self.residual).all(axis=1))

    def blank(self, poses: Mask) -> Derivatives:
        """Return the derivatives without those of some *poses* (N,)."""
        residual, by_pose, by_unknown = (
            np.where(poses[(..., *(None,) * (part.ndim - 1))], 0.0, part)
            for part in (self.residual, self.by_pose, self.by_unknown)
        )
        return Derivatives(residual, by_pose, by_unknown, self.others, self.others_by_unknown)


def with_unknowns(known: Array, target: NDArray[np.int64], theta: Array) -> Array:
    """Return the numbers *known* (b, c) with unknowns *theta* (k,) where *target*, (b, ..), has their indices."""
    found = known.copy()
    found[:, : target.shape[1]][target >= 0] = theta[target[target >= 0]]
    return found


def of_free(target: NDArray[np.int64], held: Mask) -> NDArray[np.int64]:
    """Convert indices among all unknowns, *target*, to indices among the free ones; -1 where one is *held* or none."""
    if not len(held):
        return target
    return np.where((target >= 0) & ~held[target], (np.cumsum(~held) - 1)[target], -1)
