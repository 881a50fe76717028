"""Search for the next equilibrium, by damped motion, where the previous one no longer exists."""

from __future__ import annotations

from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.kernels.layout import Packed
from cablewright.kernels.plant import dynamics
from cablewright.kernels.plant.dynamics import RATE, TURN, VELOCITY
from cablewright.kernels.plant.machine_step import retry

_STEP: Final = 2e-3  # s
_STEPS: Final = 50_000
_RAMP: Final = 250  # steps in which the lengths change
_DAMPING: Final = 4.0  # 1/s: of drag over mass, and of damping over inertia
_RELAXATION: Final = 0.01  # s, of the lines
_STANDS: Final = 1e-4  # m/s and rad/s


def settle(packed: Packed, body: Array, before: Array, after: Array, pose: Array, states: Array) -> bool:
    """Let the *body* (BODY,) move, damped, from rest at *pose* (6,) until it stands, as lengths change.

    They change from *before* to *after*. *pose* and *states* are updated in place. Returns False where it does not come
    to rest, or falls out of the range in which lines can be computed.
    """
    motion, damped = np.zeros(dynamics.MOTION), _damped(body)
    motion[:3], motion[TURN : TURN + 3] = pose[:3], pose[3:]
    work, swing = dynamics.moving_workspace(packed)
    at = before.copy()
    for k in range(_STEPS):
        to = before + (after - before) * min(1.0, (k + 1) / _RAMP)
        given = (packed, damped, motion, at, to, _STEP, states, work, swing)
        if dynamics.midpoint_step(*given) != 0 and retry(*given) != 0:
            return False
        at = to
        if k > _RAMP and max(np.abs(motion[VELOCITY:TURN]).max(), np.abs(motion[RATE:]).max()) < _STANDS:
            pose[:3], pose[3:] = motion[:3], motion[TURN : TURN + 3]
            return True
    return False


def _damped(body: Array) -> Array:
    """*body* in a medium that takes most of its motion within a second."""
    damped = body.copy()
    damped[dynamics.DRAG] = _DAMPING * damped[dynamics.MASS]
    x, y, z = damped[[dynamics.INERTIA, dynamics.INERTIA + 4, dynamics.INERTIA + 8]].tolist()
    damped[dynamics.SWING_DAMPING], damped[dynamics.YAW_DAMPING] = _DAMPING * max(x, y), _DAMPING * z
    damped[dynamics.RELAXATION] = _RELAXATION
    damped[dynamics.THRUST :] = 0.0
    return damped
