"""Forces by shares, angles by forces, and readings that are given, for tests of lines that hang."""

from __future__ import annotations

import numpy as np

from cablewright.estimation.kalman.sag import Balanced, Sag
from cablewright.estimation.slackness import SlacknessState
from cablewright.foundation.arrays import Array
from cablewright.kernels.filtering import hanging, line_angles

_ROWS = {"differences": line_angles.DIFFERENCE, "excess": line_angles.EXCESS, "variances": line_angles.VARIANCE}


def forces_at(may_be: Balanced, shares: Array) -> Array:
    """Forces (k, m), N, by *shares* (k,) of their range."""
    return np.asarray(may_be.forces[0] + shares[:, None] * may_be.forces[1])


def unsure_at(may_be: Balanced, shares: Array) -> Array:
    """How forces change with the q numbers, (k, m, q), N, by *shares* (k,)."""
    return np.asarray(may_be.unsure[0] + shares[:, None, None] * may_be.unsure[1])


def differences(sag: Sag, forces: Array) -> Array:
    """Angles near the platform less those of straight lines (..., m), rad, by horizontal *forces* (..., m), N."""
    steep = sag.laws[hanging.SLOPE] + sag.laws[hanging.RISING] / forces
    return np.asarray(np.arctan(steep) - sag.laws[hanging.ANGLE])


def shown(state: SlacknessState, **values: Array) -> SlacknessState:
    """*state* with other *values* (m,)."""
    rows = state.rows.copy()
    for name, each in values.items():
        rows[_ROWS[name]] = each
    return SlacknessState(rows, state.time)
