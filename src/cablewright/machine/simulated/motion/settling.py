"""Where a body comes to rest when the equilibrium it was in is no more: by its own motion, well damped."""

from __future__ import annotations

from typing import Final

import numpy as np

from cablewright.arrays import Array
from cablewright.kernels.layout import Packed
from cablewright.kernels.plant import dynamics
from cablewright.kernels.plant.dynamics import RATE, TURN, VELOCITY

_STEP: Final = 0.01  # s
_STEPS: Final = 20_000
_EVERY: Final = 50  # steps
_DAMPING: Final = 4.0  # 1/s: of drag over mass, and of damping over inertia
_RELAXATION: Final = 0.01  # s, of the lines
_STANDS: Final = 1e-4  # m/s and rad/s


def settle(packed: Packed, body: Array, lengths: Array, pose: Array, states: Array) -> bool:
    """Let the *body* (BODY,) move from rest at *pose* (6,), with lines of constant *lengths* (m,), until it stands.

    *pose* and *states* are updated in place. Returns False where it does not come to rest, or falls out of what lines
    can be computed for.
    """
    damped = body.copy()
    damped[dynamics.DRAG] = _DAMPING * damped[dynamics.MASS]
    inertia = damped[dynamics.INERTIA : dynamics.INERTIA + 9].reshape(3, 3)
    damped[dynamics.SWING_DAMPING] = damped[dynamics.YAW_DAMPING] = _DAMPING * np.trace(inertia) / 3.0
    damped[dynamics.RELAXATION] = _RELAXATION
    damped[dynamics.THRUST :] = 0.0
    motion = np.zeros(dynamics.MOTION)
    motion[:3], motion[TURN : TURN + 3] = pose[:3], pose[3:]
    work, swing = dynamics.moving_workspace(6, len(lengths))
    for k in range(_STEPS):
        given = (packed, damped, motion, lengths, lengths, _STEP, states, work, swing)
        if dynamics.midpoint_step(*given) != 0:
            return False
        if (
            k % _EVERY == _EVERY - 1
            and np.abs(motion[[*range(VELOCITY, VELOCITY + 3), *range(RATE, RATE + 3)]]).max() < _STANDS
        ):
            pose[:3], pose[3:] = motion[:3], motion[TURN : TURN + 3]
            return True
    return False
