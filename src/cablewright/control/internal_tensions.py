"""Tensions of a platform on more lines than freedoms: rates of the lengths that change them and not the pose.

The tensions that balance any load differ by those that balance none: the null space of the transposed Jacobian of the
lengths. A line's tension changes with its length by its stiffness, that of stretch and sag together; changes of tension
in this null space need changes of length that leave the platform where it is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cablewright.arrays import Array
from cablewright.models.statics import Model
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.linearise import tension_changes


class Held(NamedTuple):
    """A pose held at the tensions that the model chooses within its limits."""

    tensions: Array  # (m,) N at the sheaves
    lengths: Array  # (m,) m, unstrained
    compliance: Array  # (m,) m/N: length to be paid out for a newton less, with the platform held


def held_at(model: Model, pose: Array, retraction: float) -> Held | None:
    """Return how *model* holds *pose* (n,) at a *retraction*, m (NaN: the robot's); None where no tensions do."""
    solved = solve_inverse(model, pose[None], retraction=None if np.isnan(retraction) else np.array([retraction]))
    if not np.isfinite(solved.lengths).all():
        return None
    per_length = tension_changes(solved).per_length[0] if solved.ok.all() else np.full(model.m, np.nan)
    stiff = np.minimum(per_length, -_SOFTEST)
    if not np.isfinite(stiff).all():
        return None
    return Held(solved.tensions[0], solved.lengths[0], -1.0 / stiff)


_SOFTEST = 1.0  # N/m


def internal_rates(per_motion: Array, held: Held, tensions: Array, gain: float) -> Array:
    """Return rates (m,), m/s, that bring *tensions* (m,), N, to those *held*, by *gain*, 1/s, without motion.

    *per_motion* (m, n): gradients of the lengths by the platform's motion. Zeros with no more lines than freedoms.
    """
    m, n = per_motion.shape
    if m <= n:
        return np.zeros(m)
    basis, _ = np.linalg.qr(per_motion)
    over = tensions - held.tensions
    over -= basis @ (basis.T @ over)
    return np.asarray(gain * held.compliance * over)
